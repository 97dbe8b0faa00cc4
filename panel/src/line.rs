//! The panel's end of the bus. It does beside every wait of the master what may not wait: it produces the heartbeat that guards the drive,
//! keeps an eye on the dead man's switch, writes down what passes, and breaks off whatever the master is at when somebody wants to stop.

use std::sync::Arc;

use canopen::{BitRate, Duration, Frame, Instant};
use master::bus::timing::{INTERMISSION_BITS, frame_bits};
use master::{Inbox, Line, LineDown};

use crate::desk::{Counts, Desk};

/// From a heartbeat of the panel to the next.
pub const HEARTBEAT: Duration = Duration::from_ticks(100_000);

/// A jog ends when no beat has come for this long: with the rest of the way, 200 ms at most.
pub const DEAD_MAN: Duration = Duration::from_ticks(150_000);

/// The longest the panel does not look up.
const SLICE: Duration = Duration::from_ticks(5_000);

/// Frames that may wait to be told.
const LOG: usize = 4_096;

/// What a master is told when it is broken off.
const INTERRUPTED: &str = "interrupted by a stop";

/// A frame that was on the bus, and whether the panel has sent it.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    /// When.
    pub at: Instant,
    /// What.
    pub frame: Frame,
    /// Whether it is the panel's.
    pub own: bool,
}

/// What may not wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Urgent {
    /// A person wants the drive to stop.
    pub stop: bool,
    /// The jog is over.
    pub release: bool,
}

impl Urgent {
    /// Whether there is anything.
    pub fn any(self) -> bool {
        self.stop || self.release
    }
}

/// The bus as the panel is on it.
#[derive(Debug)]
pub struct PanelLine<L> {
    inner: L,
    desk: Arc<Desk>,
    seen: Counts,
    urgent: Urgent,
    /// When the last beat came, while a drive is jogged.
    jogged: Option<Instant>,
    /// What is urgent may break off the master.
    interruptible: bool,
    heartbeat: Option<(u8, Instant)>,
    passed: Vec<Passed>,
    dropped: u64,
    bits: u64,
    frames: u64,
    down: Option<LineDown>,
}

impl<L: Line> PanelLine<L> {
    /// On this bus.
    pub fn new(inner: L, desk: Arc<Desk>) -> Self {
        Self {
            inner,
            seen: desk.counts(),
            desk,
            urgent: Urgent::default(),
            jogged: None,
            interruptible: true,
            heartbeat: None,
            passed: Vec::new(),
            dropped: 0,
            bits: 0,
            frames: 0,
            down: None,
        }
    }

    /// The bus itself.
    pub fn inner_mut(&mut self) -> &mut L {
        &mut self.inner
    }

    /// Begins or ends the heartbeat of this node.
    pub fn set_heartbeat(&mut self, node: Option<u8>) {
        let now = self.inner.now();
        self.heartbeat = node.map(|node| (node, now));
    }

    /// A jog begins, or is over.
    pub fn set_jogged(&mut self, jogged: bool) {
        self.jogged = jogged.then(|| self.inner.now());
    }

    /// What is urgent now; it is in the hands of the caller then.
    pub fn take_urgent(&mut self) -> Urgent {
        self.look_up();
        std::mem::take(&mut self.urgent)
    }

    /// What is urgent, and stays so.
    pub fn urgent(&self) -> Urgent {
        self.urgent
    }

    /// Whether what is urgent may break off the master. A stop is not broken off by another one.
    pub fn set_interruptible(&mut self, interruptible: bool) {
        self.interruptible = interruptible;
    }

    /// Whether the master was broken off, or the bus is down.
    pub fn is_interruption(down: &LineDown) -> bool {
        down.0 == INTERRUPTED
    }

    /// Why the bus cannot be used any more.
    pub fn down(&self) -> Option<&LineDown> {
        self.down.as_ref()
    }

    /// What has passed since the last call, and how many frames more.
    pub fn take_passed(&mut self) -> (Vec<Passed>, u64) {
        (
            std::mem::take(&mut self.passed),
            std::mem::take(&mut self.dropped),
        )
    }

    /// How many frames and bits have passed so far.
    pub fn passed_so_far(&self) -> (u64, u64) {
        (self.frames, self.bits)
    }

    fn note(&mut self, at: Instant, frame: Frame, own: bool) {
        self.frames += 1;
        self.bits += u64::from(frame_bits(&frame) + INTERMISSION_BITS);
        if self.passed.len() < LOG {
            self.passed.push(Passed { at, frame, own });
        } else {
            self.dropped += 1;
        }
    }

    /// What has come into the inbox behind the frames that were there before.
    fn note_heard(&mut self, before: usize) {
        let new: Vec<_> = self.inner.inbox().behind(before).collect();
        for (at, frame) in new {
            self.note(at, frame, false);
        }
    }

    fn look_up(&mut self) {
        let now = self.inner.now();
        let counts = self.desk.counts();
        self.urgent.stop |= counts.stops != self.seen.stops;
        self.urgent.release |= counts.releases != self.seen.releases && self.jogged.is_some();
        if counts.beats != self.seen.beats && self.jogged.is_some() {
            self.jogged = Some(now);
        }
        self.seen = counts;
        let is_late = |beat| now >= beat + DEAD_MAN;
        self.urgent.release |= self.jogged.is_some_and(is_late);
        if let Some((node, due)) = self.heartbeat.filter(|(_, due)| now >= *due) {
            // One that comes late does not make the next ones come faster.
            self.heartbeat = Some((node, (due + HEARTBEAT).max(now)));
            self.send(Frame::data_frame(0x700 + u16::from(node), &[0x05]));
        }
    }
}

impl<L: Line> Line for PanelLine<L> {
    fn now(&self) -> Instant {
        self.inner.now()
    }

    fn send(&mut self, frame: Frame) {
        let now = self.inner.now();
        self.note(now, frame, true);
        self.inner.send(frame);
    }

    fn inbox(&mut self) -> &mut Inbox {
        self.inner.inbox()
    }

    fn step(&mut self, end: Instant) -> Result<bool, LineDown> {
        self.look_up();
        if self.urgent.any() && self.interruptible {
            return Err(LineDown(INTERRUPTED.to_owned()));
        }
        let now = self.inner.now();
        let slice = end.min(now + SLICE);
        let before = self.inner.inbox().waiting();
        let happened = self.inner.step(slice);
        self.note_heard(before);
        match happened {
            // The end of a slice is not the end of the wait.
            Ok(happened) => Ok(happened || slice < end),
            Err(down) => {
                self.down = Some(down.clone());
                Err(down)
            }
        }
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) -> Result<bool, LineDown> {
        self.inner.set_bit_rate(bit_rate)
    }
}

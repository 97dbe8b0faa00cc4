//! The transmit queue: what waits for the bus, lowest identifier first.
//!
//! Each communication object has its own place. Process data is replaced by newer data (in the transmit PDOs); emergency
//! messages and LSS answers keep their order, as do the answers of each SDO server, which wait there; of heartbeats there is one. The boot-up message goes
//! before everything, because it must be the first frame of all.

use heapless::Deque;

use super::objects::Streams;
use super::{NO_COB_ID, Node};
use crate::application::Application;
use crate::cia301::nmt::NmtState;
use crate::cia305;
use crate::od::Dictionary;
use crate::outbox::Pending;
use crate::time::Instant;
use crate::wire::{Frame, cob_id};

/// Most LSS answers that wait. A master has one request in flight.
const MOST_LSS_ANSWERS: usize = 4;

/// What waits, beside emergency messages and PDOs, which wait with their producers.
#[derive(Debug)]
pub(super) struct TransmitQueue {
    /// The bits of [`waiting`], but for emergency messages and PDOs.
    waiting: u16,
    lss: Deque<[u8; 8], MOST_LSS_ANSWERS>,
    /// The counter of the SYNC that waits.
    sync: Option<u8>,
    /// The TIME that waits.
    time: [u8; 6],
    overflows: u32,
}

/// What may wait: a bit for each. Of equal identifiers the lowest bit goes first.
mod waiting {
    pub const BOOT_UP: u16 = 1 << 0;
    pub const EMERGENCY: u16 = 1 << 1;
    pub const PDO: u16 = 1 << 2;
    pub const SYNC: u16 = 1 << 3;
    pub const TIME: u16 = 1 << 4;
    pub const ANSWER: u16 = 1 << 5;
    pub const HEARTBEAT: u16 = 1 << 6;
    pub const GUARDING: u16 = 1 << 7;
    pub const LSS: u16 = 1 << 8;
}

impl TransmitQueue {
    pub(super) const fn new() -> Self {
        Self {
            waiting: 0,
            lss: Deque::new(),
            sync: None,
            time: [0; 6],
            overflows: 0,
        }
    }

    /// Drops all but LSS answers, which belong to no NMT state.
    pub(super) fn clear(&mut self) {
        self.waiting &= waiting::LSS;
    }

    /// Whether an SDO server has something to send; it waits there.
    #[inline]
    pub(super) fn set_answers(&mut self, are_waiting: bool) {
        if are_waiting {
            self.waiting |= waiting::ANSWER;
        } else {
            self.waiting &= !waiting::ANSWER;
        }
    }

    pub(super) fn push_boot_up(&mut self) {
        self.waiting |= waiting::BOOT_UP;
    }

    pub(super) fn push_heartbeat(&mut self) {
        self.waiting |= waiting::HEARTBEAT;
    }

    /// A SYNC; one that still waits is left out.
    pub(super) fn push_sync(&mut self, counter: Option<u8>) {
        self.waiting |= waiting::SYNC;
        self.sync = counter;
    }

    /// A TIME; one that still waits is replaced.
    pub(super) fn push_time(&mut self, time: [u8; 6]) {
        self.waiting |= waiting::TIME;
        self.time = time;
    }

    /// The device produces no SYNC any more.
    pub(super) fn drop_sync(&mut self) {
        self.waiting &= !waiting::SYNC;
    }

    /// The device produces no TIME any more.
    pub(super) fn drop_time(&mut self) {
        self.waiting &= !waiting::TIME;
    }

    /// An answer to the guarding master, one for all questions that wait.
    pub(super) fn push_guarding(&mut self) {
        self.waiting |= waiting::GUARDING;
    }

    /// An SDO request is lost, as its answer has no room.
    pub(super) fn count_lost_request(&mut self) {
        self.overflows = self.overflows.saturating_add(1);
    }

    /// Adds an LSS answer; one that finds no room is lost, and counts.
    pub(super) fn push_lss(&mut self, answer: [u8; 8]) {
        self.waiting |= waiting::LSS;
        if self.lss.push_back(answer).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// SDO requests and LSS answers that were lost because too many answers waited.
    pub(super) fn overflows(&self) -> u32 {
        self.overflows
    }

    /// The oldest LSS answer, removed. Out of the way of what is sent often.
    #[cold]
    #[inline(never)]
    fn take_lss(&mut self) -> Option<Frame> {
        let answer = self.lss.pop_front();
        if self.lss.is_empty() {
            self.waiting &= !waiting::LSS;
        }
        answer.map(|answer| Frame::full(cia305::RESPONSE_COB_ID, answer))
    }
}

impl<D: Dictionary> Node<D> {
    /// The next frame to send, lowest identifier first; `None` when there is nothing.
    ///
    /// The segments of a block upload come from here one by one, so the application is asked for the next piece of an object
    /// that it streams. Call it when the CAN controller can take a frame, and [`Node::poll`] after it: the time for the answer to a
    /// sub-block begins there. A frame that the controller gives back (it was not sent, and
    /// one of higher priority shall go first) cannot be put back here.
    #[inline]
    pub fn transmit<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let may_wait = self.queue.waiting != 0
            || self.services.tpdos.is_pending()
            || self.services.emergency.is_pending();
        if may_wait && !self.is_mute {
            self.transmit_one(application)
        } else {
            None
        }
    }

    /// Drops synchronous PDOs whose SYNC window (1007h) is over at `now`, so that none leaves late: to be called before
    /// [`Node::transmit`] where [`Node::poll`] was not called for this moment, as frames that arrived before it still wait to be given.
    /// An event of transmission type 0 is kept for the next SYNC.
    #[inline]
    pub fn drop_late(&mut self, now: Instant) {
        if self.services.sync.is_window_over(now) {
            self.services.tpdos.window_passed();
        }
    }

    /// What [`Node::transmit`] would give now: a controller that has no room for it is better not asked to take it, as process data
    /// is replaced by newer data here. [`Outbox`](crate::Outbox) sees to that.
    pub fn pending(&self) -> Option<Pending> {
        let waiting = self.waiting();
        if self.is_mute || waiting == 0 {
            return None;
        }
        let first = self.first(waiting);
        Some(Pending {
            cob_id: self.identifier(first),
            is_process_data: match first {
                waiting::PDO => self.services.tpdos.is_pending_replaced(),
                _ => first & (waiting::SYNC | waiting::TIME) != 0,
            },
        })
    }

    /// The SYNC of this device that [`Node::pending`] answers: what its controller holds must not be overtaken.
    pub fn follows(&self) -> Option<u16> {
        let (sync, tpdos) = (&self.services.sync, &self.services.tpdos);
        let follows = sync.is_producer()
            && tpdos.is_pending_synchronous()
            && self.first(self.waiting()) == waiting::PDO;
        follows.then_some(sync.cob_id())
    }

    /// The bits of [`waiting`] of what may leave now.
    #[inline]
    fn waiting(&self) -> u16 {
        let mut waiting = self.queue.waiting;
        if self.services.tpdos.is_pending() {
            waiting |= waiting::PDO;
        }
        if self.services.emergency.is_pending() {
            waiting |= waiting::EMERGENCY;
        }
        waiting
    }

    /// The one of these bits that goes first: the boot-up message, then the lowest identifier.
    #[inline]
    fn first(&self, waiting: u16) -> u16 {
        // Mostly one thing waits.
        if waiting & waiting.wrapping_sub(1) == 0 {
            waiting
        } else {
            self.lowest(waiting)
        }
    }

    #[inline(never)]
    fn lowest(&self, waiting: u16) -> u16 {
        let (mut rest, mut first, mut lowest) = (waiting, waiting::BOOT_UP, NO_COB_ID);
        if waiting & waiting::BOOT_UP != 0 {
            return first;
        }
        while rest != 0 {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            let cob_id = self.identifier(bit);
            if cob_id < lowest {
                (first, lowest) = (bit, cob_id);
            }
        }
        first
    }

    /// The identifier of what waits.
    #[inline(never)]
    fn identifier(&self, waiting: u16) -> u16 {
        let cob_id = match waiting {
            waiting::EMERGENCY => self.services.emergency.pending(),
            waiting::PDO => self.services.tpdos.pending(),
            waiting::SYNC => Some(self.services.sync.cob_id()),
            waiting::TIME => Some(self.services.time.cob_id()),
            waiting::ANSWER => self.sdo.pending(),
            waiting::LSS => Some(cia305::RESPONSE_COB_ID),
            _ => Some(cob_id::error_control(self.node_id)),
        };
        cob_id.unwrap_or(NO_COB_ID)
    }

    /// The frame of what waits. PDOs and answers leave by a short way.
    #[inline(never)]
    fn transmit_one<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let waiting = self.waiting();
        // What is sent often, alone.
        if waiting == waiting::PDO {
            return self.take_pdo();
        }
        if waiting == waiting::ANSWER {
            return self.take_answer(application);
        }
        let first = self.first(waiting);
        match first {
            waiting::PDO => self.take_pdo(),
            waiting::ANSWER => self.take_answer(application),
            waiting::EMERGENCY => {
                self.services.timers_changed |= self.services.emergency.needs_time();
                self.services.emergency.take()
            }
            waiting::LSS => self.queue.take_lss(),
            _ => Some(self.take_seldom(first)),
        }
    }

    /// The PDO to send first; its inhibit time begins with the next [`Node::poll`].
    #[inline]
    fn take_pdo(&mut self) -> Option<Frame> {
        let frame = self.services.tpdos.take();
        self.services.values_changed |= self.services.tpdos.needs_time();
        frame
    }

    /// The frame of what has one place, now empty.
    #[inline(never)]
    fn take_seldom(&mut self, what: u16) -> Frame {
        self.queue.waiting &= !what;
        let cob_id = self.identifier(what);
        match what {
            waiting::SYNC => {
                self.services.tpdos.follow_sync(false);
                match self.queue.sync {
                    Some(counter) => Frame::data_frame(cob_id, &[counter]),
                    None => Frame::data_frame(cob_id, &[]),
                }
            }
            waiting::TIME => Frame::data_frame(cob_id, &self.queue.time),
            waiting::BOOT_UP => Frame::data_frame(cob_id, &[NmtState::Initialisation as u8]),
            waiting::GUARDING => {
                let state = self.state as u8 | self.services.guarding.next_toggle();
                Frame::data_frame(cob_id, &[state])
            }
            _ => Frame::data_frame(cob_id, &[self.state as u8]),
        }
    }

    /// What an SDO server has to send. Out of line, so that process data leaves by a short way.
    #[inline(never)]
    fn take_answer<A: Application<D>>(&mut self, application: &mut A) -> Option<Frame> {
        let mut streams = Streams {
            dictionary: &self.dictionary,
            application,
        };
        let frame = self.sdo.transmit(&mut streams);
        if self.sdo.pending().is_none() {
            self.queue.set_answers(false);
        }
        if self.sdo.needs_time() {
            self.services.timers_changed = true;
        }
        frame
    }
}

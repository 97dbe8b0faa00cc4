//! The end where pulses come out.

use core::fmt;
use core::sync::atomic::Ordering;

use super::{Shared, ticks};
use crate::{Direction, DriverTiming, Record};

/// A timer that does one thing at one time, and then interrupts.
pub trait StepTimer {
    /// Whether falling edges take an interrupt of their own. False where nobody looks at the step signal.
    const FALLING_EDGES: bool;

    /// The counter in ticks of the step clock; wraps after 32 bits. It runs on, but may pause within
    /// [`StepTimer::stop`]. Any task may read it.
    fn now() -> u32;

    /// At `time` does this to the step signal and raises the interrupt. A time that has passed (less than half a turn of the
    /// counter ago) means at once. Replaces what was scheduled before. Returns when the edge comes: `time`, or a reading of
    /// the counter at or after an edge that was made at once.
    fn schedule(&mut self, time: u32, edge: Edge) -> u32;

    /// Nothing is scheduled any more; the step signal falls. Returns whether what was scheduled last had happened before.
    fn stop(&mut self) -> bool;

    /// Sets the direction signal.
    fn set_direction(&mut self, direction: Direction);

    /// Raises the interrupt now.
    fn interrupt();
}

/// What happens to the step signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// A pulse begins.
    Rise,
    /// A pulse ends.
    Fall,
    /// Nothing.
    None,
}

/// Plays records, a period at a time. It belongs to the step interrupt.
pub struct Player<'a, T> {
    timer: T,
    shared: &'a Shared,
    timing: DriverTiming,
    /// The record being played, and how many of its periods have not been scheduled.
    record: Option<Record>,
    left: u16,
    /// The level of the direction signal; `None` until a record has set it.
    direction: Option<Direction>,
    /// When the edge that was scheduled comes, and its interrupt with it.
    due: u32,
    awaited: Awaited,
}

impl<T> fmt::Debug for Player<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Player")
            .field("awaited", &self.awaited)
            .finish_non_exhaustive()
    }
}

/// Which interrupt is awaited.
#[derive(Clone, Copy, Debug)]
enum Awaited {
    /// None: there was nothing to play.
    Nothing,
    /// The start of the next period, if there is one; the period before ends with it.
    Start { next: Option<Record> },
    /// The falling edge in a period that ends at `end`.
    Fall { end: u32 },
}

impl<'a, T: StepTimer> Player<'a, T> {
    pub(super) fn new(shared: &'a Shared, timer: T, timing: DriverTiming) -> Self {
        Self {
            timer,
            shared,
            timing: timing.checked(),
            record: None,
            left: 0,
            direction: None,
            due: 0,
            awaited: Awaited::Nothing,
        }
    }

    /// The timer.
    pub fn timer(&self) -> &T {
        &self.timer
    }

    /// The position in steps (modulo 2³²): every pulse that has begun, forward less reverse.
    pub fn position(&self) -> i32 {
        self.shared.position.load(Ordering::Relaxed)
    }

    /// The step interrupt.
    pub fn on_interrupt(&mut self) {
        if self.shared.drop.load(Ordering::Acquire) {
            self.drop_all();
            return;
        }
        match self.awaited {
            Awaited::Nothing => self.start_anew(),
            _ if !has_come(T::now(), self.due) => {}
            Awaited::Start { next: Some(period) } => self.begin(period),
            Awaited::Start { next: None } => self.go_on(),
            // The edge may have come late.
            Awaited::Fall { end } => {
                self.schedule_next(end, self.due.wrapping_add(self.timing.pulse_low));
            }
        }
    }

    /// The timeline begins now, if there is anything to play.
    fn start_anew(&mut self) {
        if let Some(period) = self.next_period() {
            let now = T::now();
            let played = self.shared.played.load(Ordering::Relaxed);
            self.shared
                .origin
                .store(now.wrapping_sub(played), Ordering::Relaxed);
            self.schedule_start(now, now, Some(period));
            self.shared.running.store(true, Ordering::Release);
        }
    }

    /// The last period known has ended. If more has come meanwhile, that begins now.
    fn go_on(&mut self) {
        let end = self.due;
        if let Some(period) = self.next_period() {
            self.schedule_start(end, T::now(), Some(period));
        } else {
            self.timer.stop();
            self.rest(self.played_at(end));
        }
    }

    /// A period has begun, its pulse has risen.
    fn begin(&mut self, period: Record) {
        let start = self.due;
        let end = start.wrapping_add(period.period);
        if period.width == 0 {
            let ready = self.turn(period.direction).unwrap_or(start);
            self.schedule_next(end, ready);
            return;
        }
        self.count(period);
        if T::FALLING_EDGES {
            let fall = start.wrapping_add(u32::from(period.width));
            self.due = self.timer.schedule(fall, Edge::Fall);
            self.awaited = Awaited::Fall { end };
        } else {
            self.schedule_next(end, start);
        }
    }

    /// Sets the direction. If that changes it: the earliest time for the next pulse.
    fn turn(&mut self, direction: Direction) -> Option<u32> {
        if self.direction == Some(direction) {
            return None;
        }
        self.direction = Some(direction);
        self.timer.set_direction(direction);
        // The interrupt may have come late: what counts is when the driver sees it.
        Some(T::now().wrapping_add(self.timing.direction_setup))
    }

    /// Nothing more happens in this period: the next one comes at its `end`, but not before the driver is `ready`.
    fn schedule_next(&mut self, end: u32, ready: u32) {
        let next = self.next_period();
        let time = later(end, later(ready, T::now()));
        self.schedule_start(end, time, next);
    }

    /// The next period begins at `time`, where `planned` was intended. What is late moves the rest of the train back.
    fn schedule_start(&mut self, planned: u32, time: u32, next: Option<Record>) {
        let edge = match next {
            Some(period) if period.width > 0 => Edge::Rise,
            _ => Edge::None,
        };
        self.due = self.timer.schedule(time, edge);
        self.awaited = Awaited::Start { next };
        if self.due != planned {
            // Only the step interrupt writes, so that load and store are enough.
            let origin = self.shared.origin.load(Ordering::Relaxed);
            let late = self.due.wrapping_sub(planned);
            self.shared
                .origin
                .store(origin.wrapping_add(late), Ordering::Relaxed);
        }
    }

    /// One period of the record being played, or of the next.
    fn next_period(&mut self) -> Option<Record> {
        while self.left == 0 {
            let record = self.shared.records.take()?;
            self.left = record.repeat;
            self.record = Some(record);
        }
        self.left = self.left.saturating_sub(1);
        self.record
    }

    /// Counts the pulse with which a period begins.
    fn count(&mut self, period: Record) {
        let position = self.shared.position.load(Ordering::Relaxed);
        let position = position.wrapping_add(period.direction.sign());
        self.shared.position.store(position, Ordering::Relaxed);
    }

    /// Power is off: what waits is gone. For the time under way it counts as played, for the position it does not.
    fn drop_all(&mut self) {
        // First of all, so that no pulse leaves while this counts those that have left.
        let has_happened = self.timer.stop();
        let mut played = match self.awaited {
            Awaited::Nothing => self.shared.played.load(Ordering::Relaxed),
            Awaited::Start { next: None } => self.played_at(self.due),
            Awaited::Start { next: Some(period) } => {
                if period.width > 0 && has_happened {
                    // The timer was quicker: this pulse has left.
                    self.count(period);
                }
                self.played_at(self.due).wrapping_add(period.period)
            }
            Awaited::Fall { end } => self.played_at(end),
        };
        if let Some(record) = self.record.take() {
            let left = record.period.wrapping_mul(u32::from(self.left));
            played = played.wrapping_add(left);
        }
        self.left = 0;
        while let Some(record) = self.shared.records.take() {
            played = played.wrapping_add(ticks(&record));
        }
        self.rest(played);
        self.shared.drop.store(false, Ordering::Release);
    }

    /// Nothing is being played any more; so many ticks have been.
    fn rest(&mut self, played: u32) {
        self.awaited = Awaited::Nothing;
        self.shared.played.store(played, Ordering::Relaxed);
        self.shared.running.store(false, Ordering::Release);
    }

    /// Ticks that have been played when the counter comes to a time.
    fn played_at(&self, time: u32) -> u32 {
        time.wrapping_sub(self.shared.origin.load(Ordering::Relaxed))
    }
}

/// Whether the counter has come to a time, which lies less than half a turn away.
fn has_come(now: u32, time: u32) -> bool {
    now.wrapping_sub(time) <= u32::MAX / 2
}

/// The later of two times, less than half a turn apart.
fn later(one: u32, other: u32) -> u32 {
    if has_come(one, other) { one } else { other }
}

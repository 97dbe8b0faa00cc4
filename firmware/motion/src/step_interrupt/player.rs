//! The side of the step interrupt: it takes records out of the queue and makes the pulses.

use core::fmt;
use core::sync::atomic::Ordering;

use super::ring::CAPACITY;
use super::{Shared, ticks};
use crate::iterations::Iterations;
use crate::low;
use crate::{Direction, DriverTiming, Record};

/// Records that the interrupt may find in a row: it is above who puts them in.
const MAX_TAKEN: u32 = low::word(CAPACITY);

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
    /// The record being played, what each of its pulses adds to the position, and how many of its periods have not been
    /// scheduled.
    record: Record,
    sign: i32,
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
    /// The pulse of a period of the record, with which the period begins and the one before ends.
    Rise,
    /// The start of a silent period of the record.
    Silence,
    /// The end of the last period known.
    End,
    /// The falling edge in a period that ends at `end`.
    Fall { end: u32 },
}

impl<'a, T: StepTimer> Player<'a, T> {
    pub(super) fn new(shared: &'a Shared, timer: T, timing: DriverTiming) -> Self {
        Self {
            timer,
            shared,
            timing: timing.checked(),
            record: Record::NONE,
            sign: 0,
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

    /// The step interrupt. Within a run it is short; all else is in other functions.
    #[inline]
    pub fn on_interrupt(&mut self) {
        if self.shared.drop.load(Ordering::Relaxed) {
            self.drop_all();
            return;
        }
        let now = T::now();
        let start = self.due;
        match self.awaited {
            Awaited::Rise if is_reached(now, start) => {
                self.count();
                let end = start.wrapping_add(self.record.period);
                if T::FALLING_EDGES {
                    let fall = start.wrapping_add(u32::from(self.record.width));
                    self.due = self.timer.schedule(fall, Edge::Fall);
                    self.awaited = Awaited::Fall { end };
                } else if let Some(left) = self.left.checked_sub(1) {
                    self.left = left;
                    self.schedule_rise(end, later(end, now));
                } else {
                    self.schedule_next(end, now);
                }
            }
            Awaited::Fall { end } if is_reached(now, start) => {
                // The edge may have come late.
                let ready = later(start.wrapping_add(self.timing.pulse_low), now);
                if let Some(left) = self.left.checked_sub(1) {
                    self.left = left;
                    self.awaited = Awaited::Rise;
                    self.schedule_rise(end, later(end, ready));
                } else {
                    self.schedule_next(end, ready);
                }
            }
            _ => self.on_other(now),
        }
    }

    /// An interrupt that is not within a run of equal periods.
    #[inline(never)]
    fn on_other(&mut self, now: u32) {
        match self.awaited {
            Awaited::Nothing => self.start_anew(),
            Awaited::Silence if is_reached(now, self.due) => self.begin_silence(),
            Awaited::End if is_reached(now, self.due) => self.go_on(),
            _ => {}
        }
    }

    /// The timeline begins now, if there is anything to play.
    fn start_anew(&mut self) {
        if self.next_period() {
            let now = T::now();
            let played = self.shared.played.load(Ordering::Relaxed);
            self.shared
                .origin
                .store(now.wrapping_sub(played), Ordering::Relaxed);
            self.schedule_period(now, now);
            self.shared.running.store(true, Ordering::Release);
        }
    }

    /// The last period known has ended. If more has come meanwhile, that begins now.
    fn go_on(&mut self) {
        let end = self.due;
        if self.next_period() {
            self.schedule_period(end, T::now());
        } else {
            self.timer.stop();
            self.stop_playing(self.played_at(end));
        }
    }

    /// A silent period has begun.
    fn begin_silence(&mut self) {
        let start = self.due;
        let end = start.wrapping_add(self.record.period);
        let ready = self.set_direction(self.record.direction).unwrap_or(start);
        self.schedule_next(end, later(ready, T::now()));
    }

    /// Sets the direction. If that changes it: the earliest time for the next pulse.
    fn set_direction(&mut self, direction: Direction) -> Option<u32> {
        if self.direction == Some(direction) {
            return None;
        }
        self.direction = Some(direction);
        self.timer.set_direction(direction);
        // The interrupt may have come late: what counts is when the driver sees it.
        Some(T::now().wrapping_add(self.timing.direction_setup))
    }

    /// Nothing more happens in this period: the next one comes at its `end`, but not before the driver is `ready`.
    #[inline(never)]
    fn schedule_next(&mut self, end: u32, ready: u32) {
        let time = later(end, ready);
        if self.next_period() {
            self.schedule_period(end, time);
        } else {
            self.awaited = Awaited::End;
            self.schedule(end, time, Edge::None);
        }
    }

    /// The next period, which is one of the record, begins at `time`, where `planned` was intended.
    fn schedule_period(&mut self, planned: u32, time: u32) {
        let (awaited, edge) = if self.record.width > 0 {
            (Awaited::Rise, Edge::Rise)
        } else {
            (Awaited::Silence, Edge::None)
        };
        self.awaited = awaited;
        self.schedule(planned, time, edge);
    }

    /// Another pulse of the record.
    #[inline(always)]
    fn schedule_rise(&mut self, planned: u32, time: u32) {
        self.schedule(planned, time, Edge::Rise);
    }

    /// Something happens at `time`, where `planned` was intended.
    #[inline(always)]
    fn schedule(&mut self, planned: u32, time: u32, edge: Edge) {
        self.due = self.timer.schedule(time, edge);
        if self.due != planned {
            self.move_train_back(planned);
        }
    }

    /// What is late moves what follows of the train back.
    #[cold]
    #[inline(never)]
    fn move_train_back(&mut self, planned: u32) {
        // Only the step interrupt writes, so that load and store are enough.
        let origin = self.shared.origin.load(Ordering::Relaxed);
        let late = self.due.wrapping_sub(planned);
        self.shared
            .origin
            .store(origin.wrapping_add(late), Ordering::Relaxed);
    }

    /// Takes a period of the record being played, or of the next one. False: there is none.
    fn next_period(&mut self) -> bool {
        let mut iterations = Iterations::at_most(MAX_TAKEN);
        while self.left == 0 {
            iterations.count();
            let Some(record) = self.shared.records.take() else {
                return false;
            };
            self.left = record.repeat;
            self.record = record;
            self.sign = record.direction.sign();
        }
        self.left = self.left.saturating_sub(1);
        true
    }

    /// Counts the pulse with which a period of the record begins.
    #[inline(always)]
    fn count(&mut self) {
        let position = self.shared.position.load(Ordering::Relaxed);
        let position = position.wrapping_add(self.sign);
        self.shared.position.store(position, Ordering::Relaxed);
    }

    /// Power is off: what waits is gone. For the time under way it counts as played, for the position it does not.
    #[cold]
    #[inline(never)]
    fn drop_all(&mut self) {
        // First of all, so that no pulse leaves while this counts those that have left.
        let has_happened = self.timer.stop();
        let due = self.played_at(self.due);
        let mut played = match self.awaited {
            Awaited::Nothing => self.shared.played.load(Ordering::Relaxed),
            Awaited::End => due,
            Awaited::Silence => due.wrapping_add(self.record.period),
            Awaited::Rise => {
                if has_happened {
                    // The timer was quicker: this pulse has left.
                    self.count();
                }
                due.wrapping_add(self.record.period)
            }
            Awaited::Fall { end } => self.played_at(end),
        };
        let left = self.record.period.wrapping_mul(u32::from(self.left));
        played = played.wrapping_add(left);
        self.left = 0;
        let mut iterations = Iterations::at_most(MAX_TAKEN);
        while let Some(record) = self.shared.records.take() {
            iterations.count();
            played = played.wrapping_add(ticks(&record));
        }
        self.stop_playing(played);
        self.shared.drop.store(false, Ordering::Release);
    }

    /// Nothing is left to play; `played` ticks have been played in all.
    fn stop_playing(&mut self, played: u32) {
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
fn is_reached(now: u32, time: u32) -> bool {
    now.wrapping_sub(time) <= u32::MAX / 2
}

/// The later of two times, less than half a turn apart.
fn later(one: u32, other: u32) -> u32 {
    if is_reached(one, other) { one } else { other }
}

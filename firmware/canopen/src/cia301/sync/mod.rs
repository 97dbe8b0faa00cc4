//! SYNC (CiA 301, 7.2.5): the beat that synchronous PDOs follow.
//!
//! One device of a network produces it ([`producer`](Sync::poll)), the others follow. Four objects say how: 1005h its identifier and
//! who produces it, 1006h its period, 1007h how long after it synchronous PDOs may still be sent, 1019h whether it carries a
//! counter.
//!
//! The contract:
//! - A SYNC has no data without a counter, and one byte with one. Another length is not a SYNC: it is ignored, and
//!   emergency 8240h (unexpected SYNC data length) stands until the next good one. A counter of 0 or above 240 is ignored too.
//! - The producer sends the first SYNC one period after it was switched on, then keeps its rhythm; what it has missed it leaves
//!   out. Its own PDOs follow its own SYNC. Its counter begins with 1 when the device leaves Stopped.
//! - A consumer that knows the period misses a SYNC after one and a half periods: emergency 8100h, until the next one. It
//!   waits from the first SYNC on.
//! - In Stopped there is no SYNC: none is produced, none is missed.

mod errors;
mod parameters;

use errors::Errors;

use super::error_report::ErrorReport;
use crate::time::{Duration, Instant, NEVER, earlier, has_come};

/// Index of the object COB-ID SYNC.
pub const COB_ID: u16 = 0x1005;
/// Index of the communication cycle period, in µs.
pub const PERIOD: u16 = 0x1006;
/// Index of the synchronous window length, in µs.
pub const WINDOW: u16 = 0x1007;
/// Index of the synchronous counter overflow value.
pub const COUNTER_OVERFLOW: u16 = 0x1019;

/// There is none. It is that of NMT, which is nobody's to choose.
const NOT_IN_USE: u16 = 0;

/// The highest counter of a SYNC (CiA 301, 7.5.2.22).
const MOST_COUNTER: u8 = 240;

/// A SYNC: sent now, or received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beat {
    /// Its counter, 1 to 240; `None` for a SYNC without data.
    pub counter: Option<u8>,
}

impl Beat {
    /// A SYNC without data.
    pub const PLAIN: Self = Self { counter: None };
}

/// What time has brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Send a SYNC now, and follow it.
    Produce(Beat),
    /// The synchronous window is over.
    WindowOver,
    /// A SYNC is missed: ask [`Sync::report`].
    Missed,
}

/// The SYNC producer and consumer of a device.
#[derive(Debug)]
pub struct Sync {
    cob_id: u16,
    is_producer: bool,
    /// The NMT state has SYNC.
    is_running: bool,
    /// Nothing but the frame matters: see [`Sync::is_plain`].
    is_plain: bool,
    /// A SYNC has been received since the device has left Stopped.
    is_followed: bool,
    /// 1019h; 0 without a counter.
    overflow: u8,
    /// The counter of the last SYNC that was produced.
    counter: u8,
    /// 1006h in µs; 0 when it is not known.
    period: u32,
    /// 1007h in µs; 0 for no limit.
    window: u32,
    /// When the producer sends, or the consumer misses, the next one.
    next: Instant,
    window_end: Instant,
    errors: Errors,
}

impl Sync {
    /// Neither producer nor consumer until [`Sync::configure`], which goes before everything else.
    pub const fn new() -> Self {
        Self {
            cob_id: NOT_IN_USE,
            is_producer: false,
            is_running: false,
            is_plain: false,
            is_followed: false,
            overflow: 0,
            counter: 0,
            period: 0,
            window: 0,
            next: Instant::from_ticks(0),
            window_end: Instant::from_ticks(0),
            errors: Errors::new(),
        }
    }

    /// The identifier that it has; 0 when there is none.
    pub const fn cob_id(&self) -> u16 {
        self.cob_id
    }

    /// Whether this device produces SYNC: nobody else may send it.
    pub const fn is_producer(&self) -> bool {
        self.is_producer
    }

    /// Whether a frame without data is a SYNC and nothing more: the device consumes it, without a counter, a period or a window, and
    /// no error stands. [`Sync::receive`] need not be called for it.
    #[inline]
    pub const fn is_plain(&self) -> bool {
        self.is_plain
    }

    fn find_plain(&mut self) {
        self.is_plain = self.is_running
            && !self.is_producer
            && self.overflow == 0
            && self.period == 0
            && self.window == 0
            && !self.errors.stand();
    }

    /// The NMT state changed; `has_sync` says whether the new one has SYNC.
    pub fn enter(&mut self, has_sync: bool, now: Instant) {
        if has_sync != self.is_running {
            self.is_running = has_sync;
            self.is_followed = false;
            self.counter = 0;
            self.window_end = NEVER;
            self.restart(now);
            self.find_plain();
        }
    }

    /// A data frame with this identifier arrived at `now`: its length and its first byte. Returns the SYNC that it is. Ask
    /// [`Sync::report`] afterwards in either case.
    pub fn receive(&mut self, length: u8, first: u8, now: Instant) -> Option<Beat> {
        if !self.is_running {
            return None;
        }
        let expected = u8::from(self.overflow != 0);
        self.errors.length(length, length != expected);
        self.find_plain();
        if length != expected {
            return None;
        }
        let counter = (length == 1).then_some(first);
        if counter.is_some_and(|counter| counter == 0 || counter > MOST_COUNTER) {
            return None;
        }
        self.is_followed = true;
        self.errors.missed(false);
        self.restart(now);
        self.open_window(now);
        Some(Beat { counter })
    }

    /// Lets time pass. Call it until there is nothing due.
    pub fn poll(&mut self, now: Instant) -> Option<Due> {
        if self.ends_window(now) {
            return Some(Due::WindowOver);
        }
        if !has_come(self.next, now) {
            return None;
        }
        if !self.is_producer {
            self.next = NEVER;
            self.errors.missed(true);
            return Some(Due::Missed);
        }
        let in_rhythm = self.next + span(self.period);
        self.next = if has_come(in_rhythm, now) {
            now + span(self.period)
        } else {
            in_rhythm
        };
        self.open_window(now);
        let counter = (self.overflow != 0).then(|| {
            self.counter = if self.counter >= self.overflow {
                1
            } else {
                self.counter.saturating_add(1)
            };
            self.counter
        });
        Some(Due::Produce(Beat { counter }))
    }

    /// Whether the window is over since the last call.
    fn ends_window(&mut self, now: Instant) -> bool {
        let is_over = has_come(self.window_end, now);
        if is_over {
            self.window_end = NEVER;
        }
        is_over
    }

    /// Whether the window is over, and nobody has been told yet.
    #[inline]
    pub const fn is_window_over(&self, now: Instant) -> bool {
        has_come(self.window_end, now)
    }

    /// [`Sync::poll`] has nothing to do before this moment.
    #[inline]
    pub const fn deadline(&self) -> Instant {
        earlier(self.next, self.window_end)
    }

    /// Whether [`Sync::report`] has something to tell.
    #[inline]
    pub const fn has_report(&self) -> bool {
        self.errors.have_changed()
    }

    /// What the emergency producer has to hear, one at a time; `None` when it knows everything.
    pub fn report(&mut self) -> Option<ErrorReport> {
        self.errors.report()
    }

    /// The next SYNC is due one period from now, and missed after one and a half.
    #[inline(never)]
    fn restart(&mut self, now: Instant) {
        let period = u64::from(self.period);
        let patience = if self.is_producer {
            period
        } else {
            period + (period >> 1)
        };
        let is_awaited = self.is_running && (self.is_producer || self.is_followed);
        self.next = if is_awaited && period != 0 {
            now + Duration::from_ticks(patience)
        } else {
            NEVER
        };
    }

    fn open_window(&mut self, now: Instant) {
        if self.window != 0 {
            self.window_end = now + span(self.window);
        }
    }
}

fn span(microseconds: u32) -> Duration {
    Duration::from_ticks(microseconds.into())
}

impl Default for Sync {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;

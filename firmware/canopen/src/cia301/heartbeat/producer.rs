//! The heartbeat producer.
//!
//! Writing a time other than 0 to 1017h sends the first heartbeat at once, the next ones follow in that period. A change of the NMT
//! state sends nothing by itself: the next heartbeat tells it. After a boot-up message, which is the first sign of
//! life, the first heartbeat follows one period later. A producer that was called late keeps its rhythm, and leaves out
//! what it has missed.

use crate::od::{self, Dictionary};
use crate::time::{Duration, Instant, NEVER, has_come};

/// Index of the producer heartbeat time, in ms.
pub const PRODUCER_INDEX: u16 = 0x1017;

/// The heartbeat producer of a device.
#[derive(Debug)]
pub struct Producer {
    /// 0: switched off.
    period: Duration,
    next: Instant,
}

impl Producer {
    /// Switched off: [`Producer::configure`] goes before everything else.
    pub const fn new() -> Self {
        Self {
            period: Duration::from_ticks(0),
            next: Instant::from_ticks(0),
        }
    }

    /// Takes its period from 1017h: the boot-up message is sent now.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D, now: Instant) {
        self.period = period(dictionary);
        self.next = if self.is_on() {
            now + self.period
        } else {
            NEVER
        };
    }

    /// 1017h was written.
    pub fn written<D: Dictionary>(&mut self, dictionary: &D, now: Instant) {
        self.period = period(dictionary);
        self.next = if self.is_on() { now } else { NEVER };
    }

    /// Whether a heartbeat is due.
    pub fn poll(&mut self, now: Instant) -> bool {
        if !has_come(self.next, now) {
            return false;
        }
        let in_rhythm = self.next + self.period;
        self.next = if has_come(in_rhythm, now) {
            now + self.period
        } else {
            in_rhythm
        };
        true
    }

    /// When [`Producer::poll`] has something to do.
    pub fn deadline(&self) -> Instant {
        self.next
    }

    /// Whether heartbeats are sent: 1017h is not 0.
    pub fn is_on(&self) -> bool {
        self.period.ticks() != 0
    }
}

impl Default for Producer {
    fn default() -> Self {
        Self::new()
    }
}

#[inline(never)]
fn period<D: Dictionary>(dictionary: &D) -> Duration {
    let milliseconds = od::fixed::<D, PRODUCER_INDEX, 0>(dictionary).unwrap_or(0);
    Duration::from_ticks(u64::from(milliseconds) * 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Instant {
        Instant::from_ticks(milliseconds * 1000)
    }

    #[test]
    fn a_late_call_keeps_the_rhythm() {
        let mut producer = Producer {
            period: Duration::from_ticks(100_000),
            next: at(0),
        };
        assert!(producer.poll(at(0)));
        assert!(!producer.poll(at(99)));
        assert!(producer.poll(at(130)));
        assert_eq!(producer.deadline(), at(200));
    }

    #[test]
    fn missed_heartbeats_are_left_out() {
        let mut producer = Producer {
            period: Duration::from_ticks(100_000),
            next: at(0),
        };
        assert!(producer.poll(at(1000)));
        assert!(!producer.poll(at(1000)));
        assert_eq!(producer.deadline(), at(1100));
    }
}

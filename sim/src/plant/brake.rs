//! The holding brake: a disc that a spring presses and a coil lifts, so it needs its time for either.

use canopen::{Duration, Instant};

/// A brake at work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Brake {
    /// It was open before the last order.
    was_open: bool,
    /// It is told to be open.
    opens: bool,
    /// When it obeys.
    due: Instant,
}

impl Brake {
    /// One that is closed.
    pub(super) const fn new() -> Self {
        Self {
            was_open: false,
            opens: false,
            due: Instant::from_ticks(0),
        }
    }

    /// The coil gets its current, or loses it; the disc follows after `delay`. One that was on its way is where it was.
    pub(super) fn order(&mut self, opens: bool, now: Instant, delay: Duration) {
        if opens != self.opens {
            self.was_open = self.is_open(now);
            self.opens = opens;
            self.due = now + delay;
        }
    }

    /// Whether the shaft is free.
    pub(super) fn is_open(&self, now: Instant) -> bool {
        if now >= self.due {
            self.opens
        } else {
            self.was_open
        }
    }

    /// Whether it is told to be open.
    pub(super) const fn opens(&self) -> bool {
        self.opens
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_obeys_after_its_delay_and_a_short_order_not_at_all() {
        let at = |milliseconds: u64| Instant::from_ticks(milliseconds * 1_000);
        let (release, engage) = (Duration::millis(40), Duration::millis(25));
        let mut brake = Brake::new();
        assert!(!brake.is_open(at(0)));
        brake.order(true, at(100), release);
        // Said again, it is no new order.
        brake.order(true, at(120), release);
        assert!(!brake.is_open(at(139)) && brake.is_open(at(140)));
        brake.order(false, at(200), engage);
        assert!(brake.is_open(at(224)));
        brake.order(true, at(224), release);
        assert!(brake.is_open(at(230)), "it was open still");
        brake.order(false, at(300), engage);
        assert!(brake.is_open(at(324)) && !brake.is_open(at(325)));
        brake.order(true, at(400), release);
        brake.order(false, at(439), engage);
        assert!(!brake.is_open(at(439)) && !brake.is_open(at(500)));
    }
}

//! When control ticks are due in the cyclic modes: in step with the beat.
//!
//! In step, a tick comes a quarter of a tick before each beat, so that SYNC finds the values of that moment, and as many in between as keep ticks
//! from being longer than they nominally are. The rhythm is brought into step by at most 1/32 in each tick.

use canopen::{Duration, Instant};

use super::lock::Lock;
use super::{Fine, POINT, fine, span};

/// The rhythm.
#[derive(Debug)]
pub(crate) struct Schedule {
    nominal: Fine,
    /// When the next tick is due.
    due: Fine,
    /// From one tick to the next, as it is now.
    tick: Fine,
}

impl Schedule {
    /// Ticks of this period.
    pub(crate) const fn new(tick: Duration) -> Self {
        let nominal = tick.ticks() << POINT;
        Self {
            nominal,
            due: 0,
            tick: nominal,
        }
    }

    /// How long before a beat a tick comes.
    pub(crate) const fn lead(&self) -> Fine {
        self.nominal / 4
    }

    /// From one tick to the next.
    pub(crate) const fn tick(&self) -> Fine {
        self.tick
    }

    /// A tick runs at `now`. Returns when the next one is due, in step with `lock`.
    pub(crate) fn next(&mut self, now: Instant, lock: &Lock) -> Instant {
        let now = fine(now);
        if span(self.due, now).unsigned_abs() > self.nominal / 2 {
            self.due = now;
        }
        self.due = self.due.wrapping_add(self.in_step(lock));
        let half = 1 << (POINT - 1);
        Instant::from_ticks(self.due.wrapping_add(half) >> POINT)
    }

    /// From this tick to the next, towards the moments of `lock`.
    fn in_step(&mut self, lock: &Lock) -> Fine {
        let ticks = lock
            .period()
            .saturating_sub(lock.period() / 16)
            .checked_div(self.nominal)
            .unwrap_or(0)
            .saturating_add(1);
        self.tick = lock.period().checked_div(ticks).unwrap_or(self.nominal);
        // The tick of the grid that is nearest to where the next tick would be.
        let wanted = self.due.wrapping_add(self.tick);
        let off = span(lock.at().wrapping_sub(self.lead()), wanted);
        let tick = self.tick.cast_signed();
        let off = off.checked_rem_euclid(tick).unwrap_or(0);
        let off = if off > tick / 2 { off - tick } else { off };
        let most = tick / 32;
        self.tick.wrapping_add_signed(-off.max(-most).min(most))
    }
}

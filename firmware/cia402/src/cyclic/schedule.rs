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
        self.tick = self.even(lock.period());
        // The tick of the grid that is nearest to where the next tick would be.
        let wanted = self.due.wrapping_add(self.tick);
        let off = span(lock.at().wrapping_sub(self.lead()), wanted);
        let tick = self.tick.cast_signed();
        let off = nearest(off, tick);
        let most = tick / 32;
        self.tick.wrapping_add_signed(-off.max(-most).min(most))
    }

    /// As many ticks as a period needs, all of the same length. Where one is enough there is nothing to divide.
    fn even(&self, period: Fine) -> Fine {
        let least = period.saturating_sub(period / 16);
        if least < self.nominal {
            return period;
        }
        let ticks = least
            .checked_div(self.nominal)
            .unwrap_or(0)
            .saturating_add(1);
        period.checked_div(ticks).unwrap_or(self.nominal)
    }
}

/// How far off the nearest tick of a grid is. In step, it is near already.
fn nearest(off: i64, tick: i64) -> i64 {
    let half = tick / 2;
    if -half < off && off <= half {
        return off;
    }
    let off = off.checked_rem_euclid(tick).unwrap_or(0);
    if off > half { off - tick } else { off }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TICK: Fine = 1_000 << POINT;

    proptest! {
        #[test]
        fn m63_ticks_of_a_period_are_even_and_hardly_longer_than_nominal(period in TICK / 2..2_000 * TICK) {
            let tick = Schedule::new(Duration::micros(1_000)).even(period);
            let ticks = (period - period / 16) / TICK + 1;
            prop_assert_eq!(tick, period / ticks);
            prop_assert!(tick <= TICK + TICK / 15 + 1);
        }

        #[test]
        fn m63_the_nearest_tick_is_at_most_half_a_tick_away(off in -10_000_i64..10_000, tick in 1_i64..2_000) {
            let found = nearest(off, tick);
            prop_assert_eq!((off - found) % tick, 0);
            prop_assert!(2 * found <= tick && 2 * found > -tick - 2, "{found}");
            let folded = off.rem_euclid(tick);
            prop_assert_eq!(found, if folded > tick / 2 { folded - tick } else { folded });
        }
    }
}

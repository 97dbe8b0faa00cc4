//! When control ticks are due in the cyclic modes: in step with the sync events.
//!
//! In step, a tick comes a quarter of a tick before each sync event, so that the process data of SYNC are of that moment. As many ticks lie
//! in between as keep them from being longer than nominal. A tick is made longer or shorter by at most 1/32 to bring them into step.
//!
//! At the tick before a sync event the motor is at a set-point. That moment was fixed when the set-point came, some sync events ago, and
//! the loop has moved since with the jitter. So the tick keeps to the fixed moment ([`Schedule::aim`]) and not to the present one of the
//! loop; otherwise, at 500,000 increments/s, the motor would be up to five increments off.

use canopen::{Duration, Instant};
use heapless::Deque;
use motion::div_rem;
use motion::low;

use super::pll::Pll;
use super::{MicrosQ16, POINT, micros_q16, span};

/// The times of the control ticks.
#[derive(Debug)]
pub(crate) struct Schedule {
    nominal: MicrosQ16,
    /// When the next tick is due.
    due: MicrosQ16,
    /// The present length of a tick.
    tick: MicrosQ16,
    /// The period of sync events from which that length was computed.
    period: MicrosQ16,
    /// When the motor will be at set-points, the next one first.
    aims: Deque<MicrosQ16, AIMS>,
}

/// The most set-points that are known ahead of the motor, with the shortest periods.
const AIMS: usize = 12;

impl Schedule {
    /// Ticks of this period.
    pub(crate) const fn new(tick: Duration) -> Self {
        let nominal = tick.ticks() << POINT;
        Self {
            nominal,
            due: 0,
            tick: nominal,
            period: nominal,
            aims: Deque::new(),
        }
    }

    /// The motor will be at a set-point at this moment. Later moments are dropped: they are of sync events from before a new beginning.
    pub(crate) fn aim(&mut self, at: MicrosQ16) {
        while self.aims.back().is_some_and(|later| span(*later, at) <= 0) {
            let _ = self.aims.pop_back();
        }
        // Without room, the tick keeps to the loop.
        let _ = self.aims.push_back(at);
    }

    /// How long before a sync event a tick comes.
    pub(crate) const fn sync_lead(&self) -> MicrosQ16 {
        self.nominal / 4
    }

    /// From one tick to the next.
    pub(crate) const fn tick(&self) -> MicrosQ16 {
        self.tick
    }

    /// A tick runs at `now`. Returns when the next one is due, in step with `pll`.
    #[inline(never)]
    pub(crate) fn next(&mut self, now: Instant, pll: &Pll) -> Instant {
        let now = micros_q16(now);
        if span(self.due, now).unsigned_abs() > self.nominal / 2 {
            self.due = now;
        }
        self.due = self.due.wrapping_add(self.in_step(pll));
        let half = 1 << (POINT - 1);
        Instant::from_ticks(self.due.wrapping_add(half) >> POINT)
    }

    /// From this tick to the next, towards the moments of `pll`.
    fn in_step(&mut self, pll: &Pll) -> MicrosQ16 {
        if self.period != pll.period() {
            self.period = pll.period();
            self.tick = self.even(self.period);
        }
        // The tick of the grid that is nearest to where the next tick would be.
        let wanted = self.due.wrapping_add(self.tick);
        let tick = self.tick.cast_signed();
        let grid = self
            .aimed_at(wanted)
            .unwrap_or_else(|| pll.at().wrapping_sub(self.sync_lead()));
        let off = span(grid, wanted);
        let off = nearest(off, tick);
        let max = tick / 32;
        self.tick.wrapping_add_signed(-off.max(-max).min(max))
    }

    /// The next moment at which the motor is at a set-point, seen from the next tick.
    fn aimed_at(&mut self, wanted: MicrosQ16) -> Option<MicrosQ16> {
        let half = (self.tick / 2).cast_signed();
        while let Some(aim) = self.aims.front() {
            if span(*aim, wanted) <= half {
                return Some(*aim);
            }
            let _ = self.aims.pop_front();
        }
        None
    }

    /// As many ticks as a period needs, all of the same length. Where one is enough there is nothing to divide.
    fn even(&self, period: MicrosQ16) -> MicrosQ16 {
        let least = period.saturating_sub(period / 16);
        if least < self.nominal {
            return period;
        }
        // A nominal tick has 32 bits, and there are no more of them in a period.
        let by = |time: MicrosQ16, by: MicrosQ16| div_rem(time, low::u32(by)).0;
        let ticks = by(least, self.nominal).saturating_add(1);
        by(period, ticks)
    }
}

/// How far off the nearest tick of a grid is.
fn nearest(off: i64, tick: i64) -> i64 {
    let half = tick / 2;
    if -half < off && off <= half {
        return off;
    }
    // A tick has 32 bits.
    let rest = i64::from(div_rem(off.unsigned_abs(), low::u32(tick.cast_unsigned())).1);
    let off = if off < 0 && rest != 0 {
        tick - rest
    } else {
        rest
    };
    if off > half { off - tick } else { off }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TICK: MicrosQ16 = 1_000 << POINT;

    proptest! {
        #[test]
        fn m63_ticks_of_a_period_are_even_and_hardly_longer_than_nominal(period in TICK / 2..2_000 * TICK) {
            let tick = Schedule::new(Duration::micros(1_000)).even(period);
            let ticks = (period - period / 16) / TICK + 1;
            prop_assert_eq!(tick, period / ticks);
            prop_assert!(tick <= TICK + TICK / 15 + 1);
        }

        /// Whatever jitter moves them by from one to the next, a tick comes at each moment at which the motor is at a set-point.
        #[test]
        fn m63_a_tick_comes_at_each_moment_that_is_aimed_at(
            period in prop::sample::select(std::vec![1_000_u64, 2_000, 4_000, 10_000]),
            off in prop::collection::vec(-10_i64..=10, 20..60),
        ) {
            let mut schedule = Schedule::new(Duration::micros(1_000));
            let mut pll = Pll::new();
            for k in 0..8 {
                pll.on_sync_event((k * period) << POINT, [period << POINT, 0]);
            }
            let aims = (9..).zip(&off).map(|(k, off)| (k * period).strict_add_signed(*off));
            let mut coming = aims.clone();
            let mut ticks = std::vec::Vec::new();
            let mut now = Instant::from_ticks(8 * period);
            for _ in 0..off.len() as u64 * period / 900 {
                // Three of them are known ahead.
                while schedule.aims.len() < 3 && let Some(aim) = coming.next() {
                    schedule.aim(aim << POINT);
                }
                now = schedule.next(now, &pll);
                ticks.push(now.ticks());
            }
            let mut met = 0;
            for aim in aims.take_while(|aim| *aim < now.ticks()) {
                prop_assert!(ticks.contains(&aim), "{aim}: {ticks:?}");
                met += 1;
            }
            prop_assert!(met >= 15, "{met}");
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
    #[test]
    fn m63_moments_of_a_sync_event_that_is_no_more_are_forgotten() {
        let mut schedule = Schedule::new(Duration::micros(1_000));
        for second in 1..=20 {
            schedule.aim(second * 1_000 * TICK);
        }
        schedule.aim(5 * TICK);
        schedule.aim(6 * TICK);
        assert_eq!(schedule.aimed_at(5 * TICK), Some(5 * TICK));
        assert_eq!(schedule.aimed_at(6 * TICK), Some(6 * TICK));
        assert_eq!(schedule.aimed_at(7 * TICK), None);
    }
}

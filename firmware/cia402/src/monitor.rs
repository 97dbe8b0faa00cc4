//! What the motor does in comparison with what it should: actual velocity, following error, slippage.
//!
//! A velocity from counted steps is coarse: one step in a millisecond is 1000 steps/s. So the actual velocity 606Ch is the
//! velocity demand less how fast the following error has grown over the last sixteen control ticks. As long as the motor follows its
//! pulses, it is as smooth as the demand; as soon as it does not, it shows what the motor does.

use canopen::{Duration, Instant};
use motion::Demand;

use crate::configuration::Configuration;
use crate::dwell::Dwell;

/// Control ticks over which a change of the following error is taken.
const SPAN: usize = 16;

/// 6065h: the window is not looked at.
const OFF: u32 = u32::MAX;

/// The following error of the last control ticks.
#[derive(Debug)]
pub(crate) struct Monitor {
    errors: [i32; SPAN],
    oldest: usize,
    /// From a change over the span to a change in a second, Q16.
    rate: i64,
    outside: Dwell,
}

/// What a control tick found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Observed {
    /// 60F4h: 6062h less 6064h, in steps.
    pub(crate) following_error: i32,
    /// 606Ch in steps/s.
    pub(crate) velocity: i32,
    /// 606Bh less 606Ch, in steps/s.
    pub(crate) slippage: i32,
    /// The following error has been outside of 6065h for 6066h.
    pub(crate) is_lost: bool,
}

impl Monitor {
    /// A monitor for control ticks of this period.
    pub(crate) fn new(tick: Duration) -> Self {
        let span = tick.ticks().saturating_mul(SPAN as u64);
        let rate = (1_000_000_u64 << 16).checked_div(span).unwrap_or(0);
        Self {
            errors: [0; SPAN],
            oldest: 0,
            rate: i64::try_from(rate).unwrap_or(i64::MAX),
            outside: Dwell::new(),
        }
    }

    /// The motor has no power: what it should do is what it does.
    pub(crate) fn reset(&mut self) {
        self.errors = [0; SPAN];
        self.outside = Dwell::new();
    }

    /// Looks at the motor at the start of a tick.
    pub(crate) fn observe(
        &mut self,
        now: Instant,
        demand: Demand,
        position: i64,
        configuration: &Configuration,
    ) -> Observed {
        let error = (demand.position as i32).wrapping_sub(position as i32);
        let before = self
            .errors
            .get_mut(self.oldest)
            .map_or(error, |oldest| core::mem::replace(oldest, error));
        self.oldest = (self.oldest + 1) % SPAN;
        let growth = error.wrapping_sub(before);
        // One step more or less is but the moment at which a pulse leaves.
        let slippage = if growth.unsigned_abs() <= 1 {
            0
        } else {
            saturated(i64::from(growth).saturating_mul(self.rate) >> 16)
        };
        let window = configuration.following_error_window;
        Observed {
            following_error: error,
            velocity: demand.velocity.saturating_sub(slippage),
            slippage,
            is_lost: window != OFF
                && self.outside.has_held(
                    now,
                    error.unsigned_abs() > window,
                    configuration.following_error_time_out,
                ),
        }
    }
}

fn saturated(number: i64) -> i32 {
    let end = if number < 0 { i32::MIN } else { i32::MAX };
    i32::try_from(number).unwrap_or(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: Duration = Duration::from_ticks(1_000);

    fn at(milliseconds: u64) -> Instant {
        Instant::from_ticks(milliseconds * 1000)
    }

    fn demand(position: i64, velocity: i32) -> Demand {
        Demand { position, velocity }
    }

    #[test]
    fn m60_a_motor_that_follows_has_the_velocity_of_the_demand() {
        let mut monitor = Monitor::new(TICK);
        for tick in 0..100 {
            let position = i64::try_from(tick).unwrap() * 3;
            let late = position - i64::from(tick % 2 == 0);
            let observed = monitor.observe(
                at(tick),
                demand(position, 3_000),
                late,
                &Configuration::NONE,
            );
            assert_eq!((observed.velocity, observed.slippage), (3_000, 0));
        }
    }

    #[test]
    fn m42_a_motor_that_is_stuck_shows_its_velocity() {
        let mut monitor = Monitor::new(TICK);
        let mut last = Observed::default();
        for tick in 0..100 {
            let position = i64::try_from(tick).unwrap() * 8;
            last = monitor.observe(at(tick), demand(position, 8_000), 0, &Configuration::NONE);
        }
        assert_eq!((last.velocity, last.slippage), (0, 8_000));
        assert_eq!(last.following_error, 99 * 8);
        assert!(!last.is_lost, "6065h is off");
    }

    #[test]
    fn m60_the_following_error_counts_after_its_time() {
        let mut monitor = Monitor::new(TICK);
        let configuration = Configuration {
            following_error_window: 5,
            following_error_time_out: 10,
            ..Configuration::NONE
        };
        let mut lost = |milliseconds, error| {
            monitor
                .observe(at(milliseconds), demand(error, 0), 0, &configuration)
                .is_lost
        };
        assert!(!lost(0, -6));
        assert!(!lost(9, -6));
        assert!(!lost(10, 5), "inside again");
        assert!(!lost(11, 6));
        assert!(!lost(20, 6));
        assert!(lost(21, 6));
    }
}

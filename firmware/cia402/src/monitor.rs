//! What the motor does in comparison with what it should: actual velocity, following error, slippage.
//!
//! A velocity from counted steps is coarse: one step in a millisecond is 1000 steps/s. So the actual velocity 606Ch is the
//! velocity demand less how fast the following error has grown over the last sixteen control ticks. As long as the motor follows its
//! pulses, it is as smooth as the demand; as soon as it does not, it shows what the motor does.

use canopen::Instant;
use motion::{Demand, SignedSpeed, low};

use crate::configuration::Configuration;
use crate::window_timer::WindowTimer;

/// Control ticks over which a change of the following error is taken.
const SPAN: usize = 16;

/// 6065h: the following error window is off.
const OFF: u32 = u32::MAX;

/// The following error of the last control ticks.
#[derive(Debug)]
pub(crate) struct Monitor {
    /// Each with its moment in microseconds: in step with SYNC a tick may be a good deal shorter than a nominal one.
    errors: [(i32, u32); SPAN],
    oldest: usize,
    outside: WindowTimer,
    /// What was found in this tick.
    observed: Observed,
    /// There was a following error (outside of 6065h for 6066h) since the last fault reset.
    had_following_error: bool,
}

/// What a control tick found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Observed {
    /// 60F4h: 6062h less 6064h, in steps.
    pub(crate) following_error: i32,
    /// 606Ch.
    pub(crate) velocity: SignedSpeed,
    /// 606Bh less 606Ch.
    pub(crate) slippage: SignedSpeed,
    /// The following error has been outside of 6065h for 6066h.
    pub(crate) exceeds_window: bool,
}

impl Monitor {
    pub(crate) const fn new() -> Self {
        Self {
            errors: [(0, 0); SPAN],
            oldest: 0,
            outside: WindowTimer::new(),
            observed: Observed::NONE,
            had_following_error: false,
        }
    }

    /// What was found in this tick.
    pub(crate) const fn observed(&self) -> &Observed {
        &self.observed
    }

    /// Whether there was a following error since the last call of [`Monitor::forget_following_error`].
    pub(crate) const fn had_following_error(&self) -> bool {
        self.had_following_error
    }

    /// The master has reset the fault.
    pub(crate) const fn forget_following_error(&mut self) {
        self.had_following_error = false;
    }

    /// A tick without power: there is no following error.
    pub(crate) fn reset(&mut self, now: Instant) {
        for (error, _) in &mut self.errors {
            *error = 0;
        }
        self.outside = WindowTimer::new();
        self.put(now, 0);
        self.observed = Observed::NONE;
    }

    /// Keeps an error in the place of the oldest one. Returns by how much they differ, and the microseconds in between.
    fn put(&mut self, now: Instant, error: i32) -> (i32, u32) {
        let moment = low::u32(now.ticks());
        let new = (error, moment);
        let (before, since) = self
            .errors
            .get_mut(self.oldest)
            .map_or(new, |oldest| core::mem::replace(oldest, new));
        self.oldest = (self.oldest + 1) % SPAN;
        (error.wrapping_sub(before), moment.wrapping_sub(since))
    }

    /// Looks at the motor at the start of a tick. `is_counted` says that its position is the pulses that have left, and not that of an
    /// encoder.
    pub(crate) fn observe(
        &mut self,
        now: Instant,
        demand: Demand,
        position: i64,
        is_counted: bool,
        configuration: &Configuration,
    ) -> Observed {
        let error = following_error(demand, position, is_counted);
        let (growth, span) = self.put(now, error);
        // A difference of one step is only the moment at which a pulse leaves.
        let (velocity, slippage) = if growth.unsigned_abs() <= 1 {
            (demand.velocity, SignedSpeed::ZERO)
        } else {
            let slippage = per_second(growth, span).into();
            (demand.velocity.minus(slippage), slippage)
        };
        let window = configuration.following_error_window;
        self.observed = Observed {
            following_error: error,
            velocity,
            slippage,
            // Checked while it is off too, so that its time starts anew when it is on again.
            exceeds_window: self.outside.has_held(
                now,
                window != OFF && error.unsigned_abs() > window,
                configuration.following_error_time_out,
            ),
        };
        self.had_following_error |= self.observed.exceeds_window;
        self.observed
    }

    /// Looks at the motor between two ticks that measure: its slippage is the one that was found last.
    pub(crate) fn look_again(&mut self, demand: Demand, position: i64, is_counted: bool) {
        self.observed.following_error = following_error(demand, position, is_counted);
        self.observed.velocity = demand.velocity.minus(self.observed.slippage);
    }
}

impl Observed {
    /// A motor that does what it should.
    const NONE: Self = Self {
        following_error: 0,
        velocity: SignedSpeed::ZERO,
        slippage: SignedSpeed::ZERO,
        exceeds_window: false,
    };
}

/// 60F4h in steps. Where pulses are counted, one that may still be on its way is not missing.
const fn following_error(demand: Demand, position: i64, is_counted: bool) -> i32 {
    let error = low::i32(demand.position).wrapping_sub(low::i32(position));
    if is_counted && error.unsigned_abs() <= moment_of_a_pulse(demand.velocity) {
        0
    } else {
        error
    }
}

/// By how many steps pulses that are counted may differ from the demand though none is missing: one for the moment at which it
/// leaves, and what passes in the 4 µs between the looks at the count and at the clock.
const fn moment_of_a_pulse(velocity: SignedSpeed) -> u32 {
    1 + (velocity.unsigned_abs().bits() >> (32 + 18)) as u32
}

/// A change in so many microseconds as one in a second, saturating.
#[cold]
fn per_second(growth: i32, span: u32) -> i32 {
    let million = u64::from(growth.unsigned_abs()).wrapping_mul(1_000_000);
    let (number, _) = motion::div_rem(million, span);
    if growth < 0 {
        let end = i32::MIN;
        0_i32
            .checked_sub_unsigned(u32::try_from(number).unwrap_or(u32::MAX))
            .unwrap_or(end)
    } else {
        i32::try_from(number).unwrap_or(i32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn m27_a_velocity_is_the_whole_quotient_towards_zero() {
        for growth in [0, 1, -1, 7, -7, 4_294, -4_295, 123_456, i32::MAX, i32::MIN] {
            for span in [1, 3, 999, 1_000, 1_001, 999_999, 1_000_000, u32::MAX] {
                let number = i64::from(growth) * 1_000_000 / i64::from(span);
                let expected = number.clamp(i32::MIN.into(), i32::MAX.into());
                assert_eq!(i64::from(per_second(growth, span)), expected);
            }
            assert_eq!(per_second(growth, 0), 0);
        }
    }

    fn at(milliseconds: u64) -> Instant {
        Instant::from_ticks(milliseconds * 1000)
    }

    fn demand(position: i64, velocity: i32) -> Demand {
        Demand {
            position,
            velocity: velocity.into(),
        }
    }

    #[test]
    fn m60_a_motor_that_follows_has_the_velocity_of_the_demand() {
        let mut monitor = Monitor::new();
        for tick in 0..100 {
            let position = i64::try_from(tick).unwrap() * 3;
            let late = position - i64::from(tick % 2 == 0);
            let observed = monitor.observe(
                at(tick),
                demand(position, 3_000),
                late,
                false,
                &Configuration::NONE,
            );
            assert_eq!(
                (observed.velocity, observed.slippage),
                (3_000.into(), SignedSpeed::ZERO)
            );
        }
    }

    #[test]
    fn m42_a_motor_that_is_stuck_shows_its_velocity() {
        let mut monitor = Monitor::new();
        let mut last = Observed::default();
        for tick in 0..100 {
            let position = i64::try_from(tick).unwrap() * 8;
            last = monitor.observe(
                at(tick),
                demand(position, 8_000),
                0,
                false,
                &Configuration::NONE,
            );
        }
        assert_eq!(
            (last.velocity, last.slippage),
            (SignedSpeed::ZERO, 8_000.into())
        );
        assert_eq!(last.following_error, 99 * 8);
        assert!(!last.exceeds_window, "6065h is off");
    }

    #[test]
    fn m42_its_velocity_is_right_with_ticks_that_are_not_nominal() {
        // In step with a SYNC each 2.5 ms, and ever longer ones.
        for length in [833, 900, 1_000, 1_125] {
            let mut monitor = Monitor::new();
            let mut last = Observed::default();
            for tick in 0..40_i64 {
                let now = Instant::from_ticks(1_000_000 + (tick * length).unsigned_abs());
                if tick < 20 {
                    monitor.reset(now);
                } else {
                    // 12 steps in each tick, and 3 of them slip.
                    let demand = demand(tick * 12, 12_000_000 / length as i32);
                    last = monitor.observe(now, demand, tick * 9 + 60, false, &Configuration::NONE);
                }
            }
            let wanted = 3_000_000 / length;
            assert!(
                (i64::from(last.slippage.whole()) - wanted).abs() <= 1,
                "{length} us: {last:?}"
            );
            assert!((i64::from(last.velocity.whole()) - 3 * wanted).abs() <= 2);
        }
    }

    #[test]
    fn m60_without_an_encoder_a_motor_that_follows_has_no_following_error() {
        let mut monitor = Monitor::new();
        let configuration = Configuration {
            following_error_window: 0,
            ..Configuration::NONE
        };
        for (tick, error) in [(0, -1), (1, 1), (2, 0), (3, 1), (4, -1)] {
            let observed = monitor.observe(at(tick), demand(error, 900), 0, true, &configuration);
            assert_eq!(observed.following_error, 0);
            assert!(!observed.exceeds_window);
        }
        // With an encoder it is one, and so are two steps that are missing.
        let observed = monitor.observe(at(5), demand(1, 900), 0, false, &configuration);
        assert_eq!(
            (observed.following_error, observed.exceeds_window),
            (1, true)
        );
        let observed = monitor.observe(at(6), demand(2, 900), 0, true, &configuration);
        assert_eq!(
            (observed.following_error, observed.exceeds_window),
            (2, true)
        );
        // At 2,000,000 steps/s seven of them pass between two looks.
        let fast = |error| demand(error, 2_000_000);
        let observed = monitor.observe(at(7), fast(8), 0, true, &configuration);
        assert_eq!(observed.following_error, 0);
        let observed = monitor.observe(at(8), fast(9), 0, true, &configuration);
        assert_eq!(observed.following_error, 9);
    }

    #[test]
    fn m60_the_following_error_counts_after_its_time() {
        let mut monitor = Monitor::new();
        let configuration = Configuration {
            following_error_window: 5,
            following_error_time_out: 10,
            ..Configuration::NONE
        };
        let mut lost = |milliseconds, error| {
            monitor
                .observe(at(milliseconds), demand(error, 0), 0, false, &configuration)
                .exceeds_window
        };
        assert!(!lost(0, -6));
        assert!(!lost(9, -6));
        assert!(!lost(10, 5), "inside again");
        assert!(!lost(11, 6));
        assert!(!lost(20, 6));
        assert!(lost(21, 6));
    }

    #[test]
    fn m60_switched_off_and_on_the_time_of_6066h_starts_anew() {
        let mut monitor = Monitor::new();
        let mut lost = |milliseconds, following_error_window| {
            let configuration = Configuration {
                following_error_window,
                following_error_time_out: 1_000,
                ..Configuration::NONE
            };
            monitor
                .observe(at(milliseconds), demand(10, 0), 0, false, &configuration)
                .exceeds_window
        };
        assert!(!lost(0, 5));
        assert!(!lost(500, OFF));
        assert!(!lost(3_000, 5));
        assert!(!lost(3_999, 5));
        assert!(lost(4_000, 5));
    }
}

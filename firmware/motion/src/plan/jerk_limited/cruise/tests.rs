use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::*;
use crate::clock::Clock;
use crate::plan::jerk_limited::ramp::{Jerk, Ramp};

/// Limits that a drive may have, in steps and seconds: the velocity, the greatest acceleration and deceleration, the jerk.
fn rules() -> impl Strategy<Value = (i128, Limit, Limit, Jerk)> {
    (1u32..4_000_000, 1u32..50_000_000, 1u32..50_000_000, 1u32..).prop_map(
        |(velocity, acceleration, deceleration, jerk)| {
            let clock = Clock::new(168_000_000).unwrap();
            let jerk = Jerk::new(clock.sixth_jerk(jerk));
            let limit = |rate| Limit::new(clock.half_acceleration(rate) << 1, &jerk);
            let top = clock.speed(velocity.into()).cast_signed();
            (top, limit(acceleration), limit(deceleration), jerk)
        },
    )
}

/// A part of a number, in thousandths of its root: small ones are frequent.
fn part(number: i128, thousandths: i128) -> i128 {
    (number >> 20) * thousandths * thousandths * (1 << 20) / 1_000_000
}

/// Even where the guess is bad, a velocity above zero is found.
#[test]
fn a_bad_guess_ends_at_a_velocity_above_zero() {
    let clock = Clock::new(168_000_000).unwrap();
    let jerk = Jerk::new(clock.sixth_jerk(u32::MAX));
    let limit = Limit::new(clock.half_acceleration(1_000_000) << 1, &jerk);
    let rules = Rules {
        top: clock.speed(4_000_000.into()).cast_signed(),
        acceleration: &limit,
        deceleration: &limit,
        jerk: &jerk,
    };
    let virtual_start = VirtualStart::steady(0, false);
    for distance in [1 << 64, 1 << 70, 1 << 80, 1 << 96] {
        let moves = Moves::new(&rules, &virtual_start, 0, distance, 0);
        for more in [Rough::power(-30), Rough::power(20)] {
            let cruise = moves.refine(rules.top, more, Rough::ZERO);
            assert!(
                cruise > 0 && moves.span(cruise) <= distance,
                "{cruise} for {distance}"
            );
        }
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(4096)))]

    /// The ramps fit into the distance, and what they leave of it is over within a tick, or the velocity is the greatest allowed.
    #[test]
    fn the_velocity_found_is_the_greatest(
        (top, acceleration, deceleration, jerk) in rules(),
        (speed, rate, end) in (0i128..1200, -1000i128..=1000, 0i128..=1000),
        distance in (1u128 << 60)..,
        shift in 0u32..64,
    ) {
        let rules = Rules { top, acceleration: &acceleration, deceleration: &deceleration, jerk: &jerk };
        let distance = distance >> shift;
        let velocity = part(rules.top, speed);
        let limit = if rate < 0 { rules.deceleration } else { rules.acceleration };
        let from = Motion::new(velocity, part(limit.most, rate) * rate.signum(), &jerk);
        let end = part(rules.top, end);
        if from.coasting() < 0 {
            return Ok(());
        }
        let mut virtual_start = VirtualStart::steady(0, false);
        let Some(cruise) = rules.fastest(&from, end, distance, &mut virtual_start) else {
            return Ok(());
        };
        prop_assert!(end <= cruise && cruise <= rules.top);
        let limit = if virtual_start.falls { rules.deceleration } else { rules.acceleration };
        let first = Ramp::new((&from, &virtual_start), cruise, limit, &jerk);
        let virtual_start = VirtualStart::steady(cruise, true);
        let last = Ramp::new((&Motion::steady(cruise), &virtual_start), end, rules.deceleration, &jerk);
        let distances = first.distance.unsigned_abs() + last.distance.unsigned_abs();
        // Times are rounded to 2⁻³² ticks.
        let rounded = (distances >> 40) + (1 << 40) + (cruise.unsigned_abs() >> 31);
        prop_assert!(distances <= distance + rounded, "{distances} of {distance}");
        let left = distance.saturating_sub(distances);
        prop_assert!(
            cruise == rules.top || left <= (cruise.unsigned_abs() >> 1) + rounded,
            "{left} of {distance} left at {cruise} of {}, down to {end}", rules.top
        );
    }
}

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::*;
use crate::clock::Clock;
use crate::exact::with_sign;
use crate::plan::jerk_limited::ramp::{Jerk, Ramp};

/// Limits that a drive may have, in steps and seconds: the velocity, the greatest acceleration and deceleration, the jerk.
fn rules() -> impl Strategy<Value = (Q96, Limit, Limit, Jerk)> {
    (1u32..4_000_000, 1u32..50_000_000, 1u32..50_000_000, 1u32..).prop_map(
        |(velocity, acceleration, deceleration, jerk)| {
            let clock = Clock::new(168_000_000).unwrap();
            let jerk = Jerk::new(clock.sixth_jerk(jerk));
            let limit = |rate| Limit::new(clock.half_acceleration(rate).doubled(), &jerk);
            let top = clock.speed(velocity.into()).forwards();
            (top, limit(acceleration), limit(deceleration), jerk)
        },
    )
}

/// A part of a number, in thousandths of its root: small ones are frequent.
fn part(number: Q96, thousandths: i128) -> Q96 {
    let part = (number.bits() >> 20) * thousandths * thousandths * (1 << 20);
    Q96::from_bits(part / 1_000_000)
}

/// Even where the guess is bad, a velocity above zero is found.
#[test]
fn a_bad_guess_ends_at_a_velocity_above_zero() {
    let clock = Clock::new(168_000_000).unwrap();
    let jerk = Jerk::new(clock.sixth_jerk(u32::MAX));
    let limit = Limit::new(clock.half_acceleration(1_000_000).doubled(), &jerk);
    let rules = Rules {
        top: clock.speed(4_000_000.into()).forwards(),
        acceleration: &limit,
        deceleration: &limit,
        jerk: &jerk,
    };
    let virtual_start = VirtualStart::steady(Q96::ZERO, false);
    for distance in [1 << 64, 1 << 70, 1 << 80, 1 << 96] {
        let distance = DistanceQ96::from_bits(distance);
        let moves = Moves::new(&rules, &virtual_start, Q96::ZERO, distance, Q96::ZERO);
        for more in [Rough::power(-30), Rough::power(20)] {
            let cruise = moves.refine(rules.top, more, Rough::ZERO);
            assert!(
                cruise > Q96::ZERO && moves.span(cruise) <= distance,
                "{cruise:?} for {distance:?}"
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
        let distance = DistanceQ96::from_bits(distance >> shift);
        let velocity = part(rules.top, speed);
        let limit = if rate < 0 { rules.deceleration } else { rules.acceleration };
        let from = Motion::new(velocity, with_sign(part(limit.most, rate), rate < 0), &jerk);
        let end = part(rules.top, end);
        if from.coasting() < Q96::ZERO {
            return Ok(());
        }
        let mut virtual_start = VirtualStart::steady(Q96::ZERO, false);
        let Some(cruise) = rules.fastest(&from, end, distance, &mut virtual_start) else {
            return Ok(());
        };
        prop_assert!(end <= cruise && cruise <= rules.top);
        let limit = if virtual_start.falls { rules.deceleration } else { rules.acceleration };
        let first = Ramp::new((&from, &virtual_start), cruise, limit, &jerk);
        let virtual_start = VirtualStart::steady(cruise, true);
        let last = Ramp::new((&Motion::steady(cruise), &virtual_start), end, rules.deceleration, &jerk);
        let distance = distance.bits();
        let distances = first.distance.amount().bits() + last.distance.amount().bits();
        let step = cruise.amount().bits();
        // Times are rounded to 2⁻³² ticks.
        let rounded = (distances >> 40) + (1 << 40) + (step >> 31);
        prop_assert!(distances <= distance + rounded, "{distances} of {distance}");
        let left = distance.saturating_sub(distances);
        prop_assert!(
            cruise == rules.top || left <= (step >> 1) + rounded,
            "{left} of {distance} left at {cruise:?} of {:?}, down to {end:?}", rules.top
        );
    }
}

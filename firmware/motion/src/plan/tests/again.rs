//! Moves of limited jerk that are planned again and again.

use super::properties::{any_clock, magnitude, signed, usual_limits};
use super::sequences::part_of;
use super::{Goal, Limits, Plan, Ramps, amount, clock, per_second, state, steps};
use crate::Ticks;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// A sin² ramp of a few ticks is linear: it has no jerk by which its acceleration could be brought to zero.
#[cfg(feature = "sin-squared")]
#[test]
fn i01_a_linear_ramp_of_a_few_ticks_is_left_at_once_at_limited_jerk() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 100.into(),
        acceleration: 4_000_000_000,
        deceleration: 4_000_000_000,
    };
    let mut plan = Plan::at_rest(0, 0);
    for (at, ramps) in [(0, Ramps::SinSquared), (2, Ramps::JerkLimited(1_000))] {
        let goal = Goal::Velocity(100.into());
        plan.replan(clock, at, goal, limits, ramps).unwrap();
    }
    for t in (2..168_000_000).step_by(1_234_567) {
        let now = per_second(clock, plan.state_at(t));
        assert!((0.0..=100.001).contains(&now), "{now} at {t}");
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Planning again changes nothing, and neither does a velocity limit that is not reached: the orders differ, so that all is planned anew.
    #[test]
    fn i06_planning_a_jerk_limited_move_again_does_not_change_the_end(
        clock in any_clock(),
        v0 in signed(400_000),
        target in -2_000_000_000i64..2_000_000_000,
        limits in usual_limits(),
        jerk in magnitude(1_000, 200_000_000),
        higher in 0u32..1_000,
        mut cuts in prop::collection::vec(0u64..=1 << 32, 1..6),
    ) {
        let ramps = Ramps::JerkLimited(jerk);
        let most = limits.velocity.whole().min(400_000) as i32;
        let from = state(clock, 0, v0.max(-most).min(most));
        let Ok(first) = Plan::new(clock, 3, from, Goal::Rest(target), limits, ramps) else { return Ok(()) };
        let end = first.end().unwrap();
        let top = first.phases().map(|phase| per_second(clock, first.state_at(phase.start())).abs()).fold(0.0, f64::max);
        let is_reached = top >= amount(limits.velocity) * 0.999;
        cuts.sort_unstable();
        let mut plan = first;
        for (replans, cut) in (1u64..).zip(cuts) {
            let at = 3 + part_of(end - 3, cut);
            let before = plan.state_at(at);
            // To pass a target at no velocity is to stop there.
            let goal = if replans % 2 == 1 { Goal::Pass(target, 0.into()) } else { Goal::Rest(target) };
            let limits = match is_reached {
                true => limits,
                false => Limits { velocity: crate::Speed::from_bits(limits.velocity.bits() / 1_000 * u64::from(1_000 + higher)), ..limits },
            };
            plan.replan(clock, at, goal, limits, ramps).unwrap();
            let moved = plan.end().unwrap().abs_diff(end);
            // Velocities are rounded again: that shows in moves of hours.
            prop_assert!(moved <= 2 * replans + (end >> 28), "{moved} ticks after {replans}, cut at {at} of {end}");
            let now = plan.state_at(at);
            prop_assert!((now.position.bits() - before.position.bits()).abs() < 1 << 16, "position jumps");
            let there = steps(plan.state_at(Ticks::MAX));
            prop_assert_eq!(there, target as f64);
        }
    }
}

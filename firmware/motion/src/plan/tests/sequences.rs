//! The invariants for plans that are made anew on the way, again and again.

use super::properties::{any_clock, magnitude, signed, usual_limits};
use super::smooth::{all_over, goal, last};
use super::{Goal, Limits, Plan, Ramps, amount, per_second, state, steps};
use crate::{Position, State, Ticks, Velocity};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

fn any_ramps() -> impl Strategy<Value = Ramps> {
    prop_oneof![
        Just(Ramps::Linear),
        Just(Ramps::SinSquared),
        magnitude(1_000, u32::MAX).prop_map(Ramps::JerkLimited),
    ]
}

/// The ramps of each order: linear ones only, or any.
fn orders() -> impl Strategy<Value = Vec<(Goal, Ramps, u64)>> {
    let cut = || 0u64..=1 << 32;
    prop_oneof![
        prop::collection::vec((goal(), Just(Ramps::Linear), cut()), 1..8),
        prop::collection::vec((goal(), any_ramps(), cut()), 1..8),
    ]
}

fn part_of(length: Ticks, cut: u64) -> Ticks {
    ((u128::from(length) * u128::from(cut)) >> 32) as Ticks
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Velocity and acceleration stay within their limits, and position and velocity have no jump, for any sequence of goals and ramps at any
    /// ticks.
    #[test]
    fn i01_no_sequence_of_orders_exceeds_a_limit(
        clock in any_clock(),
        limits in usual_limits(),
        orders in orders(),
    ) {
        let hardest = f64::from(limits.acceleration.max(limits.deceleration));
        let top = amount(limits.velocity);
        let rate = f64::from(clock.hz());
        let is_linear = orders.iter().all(|(_, ramps, _)| *ramps == Ramps::Linear);
        let has_sine = orders.iter().any(|(_, ramps, _)| *ramps == Ramps::SinSquared);
        let most = if has_sine { hardest * core::f64::consts::FRAC_PI_2 } else { hardest };
        // See i01_smooth_limits_are_never_exceeded: a ramp is left at what the clock can represent at most.
        let most_jerk = rate.powi(3) / 2f64.powi(32);
        let beyond = if is_linear || 5.0 * hardest.powi(2) / top <= most_jerk { 0.0 } else { most * most / 2.0 / most_jerk };
        let mut plan = Plan::at_rest(0, 7);
        let mut at = 7;
        for (goal, ramps, cut) in orders {
            let before = plan.state_at(at);
            if plan.redirect(clock, at, goal, limits, ramps).is_err() {
                continue;
            }
            let now = plan.state_at(at);
            prop_assert!((now.position.bits() - before.position.bits()).abs() < 1 << 16, "position jumps");
            prop_assert!((per_second(clock, now) - per_second(clock, before)).abs() < 1e-3 + 1e-6 * top, "velocity jumps");
            for pair in all_over(&plan, clock, 64).windows(2) {
                let seconds = (pair[1] - pair[0]) as f64 / rate;
                let (v, w) = (per_second(clock, plan.state_at(pair[0])), per_second(clock, plan.state_at(pair[1])));
                prop_assert!(v.abs() <= top * (1.0 + 1e-6) + 1e-3 + beyond, "{v} of {top}");
                prop_assert!((w - v).abs() <= most * seconds * (1.0 + 1e-6) + 1e-3 + 1e-6 * top, "{v} to {w} in {seconds}");
            }
            at += part_of(last(&plan, clock).saturating_sub(at), cut);
        }
        // From anywhere, it lands.
        if plan.redirect(clock, at, Goal::Rest(777), limits, Ramps::Linear).is_ok() {
            let there = State { position: Position::from_steps(777), velocity: Velocity::ZERO };
            prop_assert_eq!(plan.state_at(Ticks::MAX), there);
        }
    }

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
            plan.redirect(clock, at, goal, limits, ramps).unwrap();
            let moved = plan.end().unwrap().abs_diff(end);
            // Velocities are rounded anew: that shows in moves of hours.
            prop_assert!(moved <= 2 * replans + (end >> 28), "{moved} ticks after {replans}, cut at {at} of {end}");
            let now = plan.state_at(at);
            prop_assert!((now.position.bits() - before.position.bits()).abs() < 1 << 16, "position jumps");
            let there = steps(plan.state_at(Ticks::MAX));
            prop_assert_eq!(there, target as f64);
        }
    }
}

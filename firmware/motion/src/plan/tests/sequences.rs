//! The invariants for plans that are made anew in motion, again and again.

use super::properties::{any_clock, usual_limits};
use super::smooth::{all_over, goal, last, smooth};
use super::{Goal, Plan, Ramps, amount, per_second};
use crate::{Position, State, Ticks, Velocity};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

fn any_ramps() -> impl Strategy<Value = Ramps> {
    prop_oneof![1 => Just(Ramps::Linear), 2 => smooth()]
}

/// The ramps of each order: linear ones only, or any.
fn orders() -> impl Strategy<Value = Vec<(Goal, Ramps, u64)>> {
    let cut = || 0u64..=1 << 32;
    prop_oneof![
        prop::collection::vec((goal(), Just(Ramps::Linear), cut()), 1..8),
        prop::collection::vec((goal(), any_ramps(), cut()), 1..8),
    ]
}

pub(super) fn part_of(length: Ticks, cut: u64) -> Ticks {
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
        let has_sine = orders.iter().any(|(_, ramps, _)| *ramps == Ramps::SinSquared);
        let most = if has_sine { hardest * core::f64::consts::FRAC_PI_2 } else { hardest };
        let mut plan = Plan::at_rest(0, 7);
        let mut at = 7;
        for (goal, ramps, cut) in orders {
            let before = plan.state_at(at);
            if plan.replan(clock, at, goal, limits, ramps).is_err() {
                continue;
            }
            let now = plan.state_at(at);
            prop_assert!((now.position.bits() - before.position.bits()).abs() < 1 << 16, "position jumps");
            prop_assert!((per_second(clock, now) - per_second(clock, before)).abs() < 1e-3 + 1e-6 * top, "velocity jumps");
            for pair in all_over(&plan, clock, 64).windows(2) {
                let seconds = (pair[1] - pair[0]) as f64 / rate;
                let (v, w) = (per_second(clock, plan.state_at(pair[0])), per_second(clock, plan.state_at(pair[1])));
                prop_assert!(v.abs() <= top * (1.0 + 1e-6) + 1e-3, "{v} of {top}");
                prop_assert!((w - v).abs() <= most * seconds * (1.0 + 1e-6) + 1e-3 + 1e-6 * top, "{v} to {w} in {seconds}");
            }
            at += part_of(last(&plan, clock).saturating_sub(at), cut);
        }
        // From anywhere, it lands.
        if plan.replan(clock, at, Goal::Rest(777), limits, Ramps::Linear).is_ok() {
            let there = State { position: Position::from_steps(777), velocity: Velocity::ZERO };
            prop_assert_eq!(plan.state_at(Ticks::MAX), there);
        }
    }
}

//! A motion that is planned while pulses are committed.

use super::behaviour::{T01, ms};
use super::{FAST, axis, run};
use crate::axis::Axis;
use crate::{Goal, Limits, Plan, Ramps};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::format;

fn ramps() -> impl Strategy<Value = Ramps> {
    (0..4, 20u32..32).prop_map(|(number, bits)| match number {
        0 => Ramps::Linear,
        1 => Ramps::SinSquared,
        2 => Ramps::MovingAverage(1 << bits),
        _ => Ramps::limited(1 << bits).unwrap_or(Ramps::SinSquared),
    })
}

/// All that an axis is.
fn all(axis: &Axis) -> std::string::String {
    format!("{axis:?}")
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Taken in time it is what is ordered then; otherwise nothing changes. Taking it changes nothing, and pulses and target stay one.
    #[test]
    fn a_draft_is_taken_in_time_or_not_at_all(
        (first, then, is_path) in (ramps(), ramps(), any::<bool>()),
        (target, next) in (-50_000i64..50_000, -50_000i64..50_000),
        (goal, refills) in (0u8..3, 0u32..2_000),
        limits in (1_000u32..500_000, 18u32..29, 18u32..29),
        meanwhile in 0u32..3,
    ) {
        let limits = Limits {
            velocity: limits.0.into(),
            acceleration: 1 << limits.1,
            deceleration: 1 << limits.2,
        };
        let (mut axis, mut sink) = axis(FAST);
        axis.set_ramps(first);
        if is_path {
            axis.follow_velocity(ms(10), 20_000.into()).unwrap();
        } else {
            axis.move_to(target, limits).unwrap();
        }
        for _ in 0..refills {
            axis.advance(&mut sink).unwrap();
            sink.play(ms(1) / 4);
        }
        let goal = match goal {
            0 => Goal::Velocity(0.into()),
            1 => Goal::Rest(next),
            _ => Goal::Pass(next, 10.into()),
        };
        let before = all(&axis);
        let mut draft = axis.draft(then);
        let mut plan = Plan::at_rest(0, 0);
        draft.plan(&mut plan, goal, limits).unwrap();
        prop_assert_eq!(&all(&axis), &before);
        let horizon = axis.horizon();
        for _ in 0..meanwhile {
            sink.play(ms(1) / 4);
            axis.advance(&mut sink).unwrap();
        }
        let mut twin = axis.clone();
        let is_taken = axis.install(&draft, &plan);
        prop_assert_eq!(is_taken, horizon == twin.horizon());
        if is_taken {
            twin.order(goal, limits, then).unwrap();
        }
        prop_assert_eq!(all(&axis), all(&twin));
        axis.stop(limits.deceleration).unwrap();
        let end = axis.target();
        run(&mut axis, &mut sink);
        prop_assert_eq!(sink.position, end);
        prop_assert_eq!(axis.committed_position(), end);
    }
}

/// With the refills above the tick it is for the next draft.
#[test]
fn who_was_overtaken_takes_another_draft() {
    let (mut axis, mut sink) = axis(FAST);
    axis.move_to(30_000, T01).unwrap();
    for _ in 0..400 {
        axis.advance(&mut sink).unwrap();
        sink.play(ms(1) / 4);
    }
    let plan = |axis: &Axis| {
        let (mut draft, mut plan) = (axis.draft(Ramps::Linear), Plan::at_rest(0, 0));
        draft.plan(&mut plan, Goal::Rest(25_000), T01).unwrap();
        (draft, plan)
    };
    let late = plan(&axis);
    axis.advance(&mut sink).unwrap();
    assert!(!axis.install(&late.0, &late.1));
    assert_eq!(axis.target(), 30_000);
    let next = plan(&axis);
    assert!(axis.install(&next.0, &next.1));
    assert_eq!(axis.target(), 25_000);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 25_000);
}

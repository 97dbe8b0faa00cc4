//! A stop that is only asked about.

use super::behaviour::{T01, ms};
use super::{FAST, axis};
use crate::{Limits, PlanError, Ramps};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

fn ramps() -> impl Strategy<Value = Ramps> {
    (0..4, 20u32..32).prop_map(|(number, bits)| match number {
        0 => Ramps::Linear,
        1 => Ramps::SinSquared,
        2 => Ramps::MovingAverage(1 << bits),
        _ => Ramps::limited(1 << bits).unwrap_or(Ramps::SinSquared),
    })
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() }))]

    /// It ends where the stop does that is ordered then, whatever is under way, and asking changes nothing.
    #[test]
    fn a_preview_is_where_the_stop_ends(
        (first, then) in (ramps(), ramps()),
        target in -100_000i64..100_000,
        limits in (10u32..500_000, 12u32..29, 12u32..29),
        refills in 0u32..2_000,
        deceleration in 12u32..29,
    ) {
        let limits = Limits {
            velocity: limits.0.into(),
            acceleration: 1 << limits.1,
            deceleration: 1 << limits.2,
        };
        let (mut axis, mut sink) = axis(FAST);
        axis.set_ramps(first);
        axis.move_to(target, limits).unwrap();
        for _ in 0..refills {
            axis.advance(&mut sink).unwrap();
            sink.play(ms(1) / 4);
        }
        let (before, ends) = (axis.target(), axis.plan.end());
        let told = axis.stop_preview(1 << deceleration, then, None);
        prop_assert_eq!((axis.target(), axis.plan.end()), (before, ends));
        axis.set_ramps(then);
        let result = axis.stop(1 << deceleration);
        prop_assert_eq!(told, result.map(|()| axis.target()));
    }
}

#[cfg(feature = "sin-squared")]
#[test]
fn a_ramp_that_is_left_ends_further_away_than_one_that_is_finished() {
    let (mut axis, mut sink) = axis(FAST);
    axis.set_ramps(Ramps::SinSquared);
    axis.move_to(50_000, T01).unwrap();
    // Braking for a tenth of a second.
    while axis.plan.last_ramp() + ms(100) > axis.horizon() {
        axis.advance(&mut sink).unwrap();
        sink.play(ms(1) / 4);
    }
    let end = |leaves| axis.stop_preview(T01.deceleration, Ramps::SinSquared, leaves);
    assert_eq!(end(None), Ok(50_000));
    assert!(end(Some(&T01)).unwrap() > 50_100);
    let none = axis.stop_preview(0, Ramps::SinSquared, Some(&T01));
    assert_eq!(none, Err(PlanError::ZeroDeceleration));
}

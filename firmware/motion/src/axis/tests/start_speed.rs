//! Moves that begin and end with a speed which the motor takes and loses at once.

use super::behaviour::{T01, fly, ms};
use super::replay::Replay;
use super::{FAST, HZ, axis, run};
use crate::axis::Axis;
use crate::{Limits, PlanError, Ramps, Speed};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

fn order(
    axis: &mut Axis,
    sink: &mut Replay,
    (target, speed): (i64, u32),
    (limits, ramps): (Limits, Ramps),
) -> Result<(), PlanError> {
    axis.order_from_start_speed((target, Speed::per_second(speed)), limits, ramps)?;
    sink.follow(axis);
    Ok(())
}

/// A move from rest that has been played: how long it took.
fn moved(target: i64, speed: u32, limits: Limits, ramps: Ramps) -> u64 {
    let (mut axis, mut sink) = axis(FAST);
    order(&mut axis, &mut sink, (target, speed), (limits, ramps)).unwrap();
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, target);
    assert_eq!(sink.pulses, target.unsigned_abs(), "no step too many");
    sink.ticks
}

/// 2·(v − s)/a for the ramps, and v for what they leave of the way.
#[test]
fn a_move_takes_as_long_as_the_trapezoid_upon_its_start_speed() {
    let limits = Limits {
        velocity: 20_000.into(),
        acceleration: 100_000,
        deceleration: 100_000,
    };
    for target in [10_000, -10_000] {
        let time = moved(target, 10_000, limits, Ramps::Linear);
        // Two ramps of 0.1 s and 1500 steps, and 7000 steps at 20,000 steps/s.
        let exact = u64::from(HZ) * 55 / 100;
        assert!(time.abs_diff(exact) <= 20_000, "{time} and not {exact}");
    }
    // sin² ramps take as long, and as far.
    let smooth = moved(10_000, 10_000, limits, Ramps::SinSquared);
    assert!(
        smooth.abs_diff(u64::from(HZ) * 55 / 100) <= 20_000,
        "{smooth}"
    );
    // Without a start speed it is the move that it always was.
    let plain = moved(10_000, 0, limits, Ramps::Linear);
    assert!(plain.abs_diff(u64::from(HZ) * 7 / 10) <= 20_000, "{plain}");
}

/// A profile velocity below the start speed is kept all the way.
#[test]
fn a_slow_move_has_no_ramps() {
    let limits = Limits {
        velocity: 1_000.into(),
        ..T01
    };
    let time = moved(500, 10_000, limits, Ramps::Linear);
    assert!(time.abs_diff(u64::from(HZ) / 2) <= 200_000, "{time}");
    // One step is a step.
    moved(1, 10_000, T01, Ramps::Linear);
    moved(-2, 10_000, T01, Ramps::Linear);
}

/// Away from the target, or too near to it, there is a ramp to rest.
#[test]
fn a_target_that_is_overshot_is_come_back_to() {
    let (mut axis, mut sink) = axis(FAST);
    order(&mut axis, &mut sink, (100_000, 5_000), (T01, Ramps::Linear)).unwrap();
    fly(&mut axis, &mut sink, ms(500));
    order(&mut axis, &mut sink, (100, 5_000), (T01, Ramps::Linear)).unwrap();
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 100);
}

/// A refused move leaves the motion as it was.
#[test]
fn a_move_that_cannot_be_changes_nothing() {
    let (mut axis, mut sink) = axis(FAST);
    let none = Limits {
        acceleration: 0,
        ..T01
    };
    let refused = order(&mut axis, &mut sink, (100, 50), (none, Ramps::Linear));
    assert_eq!(refused, Err(PlanError::ZeroAcceleration));
    assert!(axis.is_at_rest());
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Whatever the axis does, and wherever the target is, it stands there at the end.
    #[test]
    fn every_move_ends_at_its_target(
        (first, next) in (-20_000i64..20_000, -20_000i64..20_000),
        (speed, again) in (0u32..30_000, 0u32..30_000),
        limits in (500u32..100_000, 14u32..24, 14u32..24),
        (refills, is_smooth) in (0u32..2_000, any::<bool>()),
    ) {
        let limits = Limits {
            velocity: limits.0.into(),
            acceleration: 1 << limits.1,
            deceleration: 1 << limits.2,
        };
        let ramps = if is_smooth { Ramps::SinSquared } else { Ramps::Linear };
        let (mut axis, mut sink) = axis(FAST);
        sink.sparse = true;
        order(&mut axis, &mut sink, (first, speed), (limits, ramps)).unwrap();
        for _ in 0..refills {
            axis.advance(&mut sink).unwrap();
            sink.play(ms(1) / 4);
        }
        order(&mut axis, &mut sink, (next, again), (limits, ramps)).unwrap();
        run(&mut axis, &mut sink);
        prop_assert_eq!(sink.position, next);
        prop_assert_eq!(axis.committed_position(), next);
    }
}

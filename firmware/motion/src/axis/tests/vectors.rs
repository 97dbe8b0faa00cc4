//! The pulse trains of the reference vectors: the net count is the distance, the ticks are the duration.

use super::{Replay, run};
use crate::axis::{Axis, AxisConfig};
use crate::vectors::a_move;
use crate::{Clock, DriverTiming, Limits, Plan, Position, State, Velocity};

/// Plays the train of a vector. `time_slice` in microseconds: long moves are played in long time slices to save time.
fn play(id: &str, hz: u32, time_slice: u32) {
    let v = a_move(id);
    let clock = Clock::new(hz).unwrap();
    let timing = DriverTiming {
        pulse_high: hz / 10_000_000,
        pulse_low: hz / 10_000_000,
        direction_setup: 4,
        direction_hold: 4,
    };
    let mut axis = Axis::new(AxisConfig {
        clock,
        time_slice: hz / 1_000_000 * time_slice,
        timing,
    });
    let mut sink = Replay::new(timing, axis.stepper.time_slice().into());
    sink.sparse = v.distance > 1_000_000_000;
    sink.capacity = 4096;
    if v.velocity > 1_000_000 {
        // Pulses may be off by a step there, and whole steps are half a step off in any case.
        sink.tolerance = 1.5;
    }

    let origin = if v.distance > i64::from(i32::MAX) {
        i64::from(i32::MIN)
    } else {
        0
    };
    let limits = Limits {
        velocity: v.velocity.into(),
        acceleration: v.acceleration,
        deceleration: v.deceleration,
    };
    let from = State {
        position: Position::from_steps(origin),
        velocity: Velocity::from_speed(clock, v.v0.into()),
    };
    axis.set_position(origin);
    sink.position = origin;
    axis.plan = Plan::move_to(clock, 0, from, origin + v.distance, limits).unwrap();
    let end = axis.plan.end().unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);

    assert_eq!(sink.position, origin + v.distance, "{}", v.name);
    assert_eq!(axis.committed_position(), origin + v.distance);
    assert_eq!(sink.ticks, end, "{}", v.name);
    let late = end as f64 - v.duration * f64::from(hz);
    assert!(
        (-0.1..=1.1).contains(&late) || late.abs() < 1e-9 * end as f64,
        "{}: {late}",
        v.name
    );
    let turns = v.highest.max(-v.lowest) - v.distance.unsigned_abs() as f64;
    if turns == 0.0 && v.lowest * v.highest == 0.0 {
        assert_eq!(
            sink.pulses,
            v.distance.unsigned_abs(),
            "{}: a pulse back and forth",
            v.name
        );
    }
}

macro_rules! trains {
    ($($name:ident = $id:literal, [$($hz:literal),*], $time_slice:literal us; )*) => {
        $(#[test] fn $name() { $(play($id, $hz, $time_slice);)* })*
    };
}

trains! {
    t01_train = "T01", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t02_train = "T02", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t03_train = "T03", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t04_train = "T04", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t05_train = "T05", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t06_train = "T06", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t07_train = "T07", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t08_train = "T08", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t09_train = "T09", [1_000_000_000], 20_000 us;
    t10_train = "T10", [1_000_000_000], 4_000 us;
    t11_train = "T11", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t12_train = "T12", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t13_train = "T13", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t14_train = "T14", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t15_train = "T15", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t16_train = "T16", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t17_train = "T17", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t18_train = "T18", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t19_train = "T19", [168_000_000], 100_000 us;
    t20_train = "T20", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t21_train = "T21", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
    t22_train = "T22", [84_000_000, 168_000_000, 1_000_000_000], 250 us;
}

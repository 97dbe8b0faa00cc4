//! What an axis does, one subject per test.

use super::{FAST, HZ, Replay, SLOW, axis, run};
use crate::axis::{AdvanceError, Axis};
use crate::{Limits, Plan, PlanError, PulseSink, Speed};

pub(super) const T01: Limits = Limits {
    velocity: Speed::per_second(100_000),
    acceleration: 500_000,
    deceleration: 500_000,
};

/// Ticks of so many milliseconds.
pub(super) fn ms(milliseconds: u64) -> u64 {
    milliseconds * u64::from(HZ) / 1000
}

pub(super) fn command(axis: &mut Axis, sink: &mut Replay, target: i64, limits: Limits) {
    axis.move_to(target, limits).unwrap();
    sink.follow(axis);
}

/// Runs for some time and leaves what is pending in the sink.
pub(super) fn fly(axis: &mut Axis, sink: &mut Replay, ticks: u64) {
    let until = sink.ticks - sink.pending() + ticks;
    while sink.ticks - sink.pending() < until && !axis.is_at_rest() {
        axis.advance(sink).unwrap();
        sink.account(axis);
        sink.play(u64::from(axis.stepper.time_slice() / 2));
    }
}

#[test]
fn an_axis_at_rest_emits_nothing() {
    let (mut axis, mut sink) = axis(FAST);
    for _ in 0..10 {
        axis.advance(&mut sink).unwrap();
    }
    assert_eq!(sink.records, 0);
    assert!(axis.is_at_rest());
    // Neither does a move to where it stands.
    axis.move_to(0, T01).unwrap();
    assert!(axis.is_at_rest());
    axis.advance(&mut sink).unwrap();
    assert_eq!(sink.records, 0);
}

#[test]
fn a_move_begins_when_it_is_commanded() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 1000, T01);
    run(&mut axis, &mut sink);
    let first = sink.ticks;
    // However long the axis stood: the records go on where they ended.
    for _ in 0..1000 {
        axis.advance(&mut sink).unwrap();
    }
    command(&mut axis, &mut sink, 2000, T01);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 2000);
    // The second move takes as long as the first, to the tick.
    assert_eq!(sink.ticks - first, first);
}

#[test]
fn two_time_slices_are_committed_and_little_more() {
    let (mut axis, mut sink) = axis(FAST);
    let time_slice = u64::from(axis.stepper.time_slice());
    for velocity in [100_000, 10_000, 500] {
        command(
            &mut axis,
            &mut sink,
            1_000_000,
            Limits {
                velocity: velocity.into(),
                ..T01
            },
        );
        for _ in 0..400 {
            axis.advance(&mut sink).unwrap();
            assert!(sink.pending() >= 2 * time_slice);
            assert!(
                sink.pending() <= 3 * time_slice + 100,
                "{} pending",
                sink.pending()
            );
            // A command now takes effect at the horizon: within 0.75 ms.
            assert!(axis.horizon() - (sink.ticks - sink.pending()) <= 3 * time_slice + 100);
            sink.play(time_slice / 4);
        }
    }
}

#[test]
fn r1_target_moved_behind_in_full_flight() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 100_000, T01);
    fly(&mut axis, &mut sink, ms(500));
    let horizon = axis.horizon();
    let turn = axis.plan.state_at(horizon).position.whole_steps() + 10_000;
    command(&mut axis, &mut sink, 20_000, T01);
    let mut highest = 0;
    while !axis.is_at_rest() {
        axis.advance(&mut sink).unwrap();
        sink.account(&axis);
        highest = highest.max(sink.position);
        sink.play(axis.stepper.time_slice().into());
    }
    assert_eq!(sink.position, 20_000);
    assert!(
        (highest - turn).abs() <= 1,
        "turned at {highest}, not {turn}"
    );
}

#[test]
fn r2_velocity_lowered_on_the_way() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 100_000, T01);
    fly(&mut axis, &mut sink, ms(100));
    command(
        &mut axis,
        &mut sink,
        100_000,
        Limits {
            velocity: 25_000.into(),
            ..T01
        },
    );
    run(&mut axis, &mut sink);
    assert_eq!((sink.position, sink.pulses), (100_000, 100_000));
}

#[test]
fn r3_halt_and_go_on() {
    let (mut axis, mut sink) = axis(FAST);
    axis.ramp_to(100_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, ms(300));
    let before = axis.plan.state_at(axis.horizon()).position.whole_steps();
    axis.stop(500_000).unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    assert!((sink.position - before - 10_000).abs() <= 1);
    assert_eq!(axis.target(), sink.position);
    axis.ramp_to(100_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, ms(250));
    let velocity = axis.demand(sink.pending()).velocity;
    assert!(velocity.is_close_to(100_000.into()));
}

#[test]
fn a_stop_rests_on_a_whole_step_and_loses_none() {
    let (mut axis, mut sink) = axis(FAST);
    for (target, after) in [(7_777, 33), (-3_333, 41), (123_457, 97), (0, 211)] {
        command(
            &mut axis,
            &mut sink,
            target,
            Limits {
                velocity: 33_333.into(),
                ..T01
            },
        );
        fly(&mut axis, &mut sink, ms(after));
        axis.stop(1_234_567).unwrap();
        sink.follow(&axis);
        run(&mut axis, &mut sink);
        assert_eq!(axis.target(), sink.position);
        assert_eq!(
            axis.plan.state_at(axis.horizon()).position.bits(),
            sink.position << 32
        );
        assert_eq!(
            axis.demand(0),
            crate::Demand {
                position: sink.position,
                velocity: 0.into()
            }
        );
    }
    command(&mut axis, &mut sink, 1, T01);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 1);
}

#[test]
fn direction_changes_keep_setup_and_hold() {
    // Longer times than any driver has, so that they are felt: pulses lag by many steps at a turn.
    let timing = crate::DriverTiming {
        direction_setup: 30_000,
        direction_hold: 40_000,
        ..SLOW
    };
    let (mut axis, mut sink) = axis(timing);
    sink.tolerance = 500.0;
    let sharp = Limits {
        velocity: 200_000.into(),
        acceleration: 400_000_000,
        deceleration: 400_000_000,
    };
    for target in [10, -10, 1, 0, -1, 500, 0] {
        command(&mut axis, &mut sink, target, sharp);
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, target);
    }
}

#[test]
fn pulses_that_the_driver_cannot_take_lag_and_are_not_lost() {
    let (mut axis, mut sink) = axis(SLOW);
    assert_eq!(axis.max_velocity(), (HZ / 640).into());
    // Past the check of the axis: a plan for twice what the driver can take.
    let limits = Limits {
        velocity: 525_000.into(),
        acceleration: 50_000_000,
        deceleration: 50_000_000,
    };
    let from = crate::State::default();
    axis.plan = Plan::move_to(axis.clock, 0, from, 20_000, limits).unwrap();
    run(&mut axis, &mut sink);
    assert_eq!((sink.position, sink.pulses), (20_000, 20_000));
    // At the driver's highest rate, but for the ramp at the start.
    assert!(
        sink.ticks >= 20_000 * 640 && sink.ticks <= 20_800 * 640,
        "{}",
        sink.ticks
    );
}

#[test]
fn a_limit_above_the_driver_is_cut() {
    let (mut axis, mut sink) = axis(SLOW);
    let limits = Limits {
        velocity: u32::MAX.into(),
        acceleration: 5_000_000,
        deceleration: 5_000_000,
    };
    command(&mut axis, &mut sink, 200_000, limits);
    run(&mut axis, &mut sink);
    assert_eq!(sink.pulses, 200_000);
    assert!(sink.worst <= 1.0);
}

#[test]
fn a_full_sink_loses_nothing() {
    let (mut axis, mut sink) = axis(FAST);
    sink.capacity = 3;
    command(&mut axis, &mut sink, 5_000, T01);
    let mut refused = 0;
    while !axis.is_at_rest() {
        match axis.advance(&mut sink) {
            Ok(()) => {}
            Err(AdvanceError::SinkFull) => refused += 1,
            Err(error) => panic!("{error}"),
        }
        sink.account(&axis);
        sink.play(u64::from(axis.stepper.time_slice() / 8));
    }
    assert!(refused > 10);
    assert_eq!((sink.position, sink.pulses), (5_000, 5_000));
}

#[test]
fn an_underrun_is_reported_and_loses_nothing() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 5_000, T01);
    axis.advance(&mut sink).unwrap();
    sink.play_out();
    assert_eq!(axis.advance(&mut sink), Err(AdvanceError::Underrun));
    // It is over: once reported, it goes on.
    assert_eq!(axis.advance(&mut sink), Ok(()));
    run(&mut axis, &mut sink);
    assert_eq!((sink.position, sink.pulses), (5_000, 5_000));
    // The end of a motion is no underrun.
    assert_eq!(axis.advance(&mut sink), Ok(()));
}

#[test]
fn an_abort_stands_where_the_pulses_are() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, -50_000, T01);
    fly(&mut axis, &mut sink, ms(150));
    let stood = axis.abort();
    assert_eq!(stood, sink.position);
    assert!(axis.is_at_rest());
    assert_eq!(axis.target(), stood);
    assert_eq!(
        axis.demand(0),
        crate::Demand {
            position: stood,
            velocity: 0.into()
        }
    );
    let records = sink.records;
    axis.advance(&mut sink).unwrap();
    assert_eq!(sink.records, records);

    // The sink was cleared; the motor is somewhere else.
    sink.clear();
    axis.set_position(-4_321);
    sink.position = -4_321;
    command(&mut axis, &mut sink, 100, T01);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 100);
}

#[test]
fn a_refused_command_changes_nothing() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 5_000, T01);
    fly(&mut axis, &mut sink, ms(20));
    assert_eq!(
        axis.move_to(
            0,
            Limits {
                velocity: Speed::ZERO,
                ..T01
            }
        ),
        Err(PlanError::ZeroVelocity)
    );
    assert_eq!(
        axis.move_to(
            0,
            Limits {
                acceleration: 0,
                ..T01
            }
        ),
        Err(PlanError::ZeroAcceleration)
    );
    assert_eq!(
        axis.move_to(
            0,
            Limits {
                deceleration: 0,
                ..T01
            }
        ),
        Err(PlanError::ZeroDeceleration)
    );
    assert_eq!(axis.move_to(1 << 33, T01), Err(PlanError::OutOfRange));
    assert_eq!(axis.stop(0), Err(PlanError::ZeroDeceleration));
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 5_000);
}

#[test]
fn the_demand_is_what_is_being_played() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 30_000, T01);
    while !axis.is_at_rest() || sink.pending() > 0 {
        axis.advance(&mut sink).unwrap();
        let played = sink.ticks - sink.pending();
        let demand = axis.demand(sink.pending());
        let planned = sink.curves[0].state_at(played);
        assert!((demand.position - planned.position.whole_steps()).abs() <= 1);
        let velocity = planned.velocity.speed(axis.clock);
        // Between two points of the trace the velocity is a straight line; at corners it is cut.
        assert!(
            demand.velocity.abs_diff(velocity) <= 70.into(),
            "{demand:?} for {velocity:?}"
        );
        sink.play(12_345);
    }
    assert_eq!(
        axis.demand(0),
        crate::Demand {
            position: 30_000,
            velocity: 0.into()
        }
    );
}

#[test]
fn pulses_are_in_the_middle_between_steps() {
    let (mut axis, mut sink) = axis(FAST);
    command(&mut axis, &mut sink, 100_000, T01);
    run(&mut axis, &mut sink);
    command(&mut axis, &mut sink, 0, T01);
    run(&mut axis, &mut sink);
    // Half a step is what a step is wide; the rest is chords and ticks.
    assert!(sink.worst <= 0.51, "{} steps off", sink.worst);
}

#[test]
fn four_million_steps_per_second_stay_within_a_microsecond_and_their_rounding() {
    let (mut axis, mut sink) = axis(FAST);
    // Whole steps are half a step off in any case, and a ramp by a quarter from its chords.
    sink.tolerance = 4.75;
    let limits = Limits {
        velocity: 4_000_000.into(),
        acceleration: 20_000_000,
        deceleration: 10_000_000,
    };
    command(&mut axis, &mut sink, 1_500_000, limits);
    run(&mut axis, &mut sink);
    assert_eq!(sink.pulses, 1_500_000);
}

#[test]
fn one_step_per_second_to_a_million() {
    for (velocity, steps) in [
        (1, 3),
        (50, 60),
        (2_500, 3_000),
        (50_000, 60_000),
        (500_000, 300_000),
        (1_000_000, 800_000),
    ] {
        for steps in [steps, -steps] {
            let (mut axis, mut sink) = axis(FAST);
            let limits = Limits {
                velocity: velocity.into(),
                acceleration: 5_000_000,
                deceleration: 5_000_000,
            };
            command(&mut axis, &mut sink, steps, limits);
            let end = axis.plan.end().unwrap();
            run(&mut axis, &mut sink);
            assert_eq!((sink.position, sink.pulses), (steps, steps.unsigned_abs()));
            assert_eq!(sink.ticks, end);
            // Half a step is what a step is wide. A tenth for chords, a quarter at a million steps per second.
            let most = if velocity > 500_000 { 0.75 } else { 0.6 };
            assert!(sink.worst <= most, "{} steps off", sink.worst);
        }
    }
}

//! sin² ramps that are left before their end.

use super::smooth::{all_over, assert_no_jump};
use super::{Goal, Limits, Plan, Ramps, clock, per_second, state};
use crate::Ticks;

#[test]
fn i01_a_short_sine_ramp_that_is_left_stays_within_its_velocity() {
    let clock = clock(84_000_000);
    let limits = Limits {
        velocity: 1.into(),
        acceleration: 89_253,
        deceleration: 89_253,
    };
    for at in (0..=941).step_by(47) {
        let mut plan = Plan::at_rest(0, 0);
        for (at, goal) in [(0, 1), (at, 0)] {
            let goal = Goal::Velocity(goal.into());
            plan.replan(clock, at, goal, limits, Ramps::SinSquared)
                .unwrap();
        }
        for t in at..2_000 {
            let now = per_second(clock, plan.state_at(t));
            assert!((-1e-6..=1.0 + 1e-6).contains(&now), "{now} at {t}");
        }
    }
}

/// A quick stop must not wait for the jerk of the gentle ramp that it ends, nor for that ramp if it is a stop itself.
#[test]
fn i08_a_hard_stop_ends_a_gentle_sine_ramp_in_time() {
    let clock = clock(168_000_000);
    let stop = Goal::Velocity(0.into());
    let gentle = Limits {
        velocity: 1_000_000.into(),
        acceleration: 16_384,
        deceleration: 16_384,
    };
    let hard = Limits {
        velocity: 0.into(),
        acceleration: 0,
        deceleration: 2_000_000,
    };
    let orders = [
        (Goal::Velocity(200_000.into()), 1_000),
        (Goal::Velocity((-200_000).into()), 5_000),
        (Goal::Velocity(150_000.into()), 8_000),
        // Braking, to a target and to a stop.
        (Goal::Rest(500_000), 7_000),
        (Goal::Rest(-500_000), 10_000),
        (stop, 4_000),
    ];
    for (goal, millis) in orders {
        let mut plan = Plan::at_rest(0, 0);
        let mut begin = 0;
        if goal == stop {
            plan.replan(
                clock,
                0,
                Goal::Velocity(100_000.into()),
                gentle,
                Ramps::SinSquared,
            )
            .unwrap();
            begin = plan.phases().last().unwrap().start();
        }
        plan.replan(clock, begin, goal, gentle, Ramps::SinSquared)
            .unwrap();
        let at = begin + millis * 168_000;
        let speed = per_second(clock, plan.state_at(at)).abs();
        assert!(speed > 1_000.0, "{speed} steps/s for {goal:?}");
        plan.replan(clock, at, stop, hard, Ramps::SinSquared)
            .unwrap();
        let seconds = (plan.end().unwrap() - at) as f64 / f64::from(clock.hz());
        let linear = speed / f64::from(hard.deceleration);
        assert!(
            seconds <= 2.0 * linear,
            "{seconds} s from {speed} steps/s after {goal:?}, {linear} s with a linear ramp"
        );
        assert_no_jump(&plan);
    }
}

#[test]
fn i01_a_sine_ramp_between_two_velocities_that_is_left_stays_within_its_velocity() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 100_000.into(),
        acceleration: 500_000,
        deceleration: 500_000,
    };
    for (from, to) in [(80_000, 100_000), (99_000, 100_000), (-20_000, 100_000)] {
        for part in 1..16u64 {
            let mut plan =
                Plan::velocity(clock, 0, state(clock, 0, from), from.into(), limits).unwrap();
            let mut order = |at, goal: i32| {
                let goal = Goal::Velocity(goal.into());
                plan.replan(clock, at, goal, limits, Ramps::SinSquared)
                    .unwrap();
                plan.clone()
            };
            let ramp = order(0, to).phases().last().unwrap().start();
            let at = ramp * part / 16;
            let plan = order(at, 0);
            let before = per_second(clock, plan.state_at(at));
            for t in all_over(&plan, clock, 200) {
                let now = per_second(clock, plan.state_at(t));
                assert!(
                    now <= 100_000.0 + 1e-3,
                    "{now} after {before}, from {from} to {to}, left at {part}/16"
                );
            }
        }
    }
}

/// A new target in each millisecond of a ramp: it is finished all the same, and the move ends as if the last target had been known from the begin.
#[test]
fn i06_targets_that_stream_in_do_not_slow_a_sine_ramp_down() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 100_000.into(),
        acceleration: 500_000,
        deceleration: 500_000,
    };
    let order = |plan: &mut Plan, at, target| {
        plan.replan(clock, at, Goal::Rest(target), limits, Ramps::SinSquared)
            .unwrap();
    };
    let mut direct = Plan::at_rest(0, 0);
    order(&mut direct, 0, 90_000);
    let mut plan = Plan::at_rest(0, 0);
    for number in 0..=500 {
        order(&mut plan, number * 168_000, 89_500 + number as i64);
    }
    let moved = plan.end().unwrap().abs_diff(direct.end().unwrap());
    assert!(moved <= 500, "{moved} ticks");
    assert_no_jump(&plan);
    // Braking for a target that goes away: it brakes once more, from the velocity that it has then.
    let at = plan.last_ramp() + 16_800_000;
    order(&mut plan, at, 95_000);
    assert_no_jump(&plan);
    let there = plan.state_at(plan.end().unwrap());
    assert_eq!(there, state(clock, 95_000, 0));
}

/// Braking for a target, with limits that are harder or gentler than before: that braking is finished.
#[cfg(feature = "sin-squared")]
#[test]
fn i06_sine_braking_for_its_target_is_finished_whatever_the_limits() {
    let clock = clock(168_000_000);
    let mut limits = Limits {
        velocity: 100_000.into(),
        acceleration: 500_000,
        deceleration: 500_000,
    };
    let goal = Goal::Rest(50_000);
    let first = Plan::new(
        clock,
        0,
        state(clock, 0, 0),
        goal,
        limits,
        Ramps::SinSquared,
    )
    .unwrap();
    for deceleration in [1_000, 499_999, 500_001, 5_000_000] {
        for part in 1..16 {
            let mut plan = first.clone();
            let braking = first.end().unwrap() - first.last_ramp();
            limits.deceleration = deceleration;
            let at = first.last_ramp() + braking * part / 16;
            plan.replan(clock, at, goal, limits, Ramps::SinSquared)
                .unwrap();
            assert_eq!(plan.end(), first.end());
            assert_eq!(plan.state_at(Ticks::MAX), state(clock, 50_000, 0));
            let apart =
                plan.state_at(at + 1).position.bits() - first.state_at(at + 1).position.bits();
            assert!(apart.abs() < 1 << 12, "{apart}");
        }
    }
}

/// Its last bits, times the square of the ticks that its acceleration takes to go, would be a part of a step.
#[test]
fn i01_a_ramp_of_hours_is_left_without_a_jump() {
    let clock = clock(84_000_000);
    let limits = Limits {
        velocity: 480_000.into(),
        acceleration: 11,
        deceleration: 124,
    };
    let keep = Goal::Velocity((-330_000).into());
    let mut plan = Plan::at_rest(0, 7);
    plan.replan(clock, 7, keep, limits, Ramps::SinSquared)
        .unwrap();
    for at in all_over(&plan, clock, 100) {
        for target in [0, -2_000_000_000] {
            let mut left = plan.clone();
            left.replan(clock, at, Goal::Rest(target), limits, Ramps::SinSquared)
                .unwrap();
            let jump = left.state_at(at).position.bits() - plan.state_at(at).position.bits();
            assert!(jump.abs() <= 1, "by {jump} at {at}");
        }
    }
}

//! Smooth moves at the ends of the span of 2³² steps, and what lies out of range.

use super::smooth::{assert_no_jump, double_s};
use super::{Goal, Limits, Plan, Ramps, clock, per_second, state, steps};
use crate::exact::{Q96, Q128};
use crate::plan::InitialState;
use crate::{PlanError, Position, State};

#[test]
fn i02_a_move_over_the_whole_span_makes_no_extra_turn() {
    let clock = clock(168_000_000);
    for (velocity, acceleration, deceleration, jerk, short) in [
        (100_000u32, 1, 1, 1, 0),
        (100_000, 1, 1, 1_000, 0),
        (1_000_000, 3, 3, 77, 63),
        (1_000_000, 100, 100, 100, 0),
        (4_000_000, 1_000, 1_000, 1_000, 0),
        (100_000, 1, 3, 5, 0),
        (100_000, 3, 1, 5, 0),
    ] {
        let limits = Limits {
            velocity: velocity.into(),
            acceleration,
            deceleration,
        };
        let (from, target) = (-(1i64 << 31), (1i64 << 31) - 1 - short);
        let rest = state(clock, from, 0);
        let ramps = Ramps::JerkLimited(jerk);
        let plan = Plan::new(clock, 0, rest, Goal::Rest(target), limits, ramps).unwrap();
        assert_no_jump(&plan);
        let seconds = plan.end().unwrap() as f64 / f64::from(clock.hz());
        let ideal = double_s((target - from) as f64, limits, jerk.into());
        // A ramp beyond 2³¹ steps is slower than it might be; an extra turn takes half as long again.
        let part = if acceleration == deceleration {
            1e-5
        } else {
            0.1
        };
        assert!(
            seconds >= ideal * (1.0 - 1e-6) && seconds <= ideal * (1.0 + part),
            "{seconds} s of {ideal} s at {acceleration}, {deceleration}, {jerk}"
        );
        assert_eq!(
            plan.state_at(plan.end().unwrap()).position,
            Position::from_steps(target)
        );
    }
}

/// Braking hard, and just then allowed to brake but softly.
#[test]
fn i02_a_softer_deceleration_while_braking_is_no_reason_to_refuse() {
    let clock = clock(168_000_000);
    let limits = |deceleration| Limits {
        velocity: 2_000_000.into(),
        acceleration: 1_000_000,
        deceleration,
    };
    let ramps = Ramps::JerkLimited(5_050_000);
    // From 2,000,000 steps/s at 1,000,000 steps/s²: the acceleration begins to fall at 99,010 steps/s.
    let start = start(state(clock, 0, 2_000_000), Q96::ZERO);
    let mut braking = Plan::at_rest(0, 0);
    braking
        .make(
            clock,
            &start,
            Goal::Velocity(0.into()),
            limits(1_000_000),
            ramps,
        )
        .unwrap();
    let at = braking.phases().last().unwrap().start() - 168_000;
    let velocity = per_second(clock, braking.state_at(at));
    assert!((velocity - 100_010.0).abs() < 1.0, "{velocity}");
    let here = steps(braking.state_at(at)) as i64;
    for deceleration in [1, 2, 5, 9] {
        for target in [here + 1_000_000, here + 100, here - 1_000_000] {
            for goal in [Goal::Rest(target), Goal::Pass(target, 500.into())] {
                let mut plan = braking.clone();
                plan.replan(clock, at, goal, limits(deceleration), ramps)
                    .unwrap();
                assert_no_jump(&plan);
                if let Some(end) = plan.end() {
                    assert_eq!(plan.state_at(end).position, Position::from_steps(target));
                }
            }
        }
    }
}

/// A motion with an acceleration, which came about at whatever jerk.
fn start(from: State, acceleration: Q96) -> InitialState {
    let mut start = InitialState::steady(0, from.into());
    start.accelerate(acceleration, Q128::ZERO);
    start
}

/// Whether a motion that must brake and come back can be planned; and if so, that it lands on its target.
fn is_possible((velocity, acceleration): (i32, u32), target: i64, deceleration: u32) -> bool {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 2_000_000.into(),
        acceleration: 1_000_000,
        deceleration,
    };
    let acceleration = clock.half_acceleration(acceleration).doubled().forwards();
    let start = start(state(clock, 0, velocity), -acceleration);
    let mut plan = Plan::at_rest(0, 0);
    let goal = Goal::Rest(target);
    let made = plan.make(clock, &start, goal, limits, Ramps::JerkLimited(5_050_000));
    if let Err(error) = made {
        assert_eq!(error, PlanError::OutOfRange);
        return false;
    }
    assert_no_jump(&plan);
    let there = plan.state_at(plan.end().unwrap());
    assert_eq!(there.position, Position::from_steps(target));
    true
}

#[test]
fn i02_braking_is_out_of_range_from_half_the_span_on() {
    // v²/2a is 2³¹ steps at 65,536 steps/s.
    for target in [10, -10] {
        assert!(is_possible((65_500, 0), target, 1));
        assert!(is_possible((65_534, 0), target, 1));
        assert!(!is_possible((65_537, 0), target, 1));
        assert!(!is_possible((65_600, 0), target, 1));
    }
    // Most of the velocity goes while the acceleration falls to the limit: 99,010 steps/s, over 20,000 steps.
    for (left, expected) in [
        (10, true),
        (1_000, true),
        (65_500, true),
        (65_534, true),
        (65_537, false),
        (65_600, false),
        // Once round the span, and on.
        (92_682, false),
        (92_700, false),
        (131_100, false),
    ] {
        let from = (left + 99_010, 1_000_000);
        assert_eq!(is_possible(from, 10, 1), expected, "{left} steps/s");
    }
}

/// The ramp whose rest the braking is began so long ago that all of it is longer than 2³¹ steps.
#[test]
fn i02_braking_that_began_long_ago_lands_on_its_target() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 2_000_000.into(),
        acceleration: 1_000,
        deceleration: 1_000,
    };
    let acceleration = clock.half_acceleration(1_000).doubled().forwards();
    for target in [1_300_000_000, 1_500_000_000, 2_000_000_000, 2_100_000_000] {
        let start = start(state(clock, 0, 1_500_000), -acceleration);
        let mut plan = Plan::at_rest(0, 0);
        plan.make(
            clock,
            &start,
            Goal::Rest(target),
            limits,
            Ramps::JerkLimited(1),
        )
        .unwrap();
        assert_no_jump(&plan);
        let there = plan.state_at(plan.end().unwrap());
        assert_eq!(there.position, Position::from_steps(target));
    }
}

/// Until the acceleration has fallen the axis goes further than 2³¹ steps.
#[test]
fn i02_an_acceleration_that_takes_half_the_span_to_fall_lands_on_its_target() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 4_000_000.into(),
        acceleration: 100_000,
        deceleration: 100_000,
    };
    for (velocity, acceleration) in [(2_650_000, 2_000), (2_400_000, 2_000), (3_000_000, 2_000)] {
        let acceleration = clock.half_acceleration(acceleration).doubled().forwards();
        for target in [
            -1_000_000_000,
            0,
            1_000_000_000,
            1_500_000_000,
            2_000_000_000,
        ] {
            let start = start(state(clock, -2_000_000_000, velocity), -acceleration);
            let mut plan = Plan::at_rest(0, 0);
            let goal = Goal::Rest(target);
            let made = plan.make(clock, &start, goal, limits, Ramps::JerkLimited(2));
            if made == Err(PlanError::OutOfRange) {
                continue;
            }
            assert_no_jump(&plan);
            // Sampled often enough to tell one turn of 2³² steps from two.
            let end = plan.end().unwrap();
            let places =
                (0..=1_000).map(|part| plan.state_at(end / 1_000 * part).position.bits() >> 32);
            let places: std::vec::Vec<i64> = places.chain([target]).collect();
            let travelled: i64 = (places.windows(2))
                .map(|pair| i64::from((pair[1] - pair[0]) as i32))
                .sum();
            assert_eq!(travelled, target + 2_000_000_000, "{velocity} to {target}");
        }
    }
}

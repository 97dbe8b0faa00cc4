//! Smooth moves at the ends of the span of 2³² steps, and what lies out of range.

use super::smooth::{assert_no_jump, double_s};
use super::{Goal, Limits, Plan, Ramps, clock, state};
use crate::Position;

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

//! Smooth ramps longer than the span, and accelerations that their jerk never reaches.

use super::smooth::assert_no_jump;
use super::{Goal, Limits, Plan, Ramps, clock, state};

#[test]
fn i02_a_move_whose_braking_is_longer_than_half_the_span_lands_on_its_target() {
    for hz in [1_000_000, 84_000_000] {
        let clock = clock(hz);
        let limits = Limits {
            velocity: 315_566.into(),
            acceleration: 206_533,
            deceleration: 10,
        };
        let ramps = Ramps::JerkLimited(1_558_791_428);
        let from = state(clock, -1_500_000_000, 0);
        let goal = Goal::Rest(1_500_000_000);
        let mut plan = Plan::new(clock, 0, from, goal, limits, ramps).unwrap();
        assert_no_jump(&plan);
        // Turned round at the greatest velocity, so that the way back is as long.
        let at = u64::from(hz);
        plan.replan(clock, at, Goal::Rest(-1_500_000_000), limits, ramps)
            .unwrap();
        assert_no_jump(&plan);
    }
}

#[test]
fn i08_a_stop_and_a_ramp_longer_than_the_span_have_no_jump() {
    let clock = clock(84_000_000);
    let limits = Limits {
        velocity: 1_091_046.into(),
        acceleration: 10,
        deceleration: 10,
    };
    let ramps = Ramps::JerkLimited(1_277_730_688);
    for (now, then) in [
        (1_091_046, 0),
        (-1_091_046, 0),
        (0, 1_091_046),
        (0, -1_091_046),
    ] {
        let goal = Goal::Velocity(then.into());
        let from = state(clock, 0, now);
        let plan = Plan::new(clock, 0, from, goal, limits, ramps).unwrap();
        assert_no_jump(&plan);
    }
}

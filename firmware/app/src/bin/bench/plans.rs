//! Motion: planning a move.

use core::hint::black_box;

use motion::{Clock, Goal, Limits, Plan, Position, Ramps, State, Ticks, Velocity};

use crate::{count, row};

const HZ: u32 = 84_000_000;
/// Plans as an axis does, over the plan that was.
#[inline(never)]
fn plan(clock: Clock, plan: &mut Plan, target: i64, limits: Limits) {
    let goal = Goal::Rest(target);
    plan.redirect(clock, 0, goal, limits, Ramps::Linear)
        .unwrap();
}

/// Both plans.
pub fn run() {
    let clock = Clock::new(HZ).unwrap();
    // The reference vectors T01, a long trapezoid, and T14, a target inside the stopping distance: overshoot and return.
    let limits = Limits {
        velocity: 100_000.into(),
        acceleration: 500_000,
        deceleration: 500_000,
    };
    let mut planned = Plan::at_rest(0, 0);
    let (t01, ()) = count(|| plan(clock, black_box(&mut planned), 100_000, limits));
    assert_eq!(
        planned.state_at(Ticks::MAX).position,
        Position::from_steps(100_000)
    );
    row("motion: plan T01, from rest", t01);

    let moving = State {
        position: Position::from_steps(0),
        velocity: Velocity::from_speed(clock, 50_000.into()),
    };
    let mut planned = Plan::velocity(clock, 0, moving, 50_000.into(), limits).unwrap();
    let (t14, ()) = count(|| plan(clock, black_box(&mut planned), 1_000, limits));
    assert_eq!(
        planned.state_at(Ticks::MAX).position,
        Position::from_steps(1_000)
    );
    row("motion: plan T14, overshoot and return", t14);
}

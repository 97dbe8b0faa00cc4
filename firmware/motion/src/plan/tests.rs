//! Plans against the reference vectors, and against the rules that hold for all plans.

#[cfg(feature = "limited-jerk")]
mod again;
#[cfg(feature = "limited-jerk")]
mod double_s;
#[cfg(feature = "limited-jerk")]
mod extremes;
mod left_ramps;
#[cfg(feature = "limited-jerk")]
mod long;
mod properties;
mod sequences;
mod smooth;
mod through;
mod vectors;

use super::{Goal, Limits, Plan, Ramps};
use crate::{Clock, Speed, State, Ticks};

/// The clocks for which all vectors must pass: two STM32 timers and the fastest one supported.
const CLOCKS: [u32; 3] = [84_000_000, 168_000_000, 1_000_000_000];

fn clock(hz: u32) -> Clock {
    Clock::new(hz).unwrap()
}

fn state(clock: Clock, steps: i64, velocity: i32) -> State {
    State {
        position: crate::Position::from_steps(steps),
        velocity: crate::Velocity::from_speed(clock, velocity.into()),
    }
}

/// Position in steps.
fn steps(state: State) -> f64 {
    state.position.bits() as f64 / 2f64.powi(32)
}

/// Steps/s.
fn amount(speed: Speed) -> f64 {
    speed.bits() as f64 / 2f64.powi(32)
}

/// Velocity in steps/s.
fn per_second(clock: Clock, state: State) -> f64 {
    state.velocity.bits() as f64 / 2f64.powi(56) * f64::from(clock.hz())
}

/// The corners of a plan, its start and end among them, and the tick before each.
fn corners(plan: &Plan) -> impl Iterator<Item = Ticks> {
    let ends = [plan.start()].into_iter().chain(plan.end());
    ends.chain(plan.phases().map(|phase| phase.start()))
        .flat_map(|corner| [corner.saturating_sub(1), corner])
        .filter(|t| *t >= plan.start())
        .collect::<std::vec::Vec<_>>()
        .into_iter()
}

#[cfg(not(feature = "sin-squared"))]
#[test]
fn sin_squared_is_linear_where_it_is_not_built_in() {
    let limits = Limits {
        velocity: 20_000.into(),
        acceleration: 100_000,
        deceleration: 50_000,
    };
    let clock = clock(84_000_000);
    let plan = |ramps| {
        Plan::new(
            clock,
            0,
            State::default(),
            Goal::Rest(10_000),
            limits,
            ramps,
        )
    };
    let (sine, linear) = (plan(Ramps::SinSquared), plan(Ramps::Linear));
    let (mut sine, mut linear) = (sine.unwrap(), linear.unwrap());
    for at in [1_000_000, 20_000_000] {
        for t in (0..100_000_000).step_by(123_457) {
            assert_eq!(sine.state_at(t), linear.state_at(t));
        }
        assert_eq!(sine.end(), linear.end());
        for (plan, ramps) in [(&mut sine, Ramps::SinSquared), (&mut linear, Ramps::Linear)] {
            plan.replan(clock, at, Goal::Rest(-77), limits, ramps)
                .unwrap();
        }
    }
}

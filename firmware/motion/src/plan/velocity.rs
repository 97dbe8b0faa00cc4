//! Profile velocity: a ramp to another velocity, and the stop.

use super::Plan;
use super::builder::{Origin, PlanBuilder};
use super::goal::{Limits, PlanError};
use super::piece::{Acceleration, ramp_distance};
use crate::clock::Clock;
use crate::exact::{Q96, Uq96};
use crate::speed::{SignedSpeed, Speed};

/// Plans the ramp in a frame in which the velocity to reach is positive; for a stop, the one to leave.
// Out of line: what it needs of the stack a move does not.
#[inline(never)]
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    origin: &Origin,
    velocity: SignedSpeed,
    limits: Limits,
) -> Result<(), PlanError> {
    if limits.deceleration == 0 {
        return Err(PlanError::ZeroDeceleration);
    }
    let deceleration = Acceleration::new(clock, limits.deceleration);
    let half_deceleration = deceleration.half;
    let from = origin.from;
    let speed = from.velocity.amount();

    if velocity == SignedSpeed::ZERO {
        let mut builder = PlanBuilder::new(plan, origin, from.velocity < Q96::ZERO);
        if !speed.is_zero() {
            builder.brake(speed, half_deceleration, deceleration.time(speed));
        }
        let stop = builder.travelled;
        return builder.rest_at(stop);
    }
    if limits.velocity == Speed::ZERO {
        return Err(PlanError::ZeroVelocity);
    }
    if limits.acceleration == 0 {
        return Err(PlanError::ZeroAcceleration);
    }
    let goal = clock.speed(velocity.unsigned_abs().min(limits.velocity));

    let reverse = velocity.bits() < 0;
    let mut builder = PlanBuilder::new(plan, origin, reverse);
    let mut speed = speed;
    if !speed.is_zero() && (from.velocity < Q96::ZERO) != reverse {
        let time = deceleration.time(speed);
        let distance = ramp_distance(speed, half_deceleration, time, true);
        builder.brake_to_standstill(speed, half_deceleration, time, distance);
        speed = Uq96::ZERO;
    }
    if speed > goal {
        builder.brake(speed, half_deceleration, deceleration.time(speed - goal));
    } else if speed < goal {
        let acceleration = Acceleration::new(clock, limits.acceleration);
        builder.accelerate(speed, acceleration.half, acceleration.time(goal - speed));
    }
    builder.keep(goal)
}

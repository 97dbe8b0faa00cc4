//! Profile velocity: a ramp to another velocity, and the stop.

use super::phase::{Slope, ramp_way};
use super::{Course, Limits, Plan, PlanError};
use crate::clock::{Clock, Fine, Ticks};
use crate::fixed::Exact;
use crate::speed::{SignedSpeed, Speed};

/// Ramps from rest to a speed, and keeps it.
pub(super) fn from_rest(mut course: Course<'_>, clock: Clock, speed: Fine, limits: Limits) {
    let acceleration = Slope::new(clock, limits.acceleration);
    course.accelerate(0, acceleration.half, acceleration.time(speed));
    course.never_end(speed);
}

/// Plans the ramp in a frame in which the velocity to reach is positive; for a stop, the one to leave.
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    start: Ticks,
    from: Exact,
    velocity: SignedSpeed,
    limits: Limits,
) -> Result<(), PlanError> {
    if limits.deceleration == 0 {
        return Err(PlanError::ZeroDeceleration);
    }
    let deceleration = Slope::new(clock, limits.deceleration);
    let half_deceleration = deceleration.half;
    let speed = from.velocity.unsigned_abs();

    if velocity == SignedSpeed::ZERO {
        let mut course = Course::new(plan, start, from, from.velocity < 0);
        if speed != 0 {
            course.brake(speed, half_deceleration, deceleration.time(speed));
        }
        let stop = course.travelled;
        course.rest_at(stop);
        return Ok(());
    }
    if limits.velocity == Speed::ZERO {
        return Err(PlanError::ZeroVelocity);
    }
    if limits.acceleration == 0 {
        return Err(PlanError::ZeroAcceleration);
    }
    let goal = clock.speed(velocity.unsigned_abs().min(limits.velocity));

    let reverse = velocity.bits() < 0;
    let mut course = Course::new(plan, start, from, reverse);
    let mut speed = speed;
    if speed != 0 && (from.velocity < 0) != reverse {
        let time = deceleration.time(speed);
        let way = ramp_way(speed, half_deceleration, time, true);
        course.turn_back(speed, half_deceleration, time, way);
        speed = 0;
    }
    if speed > goal {
        let time = deceleration.time(speed.wrapping_sub(goal));
        course.brake(speed, half_deceleration, time);
    } else if speed < goal {
        let acceleration = Slope::new(clock, limits.acceleration);
        let time = acceleration.time(goal.wrapping_sub(speed));
        course.accelerate(speed, acceleration.half, time);
    }
    course.never_end(goal);
    Ok(())
}

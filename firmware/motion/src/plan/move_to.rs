//! Profile position: the trapezoid to a target, from any velocity; and through it, with a velocity left at the target.
//!
//! Braking to an end velocity at the target is the beginning of braking to rest further on: as far on as it takes to brake from the
//! end velocity. So such a move is planned as one to that point, and left at the target.

use super::phase::{Offset, Slope, ramp_way};
use super::{Course, Limits, Plan, PlanError};
use crate::clock::{Clock, Fine, Ticks};
use crate::divide::{estimate, quotient};
use crate::fixed::Exact;
use crate::root::root;
use crate::speed::Speed;
use crate::wide::Wide;

/// Plans the move in a frame in which the way still to go is positive.
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    start: Ticks,
    from: Exact,
    (target_steps, end_velocity): (i64, Speed),
    limits: Limits,
) -> Result<(), PlanError> {
    if limits.velocity == Speed::ZERO {
        return Err(PlanError::ZeroVelocity);
    }
    if limits.acceleration == 0 {
        return Err(PlanError::ZeroAcceleration);
    }
    if limits.deceleration == 0 {
        return Err(PlanError::ZeroDeceleration);
    }
    let (gap, is_back) = way_to(target_steps, from).ok_or(PlanError::OutOfRange)?;
    let speed = from.velocity.unsigned_abs();
    // On the target but still moving, the target counts as ahead: it will be overshot.
    let target_behind = if gap == 0 { from.velocity < 0 } else { is_back };
    let approaching = speed != 0 && (from.velocity < 0) == target_behind;

    let deceleration = Slope::new(clock, limits.deceleration);
    let half_deceleration = deceleration.half;
    let stop_time = deceleration.time(speed);
    if is_beyond_span(speed, stop_time) {
        return Err(PlanError::OutOfRange);
    }
    let stop_way = ramp_way(speed, half_deceleration, stop_time, true);

    let end = if end_velocity == Speed::ZERO || gap == 0 {
        End::REST
    } else {
        End::of(
            clock.speed(end_velocity.min(limits.velocity)),
            &deceleration,
        )
    };
    if is_beyond_span(end.speed, end.time) {
        return Err(PlanError::OutOfRange);
    }
    let way = gap.checked_add(end.way).ok_or(PlanError::OutOfRange)?;
    let route = Route {
        clock,
        limits,
        deceleration,
        end,
    };
    let goal = gap.cast_signed();
    if approaching {
        let is_short = way < stop_way;
        let spare = way.abs_diff(stop_way);
        let is_exact = spare <= indistinct(stop_time);
        if is_exact && route.end.speed == 0 {
            // The target is exactly at the stopping distance: brake, and nothing else.
            let course = Course::new(plan, start, from, target_behind);
            course.land(goal, half_deceleration, stop_time);
        } else if (is_exact || is_short) && route.end.speed != 0 {
            // Too fast for the end velocity: it comes about behind the target.
            let mut course = Course::new(plan, start, from, target_behind);
            let time = route
                .deceleration
                .time(speed.saturating_sub(route.end.speed));
            course.brake(speed, half_deceleration, time);
            course.never_end(route.end.speed);
        } else if is_short {
            // Too fast to stop in time: brake, turn round, come back.
            let mut course = Course::new(plan, start, from, !target_behind);
            course.turn_back(speed, half_deceleration, stop_time, stop_way);
            route.follow(course, 0, spare, goal.wrapping_neg());
        } else {
            let course = Course::new(plan, start, from, target_behind);
            route.follow(course, speed, way, goal);
        }
        return Ok(());
    }
    let way = way.checked_add(stop_way).ok_or(PlanError::OutOfRange)?;
    let mut course = Course::new(plan, start, from, target_behind);
    if speed != 0 {
        course.turn_back(speed, half_deceleration, stop_time, stop_way);
    }
    route.follow(course, 0, way, goal);
    Ok(())
}

/// Goes `way` from rest, to `goal` in the course's frame, and is at `end` there. Gives the course back where braking from that velocity
/// would go beyond the span: then nothing has been written.
pub(super) fn from_rest(
    course: Course<'_>,
    clock: Clock,
    (way, end, goal): (u128, Fine, i128),
    limits: Limits,
) -> Option<Course<'_>> {
    let deceleration = Slope::new(clock, limits.deceleration);
    let end = End::of(end, &deceleration);
    let is_beyond = is_beyond_span(end.speed, end.time);
    let Some(way) = way.checked_add(end.way).filter(|_| !is_beyond) else {
        return Some(course);
    };
    let route = Route {
        clock,
        limits,
        deceleration,
        end,
    };
    route.follow(course, 0, way, goal);
    None
}

/// Whether braking from a speed, which takes so long, leads 2³² steps away or more: half of speed · time bounds it well enough.
fn is_beyond_span(speed: Fine, time: Offset) -> bool {
    let bits = 256u32
        .wrapping_sub(speed.leading_zeros())
        .wrapping_sub(time.leading_zeros());
    bits > 160 && Wide::product(speed, time).shifted(33).is_none()
}

/// How far it is to a target, Q96 steps, and whether it lies behind. `None` if that is 2³² steps or more: positions wrap there.
pub(super) fn way_to(target_steps: i64, from: Exact) -> Option<(u128, bool)> {
    let steps = target_steps.checked_sub((from.position >> 96) as i64)?;
    let distance = u32::try_from(steps.unsigned_abs()).ok()?;
    let distance = u128::from(distance) << 96;
    let part = from.position.cast_unsigned() & ((1 << 96) - 1);
    Some(if steps > 0 {
        (distance.wrapping_sub(part), false)
    } else {
        (distance.wrapping_add(part), true)
    })
}

/// How far a gap and a stopping distance may lie apart and still mean the same.
///
/// A state has been rounded to 2⁻³² steps and 2⁻⁵⁶ steps per tick, and the latter adds up over the time of braking. Taking such a
/// difference for an overshoot would make the axis turn round for nothing.
fn indistinct(stop_time: Offset) -> u128 {
    ((stop_time >> 32) << 40).saturating_add(1 << 64)
}

/// What is left of the speed at the target.
struct End {
    speed: Fine,
    /// How long it takes to brake from it to rest, and how far.
    time: Offset,
    way: u128,
}

impl End {
    const REST: Self = Self {
        speed: 0,
        time: 0,
        way: 0,
    };

    fn of(speed: Fine, deceleration: &Slope) -> Self {
        if speed == 0 {
            return Self::REST;
        }
        let time = deceleration.time(speed);
        Self {
            speed,
            time,
            way: ramp_way(speed, deceleration.half, time, true),
        }
    }
}

/// The last part of every move: towards the target, at a speed from which it can stop there.
struct Route {
    clock: Clock,
    limits: Limits,
    deceleration: Slope,
    end: End,
}

impl Route {
    /// Goes `way` at first `speed`, to `target` in the course's frame; the way is that to rest, behind the target if there is an end
    /// velocity.
    fn follow(&self, mut course: Course<'_>, mut speed: Fine, mut way: u128, target: i128) {
        if way == 0 {
            course.rest_at(target);
            return;
        }
        let top = self.clock.speed(self.limits.velocity);
        let half_deceleration = self.deceleration.half;
        let is_alike = self.limits.acceleration == self.limits.deceleration;
        let other;
        let acceleration = if is_alike {
            &self.deceleration
        } else {
            other = Slope::new(self.clock, self.limits.acceleration);
            &other
        };
        let half_acceleration = acceleration.half;
        if speed > top {
            let time = self.deceleration.time(speed.wrapping_sub(top));
            way = way.saturating_sub(course.brake(speed, half_deceleration, time));
            speed = top;
        }
        let peak = self.peak(half_acceleration, speed, way).min(top).max(speed);
        if peak < self.end.speed {
            // The way is too short for the end velocity: it comes about behind the target.
            let time = acceleration.time(self.end.speed.wrapping_sub(speed));
            course.accelerate(speed, half_acceleration, time);
            course.never_end(self.end.speed);
            return;
        }
        let mut stop_time = None;
        if peak > speed {
            let time = acceleration.time(peak.wrapping_sub(speed));
            // The same ramp up and down is worked out once.
            if speed == 0 && is_alike {
                stop_time = Some(time);
            }
            way = way.saturating_sub(course.accelerate(speed, half_acceleration, time));
        }
        let stop_time = stop_time.unwrap_or_else(|| self.deceleration.time(peak));
        way = way.saturating_sub(ramp_way(peak, half_deceleration, stop_time, true));
        course.cruise(peak, cruise_time(way, peak), way);
        if self.end.speed == 0 {
            course.land(target, half_deceleration, stop_time);
        } else {
            let end = (self.end.speed, self.end.time, self.end.way);
            course.pass(target, half_deceleration, stop_time, end);
        }
    }

    /// The speed at which acceleration from `speed` must turn into braking if there is no limit to it:
    /// v² = (2·a·way + speed²)·d/(a + d), rounded down.
    ///
    /// 32 significant bits are plenty. The duration is at its minimum at the exact peak, so what is lost there enters it squared; and
    /// because the peak is rounded down, there is always some cruise left to take up the difference.
    fn peak(&self, half_acceleration: Fine, speed: Fine, way: u128) -> Fine {
        let mut square = Wide::product(half_acceleration << 2, way);
        if speed != 0 {
            square = square.plus(Wide::product(speed, speed));
        }
        let (mantissa, exponent) = square.leading();
        let (share, below) = if self.limits.acceleration == self.limits.deceleration {
            // Most moves are like that.
            (mantissa, 1)
        } else {
            let above = mantissa.leading_zeros();
            let (digit, below) = part_of_sum(self.limits.deceleration, self.limits.acceleration);
            let product = u128::from(mantissa << (above & 63)).wrapping_mul(digit.into());
            (
                (product >> 32) as u64,
                below.wrapping_add(above).wrapping_sub(32),
            )
        };
        // share · 2^(exponent − below): an even exponent, so that its root is a shift.
        let exponent = exponent.wrapping_sub(below);
        let odd = exponent & 1;
        let speed = Fine::from(root(share >> odd));
        let half = exponent.wrapping_add(odd).cast_signed() / 2;
        if half < 0 {
            speed >> (half.unsigned_abs() & 127)
        } else {
            speed << (half.unsigned_abs() & 127)
        }
    }
}

/// part/(part + rest) as digit / 2ⁿ, rounded down, with a digit of 31 or 32 bits. `part` is not 0.
fn part_of_sum(part: u32, rest: u32) -> (u32, u32) {
    let above = part.leading_zeros();
    let sum = u64::from(part).wrapping_add(rest.into());
    // The divisor is rounded up, so that the quotient is rounded down.
    let (divisor, shift) = match u32::try_from(sum) {
        Ok(sum) => (sum << (sum.leading_zeros() & 31), sum.leading_zeros()),
        Err(_) => ((sum.wrapping_add(1) >> 1) as u32, u32::MAX),
    };
    let digit = estimate(u64::from(part << (above & 31)) << 31, divisor);
    (digit, above.wrapping_add(31).wrapping_sub(shift))
}

/// How long `way` takes at `speed`. The fraction of a tick survives however long it is.
fn cruise_time(way: u128, speed: Fine) -> Offset {
    quotient(way, 1, speed)
}

//! Profile position: the trapezoid to a target, from any velocity; and through it, with a velocity left at the target.
//!
//! Braking to an end velocity at the target is the beginning of braking to rest further on: as far on as it takes to brake from the
//! end velocity. So such a move is planned as one to that point, and left at the target.

use super::Plan;
use super::builder::{Origin, PlanBuilder};
use super::goal::{Limits, PlanError};
use super::piece::{Acceleration, ramp_distance};
use crate::clock::Clock;
use crate::divide::{estimate, quotient};
use crate::exact::{DistanceQ96, PositionQ96, Q96, TicksQ32, Uq96};
use crate::low;
use crate::root::isqrt;
use crate::speed::Speed;
use crate::u256::U256;

/// Plans the move in a frame in which the distance still to go is positive.
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    origin: &Origin,
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
    let from = &origin.from;
    let (gap, is_back) = distance_to(target_steps, from.position).ok_or(PlanError::OutOfRange)?;
    let speed = from.velocity.amount();
    // On the target but still moving, the target counts as ahead: it will be overshot.
    let is_reverse = from.velocity < Q96::ZERO;
    let target_behind = if gap.is_zero() { is_reverse } else { is_back };
    let approaching = !speed.is_zero() && is_reverse == target_behind;

    let deceleration = Acceleration::new(clock, limits.deceleration);
    let half_deceleration = deceleration.half;
    let stop_time = deceleration.time(speed);
    if is_beyond_span(speed, stop_time) {
        return Err(PlanError::OutOfRange);
    }
    let stop_distance = ramp_distance(speed, half_deceleration, stop_time, true);

    let end = if end_velocity == Speed::ZERO || gap.is_zero() {
        End::REST
    } else {
        End::of(
            clock.speed(end_velocity.min(limits.velocity)),
            &deceleration,
        )?
    };
    let distance = gap.checked_add(end.distance).ok_or(PlanError::OutOfRange)?;
    let route = Route {
        clock,
        limits,
        deceleration,
        end,
    };
    let goal = gap.forwards();
    if approaching {
        let is_short = distance < stop_distance;
        let spare = distance.abs_diff(stop_distance);
        let is_exact = spare <= indistinct(stop_time);
        if is_exact && route.end.speed.is_zero() {
            // The target is exactly at the stopping distance: brake, and nothing else.
            let builder = PlanBuilder::new(plan, origin, target_behind);
            return builder.brake_to_rest_at(goal, half_deceleration, stop_time);
        }
        if (is_exact || is_short) && !route.end.speed.is_zero() {
            // Too fast for the end velocity: it comes about behind the target.
            let mut builder = PlanBuilder::new(plan, origin, target_behind);
            let time = route
                .deceleration
                .time(speed.saturating_sub(route.end.speed));
            builder.brake(speed, half_deceleration, time);
            return builder.keep(route.end.speed);
        }
        if is_short {
            // Too fast to stop in time: brake, turn round, come back.
            let mut builder = PlanBuilder::new(plan, origin, !target_behind);
            builder.brake_to_standstill(speed, half_deceleration, stop_time, stop_distance);
            return route.append_to(builder, Uq96::ZERO, spare, -goal);
        }
        let builder = PlanBuilder::new(plan, origin, target_behind);
        return route.append_to(builder, speed, distance, goal);
    }
    let distance = distance
        .checked_add(stop_distance)
        .ok_or(PlanError::OutOfRange)?;
    let mut builder = PlanBuilder::new(plan, origin, target_behind);
    if !speed.is_zero() {
        builder.brake_to_standstill(speed, half_deceleration, stop_time, stop_distance);
    }
    route.append_to(builder, Uq96::ZERO, distance, goal)
}

/// Whether braking from a speed, which takes so long, leads 2³² steps away or more: half of speed · time bounds it well enough.
fn is_beyond_span(speed: Uq96, time: TicksQ32) -> bool {
    let (speed, time) = (speed.bits(), time.bits());
    let bits = 256 - speed.leading_zeros() - time.leading_zeros();
    bits > 160 && U256::product(speed, time).shifted(33).is_none()
}

/// How far it is to a target, and whether it lies behind. `None` if that is 2³² steps or more: positions wrap there.
pub(super) fn distance_to(target_steps: i64, from: PositionQ96) -> Option<(DistanceQ96, bool)> {
    let steps = target_steps.checked_sub(from.steps().into())?;
    let distance = u32::try_from(steps.unsigned_abs()).ok()?;
    let distance = u128::from(distance) << 96;
    let part = from.bits().cast_unsigned() & ((1 << 96) - 1);
    let amount = DistanceQ96::from_bits;
    Some(if steps > 0 {
        (amount(distance - part), false)
    } else {
        (amount(distance.checked_add(part)?), true)
    })
}

/// How far a gap and a stopping distance may lie apart and still mean the same.
///
/// A state has been rounded to 2⁻³² steps and 2⁻⁵⁶ steps per tick, and the latter adds up over the time of braking. Taking such a
/// difference for an overshoot would make the axis turn round for nothing.
fn indistinct(stop_time: TicksQ32) -> DistanceQ96 {
    DistanceQ96::from_bits(((stop_time.bits() >> 32) << 40).saturating_add(1 << 64))
}

/// What is left of the speed at the target.
struct End {
    speed: Uq96,
    /// How long it takes to brake from it to rest, and how far.
    time: TicksQ32,
    distance: DistanceQ96,
}

impl End {
    const REST: Self = Self {
        speed: Uq96::ZERO,
        time: TicksQ32::ZERO,
        distance: DistanceQ96::ZERO,
    };

    fn of(speed: Uq96, deceleration: &Acceleration) -> Result<Self, PlanError> {
        let time = deceleration.time(speed);
        if is_beyond_span(speed, time) {
            return Err(PlanError::OutOfRange);
        }
        Ok(Self {
            speed,
            time,
            distance: ramp_distance(speed, deceleration.half, time, true),
        })
    }
}

/// The last part of every move: towards the target, at a speed from which it can stop there.
struct Route {
    clock: Clock,
    limits: Limits,
    deceleration: Acceleration,
    end: End,
}

impl Route {
    /// Covers `distance` at first `speed`, to `target` in the builder's frame; it is the distance to rest, behind the target if there is an end
    /// velocity.
    fn append_to(
        &self,
        mut builder: PlanBuilder<'_>,
        mut speed: Uq96,
        mut distance: DistanceQ96,
        target: PositionQ96,
    ) -> Result<(), PlanError> {
        if distance.is_zero() {
            return builder.rest_at(target);
        }
        let top = self.clock.speed(self.limits.velocity);
        let half_deceleration = self.deceleration.half;
        let is_alike = self.limits.acceleration == self.limits.deceleration;
        let other;
        let acceleration = if is_alike {
            &self.deceleration
        } else {
            other = Acceleration::new(self.clock, self.limits.acceleration);
            &other
        };
        let half_acceleration = acceleration.half;
        if speed > top {
            let time = self.deceleration.time(speed - top);
            let braked = builder.brake(speed, half_deceleration, time);
            distance = distance.saturating_sub(braked);
            speed = top;
        }
        let peak = self.peak(half_acceleration, speed, distance);
        let peak = peak.min(top).max(speed);
        if peak < self.end.speed {
            // The distance is too short for the end velocity: it comes about behind the target.
            let time = acceleration.time(self.end.speed - speed);
            builder.accelerate(speed, half_acceleration, time);
            return builder.keep(self.end.speed);
        }
        let mut stop_time = None;
        if peak > speed {
            let time = acceleration.time(peak - speed);
            // The same ramp up and down is worked out once.
            if speed.is_zero() && is_alike {
                stop_time = Some(time);
            }
            let covered = builder.accelerate(speed, half_acceleration, time);
            distance = distance.saturating_sub(covered);
        }
        let stop_time = stop_time.unwrap_or_else(|| self.deceleration.time(peak));
        let stop_distance = ramp_distance(peak, half_deceleration, stop_time, true);
        distance = distance.saturating_sub(stop_distance);
        // The fraction of a tick survives however long the cruise is.
        let time = TicksQ32::from_bits(quotient(distance.bits(), 1, peak.bits()));
        builder.cruise(peak, time, distance);
        if self.end.speed.is_zero() {
            builder.brake_to_rest_at(target, half_deceleration, stop_time)
        } else {
            // Both times are rounded down: a difference that is too long would begin above the peak.
            let time = stop_time.saturating_sub(self.end.time + TicksQ32::from_bits(1));
            builder.brake_through(target, half_deceleration, time, self.end.speed)
        }
    }

    /// The speed at which acceleration from `speed` must turn into braking if there is no limit to it:
    /// v² = (2·a·distance + speed²)·d/(a + d), rounded down.
    ///
    /// 32 significant bits are plenty. The duration is at its minimum at the exact peak, so what is lost there enters it squared; and
    /// because the peak is rounded down, there is always some cruise left to take up the difference.
    fn peak(&self, half_acceleration: Uq96, speed: Uq96, distance: DistanceQ96) -> Uq96 {
        let mut square = U256::product(half_acceleration.bits() << 2, distance.bits());
        if !speed.is_zero() {
            square = square.plus(U256::product(speed.bits(), speed.bits()));
        }
        let (mantissa, exponent) = square.leading();
        let (share, below) = if self.limits.acceleration == self.limits.deceleration {
            // Most moves are like that.
            (mantissa, 1)
        } else {
            let above = mantissa.leading_zeros();
            let (digit, below) = part_of_sum(self.limits.deceleration, self.limits.acceleration);
            let product = u128::from(mantissa << (above & 63)) * u128::from(digit);
            (low::u64(product >> 32), below + above.cast_signed() - 32)
        };
        // share · 2^(exponent − below): an even exponent, so that its root is a shift.
        let exponent = exponent.cast_signed() - below;
        let odd = exponent & 1;
        let speed = u128::from(isqrt(share >> odd));
        let half = (exponent + odd) / 2;
        Uq96::from_bits(if half < 0 {
            speed >> (half.unsigned_abs() & 127)
        } else {
            speed << (half.unsigned_abs() & 127)
        })
    }
}

/// part/(part + other) as digit / 2ⁿ, rounded down, with a digit of 31 or 32 bits. `part` is not 0.
fn part_of_sum(part: u32, other: u32) -> (u32, i32) {
    let above = part.leading_zeros();
    let sum = u64::from(part) + u64::from(other);
    // The divisor is rounded up, so that the quotient is rounded down.
    let (divisor, shift) = match u32::try_from(sum) {
        Ok(sum) => {
            let above = sum.leading_zeros();
            (sum << (above & 31), above.cast_signed())
        }
        Err(_) => (low::u32((sum + 1) >> 1), -1),
    };
    let digit = estimate(u64::from(part << (above & 31)) << 31, divisor);
    (digit, above.cast_signed() + 31 - shift)
}

//! Jerk-limited motion: a target or a velocity, from any position, velocity and acceleration.
//!
//! A move is a ramp to a velocity, a cruise, and a ramp to rest; from rest to rest that is the double-S, the fastest there is. Where
//! there is no room for the profile velocity, the greatest one for which both ramps fit is looked for (`cruise.rs`).
//!
//! A motion that has to turn round comes to rest first. A ramp that is under way is left at the same jerk: its acceleration goes to
//! nothing, or on to that of the next ramp.

use super::move_to::way_to;
use super::phase::Offset;
use super::ramp::{Jerk, LONGEST, Ramp, coasting};
use super::{Course, Goal, Limits, Plan, PlanError};
use crate::clock::{Clock, Fine, Ticks};
use crate::divide::quotient;
use crate::fixed::Exact;
use crate::speed::{SignedSpeed, Speed};

/// What rules the motion, all per tick.
#[derive(Debug)]
pub(super) struct Rules {
    pub(super) top: i128,
    pub(super) acceleration: Fine,
    pub(super) deceleration: Fine,
    pub(super) jerk: Jerk,
}

impl Rules {
    pub(super) fn new(clock: Clock, limits: Limits, jerk: Jerk) -> Self {
        Self {
            top: clock.speed(limits.velocity).cast_signed(),
            acceleration: clock.half_acceleration(limits.acceleration) << 1,
            deceleration: clock.half_acceleration(limits.deceleration) << 1,
            jerk,
        }
    }

    /// From a velocity that is not negative, with an acceleration, to another one.
    fn ramp(&self, velocity: i128, acceleration: i128, end: i128) -> Ramp {
        let slows = end == 0 || end < coasting(velocity, acceleration, self.jerk);
        let most = if slows {
            self.deceleration
        } else {
            self.acceleration
        };
        Ramp::new(velocity, acceleration, end, most, self.jerk)
    }

    /// To rest, in whichever direction.
    #[inline]
    fn stop(&self, velocity: i128, acceleration: i128) -> Ramp {
        if velocity == 0 && acceleration == 0 {
            return Ramp::default();
        }
        Ramp::new(velocity, acceleration, 0, self.deceleration, self.jerk)
    }
}

/// Plans the motion in a frame in which the way still to go is positive.
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    start: Ticks,
    from: (Exact, i128),
    goal: Goal,
    limits: Limits,
    jerk: Jerk,
) -> Result<(), PlanError> {
    let is_stop = goal == Goal::Velocity(SignedSpeed::ZERO);
    if limits.velocity == Speed::ZERO && !is_stop {
        return Err(PlanError::ZeroVelocity);
    }
    if limits.acceleration == 0 && !is_stop {
        return Err(PlanError::ZeroAcceleration);
    }
    if limits.deceleration == 0 {
        return Err(PlanError::ZeroDeceleration);
    }
    let rules = Rules::new(clock, limits, jerk);
    let speed = |velocity: Speed| clock.speed(velocity.min(limits.velocity)).cast_signed();
    match goal {
        Goal::Velocity(SignedSpeed::ZERO) => stop(plan, start, from, &rules),
        Goal::Velocity(velocity) => {
            let end = speed(velocity.unsigned_abs());
            keep(plan, start, from, velocity.bits() < 0, end, &rules);
        }
        Goal::Rest(target) => reach(plan, start, from, (target, 0), &rules)?,
        Goal::Pass(target, velocity) => {
            reach(plan, start, from, (target, speed(velocity)), &rules)?;
        }
    }
    Ok(())
}

/// Comes to rest, wherever that is.
fn stop(plan: &mut Plan, start: Ticks, (from, acceleration): (Exact, i128), rules: &Rules) {
    let mut course = Course::new(plan, start, from, false);
    course.ramp(&rules.stop(from.velocity, acceleration));
    let rest = course.travelled;
    course.rest_at(rest);
}

/// Keeps the velocity `end`, backwards if `reverse`.
fn keep(
    plan: &mut Plan,
    start: Ticks,
    (from, acceleration): (Exact, i128),
    reverse: bool,
    end: i128,
    rules: &Rules,
) {
    let turn = |value: i128| if reverse { value.wrapping_neg() } else { value };
    let (mut velocity, mut acceleration) = (turn(from.velocity), turn(acceleration));
    let mut course = Course::new(plan, start, from, reverse);
    if velocity < 0 {
        course.ramp(&rules.stop(velocity, acceleration));
        (velocity, acceleration) = (0, 0);
    }
    course.ramp(&rules.ramp(velocity, acceleration, end));
    course.never_end(end.unsigned_abs());
}

/// Moves to a target in steps, with the velocity `end` there.
fn reach(
    plan: &mut Plan,
    start: Ticks,
    (from, acceleration): (Exact, i128),
    (target, end): (i64, i128),
    rules: &Rules,
) -> Result<(), PlanError> {
    let (gap, is_behind) = way_to(target, from).ok_or(PlanError::OutOfRange)?;
    let stop = rules.stop(from.velocity, acceleration);
    if stop.way.unsigned_abs() >= LONGEST {
        return Err(PlanError::OutOfRange);
    }
    // What is still to go from where a stop would end.
    let (rest_is_behind, left) = beyond(is_behind, gap, stop.way).ok_or(PlanError::OutOfRange)?;
    if left <= indistinct(stop.time) && (end == 0 || gap == 0) {
        let reverse = stop.way < 0;
        let goal = if is_behind == reverse {
            gap.cast_signed()
        } else {
            gap.cast_signed().wrapping_neg()
        };
        let course = Course::new(plan, start, from, reverse);
        let ramp = if reverse {
            rules.stop(from.velocity.wrapping_neg(), acceleration.wrapping_neg())
        } else {
            stop
        };
        course.land_on(&ramp, goal);
        return Ok(());
    }
    let reverse = rest_is_behind;
    let turn = |value: i128| if reverse { value.wrapping_neg() } else { value };
    let (velocity, acceleration) = (turn(from.velocity), turn(acceleration));
    let goal = if is_behind == reverse {
        gap.cast_signed()
    } else {
        gap.cast_signed().wrapping_neg()
    };
    let mut course = Course::new(plan, start, from, reverse);
    let forwards = velocity > 0 && coasting(velocity, acceleration, rules.jerk) >= 0;
    if (forwards || velocity == 0 && acceleration >= 0)
        && let Some(cruise) = rules.fastest(velocity, acceleration, end, gap)
    {
        let route = rules.over(velocity, acceleration, cruise, end);
        course.take(&route, gap, end, goal);
        return Ok(());
    }
    course.ramp(&rules.stop(velocity, acceleration));
    match rules.fastest(0, 0, end, left) {
        Some(cruise) => course.take(&rules.over(0, 0, cruise, end), left, end, goal),
        // The way is too short for the end velocity: it comes about behind the target.
        None => {
            course.ramp(&rules.ramp(0, 0, end));
            course.never_end(end.unsigned_abs());
        }
    }
    Ok(())
}

/// Where the target lies from the end of `way`: whether it is behind there, and how far.
fn beyond(is_behind: bool, gap: u128, way: i128) -> Option<(bool, u128)> {
    let is_away = (way < 0) != is_behind;
    let way = way.unsigned_abs();
    if is_away {
        return Some((is_behind, gap.checked_add(way)?));
    }
    Some(if gap >= way {
        (is_behind, gap.wrapping_sub(way))
    } else {
        (!is_behind, way.wrapping_sub(gap))
    })
}

/// How far a target and the end of a stop may lie apart and still mean the same: states are rounded, and what is lost adds up over
/// the time of braking.
fn indistinct(stop_time: Offset) -> u128 {
    ((stop_time >> 32) << 44).saturating_add(1 << 68)
}

/// Two ramps with a cruise between them.
pub(super) struct Route {
    pub(super) first: Ramp,
    pub(super) cruise: i128,
    pub(super) last: Ramp,
}

impl Route {
    /// How far both ramps go.
    pub(super) fn way(&self) -> u128 {
        let (first, last) = (self.first.way, self.last.way);
        if first < 0 {
            return last.saturating_add(first).max(0).unsigned_abs();
        }
        first.unsigned_abs().saturating_add(last.unsigned_abs())
    }
}

impl Rules {
    /// Inlined, as a route is large.
    #[inline(always)]
    pub(super) fn over(
        &self,
        velocity: i128,
        acceleration: i128,
        cruise: i128,
        end: i128,
    ) -> Route {
        let first = self.ramp(velocity, acceleration, cruise);
        let is_alike = velocity == 0
            && acceleration == 0
            && end == 0
            && self.acceleration == self.deceleration;
        let last = if is_alike {
            first.back_to_rest(cruise)
        } else {
            self.ramp(cruise, 0, end)
        };
        Route {
            first,
            cruise,
            last,
        }
    }

    /// The velocity of the fastest way over `way`, from a state to the velocity `end`; `None` if the ramps are too long.
    fn fastest(&self, velocity: i128, acceleration: i128, end: i128, way: u128) -> Option<i128> {
        // Both ways of adding up differ by their roundings at most, and the landing is anchored at the target.
        let cruise = self.cruise(velocity, acceleration, end, way)?;
        (cruise > 0).then_some(cruise)
    }
}

impl Course<'_> {
    /// Follows a route over `way`, to `goal` in the frame, where `end` is left of the velocity.
    fn take(mut self, route: &Route, way: u128, end: i128, goal: i128) {
        self.ramp(&route.first);
        let left = way.saturating_sub(route.way());
        let cruise = route.cruise.unsigned_abs();
        self.cruise(cruise, quotient(left, 1, cruise), left);
        if end == 0 {
            self.land_on(&route.last, goal);
        } else {
            self.ramp(&route.last);
            self.travelled = goal;
            self.never_end(end.unsigned_abs());
        }
    }
}

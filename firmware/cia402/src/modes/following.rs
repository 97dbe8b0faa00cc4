//! Following set-points that come in each period: what cyclic synchronous position and interpolated position share.
//!
//! The contract:
//! - Between two set-points exactly the difference of them leaves, spread evenly over the time between them (60C0h = 0), or as a cubic
//!   with the mean velocity of its neighbours (60C0h = −1), but never beyond one of the two set-points. Where a cubic would be
//!   faster than 607Fh and 6080h allow, the line is straight.
//! - Each distance is reckoned from where the pulses lead, and over the time there is from there. So a set-point that came too late, and a
//!   period that has become another, pass no limit: what is missing is caught up with.
//! - It begins where the motor stands. Set-points that are not there, and later what is farther away than 607Fh and 6080h allow in one
//!   period, are caught up with: at these velocities, on the ramps 6083h and 6084h within 60C5h and 60C6h.
//! - So is what 60C5h and 60C6h do not allow, as far as whole units let it be known ([`acceleration`]).
//! - A set-point that is farther away than one motion may lead is cut to that distance, so that no difference overflows.
//! - Before a software limit 607Dh the motor slows down with 6085h and stops on it. The way back is free.
//! - A set-point that is missing is bridged at the velocity before, as often as 2051h:1 says. One is missing only where the motor
//!   moves; where the last set-point was the only one, the motor stays there.

mod acceleration;
mod bounds;
mod period;

use motion::{Limits, Speed};

use super::{Context, Types};
use acceleration::{MaxChange, SetPoints};
use bounds::{rounding, within_reach, within_travel};
use period::{away, distance_at, distance_q16, is_monotone};
use period::{may_brake_behind, over, slope, to, whole};

pub(super) use period::{braking_distance, gain, seconds};

use crate::actuator::Actuator;
use crate::cyclic::{MicrosQ16, Slot};
use crate::motor::Motor;
use crate::objects::Objects;
use crate::option_codes::StopRamp;
use crate::travel::Travel;

/// Bits behind the point of positions here; before it there is room for 2⁴⁷ increments.
const POINT: u32 = 16;

/// What is done about set-points that are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// They are there, or bridged.
    Followed,
    /// Too many are missing: the mode is to stop.
    Lost,
}

/// A set-point that is still to be given to the axis.
#[derive(Clone, Copy, Debug)]
struct Knot {
    end: MicrosQ16,
    at: i64,
    /// From the set-point before.
    distance: i64,
    /// The time for it.
    interval: MicrosQ16,
    /// The longest distance that is allowed in this time.
    max_distance: i64,
}

/// The times of the path segment to the next set-point.
#[derive(Clone, Copy, Debug)]
struct SegmentTiming {
    /// The time from the set-point before.
    interval: MicrosQ16,
    /// It begins where the last set-point was, about a period before.
    is_in_step: bool,
}

/// The motion.
#[derive(Debug)]
pub(super) struct Following {
    is_active: bool,
    /// The last set-point as it is carried out.
    at: i64,
    /// The distance to it in the last period; where the next one lasts otherwise, what would be as fast.
    distance: i64,
    /// The last set-point as it was asked for, in increments.
    goal: i64,
    /// How far the last set-point was from the one before it: their velocity, for a period.
    velocity: i64,
    /// Set-points in a row that were there.
    fresh: u8,
    /// Set-points in a row that were not, and are bridged.
    bridged: u8,
    is_catching_up: bool,
    is_limited: bool,
    /// The set-points that were followed, for 60C5h and 60C6h.
    set_points: SetPoints,
    /// By how much the difference of two distances may be off because they are whole units.
    rounding: i64,
    /// Of a cubic: it waits for the one behind it.
    waiting: Option<Knot>,
}

impl Following {
    pub(super) const fn new() -> Self {
        Self {
            is_active: false,
            at: 0,
            distance: 0,
            goal: 0,
            velocity: 0,
            fresh: 0,
            bridged: 0,
            is_catching_up: false,
            is_limited: false,
            set_points: SetPoints::new(),
            rounding: 0,
            waiting: None,
        }
    }

    /// Somebody else moves or stops the motor.
    #[inline(never)]
    pub(super) fn forget(&mut self) {
        let is_limited = self.is_limited;
        *self = Self::new();
        self.is_limited = is_limited;
    }

    /// The motor does what the set-points say (statusword bit 12).
    pub(super) const fn follows(&self) -> bool {
        self.is_active && !self.is_limited
    }

    /// A set-point could not be carried out as it is (statusword bit 11).
    pub(super) const fn is_limited(&self) -> bool {
        self.is_limited
    }

    /// Whether what was given to the axis ends at the last set-point as it was asked for; `None` while none is followed.
    pub(super) fn is_at_goal(&self) -> Option<bool> {
        let is_there = self.distance == 0 && self.at == self.goal.wrapping_shl(POINT);
        self.is_active.then_some(is_there)
    }

    /// A limit switch stops the motor.
    pub(super) fn on_limit(&mut self) {
        self.forget();
        self.is_limited = true;
    }

    /// Carries out the set-point of a slot, in increments, or bridges it.
    pub(super) fn take<P: Types>(
        &mut self,
        slot: Slot,
        target: Option<i64>,
        context: &mut Context<'_, P>,
    ) -> Outcome {
        let is_cubic =
            P::Objects::DRIVE.cubic_interpolation && context.configuration.cyclic.is_cubic;
        let end = slot.due(is_cubic);
        if context.motor.is_at_rest() {
            if !self.is_active && target.is_none() {
                return Outcome::Followed;
            }
            self.stand(context.motor);
        } else if !self.is_active {
            // It is still being stopped.
            return Outcome::Followed;
        }
        let here = context.motor.committed_position();
        let goal = target.map(|target| within_reach(target, here));
        if let Some(goal) = goal
            && self.stands_at(goal, here)
            && context.motor.is_at_rest()
        {
            self.head_for(goal);
            self.set_points.keep(whole(self.at));
            self.is_limited = Some(goal) != target;
            return Outcome::Followed;
        }
        let Some(segment) = self.begin_segment::<P>(end, slot.period, context.motor) else {
            // What was given before the period changed lasts that long.
            if let Some(goal) = goal {
                self.head_for(goal);
            }
            return Outcome::Followed;
        };
        let Some(required) = self.required(goal, context) else {
            return Outcome::Lost;
        };
        let before = self.distance;
        let seconds = seconds(segment.interval);
        let max = distance_at(context.max_velocity(), seconds);
        let was_catching_up = self.is_catching_up;
        let times = (slot.period, segment.interval);
        self.distance = self.allowed(required, times, max, seconds, context);
        self.is_limited |= goal != target;
        let knot = Knot {
            end,
            at: self.at.wrapping_add(self.distance),
            distance: self.distance,
            interval: segment.interval,
            max_distance: max,
        };
        if was_catching_up || self.is_catching_up {
            let distance = over(knot.distance, segment.interval, slot.period);
            self.rounding = rounding(context);
            self.set_points
                .begin(whole(knot.at.wrapping_sub(distance)), whole(knot.at));
        } else {
            self.set_points.keep(whole(knot.at));
        }
        self.give::<P>(knot, before, is_cubic && segment.is_in_step, context.motor);
        self.at = knot.at;
        Outcome::Followed
    }

    /// Whether the motor, which is `here`, has been at the set-points for long, and this is the same again. There is nothing to do then.
    fn stands_at(&self, goal: i64, here: i64) -> bool {
        goal == self.goal
            && here == goal
            && self.distance == 0
            && self.at == goal.wrapping_shl(POINT)
            && self.set_points.stand()
            && !self.is_catching_up
            && self.waiting.is_none()
    }

    /// Begins where the motor stands.
    fn stand(&mut self, motor: &Motor<impl Actuator>) {
        let at = motor.committed_position();
        if !self.is_active {
            self.is_active = true;
            // With a set-point elsewhere the motor does not start with a jump.
            self.is_catching_up = true;
            self.fresh = 0;
            self.goal = at;
        }
        self.bridged = 0;
        self.at = at.wrapping_shl(POINT);
        self.distance = 0;
        self.waiting = None;
    }

    /// Finds where the motion to a set-point that is due at `end` begins, and the velocity there; `None` if there is no time for it.
    fn begin_segment<P: Types>(
        &mut self,
        end: MicrosQ16,
        period: MicrosQ16,
        motor: &mut Motor<P::Actuator>,
    ) -> Option<SegmentTiming> {
        let is_steady = |interval: MicrosQ16| interval.abs_diff(period) <= period / 4;
        let mut path = motor.path_to(end);
        if let Some(waiting) = self.waiting::<P>() {
            let interval = end.wrapping_sub(waiting.end);
            let is_there = away(waiting.at.wrapping_sub(waiting.distance), path.position) == 0;
            if is_there && is_steady(interval) {
                if self.is_catching_up {
                    self.distance = over(self.distance, waiting.interval, interval);
                }
                return Some(SegmentTiming {
                    interval,
                    is_in_step: true,
                });
            }
            self.waiting = None;
            if is_there {
                let _ = motor.follow(waiting.end, to(waiting.at));
                path = motor.path_to(end);
            }
        }
        let interval = if path.distance == 0 {
            path.left.min(period)
        } else {
            path.left
        };
        let away = away(self.at, path.position);
        let is_in_step = away == 0 && is_steady(interval);
        if !is_in_step || self.is_catching_up {
            self.is_catching_up = true;
            self.at = self.at.wrapping_add(away);
            self.distance = path.distance >> (32 - POINT);
        }
        (interval >= period / 4).then_some(SegmentTiming {
            interval,
            is_in_step,
        })
    }

    /// A set-point has come.
    fn head_for(&mut self, goal: i64) {
        let velocity = goal.wrapping_sub(self.goal).wrapping_shl(POINT);
        self.velocity = if self.fresh == 0 { 0 } else { velocity };
        self.fresh = self.fresh.saturating_add(1);
        self.bridged = 0;
        self.goal = goal;
    }

    /// The distance that is asked for; `None` if too many set-points are missing.
    fn required(&mut self, target: Option<i64>, context: &Context<'_, impl Types>) -> Option<i64> {
        let lost = &context.configuration.cyclic.lost;
        if let Some(goal) = target {
            self.head_for(goal);
        } else if !lost.is_as_before() && self.fresh > 1 && self.distance != 0 {
            if self.bridged >= lost.bridged {
                return None;
            }
            self.bridged = self.bridged.saturating_add(1);
            if !self.is_catching_up {
                self.goal = self.at.wrapping_add(self.distance) >> POINT;
                return Some(self.distance);
            }
            self.goal = self.goal.wrapping_add(self.velocity >> POINT);
        } else {
            self.fresh = 0;
            self.velocity = 0;
        }
        Some(self.goal.wrapping_shl(POINT).wrapping_sub(self.at))
    }

    /// How far set-points move in an interval.
    fn set_point_velocity(&self, (period, interval): (MicrosQ16, MicrosQ16)) -> i64 {
        if interval.abs_diff(period) <= period / 64 {
            self.velocity
        } else {
            over(self.velocity, period, interval)
        }
    }

    /// The distance within all limits. Set-points come in a period and this is an interval, and `max` is the longest distance allowed.
    #[inline(never)]
    fn allowed(
        &mut self,
        required: i64,
        times: (MicrosQ16, MicrosQ16),
        max: i64,
        seconds: u64,
        context: &Context<'_, impl Types>,
    ) -> i64 {
        let asked = required;
        let has_ends = context.travel.increments != Travel::NONE.increments;
        let required = if has_ends {
            within_travel(self.at, required, *context.travel)
        } else {
            required
        };
        let required = Self::outside_limit_switches(required, context);
        // A set-point beyond a limit stands still there.
        let velocity = |motion: &Self| {
            if required == asked {
                motion.set_point_velocity(times)
            } else {
                0
            }
        };
        let is_within_ramps = if self.is_catching_up {
            let (up, down) = ramps(seconds, context);
            let change = required.saturating_sub(self.distance);
            // Both this change and the one to the velocity of the set-points, behind it. Those are whole increments.
            change.saturating_abs() <= up.max(down).max(1 << POINT)
                && required.saturating_sub(velocity(self)).saturating_abs() <= down.max(1 << POINT)
        } else {
            let at = whole(self.at.saturating_add(required));
            // A steady motion keeps to limits of any size.
            let least = MaxChange::rounding(self.rounding);
            self.set_points.may_be_followed_by(at, least) || {
                let max = MaxChange {
                    up: gain(context.configuration.max_acceleration, seconds),
                    down: gain(context.configuration.max_deceleration, seconds),
                    ..least
                };
                self.set_points.may_be_followed_by(at, max)
            }
        };
        let is_in_reach = required.saturating_abs() <= max && is_within_ramps;
        let distance = if is_in_reach {
            required
        } else {
            self.catch_up(required, velocity(self), max, ramps(seconds, context))
        };
        let distance = if has_ends {
            self.before_limit(distance, seconds, context)
        } else {
            distance
        };
        let distance = if distance == required {
            required
        } else {
            Self::outside_limit_switches(distance, context)
        };
        // Out of a limit, too, the motor goes on with no jump.
        self.is_catching_up = !is_in_reach || distance != asked;
        self.is_limited = self.is_catching_up;
        distance
    }

    /// The distance in this period on a ramp that ends with the set-points, at their velocity.
    fn catch_up(&self, required: i64, velocity: i64, max: i64, (up, down): (i64, i64)) -> i64 {
        let behind = required.saturating_sub(velocity);
        let gained = braking_distance(behind.saturating_abs(), down).min(behind.saturating_abs());
        let gained = if behind < 0 {
            gained.wrapping_neg()
        } else {
            gained
        };
        let wanted = velocity
            .saturating_add(gained)
            .max(max.wrapping_neg())
            .min(max);
        let grows = wanted.saturating_abs() > self.distance.saturating_abs();
        let step = if grows { up } else { down };
        wanted
            .max(self.distance.saturating_sub(step))
            .min(self.distance.saturating_add(step))
    }

    /// The distance, if no limit switch blocks it.
    fn outside_limit_switches(distance: i64, context: &Context<'_, impl Types>) -> i64 {
        let is_free = context.motor.is_free(distance).is_ok();
        if is_free { distance } else { 0 }
    }

    /// The distance that still lets the motor stop at a software limit.
    fn before_limit(&self, distance: i64, seconds: u64, context: &Context<'_, impl Types>) -> i64 {
        let (low, high) = context.travel.increments;
        let available = match distance {
            1.. => distance_q16(high).saturating_sub(self.at),
            ..=-1 => self.at.saturating_sub(distance_q16(low)),
            0 => return 0,
        };
        // Far enough away that there is no need to look closely.
        if available == i64::MAX {
            return distance;
        }
        let down = gain(context.deceleration(StopRamp::QuickStop), seconds);
        if may_brake_behind(distance.unsigned_abs(), available, down) {
            return distance;
        }
        let max = braking_distance(available.max(0), down);
        distance.max(max.wrapping_neg()).min(max)
    }

    /// The set-point that waits for the next one, for a cubic.
    fn waiting<P: Types>(&self) -> Option<Knot> {
        let is_cubic = P::Objects::DRIVE.cubic_interpolation;
        self.waiting.filter(|_| is_cubic)
    }

    /// Gives a set-point to the axis; on a cubic the one before it. What the axis does not take, the next distance makes up for.
    fn give<P: Types>(
        &mut self,
        knot: Knot,
        before: i64,
        is_cubic: bool,
        motor: &mut Motor<P::Actuator>,
    ) {
        let stands = before == 0 && knot.distance == 0;
        let Some(waiting) = self.waiting::<P>() else {
            if stands {
                return;
            }
            if before == 0 {
                // Until the motion begins. There may be no time left to wait for.
                let _ = motor.follow(knot.end.wrapping_sub(knot.interval), to(self.at));
            }
            if is_cubic {
                self.waiting = Some(knot);
            } else {
                let _ = motor.follow(knot.end, to(knot.at));
            }
            return;
        };
        let first = motor.path_to(waiting.end).distance >> (32 - POINT);
        let before = over(waiting.distance, waiting.interval, knot.interval);
        let slope = slope(before, knot.distance);
        let last = over(slope, knot.interval, waiting.interval);
        let (end, at) = (waiting.end, to(waiting.at));
        let _ = match is_monotone(first, last, waiting) {
            true => motor.follow_smoothly(end, at, (to(slope), knot.interval)),
            false => motor.follow(end, at),
        };
        self.waiting = (!stands).then_some(knot);
    }
}

/// By how much a distance may grow and shrink from period to period while the motor catches up.
fn ramps(seconds: u64, context: &Context<'_, impl Types>) -> (i64, i64) {
    let (limits, _) = context.within(Limits {
        velocity: Speed::ZERO,
        acceleration: context.commands.profile_acceleration,
        deceleration: context.commands.profile_deceleration,
    });
    let up = gain(limits.acceleration, seconds);
    (up, gain(limits.deceleration, seconds))
}

#[cfg(test)]
mod tests;

//! Jerk-limited motion: a target or a velocity, from any position, velocity and acceleration.
//!
//! A move is a ramp to a velocity, a cruise, and a ramp to rest; from rest to rest that is the double-S, the fastest there is. Where
//! there is no room for the profile velocity, the greatest one for which both ramps fit is looked for (`cruise.rs`).
//!
//! A motion that has to turn round comes to rest first, and that is all that is planned of it here: the way from there is a leg of its
//! own (`second_leg.rs`). A ramp that is under way is left at the same jerk: its acceleration goes to
//! nothing, or on to that of the next ramp.

use super::move_to::way_to;
use super::number::Number;
use super::phase::Offset;
use super::ramp::{Jerk, Lead, Limit, Motion, Ramp, RoughLimit, stopping_way};
use super::rough::{Kind, Rough};
use super::{Course, Goal, Limits, Plan, PlanError};
use crate::clock::{Clock, Ticks};
use crate::fixed::Exact;
use crate::speed::{SignedSpeed, Speed};

/// What rules the motion, all per tick.
#[derive(Debug)]
pub(super) struct Rules<'a> {
    pub(super) top: i128,
    pub(super) acceleration: &'a Limit,
    pub(super) deceleration: &'a Limit,
    pub(super) jerk: &'a Jerk,
}

impl Rules<'_> {
    /// From a velocity that is not negative to another one.
    fn ramp(&self, ramp: &mut Ramp, from: &Motion, end: i128) {
        let falls = end < from.coasting();
        let limit = if falls || end == 0 {
            self.deceleration
        } else {
            self.acceleration
        };
        let lead = Lead::new(from, falls, limit);
        ramp.become_of((from, &lead), end, limit, self.jerk);
    }
}

/// To rest, in whichever direction.
fn stopping(ramp: &mut Ramp, from: &Motion, limit: &Limit, jerk: &Jerk) {
    if from.is_rest() {
        *ramp = Ramp::NONE;
        return;
    }
    let falls = from.coasting() > 0;
    let lead = Lead::new(from, falls, limit);
    ramp.become_of((from, &lead), 0, limit, jerk);
}

/// Plans the motion in a frame in which the way still to go is positive.
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    start: Ticks,
    from: (Exact, i128),
    goal: Goal,
    limits: Limits,
    jerk: &Jerk,
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
    if is_stop {
        let deceleration = limit(clock, limits.deceleration, jerk);
        stop(plan, start, from, &deceleration, jerk);
        return Ok(());
    }
    with_rules(clock, limits, jerk, |rules| {
        let speed = |velocity: Speed| clock.speed(velocity.min(limits.velocity)).cast_signed();
        match goal {
            Goal::Velocity(velocity) => {
                let end = speed(velocity.unsigned_abs());
                keep(plan, clock, start, from, velocity.bits() < 0, end, rules);
                Ok(())
            }
            Goal::Rest(target) => reach(plan, clock, start, from, (target, 0), rules),
            Goal::Pass(target, velocity) => {
                reach(plan, clock, start, from, (target, speed(velocity)), rules)
            }
        }
    })
}

#[inline(always)]
fn limit(clock: Clock, rate: u32, jerk: &Jerk) -> Limit {
    Limit::new(clock.half_acceleration(rate) << 1, jerk)
}

/// Does something by the rules that the limits make.
#[inline(always)]
pub(super) fn with_rules<R>(
    clock: Clock,
    limits: Limits,
    jerk: &Jerk,
    then: impl FnOnce(&Rules<'_>) -> R,
) -> R {
    let deceleration = &limit(clock, limits.deceleration, jerk);
    let other;
    let acceleration = if limits.acceleration == limits.deceleration {
        deceleration
    } else {
        other = limit(clock, limits.acceleration, jerk);
        &other
    };
    then(&Rules {
        top: clock.speed(limits.velocity).cast_signed(),
        acceleration,
        deceleration,
        jerk,
    })
}

/// A motion as it is in a frame that may be turned round.
fn seen(velocity: i128, acceleration: i128, reverse: bool, jerk: &Jerk) -> Motion {
    if reverse {
        Motion::new(velocity.wrapping_neg(), acceleration.wrapping_neg(), jerk)
    } else {
        Motion::new(velocity, acceleration, jerk)
    }
}

/// Comes to rest, wherever that is.
fn stop(
    plan: &mut Plan,
    start: Ticks,
    (from, acceleration): (Exact, i128),
    limit: &Limit,
    jerk: &Jerk,
) {
    let reverse = from.velocity < 0;
    let motion = seen(from.velocity, acceleration, reverse, jerk);
    let mut course = Course::new(plan, start, from, reverse);
    stopping(course.ramp(0), &motion, limit, jerk);
    course.follow(0);
    let rest = course.travelled;
    course.rest_at(rest);
}

/// Keeps the velocity `end`, backwards if `reverse`. If it stops first, the rest is left for the second leg.
fn keep(
    plan: &mut Plan,
    clock: Clock,
    start: Ticks,
    (from, acceleration): (Exact, i128),
    reverse: bool,
    end: i128,
    rules: &Rules<'_>,
) {
    let motion = seen(from.velocity, acceleration, reverse, rules.jerk);
    let mut course = Course::new(plan, start, from, reverse);
    if motion.velocity < 0 {
        stopping(course.ramp(0), &motion, rules.deceleration, rules.jerk);
        course.follow(0);
        course.wait(clock, (0, end, 0));
        return;
    }
    course.ramp_to(&motion, end, rules);
}

/// Moves to a target in steps, with the velocity `end` there. If it stops first, the rest is left for the second leg.
fn reach(
    plan: &mut Plan,
    clock: Clock,
    start: Ticks,
    (from, acceleration): (Exact, i128),
    (target, end): (i64, i128),
    rules: &Rules<'_>,
) -> Result<(), PlanError> {
    // In a frame in which the target lies ahead.
    let (gap, reverse) = way_to(target, from).ok_or(PlanError::OutOfRange)?;
    let goal = gap.cast_signed();
    let motion = seen(from.velocity, acceleration, reverse, rules.jerk);
    let forwards = if motion.velocity == 0 {
        motion.acceleration >= 0
    } else {
        motion.velocity > 0 && motion.coasting() >= 0
    };
    let room = Room::new(&motion, gap, rules);
    let mut lead = Lead::steady(motion.velocity, false);
    if room.is_ample
        && forwards
        && let Some(cruise) = rules.fastest(&motion, end, gap, &mut lead)
    {
        let course = Course::new(plan, start, from, reverse);
        course.take((&motion, &lead), cruise, (gap, end, goal), rules);
        return Ok(());
    }
    if room.is_doubtful && is_too_long(&motion, rules) {
        return Err(PlanError::OutOfRange);
    }
    // Whoever is to pass the target need not be able to stop before it.
    if end != 0 && gap != 0 && forwards {
        let cruise = if room.is_ample {
            None
        } else {
            rules.fastest(&motion, end, gap, &mut lead)
        };
        let course = Course::new(plan, start, from, reverse);
        match cruise {
            Some(cruise) => course.take((&motion, &lead), cruise, (gap, end, goal), rules),
            // Too fast for the end velocity, or the way is too short for it: it comes about behind the target.
            None => course.ramp_to(&motion, end, rules),
        }
        return Ok(());
    }
    let number = plan.spare_ramp();
    let stop = plan.ramp_mut(number);
    stopping(stop, &motion, rules.deceleration, rules.jerk);
    let stop_time = stop.time();
    // What is still to go from where a stop would end.
    let (mut is_beyond, mut left) = beyond(gap, stop.way).ok_or(PlanError::OutOfRange)?;
    if left <= indistinct(stop_time) {
        if end == 0 || gap == 0 {
            let mut course = Course::new(plan, start, from, reverse);
            course.follow_to(number, false, goal);
            course.rest_at(goal);
            return Ok(());
        }
        // On which side of the target it ends is rounding: it goes on as it came.
        (is_beyond, left) = (false, 0);
    }
    if room.is_unknown
        && !is_beyond
        && forwards
        && let Some(cruise) = rules.fastest(&motion, end, gap, &mut lead)
    {
        let course = Course::new(plan, start, from, reverse);
        course.take((&motion, &lead), cruise, (gap, end, goal), rules);
        return Ok(());
    }
    // Behind the target, in a frame in which the way back is positive.
    let goal = if is_beyond { goal.wrapping_neg() } else { goal };
    if motion.is_rest() {
        // A velocity of nothing would never get there.
        return Err(PlanError::OutOfRange);
    }
    let mut course = Course::new(plan, start, from, reverse != is_beyond);
    if is_beyond {
        course.ramp(number).mirror();
    }
    course.follow(number);
    course.wait(clock, (left, end, goal));
    Ok(())
}

/// Where the target lies from the end of `way`: whether it is behind there, and how far.
fn beyond(gap: u128, way: i128) -> Option<(bool, u128)> {
    let length = way.unsigned_abs();
    if way < 0 {
        return Some((false, gap.checked_add(length)?));
    }
    Some(if gap >= length {
        (false, gap.wrapping_sub(length))
    } else {
        (true, length.wrapping_sub(gap))
    })
}

/// How far a target and the end of a stop may lie apart and still mean the same: states are rounded, and what is lost adds up over
/// the time of braking.
fn indistinct(stop_time: Offset) -> u128 {
    ((stop_time >> 32) << 44).saturating_add(1 << 68)
}

/// Whether a stop takes 2³¹ steps or more.
#[cold]
fn is_too_long(motion: &Motion, rules: &Rules<'_>) -> bool {
    let way = stopping_way(motion, rules.deceleration, rules.jerk);
    way == i128::MAX || way == i128::MIN
}

/// What rough numbers tell of a stop.
struct Room {
    /// It ends before the target, without doubt.
    is_ample: bool,
    /// Nor is it certain that it ends behind it.
    is_unknown: bool,
    /// It may end 2³¹ steps away, or more.
    is_doubtful: bool,
}

/// A part of a way of which rough numbers are sure, however much of it cancels out: 2⁻¹².
const DOUBT: Rough = Rough::power(-12);

/// A way of 2³¹ steps.
const SPAN: Rough = Rough::power(31);

impl Room {
    fn new(motion: &Motion, gap: u128, rules: &Rules<'_>) -> Self {
        if motion.is_rest() {
            return Self {
                is_ample: gap > indistinct(0),
                is_unknown: false,
                is_doubtful: false,
            };
        }
        let RoughLimit {
            square: limit,
            slowness,
            entry,
        } = rules.deceleration.rough;
        let turned = |value: Rough, negative: bool| {
            if negative { value.negated() } else { value }
        };
        let falls = motion.coasting() > 0;
        let time = turned(motion.time.rough(), falls);
        let change = turned(motion.change.rough(), falls);
        let velocity = Number::of(motion.velocity, Kind::Velocity).rough();
        let jerk = rules.jerk.rough;
        // How far the motion is behind the beginning of a ramp without acceleration, whose rest it is, and at which velocity that begins; as
        // `Lead::new` has it.
        let over = time.minus(entry);
        let (start, before, cancelled) = if over > Rough::ZERO {
            let rise = turned(jerk.times(entry).times(entry).halved(), falls);
            let start = velocity.plus(change).minus(rise.doubled());
            // v·t + a·t²/2 − j·t³/6, where a is j times the time that it takes to fall.
            let bend = jerk.times(time.minus(over.times(Rough::THIRD))).times(over);
            let mean = velocity.plus(turned(bend.halved(), falls));
            let eased = mean.times(over);
            let entered = start.plus(rise.times(Rough::THIRD)).times(entry);
            let all = velocity.magnitude().plus(change.magnitude());
            (start, entered.minus(eased), all.times(time))
        } else {
            let start = velocity.minus(change);
            let before = time.times(start.plus(change.times(Rough::THIRD)));
            (start, before, before.magnitude())
        };
        // As `steady_way` has it.
        let gain = start.magnitude();
        let square = jerk.times(gain);
        let steady = if square < limit {
            gain.times(square.reciprocal_root()).doubled()
        } else {
            gain.times(slowness).plus(entry)
        };
        let whole = start.halved().times(steady);
        let way = whole.minus(before);
        let parts = whole.magnitude().plus(cancelled);
        let room = Rough::of(gap, Kind::Way).minus(way);
        let doubt = parts.times(DOUBT);
        let is_unknown = room.magnitude() <= doubt;
        Self {
            is_ample: !is_unknown && room > Rough::ZERO,
            is_unknown,
            is_doubtful: way.magnitude().plus(doubt) >= SPAN,
        }
    }
}

impl Course<'_> {
    /// Moves from rest over `way` to `goal` in the frame, with the velocity `end` there. Where the way is too short for that, it comes about
    /// behind the target. A velocity of nothing is there for no way that is not nothing: the lowest would do then.
    pub(super) fn leave_rest(self, (way, end, goal): (u128, i128, i128), rules: &Rules<'_>) {
        let mut lead = Lead::steady(0, false);
        let cruise = rules.fastest(&Motion::REST, end, way, &mut lead);
        if cruise.is_some() || end == 0 {
            let cruise = cruise.unwrap_or(1);
            self.take((&Motion::REST, &lead), cruise, (way, end, goal), rules);
        } else {
            self.ramp_to(&Motion::REST, end, rules);
        }
    }

    /// Ramps from a motion to the velocity `end`, and keeps it.
    pub(super) fn ramp_to(mut self, from: &Motion, end: i128, rules: &Rules<'_>) {
        rules.ramp(self.ramp(1), from, end);
        self.follow(1);
        self.never_end(end.unsigned_abs());
    }

    /// Follows a ramp to the velocity `cruise`, and another one to `end`, over `way`, to `goal` in the frame.
    fn take(
        mut self,
        (from, lead): (&Motion, &Lead),
        cruise: i128,
        (way, end, goal): (u128, i128, i128),
        rules: &Rules<'_>,
    ) {
        let limit = if lead.falls {
            rules.deceleration
        } else {
            rules.acceleration
        };
        let first = self.ramp(1);
        first.become_of((from, lead), cruise, limit, rules.jerk);
        let one = first.way;
        self.follow(1);
        let is_back = from.is_rest() && end == 0 && limit.most == rules.deceleration.most;
        let (last, another) = if is_back {
            (1, one)
        } else {
            let last = self.ramp(2);
            last.become_steady((cruise, true), end, rules.deceleration, rules.jerk);
            (2, last.way)
        };
        let ways = one.wrapping_add(another).cast_unsigned();
        let left = way.wrapping_sub(ways);
        // The ramps may be longer than the way by what is rounded; two of 2³¹ steps are.
        let is_longer = left > way || one & another < 0;
        let left = if is_longer { 0 } else { left };
        let speed = Number::of(cruise, Kind::Velocity);
        let time = Number::of((left >> 1).cast_signed(), Kind::Way)
            .times(speed.reciprocal())
            .doubled()
            .fixed(Kind::Time)
            .max(0)
            .cast_unsigned();
        self.cruise(cruise.unsigned_abs(), time, left);
        self.follow_to(last, is_back, goal);
        if end == 0 {
            self.rest_at(goal);
        } else {
            self.never_end(end.unsigned_abs());
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::contextualize_config;

    use super::*;

    proptest! {
        #![proptest_config(contextualize_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() }))]

        /// What rough numbers are sure of is so, within the limit and beyond it, however close the target is to where a stop ends.
        #[test]
        fn rough_numbers_tell_whether_a_stop_ends_before_a_target(
            velocity in -4_000_000i32..4_000_000,
            pull in -100_000_000i64..100_000_000,
            bits in (0u32..27, 0u32..22, 0u32..27),
            deceleration in 1u32..100_000_000,
            jerk in 1u32..,
            closeness in 1u32..40,
        ) {
            let clock = Clock::new(168_000_000).unwrap();
            let jerk = &Jerk::new(clock.sixth_jerk((jerk >> bits.2).max(1)));
            let deceleration = &limit(clock, (deceleration >> bits.0).max(1), jerk);
            let rules = Rules { top: 0, acceleration: deceleration, deceleration, jerk };
            let speed = |whole: u32| clock.speed(whole.into()).cast_signed();
            let velocity = speed(velocity.unsigned_abs() >> bits.1) * i128::from(velocity.signum());
            let acceleration = (clock.half_acceleration((pull.unsigned_abs() >> bits.2) as u32) << 1).cast_signed();
            let motion = Motion::new(velocity, acceleration * i128::from(pull.signum()), jerk);
            prop_assume!(!motion.is_rest());
            let way = stopping_way(&motion, deceleration, jerk);
            // Nearer and nearer to it, on both sides.
            let off = (way.unsigned_abs() >> closeness).cast_signed();
            for gap in [way.saturating_sub(off), way.saturating_add(off)] {
                let room = Room::new(&motion, gap.max(0).unsigned_abs(), &rules);
                let is_far = way.unsigned_abs() >= 1 << 127;
                prop_assert!(!is_far || room.is_doubtful, "{way}");
                if !room.is_unknown && way < i128::MAX {
                    prop_assert_eq!(room.is_ample, gap.max(0) > way, "{} for {}", gap, way);
                }
                if closeness < 5 && gap > 1 << 70 && way.unsigned_abs() > 1 << 80 {
                    prop_assert!(!room.is_unknown, "{gap} for {way}");
                }
            }
        }
    }
}

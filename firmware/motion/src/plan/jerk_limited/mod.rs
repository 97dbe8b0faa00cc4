//! Jerk-limited motion: a target or a velocity, from any position, velocity and acceleration.
//!
//! A move is a ramp to a velocity, a cruise, and a ramp to rest; from rest to rest that is the double-S, the fastest there is. Where
//! there is no room for the profile velocity, the greatest one for which both ramps fit is looked for (`cruise.rs`).
//!
//! A motion that has to turn round comes to rest first. A ramp that is under way is left at the same jerk: its acceleration goes to
//! zero, or on to that of the next ramp.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "what is rough begins in floating point, and is cut to what the integers behind it can use"
)]

mod cruise;
mod follow;
mod number;
mod ramp;
mod rough;

use super::builder::{Origin, PlanBuilder};
use super::move_to::distance_to;
use super::{Goal, InitialState, Limits, Plan, PlanError};
use crate::clock::{Clock, TOP_SIXTH_JERK};
use crate::exact::{DistanceQ96, PositionQ96, Q96, Q128, TicksQ32, with_sign};
use crate::speed::{SignedSpeed, Speed};
use number::Number;
use ramp::{Jerk, Limit, Motion, Ramp, RoughLimit, VirtualStart, stopping_distance};
use rough::{Kind, Rough};

/// The limits of the motion, all per tick.
#[derive(Debug)]
struct Rules<'a> {
    top: Q96,
    acceleration: &'a Limit,
    deceleration: &'a Limit,
    jerk: &'a Jerk,
}

impl Rules<'_> {
    /// From a velocity that is not negative to another one.
    fn ramp(&self, from: &Motion, end: Q96) -> Ramp {
        let falls = end < from.coasting();
        let limit = if falls || end.is_zero() {
            self.deceleration
        } else {
            self.acceleration
        };
        let virtual_start = VirtualStart::new(from, falls, limit);
        let mut ramp = Ramp::NONE;
        ramp.become_of((from, &virtual_start), end, limit, self.jerk);
        ramp
    }
}

/// To rest, in whichever direction.
fn stopping(from: &Motion, limit: &Limit, jerk: &Jerk) -> Ramp {
    let mut ramp = Ramp::NONE;
    if !from.is_rest() {
        let falls = from.coasting() > Q96::ZERO;
        let virtual_start = VirtualStart::new(from, falls, limit);
        ramp.become_of((from, &virtual_start), Q96::ZERO, limit, jerk);
    }
    ramp
}

/// Plans the motion in a frame in which the distance still to go is positive, at a jerk of which this is a sixth.
pub(super) fn plan(
    plan: &mut Plan,
    clock: Clock,
    start: &InitialState,
    goal: Goal,
    limits: Limits,
    sixth_jerk: Q128,
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
    let jerk = &Jerk::new(sixth_jerk.min(TOP_SIXTH_JERK));
    if is_stop {
        return stop(plan, start, &limit(clock, limits.deceleration, jerk), jerk);
    }
    with_rules(clock, limits, jerk, |rules| {
        let speed = |velocity: Speed| clock.speed(velocity.min(limits.velocity)).forwards();
        match goal {
            Goal::Velocity(velocity) => {
                let end = speed(velocity.unsigned_abs());
                keep(plan, start, velocity.bits() < 0, end, rules)
            }
            Goal::Rest(target) => reach(plan, start, (target, Q96::ZERO), rules),
            Goal::Pass(target, velocity) => reach(plan, start, (target, speed(velocity)), rules),
        }
    })
}

#[inline(always)]
fn limit(clock: Clock, rate: u32, jerk: &Jerk) -> Limit {
    Limit::new(clock.half_acceleration(rate).doubled(), jerk)
}

/// Calls `then` with the limits in ticks.
#[inline(always)]
fn with_rules<R>(
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
        top: clock.speed(limits.velocity).forwards(),
        acceleration,
        deceleration,
        jerk,
    })
}

/// A motion as it is in a frame that may be turned round.
fn seen(start: &InitialState, reverse: bool, jerk: &Jerk) -> Motion {
    Motion::new(
        with_sign(start.from.velocity, reverse),
        with_sign(*start.acceleration.get(), reverse),
        jerk,
    )
}

fn builder<'a>(plan: &'a mut Plan, start: &InitialState, reverse: bool) -> PlanBuilder<'a> {
    PlanBuilder::new(plan, &Origin::steady(start.tick, start.from), reverse)
}

/// Comes to rest, wherever that is.
fn stop(
    plan: &mut Plan,
    start: &InitialState,
    limit: &Limit,
    jerk: &Jerk,
) -> Result<(), PlanError> {
    let reverse = start.from.velocity < Q96::ZERO;
    let motion = seen(start, reverse, jerk);
    let mut builder = builder(plan, start, reverse);
    builder.append_ramp(&stopping(&motion, limit, jerk));
    let rest = builder.travelled;
    builder.rest_at(rest)
}

/// Keeps the velocity `end`, backwards if `reverse`.
fn keep(
    plan: &mut Plan,
    start: &InitialState,
    reverse: bool,
    end: Q96,
    rules: &Rules<'_>,
) -> Result<(), PlanError> {
    let motion = seen(start, reverse, rules.jerk);
    let mut builder = builder(plan, start, reverse);
    if motion.velocity < Q96::ZERO {
        builder.append_ramp(&stopping(&motion, rules.deceleration, rules.jerk));
        return builder.ramp_to(&Motion::REST, end, rules);
    }
    builder.ramp_to(&motion, end, rules)
}

/// Moves to a target in steps, with the velocity `end` there.
fn reach(
    plan: &mut Plan,
    start: &InitialState,
    (target, end): (i64, Q96),
    rules: &Rules<'_>,
) -> Result<(), PlanError> {
    // In a frame in which the target lies ahead.
    let (gap, reverse) = distance_to(target, start.from.position).ok_or(PlanError::OutOfRange)?;
    let goal = gap.forwards();
    let motion = seen(start, reverse, rules.jerk);
    let forwards = if motion.velocity.is_zero() {
        motion.acceleration >= Q96::ZERO
    } else {
        motion.velocity > Q96::ZERO && motion.coasting() >= Q96::ZERO
    };
    let fit = Fit::new(&motion, gap, rules);
    let mut virtual_start = VirtualStart::steady(motion.velocity, false);
    if fit.is_ample
        && forwards
        && let Some(cruise) = rules.fastest(&motion, end, gap, &mut virtual_start)
    {
        let builder = builder(plan, start, reverse);
        return builder.append_move((&motion, &virtual_start), cruise, (gap, end, goal), rules);
    }
    if fit.is_doubtful && is_too_long(&motion, rules) {
        return Err(PlanError::OutOfRange);
    }
    // Whoever is to pass the target need not be able to stop before it.
    if !end.is_zero() && !gap.is_zero() && forwards {
        let cruise = if fit.is_ample {
            None
        } else {
            rules.fastest(&motion, end, gap, &mut virtual_start)
        };
        let builder = builder(plan, start, reverse);
        return match cruise {
            Some(cruise) => {
                builder.append_move((&motion, &virtual_start), cruise, (gap, end, goal), rules)
            }
            // Too fast for the end velocity, or the distance is too short for it: it comes about behind the target.
            None => builder.ramp_to(&motion, end, rules),
        };
    }
    let mut stop = stopping(&motion, rules.deceleration, rules.jerk);
    let stop_time = stop.time();
    // What is still to go from where a stop would end.
    let (mut is_beyond, mut left) = beyond(gap, stop.distance).ok_or(PlanError::OutOfRange)?;
    if left <= indistinct(stop_time) {
        if end.is_zero() || gap.is_zero() {
            let mut builder = builder(plan, start, reverse);
            builder.append_ramp_ending_at(&stop, goal);
            return builder.rest_at(goal);
        }
        // On which side of the target it ends is rounding: it goes on as it came.
        (is_beyond, left) = (false, DistanceQ96::ZERO);
    }
    if fit.is_unknown
        && !is_beyond
        && forwards
        && let Some(cruise) = rules.fastest(&motion, end, gap, &mut virtual_start)
    {
        let builder = builder(plan, start, reverse);
        return builder.append_move((&motion, &virtual_start), cruise, (gap, end, goal), rules);
    }
    // Behind the target, in a frame in which the distance back is positive.
    let goal = with_sign(goal, is_beyond);
    if motion.is_rest() {
        // Velocity zero never covers a distance.
        return Err(PlanError::OutOfRange);
    }
    let mut builder = builder(plan, start, reverse != is_beyond);
    if is_beyond {
        stop.mirror();
    }
    builder.append_ramp(&stop);
    builder.move_from_rest((left, end, goal), rules)
}

/// Where the target lies from the end of `distance`: whether it is behind there, and how far.
fn beyond(gap: DistanceQ96, distance: PositionQ96) -> Option<(bool, DistanceQ96)> {
    let length = distance.amount();
    if distance.bits() < 0 {
        return Some((false, gap.checked_add(length)?));
    }
    Some((gap < length, gap.abs_diff(length)))
}

/// How far a target and the end of a stop may lie apart and still mean the same: states are rounded, and what is lost adds up over
/// the time of braking.
fn indistinct(stop_time: TicksQ32) -> DistanceQ96 {
    DistanceQ96::from_bits(((stop_time.bits() >> 32) << 44).saturating_add(1 << 68))
}

/// Whether a stop takes 2³¹ steps or more.
#[cold]
fn is_too_long(motion: &Motion, rules: &Rules<'_>) -> bool {
    let distance = stopping_distance(motion, rules.deceleration, rules.jerk);
    distance.bits() == i128::MAX || distance.bits() == i128::MIN
}

/// What rough numbers tell of a stop.
struct Fit {
    /// It certainly ends before the target.
    is_ample: bool,
    /// Rough numbers cannot tell whether it ends before the target or behind it.
    is_unknown: bool,
    /// It may end 2³¹ steps away, or more.
    is_doubtful: bool,
}

/// A part of a distance of which rough numbers are sure, however much of it cancels out: 2⁻¹².
const ROUGH_ERROR: Rough = Rough::power(-12);

/// A distance of 2³¹ steps.
const SPAN: Rough = Rough::power(31);

impl Fit {
    fn new(motion: &Motion, gap: DistanceQ96, rules: &Rules<'_>) -> Self {
        if motion.is_rest() {
            return Self {
                is_ample: gap > indistinct(TicksQ32::ZERO),
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
        let falls = motion.coasting() > Q96::ZERO;
        let time = turned(motion.time.rough(), falls);
        let change = turned(motion.change.rough(), falls);
        let velocity = Number::of(motion.velocity.bits(), Kind::Velocity).rough();
        let jerk = rules.jerk.rough;
        // How far the motion is behind the beginning of a ramp without acceleration, whose rest it is, and at which velocity that begins; as
        // `VirtualStart::new` has it.
        let over = time.minus(entry);
        let (start, before, cancelled) = if over > Rough::ZERO {
            let rise = turned(jerk.times(entry).times(entry).halved(), falls);
            let start = velocity.plus(change).minus(rise.doubled());
            // v·t + a·t²/2 − j·t³/6, where a is j times the time that it takes to fall.
            let by_jerk = jerk.times(time.minus(over.times(Rough::THIRD))).times(over);
            let mean = velocity.plus(turned(by_jerk.halved(), falls));
            let eased = mean.times(over);
            let entered = start.plus(rise.times(Rough::THIRD)).times(entry);
            let all = velocity.magnitude().plus(change.magnitude());
            (start, entered.minus(eased), all.times(time))
        } else {
            let start = velocity.minus(change);
            let before = time.times(start.plus(change.times(Rough::THIRD)));
            (start, before, before.magnitude())
        };
        // As `steady_distance` has it.
        let gain = start.magnitude();
        let square = jerk.times(gain);
        let steady = if square < limit {
            gain.times(square.reciprocal_root()).doubled()
        } else {
            gain.times(slowness).plus(entry)
        };
        let whole = start.halved().times(steady);
        let distance = whole.minus(before);
        let parts = whole.magnitude().plus(cancelled);
        let spare = Rough::of(gap.bits(), Kind::Distance).minus(distance);
        let error_bound = parts.times(ROUGH_ERROR);
        let is_unknown = spare.magnitude() <= error_bound;
        Self {
            is_ample: !is_unknown && spare > Rough::ZERO,
            is_unknown,
            is_doubtful: distance.magnitude().plus(error_bound) >= SPAN,
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
            rate in -100_000_000i64..100_000_000,
            bits in (0u32..27, 0u32..22, 0u32..27),
            deceleration in 1u32..100_000_000,
            jerk in 1u32..,
            closeness in 1u32..40,
        ) {
            let clock = Clock::new(168_000_000).unwrap();
            let jerk = &Jerk::new(clock.sixth_jerk((jerk >> bits.2).max(1)));
            let deceleration = &limit(clock, (deceleration >> bits.0).max(1), jerk);
            let rules = Rules { top: Q96::ZERO, acceleration: deceleration, deceleration, jerk };
            let speed = clock.speed((velocity.unsigned_abs() >> bits.1).into());
            let acceleration = clock.half_acceleration((rate.unsigned_abs() >> bits.2) as u32).doubled();
            let motion = Motion::new(
                with_sign(speed.forwards(), velocity < 0),
                with_sign(acceleration.forwards(), rate < 0),
                jerk,
            );
            prop_assume!(!motion.is_rest());
            let distance = stopping_distance(&motion, deceleration, jerk).bits();
            // Nearer and nearer to it, on both sides.
            let off = (distance.unsigned_abs() >> closeness).cast_signed();
            for gap in [distance.saturating_sub(off), distance.saturating_add(off)] {
                let fit = Fit::new(&motion, DistanceQ96::from_bits(gap.max(0).unsigned_abs()), &rules);
                let is_far = distance.unsigned_abs() >= 1 << 127;
                prop_assert!(!is_far || fit.is_doubtful, "{distance}");
                if !fit.is_unknown && distance < i128::MAX {
                    prop_assert_eq!(fit.is_ample, gap.max(0) > distance, "{} for {}", gap, distance);
                }
                if closeness < 5 && gap > 1 << 70 && distance.unsigned_abs() > 1 << 80 {
                    prop_assert!(!fit.is_unknown, "{gap} for {distance}");
                }
            }
        }
    }
}

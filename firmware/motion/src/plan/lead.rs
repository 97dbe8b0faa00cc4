//! How a smooth motion leaves a ramp that is under way.
//!
//! Where the new motion would do the rest of the ramp anyway, it begins with that. Otherwise the acceleration is brought to zero in one cubic
//! piece, at the jerk with which the ramp began, or at that of the new limits if these are harder. Either way the new ramps begin with no
//! acceleration.

use super::builder::Origin;
use super::goal::{Goal, Limits};
use super::move_to::distance_to;
use super::piece::{Instant, Piece, Shape, distance_at, over_time};
use super::{Plan, sine};
use crate::clock::{Clock, Fine, Ticks};
use crate::divide::quotient;
use crate::fixed::Exact;
use crate::speed::Speed;
use crate::wide::Wide;
use core::cmp::Ordering;

/// A motion, as another one begins with it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) tick: Ticks,
    pub(crate) from: Exact,
    /// The acceleration, Q96 steps per tick², which linear ramps do not care for; and a sixth of the jerk, Q128 steps per tick³, at which it is brought
    /// to zero: no less than that with which it came about, or the velocity would go on beyond its limit.
    pub(crate) acceleration: i128,
    pub(crate) sixth_jerk: Fine,
}

impl Start {
    /// With no acceleration.
    pub(crate) const fn steady(tick: Ticks, from: Exact) -> Self {
        Self {
            tick,
            from,
            acceleration: 0,
            sixth_jerk: 0,
        }
    }

    /// From where sin² ramps go on when the acceleration has been brought to zero; at once if there is no jerk for that.
    pub(super) fn eased(&self) -> Origin {
        let Self {
            tick,
            from,
            acceleration,
            sixth_jerk,
        } = *self;
        let strength = acceleration.unsigned_abs();
        let jerk = 6 * sixth_jerk;
        // A divisor has 96 bits.
        let time = if jerk >> 96 == 0 {
            quotient(strength, 2, jerk)
        } else {
            quotient(strength, 1, jerk >> 32)
        };
        if time == 0 {
            return Origin {
                is_sine: true,
                ..Origin::steady(tick, from)
            };
        }
        let signed = |value: u128| {
            let value = value.cast_signed();
            if acceleration < 0 { -value } else { value }
        };
        let end = Instant::from(tick).after(time);
        let velocity = from.velocity + signed(over_time(strength, time) >> 1);
        let lead = Piece {
            start: tick,
            anchor: end,
            position: 0,
            velocity,
            half_acceleration: 0,
            shape: Shape::Cubic(-signed(sixth_jerk)),
        };
        // However long it lasts and whatever is rounded in it, it begins here.
        let position = from.position.wrapping_sub(lead.position_at(tick));
        Origin {
            start: tick,
            lead: Some(lead),
            begin: from.position,
            end,
            from: Exact { position, velocity },
            is_sine: true,
        }
    }
}

impl Plan {
    /// The motion at tick `at` of a smooth plan.
    pub(super) fn leave(&self, at: Ticks) -> Start {
        let (from, acceleration) = self.motion_at(at);
        if acceleration == 0 {
            return Start::steady(at, from);
        }
        let entered = match self.find_piece(at).map(|(piece, _)| (piece, piece.shape)) {
            Some((piece, Shape::Sine(time))) => sine::jerk(piece.half_acceleration, time),
            Some((_, Shape::Cubic(sixth_jerk))) if sixth_jerk != 0 => sixth_jerk.unsigned_abs(),
            _ => self.sixth_jerk,
        };
        Start {
            tick: at,
            from,
            acceleration,
            sixth_jerk: entered,
        }
    }

    /// The rest of a sin² ramp that is under way at tick `at`, if a motion to `goal` begins with that anyway.
    pub(super) fn rest_of_ramp(
        &self,
        clock: Clock,
        at: Ticks,
        goal: Goal,
        limits: Limits,
    ) -> Option<Origin> {
        let (ramp, _) = self.find_piece(at)?;
        let Shape::Sine(time) = ramp.shape else {
            return None;
        };
        // Where it ends, in the frame.
        let (end, position, velocity) = if Instant::from(at) < ramp.anchor {
            (ramp.anchor, ramp.position, ramp.velocity)
        } else {
            let half_gain = distance_at(ramp.half_acceleration, time);
            let distance = distance_at(ramp.velocity + half_gain, time);
            (
                ramp.anchor.after(time),
                ramp.position.wrapping_add(distance),
                ramp.velocity + 2 * half_gain,
            )
        };
        let turn = |value| self.frame.turn(value);
        let half = turn(ramp.half_acceleration);
        let from = Exact {
            position: self.frame.place(position),
            velocity: turn(velocity),
        };
        let change = if ramp.anchor == end { -half } else { half };
        if !is_done_anyway(from, change, clock, goal, limits) {
            return None;
        }
        // Only a target to pass asks where it begins; the piece there need not be worked out for another one.
        let begin = match goal {
            Goal::Pass(..) => self.exact_at(at).position,
            Goal::Rest(_) | Goal::Velocity(_) => from.position,
        };
        Some(Origin {
            start: at,
            lead: Some(Piece {
                start: at,
                position: turn(ramp.position.wrapping_sub(position)),
                velocity: turn(ramp.velocity),
                half_acceleration: half,
                ..*ramp
            }),
            begin,
            end,
            from,
            is_sine: true,
        })
    }

    /// If these limits are harder than those so far, a sixth of the jerk of their ramps from rest to the profile velocity, or from the velocity of
    /// now if that is higher: a quick stop must not last as long as the gentle ramp that it ends.
    pub(super) fn harder_jerk(&self, clock: Clock, from: Exact, limits: Limits) -> Fine {
        let hardest = |limits: Limits| limits.acceleration.max(limits.deceleration);
        let before = self.order.map_or(0, |(_, before, _)| hardest(before));
        if hardest(limits) <= before {
            return 0;
        }
        let speed = clock
            .speed(limits.velocity)
            .max(from.velocity.unsigned_abs());
        sine::jerk_of(clock.half_acceleration(hardest(limits)), speed)
    }
}

/// Whether a motion to `goal` begins with the rest of a sin² ramp whatever it does then: it goes on accelerating, or it has to brake
/// at least as far. `rest` is where the ramp ends, and `change` half of the acceleration of the linear ramp in its place.
fn is_done_anyway(rest: Exact, change: i128, clock: Clock, goal: Goal, limits: Limits) -> bool {
    let end = rest.velocity;
    let is_reverse = if end == 0 { change > 0 } else { end < 0 };
    let rises = (change < 0) == is_reverse;
    let speed = end.unsigned_abs();
    let rate = if rises {
        limits.acceleration
    } else {
        limits.deceleration
    };
    let half = clock.half_acceleration(rate);
    let own = change.unsigned_abs();
    // Harder limits are obeyed, and gentler ones where less speed is not what is wanted. But no braking for the target is longer than this.
    if let Goal::Rest(target) = goal
        && speed == 0
        && distance_to(target, rest).is_some_and(|(gap, _)| gap == 0)
    {
        return true;
    }
    if half > own || rises && half < own {
        return false;
    }
    let top = clock.speed(limits.velocity);
    let (target, passes) = match goal {
        Goal::Velocity(velocity) => {
            let wanted = clock.speed(velocity.unsigned_abs()).min(top);
            let is_along = wanted == 0 || (velocity.bits() < 0) == is_reverse;
            return if rises {
                is_along && wanted >= speed
            } else {
                !is_along || wanted <= speed
            };
        }
        Goal::Rest(target) => (target, Speed::ZERO),
        Goal::Pass(target, end) => (target, end),
    };
    let Some((gap, is_back)) = distance_to(target, rest) else {
        return false;
    };
    let is_ahead = gap == 0 || is_back == is_reverse;
    if speed == 0 {
        return !is_ahead || gap == 0 && passes == Speed::ZERO;
    }
    if rises && speed > top || !rises && speed >= top {
        return !rises;
    }
    // Whether it can be at the velocity to pass with when it gets there: 2·d·gap is not less than v² − e², by whole products.
    let end = clock.speed(passes).min(top);
    let room = match (is_ahead, speed.checked_sub(end)) {
        (false, _) => Ordering::Less,
        (true, None) => Ordering::Greater,
        (true, Some(more)) => {
            let deceleration = clock.half_acceleration(limits.deceleration) << 2;
            Wide::product(deceleration, gap).cmp(&Wide::product(more, speed + end))
        }
    };
    if rises { room.is_ge() } else { room.is_le() }
}

//! How a smooth motion leaves a ramp that is under way.
//!
//! Where the new motion would finish the ramp anyway, it begins with the end of the ramp. Otherwise the acceleration is brought to zero in one cubic
//! piece, at the jerk with which the ramp began, or at that of the new limits if these are harder. Either way the new ramps begin with no
//! acceleration.

use super::builder::Origin;
use super::goal::{Goal, Limits};
use super::move_to::distance_to;
use super::piece::{Instant, Piece, Shape};
use super::smooth::{SMOOTH, Smooth};
use super::{Order, Plan, Ramps, sine};
use crate::clock::{Clock, Ticks};
use crate::divide::quotient;
use crate::exact::{PositionQ96, Q96, Q128, TicksQ32, Uq96, with_sign};
use crate::fixed::Exact;
use crate::speed::Speed;
use crate::u256::U256;
use core::cmp::Ordering;

/// The motion that another one begins with.
#[derive(Debug, Clone)]
pub(crate) struct InitialState {
    pub(crate) tick: Ticks,
    pub(crate) from: Exact,
    /// Linear ramps ignore it.
    pub(crate) acceleration: Smooth<Q96>,
    /// A sixth of the jerk at which the acceleration is brought to zero: no less than the jerk that has built it up,
    /// or the velocity would go on beyond its limit.
    pub(crate) sixth_jerk: Smooth<Q128>,
    /// The goal, limits and ramps that it was planned for, if its ramps are smooth.
    pub(super) order: Smooth<Option<Order>>,
    /// A sin² ramp that is under way and may be finished, in the frame of the axis.
    pub(super) ramp: Smooth<Option<Piece>>,
    /// That ramp is broken off, even if the new motion could finish it.
    pub(super) leaves_ramp: Smooth<bool>,
}

impl InitialState {
    /// With no acceleration.
    pub(crate) const fn steady(tick: Ticks, from: Exact) -> Self {
        Self {
            tick,
            from,
            acceleration: Smooth::new(Q96::ZERO),
            sixth_jerk: Smooth::new(Q128::ZERO),
            order: Smooth::new(None),
            ramp: Smooth::new(None),
            leaves_ramp: Smooth::new(false),
        }
    }

    /// Whether it was planned for this goal already.
    pub(crate) fn is_for(&self, goal: Goal, limits: Limits, ramps: Ramps) -> bool {
        *self.order.get() == Some((goal, limits, ramps))
    }

    /// Has an acceleration, and a sixth of the jerk of which it is.
    pub(crate) const fn accelerate(&mut self, acceleration: Q96, sixth_jerk: Q128) {
        self.acceleration = Smooth::new(acceleration);
        self.sixth_jerk = Smooth::new(sixth_jerk);
    }

    /// Begins with a speed towards the target at once: from rest, or from a lower speed in that direction.
    pub(crate) fn jump(&mut self, speed: Uq96, target_steps: i64) {
        let is_steady = self.acceleration.get().is_zero() && self.ramp.get().is_none();
        let to_target = distance_to(target_steps, self.from.position);
        let Some((gap, is_back)) = to_target.filter(|_| is_steady) else {
            return;
        };
        let now = self.from.velocity;
        let is_along = now.is_zero() || (now < Q96::ZERO) == is_back;
        if !gap.is_zero() && is_along && now.amount() < speed {
            self.from.velocity = with_sign(speed.forwards(), is_back);
        }
    }

    /// Breaks off a ramp that is under way, even if the new motion could finish it.
    pub(crate) const fn leave_ramp(&mut self) {
        self.leaves_ramp = Smooth::new(true);
    }

    /// Moves the origin to where new sin² ramps begin: behind a lead, if there is one.
    // Out of line: what it needs of the stack is free again when the plan is built.
    #[inline(never)]
    pub(super) fn begin_smoothly(
        &self,
        clock: Clock,
        goal: Goal,
        limits: Limits,
        origin: &mut Origin,
    ) {
        origin.is_sine = Smooth::new(true);
        if !self.finish((clock, goal, limits), origin) {
            let jerk = self.sixth_jerk().max(self.harder_jerk(clock, limits));
            self.ease(jerk, origin);
        }
    }

    /// A sixth of the jerk at which its acceleration is brought to zero.
    pub(super) fn sixth_jerk(&self) -> Q128 {
        match self.ramp.get() {
            Some(ramp) if !self.acceleration.get().is_zero() => ramp.sixth_jerk(),
            _ => *self.sixth_jerk.get(),
        }
    }

    /// From where sin² ramps go on when the acceleration has been brought to zero; at once if there is no jerk for that.
    fn ease(&self, sixth_jerk: Q128, origin: &mut Origin) {
        let Self { tick, from, .. } = *self;
        let acceleration = *self.acceleration.get();
        let strength = acceleration.amount();
        let jerk = 6 * sixth_jerk.bits().cast_unsigned();
        // A divisor has 96 bits.
        let time = TicksQ32::from_bits(if jerk >> 96 == 0 {
            quotient(strength.bits(), 2, jerk)
        } else {
            quotient(strength.bits(), 1, jerk >> 32)
        });
        if time.is_zero() {
            return;
        }
        let falls = acceleration < Q96::ZERO;
        let end = Instant::from(tick).after(time);
        let gain = strength.gain(time).halved().forwards();
        let velocity = from.velocity + with_sign(gain, falls);
        let lead = Piece {
            start: tick,
            anchor: end,
            position: PositionQ96::ZERO,
            velocity,
            half_acceleration: Q96::ZERO,
            shape: Smooth::new(Shape::Cubic(with_sign(sixth_jerk, !falls))),
        };
        // However long it lasts and whatever is rounded in it, it begins here.
        let position = from.position - lead.position_at(tick);
        origin.lead = Smooth::new(Some(lead));
        origin.end = end;
        origin.from = Exact { position, velocity };
    }

    /// From where the ramp that is under way ends, if a motion to `goal` finishes it anyway. Returns whether it does.
    fn finish(&self, (clock, goal, limits): (Clock, Goal, Limits), origin: &mut Origin) -> bool {
        let Some(ramp) = self
            .ramp
            .get()
            .as_ref()
            .filter(|_| !*self.leaves_ramp.get())
        else {
            return false;
        };
        let Shape::Sine(time) = *ramp.shape.get() else {
            return false;
        };
        let half = ramp.half_acceleration;
        // From where it is anchored to where it ends.
        let is_braking = Instant::from(self.tick) < ramp.anchor;
        let (end, distance, gain) = if is_braking {
            (ramp.anchor, PositionQ96::ZERO, Q96::ZERO)
        } else {
            let half_gain = half.gain(time);
            let distance = (ramp.velocity + half_gain).distance(time);
            (ramp.anchor.after(time), distance, half_gain.doubled())
        };
        let from = Exact {
            position: ramp.position + distance,
            velocity: ramp.velocity + gain,
        };
        let change = if is_braking { -half } else { half };
        if !is_done_anyway(from, change, clock, goal, limits) {
            return false;
        }
        origin.lead = Smooth::new(Some(Piece {
            start: self.tick,
            position: -distance,
            ..*ramp
        }));
        origin.end = end;
        origin.from = from;
        true
    }

    /// If these limits are harder than the present ones, a sixth of the jerk of a ramp within them between rest and the profile velocity,
    /// or the present velocity if that is higher; otherwise 0. So a quick stop does not last as long as the gentle ramp that it ends.
    fn harder_jerk(&self, clock: Clock, limits: Limits) -> Q128 {
        let hardest = |limits: Limits| limits.acceleration.max(limits.deceleration);
        if !matches!(*self.order.get(), Some((_, before, _)) if hardest(limits) > hardest(before)) {
            return Q128::ZERO;
        }
        let speed = clock
            .speed(limits.velocity)
            .max(self.from.velocity.amount());
        sine::jerk_of(clock.half_acceleration(hardest(limits)), speed)
    }
}

impl Plan {
    /// Makes a steady start that of another motion, at its tick: from linear ramps with no acceleration.
    // Where it stays: a copy costs as much as finding it.
    pub(crate) fn leave(&self, start: &mut InitialState) {
        let at = start.tick;
        if !SMOOTH || self.order.get().is_none() {
            start.from = self.exact_at(at);
            return;
        }
        let (from, acceleration) = self.motion_at(at);
        start.from = from;
        start.order = Smooth::new(self.order.get().filter(|_| at >= self.frame.start));
        start.acceleration = Smooth::new(acceleration);
        match self.find_piece(at) {
            Some((piece, _)) if piece.is_sine() => {
                start.ramp = Smooth::new(Some(piece.placed(&self.frame)));
            }
            _ if acceleration.is_zero() => {}
            Some((piece, _)) if !piece.sixth_jerk().is_zero() => {
                start.sixth_jerk = Smooth::new(piece.sixth_jerk());
            }
            // No jerk has built it up: the ramp is linear, as one of a few ticks is.
            _ if self.sixth_jerk.get().is_zero() => start.acceleration = Smooth::new(Q96::ZERO),
            _ => start.sixth_jerk = self.sixth_jerk,
        }
    }
}

/// Whether a motion to `goal` finishes a sin² ramp whatever it does then: it goes on accelerating, or it has to brake
/// at least as far. `rest` is where the ramp ends, and `change` half of the acceleration of the linear ramp in its place.
fn is_done_anyway(rest: Exact, change: Q96, clock: Clock, goal: Goal, limits: Limits) -> bool {
    let end = rest.velocity;
    let speed = end.amount();
    let is_rest = speed.is_zero();
    let is_reverse = if is_rest {
        change > Q96::ZERO
    } else {
        end < Q96::ZERO
    };
    let rises = (change < Q96::ZERO) == is_reverse;
    let rate = if rises {
        limits.acceleration
    } else {
        limits.deceleration
    };
    let half = clock.half_acceleration(rate);
    let own = change.amount();
    // Harder limits are obeyed, and gentler ones where less speed is not what is wanted. But no braking for the target is longer than this.
    if let Goal::Rest(target) = goal
        && is_rest
        && distance_to(target, rest.position).is_some_and(|(gap, _)| gap.is_zero())
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
            let is_along = wanted.is_zero() || (velocity.bits() < 0) == is_reverse;
            return if rises {
                is_along && wanted >= speed
            } else {
                !is_along || wanted <= speed
            };
        }
        Goal::Rest(target) => (target, Speed::ZERO),
        Goal::Pass(target, end) => (target, end),
    };
    let Some((gap, is_back)) = distance_to(target, rest.position) else {
        return false;
    };
    let is_there = gap.is_zero();
    let is_ahead = is_there || is_back == is_reverse;
    if is_rest {
        return !is_ahead || is_there && passes == Speed::ZERO;
    }
    if rises && speed > top || !rises && speed >= top {
        return !rises;
    }
    // Whether it can be at the velocity to pass with when it gets there: 2·d·gap is not less than v² − e², by whole products.
    let end = clock.speed(passes).min(top);
    let margin = if !is_ahead {
        Ordering::Less
    } else if speed < end {
        Ordering::Greater
    } else {
        let deceleration = clock.half_acceleration(limits.deceleration);
        let (more, sum) = (speed - end, speed + end);
        U256::product(deceleration.bits() << 2, gap.bits())
            .cmp(&U256::product(more.bits(), sum.bits()))
    };
    if rises {
        margin.is_ge()
    } else {
        margin.is_le()
    }
}

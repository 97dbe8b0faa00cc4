//! The jerk-limited ramp: from any velocity and acceleration to a velocity that is kept.
//!
//! The acceleration goes at the jerk j to a greatest value, stays there, and goes at j to zero: at most three pieces. A ramp
//! that begins with no acceleration and gains Δ takes T = √(Δ/j) in each direction; or, if that were beyond the limit A,
//! T = A/j, and stays at A for Δ/A − T. Its distance is its mean velocity times its time.
//!
//! A ramp that begins with an acceleration a is the end of one that began without, a/j earlier and a²/2j away from the velocity of
//! now: its [`VirtualStart`]. If a is in the other direction, it begins as much later instead, and the same formulas hold.

use core::cell::Cell;

use super::number::Number;
use super::rough::{Kind, Rough};
use crate::exact::{PositionQ96, Q96, Q128, TicksQ32, Uq96, with_sign};

/// The jerk, as it is worked with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jerk {
    /// A sixth of it: the coefficient of a cubic. At most `TOP_SIXTH_JERK`.
    pub(crate) sixth: Q128,
    inverse: Number,
    /// All of it.
    pub(super) rough: Rough,
}

impl Jerk {
    pub(super) fn new(sixth: Q128) -> Self {
        let whole = Number::of(sixth.bits() * 6, Kind::Jerk);
        Self {
            sixth,
            inverse: whole.reciprocal(),
            rough: whole.rough(),
        }
    }
}

/// The greatest acceleration of a ramp.
#[derive(Debug, Clone)]
pub(super) struct Limit {
    pub(super) most: Q96,
    number: Number,
    /// The time from no acceleration to this one, at the jerk.
    entry: Number,
    /// The change of velocity in that time.
    half: Number,
    /// The change of velocity while the acceleration grows to the limit and falls again at once, saturating: it may be beyond
    /// all velocities.
    rises: Q96,
    /// Its reciprocal, once it was asked for; and then also the entry as a time.
    inverse: Cell<Number>,
    exact_entry: Cell<TicksQ32>,
    pub(super) rough: RoughLimit,
}

/// The same in rough numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoughLimit {
    pub(super) square: Rough,
    /// The reciprocal of the acceleration.
    pub(super) slowness: Rough,
    pub(super) entry: Rough,
}

impl Limit {
    pub(super) fn new(most: Uq96, jerk: &Jerk) -> Self {
        let most = most.forwards();
        let number = Number::of(most.bits(), Kind::Acceleration);
        let entry = number.times(jerk.inverse);
        let half = number.times(entry).halved();
        let rough = number.rough();
        Self {
            most,
            number,
            entry,
            half,
            rises: Q96::from_bits(half.doubled().bounded(Kind::Velocity)),
            inverse: Cell::new(Number::ZERO),
            exact_entry: Cell::new(TicksQ32::ZERO),
            rough: RoughLimit {
                square: rough.times(rough),
                slowness: Rough::ONE.over(rough),
                entry: entry.rough(),
            },
        }
    }

    #[inline]
    fn inverse(&self) -> Number {
        let known = self.inverse.get();
        if known != Number::ZERO {
            return known;
        }
        let inverse = self.number.reciprocal();
        self.inverse.set(inverse);
        self.exact_entry.set(self.entry.time());
        inverse
    }
}

/// The times of a ramp that begins and ends with no acceleration.
struct Steady {
    /// How long the acceleration grows, and how long it falls again.
    entry: Number,
    /// How long it stays at the limit; none if it does not get there.
    hold: Option<Number>,
}

impl Steady {
    #[inline(always)]
    fn new(gain: Q96, limit: &Limit, jerk: &Jerk) -> Self {
        let held = gain - limit.rises;
        if held >= Q96::ZERO {
            return Self {
                entry: limit.entry,
                hold: Some(Number::of(held.bits(), Kind::Velocity).times(limit.inverse())),
            };
        }
        let square = Number::of(gain.bits(), Kind::Velocity).times(jerk.inverse);
        Self {
            entry: square.root(),
            hold: None,
        }
    }
}

/// How far a ramp goes that begins and ends with no acceleration, saturating. What [`Ramp::become_steady`] would find, without
/// its pieces.
#[inline(never)]
pub(super) fn steady_distance(velocity: Q96, end: Q96, limit: &Limit, jerk: &Jerk) -> PositionQ96 {
    PositionQ96::from_bits(steady_length(velocity, end, limit, jerk).bounded(Kind::Distance))
}

#[inline(always)]
fn steady_length(velocity: Q96, end: Q96, limit: &Limit, jerk: &Jerk) -> Number {
    let gain = (end - velocity).amount().forwards();
    let steady = Steady::new(gain, limit, jerk);
    let time = match steady.hold {
        None => steady.entry,
        Some(hold) => steady.entry.plus(hold.halved()),
    };
    let sum = Number::of((velocity + end).bits(), Kind::Velocity);
    sum.times(time)
}

/// How far a ramp to rest goes, saturating: [`Ramp::distance`], which wraps, is wrong for a long one.
#[cold]
#[inline(never)]
pub(super) fn stopping_distance(from: &Motion, limit: &Limit, jerk: &Jerk) -> PositionQ96 {
    let falls = from.coasting() > Q96::ZERO;
    let turned = |value: Number| if falls { value.negated() } else { value };
    let mut virtual_start = VirtualStart::new(from, falls, limit);
    let ahead = if virtual_start.is_easing {
        virtual_start.ease(from, limit)
    } else {
        let (time, change) = (turned(from.time), turned(from.change));
        let mean = virtual_start.speed().plus(change.times(Number::THIRD));
        time.times(mean).negated()
    };
    let length = steady_length(virtual_start.velocity, Q96::ZERO, limit, jerk);
    PositionQ96::from_bits(length.plus(ahead).bounded(Kind::Distance))
}

/// A velocity with an acceleration.
#[derive(Debug)]
pub(super) struct Motion {
    pub(super) velocity: Q96,
    pub(super) acceleration: Q96,
    /// The time in which the acceleration goes to zero at the jerk; negative if the acceleration is.
    pub(super) time: Number,
    /// The change of velocity in that time.
    pub(super) change: Number,
    /// The same, exactly.
    exact_change: Q96,
}

impl Motion {
    pub(super) const REST: Self = Self {
        velocity: Q96::ZERO,
        acceleration: Q96::ZERO,
        time: Number::ZERO,
        change: Number::ZERO,
        exact_change: Q96::ZERO,
    };

    /// One without acceleration.
    pub(super) const fn steady(velocity: Q96) -> Self {
        Self {
            velocity,
            ..Self::REST
        }
    }

    pub(super) fn new(velocity: Q96, acceleration: Q96, jerk: &Jerk) -> Self {
        if acceleration.is_zero() {
            return Self::steady(velocity);
        }
        let number = Number::of(acceleration.bits(), Kind::Acceleration);
        let time = number.times(jerk.inverse);
        let change = number.times(time).halved();
        Self {
            velocity,
            acceleration,
            time,
            change,
            exact_change: change.velocity(),
        }
    }

    pub(super) const fn is_rest(&self) -> bool {
        self.velocity.is_zero() && self.acceleration.is_zero()
    }

    /// The velocity at the end, if the acceleration now goes to zero at the jerk.
    pub(super) fn coasting(&self) -> Q96 {
        if self.acceleration < Q96::ZERO {
            self.velocity - self.exact_change
        } else {
            self.velocity + self.exact_change
        }
    }
}

/// Where a ramp that begins with an acceleration would have begun at the same jerk from an acceleration of zero: the ramp is the
/// last part of that longer one.
#[derive(Debug)]
pub(super) struct VirtualStart {
    /// How far the motion is ahead of the virtual start.
    pub(super) ahead: PositionQ96,
    /// How long ago the virtual start is, Q32 ticks; negative if it is still to come.
    ago: i128,
    /// The velocity there.
    pub(super) velocity: Q96,
    /// The ramp goes downwards.
    pub(super) falls: bool,
    /// The acceleration is beyond the limit: first of all it falls to that.
    is_easing: bool,
    /// `ahead` is 2³¹ steps or more, and so not what it says: no distance has room for this ramp.
    pub(super) is_far: bool,
}

impl VirtualStart {
    /// Of a ramp upwards or downwards. `limit` is its greatest acceleration.
    pub(super) fn new(from: &Motion, falls: bool, limit: &Limit) -> Self {
        let mut virtual_start = Self::steady(from.velocity, falls);
        if !from.acceleration.is_zero() {
            virtual_start.come_from(from, limit);
        }
        virtual_start
    }

    /// Becomes another one, as [`VirtualStart::new`] would have it: it is large, and copies of it are costly.
    pub(super) fn renew(&mut self, from: &Motion, falls: bool, limit: &Limit) {
        self.velocity = from.velocity;
        self.ahead = PositionQ96::ZERO;
        self.ago = 0;
        self.falls = falls;
        self.is_easing = false;
        self.is_far = false;
        if !from.acceleration.is_zero() {
            self.come_from(from, limit);
        }
    }

    /// The same of one that begins with an acceleration.
    #[inline(never)]
    fn come_from(&mut self, from: &Motion, limit: &Limit) {
        let falls = self.falls;
        if with_sign(from.acceleration, falls) > limit.most {
            self.ease(from, limit);
            return;
        }
        let turned = |value: Number| if falls { value.negated() } else { value };
        let (time, change) = (turned(from.time), turned(from.change));
        self.velocity = from.velocity - with_sign(from.exact_change, falls);
        let distance = time.times(self.speed());
        let by_jerk = time.times(change).times(Number::THIRD);
        // Most are so short that the sum need not be made for that.
        self.is_far = distance.may_exceed(29) | by_jerk.may_exceed(29)
            && distance.plus(by_jerk).saturates(Kind::Distance);
        self.ahead = -(distance.distance() + by_jerk.distance());
        self.ago = time.fixed(Kind::Time);
    }

    fn speed(&self) -> Number {
        Number::of(self.velocity.bits(), Kind::Velocity)
    }

    /// Of a ramp that begins with no acceleration.
    pub(super) const fn steady(velocity: Q96, falls: bool) -> Self {
        Self {
            velocity,
            ahead: PositionQ96::ZERO,
            ago: 0,
            falls,
            is_easing: false,
            is_far: false,
        }
    }

    /// The acceleration falls to the limit; from there on it is a ramp that has been at its limit from the beginning. Returns how far the
    /// motion is ahead of that.
    #[inline(never)]
    fn ease(&mut self, from: &Motion, limit: &Limit) -> Number {
        let falls = self.falls;
        let turned = |value: Number| if falls { value.negated() } else { value };
        let (time, change) = (turned(from.time), turned(from.change));
        let rise = turned(limit.half);
        self.velocity = from.velocity + change.minus(rise.doubled()).velocity();
        // With T for the entry and t for the time that the acceleration would need to zero: v·(t − 2T) + j·(t³/3 − t²·T + T³).
        let since = time.minus(limit.entry.doubled());
        let fallen = time.times(Number::THIRD).minus(limit.entry);
        let by_jerk = change.times(fallen).plus(rise.times(limit.entry));
        let ahead = Number::of(from.velocity.bits(), Kind::Velocity)
            .times(since)
            .plus(by_jerk.doubled());
        self.is_far = ahead.saturates(Kind::Distance);
        self.ahead = ahead.distance();
        self.ago = since.negated().fixed(Kind::Time);
        self.is_easing = true;
        ahead
    }
}

/// A change of velocity: how long its pieces last, what it begins and ends with, and how far it goes. What else its pieces are is worked
/// out when they are entered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ramp {
    /// At its beginning.
    pub(super) velocity: Q96,
    pub(super) acceleration: Q96,
    /// At its end, where there is no acceleration.
    pub(super) end: Q96,
    /// How far it goes.
    pub(super) distance: PositionQ96,
    /// How long the acceleration goes to the greatest value, stays there, and goes to zero.
    pub(super) entry: TicksQ32,
    pub(super) hold: TicksQ32,
    pub(super) exit: TicksQ32,
    /// The limit of the acceleration, whichever its direction.
    pub(super) most: Q96,
    /// A sixth of the jerk, whichever its direction.
    pub(super) sixth_jerk: Q128,
    pub(super) falls: bool,
    /// It begins with more than the greatest acceleration, and so against the direction of the change.
    pub(super) is_easing: bool,
}

impl Ramp {
    /// Rest.
    pub(super) const NONE: Self = Self {
        velocity: Q96::ZERO,
        acceleration: Q96::ZERO,
        end: Q96::ZERO,
        distance: PositionQ96::ZERO,
        entry: TicksQ32::ZERO,
        hold: TicksQ32::ZERO,
        exit: TicksQ32::ZERO,
        most: Q96::ZERO,
        sixth_jerk: Q128::ZERO,
        falls: false,
        is_easing: false,
    };

    /// From a motion and its virtual start to the velocity `end`.
    #[cfg(test)]
    pub(super) fn new(
        (from, virtual_start): (&Motion, &VirtualStart),
        end: Q96,
        limit: &Limit,
        jerk: &Jerk,
    ) -> Self {
        let mut ramp = Self::NONE;
        ramp.become_of((from, virtual_start), end, limit, jerk);
        ramp
    }

    /// Becomes another one, from a motion and its virtual start to the velocity `end`.
    pub(super) fn become_of(
        &mut self,
        (from, virtual_start): (&Motion, &VirtualStart),
        end: Q96,
        limit: &Limit,
        jerk: &Jerk,
    ) {
        self.become_steady(
            (virtual_start.velocity, virtual_start.falls),
            end,
            limit,
            jerk,
        );
        self.velocity = from.velocity;
        self.acceleration = from.acceleration;
        self.distance = self.distance + virtual_start.ahead;
        let entry = self.exit.bits().cast_signed() - virtual_start.ago;
        self.entry = TicksQ32::from_bits(entry.max(0).cast_unsigned());
        self.is_easing = virtual_start.is_easing;
    }

    /// Becomes the one that begins with a velocity and no acceleration.
    #[inline(never)]
    pub(super) fn become_steady(
        &mut self,
        (velocity, falls): (Q96, bool),
        end: Q96,
        limit: &Limit,
        jerk: &Jerk,
    ) {
        self.velocity = velocity;
        self.acceleration = Q96::ZERO;
        self.end = end;
        self.falls = falls;
        self.is_easing = false;
        self.sixth_jerk = jerk.sixth;
        let gain = with_sign(end - velocity, falls);
        let Steady { entry, hold } = Steady::new(gain.max(Q96::ZERO), limit, jerk);
        let (exit, hold) = match hold {
            None => (entry.time(), TicksQ32::ZERO),
            Some(hold) => (limit.exact_entry.get(), hold.time()),
        };
        self.most = limit.most;
        self.entry = exit;
        self.hold = hold;
        self.exit = exit;
        // Its mean velocity is that of its ends.
        self.distance = (velocity + end).distance(exit + hold.halved());
    }

    /// Turns it into the same in the other direction of motion.
    pub(super) fn mirror(&mut self) {
        self.velocity = -self.velocity;
        self.acceleration = -self.acceleration;
        self.end = -self.end;
        self.distance = -self.distance;
        self.falls = !self.falls;
    }

    /// How long it takes.
    pub(super) fn time(&self) -> TicksQ32 {
        self.entry + self.hold + self.exit
    }
}

/// A third of a speed.
#[inline(always)]
pub(super) fn third(speed: Uq96) -> Uq96 {
    /// Of 2⁶⁴.
    const THIRD: u64 = u64::MAX / 3;
    let low = (u128::from(speed.bits() as u64) * u128::from(THIRD)) >> 64;
    Uq96::from_bits((speed.bits() >> 64) * u128::from(THIRD) + low)
}

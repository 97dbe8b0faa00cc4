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
use crate::clock::{Uq96, Uq128};
use crate::plan::piece::{TicksQ32, distance_at};

/// The jerk, as it is worked with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jerk {
    /// A sixth of it, Q128 steps per tick³: the coefficient of a cubic. At most `TOP_SIXTH_JERK`.
    pub(crate) sixth: Uq128,
    inverse: Number,
    /// All of it.
    pub(super) rough: Rough,
}

impl Jerk {
    pub(super) fn new(sixth: Uq128) -> Self {
        let whole = Number::of(sixth.wrapping_mul(6).cast_signed(), Kind::Jerk);
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
    /// Q96 steps per tick².
    pub(super) most: i128,
    number: Number,
    /// The time from no acceleration to this one, at the jerk.
    entry: Number,
    /// The change of velocity in that time.
    half: Number,
    /// The change of velocity while the acceleration grows to the limit and falls again at once, Q96, saturating: it may be beyond
    /// all velocities.
    rises: i128,
    /// Its reciprocal, once it was asked for; and then also the entry in Q32 ticks.
    inverse: Cell<Number>,
    exact_entry: Cell<i128>,
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
        let most = most.cast_signed();
        let number = Number::of(most, Kind::Acceleration);
        let entry = number.times(jerk.inverse);
        let half = number.times(entry).halved();
        let rough = number.rough();
        Self {
            most,
            number,
            entry,
            half,
            rises: half.doubled().bounded(Kind::Velocity),
            inverse: Cell::new(Number::ZERO),
            exact_entry: Cell::new(0),
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
        self.exact_entry.set(self.entry.fixed(Kind::Time));
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
    fn new(gain: i128, limit: &Limit, jerk: &Jerk) -> Self {
        let held = gain.wrapping_sub(limit.rises);
        if held >= 0 {
            return Self {
                entry: limit.entry,
                hold: Some(Number::of(held, Kind::Velocity).times(limit.inverse())),
            };
        }
        let square = Number::of(gain, Kind::Velocity).times(jerk.inverse);
        Self {
            entry: square.root(),
            hold: None,
        }
    }
}

/// How far a ramp goes that begins and ends with no acceleration, Q96 steps, saturating. What [`Ramp::become_steady`] would find, without
/// its pieces.
#[inline(never)]
pub(super) fn steady_distance(velocity: i128, end: i128, limit: &Limit, jerk: &Jerk) -> i128 {
    steady_length(velocity, end, limit, jerk).bounded(Kind::Distance)
}

#[inline(always)]
fn steady_length(velocity: i128, end: i128, limit: &Limit, jerk: &Jerk) -> Number {
    let gain = end.wrapping_sub(velocity).unsigned_abs().cast_signed();
    let steady = Steady::new(gain, limit, jerk);
    let time = match steady.hold {
        None => steady.entry,
        Some(hold) => steady.entry.plus(hold.halved()),
    };
    let sum = Number::of(velocity.wrapping_add(end), Kind::Velocity);
    sum.times(time)
}

/// How far a ramp to rest goes, Q96 steps, saturating: [`Ramp::distance`], which wraps, is wrong for a long one.
#[cold]
#[inline(never)]
pub(super) fn stopping_distance(from: &Motion, limit: &Limit, jerk: &Jerk) -> i128 {
    let falls = from.coasting() > 0;
    let turned = |value: Number| if falls { value.negated() } else { value };
    let mut virtual_start = VirtualStart::new(from, falls, limit);
    let ahead = if virtual_start.is_easing {
        virtual_start.ease(from, limit)
    } else {
        let (time, change) = (turned(from.time), turned(from.change));
        let mean = virtual_start.speed().plus(change.times(Number::THIRD));
        time.times(mean).negated()
    };
    steady_length(virtual_start.velocity, 0, limit, jerk)
        .plus(ahead)
        .bounded(Kind::Distance)
}

/// A velocity with an acceleration.
#[derive(Debug)]
pub(super) struct Motion {
    pub(super) velocity: i128,
    pub(super) acceleration: i128,
    /// The time in which the acceleration goes to zero at the jerk; negative if the acceleration is.
    pub(super) time: Number,
    /// The change of velocity in that time.
    pub(super) change: Number,
    /// The same, Q96.
    exact_change: i128,
}

impl Motion {
    pub(super) const REST: Self = Self {
        velocity: 0,
        acceleration: 0,
        time: Number::ZERO,
        change: Number::ZERO,
        exact_change: 0,
    };

    /// One without acceleration.
    pub(super) const fn steady(velocity: i128) -> Self {
        Self {
            velocity,
            ..Self::REST
        }
    }

    pub(super) fn new(velocity: i128, acceleration: i128, jerk: &Jerk) -> Self {
        if acceleration == 0 {
            return Self::steady(velocity);
        }
        let number = Number::of(acceleration, Kind::Acceleration);
        let time = number.times(jerk.inverse);
        let change = number.times(time).halved();
        Self {
            velocity,
            acceleration,
            time,
            change,
            exact_change: change.fixed(Kind::Velocity),
        }
    }

    pub(super) const fn is_rest(&self) -> bool {
        self.velocity == 0 && self.acceleration == 0
    }

    /// The velocity at the end, if the acceleration now goes to zero at the jerk.
    pub(super) const fn coasting(&self) -> i128 {
        if self.acceleration < 0 {
            self.velocity.wrapping_sub(self.exact_change)
        } else {
            self.velocity.wrapping_add(self.exact_change)
        }
    }
}

/// Where a ramp that begins with an acceleration would have begun at the same jerk from an acceleration of zero: the ramp is the
/// last part of that longer one.
#[derive(Debug)]
pub(super) struct VirtualStart {
    /// How far the motion is ahead of the virtual start, Q96 steps.
    pub(super) ahead: i128,
    /// How long ago the virtual start is, Q32 ticks; negative if it is still to come.
    ago: i128,
    /// The velocity there.
    pub(super) velocity: i128,
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
        if from.acceleration != 0 {
            virtual_start.come_from(from, limit);
        }
        virtual_start
    }

    /// Becomes another one, as [`VirtualStart::new`] would have it: it is large, and copies of it are costly.
    pub(super) fn renew(&mut self, from: &Motion, falls: bool, limit: &Limit) {
        self.velocity = from.velocity;
        self.ahead = 0;
        self.ago = 0;
        self.falls = falls;
        self.is_easing = false;
        self.is_far = false;
        if from.acceleration != 0 {
            self.come_from(from, limit);
        }
    }

    /// The same of one that begins with an acceleration.
    #[inline(never)]
    fn come_from(&mut self, from: &Motion, limit: &Limit) {
        let falls = self.falls;
        let acceleration = if falls {
            from.acceleration.wrapping_neg()
        } else {
            from.acceleration
        };
        if acceleration > limit.most {
            self.ease(from, limit);
            return;
        }
        let turned = |value: Number| if falls { value.negated() } else { value };
        let (time, change) = (turned(from.time), turned(from.change));
        let exact_change = if falls {
            from.exact_change.wrapping_neg()
        } else {
            from.exact_change
        };
        self.velocity = from.velocity.wrapping_sub(exact_change);
        let distance = time.times(self.speed());
        let by_jerk = time.times(change).times(Number::THIRD);
        // Most are so short that the sum need not be made for that.
        self.is_far = distance.may_exceed(29) | by_jerk.may_exceed(29)
            && distance.plus(by_jerk).saturates(Kind::Distance);
        let (distance, by_jerk) = (
            distance.fixed(Kind::Distance),
            by_jerk.fixed(Kind::Distance),
        );
        self.ahead = distance.wrapping_add(by_jerk).wrapping_neg();
        self.ago = time.fixed(Kind::Time);
    }

    fn speed(&self) -> Number {
        Number::of(self.velocity, Kind::Velocity)
    }

    /// Of a ramp that begins with no acceleration.
    pub(super) const fn steady(velocity: i128, falls: bool) -> Self {
        Self {
            velocity,
            ahead: 0,
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
        self.velocity = from
            .velocity
            .wrapping_add(change.minus(rise.doubled()).fixed(Kind::Velocity));
        // With T for the entry and t for the time that the acceleration would need to zero: v·(t − 2T) + j·(t³/3 − t²·T + T³).
        let since = time.minus(limit.entry.doubled());
        let fallen = time.times(Number::THIRD).minus(limit.entry);
        let by_jerk = change.times(fallen).plus(rise.times(limit.entry));
        let ahead = Number::of(from.velocity, Kind::Velocity)
            .times(since)
            .plus(by_jerk.doubled());
        self.is_far = ahead.saturates(Kind::Distance);
        self.ahead = ahead.fixed(Kind::Distance);
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
    pub(super) velocity: i128,
    pub(super) acceleration: i128,
    /// At its end, where there is no acceleration.
    pub(super) end: i128,
    /// How far it goes, Q96 steps; modulo 2³² steps.
    pub(super) distance: i128,
    /// How long the acceleration goes to the greatest value, stays there, and goes to zero.
    pub(super) entry: TicksQ32,
    pub(super) hold: TicksQ32,
    pub(super) exit: TicksQ32,
    /// The limit of the acceleration, whichever its direction.
    pub(super) most: i128,
    /// A sixth of the jerk, Q128, whichever its direction.
    pub(super) sixth_jerk: i128,
    pub(super) falls: bool,
    /// It begins with more than the greatest acceleration, and so against the direction of the change.
    pub(super) is_easing: bool,
}

impl Ramp {
    /// Rest.
    pub(super) const NONE: Self = Self {
        velocity: 0,
        acceleration: 0,
        end: 0,
        distance: 0,
        entry: 0,
        hold: 0,
        exit: 0,
        most: 0,
        sixth_jerk: 0,
        falls: false,
        is_easing: false,
    };

    /// From a motion and its virtual start to the velocity `end`.
    #[cfg(test)]
    pub(super) fn new(
        (from, virtual_start): (&Motion, &VirtualStart),
        end: i128,
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
        end: i128,
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
        self.distance = self.distance.wrapping_add(virtual_start.ahead);
        let entry = self
            .exit
            .cast_signed()
            .wrapping_sub(virtual_start.ago)
            .max(0);
        self.entry = entry.cast_unsigned();
        self.is_easing = virtual_start.is_easing;
    }

    /// Becomes the one that begins with a velocity and no acceleration.
    #[inline(never)]
    pub(super) fn become_steady(
        &mut self,
        (velocity, falls): (i128, bool),
        end: i128,
        limit: &Limit,
        jerk: &Jerk,
    ) {
        self.velocity = velocity;
        self.acceleration = 0;
        self.end = end;
        self.falls = falls;
        self.is_easing = false;
        self.sixth_jerk = jerk.sixth.cast_signed();
        let gain = end.wrapping_sub(velocity);
        let gain = if falls { gain.wrapping_neg() } else { gain };
        let Steady { entry, hold } = Steady::new(gain.max(0), limit, jerk);
        let (exit, hold) = match hold {
            None => (entry.fixed(Kind::Time), 0),
            Some(hold) => (limit.exact_entry.get(), hold.fixed(Kind::Time)),
        };
        let (exit, hold) = (exit.cast_unsigned(), hold.cast_unsigned());
        self.most = limit.most;
        self.entry = exit;
        self.hold = hold;
        self.exit = exit;
        // Its mean velocity is that of its ends.
        let sum = velocity.wrapping_add(end);
        self.distance = distance_at(sum, exit.wrapping_add(hold >> 1));
    }

    /// Turns it into the same in the other direction of motion.
    pub(super) fn mirror(&mut self) {
        self.velocity = self.velocity.wrapping_neg();
        self.acceleration = self.acceleration.wrapping_neg();
        self.end = self.end.wrapping_neg();
        self.distance = self.distance.wrapping_neg();
        self.falls = !self.falls;
    }

    /// How long it takes.
    pub(super) fn time(&self) -> TicksQ32 {
        self.entry.wrapping_add(self.hold).wrapping_add(self.exit)
    }
}

/// A third of a number of 96 bits.
#[inline(always)]
pub(super) fn third(value: u128) -> u128 {
    /// Of 2⁶⁴.
    const THIRD: u64 = u64::MAX / 3;
    let low = u128::from(value as u64).wrapping_mul(THIRD.into()) >> 64;
    (value >> 64).wrapping_mul(THIRD.into()).wrapping_add(low)
}

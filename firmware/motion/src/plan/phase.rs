//! One phase of a plan: a polynomial of degree 3 at most, which is evaluated without rounding up to degree 2.
//!
//! Coefficients are Q96 in 128 bits and time is a whole number of ticks from the phase's anchor, so x = x₀ + n·(v + n·h) in wrapping
//! arithmetic is exact modulo 2³² steps, which is the span of a position. There is no error to accumulate, however
//! long the phase; a cruise that never ends needs no new anchor. The coefficient of a cubic is Q128: over the time that a jerk lasts, its
//! rounding does not show.

use super::smooth::Smooth;
use crate::clock::{Clock, Ticks};
use crate::fixed::{Exact, Q96, Q128, State, product};
use crate::low;
use crate::stepper::polynomial::Polynomial;
use crate::u256::U256;

/// A stretch of constant jerk; most often there is none.
#[derive(Debug, Clone, Copy)]
pub struct Phase {
    /// The first tick that belongs to it.
    start: Ticks,
    /// The tick for which the coefficients hold.
    anchor: Ticks,
    position: i128,
    velocity: i128,
    half_acceleration: i128,
    /// A sixth of the jerk, Q128 steps per tick³.
    sixth_jerk: Smooth<i128>,
}

impl Phase {
    pub(crate) const NONE: Self = Self {
        start: 0,
        anchor: 0,
        position: 0,
        velocity: 0,
        half_acceleration: 0,
        sixth_jerk: Smooth::NONE,
    };

    /// A parabola that begins in a state, with half of an acceleration, Q96 steps per tick².
    pub(crate) const fn parabola(start: Ticks, from: Exact, half_acceleration: i128) -> Self {
        Self {
            start,
            anchor: start,
            position: from.position,
            velocity: from.velocity,
            half_acceleration,
            ..Self::NONE
        }
    }

    /// A polynomial of degree 3 that is at `position` with `velocity` at its anchor; half of the acceleration there, and a sixth of the jerk.
    pub(super) const fn cubic(
        (start, anchor): (Ticks, Ticks),
        position: i128,
        velocity: i128,
        (half_acceleration, sixth_jerk): (i128, i128),
    ) -> Self {
        Self {
            start,
            anchor,
            position,
            velocity,
            half_acceleration,
            sixth_jerk: Smooth::new(sixth_jerk),
        }
    }

    /// The first tick of this phase.
    pub const fn start(&self) -> Ticks {
        self.start
    }

    /// The acceleration at the start of the phase in steps/s², to the nearest.
    pub fn acceleration(&self, clock: Clock) -> i64 {
        self.acceleration_at(clock, self.start)
    }

    /// The acceleration at tick `t` of the phase in steps/s², to the nearest.
    pub fn acceleration_at(&self, clock: Clock, t: Ticks) -> i64 {
        let acceleration = self.acceleration_exact(t);
        let rate = u128::from(clock.hz());
        let magnitude = low::u64(
            U256::product(acceleration.unsigned_abs(), rate * rate)
                .plus(U256::product(1 << 95, 1))
                .shifted_wrapping(96),
        )
        .cast_signed();
        if acceleration < 0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        }
    }

    /// The acceleration at tick `t`, Q96 steps per tick².
    pub(crate) fn acceleration_exact(&self, t: Ticks) -> i128 {
        let rise = whole(times(*self.sixth_jerk.get(), self.since_anchor(t)));
        2 * (self.half_acceleration + 3 * rise)
    }

    /// The state at tick `t` of the phase.
    pub fn state_at(&self, t: Ticks) -> State {
        self.at(t).rounded()
    }

    /// The exact state at tick `t`.
    #[inline(never)]
    pub(crate) fn at(&self, t: Ticks) -> Exact {
        let n = self.since_anchor(t);
        // Most of the time is spent in cruises, and wide products take long.
        let (half, rise) = match (*self.sixth_jerk.get(), self.half_acceleration) {
            (0, half) => (half, 0),
            (sixth_jerk, half) => {
                let rise = whole(times(sixth_jerk, n));
                (half + rise, rise)
            }
        };
        let gain = if half == 0 { 0 } else { times(half, n) };
        let change = gain
            .wrapping_mul(2)
            .wrapping_add(if rise == 0 { 0 } else { times(rise, n) });
        Exact {
            position: times(self.velocity.wrapping_add(gain), n).wrapping_add(self.position),
            velocity: self.velocity.wrapping_add(change),
        }
    }

    /// How it goes on from tick `t` up to `end`, its own or an earlier one.
    pub(crate) fn polynomial(&self, t: Ticks, end: Ticks) -> Polynomial {
        Polynomial {
            half: Q96(self.acceleration_exact(t) >> 1),
            sixth: Q128(*self.sixth_jerk.get()),
            ..Polynomial::line(end, self.at(t))
        }
    }

    fn since_anchor(&self, t: Ticks) -> i128 {
        i128::from(t.wrapping_sub(self.anchor).cast_signed())
    }

    /// Half of the acceleration at the anchor, Q96 steps per tick²; of a parabola, that everywhere.
    pub(crate) const fn half_acceleration(&self) -> i128 {
        self.half_acceleration
    }

    /// Whether it is one parabola, so that the longest chord is the same everywhere.
    pub(crate) const fn is_parabola(&self) -> bool {
        *self.sixth_jerk.get() == 0
    }

    /// Whether its velocity is constant.
    pub(crate) const fn is_line(&self) -> bool {
        self.is_parabola() && self.half_acceleration == 0
    }
}

/// A product modulo 2¹²⁸. Within 2³² ticks of the anchor, 25 s at 168 MHz, it is four short ones.
#[inline]
fn times(value: i128, ticks: i128) -> i128 {
    let Ok(factor) = u32::try_from(ticks.unsigned_abs()) else {
        return value.wrapping_mul(ticks);
    };
    let product = product(value, factor);
    if ticks < 0 {
        product.wrapping_neg()
    } else {
        product
    }
}

/// value / 2³² towards zero, which treats both directions alike.
pub(super) fn whole(value: i128) -> i128 {
    let magnitude = (value.unsigned_abs() >> 32).cast_signed();
    if value < 0 {
        magnitude.wrapping_neg()
    } else {
        magnitude
    }
}

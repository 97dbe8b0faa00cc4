//! One phase of a plan: a polynomial of degree 3 at most, which is evaluated without rounding up to degree 2.
//!
//! Coefficients are Q96 in 128 bits and time is a whole number of ticks from the phase's anchor, so x = x₀ + n·(v + n·h) in wrapping
//! arithmetic is exact modulo 2³² steps, which is the span of a position. There is no error to accumulate, however
//! long the phase; a cruise that never ends needs no new anchor. The coefficient of a cubic is Q128: over the time that a jerk lasts, its
//! rounding does not show.

use crate::clock::{Clock, Ticks};
use crate::exact::{PositionQ96, Q96, Q128};
use crate::fixed::{Exact, State};
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
    position: PositionQ96,
    velocity: Q96,
    half_acceleration: Q96,
    sixth_jerk: Q128,
}

impl Phase {
    pub(crate) const NONE: Self = Self {
        start: 0,
        anchor: 0,
        position: PositionQ96::ZERO,
        velocity: Q96::ZERO,
        half_acceleration: Q96::ZERO,
        sixth_jerk: Q128::ZERO,
    };

    /// A parabola that begins in a state, with half of an acceleration.
    pub(crate) const fn parabola(start: Ticks, from: Exact, half_acceleration: Q96) -> Self {
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
    pub(crate) const fn cubic(
        (start, anchor): (Ticks, Ticks),
        position: PositionQ96,
        velocity: Q96,
        (half_acceleration, sixth_jerk): (Q96, Q128),
    ) -> Self {
        Self {
            start,
            anchor,
            position,
            velocity,
            half_acceleration,
            sixth_jerk,
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
            U256::product(acceleration.amount().bits(), rate * rate)
                .plus(U256::product(1 << 95, 1))
                .shifted_wrapping(96),
        )
        .cast_signed();
        if acceleration < Q96::ZERO {
            magnitude.wrapping_neg()
        } else {
            magnitude
        }
    }

    /// The acceleration at tick `t`.
    pub(crate) fn acceleration_exact(&self, t: Ticks) -> Q96 {
        self.half_acceleration_at(t).doubled()
    }

    fn half_acceleration_at(&self, t: Ticks) -> Q96 {
        let rise = self.sixth_jerk.even_gain(self.since_anchor(t));
        self.half_acceleration + rise.doubled() + rise
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
        let (half, rise) = match (self.sixth_jerk, self.half_acceleration) {
            (Q128::ZERO, half) => (half, Q96::ZERO),
            (sixth_jerk, half) => {
                let rise = sixth_jerk.even_gain(n);
                (half + rise, rise)
            }
        };
        let mut gain = Q96::ZERO;
        if !half.is_zero() {
            gain = half.gain(n);
        }
        let mut change = gain.doubled();
        if !rise.is_zero() {
            change = change + rise.gain(n);
        }
        Exact {
            position: (self.velocity + gain).distance(n) + self.position,
            velocity: self.velocity + change,
        }
    }

    /// How it goes on from tick `t` up to `end`, its own or an earlier one.
    pub(crate) fn polynomial(&self, t: Ticks, end: Ticks) -> Polynomial {
        Polynomial {
            half: self.half_acceleration_at(t),
            sixth: self.sixth_jerk,
            ..Polynomial::line(end, self.at(t))
        }
    }

    /// In ticks, negative before it.
    const fn since_anchor(&self, t: Ticks) -> i64 {
        t.wrapping_sub(self.anchor).cast_signed()
    }

    /// Half of the acceleration at the anchor; of a parabola, that everywhere.
    pub(crate) const fn half_acceleration(&self) -> Q96 {
        self.half_acceleration
    }
}

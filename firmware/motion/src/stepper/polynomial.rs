//! A polynomial of degree 3 at most: a part of a trajectory, along which the stepper advances.
//!
//! Position, velocity, half of the acceleration and a sixth of the jerk are those at one tick; to advance by n ticks is to compute all of
//! them for the later tick. Lines and parabolas are advanced without rounding. The rounding of a cubic is less than 2⁻³⁰ steps in a minute.

use crate::clock::Ticks;
use crate::divide::div_rem;
use crate::exact::{PositionQ96, Q96, Q128};
use crate::fixed::Exact;

/// How the position goes on from a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Polynomial {
    /// The first tick behind it; `Ticks::MAX` if it never ends.
    pub(crate) end: Ticks,
    pub(crate) position: PositionQ96,
    pub(crate) velocity: Q96,
    /// Half of the acceleration.
    pub(crate) half: Q96,
    /// A sixth of the jerk.
    pub(crate) sixth: Q128,
}

impl Polynomial {
    /// Nothing: it has ended.
    pub(crate) const NONE: Self = Self::line(0, Exact::at_rest(PositionQ96::ZERO));

    /// A line: at the velocity that it begins with.
    pub(crate) const fn line(end: Ticks, from: Exact) -> Self {
        Self {
            end,
            position: from.position,
            velocity: from.velocity,
            half: Q96::ZERO,
            sixth: Q128::ZERO,
        }
    }

    /// The cubic from one state to another, so many ticks later, which are at least 1.
    pub(crate) fn between(from: Exact, (end, to): (Ticks, Exact), length: u32) -> Self {
        // x = x₀ + v₀·n + b·(n / length)² + c·(n / length)³
        let distance = to.position - from.position;
        let first = from.velocity.distance(length);
        let last = to.velocity.distance(length);
        let c = first + last - distance - distance;
        let b = distance - first - c;
        let (reciprocal, _) = div_rem(u64::MAX, length);
        Self {
            half: b.per_tick(reciprocal).part(reciprocal),
            sixth: Q128::from(c.per_tick(reciprocal).part(reciprocal)).part(reciprocal),
            ..Self::line(end, from)
        }
    }

    /// Whether its velocity is constant.
    #[inline]
    pub(crate) const fn is_line(&self) -> bool {
        self.half.is_zero() && self.sixth.is_zero()
    }

    /// Advances by so many ticks, if its velocity is constant.
    #[inline]
    pub(crate) fn advance_line_by(&mut self, ticks: u32) {
        self.position = self.position + self.velocity.distance(ticks);
    }

    /// Advances by so many ticks.
    pub(crate) fn advance_by(&mut self, ticks: u32) {
        let mut half = self.half;
        let mut growth = Q96::ZERO;
        if !self.sixth.is_zero() {
            growth = self.sixth.gain(ticks);
            half = half + growth;
            self.half = half + growth + growth;
        }
        if half.is_zero() && growth.is_zero() {
            self.advance_line_by(ticks);
            return;
        }
        let gain = half.gain(ticks);
        let mean = self.velocity + gain;
        self.position = self.position + mean.distance(ticks);
        self.velocity = mean + gain;
        if !growth.is_zero() {
            self.velocity = self.velocity + growth.gain(ticks);
        }
    }

    /// The state that it has come to.
    #[inline]
    pub(crate) const fn exact(&self) -> Exact {
        Exact {
            position: self.position,
            velocity: self.velocity,
        }
    }

    /// The longest chord, a power of two in ticks, that is nowhere more than a quarter of a step off the polynomial from its present tick
    /// `begin` up to its end: ½a·len²/4 ≤ ¼.
    pub(crate) fn longest_chord(&self, begin: Ticks) -> u64 {
        let mut max = self.half.amount();
        if !self.sixth.is_zero() {
            // The acceleration is greatest at an end.
            let length = self.end.saturating_sub(begin);
            let length = u32::try_from(length).unwrap_or(u32::MAX);
            let growth = self.sixth.gain(length);
            let at_end = self.half + growth.doubled() + growth;
            max = max.max(at_end.amount());
        }
        let above = max.bits().leading_zeros();
        1_u64.wrapping_shl(above.saturating_sub(32) / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::Polynomial;
    use crate::exact::{PositionQ96, Q96, Q128};
    use crate::fixed::Exact;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn many_advances_are_one_over_their_sum(
            velocity in -1i128 << 90..1 << 90,
            half in -1i128 << 62..1 << 62,
            strides in prop::collection::vec(1u32..100_000, 1..100),
        ) {
            let from = Exact { position: PositionQ96::from_steps(5), velocity: Q96::from_bits(velocity) };
            let mut one = Polynomial { half: Q96::from_bits(half), ..Polynomial::line(0, from) };
            let mut many = one;
            for stride in &strides {
                many.advance_by(*stride);
            }
            one.advance_by(strides.iter().sum());
            prop_assert_eq!(one, many);
        }

        #[test]
        fn a_cubic_rounds_next_to_nothing(
            velocity in -1i128 << 90..1 << 90,
            half in -1i128 << 62..1 << 62,
            sixth in -1i128 << 70..1 << 70,
            strides in prop::collection::vec(1u32..100_000, 1..100),
        ) {
            let from = Exact { position: PositionQ96::from_steps(5), velocity: Q96::from_bits(velocity) };
            let mut one = Polynomial { half: Q96::from_bits(half), sixth: Q128::from_bits(sixth), ..Polynomial::line(0, from) };
            let mut many = one;
            for stride in &strides {
                many.advance_by(*stride);
            }
            one.advance_by(strides.iter().sum());
            let off = (one.position - many.position).bits();
            prop_assert!(off.unsigned_abs() < 1 << 62, "{off} Q96 steps");
        }

        #[test]
        fn a_cubic_between_two_states_leads_from_one_to_the_other(
            distance in -1i128 << 107..1 << 107,
            first in -1i128 << 90..1 << 90,
            last in -1i128 << 90..1 << 90,
            length in 1u32..1 << 22,
        ) {
            let from = Exact { position: PositionQ96::from_steps(9), velocity: Q96::from_bits(first) };
            let to = Exact { position: from.position + PositionQ96::from_bits(distance), velocity: Q96::from_bits(last) };
            let mut polynomial = Polynomial::between(from, (0, to), length);
            polynomial.advance_by(length);
            let off = (polynomial.position - to.position).bits().unsigned_abs();
            prop_assert!(off < 1 << 86, "{off} Q96 steps");
            let off = (polynomial.velocity - to.velocity).amount().bits();
            prop_assert!(off < 1 << 82, "{off} Q96 steps");
        }
    }
}

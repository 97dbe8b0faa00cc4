//! A polynomial of degree 3 at most: a part of a trajectory, along which the stepper advances.
//!
//! Position, velocity, half of the acceleration and a sixth of the jerk are those at one tick; to advance by n ticks is to compute all of
//! them for the later tick. Lines and parabolas are advanced without rounding. The rounding of a cubic is less than 2⁻³⁰ steps in a minute.

use crate::clock::Ticks;
use crate::divide::div_rem;
use crate::fixed::{Exact, Q96, Q128};

/// How the position goes on from a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Polynomial {
    /// The first tick behind it; `Ticks::MAX` if it never ends.
    pub(crate) end: Ticks,
    /// Steps, and steps per tick.
    pub(crate) position: Q96,
    pub(crate) velocity: Q96,
    /// Half of the acceleration, steps per tick².
    pub(crate) half: Q96,
    /// A sixth of the jerk, steps per tick³.
    pub(crate) sixth: Q128,
}

impl Polynomial {
    /// Nothing: it has ended.
    pub(crate) const NONE: Self = Self::line(
        0,
        Exact {
            position: 0,
            velocity: 0,
        },
    );

    /// A line: at the velocity that it begins with.
    pub(crate) const fn line(end: Ticks, from: Exact) -> Self {
        Self {
            end,
            position: Q96(from.position),
            velocity: Q96(from.velocity),
            half: Q96::ZERO,
            sixth: Q128::ZERO,
        }
    }

    /// The cubic from one state to another, so many ticks later, which are at least 1.
    pub(crate) fn between(from: Exact, (end, to): (Ticks, Exact), length: u32) -> Self {
        // x = x₀ + v₀·n + b·(n / length)² + c·(n / length)³
        let distance = Q96(to.position).minus(Q96(from.position));
        let first = Q96(from.velocity).times(length);
        let last = Q96(to.velocity).times(length);
        let b = distance.times(3).minus(first.times(2)).minus(last);
        let c = first.plus(last).minus(distance.times(2));
        let (inverse, _) = div_rem(u64::MAX, length);
        let per_length = |value: Q96| value.part(inverse);
        Self {
            half: per_length(per_length(b)),
            sixth: Q128::from(per_length(per_length(c))).part(inverse),
            ..Self::line(end, from)
        }
    }

    /// Whether its velocity is constant.
    #[inline]
    pub(crate) const fn is_line(&self) -> bool {
        self.half.0 == 0 && self.sixth.0 == 0
    }

    /// Advances by so many ticks, if its velocity is constant.
    #[inline]
    pub(crate) fn advance_line_by(&mut self, ticks: u32) {
        self.position = self.position.plus(self.velocity.times(ticks));
    }

    /// Advances by so many ticks.
    pub(crate) fn advance_by(&mut self, ticks: u32) {
        let mut half = self.half;
        let mut growth = Q96::ZERO;
        if self.sixth != Q128::ZERO {
            growth = self.sixth.times(ticks);
            half = half.plus(growth);
            self.half = half.plus(growth).plus(growth);
        }
        if half == Q96::ZERO && growth == Q96::ZERO {
            self.advance_line_by(ticks);
            return;
        }
        let gain = half.times(ticks);
        let mean = self.velocity.plus(gain);
        self.position = self.position.plus(mean.times(ticks));
        self.velocity = mean.plus(gain);
        if growth != Q96::ZERO {
            self.velocity = self.velocity.plus(growth.times(ticks));
        }
    }

    /// The state that it has come to.
    #[inline]
    pub(crate) const fn exact(&self) -> Exact {
        Exact {
            position: self.position.0,
            velocity: self.velocity.0,
        }
    }

    /// The longest chord, a power of two in ticks, that is nowhere more than a quarter of a step off the polynomial from its present tick
    /// `begin` up to its end: ½a·len²/4 ≤ ¼.
    pub(crate) fn longest_chord(&self, begin: Ticks) -> u64 {
        let mut max = self.half.0.unsigned_abs();
        if self.sixth != Q128::ZERO {
            // The acceleration is greatest at an end.
            let length = self.end.saturating_sub(begin);
            let length = u32::try_from(length).unwrap_or(u32::MAX);
            let at_end = self.half.plus(self.sixth.times(length).times(3));
            max = max.max(at_end.0.unsigned_abs());
        }
        let above = max.leading_zeros();
        1_u64.wrapping_shl(above.saturating_sub(32) / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::Polynomial;
    use crate::fixed::{Exact, Q96, Q128};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn many_advances_are_one_over_their_sum(
            velocity in -1i128 << 90..1 << 90,
            half in -1i128 << 62..1 << 62,
            strides in prop::collection::vec(1u32..100_000, 1..100),
        ) {
            let from = Exact { position: 5 << 96, velocity };
            let mut one = Polynomial { half: Q96(half), ..Polynomial::line(0, from) };
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
            let from = Exact { position: 5 << 96, velocity };
            let mut one = Polynomial { half: Q96(half), sixth: Q128(sixth), ..Polynomial::line(0, from) };
            let mut many = one;
            for stride in &strides {
                many.advance_by(*stride);
            }
            one.advance_by(strides.iter().sum());
            let off = one.position.minus(many.position).0;
            prop_assert!(off.unsigned_abs() < 1 << 62, "{off} Q96 steps");
        }

        #[test]
        fn a_cubic_between_two_states_leads_from_one_to_the_other(
            distance in -1i128 << 107..1 << 107,
            first in -1i128 << 90..1 << 90,
            last in -1i128 << 90..1 << 90,
            length in 1u32..1 << 22,
        ) {
            let from = Exact { position: 9 << 96, velocity: first };
            let to = Exact { position: (9 << 96) + distance, velocity: last };
            let mut polynomial = Polynomial::between(from, (0, to), length);
            polynomial.advance_by(length);
            let off = polynomial.position.minus(Q96(to.position)).0.unsigned_abs();
            prop_assert!(off < 1 << 86, "{off} Q96 steps");
            let off = polynomial.velocity.minus(Q96(to.velocity)).0.unsigned_abs();
            prop_assert!(off < 1 << 82, "{off} Q96 steps");
        }
    }
}

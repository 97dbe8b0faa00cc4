//! Rough numbers: single-precision floating point (the hardware's), of which some 22 bits are right.
//!
//! They are for guesses which exact numbers check afterwards: an operation is one instruction where one with all bits takes hundreds.
//! So that nothing becomes too small for them, they count time in units of 2²⁴ ticks.

use crate::root::reciprocal_root;

/// The quantity of a number, which says how many bits the exact number has behind the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Steps, Q96.
    Distance,
    /// Q96 steps per tick.
    Velocity,
    /// Q96 steps per tick².
    Acceleration,
    /// Q128 steps per tick³.
    Jerk,
    /// Q32 ticks.
    Time,
}

impl Kind {
    pub(super) const fn point(self) -> u32 {
        match self {
            Self::Distance => 96,
            Self::Velocity => 96 - 24,
            Self::Acceleration => 96 - 48,
            Self::Jerk => 128 - 72,
            Self::Time => 32 + 24,
        }
    }
}

/// A rough number.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Rough(f32);

impl Rough {
    pub(super) const ZERO: Self = Self(0.0);
    pub(super) const ONE: Self = Self(1.0);
    pub(super) const THIRD: Self = Self(1.0 / 3.0);

    /// 2 to the power of an exponent between −126 and 127.
    pub(super) const fn power(exponent: i32) -> Self {
        Self(f32::from_bits((exponent + 127).cast_unsigned() << 23))
    }

    /// number · 2^exponent, the exponent cut to −126 to 127.
    pub(super) fn scaled(number: f32, exponent: i32) -> Self {
        Self(number * Self::power(exponent.clamp(-126, 127)).0)
    }

    pub(super) fn of(value: u128, kind: Kind) -> Self {
        // Of four digits the first that is not zero, and the next.
        let [a, b, c, d] = crate::divide::split(value);
        let (high, low, below) = if d != 0 {
            (d, c, 64)
        } else if c != 0 {
            (c, b, 32)
        } else {
            (b, a, 0)
        };
        let leading = high as f32 * 4_294_967_296.0 + low as f32;
        let below: i32 = below;
        Self(leading).times(Self::power(below - kind.point().cast_signed()))
    }

    /// The exact number, rounded down; what does not fit is the largest.
    pub(super) fn fixed(self, kind: Kind) -> u128 {
        let bits = self.0.to_bits();
        let mantissa = u128::from(bits & 0x7F_FFFF | 0x80_0000);
        let shift = ((bits >> 23) + kind.point()).cast_signed() - (127 + 23);
        match shift {
            105.. => u128::MAX,
            0..=104 => mantissa << (shift & 127),
            -23..=-1 => mantissa >> (-shift & 31),
            _ => 0,
        }
    }

    pub(super) fn times(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }

    /// Twice as much.
    pub(super) fn doubled(self) -> Self {
        Self(self.0 + self.0)
    }

    /// Half of it.
    pub(super) fn halved(self) -> Self {
        Self(self.0 * 0.5)
    }

    /// The quotient; that by 0 is 0.
    pub(super) fn over(self, other: Self) -> Self {
        if other.0 > 0.0 {
            Self(self.0 / other.0)
        } else {
            Self::ZERO
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }

    pub(super) fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }

    pub(super) fn negated(self) -> Self {
        Self(-self.0)
    }

    /// Without its sign.
    pub(super) fn magnitude(self) -> Self {
        Self(self.0.abs())
    }

    /// The smaller one.
    pub(super) fn min(self, other: Self) -> Self {
        if other.0 < self.0 { other } else { self }
    }

    /// The greater one.
    pub(super) fn max(self, other: Self) -> Self {
        if self.0 < other.0 { other } else { self }
    }

    /// The cube root of what is not negative, to some eighteen bits.
    pub(super) fn cube_root(self) -> Self {
        // A third of the exponent: right to one part in twenty. Two steps of Newton's method do the others.
        let mut root = f32::from_bits((self.0.to_bits() / 3).wrapping_add(0x2A51_4067));
        for _ in 0..2 {
            root = (root + root + self.0 / (root * root)) * (1.0 / 3.0);
        }
        Self(root)
    }

    /// 1/√self; of 0, a large number.
    pub(super) fn reciprocal_root(self) -> Self {
        Self(reciprocal_root(self.0))
    }

    /// How far apart they are.
    pub(super) fn distance(self, other: Self) -> Self {
        Self((self.0 - other.0).abs())
    }

    pub(super) fn root(self) -> Self {
        Self(self.0 * reciprocal_root(self.0))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::contextualize_config;

    use super::{Kind, Rough};

    const KINDS: [Kind; 4] = [
        Kind::Distance,
        Kind::Velocity,
        Kind::Acceleration,
        Kind::Jerk,
    ];

    fn any_kind() -> impl Strategy<Value = Kind> {
        (0..KINDS.len()).prop_map(|index| KINDS[index])
    }

    #[test]
    fn zero_is_zero() {
        let zero = Rough::ZERO;
        assert_eq!(zero.times(Rough::ONE), zero);
        assert_eq!(Rough::ONE.over(zero), zero);
        assert_eq!(zero.root(), zero);
        for kind in KINDS {
            assert_eq!(Rough::of(0, kind), zero);
            assert_eq!(zero.fixed(kind), 0);
            assert_eq!(Rough::of(u128::MAX, kind).doubled().fixed(kind), u128::MAX);
            assert!(zero < Rough::of(1, kind));
        }
    }

    proptest! {
        #![proptest_config(contextualize_config(ProptestConfig::with_cases(4096)))]

        #[test]
        fn an_exact_number_keeps_its_leading_bits(value: u128, shift in 1u32..128, kind in any_kind()) {
            let value = value >> shift;
            let back = Rough::of(value, kind).fixed(kind);
            prop_assert!(back.abs_diff(value) <= value >> 21 | 1, "{back} of {value}");
        }

        #[test]
        fn a_cube_root_to_the_third_is_the_number(value in 1u128.., shift in 0u32..100, kind in any_kind()) {
            let number = Rough::of(value >> shift, kind);
            let root = number.cube_root();
            let cube = root.times(root).times(root);
            prop_assert!(cube.distance(number) <= number.times(Rough(1e-4)));
        }

        #[test]
        fn a_root_squared_is_the_number(value: u128, shift in 0u32..128, kind in any_kind()) {
            let number = Rough::of(value >> shift, kind);
            let square = number.root().times(number.root());
            prop_assert!(square.distance(number) <= number.times(Rough(1e-6)));
        }
    }
}

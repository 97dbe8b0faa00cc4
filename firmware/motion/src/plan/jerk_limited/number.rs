//! Floating point in software with a mantissa of 62 bits: jerk-limited motions are computed in it, and their phases written in
//! fixed point.
//!
//! A product is three short ones; reciprocal and root are begun in floating point, and the 22 bits that come from there are made 60
//! by a series of two terms. So a division costs a fifth of one with all bits. Nothing is rounded to the nearest, and a
//! sum may lose a last bit: what is worked out here is right to 2⁻⁵⁵, a thousand times finer than a difference that counts.

use super::rough::{Kind, Rough};
use crate::exact::{DistanceQ96, PositionQ96, Q96, TicksQ32};
use crate::root::reciprocal_root;

/// The bits of a mantissa, without its sign.
const BITS: i32 = 62;

/// mantissa · 2^exponent
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Number {
    mantissa: i64,
    exponent: i32,
}

impl Number {
    /// Below all others, so that it moves none of them where it is added.
    pub(super) const ZERO: Self = Self {
        mantissa: 0,
        exponent: -1_000,
    };

    /// A third.
    pub(super) const THIRD: Self = Self {
        mantissa: (1 << 62) / 3,
        exponent: -62,
    };

    /// The leading bits of an exact number, rounded towards zero.
    pub(super) fn of(value: i128, kind: Kind) -> Self {
        let magnitude = value.unsigned_abs();
        let [a, b, c, d] = crate::divide::split(magnitude);
        let (top, middle, low, below) = if d != 0 {
            (d, c, b, 64)
        } else if c != 0 {
            (c, b, a, 32)
        } else if b != 0 {
            (b, a, 0, 0)
        } else if a != 0 {
            (a, 0, 0, -32)
        } else {
            return Self::ZERO;
        };
        let shift = top.leading_zeros() & 31;
        let leading =
            u64::from(pair(top, middle, shift)) << 32 | u64::from(pair(middle, low, shift));
        let mantissa = (leading >> 2).cast_signed();
        Self {
            mantissa: if value < 0 { -mantissa } else { mantissa },
            exponent: below + 2 - shift.cast_signed() - kind.point().cast_signed(),
        }
    }

    /// The exact number, rounded down, modulo 2¹²⁸.
    pub(super) fn fixed(self, kind: Kind) -> i128 {
        let shift = self.exponent + kind.point().cast_signed();
        if shift < 0 {
            return i128::from(self.mantissa >> (-shift).min(63));
        }
        let (low, high) = (self.mantissa as u32, (self.mantissa >> 32) as u32);
        let sign = (self.mantissa >> 63) as u32;
        let part = shift.cast_unsigned() & 31;
        let digits = [low << part, pair(high, low, part), pair(sign, high, part)];
        let [a, b, c, d] = match (shift >> 5, digits) {
            (0, [a, b, c]) => [a, b, c, sign],
            (1, [a, b, c]) => [0, a, b, c],
            (2, [a, b, _]) => [0, 0, a, b],
            (3, [a, _, _]) => [0, 0, 0, a],
            _ => [0; 4],
        };
        let word = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
        (u128::from(word(c, d)) << 64 | u128::from(word(a, b))).cast_signed()
    }

    pub(super) fn velocity(self) -> Q96 {
        Q96::from_bits(self.fixed(Kind::Velocity))
    }

    pub(super) fn distance(self) -> PositionQ96 {
        PositionQ96::from_bits(self.fixed(Kind::Distance))
    }

    /// Of what is not negative.
    pub(super) fn time(self) -> TicksQ32 {
        TicksQ32::from_bits(self.fixed(Kind::Time).cast_unsigned())
    }

    /// Whether it may be 2^exponent or more, or as much below zero: what is sure to be less is not.
    #[inline(always)]
    pub(super) fn may_exceed(self, exponent: i32) -> bool {
        self.exponent >= exponent - 63
    }

    /// Whether the exact number does not fit.
    pub(super) fn saturates(self, kind: Kind) -> bool {
        let bounded = self.bounded(kind);
        bounded == i128::MAX || bounded == i128::MIN
    }

    /// The same, saturating.
    pub(super) fn bounded(self, kind: Kind) -> i128 {
        let shift = self.exponent + kind.point().cast_signed();
        let beyond = self.mantissa >> (127 - shift).clamp(0, 63);
        match beyond {
            0 | -1 => self.fixed(kind),
            1.. => i128::MAX,
            _ => i128::MIN,
        }
    }

    /// Its leading bits.
    pub(super) fn rough(self) -> Rough {
        let leading = (self.mantissa >> 31) as i32 as f32;
        Rough::scaled(leading, self.exponent + 31)
    }

    pub(super) const fn negated(self) -> Self {
        Self {
            mantissa: -self.mantissa,
            exponent: self.exponent,
        }
    }

    pub(super) const fn halved(self) -> Self {
        Self {
            mantissa: self.mantissa,
            exponent: self.exponent - 1,
        }
    }

    pub(super) const fn doubled(self) -> Self {
        Self {
            mantissa: self.mantissa,
            exponent: self.exponent + 1,
        }
    }

    #[inline]
    pub(super) fn times(self, other: Self) -> Self {
        Self {
            mantissa: fraction(self.mantissa, other.mantissa),
            exponent: self.exponent + other.exponent + BITS,
        }
    }

    /// The sum; the last bit is lost.
    pub(super) fn plus(self, other: Self) -> Self {
        let apart = self.exponent - other.exponent;
        let (large, small, apart) = if apart < 0 {
            (other, self, -apart)
        } else {
            (self, other, apart)
        };
        let small = (small.mantissa >> 1) >> apart.min(63);
        Self {
            mantissa: (large.mantissa >> 1) + small,
            exponent: large.exponent + 1,
        }
    }

    pub(super) fn minus(self, other: Self) -> Self {
        self.plus(other.negated())
    }

    /// The leading bit of what is not negative set.
    fn leading(self) -> Self {
        let above = self.mantissa.leading_zeros().wrapping_sub(2) & 63;
        Self {
            mantissa: self.mantissa << above,
            exponent: self.exponent - above.cast_signed(),
        }
    }

    /// 1/self of a number above zero; of any other, zero.
    #[inline(never)]
    pub(super) fn reciprocal(self) -> Self {
        if self.mantissa <= 0 {
            return Self::ZERO;
        }
        let Self { mantissa, exponent } = self.leading();
        // x from 1/2 to 1, and y from 1 to 2, both with 30 bits behind the point.
        let leading = (mantissa >> 31) as i32 as f32;
        let rough = ((1u64 << 61) as f32 / leading) as i32;
        // x·y = 1 − e, and 1/x = y·(1 + e + e²).
        let rough_fraction = i64::from(rough) << 31;
        let left = (1 << 61) - fraction(mantissa, rough_fraction);
        let short = left >> 20;
        let series = left + ((short * short) >> 21);
        let better = fraction(rough_fraction, series << 20) >> 19;
        Self {
            mantissa: (rough_fraction + better).min((1 << 62) - 1),
            exponent: 1 - (exponent + 2 * BITS),
        }
    }

    /// The root; that of a number below zero is zero.
    #[inline(never)]
    pub(super) fn root(self) -> Self {
        if self.mantissa <= 0 {
            return Self::ZERO;
        }
        let Self { mantissa, exponent } = self.leading();
        // An even exponent, so that its root is a half of it.
        let odd = exponent & 1;
        let (square, exponent) = (mantissa >> odd, exponent + odd);
        // x from 1/4 to 1, and y = 1/√x from 1 to 2, with 30 bits behind the point.
        let leading = (square >> 31) as i32 as f32 * (1.0 / 2_147_483_648.0);
        let rough = ((reciprocal_root(leading) * 1_073_741_824.0) as u32).min((1 << 31) - 1);
        let rough = i64::from(rough);
        // x·y² = 1 − e, and √x = x·y·(1 + e/2 + 3e²/8).
        let left = (1 << 60) - fraction(square, rough * rough);
        let short = left >> 20;
        let squared = (short * short) >> 20;
        let series = (left >> 1) + ((squared * 3) >> 3);
        let root = fraction(square, rough << 31) << 1;
        let better = fraction(root, series << 22) >> 20;
        Self {
            mantissa: (root + better).min((1 << 62) - 1),
            exponent: (exponent >> 1) - 31,
        }
    }
}

/// The product of two mantissas, 62 bits lower. The lowest bits, which would add less than one, are left out.
#[inline]
fn fraction(one: i64, other: i64) -> i64 {
    // In digits of 32 and 31 bits, as the processor multiplies them.
    let split = |mantissa: i64| {
        let low = mantissa as u32;
        let high = ((mantissa >> 32) as u32) << 1 | low >> 31;
        let low = (low & 0x7FFF_FFFF).cast_signed();
        (i64::from(high.cast_signed()), i64::from(low))
    };
    let ((high, low), (other_high, other_low)) = (split(one), split(other));
    let cross = high * other_low + low * other_high;
    high * other_high + (cross >> 31)
}

/// What no other motion asks of exact numbers.
impl PositionQ96 {
    /// How long a distance is, in whichever direction.
    pub(super) const fn amount(self) -> DistanceQ96 {
        DistanceQ96::from_bits(self.bits().unsigned_abs())
    }
}

impl Q96 {
    /// The least above zero.
    pub(super) const LEAST: Self = Self::from_bits(1);

    pub(super) const fn halved(self) -> Self {
        Self::from_bits(self.bits() >> 1)
    }
}

impl TicksQ32 {
    pub(super) const fn halved(self) -> Self {
        Self::from_bits(self.bits() >> 1)
    }
}

/// The upper digit of two that are shifted up by less than a digit.
#[inline]
const fn pair(upper: u32, lower: u32, shift: u32) -> u32 {
    let shift = shift & 31;
    upper << shift | (lower >> 1) >> (31u32.wrapping_sub(shift) & 31)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::rough::Kind;
    use super::Number;

    /// As a floating-point number, and how far it may be off: double precision has fewer bits.
    fn float(number: Number) -> f64 {
        number.mantissa as f64 * f64::from(number.exponent).exp2()
    }

    fn near(one: f64, other: f64) -> bool {
        (one - other).abs() <= other.abs() * 2f64.powi(-51)
    }

    /// What is left of a number when another is taken from it, as a part of it.
    fn part(of: Number, less: Number) -> f64 {
        float(of.minus(less)) / float(of)
    }

    fn any_number() -> impl Strategy<Value = Number> {
        (1i128.., 0u32..127)
            .prop_map(|(value, shift)| Number::of((value >> shift).max(1), Kind::Distance))
    }

    #[test]
    fn zero_is_zero() {
        let zero = Number::of(0, Kind::Velocity);
        let one = Number::of(1 << 72, Kind::Velocity);
        assert_eq!(zero, Number::ZERO);
        assert_eq!(zero.root().fixed(Kind::Distance), 0);
        assert_eq!(zero.reciprocal().fixed(Kind::Distance), 0);
        assert_eq!(one.negated().root(), Number::ZERO);
        assert_eq!(zero.times(one).fixed(Kind::Distance), 0);
        assert_eq!(zero.plus(one).fixed(Kind::Velocity), 1 << 72);
        assert_eq!(float(one), 1.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn an_exact_number_comes_back(value: i128, shift in 0u32..128) {
            let value = value >> shift.min(127);
            for kind in [Kind::Distance, Kind::Velocity, Kind::Acceleration, Kind::Jerk, Kind::Time] {
                let back = Number::of(value, kind).fixed(kind);
                prop_assert!(back.abs_diff(value) <= value.unsigned_abs() >> 61, "{back} of {value}");
            }
        }

        #[test]
        fn sums_and_products_are_those_of_floating_point(a in any_number(), b in any_number()) {
            prop_assert!(near(float(a.times(b)), float(a) * float(b)));
            prop_assert!(near(float(a.negated().times(b)), -float(a) * float(b)));
            prop_assert!(near(float(a.plus(b)), float(a) + float(b)));
            let difference = float(a) - float(b);
            let most = float(a).max(float(b));
            prop_assert!((float(a.minus(b)) - difference).abs() <= most * 2f64.powi(-51));
        }

        #[test]
        fn a_reciprocal_gives_one(a in any_number()) {
            let one = Number::of(1 << 96, Kind::Distance);
            let off = part(one, a.times(a.reciprocal()));
            prop_assert!(off.abs() <= 2f64.powi(-58), "{off}");
        }

        #[test]
        fn a_root_squared_is_the_number(a in any_number()) {
            let root = a.root();
            let off = part(a, root.times(root));
            prop_assert!(off.abs() <= 2f64.powi(-57), "{off}");
        }
    }
}

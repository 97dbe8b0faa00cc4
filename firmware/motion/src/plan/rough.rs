//! Rough numbers: 32 significant bits and an exponent, none negative.
//!
//! They are for guesses which exact numbers check afterwards: an operation takes a few dozen instructions where one with all bits takes
//! hundreds. Results are rounded down.

use core::cmp::Ordering;

use crate::divide::estimate;
use crate::root::root;

/// mantissa · 2^exponent. The leading bit of the mantissa is set, unless the number is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rough {
    mantissa: u32,
    exponent: i32,
}

impl Rough {
    pub(super) const ZERO: Self = Self {
        mantissa: 0,
        exponent: 0,
    };

    /// A number with so many bits behind the point.
    pub(super) const fn of(value: u128, point: i32) -> Self {
        if value == 0 {
            return Self::ZERO;
        }
        let above = value.leading_zeros();
        let mantissa = if above <= 96 {
            (value >> (96u32.wrapping_sub(above) & 127)) as u32
        } else {
            (value as u32) << (above.wrapping_sub(96) & 31)
        };
        Self {
            mantissa,
            exponent: 96i32.wrapping_sub(above.cast_signed()).wrapping_sub(point),
        }
    }

    /// With so many bits behind the point; what does not fit is the largest number.
    pub(super) fn fixed(self, point: i32) -> u128 {
        let mantissa = u128::from(self.mantissa);
        let shift = self.exponent.wrapping_add(point);
        match shift {
            97.. if mantissa != 0 => u128::MAX,
            0..=96 => mantissa << (shift & 127),
            -31..=-1 => mantissa >> (shift.wrapping_neg() & 31),
            _ => 0,
        }
    }

    pub(super) fn times(self, other: Self) -> Self {
        let product = u64::from(self.mantissa).wrapping_mul(other.mantissa.into());
        Self::normalised(product, self.exponent.wrapping_add(other.exponent))
    }

    /// Twice as much.
    pub(super) const fn doubled(self) -> Self {
        Self {
            mantissa: self.mantissa,
            exponent: self.exponent.wrapping_add(1),
        }
    }

    /// Half of it.
    pub(super) const fn halved(self) -> Self {
        Self {
            mantissa: self.mantissa,
            exponent: self.exponent.wrapping_sub(1),
        }
    }

    /// The quotient; that by 0 is 0.
    pub(super) fn over(self, other: Self) -> Self {
        if self.mantissa == 0 || other.mantissa == 0 {
            return Self::ZERO;
        }
        // The quotient has 32 bits either way.
        let shift = if self.mantissa >= other.mantissa {
            31
        } else {
            32
        };
        Self {
            mantissa: estimate(u64::from(self.mantissa) << shift, other.mantissa),
            exponent: self
                .exponent
                .wrapping_sub(other.exponent)
                .wrapping_sub(shift),
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        let (large, small) = self.ordered(other);
        let wide = u64::from(large.mantissa) << 31;
        let sum = wide.wrapping_add(large.aligned(small));
        Self::normalised(sum, large.exponent.wrapping_sub(31))
    }

    /// How far apart they are.
    pub(super) fn distance(self, other: Self) -> Self {
        let (large, small) = self.ordered(other);
        let wide = u64::from(large.mantissa) << 31;
        let difference = wide.wrapping_sub(large.aligned(small));
        Self::normalised(difference, large.exponent.wrapping_sub(31))
    }

    pub(super) fn root(self) -> Self {
        let shift = if self.exponent & 1 == 0 { 32 } else { 31 };
        Self {
            mantissa: root(u64::from(self.mantissa) << shift),
            exponent: self.exponent.wrapping_sub(shift) >> 1,
        }
    }

    /// The larger one first.
    fn ordered(self, other: Self) -> (Self, Self) {
        if self < other {
            (other, self)
        } else {
            (self, other)
        }
    }

    /// The mantissa of a number that is not larger, as 31 bits below this one has it.
    fn aligned(self, smaller: Self) -> u64 {
        let shift = self.exponent.wrapping_sub(smaller.exponent);
        let wide = u64::from(smaller.mantissa) << 31;
        if (0..64).contains(&shift) {
            wide >> (shift & 63)
        } else {
            0
        }
    }

    fn normalised(value: u64, exponent: i32) -> Self {
        if value == 0 {
            return Self::ZERO;
        }
        let above = value.leading_zeros();
        Self {
            mantissa: ((value << (above & 63)) >> 32) as u32,
            exponent: exponent.wrapping_add(32).wrapping_sub(above.cast_signed()),
        }
    }
}

impl PartialOrd for Rough {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(match (self.mantissa, other.mantissa) {
            (0, 0) => Ordering::Equal,
            (0, _) => Ordering::Less,
            (_, 0) => Ordering::Greater,
            (one, two) => self.exponent.cmp(&other.exponent).then(one.cmp(&two)),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Rough;

    /// As a float, which has more bits.
    fn float(number: Rough) -> f64 {
        f64::from(number.mantissa) * 2f64.powi(number.exponent)
    }

    fn any_rough() -> impl Strategy<Value = Rough> {
        (any::<u128>(), 0u32..128, 0i32..128)
            .prop_map(|(value, shift, point)| Rough::of(value >> shift, point))
    }

    fn is_near(found: Rough, wanted: f64) -> bool {
        (float(found) - wanted).abs() <= wanted * 2f64.powi(-30)
    }

    #[test]
    fn nothing_is_nothing() {
        let (zero, one) = (Rough::ZERO, Rough::of(1, 0));
        assert_eq!(zero.times(one), zero);
        assert_eq!(one.over(zero), zero);
        assert_eq!(zero.over(one), zero);
        assert_eq!(one.distance(one), zero);
        assert_eq!(zero.root().fixed(0), 0);
        assert_eq!(zero.plus(one), one);
        assert_eq!(zero.fixed(120), 0);
        assert_eq!(Rough::of(u128::MAX, 0).fixed(40), u128::MAX);
        assert!(zero < one);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn operations_have_thirty_bits(a in any_rough(), b in any_rough()) {
            let (x, y) = (float(a), float(b));
            prop_assert!(is_near(a.times(b), x * y));
            prop_assert!(is_near(a.plus(b), x + y));
            prop_assert!(is_near(a.root(), x.sqrt()));
            prop_assert!(is_near(a.doubled().halved(), x));
            let larger = x.max(y);
            let distance = float(a.distance(b));
            prop_assert!((distance - (x - y).abs()).abs() <= larger * 2f64.powi(-30));
            prop_assert_eq!(a < b, x < y);
            if y != 0.0 {
                prop_assert!(is_near(a.over(b), x / y));
            }
        }

        #[test]
        fn a_fixed_point_keeps_its_leading_bits(value: u128, shift in 0u32..128, point in 0i32..128) {
            let value = value >> shift;
            let back = Rough::of(value, point).fixed(point);
            prop_assert!(back <= value);
            prop_assert!(value - back <= value >> 31);
        }
    }
}

//! 256-bit products: two Q96 numbers multiply to Q192, and no bit may fall off before it is known to be small.

use crate::low;

/// An unsigned 256-bit number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct U256 {
    high: u128,
    low: u128,
}

impl U256 {
    /// a · b, exactly.
    #[inline(never)]
    pub(crate) fn product(a: u128, b: u128) -> Self {
        let half = |value: u128| u128::from(low::u64(value));
        let (a1, a0) = (a >> 64, half(a));
        let (b1, b0) = (b >> 64, half(b));
        let bottom = a0 * b0;
        // A product of halves and a half more are never more than two halves.
        let cross = a1 * b0 + (bottom >> 64);
        let middle = a0 * b1 + half(cross);
        Self {
            high: a1 * b1 + (cross >> 64) + (middle >> 64),
            low: (middle << 64) | half(bottom),
        }
    }

    /// The sum, modulo 2²⁵⁶.
    pub(crate) fn plus(self, other: Self) -> Self {
        let (low, carry) = self.low.overflowing_add(other.low);
        Self {
            high: self
                .high
                .wrapping_add(other.high)
                .wrapping_add(u128::from(carry)),
            low,
        }
    }

    /// ⌊self / 2ⁿ⌋ for n of 1 to 127, if it fits.
    pub(crate) fn shifted(self, n: u32) -> Option<u128> {
        (self.high >> (n & 127) == 0).then(|| self.shifted_wrapping(n))
    }

    /// ⌊self / 2ⁿ⌋ modulo 2¹²⁸ for n of 1 to 127.
    pub(crate) fn shifted_wrapping(self, n: u32) -> u128 {
        self.high.wrapping_shl(128 - n) | (self.low >> (n & 127))
    }

    /// The leading 64 bits and how far they were shifted down: self = mantissa · 2^exponent, rounded down.
    pub(crate) fn leading(self) -> (u64, u32) {
        let (word, base) = if self.high == 0 {
            (self.low, 0)
        } else {
            (self.high, 128)
        };
        let above = word.leading_zeros();
        if base == 0 {
            let shift = 64u32.saturating_sub(above);
            (low::u64(word >> (shift & 127)), shift)
        } else if above > 64 {
            // Fewer than 64 bits in the upper half: fill up from the lower one.
            let shift = 192 - above;
            (low::u64(self.shifted_wrapping(shift)), shift)
        } else {
            let shift = 64 - above;
            (low::u64(word >> (shift & 127)), shift + base)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::U256;
    use proptest::prelude::*;

    #[test]
    fn the_largest_product_is_exact() {
        let square = U256::product(u128::MAX, u128::MAX);
        assert_eq!(
            square,
            U256 {
                high: u128::MAX - 1,
                low: 1
            }
        );
    }

    proptest! {
        #[test]
        fn product_of_halves_agrees(a: u64, b: u64, s in 1u32..127) {
            let exact = u128::from(a) * u128::from(b);
            prop_assert_eq!(U256::product(a.into(), b.into()), U256 { high: 0, low: exact });
            prop_assert_eq!(U256::product(a.into(), b.into()).shifted(s), Some(exact >> s));
            // (a·2⁶⁴)·(b·2⁶³) = exact·2¹²⁷
            let far = U256::product(u128::from(a) << 64, u128::from(b) << 63);
            prop_assert_eq!(far, U256 { high: exact >> 1, low: exact << 127 });
        }

        #[test]
        fn product_distributes_over_the_sum(a: u128, b in 0..u128::MAX / 2, c in 0..u128::MAX / 2) {
            let sum = U256::product(a, b).plus(U256::product(a, c));
            prop_assert_eq!(U256::product(a, b + c), sum);
        }

        #[test]
        fn leading_bits_are_the_leading_bits(a: u128, b: u128, s in 0u32..128, u in 0u32..128) {
            let wide = U256::product(a >> s, b >> u);
            let (mantissa, exponent) = wide.leading();
            // Full 64 bits, or nothing lost.
            prop_assert!(mantissa >> 63 == 1 || exponent == 0);
            let back = U256::product(u128::from(mantissa) << 63, 1u128 << 64); // mantissa · 2¹²⁷
            if exponent <= 127 && exponent > 0 {
                prop_assert_eq!(back.shifted(127), Some(u128::from(mantissa)));
                prop_assert_eq!(wide.shifted_wrapping(exponent) , u128::from(mantissa));
            }
            if exponent > 128 {
                prop_assert_eq!(wide.high >> (exponent - 128), u128::from(mantissa));
            }
        }
    }
}

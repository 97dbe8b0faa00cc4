//! Division of wide numbers in 32-bit digits, as on paper.
//!
//! The processor divides 32 bits by 32; the compiler's own 128-bit division is made for processors that do more. Only digits that
//! the quotient has are worked out, and there is one copy of the code.

use crate::iterations::Iterations;
use crate::low;

/// Digits of a quotient at most: a numerator has four, one more when it is shifted, two are behind the point, and a divisor has one at least.
const MAX_DIGITS: u32 = 6;

/// A digit is estimated from the leading digit of the divisor, whose first bit is set: never too small, and too large by no more than this
/// (Knuth, The Art of Computer Programming, 4.3.1).
const TOO_LARGE: u32 = 2;

/// ⌊numerator · 2^(32 · digits) / divisor⌋ modulo 2¹²⁸, for a divisor of at most 96 bits; 0 for any other.
pub fn quotient(numerator: u128, digits: u32, divisor: u128) -> u128 {
    Divisor::new(divisor).quotient(numerator, digits)
}

/// What a division needs of its divisor. Made once for several divisions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Divisor {
    /// The divisor, shifted up until the leading bit of 96 is set.
    high: u32,
    /// The two digits below `high`.
    low_digits: u64,
    /// ⌊(2⁶⁴ − 1) / high⌋ − 2³²
    reciprocal: u32,
    /// How far its leading digit was shifted up within itself.
    shift: u32,
    /// How many digits it has: 1 to 3. None if it cannot divide.
    length: u32,
}

impl Divisor {
    /// For a divisor of at most 96 bits; the quotient by any other, and by 0, is 0.
    #[inline(never)]
    pub(crate) fn new(divisor: u128) -> Self {
        let [low, middle, top, _] = split(divisor);
        let ([high, middle, low], length) = match (top, middle) {
            (0, 0) => ([low, 0, 0], 1),
            (0, _) => ([middle, low, 0], 2),
            _ => ([top, middle, low], 3),
        };
        let is_divisor = high != 0 && divisor >> 96 == 0;
        let shift = high.leading_zeros() & 31;
        let high = pair(high, middle, shift);
        Self {
            high,
            low_digits: u64::from(pair(middle, low, shift)) << 32 | u64::from(low << shift),
            reciprocal: estimate(u64::from(!high) << 32 | u64::from(u32::MAX), high),
            shift,
            length: if is_divisor { length } else { 0 },
        }
    }

    /// ⌊numerator · 2^(32 · digits) / self⌋ modulo 2¹²⁸.
    #[inline(never)]
    pub(crate) fn quotient(&self, numerator: u128, digits: u32) -> u128 {
        if self.length == 0 {
            return 0;
        }
        // The numerator is shifted as the divisor was. What its three leading digits are then is the first remainder, and less than the divisor.
        let [a, b, c, d] = split(numerator);
        let shift = self.shift & 31;
        let mut first = pair(0, d, shift);
        let mut second = u64::from(pair(d, c, shift)) << 32 | u64::from(pair(c, b, shift));
        let mut rest = u64::from(pair(b, a, shift)) << 32 | u64::from(a << shift);
        let mut left = 5 - self.length + digits;
        let mut iterations = Iterations::at_most(MAX_DIGITS);
        // Digits in front that are 0.
        while left != 0 && first == 0 && ((second >> 32) as u32) < self.high {
            iterations.count();
            first = (second >> 32) as u32;
            (second, rest) = (second << 32 | rest >> 32, rest << 32);
            left -= 1;
        }
        let mut result: u128 = 0;
        while left != 0 {
            iterations.count();
            let mut digit = self.digit(first, (second >> 32) as u32);
            // Remainder and next digit, less the product.
            let low = u64::from(low::u32(self.low_digits)) * u64::from(digit);
            let middle = (self.low_digits >> 32) * u64::from(digit) + (low >> 32);
            let top = u64::from(self.high) * u64::from(digit) + (middle >> 32);
            let below = middle << 32 | u64::from(low::u32(low));
            let (mut lower, borrow) = (second << 32 | rest >> 32).overflowing_sub(below);
            let upper = (u64::from(first) << 32 | second >> 32).wrapping_sub(top);
            let mut upper = upper.wrapping_sub(borrow.into());
            rest <<= 32;
            let mut iterations = Iterations::at_most(TOO_LARGE);
            while upper >> 63 != 0 {
                iterations.count();
                digit -= 1;
                let (sum, carry) = lower.overflowing_add(self.low_digits);
                lower = sum;
                upper = upper
                    .wrapping_add(self.high.into())
                    .wrapping_add(carry.into());
            }
            (first, second) = (low::u32(upper), lower);
            result = result << 32 | u128::from(digit);
            left -= 1;
        }
        result
    }

    /// ⌊(first · 2³² + next) / high⌋, or the largest digit if that is less.
    #[inline]
    fn digit(&self, first: u32, next: u32) -> u32 {
        if first >= self.high {
            return u32::MAX;
        }
        // Möller and Granlund, "Improved division by invariant integers".
        let guess = u64::from(self.reciprocal)
            .wrapping_mul(first.into())
            .wrapping_add(u64::from(first) << 32 | u64::from(next));
        let mut digit = ((guess >> 32) as u32).wrapping_add(1);
        let mut left = next.wrapping_sub(digit.wrapping_mul(self.high));
        if left > low::u32(guess) {
            digit = digit.wrapping_sub(1);
            left = left.wrapping_add(self.high);
        }
        if left >= self.high {
            digit = digit.wrapping_add(1);
        }
        digit
    }
}

/// ⌊numerator / divisor⌋ and the remainder. A divisor of 0 gives 0 and 0.
#[inline]
pub fn div_rem(numerator: u64, divisor: u32) -> (u64, u32) {
    let (high, low) = ((numerator >> 32) as u32, low::u32(numerator));
    if high == 0 {
        let quotient = low.checked_div(divisor).unwrap_or(0);
        let remainder = low.checked_rem(divisor).unwrap_or(0);
        return (quotient.into(), remainder);
    }
    let (Some(first), Some(left)) = (high.checked_div(divisor), high.checked_rem(divisor)) else {
        return (0, 0);
    };
    // Less than the divisor, so that what is left is one digit, and exactly the estimate.
    let shift = divisor.leading_zeros() & 31;
    let rest = (u64::from(left) << 32) | u64::from(low);
    let second = estimate(rest << shift, divisor << shift);
    let remainder = low.wrapping_sub(second.wrapping_mul(divisor));
    ((u64::from(first) << 32) | u64::from(second), remainder)
}

/// ⌊numerator · 2⁶⁴ / divisor⌋; 0 for a divisor of 0.
pub(crate) fn fraction(numerator: u64, divisor: u32) -> u128 {
    if divisor == 0 {
        return 0;
    }
    let (whole, left) = div_rem(numerator, divisor);
    let shift = divisor.leading_zeros() & 31;
    let digit = |left: u32| estimate((u64::from(left) << 32) << shift, divisor << shift);
    let first = digit(left);
    // What is left of left · 2³² is less than the divisor.
    let second = digit(0_u32.wrapping_sub(first.wrapping_mul(divisor)));
    let behind = (u64::from(first) << 32) | u64::from(second);
    (u128::from(whole) << 64) | u128::from(behind)
}

/// The digits of a number, the lowest first. Written out: a loop over the shifts costs 60 instructions more.
#[inline]
pub(crate) const fn split(value: u128) -> [u32; 4] {
    [
        low::u32(low::u64(value)),
        low::u32(low::u64(value >> 32)),
        low::u32(low::u64(value >> 64)),
        (value >> 96) as u32,
    ]
}

/// The upper digit of two that are shifted up by less than a digit.
#[inline]
const fn pair(upper: u32, lower: u32, shift: u32) -> u32 {
    let shift = shift & 31;
    upper << shift | (lower >> 1) >> (31u32.wrapping_sub(shift) & 31)
}

/// numerator / divisor, or the largest digit if that is less. The divisor's leading bit is set.
#[inline]
pub(crate) fn estimate(numerator: u64, divisor: u32) -> u32 {
    let high = (numerator >> 32) as u32;
    if high >= divisor {
        return u32::MAX;
    }
    let low = low::u32(numerator);
    let (first, left) = half_digit(high, low >> 16, divisor);
    let (second, _) = half_digit(left, low & 0xFFFF, divisor);
    (first << 16) | second
}

/// One digit of 16 bits, and the remainder. `remainder` is less than `divisor`.
#[inline]
fn half_digit(remainder: u32, next: u32, divisor: u32) -> (u32, u32) {
    let mut digit = remainder.checked_div(divisor >> 16).unwrap_or(0);
    let numerator = (u64::from(remainder) << 16) | u64::from(next);
    let mut product = u64::from(digit) * u64::from(divisor);
    let mut iterations = Iterations::at_most(TOO_LARGE);
    while product > numerator {
        iterations.count();
        digit -= 1;
        product -= u64::from(divisor);
    }
    (digit, low::u32(numerator - product))
}

#[cfg(test)]
mod tests {
    use super::{div_rem, fraction, quotient};
    use proptest::prelude::*;
    use proptest::test_runner::contextualize_config;

    #[test]
    fn no_quotient_is_zero() {
        assert_eq!(quotient(5, 0, 0), 0);
        assert_eq!(quotient(u128::MAX, 0, 1 << 96), 0);
        assert_eq!(quotient(0, 2, 1), 0);
        assert_eq!(div_rem(5, 0), (0, 0));
        assert_eq!(div_rem(u64::MAX, 0), (0, 0));
        assert_eq!(fraction(u64::MAX, 0), 0);
    }

    #[test]
    fn digits_of_ones_are_exact() {
        for bits in 1..=96 {
            let divisor = u128::MAX >> (128 - bits);
            for above in 0..128 {
                let numerator = u128::MAX >> above;
                assert_eq!(quotient(numerator, 0, divisor), numerator / divisor);
            }
        }
    }

    proptest! {
        #![proptest_config(contextualize_config(ProptestConfig::with_cases(4096)))]

        #[test]
        fn agrees_with_the_division_of_the_language(n: u128, d: u128, s in 0u32..128, u in 32u32..128) {
            let (n, d) = (n >> s, (d >> u).max(1));
            prop_assert_eq!(quotient(n, 0, d), n / d);
        }

        #[test]
        fn a_division_by_a_digit_is_exact(n: u64, d: u32, s in 0u32..64, u in 0u32..32) {
            let (n, d) = (n >> s, (d >> u).max(1));
            let divisor = u64::from(d);
            let remainder = u32::try_from(n % divisor).unwrap();
            prop_assert_eq!(div_rem(n, d), (n / divisor, remainder));
            prop_assert_eq!(div_rem(u64::MAX, d).0, u64::MAX / divisor);
        }

        #[test]
        fn a_fraction_of_two_digits_is_exact(n: u64, d: u32, s in 0u32..64, u in 0u32..32) {
            let (n, d) = (n >> s, (d >> u).max(1));
            prop_assert_eq!(fraction(n, d), (u128::from(n) << 64) / u128::from(d));
            prop_assert_eq!(fraction(u64::MAX, d), (u128::from(u64::MAX) << 64) / u128::from(d));
        }

        #[test]
        fn a_digit_behind_the_point_is_that_of_a_longer_numerator(n: u128, d: u128, s in 0u32..96, u in 32u32..128) {
            let (n, d) = (n >> s >> 32, (d >> u).max(1));
            prop_assert_eq!(quotient(n, 1, d), (n << 32) / d);
        }

        #[test]
        fn near_multiples_are_exact(q: u64, d: u128, u in 64u32..128, less in 0u128..3) {
            let d = (d >> u).max(1);
            let n = (u128::from(q) * d).saturating_sub(less);
            prop_assert_eq!(quotient(n, 0, d), n / d);
        }
    }
}

//! Division of wide numbers in 32-bit digits, as on paper.
//!
//! The processor divides 32 bits by 32; the compiler's own 128-bit division is made for processors that do more. Only digits that
//! the quotient has are worked out, and there is one copy of the code.

/// ⌊numerator · 2^(32 · digits) / divisor⌋ modulo 2¹²⁸, for a divisor of at most 96 bits; 0 for any other.
#[inline(never)]
pub fn quotient(numerator: u128, digits: u32, divisor: u128) -> u128 {
    // The divisor's leading bit becomes bit 95, so that its leading digit makes good estimates.
    let Some(shift) = divisor.leading_zeros().checked_sub(32) else {
        return 0;
    };
    if divisor == 0 || numerator == 0 {
        return 0;
    }
    let divisor = divisor << (shift & 127);
    let top = (divisor >> 64) as u32;

    // The numerator is shifted alike. What lies above the digits of the quotient is the first remainder, and less than the divisor.
    let above = numerator.leading_zeros();
    let bits = shift.wrapping_add(33).saturating_sub(above);
    let whole = bits.div_ceil(32);
    let (mut remainder, mut rest): (u128, u64) = if whole == 0 {
        (numerator << (shift & 127), 0)
    } else {
        // 64 to 95 bits.
        let width = bits.wrapping_add(95).wrapping_sub(whole << 5);
        let aligned = numerator << (above & 127);
        (
            aligned >> (128u32.wrapping_sub(width) & 127),
            (aligned as u64) << (width & 31),
        )
    };

    let mut result = 0;
    for _ in 0..whole.wrapping_add(digits) {
        remainder = (remainder << 32) | u128::from(rest >> 32);
        rest <<= 32;
        let mut digit = estimate((remainder >> 64) as u64, top);
        let (left, mut short) = remainder.overflowing_sub(times(divisor, digit));
        remainder = left;
        // The estimate is never too small, and too large by at most two.
        while short {
            digit = digit.wrapping_sub(1);
            let (left, positive) = remainder.overflowing_add(divisor);
            remainder = left;
            short = !positive;
        }
        result = (result << 32) | u128::from(digit);
    }
    result
}

/// ⌊numerator / divisor⌋ and the remainder. A divisor of 0 gives 0 and 0.
#[inline]
pub fn by_digit(numerator: u64, divisor: u32) -> (u64, u32) {
    let (high, low) = ((numerator >> 32) as u32, numerator as u32);
    if high == 0 {
        let quotient = low.checked_div(divisor).unwrap_or(0);
        let remainder = low.checked_rem(divisor).unwrap_or(0);
        return (quotient.into(), remainder);
    }
    let (Some(first), Some(left)) = (high.checked_div(divisor), high.checked_rem(divisor)) else {
        return (0, 0);
    };
    // Less than the divisor, so that the rest is one digit, and exactly the estimate.
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
    let (whole, left) = by_digit(numerator, divisor);
    let shift = divisor.leading_zeros() & 31;
    let digit = |left: u32| estimate((u64::from(left) << 32) << shift, divisor << shift);
    let first = digit(left);
    // What is left of left · 2³² is less than the divisor.
    let second = digit(0_u32.wrapping_sub(first.wrapping_mul(divisor)));
    let behind = (u64::from(first) << 32) | u64::from(second);
    (u128::from(whole) << 64) | u128::from(behind)
}

/// A number of 96 bits times a digit.
fn times(number: u128, digit: u32) -> u128 {
    let digit = u64::from(digit);
    let low = u64::from(number as u32).wrapping_mul(digit);
    let middle = u64::from((number >> 32) as u32)
        .wrapping_mul(digit)
        .wrapping_add(low >> 32);
    let high = u64::from((number >> 64) as u32)
        .wrapping_mul(digit)
        .wrapping_add(middle >> 32);
    (u128::from(high) << 64) | u128::from((middle << 32) | (low & u64::from(u32::MAX)))
}

/// numerator / divisor, or the largest digit if that is less. The divisor's leading bit is set.
#[inline]
pub(crate) fn estimate(numerator: u64, divisor: u32) -> u32 {
    let high = (numerator >> 32) as u32;
    if high >= divisor {
        return u32::MAX;
    }
    let low = numerator as u32;
    let (first, left) = half_digit(high, low >> 16, divisor);
    let (second, _) = half_digit(left, low & 0xFFFF, divisor);
    (first << 16) | second
}

/// One digit of 16 bits, and the remainder. `remainder` is less than `divisor`.
#[inline]
fn half_digit(remainder: u32, next: u32, divisor: u32) -> (u32, u32) {
    let mut digit = remainder.checked_div(divisor >> 16).unwrap_or(0);
    let numerator = (u64::from(remainder) << 16) | u64::from(next);
    let mut product = u64::from(digit).wrapping_mul(divisor.into());
    // Too large by at most two.
    while product > numerator {
        digit = digit.wrapping_sub(1);
        product = product.wrapping_sub(divisor.into());
    }
    (digit, numerator.wrapping_sub(product) as u32)
}

#[cfg(test)]
mod tests {
    use super::{by_digit, fraction, quotient};
    use proptest::prelude::*;

    #[test]
    fn no_quotient_is_zero() {
        assert_eq!(quotient(5, 0, 0), 0);
        assert_eq!(quotient(u128::MAX, 0, 1 << 96), 0);
        assert_eq!(quotient(0, 3, 1), 0);
        assert_eq!(by_digit(5, 0), (0, 0));
        assert_eq!(by_digit(u64::MAX, 0), (0, 0));
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
        #![proptest_config(ProptestConfig::with_cases(4096))]

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
            prop_assert_eq!(by_digit(n, d), (n / divisor, remainder));
            prop_assert_eq!(by_digit(u64::MAX, d).0, u64::MAX / divisor);
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

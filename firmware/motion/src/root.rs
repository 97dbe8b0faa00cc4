//! The root of an integer, exactly; begun in floating point, which this processor has in hardware.

use crate::iterations::Iterations;
use crate::low;

/// A guess of twenty bits, behind a step of Newton's method that is cut to an integer, is off by no more than this.
const LAST_BITS: u32 = 2;

/// ⌊√square⌋.
///
/// The leading bits give a root of some twenty bits, and one step of Newton's method in integers the others.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a number in floating point, none of them below 0 but a step, is cut to the integer next to it"
)]
pub fn isqrt(square: u64) -> u32 {
    // An even shift, so that the root is shifted back by half of it.
    let above = square.leading_zeros() & 62;
    let high = square << above;
    let lead = ((high >> 32) as u32) as f32;
    let reciprocal = reciprocal_root(lead);
    // √high = 2¹⁶·√lead; what does not fit is the largest number.
    let rough = (lead * reciprocal * 65_536.0) as u32;
    let left = beyond(high, rough);
    let step = (low::i32(left >> 16) as f32 * reciprocal * 0.5) as i32;
    // Now it is the root, or next to it.
    let mut root = rough.saturating_add_signed(step);
    let mut left = beyond(high, root);
    let mut iterations = Iterations::at_most(LAST_BITS);
    while left < 0 {
        iterations.count();
        left += (i64::from(root) << 1) - 1;
        root -= 1;
    }
    let mut iterations = Iterations::at_most(LAST_BITS);
    while left > i64::from(root) << 1 {
        iterations.count();
        left -= (i64::from(root) << 1) + 1;
        root += 1;
    }
    root >> (above >> 1)
}

/// 1/√square, to some twenty-two bits; for 0, a large number.
pub(crate) fn reciprocal_root(square: f32) -> f32 {
    // Half of the exponent, the other way round: right to three parts in a hundred. Three steps of Newton's method do the others.
    let mut guess = f32::from_bits(0x5F37_59DF_u32.wrapping_sub(square.to_bits() >> 1));
    for _ in 0..3 {
        guess *= 1.5 - (square * 0.5 * guess) * guess;
    }
    guess
}

/// What a square has more than that of a root that is near.
const fn beyond(square: u64, root: u32) -> i64 {
    let root = root as u64;
    square.wrapping_sub(root.wrapping_mul(root)).cast_signed()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::contextualize_config;

    use super::isqrt;

    fn check(square: u64) {
        assert_eq!(u64::from(isqrt(square)), square.isqrt(), "of {square}");
    }

    #[test]
    fn roots_at_the_ends_are_exact() {
        for bits in 0..64 {
            for less in 0..3 {
                check((1_u64 << bits).wrapping_sub(less));
                check((1_u64 << bits).wrapping_add(less));
            }
        }
        check(u64::MAX);
    }

    proptest! {
        #![proptest_config(contextualize_config(ProptestConfig::with_cases(20_000)))]

        #[test]
        fn a_root_is_that_of_the_language(square: u64, shift in 0u32..64) {
            check(square >> shift);
        }

        #[test]
        fn a_square_has_its_root(side: u32, less in 0u64..2) {
            check((u64::from(side) * u64::from(side)).saturating_sub(less));
        }
    }
}

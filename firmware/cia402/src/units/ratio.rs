//! Exact ratios of increments to units.

use motion::{Speed, div_rem, low, quotient};

/// A ratio of two positive numbers in lowest terms: how many increments a unit is.
///
/// A conversion is one product of 128 bits and one division, rounded to the nearest, halves away from zero; so it treats both
/// directions alike. A result beyond 64 bits stops at their end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ratio {
    increments: u64,
    units: u64,
}

impl Ratio {
    /// A unit is an increment.
    pub const ONE: Self = Self {
        increments: 1,
        units: 1,
    };

    /// The product of `over` divided by the product of `under`. `None` if one of them is 0, or if what is left in lowest terms
    /// does not fit in 64 bits.
    pub fn of<const N: usize>(mut over: [u32; N], mut under: [u32; N]) -> Option<Self> {
        Self::reduced(&mut over, &mut under)
    }

    /// The same, once for every number of factors.
    #[inline(never)]
    fn reduced(over: &mut [u32], under: &mut [u32]) -> Option<Self> {
        for numerator in over.iter_mut() {
            for denominator in under.iter_mut() {
                let divisor = greatest_common_divisor(*numerator, *denominator);
                *numerator = numerator.checked_div(divisor)?;
                *denominator = denominator.checked_div(divisor)?;
            }
        }
        let product = |factors: &[u32]| {
            let product = factors.iter().try_fold(1_u64, |product, factor| {
                product.checked_mul(u64::from(*factor))
            });
            product.filter(|product| *product != 0)
        };
        Some(Self {
            increments: product(over)?,
            units: product(under)?,
        })
    }

    /// So many increments in so many units, not reduced; `None` if one of them is 0.
    pub const fn between(increments: u32, units: u32) -> Option<Self> {
        if increments == 0 || units == 0 {
            return None;
        }
        Some(Self {
            increments: increments as u64,
            units: units as u64,
        })
    }

    /// The speed of a number of units, where the ratio is in increments/s.
    #[inline]
    pub fn to_speed(self, units: u32) -> Speed {
        if self.is_one() {
            Speed::per_second(units)
        } else {
            Speed::from_bits(fine(units, self.increments, self.units))
        }
    }

    /// The number of units of a speed, where the ratio is in increments/s.
    #[inline]
    pub fn to_units_of_speed(self, speed: Speed) -> u64 {
        if self.is_one() {
            speed.whole().into()
        } else {
            coarse(speed.bits(), self.units, self.increments)
        }
    }

    /// Increments for a number of units.
    #[inline]
    pub fn to_increments(self, units: i64) -> i64 {
        if self.is_one() || units == 0 {
            units
        } else {
            scaled(units, self.increments, self.units)
        }
    }

    /// Units for a number of increments.
    #[inline]
    pub fn to_units(self, increments: i64) -> i64 {
        if self.is_one() || increments == 0 {
            increments
        } else {
            scaled(increments, self.units, self.increments)
        }
    }

    /// Whether a unit is an increment.
    #[inline]
    pub const fn is_one(self) -> bool {
        // In lowest terms.
        self.increments == self.units
    }
}

/// `value * numerator / denominator`, rounded to the nearest, halves away from zero.
#[inline(never)]
fn scaled(value: i64, numerator: u64, denominator: u64) -> i64 {
    let amount = value.unsigned_abs();
    let scaled = match (u32::try_from(numerator), u32::try_from(denominator)) {
        // So it is with all but odd factors and far positions.
        (Ok(numerator), Ok(denominator)) if amount >> 32 == 0 => {
            let product = (amount & u64::from(u32::MAX)) * u64::from(numerator);
            let (whole, rest) = div_rem(product, denominator);
            whole.saturating_add(u64::from(rest >= denominator - rest))
        }
        _ => wide(amount, numerator, denominator),
    };
    let scaled = i64::try_from(scaled).unwrap_or(i64::MAX);
    if value < 0 {
        scaled.wrapping_neg()
    } else {
        scaled
    }
}

/// `value * numerator / denominator` with 32 bits behind the point, rounded to the nearest.
#[inline(never)]
fn fine(value: u32, numerator: u64, denominator: u64) -> u64 {
    match (u32::try_from(numerator), u32::try_from(denominator)) {
        (Ok(numerator), Ok(denominator)) => {
            let product = u64::from(value) * u64::from(numerator);
            let (whole, rest) = div_rem(product, denominator);
            let Ok(whole) = u32::try_from(whole) else {
                return u64::MAX;
            };
            // The rest is less than the denominator, so this is one digit.
            let (part, rest) = div_rem(u64::from(rest) << 32, denominator);
            let half = u64::from(rest >= denominator - rest);
            (u64::from(whole) << 32).saturating_add(part + half)
        }
        _ => {
            let product = u128::from(value) * u128::from(numerator);
            let amount = quotient(product, 1, denominator.into());
            rounded(amount, product << 32, denominator.into())
        }
    }
}

/// `value * numerator / denominator` of a value with 32 bits behind the point, rounded to the nearest whole number.
#[inline(never)]
fn coarse(value: u64, numerator: u64, denominator: u64) -> u64 {
    match (u32::try_from(numerator), u32::try_from(denominator)) {
        (Ok(numerator), Ok(denominator)) => {
            let low = (value & u64::from(u32::MAX)) * u64::from(numerator);
            let high = (value >> 32) * u64::from(numerator);
            let (whole, rest) = div_rem(high + (low >> 32), denominator);
            // Behind the point only whether it is half or more can count.
            let twice = u64::from(rest) << 1 | (low >> 31 & 1);
            whole.saturating_add(u64::from(twice >= denominator.into()))
        }
        _ => {
            let product = u128::from(value) * u128::from(numerator);
            let denominator = u128::from(denominator) << 32;
            rounded(quotient(product, 0, denominator), product, denominator)
        }
    }
}

/// A quotient rounded down, to the nearest.
#[cold]
#[inline(never)]
fn rounded(whole: u128, numerator: u128, denominator: u128) -> u64 {
    let rest = numerator.wrapping_sub(whole.wrapping_mul(denominator));
    let is_half = rest >= denominator.wrapping_sub(rest);
    u64::try_from(whole.saturating_add(is_half.into())).unwrap_or(u64::MAX)
}

/// The same for all numbers.
#[cold]
#[inline(never)]
fn wide(value: u64, numerator: u64, denominator: u64) -> u64 {
    let product = u128::from(value) * u128::from(numerator);
    let whole = quotient(product, 0, denominator.into());
    // The remainder is less than the denominator: the lower half has all of it.
    let rest = low::u64(product).wrapping_sub(low::u64(whole).wrapping_mul(denominator));
    let is_half = rest >= denominator.wrapping_sub(rest);
    u64::try_from(whole.saturating_add(is_half.into())).unwrap_or(u64::MAX)
}

/// The greatest number that divides both; of 0 and a number that number.
fn greatest_common_divisor(mut a: u32, mut b: u32) -> u32 {
    while let Some(rest) = a.checked_rem(b) {
        a = b;
        b = rest;
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::contextualize_config;

    fn exact(value: i64, numerator: u64, denominator: u64) -> i64 {
        let (n, d) = (i128::from(numerator), i128::from(denominator));
        let product = i128::from(value).unsigned_abs() * n.unsigned_abs();
        let rounded = (product / d.unsigned_abs())
            + u128::from((product % d.unsigned_abs()) * 2 >= d.unsigned_abs());
        let amount = i64::try_from(rounded).unwrap_or(i64::MAX);
        if value < 0 { -amount } else { amount }
    }

    #[test]
    fn a_third_of_ten_is_rounded_to_the_nearest() {
        let ratio = Ratio::of([10, 1], [3, 1]).unwrap();
        assert_eq!(ratio.to_increments(1), 3);
        assert_eq!(ratio.to_increments(2), 7);
        assert_eq!(ratio.to_increments(-2), -7);
        assert_eq!(ratio.to_increments(10_000), 33_333);
        assert_eq!(ratio.to_units(33_333), 10_000);
    }

    #[test]
    fn halves_go_away_from_zero() {
        let half = Ratio::of([1], [2]).unwrap();
        assert_eq!((half.to_increments(3), half.to_increments(-3)), (2, -2));
        assert_eq!((half.to_increments(1), half.to_increments(-1)), (1, -1));
    }

    #[test]
    fn factors_that_cancel_are_one() {
        let ratio = Ratio::of([3200, 7, 100], [700, 3200, 1]).unwrap();
        assert!(ratio.is_one());
    }

    #[test]
    fn m73_what_cannot_be_represented_is_none() {
        assert_eq!(Ratio::of([0, 1], [1, 1]), None);
        assert_eq!(Ratio::of([1, 1], [1, 0]), None);
        assert_eq!(Ratio::of([u32::MAX; 3], [1; 3]), None);
        assert_eq!(Ratio::of([1; 3], [u32::MAX; 3]), None);
        assert!(Ratio::of([u32::MAX, u32::MAX, 1], [1, 1, u32::MAX - 1]).is_some());
    }

    #[test]
    fn m73_results_beyond_64_bits_stop_at_their_end() {
        let large = Ratio::of([u32::MAX, u32::MAX], [1, 1]).unwrap();
        assert_eq!(large.to_increments(i64::MIN), -i64::MAX);
        assert_eq!(large.to_increments(i64::from(i32::MAX)), i64::MAX);
        let small = Ratio::of([1, 1], [u32::MAX, u32::MAX]).unwrap();
        assert_eq!(small.to_units(i64::MAX), i64::MAX);
        assert_eq!(small.to_increments(i64::from(i32::MAX)), 0);
    }

    proptest! {
        #![proptest_config(contextualize_config(ProptestConfig::with_cases(2048)))]

        #[test]
        fn m73_conversions_are_exact(
            over in prop::array::uniform2(1..u32::MAX),
            under in prop::array::uniform2(1..u32::MAX),
            s in 0u32..32, u in 0u32..32, value: i64, v in 0u32..64,
        ) {
            let over = over.map(|n| (n >> s).max(1));
            let under = under.map(|n| (n >> u).max(1));
            let Some(ratio) = Ratio::of(over, under) else {
                return Ok(());
            };
            let value = value >> v;
            let product = |factors: [u32; 2]| u64::from(factors[0]) * u64::from(factors[1]);
            let expected = exact(value, product(over), product(under));
            prop_assert_eq!(ratio.to_increments(value), expected);
            prop_assert_eq!(ratio.to_increments(value.saturating_neg()), expected.saturating_neg());
        }

        #[test]
        fn m73_speeds_are_exact_to_their_last_bit(
            over in prop::array::uniform2(1..u32::MAX),
            under in prop::array::uniform2(1..u32::MAX),
            s in 0u32..32, u in 0u32..32, units: u32, bits: u64, v in 0u32..64,
        ) {
            let over = over.map(|n| (n >> s).max(1));
            let under = under.map(|n| (n >> u).max(1));
            let Some(ratio) = Ratio::of(over, under) else {
                return Ok(());
            };
            let product = |factors: [u32; 2]| u128::from(factors[0]) * u128::from(factors[1]);
            let nearest = |n: u128, d: u128| u64::try_from(n / d + u128::from(n % d >= d - n % d));
            let speed = nearest((u128::from(units) * product(over)) << 32, product(under));
            prop_assert_eq!(ratio.to_speed(units).bits(), speed.unwrap_or(u64::MAX));
            let bits = bits >> v;
            let (n, d) = (u128::from(bits) * u128::from(ratio.units), u128::from(ratio.increments) << 32);
            let expected = nearest(n, d).unwrap_or(u64::MAX);
            let shown = ratio.to_units_of_speed(Speed::from_bits(bits));
            // Whole numbers of steps/s stop at their end.
            prop_assert!(shown == expected || ratio.is_one() && expected == 1 << 32, "{} {}", shown, expected);
        }

        #[test]
        fn m73_there_and_back_is_the_same_or_next_to_it(over: u32, under: u32, value: i32) {
            let (over, under) = (over.max(1), under.max(1));
            let ratio = Ratio::of([over], [under]).unwrap();
            let value = i64::from(value);
            let increments = ratio.to_increments(value);
            let back = ratio.to_units(increments);
            if over >= under {
                prop_assert_eq!(back, value);
            }
            // Never more than a unit, or half an increment.
            let half = i64::from(under.div_ceil(over).div_ceil(2)).max(1);
            prop_assert!((back - value).abs() <= half);
            prop_assert!((ratio.to_increments(back) - increments).abs() <= 1);
        }
    }
}

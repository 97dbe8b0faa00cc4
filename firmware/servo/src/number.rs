//! Numbers of 32 bits that stay numbers. What is asked in many places is out of line, but for what a period of the current loop asks.

use core::hint::cold_path;

/// The value within a bound on both sides; NaN is 0. A bound below 0 or that is NaN is 0 as well.
#[inline(never)]
pub fn limit(value: f32, bound: f32) -> f32 {
    limit_at_once(value, bound)
}

/// The same where there is no time for a call.
#[inline(always)]
pub(crate) fn limit_at_once(value: f32, bound: f32) -> f32 {
    // Most are; only what is not needs more than one comparison.
    if value.abs() <= bound {
        return value;
    }
    cold_path();
    let bound = if bound > 0.0 { bound } else { 0.0 };
    if value > bound {
        bound
    } else if value < -bound {
        -bound
    } else {
        0.0
    }
}

/// The value, cut to `min` ..= `max`; for NaN the value in this range that is nearest to 0.
#[inline(never)]
pub fn between(value: f32, min: f32, max: f32) -> f32 {
    if value > max {
        max
    } else if value >= min {
        value
    } else if value < min || min > 0.0 {
        min
    } else if max < 0.0 {
        max
    } else {
        0.0
    }
}

/// From −2 to the power of the bits to one less than that on the other side.
#[inline(always)]
pub(crate) fn held(value: i32, bits: u32) -> i32 {
    value.clamp(-(1 << bits), (1 << bits) - 1)
}

/// The greater one; the other if one is NaN.
#[inline]
pub fn greater(one: f32, other: f32) -> f32 {
    if one > other { one } else { other }
}

/// The lesser one; the other if one is NaN.
#[inline]
pub fn lesser(one: f32, other: f32) -> f32 {
    if one < other { one } else { other }
}

/// The value, cut to `min` ..= `max`; for NaN `min`.
#[inline]
pub fn within(value: f32, min: f32, max: f32) -> f32 {
    lesser(greater(value, min), max)
}

/// Whether a value lies in a range; NaN does not.
#[inline(never)]
pub fn is_within(value: f32, min: f32, max: f32) -> bool {
    value >= min && value <= max
}

/// Whether each value lies in its range; NaN does not. A row of these is smaller than as many calls.
pub(crate) fn are_within<const N: usize>(values: [f32; N], ranges: &[(f32, f32); N]) -> bool {
    all_within(&values, ranges)
}

#[inline(never)]
fn all_within(values: &[f32], ranges: &[(f32, f32)]) -> bool {
    let mut pairs = values.iter().zip(ranges);
    pairs.all(|(value, (min, max))| value >= min && value <= max)
}

/// The square root; 0 for a subnormal or negative value and for NaN. Within 10⁻⁶ of it.
///
/// Two of Newton's steps for 1/√x, the first one with the factors that suit the first guess, which halves the exponent.
#[inline(never)]
pub fn root(value: f32) -> f32 {
    if !(f32::MIN_POSITIVE.to_bits()..f32::INFINITY.to_bits()).contains(&value.to_bits()) {
        return 0.0;
    }
    root_of_number(value)
}

/// The same of 0 or a finite number above it, where there is no time for a call.
#[inline(always)]
pub(crate) fn root_of_number(value: f32) -> f32 {
    let inverse = inverse_root(value);
    let root = value * inverse;
    root * (1.5 - 0.5 * root * inverse)
}

/// 1/√x of a finite number above 0, within 7 · 10⁻⁴ of it: the first of these steps.
#[inline(always)]
pub(crate) fn inverse_root(value: f32) -> f32 {
    let guess = f32::from_bits(0x5F1F_FFF9_u32.wrapping_sub(value.to_bits() >> 1));
    guess * (1.681_913_9 - 0.703_952_25 * value * guess * guess)
}

/// The whole number toward 0; the nearest one of what is beyond 64 bits, and 0 for NaN.
#[inline(never)]
pub fn whole(value: f32) -> i64 {
    value as i64
}

/// The factor by which something fades in a period, when it fades at so many rad/s: e^(−rate · period), as a quotient that stays between 0 and 1.
#[inline(never)]
pub fn fade(rate: f32, period: f32) -> f32 {
    let half = between(rate * period / 2.0, 0.0, 1.0);
    (1.0 - half) / (1.0 + half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_becomes_one() {
        for value in [f32::NAN, f32::INFINITY, -f32::INFINITY, 3.0, -3.0, 0.5] {
            for bound in [f32::NAN, f32::INFINITY, -1.0, 0.0, 2.0] {
                let held = limit(value, bound);
                assert!(!held.is_nan(), "{value} within {bound}");
                assert!(held.abs() <= bound.max(0.0), "{value} within {bound}");
            }
        }
        assert_eq!(between(f32::NAN, 1.0, 2.0), 1.0);
        assert_eq!(within(f32::NAN, -1.0, 2.0), -1.0);
        assert_eq!(between(f32::NAN, -2.0, -1.0), -1.0);
        assert_eq!(limit(1.5, 2.0), 1.5);
    }

    #[test]
    fn each_value_has_its_range() {
        let ranges = [(0.0, 1.0), (-2.0, -1.0)];
        assert!(are_within([0.0, -1.0], &ranges));
        for wrong in [[1.5, -1.0], [0.5, 0.5], [f32::NAN, -1.0], [0.5, f32::NAN]] {
            assert!(!are_within(wrong, &ranges), "{wrong:?}");
        }
    }

    #[test]
    fn a_root_is_one() {
        for value in [1e-30_f32, 1e-6, 0.3, 1.0, 2.0, 48.0, 1e9, 3e37] {
            let away = root(value) / value.sqrt() - 1.0;
            assert!(away.abs() < 1e-6, "of {value}: {away}");
        }
        for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(root(value), 0.0);
        }
    }
}

//! How the numbers of a manufacturer's object and those of the drive relate.
//!
//! A binding says `parameter = object * scale + offset`. Results are rounded to the nearest number (halves away from zero) and
//! stop at the ends of a type instead of wrapping.

/// A scale and an offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conversion {
    numerator: i32,
    denominator: i32,
    offset: i64,
}

impl Conversion {
    /// `object * numerator / denominator + offset`.
    ///
    /// # Panics
    /// When numerator or denominator is 0. It is for constants, so that this is found by the compiler.
    pub const fn new(numerator: i32, denominator: i32, offset: i64) -> Self {
        assert!(numerator != 0 && denominator != 0, "a scale is not 0");
        Self {
            numerator,
            denominator,
            offset,
        }
    }

    /// What a number in the object means to the drive.
    pub fn to_parameter(self, object: i64) -> i64 {
        scaled(object, self.numerator, self.denominator).saturating_add(self.offset)
    }

    /// What the object shows for a number of the drive.
    pub fn to_object(self, parameter: i64) -> i64 {
        scaled(
            parameter.saturating_sub(self.offset),
            self.denominator,
            self.numerator,
        )
    }
}

/// `value * numerator / denominator`, rounded.
fn scaled(value: i64, numerator: i32, denominator: i32) -> i64 {
    let product = value.saturating_mul(i64::from(numerator));
    let divisor = i64::from(denominator);
    let (Some(quotient), Some(rest)) = (product.checked_div(divisor), product.checked_rem(divisor))
    else {
        // Only the most negative number by -1: the constructor keeps 0 out.
        return i64::MAX;
    };
    let is_half = rest.unsigned_abs().saturating_mul(2) >= divisor.unsigned_abs();
    let away = if (rest < 0) == (divisor < 0) { 1 } else { -1 };
    if is_half {
        quotient.saturating_add(away)
    } else {
        quotient
    }
}

#[cfg(test)]
mod tests;

//! From the numbers of a manufacturer's object to those of the drive, and back.
//!
//! A binding says `parameter = object * scale + offset`. The code that `od-gen` writes for it calls these functions; they
//! round to the nearest number (halves away from zero) and stop at the ends of a type instead of wrapping.

use canopen::cia301::sdo::AbortCode;

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

/// What a written number means, if that is a number and within `low` to `high`.
///
/// # Errors
/// 06090030h for a number that means nothing, 06090031h and 06090032h for one that means too much or too little.
pub fn within(number: Option<i64>, low: i64, high: i64) -> Result<i64, AbortCode> {
    match number {
        None => Err(AbortCode::InvalidValue),
        Some(number) if number > high => Err(AbortCode::ValueTooHigh),
        Some(number) if number < low => Err(AbortCode::ValueTooLow),
        Some(number) => Ok(number),
    }
}

/// A number of a dictionary.
pub trait Number: Copy {
    /// As a number of 64 bits; an UNSIGNED64 stops at the largest.
    fn number(self) -> i64;

    /// The nearest of its own numbers.
    fn nearest(number: i64) -> Self;
}

/// Numbers of up to 32 bits, which all fit.
macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl Number for $type {
            fn number(self) -> i64 {
                i64::from(self)
            }

            fn nearest(number: i64) -> Self {
                let end = if number < 0 { Self::MIN } else { Self::MAX };
                Self::try_from(number).unwrap_or(end)
            }
        }
    )*};
}

numbers!(i8, i16, i32, i64, u8, u16, u32);

impl Number for u64 {
    fn number(self) -> i64 {
        i64::try_from(self).unwrap_or(i64::MAX)
    }

    fn nearest(number: i64) -> Self {
        Self::try_from(number).unwrap_or(0)
    }
}

impl Number for bool {
    fn number(self) -> i64 {
        i64::from(self)
    }

    fn nearest(number: i64) -> Self {
        number != 0
    }
}

#[cfg(test)]
mod tests;

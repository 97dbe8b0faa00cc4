//! From the numbers of a manufacturer's object to those of the drive, and back.
//!
//! The code that `od-gen` writes for a binding calls these functions.

use canopen::cia301::sdo::AbortCode;
pub use cia402_parameters::Conversion;

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

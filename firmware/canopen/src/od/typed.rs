//! Between the bytes of a value and the types of Rust: what the getters and setters of a generated dictionary are made of.
//!
//! Offsets are constants that the compiler checks against the block; no call can fail at run time.

use core::fmt;

use crate::copy::copy;
use crate::wire::sdo::AbortCode;

/// The `N` bytes of the block at `AT`.
#[inline]
pub const fn bytes_at<const AT: usize, const N: usize, const SIZE: usize>(
    ram: &[u8; SIZE],
) -> [u8; N] {
    const { assert!(AT + N <= SIZE, "a value lies outside of the block") };
    match ram.split_at_checked(AT) {
        Some((_, rest)) => match rest.first_chunk::<N>() {
            Some(bytes) => *bytes,
            None => [0; N],
        },
        None => [0; N],
    }
}

/// Puts `N` bytes into the block at `AT`.
#[inline]
pub const fn put_at<const AT: usize, const N: usize, const SIZE: usize>(
    ram: &mut [u8; SIZE],
    bytes: [u8; N],
) {
    const { assert!(AT + N <= SIZE, "a value lies outside of the block") };
    if let Some((_, rest)) = ram.split_at_mut_checked(AT)
        && let Some(place) = rest.first_chunk_mut::<N>()
    {
        *place = bytes;
    }
}

/// A number that the 24, 40, 48 or 56 bits of its type do not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfRange;

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the number does not fit the type of its object")
    }
}

impl core::error::Error for OutOfRange {}

/// An INTEGER40, INTEGER48 or INTEGER56 (or any other of up to eight bytes), the lowest byte first.
#[inline]
pub const fn signed<const N: usize>(bytes: [u8; N]) -> i64 {
    let unused = 64_u32.saturating_sub(8 * N as u32);
    // Up to the top and back down: the shift right of a signed number copies its sign.
    (unsigned(bytes) << (unused & 63)).cast_signed() >> (unused & 63)
}

/// An UNSIGNED40, UNSIGNED48 or UNSIGNED56 (or any other of up to eight bytes), the lowest byte first.
#[inline]
pub const fn unsigned<const N: usize>(bytes: [u8; N]) -> u64 {
    const { assert!(N >= 1 && N <= 8, "numbers have up to eight bytes") };
    let mut number = 0;
    let mut rest = bytes.as_slice();
    while let [before @ .., byte] = rest {
        number = number << 8 | *byte as u64;
        rest = before;
    }
    number
}

/// The lowest `N` bytes of a signed number.
///
/// # Errors
/// The number needs more.
#[inline]
pub const fn signed_bytes<const N: usize>(number: i64) -> Result<[u8; N], OutOfRange> {
    match number.to_le_bytes().first_chunk::<N>() {
        Some(bytes) if signed(*bytes) == number => Ok(*bytes),
        _ => Err(OutOfRange),
    }
}

/// The lowest `N` bytes of a number.
///
/// # Errors
/// The number needs more.
#[inline]
pub const fn unsigned_bytes<const N: usize>(number: u64) -> Result<[u8; N], OutOfRange> {
    match number.to_le_bytes().first_chunk::<N>() {
        Some(bytes) if unsigned(*bytes) == number => Ok(*bytes),
        _ => Err(OutOfRange),
    }
}

impl From<OutOfRange> for AbortCode {
    fn from(_: OutOfRange) -> Self {
        Self::General
    }
}

/// Puts the bytes of a number where a client is to get them from, and returns how many those are: what
/// [`Application::read_at`](crate::Application::read_at) does for a number that the application has.
#[inline]
pub fn give<const N: usize>(bytes: [u8; N], into: &mut [u8]) -> usize {
    copy(into, &bytes);
    N.min(into.len())
}

/// A value of TIME_OF_DAY or TIME_DIFFERENCE (CiA 301, 7.1.6.5 and 7.1.6.6): days, and the time of the day.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct DayTime {
    /// Days; of a TIME_OF_DAY since the first of January 1984.
    pub days: u16,
    /// Milliseconds after midnight, of which 28 bits travel.
    pub milliseconds: u32,
}

impl DayTime {
    /// The value of six bytes on the bus; the four bits above the milliseconds are reserved.
    pub const fn from_le_bytes(bytes: [u8; 6]) -> Self {
        let [a, b, c, d, low, high] = bytes;
        Self {
            days: u16::from_le_bytes([low, high]),
            milliseconds: u32::from_le_bytes([a, b, c, d]) & 0x0FFF_FFFF,
        }
    }

    /// Six bytes on the bus.
    pub const fn to_le_bytes(self) -> [u8; 6] {
        let [a, b, c, d] = (self.milliseconds & 0x0FFF_FFFF).to_le_bytes();
        let [low, high] = self.days.to_le_bytes();
        [a, b, c, d, low, high]
    }
}

/// What a getter returns: a number or a time, made of bytes of any length.
pub trait Value {
    /// The value of bytes in the order of the bus. Those of a number may be fewer than its type has, as in an INTEGER24; other
    /// lengths, which a checked value has not, give 0.
    fn of(bytes: &[u8]) -> Self;
}

macro_rules! numbers {
    ($as_long:ident: $($type:ty),*) => {$(
        impl Value for $type {
            #[inline]
            fn of(bytes: &[u8]) -> Self {
                match bytes.try_into() {
                    Ok(bytes) => Self::from_le_bytes(bytes),
                    // Shorter than its type: the type has room for it.
                    Err(_) => Self::try_from($as_long(bytes)).unwrap_or(0),
                }
            }
        }
    )*};
}

numbers!(signed_of: i8, i16, i32, i64);
numbers!(unsigned_of: u8, u16, u32, u64);

#[cold]
fn signed_of(bytes: &[u8]) -> i64 {
    match *bytes {
        [a, b, c] => signed([a, b, c]),
        [a, b, c, d, e] => signed([a, b, c, d, e]),
        [a, b, c, d, e, f] => signed([a, b, c, d, e, f]),
        [a, b, c, d, e, f, g] => signed([a, b, c, d, e, f, g]),
        _ => 0,
    }
}

#[cold]
fn unsigned_of(bytes: &[u8]) -> u64 {
    match *bytes {
        [a, b, c] => unsigned([a, b, c]),
        [a, b, c, d, e] => unsigned([a, b, c, d, e]),
        [a, b, c, d, e, f] => unsigned([a, b, c, d, e, f]),
        [a, b, c, d, e, f, g] => unsigned([a, b, c, d, e, f, g]),
        _ => 0,
    }
}

impl Value for bool {
    fn of(bytes: &[u8]) -> Self {
        u8::of(bytes) != 0
    }
}

impl Value for f32 {
    fn of(bytes: &[u8]) -> Self {
        Self::from_bits(u32::of(bytes))
    }
}

impl Value for f64 {
    fn of(bytes: &[u8]) -> Self {
        Self::from_bits(u64::of(bytes))
    }
}

impl Value for DayTime {
    fn of(bytes: &[u8]) -> Self {
        Self::from_le_bytes(bytes.try_into().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests;

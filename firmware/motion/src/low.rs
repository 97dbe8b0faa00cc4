//! Narrowing conversions of integers: the low bits of a wider one, by name.
//!
//! `as` cuts bits off and changes signs without a word, so it is not written for that in this crate nor in the drive above it (the cast lints of clippy are
//! on): what is cut off, is cut off here. That is right where the number is known to fit, as the caller says, and where it counts modulo a power of two,
//! as positions and ticks do. Signs change by `cast_signed` and `cast_unsigned`. Each is an instruction at most.
#![allow(
    clippy::cast_possible_truncation,
    reason = "it is what this file is for"
)]

/// The low 8 bits.
#[inline(always)]
pub const fn u8(value: u32) -> u8 {
    value as u8
}

/// The low 16 bits.
#[inline(always)]
pub const fn u16(value: u32) -> u16 {
    value as u16
}

/// The low 32 bits.
#[inline(always)]
pub const fn u32(value: u64) -> u32 {
    value as u32
}

/// The low 32 bits of a number as long as an address, all that it has on the processors that this is for. Nothing that is counted in memory has more.
#[inline(always)]
pub const fn word(value: usize) -> u32 {
    value as u32
}

/// The low 64 bits.
#[inline(always)]
pub const fn u64(value: u128) -> u64 {
    value as u64
}

/// The low 16 bits, with the sign that they make.
#[inline(always)]
pub const fn i16(value: i64) -> i16 {
    value as i16
}

/// The low 32 bits, with the sign that they make: positions are counted modulo 2³².
#[inline(always)]
pub const fn i32(value: i64) -> i32 {
    value as i32
}

/// The low 64 bits, with the sign that they make.
#[inline(always)]
pub const fn i64(value: i128) -> i64 {
    value as i64
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_low_bits_are_what_stays() {
        assert_eq!(super::u8(0x1FE), 0xFE);
        assert_eq!(super::u16(0x1_FFFE), 0xFFFE);
        assert_eq!(super::u32(0x1_0000_0002), 2);
        assert_eq!(super::word(3), 3);
        assert_eq!(super::u64(1 << 64 | 5), 5);
        assert_eq!(super::i16(0x8000), i16::MIN);
        assert_eq!(super::i32(0x8000_0000), i32::MIN);
        assert_eq!(super::i64(1 << 63), i64::MIN);
        assert_eq!(super::i64(-1), -1);
    }
}

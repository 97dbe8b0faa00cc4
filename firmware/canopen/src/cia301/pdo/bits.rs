//! Bits of a frame that begin or end within a byte.
//!
//! The first bit of a frame is bit 0 of its first byte, so a frame is one little-endian number, and a value is a shift and a
//! mask. Values that are whole bytes at whole bytes take the shorter way of copies.

/// Whether a value at this bit of the frame, so many bits long, is whole bytes.
#[inline]
pub(super) const fn are_bytes(position: u8, bits: u8) -> bool {
    (position | bits) & 7 == 0
}

/// The lowest `bits` bits, 1 to 64.
const fn mask(bits: u8) -> u64 {
    u64::MAX.wrapping_shr(64_u32.wrapping_sub(bits as u32))
}

/// The value at `position` (0 to 63), `bits` long (1 to 64), as a number; the bits above are 0.
pub(super) fn get(frame: &[u8; 8], position: u8, bits: u8) -> u64 {
    u64::from_le_bytes(*frame).wrapping_shr(position.into()) & mask(bits)
}

/// `frame` with the low `bits` bits (1 to 64) of a value at `position` (0 to 63), where it was 0 before.
pub(super) fn with(frame: u64, position: u8, bits: u8, value: u64) -> u64 {
    frame | (value & mask(bits)).wrapping_shl(position.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p24_a_value_lies_across_bytes_low_bits_first() {
        let frame = with(0, 0, 1, 1);
        let frame = with(frame, 1, 7, 0b101_0101);
        let frame = with(frame, 8, 16, 0xA55A);
        assert_eq!(frame.to_le_bytes(), [0xAB, 0x5A, 0xA5, 0, 0, 0, 0, 0]);
        assert_eq!(get(&frame.to_le_bytes(), 1, 7), 0b101_0101);
        assert_eq!(get(&frame.to_le_bytes(), 4, 8), 0xAA);
    }

    #[test]
    fn p41_a_value_of_64_bits_is_the_frame() {
        let value = 0x8877_6655_4433_2211;
        assert_eq!(with(0, 0, 64, value), value);
        assert_eq!(get(&value.to_le_bytes(), 0, 64), value);
    }

    #[test]
    fn p41_bits_beyond_the_length_are_left_out() {
        assert_eq!(with(0, 60, 4, 0xFFFF), 0xF000_0000_0000_0000);
        assert_eq!(get(&[0xFF; 8], 63, 1), 1);
    }
}

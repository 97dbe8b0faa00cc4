//! The checksum of block transfer (CiA 301, 7.2.4.3.16): CRC-16/CCITT, polynomial x^16 + x^12 + x^5 + 1, start value 0,
//! highest bit first ("XMODEM" in catalogues).
//!
//! The polynomial has so few terms that up to four bytes are divided by it at once, in a dozen instructions and without a table:
//! its inverse is a product of three short ones.

/// The checksum of what came before (`crc`) and these bytes. Only the last segment needs it, once.
#[inline(never)]
pub(super) fn add(crc: u16, bytes: &[u8]) -> u16 {
    let (words, rest) = bytes.as_chunks::<4>();
    let crc = words.iter().fold(crc, |crc, word| {
        remainder(u32::from_be_bytes(*word) ^ u32::from(crc) << 16)
    });
    rest.iter().fold(crc, |crc, byte| {
        remainder(u32::from(*byte) ^ u32::from(crc >> 8)) ^ crc << 8
    })
}

/// The checksum of what came before and the seven bytes of a full segment, which lie behind byte 0 of its frame.
#[inline(always)] // Of a segment it is an eighth of the work.
pub(super) fn add_segment(crc: u16, frame: &[u8; 8]) -> u16 {
    // Two loads of a word. The command falls out of the first one.
    let words = u64::from_be_bytes(*frame);
    let first = (words >> 32) as u32 & 0x00FF_FFFF;
    let crc = remainder(first ^ u32::from(crc) << 8);
    remainder(words as u32 ^ u32::from(crc) << 16)
}

/// The remainder of `value` * x^16.
///
/// The quotient is `value` / (1 + s) with s = x^-4 + x^-11 + x^-16. In powers of two, (1 + s)^2 = 1 + s^2 and so on, the inverse
/// of 1 + s is (1 + s)(1 + s^2)(1 + s^4) / (1 + s^8), and s^8 is beyond the 32 bits.
#[inline]
const fn remainder(value: u32) -> u16 {
    let mut quotient = value ^ value >> 4 ^ value >> 11 ^ value >> 16;
    quotient ^= quotient >> 8 ^ quotient >> 22;
    quotient ^= quotient >> 16;
    (quotient ^ quotient << 5 ^ quotient << 12) as u16
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{add, add_segment};

    #[test]
    fn b04_the_catalogue_values() {
        assert_eq!(add(0, b"123456789"), 0x31C3);
        assert_eq!(add(0, b"ABCDEFGHIJKLMNOPQRST"), 0x1034);
        assert_eq!(add(0, &[0x91, 0x01, 0x0F, 0x00]), 0x9725);
        assert_eq!(add(0, b"ABCDEFGHIJKLMN"), 0x38D6);
    }

    proptest! {
        #[test]
        fn it_is_the_remainder_of_a_long_division(data: std::vec::Vec<u8>, split: usize) {
            let mut remainder = 0_u16;
            for bit in data.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1)) {
                let overflow = remainder >> 15 ^ u16::from(bit);
                remainder = (remainder << 1) ^ (0x1021 * overflow);
            }
            prop_assert_eq!(add(0, &data), remainder);
            if let Some(segment) = data.first_chunk::<7>() {
                let [a, b, c, d, e, f, g] = *segment;
                let frame = [0x85, a, b, c, d, e, f, g];
                prop_assert_eq!(add_segment(split as u16, &frame), add(split as u16, segment));
            }
            let (first, second) = data.split_at(split % (data.len() + 1));
            prop_assert_eq!(add(add(0, first), second), remainder);
        }
    }
}

//! The checksum of block transfer (CiA 301, 7.2.4.3.16): CRC-16/CCITT, polynomial x^16 + x^12 + x^5 + 1, start value 0,
//! highest bit first ("XMODEM" in catalogues).
//!
//! The polynomial has so few terms that the remainder of a byte is four shifts of the byte itself: six instructions a byte and no table.
//! A table of 512 bytes costs the same, a smaller one more.

/// The checksum of what came before (`crc`) and these bytes.
#[inline]
pub(super) fn add(crc: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(crc, |crc, byte| {
        let mut quotient = crc >> 8 ^ u16::from(*byte);
        quotient ^= quotient >> 4;
        crc << 8 ^ quotient << 12 ^ quotient << 5 ^ quotient
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::add;

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
            let (first, second) = data.split_at(split % (data.len() + 1));
            prop_assert_eq!(add(add(0, first), second), remainder);
        }
    }
}

//! The CRC of block transfers (CiA 301, 7.2.4.3.16), bit by bit as the standard writes it: slow, and not the firmware's.

/// The CRC-16 with the polynomial 1021h that starts with 0.
pub fn crc(data: &[u8]) -> u16 {
    let mut crc = 0_u16;
    for byte in data {
        crc ^= u16::from(*byte) << 8;
        for _ in 0..8 {
            let carry = crc & 0x8000 != 0;
            crc <<= 1;
            if carry {
                crc ^= 0x1021;
            }
        }
    }
    crc
}

#[cfg(test)]
mod tests {
    use super::crc;

    #[test]
    fn known_values() {
        assert_eq!(crc(b"123456789"), 0x31C3);
        assert_eq!(crc(b"ABCDEFGHIJKLMNOPQRST"), 0x1034);
        assert_eq!(crc(&[]), 0);
    }
}

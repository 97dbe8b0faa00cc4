//! A serial number (CiA 301, 7.5.2.16: object 1018h:4) from the unique identifier of a chip.
//!
//! Chips have more bits than an object of 32 has room for, and chips of one batch differ in few of them. They are folded by FNV-1a:
//! every bit of the identifier has a part in every bit of the serial number. Two devices of a thousand have the same number with a
//! chance of one in nine thousand; production that wants to be sure writes numbers of its own.

/// The bytes of an identifier, folded: FNV-1a, 32 bits.
pub fn fold(identifier: impl IntoIterator<Item = u8>) -> u32 {
    identifier.into_iter().fold(0x811C_9DC5, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::fold;

    #[test]
    fn the_fold_is_that_of_fnv_1a() {
        for (text, expected) in [
            ("", 0x811C_9DC5),
            ("a", 0xE40C_292C),
            ("foobar", 0xBF9C_F968),
        ] {
            assert_eq!(fold(text.bytes()), expected);
        }
    }

    #[test]
    fn identifiers_that_differ_in_one_bit_have_different_serial_numbers() {
        let identifier: u128 = 0x3230_3832_3047_0A0F_0031_002D;
        let numbers: BTreeSet<u32> = (0..96)
            .map(|bit| fold((identifier ^ 1 << bit).to_le_bytes().into_iter().take(12)))
            .collect();
        assert_eq!(numbers.len(), 96);
        assert!(!numbers.contains(&fold(identifier.to_le_bytes().into_iter().take(12))));
    }
}

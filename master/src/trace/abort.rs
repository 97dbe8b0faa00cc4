//! SDO abort codes in words (CiA 301, table 22).

/// Every code of the standard.
const WORDS: [(u32, &str); 31] = [
    (0x0503_0000, "toggle bit not alternated"),
    (0x0504_0000, "SDO protocol timed out"),
    (0x0504_0001, "command specifier not valid or unknown"),
    (0x0504_0002, "invalid block size"),
    (0x0504_0003, "invalid sequence number"),
    (0x0504_0004, "CRC error"),
    (0x0504_0005, "out of memory"),
    (0x0601_0000, "unsupported access to an object"),
    (0x0601_0001, "attempt to read a write-only object"),
    (0x0601_0002, "attempt to write a read-only object"),
    (0x0602_0000, "object does not exist"),
    (0x0604_0041, "object cannot be mapped to the PDO"),
    (
        0x0604_0042,
        "mapped objects would exceed the length of the PDO",
    ),
    (0x0604_0043, "general parameter incompatibility"),
    (
        0x0604_0047,
        "general internal incompatibility in the device",
    ),
    (0x0606_0000, "access failed due to a hardware error"),
    (0x0607_0010, "data type or length does not match"),
    (0x0607_0012, "length too high"),
    (0x0607_0013, "length too low"),
    (0x0609_0011, "sub-index does not exist"),
    (0x0609_0030, "invalid value"),
    (0x0609_0031, "value too high"),
    (0x0609_0032, "value too low"),
    (0x0609_0036, "maximum value is less than minimum value"),
    (0x060A_0023, "resource not available: SDO connection"),
    (0x0800_0000, "general error"),
    (0x0800_0020, "data cannot be transferred or stored"),
    (0x0800_0021, "not possible because of local control"),
    (
        0x0800_0022,
        "not possible in the present state of the device",
    ),
    (0x0800_0023, "no object dictionary is present"),
    (0x0800_0024, "no data available"),
];

/// What a code says; nothing for one that the standard does not have.
pub fn abort_words(code: u32) -> Option<&'static str> {
    let found = WORDS.iter().find(|(known, _)| *known == code);
    found.map(|(_, words)| *words)
}

/// `06010002h: attempt to write a read-only object`.
pub fn abort_code(code: u32) -> String {
    match abort_words(code) {
        Some(words) => format!("{code:08X}h: {words}"),
        None => format!("{code:08X}h"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_their_words() {
        let words = abort_code(0x0601_0002);
        assert_eq!(words, "06010002h: attempt to write a read-only object");
        assert_eq!(abort_code(0x1234_5678), "12345678h");
    }

    #[test]
    fn codes_stand_in_their_order_once() {
        assert!(WORDS.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}

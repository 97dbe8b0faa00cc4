//! Names and values of objects, from the data sheet.

use crate::data_sheet::DataSheet;
use crate::trace::words;

/// `6083h profile acceleration`, with `:01` behind the index if the object has sub-indexes.
pub fn name(sheet: &DataSheet, index: u16, sub: u8) -> String {
    let name = known_as(sheet, index, sub).unwrap_or_default();
    let has_subs = sheet
        .object(index)
        .is_some_and(|object| object.entries.len() > 1);
    let number = if has_subs || sub > 0 {
        format!("{index:04X}h:{sub:02X}")
    } else {
        format!("{index:04X}h")
    };
    format!("{number} {name}").trim_end().to_owned()
}

/// A value as people like to read it: words for controlword and statusword, text for strings, hexadecimal for
/// communication objects, decimal for the rest.
pub fn value(sheet: &DataSheet, index: u16, sub: u8, bytes: &[u8]) -> String {
    let number = bytes
        .iter()
        .rev()
        .fold(0u64, |number, byte| number << 8 | u64::from(*byte));
    let data_type = sheet.entry(index, sub).map(|entry| entry.data_type);
    match index {
        0x6040 => words::controlword(number as u16),
        0x6041 => words::statusword(number as u16),
        _ if bytes.len() > 8 => long(bytes),
        0x1000..=0x1FFF if bytes.len() > 1 => {
            format!("{number:0width$X}h", width = 2 * bytes.len())
        }
        _ if data_type.is_some_and(|known| known.is_signed()) && !bytes.is_empty() => {
            let unused = 64 - 8 * bytes.len() as u32;
            (((number << unused) as i64) >> unused).to_string()
        }
        _ => number.to_string(),
    }
}

/// A text as it is; what is none by its length.
fn long(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) if !text.contains(|letter: char| letter.is_control()) => format!("\"{text}\""),
        _ => format!("{} bytes", bytes.len()),
    }
}

/// The name in a few words for a PDO: `position actual value -5`, or only the words of controlword and statusword.
pub fn short(sheet: &DataSheet, index: u16, sub: u8, bytes: &[u8]) -> String {
    let value = value(sheet, index, sub, bytes);
    match (index, known_as(sheet, index, sub)) {
        (0x6040 | 0x6041, _) | (_, None) => value,
        (_, Some(name)) => format!("{name} {value}"),
    }
}

/// The name of a value: that of its object where it is the only one, in a sentence.
fn known_as(sheet: &DataSheet, index: u16, sub: u8) -> Option<String> {
    let object = sheet.object(index)?;
    let entry = object.entry(sub)?;
    let name = if object.entries.len() > 1 {
        &entry.name
    } else {
        &object.name
    };
    Some(in_a_sentence(name))
}

/// A name as it stands inside a sentence: "Profile velocity" with a small letter, "COB-ID used by SYNC" as it is.
fn in_a_sentence(name: &str) -> String {
    let mut letters = name.chars();
    match (letters.next(), letters.next()) {
        (Some(first), Some(second)) if second.is_lowercase() => {
            first.to_lowercase().chain(name.chars().skip(1)).collect()
        }
        _ => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_from_the_data_sheet() {
        let name = |index, sub| name(&DataSheet::axis402(), index, sub);
        assert_eq!(name(0x6083, 0), "6083h profile acceleration");
        assert!(name(0x1018, 4).starts_with("1018h:04 "));
        assert_eq!(name(0x5FFF, 0), "5FFFh");
        assert_eq!(name(0x5FFF, 7), "5FFFh:07");
    }

    #[test]
    fn values_are_shown_by_their_type() {
        let value = |index, sub, bytes: &[u8]| value(&DataSheet::axis402(), index, sub, bytes);
        assert_eq!(value(0x6064, 0, &(-5i32).to_le_bytes()), "-5");
        assert_eq!(value(0x6083, 0, &50_000u32.to_le_bytes()), "50000");
        assert_eq!(value(0x1000, 0, &0x0004_0192u32.to_le_bytes()), "00040192h");
        assert_eq!(value(0x6040, 0, &[0x06, 0x00]), "shutdown");
        assert_eq!(value(0x1008, 0, b"Axis402 drive"), "\"Axis402 drive\"");
        assert_eq!(value(0x2020, 0, &[0; 20]), "20 bytes");
        assert_eq!(value(0x6060, 0, &[0xFF]), "-1");
    }
}

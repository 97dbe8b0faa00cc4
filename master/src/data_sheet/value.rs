//! Values for people, by the types of the data sheet.

use od_gen::{DataType, transfer};

use super::{Address, DataSheet};
use crate::trace::{controlword, statusword};

/// Short names of types, as programmers write them.
const SHORT_NAMES: [(&str, DataType); 14] = [
    ("bool", DataType::Boolean),
    ("i8", DataType::Integer8),
    ("i16", DataType::Integer16),
    ("i32", DataType::Integer32),
    ("i64", DataType::Integer64),
    ("u8", DataType::Unsigned8),
    ("u16", DataType::Unsigned16),
    ("u32", DataType::Unsigned32),
    ("u64", DataType::Unsigned64),
    ("f32", DataType::Real32),
    ("f64", DataType::Real64),
    ("string", DataType::VisibleString),
    ("bytes", DataType::OctetString),
    ("domain", DataType::Domain),
];

/// The type that a person calls `u16`, `unsigned16` or `UNSIGNED16`.
///
/// # Errors
/// Which names there are.
pub fn data_type(name: &str) -> Result<DataType, String> {
    let short = SHORT_NAMES.iter().find(|(short, _)| *short == name);
    let long = || DataType::from_name(&name.to_ascii_uppercase());
    short
        .map(|(_, data_type)| *data_type)
        .or_else(long)
        .ok_or_else(|| {
            let names = SHORT_NAMES.map(|(short, _)| short);
            format!(
                "no type; there are {} and those of CiA 301",
                names.join(", ")
            )
        })
}

impl DataSheet {
    /// The type of a value, if it is known.
    pub fn data_type(&self, address: Address) -> Option<DataType> {
        let entry = self.entry(address.index, address.sub)?;
        Some(entry.data_type)
    }

    /// `Position actual value`, `Identity object: Serial number`; `None` for what is not in the data sheet.
    pub fn name(&self, address: Address) -> Option<String> {
        let object = self.object(address.index)?;
        let entry = object.entry(address.sub)?;
        Some(if object.object_type.has_subs() {
            format!("{}: {}", object.name, entry.name)
        } else {
            object.name.clone()
        })
    }
}

/// The text of bytes that were read, as they can be written again; what a controlword or a statusword says stands behind it.
/// Bytes that do not fit the type are shown as they are.
pub fn text(address: Address, bytes: &[u8], data_type: Option<DataType>) -> String {
    let known =
        data_type.and_then(|data_type| Some((data_type, transfer::value(bytes, data_type)?)));
    let word = |bytes: &[u8]| bytes.try_into().map(u16::from_le_bytes);
    match (known, address.index) {
        (Some((DataType::VisibleString, _)), _) => {
            let end = bytes
                .iter()
                .rposition(|byte| *byte != 0)
                .map_or(0, |last| last + 1);
            String::from_utf8_lossy(&bytes[..end]).into_owned()
        }
        (Some((DataType::Domain | DataType::OctetString, _)), _) | (None, _) => hexadecimal(bytes),
        (Some((data_type, value)), index) => {
            let text = transfer::text(&value, data_type);
            match (index, word(bytes)) {
                (0x6040, Ok(word)) => format!("0x{word:04X} ({})", controlword(word)),
                (0x6041, Ok(word)) => format!("0x{word:04X} ({})", statusword(word)),
                _ => text,
            }
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_short_and_long_names() {
        assert_eq!(data_type("u16"), Ok(DataType::Unsigned16));
        assert_eq!(data_type("integer24"), Ok(DataType::Integer24));
        assert_eq!(data_type("VISIBLE_STRING"), Ok(DataType::VisibleString));
        assert!(data_type("u128").is_err());
    }

    #[test]
    fn values_are_shown_by_their_type() {
        let show = |index, bytes: &[u8], data_type| text(Address::new(index, 0), bytes, data_type);
        let minus_five = (-5i32).to_le_bytes();
        assert_eq!(show(0x6064, &minus_five, Some(DataType::Integer32)), "-5");
        assert_eq!(
            show(0x1008, b"Axis402\0\0", Some(DataType::VisibleString)),
            "Axis402"
        );
        assert_eq!(show(0x2000, &[0x12, 0xAB], None), "12 AB");
        assert_eq!(show(0x6064, &[1, 2], Some(DataType::Integer32)), "01 02");
        let statusword = show(0x6041, &[0x37, 0x06], Some(DataType::Unsigned16));
        assert_eq!(statusword, "0x0637 (operation enabled, target reached)");
    }
}

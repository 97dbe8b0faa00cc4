//! Values between text and the bytes of a transfer, for tools that talk to a device.
//!
//! The text is that of a data sheet, so what a tool shows can be put into a DCF and back.
//!
//! ```
//! use od_gen::{DataType, transfer};
//!
//! let value = transfer::parse("-5", DataType::Integer16).unwrap();
//! assert_eq!(transfer::bytes(&value, DataType::Integer16, 4), [0xFB, 0xFF]);
//! assert_eq!(transfer::value(&[0xFB, 0xFF], DataType::Integer16), Some(value.clone()));
//! assert_eq!(transfer::text(&value, DataType::Integer16), "-5");
//! ```

use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::DefaultValue;
use crate::parse::value::Written;
use crate::source::Span;

/// Reads a value as a data sheet writes it: decimal, hexadecimal with `0x`, `$NODEID+0x180`, text, the bytes of an OCTET_STRING in
/// hexadecimal.
///
/// # Errors
/// Why it is no value of this type.
pub fn parse(text: &str, data_type: DataType) -> Result<DefaultValue, String> {
    let mut findings = Findings::new("");
    let written = Written {
        key: "the value",
        text,
        span: Span::START,
    };
    let value = crate::parse::value::value(written, data_type, &mut findings);
    value.ok_or_else(|| {
        let first = findings.into_sorted().into_iter().next();
        first.map_or_else(|| "it means nothing".into(), |finding| finding.message)
    })
}

/// A value as a data sheet writes it.
pub fn text(value: &DefaultValue, data_type: DataType) -> String {
    crate::print::value::value(value, data_type)
}

/// The bytes of a value as they travel, in a device with this node-ID.
pub fn bytes(value: &DefaultValue, data_type: DataType, node_id: u8) -> Vec<u8> {
    match value {
        DefaultValue::Number {
            value,
            adds_node_id,
        } => {
            let added = if *adds_node_id { node_id } else { 0 };
            let size = data_type.size().unwrap_or_default();
            let bytes = value.saturating_add(added.into()).to_le_bytes();
            bytes.into_iter().take(size.into()).collect()
        }
        DefaultValue::Real(value) if data_type == DataType::Real32 => {
            // The value has been rounded to a REAL32 when it was read.
            #[allow(clippy::cast_possible_truncation, reason = "nothing is lost")]
            let value = *value as f32;
            value.to_le_bytes().to_vec()
        }
        DefaultValue::Real(value) => value.to_le_bytes().to_vec(),
        DefaultValue::Text(bytes) => bytes.clone(),
    }
}

/// The value that came as these bytes; `None` if their number does not fit the type.
pub fn value(bytes: &[u8], data_type: DataType) -> Option<DefaultValue> {
    if data_type
        .size()
        .is_some_and(|size| usize::from(size) != bytes.len())
    {
        return None;
    }
    match data_type {
        DataType::Real32 => {
            let value = f32::from_le_bytes(bytes.try_into().ok()?);
            Some(DefaultValue::Real(value.into()))
        }
        DataType::Real64 => {
            let value = f64::from_le_bytes(bytes.try_into().ok()?);
            Some(DefaultValue::Real(value))
        }
        _ if data_type.range().is_some() => Some(DefaultValue::number(number(bytes, data_type))),
        _ => Some(DefaultValue::Text(bytes.to_vec())),
    }
}

/// At most eight bytes as a number, the low one first.
fn number(bytes: &[u8], data_type: DataType) -> i128 {
    let pattern =
        (bytes.iter().rev()).fold(0, |number: i128, byte| number << 8 | i128::from(*byte));
    match data_type.range() {
        Some((low, high)) if pattern > high => pattern + 2 * low,
        _ => pattern,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_every_type_come_back_from_text_and_from_bytes() {
        for (data_type, written) in [
            (DataType::Boolean, "1"),
            (DataType::Integer8, "-128"),
            (DataType::Integer24, "-2"),
            (DataType::Integer64, "-9223372036854775808"),
            (DataType::Unsigned8, "255"),
            (DataType::Unsigned32, "0xFFFFFFFF"),
            (DataType::Unsigned64, "0xFFFFFFFFFFFFFFFF"),
            (DataType::Real32, "1.5"),
            (DataType::Real64, "-0.1"),
            (DataType::VisibleString, "Axis 402"),
            (DataType::OctetString, "00 A5 FF"),
            (DataType::UnicodeString, "Grüße"),
            (DataType::TimeOfDay, "0x0102030405FF"),
        ] {
            let parsed = parse(written, data_type).unwrap();
            assert_eq!(text(&parsed, data_type), written, "{data_type:?}");
            let bytes = bytes(&parsed, data_type, 4);
            assert_eq!(value(&bytes, data_type), Some(parsed), "{data_type:?}");
        }
    }

    #[test]
    fn the_node_id_is_added_where_the_data_sheet_says_so() {
        let value = parse("$NODEID+0x180", DataType::Unsigned32).unwrap();
        assert_eq!(bytes(&value, DataType::Unsigned32, 4), [0x84, 1, 0, 0]);
    }

    #[test]
    fn what_does_not_fit_has_a_reason_or_no_value() {
        let refused = parse("256", DataType::Unsigned8).unwrap_err();
        assert_eq!(refused, "the value 256 does not fit UNSIGNED8 (0 to 255)");
        assert!(parse("much", DataType::Integer32).is_err());
        assert_eq!(value(&[1, 2, 3], DataType::Unsigned16), None);
    }
}

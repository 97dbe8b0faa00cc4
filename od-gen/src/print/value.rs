//! Values as text.

use crate::data_type::DataType;
use crate::model::{DefaultValue, Limit};

/// Numbers above this are written in hexadecimal, where they have no sign.
const LARGEST_DECIMAL: i128 = 0xFFFF;

/// A default, or what a DCF configures.
pub(crate) fn value(value: &DefaultValue, data_type: DataType) -> String {
    match value {
        DefaultValue::Number {
            value,
            adds_node_id: false,
        } => number(*value, data_type),
        DefaultValue::Number { value: 0, .. } => "$NODEID".into(),
        DefaultValue::Number { value, .. } => format!("$NODEID+0x{value:X}"),
        DefaultValue::Real(value) => real(*value, data_type),
        DefaultValue::Text(bytes) if data_type == DataType::OctetString => {
            let bytes = bytes.iter().map(|byte| format!("{byte:02X}"));
            bytes.collect::<Vec<_>>().join(" ")
        }
        DefaultValue::Text(bytes) if data_type == DataType::UnicodeString => {
            let units = bytes.chunks_exact(2).map(|pair| match pair {
                [low, high] => u16::from_le_bytes([*low, *high]),
                _ => 0,
            });
            char::decode_utf16(units)
                .map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect()
        }
        DefaultValue::Text(bytes) => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// LowLimit or HighLimit.
pub(crate) fn limit(limit: Limit, data_type: DataType) -> String {
    match limit {
        Limit::Integer(value) => number(value, data_type),
        Limit::NodeId(number) => value(
            &DefaultValue::Number {
                value: number,
                adds_node_id: true,
            },
            data_type,
        ),
        Limit::Real(value) => real(value, data_type),
    }
}

fn number(value: i128, data_type: DataType) -> String {
    if data_type.is_signed() || value <= LARGEST_DECIMAL {
        value.to_string()
    } else {
        let digits = 2 * usize::from(data_type.size().unwrap_or_default());
        format!("0x{value:0digits$X}")
    }
}

/// The shortest text that gives the same number again.
fn real(value: f64, data_type: DataType) -> String {
    if data_type == DataType::Real32 {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "it was rounded to a REAL32 when it was read"
        )]
        let value = value as f32;
        return format!("{value:?}");
    }
    format!("{value:?}")
}

//! Values as a reader of the reference wants them: numbers in decimal, and in hexadecimal where that helps.

use crate::data_type::DataType;
use crate::model::{DefaultValue, Entry};

/// The type, with the length of a string.
pub(super) fn data_type(entry: &Entry) -> String {
    let name = entry.data_type.name();
    match entry.data_type.size() {
        Some(_) => name.into(),
        None => format!("{name}, {} bytes", entry.size),
    }
}

/// The value at power-on.
pub(super) fn default(entry: &Entry) -> String {
    match &entry.default {
        DefaultValue::Number {
            value,
            adds_node_id,
        } => {
            let number = number(entry, *value);
            match (adds_node_id, value) {
                (false, _) => number,
                (true, 0) => "node-ID".into(),
                (true, _) => format!("{value:X}h + node-ID"),
            }
        }
        DefaultValue::Real(value) => value.to_string(),
        DefaultValue::Text(bytes) if bytes.is_empty() => "empty".into(),
        DefaultValue::Text(bytes) if entry.data_type == DataType::VisibleString => {
            format!("\"{}\"", String::from_utf8_lossy(bytes))
        }
        DefaultValue::Text(bytes) => {
            let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
            bytes.join(" ")
        }
    }
}

/// What can be written, or what the device can show.
pub(super) fn range(entry: &Entry) -> String {
    match (entry.low_limit, entry.high_limit, entry.data_type.range()) {
        (None, None, None) => String::new(),
        (None, None, Some(_)) => "all of the type".into(),
        (Some(low), Some(high), _) => format!("{low} to {high}"),
        (Some(low), None, Some((_, high))) => format!("{low} to {high}"),
        (None, Some(high), Some((low, _))) => format!("{low} to {high}"),
        (Some(low), None, None) => format!("from {low}"),
        (None, Some(high), None) => format!("to {high}"),
    }
}

/// In decimal; of what is a pattern rather than a quantity, in hexadecimal first.
fn number(entry: &Entry, value: i128) -> String {
    let is_wide = entry.data_type.size().is_some_and(|size| size >= 2);
    if entry.data_type.is_signed() || !is_wide || value < 0x100 {
        value.to_string()
    } else {
        format!("{value} ({value:X}h)")
    }
}

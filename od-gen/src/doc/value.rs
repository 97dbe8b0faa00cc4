//! Values as a reader of the reference wants them: numbers in decimal, and in hexadecimal where that helps.

use crate::data_type::DataType;
use crate::model::{DefaultValue, Entry};

/// The type, with the length of a string.
pub(super) fn data_type(entry: &Entry) -> String {
    let name = entry.data_type.name();
    match entry.data_type.size() {
        Some(_) => name.into(),
        None if entry.size == 0 => name.into(),
        None => format!("{name}, {} bytes", entry.size),
    }
}

/// The value at power-on, and in a DCF what it is configured to.
pub(super) fn default(index: u16, entry: &Entry) -> String {
    let default = entry.default.as_ref();
    let default = default.map_or_else(String::new, |value| text(index, entry, value));
    match &entry.configured {
        Some(configured) => {
            let configured = format!("configured to {}", text(index, entry, configured));
            if default.is_empty() {
                configured
            } else {
                format!("{default}, {configured}")
            }
        }
        None => default,
    }
}

fn text(index: u16, entry: &Entry, value: &DefaultValue) -> String {
    match value {
        DefaultValue::Number {
            value,
            adds_node_id,
        } => match (adds_node_id, value) {
            (false, _) if is_pattern(index, entry.sub) => format!("{value:08X}h"),
            (false, _) => number(entry, *value),
            (true, 0) => "node-ID".into(),
            (true, _) => format!("{value:X}h + node-ID"),
        },
        DefaultValue::Real(value) => real(entry.data_type, *value),
        DefaultValue::Text(_) if entry.data_type == DataType::Domain => String::new(),
        DefaultValue::Text(bytes) if bytes.is_empty() => "empty".into(),
        DefaultValue::Text(bytes) => match entry.data_type {
            DataType::VisibleString => format!("\"{}\"", String::from_utf8_lossy(bytes)),
            DataType::UnicodeString => format!("\"{}\"", utf_16(bytes)),
            _ => {
                let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
                bytes.join(" ")
            }
        },
    }
}

/// As short as it can be read back; with a power of ten where that is shorter.
fn real(data_type: DataType, value: f64) -> String {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a REAL32 was an f32 when it was read"
    )]
    let (plain, power) = match data_type {
        DataType::Real32 => ((value as f32).to_string(), format!("{:e}", value as f32)),
        _ => (value.to_string(), format!("{value:e}")),
    };
    if plain.len() > 12 && power.len() < plain.len() {
        power
    } else {
        plain
    }
}

/// Two bytes a letter, the low one first.
fn utf_16(bytes: &[u8]) -> String {
    let units = bytes
        .chunks_exact(2)
        .filter_map(|pair| pair.try_into().ok());
    let units: Vec<u16> = units.map(u16::from_le_bytes).collect();
    String::from_utf16_lossy(&units)
}

/// Whether a value of 32 bits is made of parts: a type, an identifier, a mapping.
fn is_pattern(index: u16, sub: u8) -> bool {
    match index {
        0x1000 | 0x1002 | 0x1005 | 0x1012 | 0x1014 => true,
        0x1003 | 0x1010 | 0x1011 | 0x1016 | 0x1018 | 0x1028 => sub != 0,
        0x1200..=0x12FF => matches!(sub, 1 | 2),
        0x1400..=0x15FF | 0x1800..=0x19FF => sub == 1,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => sub != 0,
        0x1F80 | 0x6502 => true,
        _ => false,
    }
}

/// What can be written, or what the device can show.
pub(super) fn range(entry: &Entry) -> String {
    match (entry.low_limit, entry.high_limit, entry.data_type.range()) {
        (None, None, None) => String::new(),
        (None, None, Some(_)) => "any".into(),
        (Some(low), Some(high), _) => format!("{low} to {high}"),
        (Some(low), None, Some((_, high))) => format!("{low} to {high}"),
        (None, Some(high), Some((low, _))) => format!("{low} to {high}"),
        (Some(low), None, None) => format!("from {low}"),
        (None, Some(high), None) => format!("to {high}"),
    }
}

/// In decimal; in hexadecimal too, where that may be what is meant.
fn number(entry: &Entry, value: i128) -> String {
    let is_wide = entry.data_type.size().is_some_and(|size| size >= 2);
    if entry.data_type.is_signed() || !is_wide || value < 0x100 {
        value.to_string()
    } else {
        format!("{value} ({value:X}h)")
    }
}

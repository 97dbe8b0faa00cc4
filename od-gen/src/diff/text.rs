//! Objects and values in few words.

use crate::data_type::DataType;
use crate::model::{DefaultValue, Entry, Limit, Object};

/// An object that only one file has.
pub(super) fn object(object: &Object) -> String {
    let kind = object.object_type.name();
    match object.entries.as_slice() {
        [only] if !object.object_type.has_subs() => {
            format!("{}: {kind} {}", object.name, value(only))
        }
        entries => format!("{}: {kind}, {} values", object.name, entries.len()),
    }
}

/// A value that only one file has.
pub(super) fn entry(entry: &Entry) -> String {
    format!("{}: {}", entry.name, value(entry))
}

fn value(entry: &Entry) -> String {
    let (data_type, access) = (entry.data_type.name(), entry.access.name());
    match &entry.default {
        Some(value) => format!("{data_type} {access} = {}", default(value, entry.data_type)),
        None => format!("{data_type} {access}"),
    }
}

/// A default, as a data sheet could have it.
pub(super) fn default(value: &DefaultValue, data_type: DataType) -> String {
    match value {
        DefaultValue::Number {
            value,
            adds_node_id,
        } => {
            if *adds_node_id && *value == 0 {
                return "$NODEID".into();
            }
            let is_pattern = !data_type.is_signed() && *value > 0xFF;
            match (adds_node_id, is_pattern) {
                (true, _) => format!("$NODEID+0x{value:X}"),
                (false, true) => format!("{value} (0x{value:X})"),
                (false, false) => value.to_string(),
            }
        }
        DefaultValue::Real(value) => value.to_string(),
        DefaultValue::Text(bytes) if data_type == DataType::VisibleString => {
            String::from_utf8_lossy(bytes).into_owned()
        }
        DefaultValue::Text(bytes) => {
            let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
            bytes.join(" ")
        }
    }
}

/// A limit; empty where there is none.
pub(super) fn limit(limit: Option<Limit>) -> String {
    limit.map_or_else(String::new, |limit| limit.to_string())
}

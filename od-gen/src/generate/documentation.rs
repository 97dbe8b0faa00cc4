//! What is said about a value in the comments of generated code.

use super::layout::Row;
use super::names;
use crate::model::{Access, DefaultValue};

/// Which value this is: `1018h:4, Identity object: Serial number`.
pub(super) fn title(row: &Row<'_>) -> String {
    let index = row.object.index;
    let object = names::documentation(&row.object.name);
    if row.object.object_type.has_subs() {
        let value = names::documentation(&row.entry.name);
        format!("{index:04X}h:{}, {object}: {value}", row.entry.sub)
    } else {
        format!("{index:04X}h, {object}")
    }
}

/// What else the data sheet says: access, unit, limits and default.
pub(super) fn facts(row: &Row<'_>) -> String {
    facts_with(row, names::documentation)
}

/// The same as a plain text for users of the device, the maker's own words (`;Description=`) first.
pub(super) fn description(row: &Row<'_>) -> String {
    let facts = facts_with(row, str::to_owned);
    match row.entry.note("Description") {
        Some(words) => format!("{words} ({facts})"),
        None => facts,
    }
}

fn facts_with(row: &Row<'_>, unit_as: impl Fn(&str) -> String) -> String {
    let entry = row.entry;
    let mut facts = vec![format!(
        "{} {}",
        entry.access.name(),
        entry.data_type.name()
    )];
    if let Some(unit) = entry.unit() {
        facts.push(format!("in {}", unit_as(unit)));
    }
    match (entry.low_limit, entry.high_limit) {
        (Some(low), Some(high)) => facts.push(format!("{low} to {high}")),
        (Some(low), None) => facts.push(format!("{low} or more")),
        (None, Some(high)) => facts.push(format!("at most {high}")),
        (None, None) => {}
    }
    if entry.data_type.size().is_none() && entry.access != Access::Constant && entry.size > 0 {
        facts.push(format!("up to {} bytes", entry.size));
    }
    if let Some(default) = default(&entry.initial()) {
        facts.push(format!("{default} at power-on"));
    }
    facts.join(", ")
}

fn default(value: &DefaultValue) -> Option<String> {
    match value {
        DefaultValue::Number {
            value: 0,
            adds_node_id: true,
        } => Some("the node-ID".into()),
        DefaultValue::Number {
            value,
            adds_node_id: true,
        } => Some(format!("{value:X}h + node-ID")),
        DefaultValue::Number {
            value,
            adds_node_id: false,
        } => Some(value.to_string()),
        DefaultValue::Real(value) => Some(value.to_string()),
        DefaultValue::Text(_) => None,
    }
}

//! Rules: what a device is configured to is what it can be written with (CiA 306, device configuration files).

use super::{Rule, Subject};
use crate::diagnostic::Findings;
use crate::model::{DefaultValue, Entry, Field, FileKind, Limit};
use crate::source::Span;

/// Of a configured device.
pub(crate) const RULES: &[&Rule] = &[&CONFIGURED_READ_ONLY, &CONFIGURED_OUTSIDE_LIMITS];

/// Of a file of values that a configuration is made from.
pub(crate) const OF_VALUES: &[&Rule] = &[&VALUE_LINE, &VALUE_OF_NOTHING, &VALUE_TWICE];

static CONFIGURED_READ_ONLY: Rule = Rule::masters(
    "configured-read-only",
    "Only what can be written is configured.",
    "A configuration tool writes every ParameterValue into the device, which refuses what is ro or const with 06010002h.",
).strict();

static CONFIGURED_OUTSIDE_LIMITS: Rule = Rule::error(
    "configured-outside-limits",
    "What is configured lies between the limits, and a string is not too long.",
    "A configuration tool writes every ParameterValue into the device, which refuses it with 06090031h, 06090032h or 06070012h.",
);

pub(crate) static VALUE_LINE: Rule = Rule::error(
    "value-line",
    "A line of values is INDEX=VALUE or INDEX:SUB=VALUE.",
    "Index and sub-index are hexadecimal, with or without 0x: `6081=1000`, `1800:5=100`. Lines that begin with `;` or `#` are \
     comments. When this is silenced, the line does not count.",
);

pub(crate) static VALUE_OF_NOTHING: Rule = Rule::error(
    "value-of-nothing",
    "What is configured exists.",
    "The data sheet has no such object, or the object no such sub-index. When this is silenced, the line does not count.",
);

pub(crate) static VALUE_TWICE: Rule = Rule::warning(
    "value-twice",
    "What is configured has one value.",
    "The last one counts.",
);

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    // In every other file the values mean nothing, which has been reported.
    if model.kind != FileKind::Dcf {
        return;
    }
    let node_id = model.commissioning.as_ref().map(|node| node.node_id);
    for (object, entry) in model.entries() {
        if let Some(value) = &entry.configured {
            let place = format!("{:04X}h:{:X}", object.index, entry.sub);
            let span = entry.places.of(Field::ParameterValue);
            check_value(&place, entry, value, node_id, span, findings);
        }
    }
}

/// Whether a value can be written into an entry, or is to be all the same; reports why it cannot.
pub(crate) fn check_value(
    place: &str,
    entry: &Entry,
    value: &DefaultValue,
    node_id: Option<u8>,
    span: Span,
    findings: &mut Findings,
) -> bool {
    if !entry.access.is_writable() {
        let message = format!(
            "{place} is {}: it cannot be configured",
            entry.access.name()
        );
        findings.report(&CONFIGURED_READ_ONLY, span, message);
        return findings.allowed(&CONFIGURED_READ_ONLY, span, ()).is_some();
    }
    let value = match value {
        DefaultValue::Number {
            value,
            adds_node_id,
        } => {
            let added = node_id.filter(|_| *adds_node_id).unwrap_or(0);
            Limit::Integer(value.saturating_add(added.into()))
        }
        DefaultValue::Real(value) => Limit::Real(*value),
        DefaultValue::Text(bytes) => {
            let has_room = bytes.len() <= usize::from(entry.size);
            if !has_room {
                let message = format!(
                    "{place} has room for {} bytes, not for {}",
                    entry.size,
                    bytes.len()
                );
                findings.report(&CONFIGURED_OUTSIDE_LIMITS, span, message);
            }
            let allowed = findings.allowed(&CONFIGURED_OUTSIDE_LIMITS, span, ());
            return has_room || allowed.is_some();
        }
    };
    let of_node = |limit: Option<Limit>| match node_id {
        Some(node_id) => limit.map(|limit| limit.of_node(node_id)),
        None => limit,
    };
    let outside = match (of_node(entry.low_limit), of_node(entry.high_limit)) {
        (Some(low), _) if value < low => format!("below LowLimit {low}"),
        (_, Some(high)) if value > high => format!("above HighLimit {high}"),
        _ => return true,
    };
    let message = format!("{place} is {value}, {outside}");
    findings.report(&CONFIGURED_OUTSIDE_LIMITS, span, message);
    findings
        .allowed(&CONFIGURED_OUTSIDE_LIMITS, span, ())
        .is_some()
}

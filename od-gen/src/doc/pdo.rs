//! The PDOs as they are after a reset of the communication: identifier, transmission, and where each object lies in the frame.

use super::view;
use crate::model::{DefaultValue, Model};

/// Bits of a frame.
const FRAME_BITS: u32 = 64;
/// The PDO is switched off (CiA 301, tables 68 and 71).
const INVALID: i128 = 1 << 31;
/// The identifier of a base frame.
const IDENTIFIER: i128 = 0x7FF;

/// A PDO.
pub(super) struct Pdo {
    pub(super) name: String,
    /// Identifier, transmission type and times.
    pub(super) settings: String,
    pub(super) is_valid: bool,
    pub(super) fields: Vec<Field>,
    /// Bits behind the last field.
    pub(super) free_bits: u32,
}

/// An object in a PDO.
pub(super) struct Field {
    pub(super) address: String,
    /// Where the object is on the page; a gap is nowhere.
    pub(super) anchor: Option<String>,
    pub(super) name: String,
    pub(super) bits: u32,
    /// Which bytes or bits it takes.
    pub(super) place: String,
}

/// All PDOs, receiving ones first.
pub(super) fn defaults(model: &Model) -> Vec<Pdo> {
    let mut pdos = Vec::new();
    for object in &model.objects {
        let (name, first, to_mapping) = match object.index {
            0x1400..=0x15FF => ("RPDO", 0x1400, 0x200),
            0x1800..=0x19FF => ("TPDO", 0x1800, 0x200),
            _ => continue,
        };
        let fields = fields(model, object.index + to_mapping);
        let used: u32 = fields.iter().map(|field| field.bits).sum();
        pdos.push(Pdo {
            name: format!("{name} {}", object.index - first + 1),
            settings: settings(model, object.index),
            is_valid: number(model, object.index, 1).is_some_and(|cob_id| cob_id & INVALID == 0),
            fields,
            free_bits: FRAME_BITS.saturating_sub(used),
        });
    }
    pdos
}

fn number(model: &Model, index: u16, sub: u8) -> Option<i128> {
    model.entry(index, sub)?.default_number()
}

fn settings(model: &Model, index: u16) -> String {
    let mut settings = Vec::new();
    if let Some(DefaultValue::Number {
        value,
        adds_node_id,
    }) = model
        .entry(index, 1)
        .and_then(|entry| entry.default.as_ref())
    {
        let node_id = if *adds_node_id { " + node-ID" } else { "" };
        let off = if value & INVALID == 0 { "" } else { ", off" };
        settings.push(format!("COB-ID {:03X}h{node_id}{off}", value & IDENTIFIER));
    }
    if let Some(kind) = number(model, index, 2) {
        settings.push(format!("type {kind} ({})", transmission(kind, index)));
    }
    let times = [(3, "inhibit time", 100, "µs"), (5, "event timer", 1, "ms")];
    for (sub, name, factor, unit) in times {
        if let Some(time) = number(model, index, sub).filter(|time| *time != 0) {
            settings.push(format!("{name} {} {unit}", time * factor));
        }
    }
    settings.join(", ")
}

/// The transmission types (CiA 301, tables 69 and 72).
fn transmission(kind: i128, index: u16) -> String {
    match kind {
        0 if index < 0x1800 => "by SYNC".into(),
        0 => "by SYNC, after a change".into(),
        1 => "by every SYNC".into(),
        2..=240 if index >= 0x1800 => format!("by every {kind}th SYNC"),
        2..=240 => "by SYNC".into(),
        252 => "by SYNC, on request".into(),
        253 => "on request".into(),
        254 => "by event, the manufacturer's".into(),
        255 => "by event, the profile's".into(),
        _ => "reserved".into(),
    }
}

/// The mapped objects, each behind the one before.
fn fields(model: &Model, mapping: u16) -> Vec<Field> {
    let count = number(model, mapping, 0).unwrap_or(0);
    let count = u8::try_from(count).unwrap_or(0).min(64);
    let mut start = 0;
    let mut fields = Vec::new();
    for sub in 1..=count {
        let value = number(model, mapping, sub).and_then(|value| u32::try_from(value).ok());
        let [high, low, sub, bits] = value.unwrap_or(0).to_be_bytes();
        let index = u16::from_be_bytes([high, low]);
        let bits = u32::from(bits);
        fields.push(Field {
            address: address(model, index, sub),
            anchor: model.object(index).map(|_| view::anchor(index)),
            name: name(model, index, sub),
            bits,
            place: place(start, bits),
        });
        start += bits;
    }
    fields
}

fn address(model: &Model, index: u16, sub: u8) -> String {
    let is_alone = model
        .object(index)
        .is_some_and(|object| object.entries.len() == 1);
    match sub {
        0 if is_alone => format!("{index:04X}h"),
        _ => format!("{index:04X}h:{sub:X}"),
    }
}

fn name(model: &Model, index: u16, sub: u8) -> String {
    match (model.object(index), model.entry(index, sub)) {
        (Some(object), Some(entry)) if object.name == entry.name => object.name.clone(),
        (Some(object), Some(entry)) => format!("{} {}", object.name, entry.name),
        _ => "gap".into(),
    }
}

/// Bytes are counted from 0, as in a frame.
fn place(start: u32, bits: u32) -> String {
    let end = (start + bits).saturating_sub(1);
    if !start.is_multiple_of(8) || !bits.is_multiple_of(8) {
        return match bits {
            1 => format!("bit {start}"),
            _ => format!("bits {start} to {end}"),
        };
    }
    match (start / 8, end / 8) {
        (first, last) if first == last => format!("byte {first}"),
        (first, last) => format!("bytes {first} to {last}"),
    }
}

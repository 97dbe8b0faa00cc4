//! Objects as a description names them, and what they are set to.

use crate::bind;
use crate::data_type::DataType;
use crate::generate::snake_case;
use crate::model::{DefaultValue, Entry, Model};
use crate::spelling;

/// An object in a PDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mapped {
    pub(super) index: u16,
    pub(super) sub: u8,
    pub(super) bits: u8,
    pub(super) name: String,
    pub(super) data_type: DataType,
}

impl Mapped {
    /// As the mapping parameter has it.
    pub(super) fn value(&self) -> u32 {
        u32::from(self.index) << 16 | u32::from(self.sub) << 8 | u32::from(self.bits)
    }

    /// Whether it only makes a gap.
    pub(super) fn is_gap(&self) -> bool {
        self.index < 0x1000
    }

    /// What a mapping parameter names; `None` where it is in no data sheet.
    pub(super) fn of_value(model: &Model, value: u32) -> Option<Self> {
        let [bits, sub, low, high] = value.to_le_bytes();
        let index = u16::from_le_bytes([low, high]);
        if let Some(data_type) = DataType::from_code(index.into()).filter(|_| index < 0x1000) {
            return Some(Self::gap(data_type, bits));
        }
        let entry = model.entry(index, sub)?;
        let name = name(model, index, entry);
        let data_type = entry.data_type;
        Some(Self {
            index,
            sub,
            bits,
            name,
            data_type,
        })
    }

    fn gap(data_type: DataType, bits: u8) -> Self {
        Self {
            index: data_type.code(),
            sub: 0,
            bits,
            name: data_type.name().into(),
            data_type,
        }
    }

    /// What a description names: a value, or the type of a gap.
    pub(super) fn find(model: &Model, text: &str) -> Result<Self, (String, Option<String>)> {
        if let Some(data_type) = DataType::from_name(text) {
            let bits = bits(data_type).ok_or((format!("{text} has no length"), None))?;
            return Ok(Self::gap(data_type, bits));
        }
        let (index, sub) = find(model, text).ok_or_else(|| {
            let names = names(model);
            let names = names.iter().map(|(name, _)| name.as_str());
            let near = spelling::nearest(text, names);
            let help = near.map(|near| format!("did you mean `{near}`?"));
            (format!("the data sheet has no `{text}`"), help)
        })?;
        let Some(entry) = model.entry(index, sub) else {
            return Err((format!("the data sheet has no {index:04X}h:{sub:X}"), None));
        };
        let bits = bits(entry.data_type).ok_or_else(|| {
            let message = format!("{text} is a {}: no PDO", entry.data_type.name());
            (message + " carries it", None)
        })?;
        let name = name(model, index, entry);
        let data_type = entry.data_type;
        Ok(Self {
            index,
            sub,
            bits,
            name,
            data_type,
        })
    }
}

/// Bits in a PDO: a BOOLEAN takes one (CiA 301, 7.1.4.2).
fn bits(data_type: DataType) -> Option<u8> {
    match data_type {
        DataType::Boolean => Some(1),
        _ => u8::try_from(data_type.size()? * 8).ok(),
    }
}

fn name(model: &Model, index: u16, entry: &Entry) -> String {
    match model.object(index) {
        Some(object) if object.object_type.has_subs() => {
            format!("{} {}", object.name, entry.name)
        }
        _ => entry.name.clone(),
    }
}

/// Index and sub-index of a value, by its name or by its number.
pub(super) fn find(model: &Model, text: &str) -> Option<(u16, u8)> {
    let wanted = text.to_ascii_lowercase();
    let (object, sub) = wanted.split_once('.').unwrap_or((&wanted, ""));
    for candidate in &model.objects {
        if snake_case(&candidate.name) != object {
            continue;
        }
        let has_subs = candidate.object_type.has_subs();
        let mut entries = candidate.entries.iter();
        let entry = entries.find(|entry| match has_subs {
            true => snake_case(&entry.name) == sub,
            false => sub.is_empty(),
        });
        if let Some(entry) = entry {
            return Some((candidate.index, entry.sub));
        }
    }
    bind::entry(text)
}

/// All names by which values can be called.
fn names(model: &Model) -> Vec<(String, (u16, u8))> {
    let names = model.entries().map(|(object, entry)| {
        let mut name = snake_case(&object.name);
        if object.object_type.has_subs() {
            name = format!("{name}.{}", snake_case(&entry.name));
        }
        (name, (object.index, entry.sub))
    });
    names.collect()
}

/// What a number is set to in the device with this node-ID, 0 where nothing is said; `None` of what is no number.
pub(super) fn number(model: &Model, index: u16, sub: u8, node_id: u8) -> Option<u32> {
    let entry = model.entry(index, sub)?;
    entry.data_type.range()?;
    match entry.configured.as_ref().or(entry.default.as_ref()) {
        None => Some(0),
        Some(DefaultValue::Number {
            value,
            adds_node_id,
        }) => {
            let added = if *adds_node_id { node_id } else { 0 };
            u32::try_from(value.saturating_add(added.into())).ok()
        }
        Some(DefaultValue::Real(_) | DefaultValue::Text(_)) => None,
    }
}

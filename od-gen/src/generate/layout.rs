//! Where each value lies.

use super::names;
use crate::model::{Access, DefaultValue, Entry, Model, Object, ObjectType};

/// Every value with its place, and the blocks of bytes they lie in.
#[derive(Debug)]
pub(super) struct Layout<'a> {
    /// In ascending order of index and sub-index.
    pub(super) rows: Vec<Row<'a>>,
    /// The block in flash.
    pub(super) rom: Vec<u8>,
    /// The block in RAM at power-on.
    pub(super) defaults: Vec<u8>,
    /// Limits, each pair once.
    pub(super) limits: Vec<(i64, i64)>,
}

/// One value.
#[derive(Debug)]
pub(super) struct Row<'a> {
    pub(super) object: &'a Object,
    pub(super) entry: &'a Entry,
    /// The name of its getter.
    pub(super) name: String,
    pub(super) place: Place,
    /// Which of the limits.
    pub(super) limits: Option<usize>,
}

/// A place in one of the blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Ram(usize),
    Rom(usize),
}

impl<'a> Layout<'a> {
    pub(super) fn new(model: &'a Model) -> Self {
        let mut layout = Self {
            rows: Vec::new(),
            rom: Vec::new(),
            defaults: Vec::new(),
            limits: Vec::new(),
        };
        let names = names::getters(model);
        let entries = model
            .objects
            .iter()
            .flat_map(|object| object.entries.iter().map(move |entry| (object, entry)));
        for ((object, entry), name) in entries.zip(names) {
            let place = if is_constant(object, entry) {
                layout.place_in_rom(entry)
            } else {
                layout.place_in_ram(entry)
            };
            let limits = layout.limits_of(entry);
            layout.rows.push(Row {
                object,
                entry,
                name,
                place,
                limits,
            });
        }
        layout
    }

    /// The row of an entry.
    pub(super) fn row(&self, index: u16, sub: u8) -> Option<&Row<'a>> {
        self.rows
            .iter()
            .find(|row| row.object.index == index && row.entry.sub == sub)
    }

    fn place_in_rom(&mut self, entry: &Entry) -> Place {
        let bytes = default_bytes(entry);
        // Equal bytes need to be there only once: most sub-indices 0 are small numbers.
        let known = self
            .rom
            .windows(bytes.len().max(1))
            .position(|window| window == bytes);
        Place::Rom(known.unwrap_or_else(|| {
            let offset = self.rom.len();
            self.rom.extend(&bytes);
            offset
        }))
    }

    fn place_in_ram(&mut self, entry: &Entry) -> Place {
        let offset = self.defaults.len();
        let bytes = default_bytes(entry);
        let size = usize::from(entry.size);
        if matches!(entry.default, DefaultValue::Text(_)) {
            // A string is preceded by its present length.
            let length = u16::try_from(bytes.len()).unwrap_or(entry.size);
            self.defaults.extend(length.to_le_bytes());
        }
        self.defaults
            .extend(bytes.iter().copied().chain(std::iter::repeat(0)).take(size));
        Place::Ram(offset)
    }

    fn limits_of(&mut self, entry: &Entry) -> Option<usize> {
        if entry.low_limit.is_none() && entry.high_limit.is_none() {
            return None;
        }
        let (low, high) = entry.data_type.range()?;
        // Of all types only UNSIGNED64 has a larger range; there the largest number stands for no limit.
        let own = |limit: i128| i64::try_from(limit).unwrap_or(i64::MAX);
        let limits = (
            entry.low_limit.unwrap_or(own(low)),
            entry.high_limit.unwrap_or(own(high)),
        );
        let known = self.limits.iter().position(|other| *other == limits);
        Some(known.unwrap_or_else(|| {
            self.limits.push(limits);
            self.limits.len() - 1
        }))
    }
}

/// Whether a value can lie in flash: `const` objects, strings nobody can write, and the sub-index 0 of a record or an array whose
/// entries are fixed (that of 1003h counts errors). Other `ro` objects are the device's to change.
fn is_constant(object: &Object, entry: &Entry) -> bool {
    if matches!(
        entry.default,
        DefaultValue::Number {
            adds_node_id: true,
            ..
        }
    ) {
        return false;
    }
    let is_text = matches!(entry.default, DefaultValue::Text(_));
    let counts_entries =
        object.object_type != ObjectType::Var && entry.sub == 0 && object.index != 0x1003;
    match entry.access {
        Access::Constant => true,
        Access::ReadOnly => is_text || counts_entries,
        _ => false,
    }
}

/// The default as it travels on the bus.
fn default_bytes(entry: &Entry) -> Vec<u8> {
    match &entry.default {
        DefaultValue::Number { value, .. } => value
            .to_le_bytes()
            .into_iter()
            .take(usize::from(entry.size))
            .collect(),
        DefaultValue::Text(bytes) => bytes.clone(),
    }
}

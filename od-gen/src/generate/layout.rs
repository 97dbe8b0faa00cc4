//! Where each value lies.
//!
//! In RAM the values of each storage group lie side by side, then those that are not stored; within a group they are in the order
//! of their indices. What the application serves piece by piece takes no room at all.

use std::collections::HashMap;
use std::ops::Range;

use super::names;
use crate::data_type::DataType;
use crate::model::{Access, DefaultValue, Entry, Limit, Model, Object, StorageGroup};
use crate::parse::LARGEST_VALUE;
use crate::transfer;

/// The storage groups in the order of `canopen::od::StorageGroup`.
const GROUPS: [StorageGroup; 3] = [
    StorageGroup::Communication,
    StorageGroup::Application,
    StorageGroup::Manufacturer,
];

/// Every value with its place, and the blocks of bytes they lie in.
#[derive(Debug)]
pub(super) struct Layout<'a> {
    /// In ascending order of index and sub-index.
    pub(super) rows: Vec<Row<'a>>,
    /// The block in flash.
    pub(super) rom: Vec<u8>,
    /// The block in RAM at power-on.
    pub(super) defaults: Vec<u8>,
    /// Limits: the lowest number and the highest one, each as it travels; equal pairs once.
    pub(super) limits: Vec<u8>,
    /// Where each storage group lies in RAM.
    pub(super) storage: [Range<usize>; 3],
    /// Where byte sequences stand in the block in flash, so that none need be there twice.
    known: HashMap<Vec<u8>, usize>,
    /// Where each pair of limits stands, by its bytes.
    pairs: HashMap<Vec<u8>, usize>,
}

/// One value.
#[derive(Debug)]
pub(super) struct Row<'a> {
    pub(super) object: &'a Object,
    pub(super) entry: &'a Entry,
    /// The name of its getter.
    pub(super) name: String,
    pub(super) place: Place,
    /// Where its limits are; an even number.
    pub(super) limits: Option<usize>,
    /// The group that stores it.
    pub(super) storage: Option<StorageGroup>,
}

/// A place in one of the blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Ram(usize),
    Rom(usize),
    /// With the application.
    Application,
}

impl<'a> Layout<'a> {
    pub(super) fn new(model: &'a Model) -> Self {
        let mut layout = Self {
            rows: Vec::new(),
            rom: Vec::new(),
            defaults: Vec::new(),
            limits: Vec::new(),
            storage: [0..0, 0..0, 0..0],
            known: HashMap::new(),
            pairs: HashMap::new(),
        };
        let names = names::getters(model);
        let entries = model
            .objects
            .iter()
            .flat_map(|object| object.entries.iter().map(move |entry| (object, entry)));
        for ((object, entry), name) in entries.zip(names) {
            let (place, storage) = if is_constant(object, entry) && !entry.is_with_application {
                (layout.place_in_rom(entry), None)
            } else if is_streamed(entry) {
                (Place::Application, None)
            } else {
                // The offset is given below, when the groups are known.
                (Place::Ram(0), entry.storage)
            };
            let limits = layout.limits_of(entry);
            layout.rows.push(Row {
                object,
                entry,
                name,
                place,
                limits,
                storage,
            });
        }
        layout.fill_ram();
        layout
    }

    /// How many buckets the look-up has (`canopen::od::buckets`): at least an eighth more than there are objects. Most are found in the
    /// first one that is looked into, and an entry takes some 12 bytes.
    pub(super) fn buckets(&self) -> usize {
        let objects = self.rows.chunk_by(|a, b| a.object.index == b.object.index);
        (objects.count() * 9).div_ceil(8).next_power_of_two().max(2)
    }

    /// Gives every value in RAM its place: the storage groups, then the rest.
    fn fill_ram(&mut self) {
        let mut rows = std::mem::take(&mut self.rows);
        for (range, group) in (0..).zip(GROUPS.map(Some).into_iter().chain([None])) {
            let start = self.defaults.len();
            for row in &mut rows {
                if matches!(row.place, Place::Ram(_)) && row.storage == group {
                    row.place = self.place_in_ram(row.entry);
                }
            }
            if let Some(storage) = self.storage.get_mut(range) {
                *storage = start..self.defaults.len();
            }
        }
        self.rows = rows;
    }

    /// The row of an entry.
    pub(super) fn row(&self, index: u16, sub: u8) -> Option<&Row<'a>> {
        let key = |row: &Row<'_>| (row.object.index, row.entry.sub);
        let position = self.rows.binary_search_by_key(&(index, sub), key).ok()?;
        self.rows.get(position)
    }

    /// Bytes of the longest value in RAM: an SDO server keeps one whole while it travels in segments.
    pub(super) fn longest_in_ram(&self) -> u16 {
        let in_ram = |row: &&Row<'_>| matches!(row.place, Place::Ram(_));
        let sizes = self.rows.iter().filter(in_ram).map(|row| row.entry.size);
        sizes.max().unwrap_or(0)
    }

    fn place_in_rom(&mut self, entry: &Entry) -> Place {
        let bytes = default_bytes(entry);
        // Equal bytes need to be there only once: most sub-indices 0 are small numbers.
        if let Some(offset) = self.known.get(&bytes) {
            return Place::Rom(*offset);
        }
        let offset = self.rom.len();
        self.rom.extend(&bytes);
        // Numbers are looked for everywhere, also within others and across them; strings as a whole.
        for length in [1, 2, 4, 8] {
            let start = (offset + 1).saturating_sub(length);
            let tail = self.rom.get(start..).unwrap_or_default();
            for (at, window) in (start..).zip(tail.windows(length)) {
                self.known.entry(window.to_vec()).or_insert(at);
            }
        }
        self.known.entry(bytes).or_insert(offset);
        Place::Rom(offset)
    }

    fn place_in_ram(&mut self, entry: &Entry) -> Place {
        let offset = self.defaults.len();
        let bytes = default_bytes(entry);
        let size = usize::from(entry.size);
        if entry.data_type.size().is_none() {
            // A string is preceded by its present length.
            let length = u16::try_from(bytes.len()).unwrap_or(entry.size);
            self.defaults.extend(length.to_le_bytes());
        }
        self.defaults
            .extend(bytes.iter().copied().chain(std::iter::repeat(0)).take(size));
        Place::Ram(offset)
    }

    fn limits_of(&mut self, entry: &Entry) -> Option<usize> {
        let pair = limits(entry)?;
        let list = &mut self.limits;
        Some(*self.pairs.entry(pair).or_insert_with_key(|pair| {
            let at = list.len();
            list.extend(pair);
            at
        }))
    }
}

/// The lowest and the highest number as they travel; `None` where there are no limits beside the type's own.
fn limits(entry: &Entry) -> Option<Vec<u8>> {
    let (low, high) = if entry.data_type.is_real() {
        real_limits(entry)?
    } else {
        let (low_limit, high_limit) = entry.integer_limits();
        if low_limit.is_none() && high_limit.is_none() {
            return None;
        }
        let (low, high) = entry.data_type.range()?;
        let (low, high) = (low_limit.unwrap_or(low), high_limit.unwrap_or(high));
        (DefaultValue::number(low), DefaultValue::number(high))
    };
    let bytes = |limit| transfer::bytes(&limit, entry.data_type, 0);
    Some([bytes(low), bytes(high)].concat())
}

/// Those of a REAL.
fn real_limits(entry: &Entry) -> Option<(DefaultValue, DefaultValue)> {
    if entry.low_limit.is_none() && entry.high_limit.is_none() {
        return None;
    }
    let number = |limit: Option<Limit>, none: f64| match limit {
        Some(Limit::Real(value)) => value,
        Some(Limit::Integer(_) | Limit::NodeId(_)) | None => none,
    };
    let low = number(entry.low_limit, f64::NEG_INFINITY);
    let high = number(entry.high_limit, f64::INFINITY);
    // Both zeros are the same number: the lower one is the low limit, the higher one the high limit.
    let low = if low == 0.0 { -0.0 } else { low };
    let high = if high == 0.0 { 0.0 } else { high };
    Some((DefaultValue::Real(low), DefaultValue::Real(high)))
}

/// Whether a value can lie in flash: `const` objects, strings nobody can write, and the sub-index 0 of a record or an array whose
/// entries are fixed (that of 1003h counts errors). Other `ro` objects are the device's to change.
fn is_constant(object: &Object, entry: &Entry) -> bool {
    if entry.adds_node_id() {
        return false;
    }
    let is_text = entry.data_type.is_text();
    let counts_entries = object.object_type.has_subs() && entry.sub == 0 && object.index != 0x1003;
    match entry.access {
        _ if entry.data_type == DataType::Domain => false,
        Access::Constant => true,
        Access::ReadOnly => is_text || counts_entries,
        _ => false,
    }
}

/// Whether the application has a value: a DOMAIN, a string that can be written and is longer than what the firmware takes in before
/// it checks, and what the data sheet gives to it.
fn is_streamed(entry: &Entry) -> bool {
    let is_long = entry.data_type.is_text() && entry.size > LARGEST_VALUE;
    entry.data_type == DataType::Domain || is_long || entry.is_with_application
}

/// The default as it travels on the bus; the firmware adds the node-ID itself.
fn default_bytes(entry: &Entry) -> Vec<u8> {
    transfer::bytes(&entry.initial(), entry.data_type, 0)
}

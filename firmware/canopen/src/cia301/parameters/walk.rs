//! Which entries a set has, in which order, and the records they make.
//!
//! A record is index (2 bytes), sub-index (1), length (1) and value, all little-endian. It never crosses the end of a chunk.
//! Length 0 of a number stands for the default of the data sheet with the node-ID that the device has then.

use super::{CHUNK, ParameterSet, VERIFY_CONFIGURATION};
use crate::copy::copy;
use crate::od::{self, Attributes, Dictionary, Entry, StorageGroup, Table};

/// Bytes of a record before its value.
const HEADER: usize = 4;

/// Most bytes of a value that can be stored. `od-gen` lets no stored object be longer.
const MOST_VALUE: usize = CHUNK - HEADER;

/// Objects that depend on others, and so come last: a SYNC counter may only change while no SYNC is produced (1006h is 0), and
/// a producer (1005h bit 30) needs its period.
const LAST: [u16; 2] = [0x1006, 0x1005];

/// The record of a PDO that the entries of both of its records are stored with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Communication parameter.
    Communication,
    /// Mapping parameter; the communication parameter has this index.
    Mapping(u16),
    /// Not of a PDO.
    Elsewhere,
}

/// Distance between the communication parameter of a PDO and its mapping parameter.
pub(super) const MAPPING: u16 = 0x200;

/// Where an object stands.
pub(super) const fn place(index: u16) -> Place {
    match index {
        0x1400..=0x15FF | 0x1800..=0x19FF => Place::Communication,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => Place::Mapping(index.wrapping_sub(MAPPING)),
        _ => Place::Elsewhere,
    }
}

/// The set that an entry is stored in; `None` for what is not stored.
pub(crate) fn set_of(entry: &Entry) -> Option<ParameterSet> {
    let group = entry.storage_group()?;
    if entry.attributes.has(Attributes::STREAMED) || entry.attributes.has(Attributes::ROM) {
        return None;
    }
    Some(match group {
        _ if entry.index == VERIFY_CONFIGURATION => ParameterSet::ConfigurationDate,
        StorageGroup::Communication => ParameterSet::Communication,
        StorageGroup::Application => ParameterSet::Application,
        StorageGroup::Manufacturer => ParameterSet::Manufacturer,
    })
}

/// A walk over the entries of one set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walk {
    pub(crate) set: ParameterSet,
    /// Position in the table; beyond its end, position in [`LAST`].
    position: usize,
    /// Entries of the PDO at this position that are done.
    step: usize,
}

impl Walk {
    /// At the first entry.
    pub(crate) const fn new(set: ParameterSet) -> Self {
        Self {
            set,
            position: 0,
            step: 0,
        }
    }

    /// Fills a chunk with records and returns its length; 0 at the end of the set.
    pub(crate) fn fill<D: Dictionary>(
        &mut self,
        dictionary: &D,
        node_id: u8,
        chunk: &mut [u8; CHUNK],
    ) -> usize {
        let mut length = 0;
        loop {
            let here = *self;
            let Some(entry) = self.next(D::TABLE) else {
                return length;
            };
            let value = od::value(dictionary, entry);
            let follows = !D::HABITS.stored_identifiers_stay
                && od::is_node_id_default(dictionary, entry, node_id);
            let value = if follows { &[] } else { value };
            let size = value.len().saturating_add(HEADER);
            let Some(record) = chunk.get_mut(length..length.saturating_add(size)) else {
                if size <= CHUNK {
                    // It goes first in the next chunk.
                    *self = here;
                    return length;
                }
                continue;
            };
            let Some((header, room)) = record.split_first_chunk_mut::<HEADER>() else {
                continue;
            };
            let [low, high] = entry.index.to_le_bytes();
            // A value that fits is shorter than 256 bytes.
            let count = u8::try_from(value.len()).unwrap_or(0);
            *header = [low, high, entry.sub, count];
            copy(room, value);
            length = length.saturating_add(size);
        }
    }

    /// The next entry of the set.
    fn next(&mut self, table: &Table) -> Option<&'static Entry> {
        loop {
            let entry = self.advance(table)?;
            if entry.is_some_and(|entry| set_of(entry) == Some(self.set)) {
                return entry;
            }
        }
    }

    /// One step on: `None` at the end, `Some(None)` at an entry that has another turn.
    fn advance(&mut self, table: &Table) -> Option<Option<&'static Entry>> {
        let Some(entry) = table.entries.get(self.position) else {
            let index = *LAST.get(self.position.checked_sub(table.entries.len())?)?;
            self.position = self.position.saturating_add(1);
            return Some(table.find(index, 0).ok());
        };
        match place(entry.index) {
            Place::Communication => match pdo_entry(table, entry.index, self.step) {
                Some(entry) => {
                    self.step = self.step.saturating_add(1);
                    return Some(Some(entry));
                }
                None => {
                    self.step = 0;
                    let record = table.range(entry.index..=entry.index).len();
                    self.position = self.position.saturating_add(record.max(1));
                    return Some(None);
                }
            },
            Place::Mapping(_) => self.position = self.position.saturating_add(1),
            Place::Elsewhere => {
                self.position = self.position.saturating_add(1);
                if !LAST.contains(&entry.index) {
                    return Some(Some(entry));
                }
            }
        }
        Some(None)
    }
}

/// Entry number `step` of a PDO, both of its records in the order of CiA 301: times and type, what is mapped, how many, and
/// the COB-ID that switches it on.
fn pdo_entry(table: &Table, communication: u16, step: usize) -> Option<&'static Entry> {
    let mapping = communication.saturating_add(MAPPING);
    let communication = table.range(communication..=communication).iter();
    let mapping = table.range(mapping..=mapping).iter();
    let times = communication.clone().filter(|entry| entry.sub > 1);
    let objects = mapping.clone().filter(|entry| entry.sub > 0);
    let count = mapping.filter(|entry| entry.sub == 0);
    let cob_id = communication.filter(|entry| entry.sub == 1);
    times.chain(objects).chain(count).chain(cob_id).nth(step)
}

/// The records of a chunk: index, sub-index, value. It ends where the bytes make no record.
pub(super) struct Records<'a>(pub(super) &'a [u8]);

impl<'a> Iterator for Records<'a> {
    type Item = (u16, u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let (&[low, high, sub, length], rest) = self.0.split_first_chunk()?;
        let (value, rest) = rest.split_at_checked(usize::from(length))?;
        self.0 = rest;
        Some((u16::from_le_bytes([low, high]), sub, value))
    }
}

const _: () = assert!(MOST_VALUE < 256, "a length takes one byte");

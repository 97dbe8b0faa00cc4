//! The object dictionary: a table of descriptors in flash over one block of bytes in RAM.
//!
//! `od-gen` writes a type that implements [`Dictionary`] from an electronic data sheet. Every value is kept as it
//! travels on the bus, little-endian, at a fixed offset: an SDO answer and a PDO are copies of bytes, and saving
//! parameters is a walk over ranges. What cannot change lies in flash ([`Table::rom`]); RAM holds the rest. The
//! generated type adds a typed getter and setter for each object, so code never meets an offset.
//!
//! Layout of a value: numbers take the bytes of their type. A string that can be written takes a `u16` with its present
//! length and then [`Entry::size`] bytes; a string that cannot be written lies in flash, as many bytes, no prefix. The values
//! of each storage group lie side by side. A DOMAIN, and what is too long for RAM, lies with the application.

mod access;
mod buckets;
mod counts;
mod entry;
mod features;
mod fixed;
mod format;
mod habits;
mod typed;

use core::ops::Range;

pub use crate::slots::{Slots, Unused};
pub use access::{
    AccessError, check, constant, find, is_node_id_default, load_defaults, node_id_default, number,
    put, read_u8, read_u16, read_u32, set, value, write_u8, write_u16, write_u32,
};
pub(crate) use access::{number_at, put_here, raw, raw_of};
pub use buckets::buckets;
pub use counts::{Count, Counts};
pub use entry::{Access, Attributes, DataType, Entry, Location, StorageGroup, key};
pub use features::Features;
pub(crate) use fixed::{fixed, place};
pub use habits::{ErrorMapping, Habits};
pub use typed::{
    DayTime, OutOfRange, Value, bytes_at, give, put_at, signed, signed_bytes, unsigned,
    unsigned_bytes,
};

/// What `od-gen` puts in flash for one dictionary.
#[derive(Debug)]
pub struct Table {
    /// One descriptor for each sub-index, in ascending order of [`Entry::key`].
    pub entries: &'static [Entry],
    /// Where the entries of each object begin, by its index: [`buckets`] of the entries.
    pub buckets: &'static [u16],
    /// Values that never change (const and ro objects nobody updates).
    pub rom: &'static [u8],
    /// The power-on image of the RAM block, node-ID not yet added to entries with [`Attributes::NODE_ID`].
    pub defaults: &'static [u8],
    /// Limits that entries refer to by their place: the lowest and the highest number, each as it travels on the bus. Entries share them.
    pub limits: &'static [u8],
    /// The part of the RAM block that holds each storage group, in the order of [`StorageGroup`]; [`Table::stored`] gives it.
    pub storage: [Range<u16>; 3],
}

impl Table {
    /// The storage groups of a dictionary that stores nothing.
    pub const NO_STORAGE: [Range<u16>; 3] = [0..0, 0..0, 0..0];

    /// The part of the RAM block that holds a storage group: its values lie side by side, and nothing else is among them.
    /// Empty for a range outside of the block.
    pub fn stored(&self, group: StorageGroup) -> Range<usize> {
        let [communication, application, manufacturer] = &self.storage;
        let range = match group {
            StorageGroup::Communication => communication,
            StorageGroup::Application => application,
            StorageGroup::Manufacturer => manufacturer,
        };
        let range = usize::from(range.start)..usize::from(range.end);
        if self.defaults.get(range.clone()).is_some() {
            range
        } else {
            0..0
        }
    }
}

/// An object dictionary: the generated table, and the block of RAM that belongs to it.
pub trait Dictionary {
    /// Descriptors, constants, defaults and limits, in flash.
    const TABLE: &'static Table;

    /// What the device has of all that this crate can do.
    const FEATURES: Features = Features::of(Self::TABLE);

    /// What the device does in the way of its maker.
    const HABITS: Habits = Habits::STANDARD;

    /// How many of each service the device has: [`Count`].
    type Counts: Counts;

    /// The values that can change.
    fn ram(&self) -> &[u8];

    /// The values that can change, writable.
    fn ram_mut(&mut self) -> &mut [u8];
}

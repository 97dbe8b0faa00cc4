//! What a device has of all that this crate can do, known when it is compiled.
//!
//! A service whose object the data sheet does not list is never used: the object does not exist ([`super::AccessError`]), and
//! its power-on behaviour is "off". So its code is left out, and costs no flash. Nothing changes on the bus.

use core::ops::RangeInclusive;

use super::{Attributes, Entry, Table};

/// The services of a device: what is `false` is not compiled into it.
///
/// [`Features::of`] finds them in the dictionary. `od-gen` adds what no object tells: `LSS_Supported` and `[DummyUsage]` of the data
/// sheet, and whether the firmware wants block transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Features {
    /// SYNC, 1005h.
    pub sync: bool,
    /// TIME, 1012h.
    pub time: bool,
    /// Node guarding and life guarding, 100Ch and 100Dh. Without them remote frames of error control are not answered.
    pub guarding: bool,
    /// Store and restore parameters, 1010h and 1011h.
    pub parameters: bool,
    /// Verify configuration, 1020h.
    pub configuration_date: bool,
    /// The emergency consumer, 1028h.
    pub emergency_consumer: bool,
    /// Multiplexed PDOs: scanner and dispatcher lists (1FA0h to 1FFFh), or a mapping record whose sub-index 0 may be 254 or 255.
    pub multiplexed_pdo: bool,
    /// Objects that the application serves piece by piece.
    pub streams: bool,
    /// Layer setting services (CiA 305). A device without them hears nothing at 7E5h.
    pub lss: bool,
    /// SDO block transfer. A server without it answers 05040001h, command specifier not valid, as CiA 301 (7.2.4.3.8) leaves it
    /// optional.
    pub block_transfer: bool,
    /// Data types that may be gaps in a receive PDO (dummy mapping): a bit for each, by its index.
    pub dummies: u32,
}

impl Features {
    /// A device with everything.
    pub const ALL: Self = Self {
        sync: true,
        time: true,
        guarding: true,
        parameters: true,
        configuration_date: true,
        emergency_consumer: true,
        multiplexed_pdo: true,
        streams: true,
        lss: true,
        block_transfer: true,
        dummies: u32::MAX,
    };

    /// What a dictionary lists, and everything that no object tells.
    pub const fn of(table: &Table) -> Self {
        Self {
            sync: table.has(0x1005..=0x1005),
            time: table.has(0x1012..=0x1012),
            guarding: table.has(0x100C..=0x100D),
            parameters: table.has(0x1010..=0x1011),
            configuration_date: table.has(0x1020..=0x1020),
            emergency_consumer: table.has(0x1028..=0x1028),
            multiplexed_pdo: table.has(0x1FA0..=0x1FFF) || table.has_multiplexed_mapping(),
            streams: table.has_streams(),
            ..Self::ALL
        }
    }
}

/// The lowest sub-index 0 of a mapping record that makes the PDO a multiplexed one.
const MULTIPLEXED: u8 = 254;

impl Table {
    /// Whether there is an object with an index in this range.
    const fn has(&self, indices: RangeInclusive<u16>) -> bool {
        let mut entries = self.entries;
        while let [entry, rest @ ..] = entries {
            if entry.index >= *indices.start() && entry.index <= *indices.end() {
                return true;
            }
            entries = rest;
        }
        false
    }

    /// Whether the application serves an object piece by piece.
    const fn has_streams(&self) -> bool {
        let mut entries = self.entries;
        while let [entry, rest @ ..] = entries {
            if entry.attributes.has(Attributes::STREAMED) {
                return true;
            }
            entries = rest;
        }
        false
    }

    /// Whether sub-index 0 of a mapping record may be 254 or 255.
    const fn has_multiplexed_mapping(&self) -> bool {
        let mut entries = self.entries;
        while let [entry, rest @ ..] = entries {
            let is_mapping = matches!(entry.index, 0x1600..=0x17FF | 0x1A00..=0x1BFF);
            if is_mapping && entry.sub == 0 && self.may_be_multiplexed(entry) {
                return true;
            }
            entries = rest;
        }
        false
    }

    const fn may_be_multiplexed(&self, entry: &Entry) -> bool {
        let is_constant = entry.attributes.has(Attributes::ROM);
        let defaults = if is_constant { self.rom } else { self.defaults };
        let default = match defaults.split_at_checked(entry.offset as usize) {
            Some((_, [default, ..])) => *default,
            _ => 0,
        };
        if default >= MULTIPLEXED {
            return true;
        }
        // An UNSIGNED8: its limits are two bytes.
        let highest = match entry.limits() {
            Some(at) => match self.limits.split_at_checked(at) {
                Some((_, [_, high, ..])) => *high,
                _ => u8::MAX,
            },
            None => u8::MAX,
        };
        !is_constant && highest >= MULTIPLEXED
    }
}

#[cfg(test)]
mod tests;

//! Loading: the stored records are written as a master would write them.

use core::ops::RangeInclusive;

use super::walk::{MAPPING, Place, Records, place, set_of};
use crate::cia301::cob_ids::{self, Rule};
use crate::cia301::sdo::AbortCode;
use crate::od::{self, Attributes, Dictionary, Entry};

/// The dictionary with the rules of its owners.
pub(crate) trait Writer {
    /// The dictionary.
    type Dictionary: Dictionary;

    /// The values.
    fn dictionary(&mut self) -> &mut Self::Dictionary;

    /// Writes a value as an SDO request would, whatever the access rights of the object.
    fn write(&mut self, entry: &'static Entry, value: &[u8]) -> Result<(), AbortCode>;
}

/// What could not be loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Refused {
    /// How many records.
    pub(crate) count: u16,
    /// Index of the first one.
    pub(crate) index: u16,
    /// Its sub-index.
    pub(crate) sub: u8,
}

impl Refused {
    pub(crate) const NOTHING: Self = Self {
        count: 0,
        index: 0,
        sub: 0,
    };

    fn add(&mut self, index: u16, sub: u8) {
        if self.count == 0 {
            self.index = index;
            self.sub = sub;
        }
        self.count = self.count.saturating_add(1);
    }

    /// Together with what was refused after it.
    pub(crate) fn and(self, later: Self) -> Self {
        let first = if self.count == 0 { later } else { self };
        Self {
            count: self.count.saturating_add(later.count),
            ..first
        }
    }
}

/// The PDO that is being loaded.
#[derive(Clone, Copy, Debug)]
struct Pdo {
    /// Index of its communication parameter.
    communication: u16,
    /// Nothing was refused.
    is_good: bool,
    /// Its COB-ID is loaded, or is not among what is stored.
    is_complete: bool,
}

/// Index of the communication cycle period, which must be 0 while 1019h changes.
const CYCLE_PERIOD: u16 = 0x1006;
const SYNC_COUNTER: u16 = 0x1019;
/// Index of the heartbeat consumers: no node-ID may stand there twice.
const HEARTBEAT_CONSUMERS: u16 = 0x1016;

/// Writes records, and keeps count of those that no longer fit.
#[derive(Debug)]
pub(crate) struct Replay {
    node_id: u8,
    /// Only these objects are loaded.
    indices: RangeInclusive<u16>,
    pdo: Option<Pdo>,
    /// Communication objects that were refused.
    refused: Refused,
    /// Objects of the other groups that were refused.
    refused_elsewhere: Refused,
}

impl Replay {
    pub(crate) const fn new(node_id: u8, indices: RangeInclusive<u16>) -> Self {
        Self {
            node_id,
            indices,
            pdo: None,
            refused: Refused::NOTHING,
            refused_elsewhere: Refused::NOTHING,
        }
    }

    /// Writes the records of a chunk.
    pub(crate) fn chunk<W: Writer>(&mut self, chunk: &[u8], writer: &mut W) {
        for (index, sub, value) in Records(chunk) {
            if !self.indices.contains(&index) {
                continue;
            }
            let result = self.record(index, sub, value, writer);
            if result.is_err() {
                self.refuse(index, sub);
            }
        }
    }

    /// Ends the loading: what was refused of the communication objects, and of the others.
    pub(crate) fn end<W: Writer>(mut self, writer: &mut W) -> (Refused, Refused) {
        self.end_pdo(writer);
        self.switch_off_taken(writer);
        (self.refused, self.refused_elsewhere)
    }

    #[inline(never)]
    fn refuse(&mut self, index: u16, sub: u8) {
        if is_communication(index) {
            self.refused.add(index, sub);
        } else {
            self.refused_elsewhere.add(index, sub);
        }
    }

    fn record<W: Writer>(
        &mut self,
        index: u16,
        sub: u8,
        value: &[u8],
        writer: &mut W,
    ) -> Result<(), AbortCode> {
        let pdo = match place(index) {
            Place::Communication => Some(index),
            Place::Mapping(communication) => Some(communication),
            Place::Elsewhere => None,
        };
        if self.pdo.map(|pdo| pdo.communication) != pdo {
            self.end_pdo(writer);
            self.pdo = pdo.map(|communication| begin_pdo(communication, writer));
        }
        let result = match &self.pdo {
            Some(pdo) if !pdo.is_good => Err(AbortCode::ParameterIncompatible),
            _ => write(index, sub, value, self.node_id, writer),
        };
        if let Some(pdo) = &mut self.pdo {
            pdo.is_good &= result.is_ok();
            pdo.is_complete |= index == pdo.communication && sub == 1;
        }
        result
    }

    /// What was stored may not fit what was not, or what follows another node-ID: a transmit PDO makes way.
    fn switch_off_taken<W: Writer>(&mut self, writer: &mut W) {
        for entry in W::Dictionary::TABLE.range(0x1800..=0x19FF) {
            let present = number(writer, entry).to_le_bytes();
            if cob_ids::is_taken(writer.dictionary(), entry, &present) {
                let off = u32::from_le_bytes(present) | 1 << 31;
                let _ = writer.write(entry, &off.to_le_bytes());
                self.refuse(entry.index, entry.sub);
            }
        }
    }

    /// A PDO that did not come whole gets the values of the data sheet.
    fn end_pdo<W: Writer>(&mut self, writer: &mut W) {
        if let Some(pdo) = self.pdo.take()
            && !(pdo.is_good && pdo.is_complete)
        {
            if pdo.is_good {
                self.refuse(pdo.communication, 1);
            }
            let mapping = pdo.communication.saturating_add(MAPPING);
            for index in [pdo.communication, mapping] {
                od::load_defaults(writer.dictionary(), self.node_id, index..=index);
            }
        }
    }
}

/// Switches a PDO off and empties its mapping, so that it can be changed.
fn begin_pdo<W: Writer>(communication: u16, writer: &mut W) -> Pdo {
    let stored = |index, sub| {
        od::find::<W::Dictionary>(index, sub)
            .ok()
            .filter(|entry| set_of(entry).is_some())
    };
    let cob_id = stored(communication, 1);
    if let Some(entry) = cob_id {
        let off = number(writer, entry) | 1 << 31;
        // Whether it worked shows when its records are written.
        let _ = writer.write(entry, &off.to_le_bytes());
    }
    if let Some(count) = stored(communication.saturating_add(MAPPING), 0) {
        let _ = writer.write(count, &[0]);
    }
    Pdo {
        communication,
        is_good: true,
        is_complete: cob_id.is_none(),
    }
}

/// Whether an object is loaded at a reset of the communication as well.
const fn is_communication(index: u16) -> bool {
    index >> 12 == 1
}

/// Writes one record.
fn write<W: Writer>(
    index: u16,
    sub: u8,
    value: &[u8],
    node_id: u8,
    writer: &mut W,
) -> Result<(), AbortCode> {
    let entry = od::find::<W::Dictionary>(index, sub)?;
    if set_of(entry).is_none() {
        return Err(AbortCode::UnsupportedAccess);
    }
    let default = od::node_id_default::<W::Dictionary>(entry, node_id);
    let value = if value.is_empty() && !entry.is_variable() {
        if !entry.attributes.has(Attributes::NODE_ID) {
            return Err(AbortCode::LengthMismatch);
        }
        default.get(..usize::from(entry.size())).unwrap_or(&[])
    } else {
        value
    };
    if entry.index == HEARTBEAT_CONSUMERS && sub == 1 {
        // Before anything else, and even if the first one is as it is stored: the others may change places.
        for consumer in W::Dictionary::TABLE.range(HEARTBEAT_CONSUMERS..=HEARTBEAT_CONSUMERS) {
            if consumer.sub > 0 {
                let _ = writer.write(consumer, &[0; 4]);
            }
        }
    }
    if od::value(writer.dictionary(), entry) == value {
        return Ok(());
    }
    if let Some(rule) = Rule::of(entry) {
        let present = number(writer, entry);
        let off = rule.switched_off(present);
        writer.write(entry, &off.to_le_bytes())?;
        return writer.write(entry, value).inspect_err(|_| {
            let _ = writer.write(entry, &present.to_le_bytes());
        });
    }
    match entry.index {
        SYNC_COUNTER => write_sync_counter(entry, value, writer),
        _ => writer.write(entry, value),
    }
}

/// 1019h may change while 1006h is 0.
fn write_sync_counter<W: Writer>(
    entry: &'static Entry,
    value: &[u8],
    writer: &mut W,
) -> Result<(), AbortCode> {
    let Ok(period) = od::find::<W::Dictionary>(CYCLE_PERIOD, 0) else {
        return writer.write(entry, value);
    };
    let present = number(writer, period);
    if present == 0 {
        return writer.write(entry, value);
    }
    writer.write(period, &[0; 4])?;
    let result = writer.write(entry, value);
    writer.write(period, &present.to_le_bytes())?;
    result
}

/// The present value of an UNSIGNED32.
fn number<W: Writer>(writer: &mut W, entry: &Entry) -> u32 {
    let value = od::value(writer.dictionary(), entry);
    value.try_into().map_or(0, u32::from_le_bytes)
}

//! Mapping parameters (1600h to 17FFh, 1A00h to 1BFFh): from the numbers that a master writes to entries of the dictionary.
//!
//! One mapping entry is an UNSIGNED32: index (bits 16 to 31), sub-index (bits 8 to 15), length in bits (bits 0 to 7).
//! The indices 0001h to 001Bh are data types; in a receive PDO they stand for bytes that are skipped (dummy mapping).

use heapless::Vec;

use crate::cia301::sdo::AbortCode;
use crate::od::{Attributes, DataType, Entry, Location, Table};

/// Most objects in one PDO: eight bytes, one each.
pub(super) const MOST_OBJECTS: usize = 8;

/// Most bytes in one PDO.
pub(super) const MOST_BYTES: u8 = 8;

/// Which way a PDO goes, seen from the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// From the bus into the dictionary.
    Receive,
    /// From the dictionary to the bus.
    Transmit,
}

/// One mapping entry as a master writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MappingEntry(pub(super) u32);

impl MappingEntry {
    /// Nothing mapped. It may be written (masters download whole records) but not counted by sub-index 0.
    pub(super) const EMPTY: Self = Self(0);

    fn index(self) -> u16 {
        let [_, _, low, high] = self.0.to_le_bytes();
        u16::from_le_bytes([low, high])
    }

    fn sub(self) -> u8 {
        let [_, sub, _, _] = self.0.to_le_bytes();
        sub
    }

    fn bits(self) -> u8 {
        let [bits, _, _, _] = self.0.to_le_bytes();
        bits
    }

    /// What the bytes of this mapping entry are.
    ///
    /// # Errors
    /// - [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`]: there is no such object.
    /// - [`AbortCode::NotMappable`]: the data sheet does not allow it, its access forbids this direction, its length is
    ///   another one, it is a communication object in a receive PDO, or a dummy in a transmit PDO.
    pub(super) fn resolve(self, table: &Table, direction: Direction) -> Result<Target, AbortCode> {
        if let Some(bytes) = dummy_bytes(self.index()) {
            let is_dummy = direction == Direction::Receive
                && self.sub() == 0
                && u16::from(self.bits()) == u16::from(bytes) * 8;
            return if is_dummy {
                Ok(Target::Dummy(bytes))
            } else {
                Err(AbortCode::NotMappable)
            };
        }
        let entry = table.find(self.index(), self.sub())?;
        let allowed = match direction {
            // The rules of communication objects are kept by SDO only.
            Direction::Receive => {
                entry.attributes.has(Attributes::RPDO | Attributes::WRITE)
                    && matches!(entry.location(), Location::Ram(_))
                    && !(0x1000..=0x1FFF).contains(&entry.index)
            }
            Direction::Transmit => entry.attributes.has(Attributes::TPDO | Attributes::READ),
        };
        let whole =
            !entry.data_type.is_variable() && u32::from(entry.size) * 8 == u32::from(self.bits());
        if allowed && whole {
            Ok(Target::Object(entry))
        } else {
            Err(AbortCode::NotMappable)
        }
    }
}

/// What a mapping entry stands for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    /// An object of the dictionary.
    Object(&'static Entry),
    /// So many bytes that are skipped.
    Dummy(u8),
}

/// The length of a dummy, by its index. Granularity is a byte, so BOOLEAN takes one.
fn dummy_bytes(index: u16) -> Option<u8> {
    const INDICES: [(DataType, u8); 9] = [
        (DataType::Boolean, 1),
        (DataType::Integer8, 1),
        (DataType::Integer16, 2),
        (DataType::Integer32, 4),
        (DataType::Unsigned8, 1),
        (DataType::Unsigned16, 2),
        (DataType::Unsigned32, 4),
        (DataType::Integer64, 8),
        (DataType::Unsigned64, 8),
    ];
    INDICES
        .iter()
        .find(|(data_type, _)| *data_type as u16 == index)
        .map(|(_, bytes)| *bytes)
}

/// An object with its place in the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct MappedObject {
    pub(super) entry: &'static Entry,
    /// Its first byte in the frame.
    pub(super) position: u8,
    /// Whether its type allows bytes that its limits do not.
    pub(super) is_limited: bool,
}

impl MappedObject {
    /// Its bytes in a frame.
    pub(super) fn value(self, frame: &[u8; 8]) -> &[u8] {
        let start = usize::from(self.position);
        let end = start.saturating_add(usize::from(self.entry.size));
        // A mapping fits into a frame.
        frame.get(start..end).unwrap_or(&[])
    }
}

/// A resolved mapping: its objects in order, dummies left out.
#[derive(Clone, Debug)]
pub(super) struct Mapping {
    pub(super) objects: Vec<MappedObject, MOST_OBJECTS>,
    /// Bytes of the frame, dummies included; 0 when nothing is mapped.
    pub(super) length: u8,
}

impl Mapping {
    /// Nothing mapped.
    pub(super) const fn new() -> Self {
        Self {
            objects: Vec::new(),
            length: 0,
        }
    }

    /// Puts one more target behind those that are there.
    ///
    /// # Errors
    /// [`AbortCode::PdoLengthExceeded`]: more than 64 bits.
    pub(super) fn push(&mut self, target: Target) -> Result<(), AbortCode> {
        let bytes = match target {
            Target::Object(entry) => {
                u8::try_from(entry.size).map_err(|_| AbortCode::PdoLengthExceeded)?
            }
            Target::Dummy(bytes) => bytes,
        };
        let length = self.length.saturating_add(bytes);
        if length > MOST_BYTES {
            return Err(AbortCode::PdoLengthExceeded);
        }
        if let Target::Object(entry) = target {
            let object = MappedObject {
                entry,
                position: self.length,
                is_limited: entry.limits != Entry::NO_LIMITS
                    || entry.data_type == DataType::Boolean,
            };
            self.objects
                .push(object)
                .map_err(|_| AbortCode::PdoLengthExceeded)?;
        }
        self.length = length;
        Ok(())
    }
}

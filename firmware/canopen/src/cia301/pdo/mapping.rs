//! Mapping parameters (1600h to 17FFh, 1A00h to 1BFFh): from the numbers that a master writes to entries of the dictionary.
//!
//! One mapping entry is an UNSIGNED32: index (bits 16 to 31), sub-index (bits 8 to 15), length in bits (bits 0 to 7).
//! The indices 0001h to 001Bh are data types; in a receive PDO they stand for bits that are skipped (dummy mapping).
//!
//! Objects follow each other without a gap, the first in the lowest bit of the first byte. The length of an object is its own;
//! a BOOLEAN has one bit, or eight as in the dictionary. Of an unsigned number the low bits may be mapped, if they are no
//! whole bytes: whole bytes are the length of another type, and so a mistake.

use super::multiplexed::Addressing;
use crate::cia301::sdo::AbortCode;
use crate::od::{Attributes, DataType, Entry, Location, Table};

/// Most bits in one PDO.
pub(super) const MOST_BITS: u8 = 64;

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

    /// What the bits of this mapping entry are.
    ///
    /// # Errors
    /// - [`AbortCode::NoObject`], [`AbortCode::NoSubIndex`]: there is no such object.
    /// - [`AbortCode::NotMappable`]: the data sheet does not allow it, its access forbids this direction, its length is
    ///   another one, it is a communication object in a receive PDO, or a dummy that is none of `dummies`
    ///   ([`Features::dummies`](crate::od::Features::dummies)) or in a transmit PDO.
    pub(super) fn resolve(
        self,
        table: &Table,
        dummies: u32,
        direction: Direction,
    ) -> Result<Target, AbortCode> {
        if let Some((data_type, bytes)) = dummy(self.index()) {
            let is_dummy = direction == Direction::Receive
                && dummies >> (self.index() % 32) & 1 != 0
                && self.sub() == 0
                && is_whole(data_type, u16::from(bytes), self.bits());
            return if is_dummy {
                Ok(Target::Dummy(self.bits()))
            } else {
                Err(AbortCode::NotMappable)
            };
        }
        let position = table.position(self.index(), self.sub())?;
        let entry = table.entries.get(position).ok_or(AbortCode::NoObject)?;
        let has_length = is_whole(entry.data_type, entry.size(), self.bits())
            || is_part(entry.data_type, entry.size(), self.bits());
        match u16::try_from(position) {
            Ok(position) if has_length && is_mappable(entry, direction) => Ok(Target::Object {
                position,
                entry,
                bits: self.bits(),
            }),
            _ => Err(AbortCode::NotMappable),
        }
    }
}

/// Whether the data sheet and the access of an object allow this direction.
pub(super) fn is_mappable(entry: &Entry, direction: Direction) -> bool {
    let is_here = !entry.is_variable() && !entry.attributes.has(Attributes::STREAMED);
    let is_allowed = match direction {
        // The rules of communication objects are kept by SDO only.
        Direction::Receive => {
            entry.attributes.has(Attributes::RPDO | Attributes::WRITE)
                && matches!(entry.location(), Location::Ram(_))
                && !(0x1000..=0x1FFF).contains(&entry.index)
        }
        Direction::Transmit => entry.attributes.has(Attributes::TPDO | Attributes::READ),
    };
    is_here && is_allowed
}

/// Whether so many bits are the whole of a type with `size` bytes.
fn is_whole(data_type: DataType, size: u16, bits: u8) -> bool {
    let is_bit = data_type == DataType::Boolean && bits == 1;
    is_bit || u32::from(size) * 8 == u32::from(bits)
}

/// Whether so many bits are a low part of a type with `size` bytes that may be mapped.
fn is_part(data_type: DataType, size: u16, bits: u8) -> bool {
    let is_unsigned = matches!(
        data_type,
        DataType::Unsigned8
            | DataType::Unsigned16
            | DataType::Unsigned24
            | DataType::Unsigned32
            | DataType::Unsigned40
            | DataType::Unsigned48
            | DataType::Unsigned56
            | DataType::Unsigned64
    );
    is_unsigned && !bits.is_multiple_of(8) && u32::from(bits) < u32::from(size) * 8
}

/// What a mapping entry stands for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    /// An object of the dictionary.
    Object {
        /// The position of its entry in the table.
        position: u16,
        /// The entry.
        entry: &'static Entry,
        /// Bits in the frame.
        bits: u8,
    },
    /// So many bits that are skipped.
    Dummy(u8),
}

impl Target {
    /// Bits in the frame.
    pub(super) const fn bits(&self) -> u8 {
        match *self {
            Self::Object { bits, .. } | Self::Dummy(bits) => bits,
        }
    }
}

/// A mapping in the making: targets are put one behind the other.
pub(super) trait Layout: Sized {
    /// Nothing mapped.
    const NOTHING: Self;

    /// A mapping without objects: the frame names its object.
    fn addressed(addressing: Addressing) -> Self;

    /// Puts one more target behind those that are there.
    ///
    /// # Errors
    /// [`AbortCode::PdoLengthExceeded`]: more than 64 bits, or more objects than the data sheet has room for.
    fn push(&mut self, target: Target) -> Result<(), AbortCode>;
}

/// The bits of a mapping that has `bits` of them with one more target.
pub(super) fn with_target(bits: u8, target: &Target) -> Result<u8, AbortCode> {
    match bits.checked_add(target.bits()) {
        Some(bits) if bits <= MOST_BITS => Ok(bits),
        _ => Err(AbortCode::PdoLengthExceeded),
    }
}

/// Type and bytes of a dummy, by its index: every number has one.
fn dummy(index: u16) -> Option<(DataType, u8)> {
    const DUMMIES: [(DataType, u8); 19] = [
        (DataType::Boolean, 1),
        (DataType::Integer8, 1),
        (DataType::Integer16, 2),
        (DataType::Integer32, 4),
        (DataType::Unsigned8, 1),
        (DataType::Unsigned16, 2),
        (DataType::Unsigned32, 4),
        (DataType::Real32, 4),
        (DataType::Integer24, 3),
        (DataType::Real64, 8),
        (DataType::Integer40, 5),
        (DataType::Integer48, 6),
        (DataType::Integer56, 7),
        (DataType::Integer64, 8),
        (DataType::Unsigned24, 3),
        (DataType::Unsigned40, 5),
        (DataType::Unsigned48, 6),
        (DataType::Unsigned56, 7),
        (DataType::Unsigned64, 8),
    ];
    DUMMIES
        .iter()
        .find(|(data_type, _)| *data_type as u16 == index)
        .copied()
}

//! Mapping parameters (1600h to 17FFh, 1A00h to 1BFFh): from the numbers that a master writes to entries of the dictionary, and
//! from those to the bytes of a frame, either way.
//!
//! One mapping entry is an UNSIGNED32: index (bits 16 to 31), sub-index (bits 8 to 15), length in bits (bits 0 to 7).
//! The indices 0001h to 001Bh are data types; in a receive PDO they stand for bits that are skipped (dummy mapping).
//!
//! Objects follow each other without a gap, the first in the lowest bit of the first byte. The length of an object is its own;
//! a BOOLEAN has one bit, or eight as in the dictionary. Of an unsigned number the low bits may be mapped, if they are no
//! whole bytes: whole bytes are the length of another type, and so a mistake.
//!
//! Values lie in the dictionary as they travel on the bus: an object is a copy of bytes, and a frame whose objects are neighbours
//! in memory is one copy.

use core::ops::Range;

use super::bits;
use super::multiplexed::Addressing;
use crate::cia301::sdo::AbortCode;
use crate::copy::{copy, copy_few};
use crate::od::{
    Attributes, DataType, Dictionary, Entry, Location, Slots, Table, Unused, check, put, value,
};

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

    pub(super) fn bits(self) -> u8 {
        let [bits, _, _, _] = self.0.to_le_bytes();
        bits
    }

    /// The same with the length of its object, if it has none and that is a habit of the device.
    pub(super) fn whole<D: Dictionary>(self) -> Self {
        if !D::HABITS.mapped_length_of_0 || self.bits() != 0 || self == Self::EMPTY {
            return self;
        }
        let bits = match dummy(self.index()) {
            Some(bytes) => u16::from(bytes) * 8,
            None => {
                let entry = D::TABLE.find(self.index(), self.sub());
                entry.map_or(0, |entry| entry.size().saturating_mul(8))
            }
        };
        Self(self.0 | u32::from(bits & 0xFF))
    }

    /// The position in the table of the object of this mapping entry; `None` for a dummy.
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
    ) -> Result<Option<u16>, AbortCode> {
        if let Some(bytes) = dummy(self.index()) {
            // Of a BOOLEAN, the first of them, one bit as well.
            let has_length = self.bits() == bytes.wrapping_mul(8) || self.0 == 1 << 16 | 1;
            let is_dummy = direction == Direction::Receive
                && dummies >> (self.index() % 32) & 1 != 0
                && self.sub() == 0
                && has_length;
            return is_dummy.then_some(None).ok_or(AbortCode::NotMappable);
        }
        let entry = table.find(self.index(), self.sub())?;
        let has_length = is_whole(entry.data_type, entry.size(), self.bits())
            || is_part(entry.data_type, entry.size(), self.bits());
        let is_allowed = has_length && is_mappable(entry, direction);
        let position = is_allowed.then(|| table.position(entry)).flatten();
        position.map(Some).ok_or(AbortCode::NotMappable)
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

/// An object in a frame: four bytes of RAM for each that the data sheet allows in a mapping.
#[derive(Clone, Copy, Debug)]
pub struct Mapped {
    /// The position of its entry in the table.
    entry: u16,
    /// Its first bit in the frame (0 to 63), and [`Mapped::LIMITED`].
    position: u8,
    /// Bits in the frame, 1 to 64.
    bits: u8,
}

impl Unused for Mapped {
    const UNUSED: Self = Self {
        entry: 0,
        position: 0,
        bits: 0,
    };
}

impl Mapped {
    /// The object refuses some values that fit into its bits.
    const LIMITED: u8 = 1 << 7;

    /// Its first bit in the frame.
    #[inline]
    const fn position(self) -> u8 {
        self.position & !Self::LIMITED
    }

    /// Whether it is whole bytes at whole bytes.
    #[inline]
    const fn is_bytes(self) -> bool {
        bits::are_bytes(self.position(), self.bits)
    }

    /// Its descriptor.
    #[inline]
    pub(super) fn entry(self, table: &Table) -> Option<&'static Entry> {
        table.entries.get(usize::from(self.entry))
    }

    /// Its value in a frame, as many bytes as the object has. Bits that are not mapped are 0; `room` is for a value that is not
    /// whole bytes in the frame.
    #[inline]
    pub(super) fn value<'a>(
        self,
        entry: &Entry,
        frame: &'a [u8; 8],
        room: &'a mut [u8; 8],
    ) -> &'a [u8] {
        if self.is_bytes() {
            let begin = usize::from(self.position() / 8);
            let end = begin.saturating_add(usize::from(self.bits / 8));
            return frame.get(begin..end).unwrap_or(&[]);
        }
        *room = self.odd_value(frame);
        room.get(..usize::from(entry.size())).unwrap_or(&[])
    }

    #[cold]
    #[inline(never)]
    fn odd_value(self, frame: &[u8; 8]) -> [u8; 8] {
        bits::get(frame, self.position(), self.bits).to_le_bytes()
    }

    /// Whether its value in a frame is within the limits of the data sheet.
    #[inline]
    pub(super) fn is_within_limits(self, table: &Table, entry: &Entry, value: &[u8]) -> bool {
        self.position & Self::LIMITED == 0 || check(table, entry, value).is_ok()
    }

    /// Writes its value in a frame, without any check.
    pub(super) fn unpack<D: Dictionary>(self, frame: &[u8; 8], dictionary: &mut D) {
        if let Some(entry) = self.entry(D::TABLE) {
            put(dictionary, entry, self.value(entry, frame, &mut [0; 8]));
        }
    }

    /// Adds its value to a frame, whose bits are 0 there.
    fn pack<D: Dictionary>(self, frame: &mut [u8; 8], dictionary: &D) {
        let Some(entry) = self.entry(D::TABLE) else {
            return;
        };
        let from = value(dictionary, entry);
        if self.is_bytes() {
            if let Some(to) = frame.get_mut(usize::from(self.position() / 8)..) {
                copy_few(to, from, usize::from(self.bits / 8));
            }
        } else {
            let mut room = [0; 8];
            copy(&mut room, from);
            let number = u64::from_le_bytes(room);
            let present = u64::from_le_bytes(*frame);
            *frame = bits::with(present, self.position(), self.bits, number).to_le_bytes();
        }
    }
}

/// What is known of all objects of a mapping together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Where the frame lies in RAM, whose objects lie there as they lie in the frame: the offset and 1; 0 if they do not.
    run: u16,
    /// The same of a frame of eight bytes; 0 of a shorter one.
    whole: u16,
    /// The places in RAM that objects lie in, as one range; empty if there are none.
    ram: (u16, u16),
    count: u8,
    /// Bits of the frame, dummies included; 0 when nothing is mapped.
    bits: u8,
    /// The bytes that they take.
    length: u8,
    /// Whether an object refuses some values that fit into its bits.
    is_limited: bool,
    /// Whose object the frame names, if it does.
    pub(super) addressing: Option<Addressing>,
}

impl Layout {
    /// Nothing mapped.
    pub(super) const NOTHING: Self = Self {
        run: 0,
        whole: 0,
        ram: (0, 0),
        count: 0,
        bits: 0,
        length: 0,
        is_limited: false,
        addressing: None,
    };

    /// A mapping without objects: the frame names its object.
    pub(super) const fn addressed(addressing: Addressing) -> Self {
        Self {
            bits: MOST_BITS,
            length: MOST_BITS / 8,
            addressing: Some(addressing),
            ..Self::NOTHING
        }
    }

    /// Whether nothing is mapped.
    pub(super) const fn is_empty(&self) -> bool {
        self.bits == 0
    }

    /// Whether the frame names its object.
    pub(super) const fn is_addressed(&self) -> bool {
        self.addressing.is_some()
    }

    /// Puts one more object, or bits that are skipped, behind those that are there.
    ///
    /// # Errors
    /// [`AbortCode::PdoLengthExceeded`]: more than 64 bits, or more objects than the data sheet has room for.
    pub(super) fn push(
        &mut self,
        objects: &mut [Mapped],
        table: &Table,
        object: Option<u16>,
        bits: u8,
    ) -> Result<(), AbortCode> {
        let total = self.bits.saturating_add(bits);
        if total > MOST_BITS {
            return Err(AbortCode::PdoLengthExceeded);
        }
        let mut run = 0;
        if let Some(position) = object
            && let Some(entry) = table.entries.get(usize::from(position))
        {
            let place = objects.get_mut(usize::from(self.count));
            let is_limited =
                entry.has_limits() || (entry.data_type == DataType::Boolean && bits != 1);
            *place.ok_or(AbortCode::PdoLengthExceeded)? = Mapped {
                entry: position,
                position: self.bits | if is_limited { Mapped::LIMITED } else { 0 },
                bits,
            };
            self.count = self.count.saturating_add(1);
            self.is_limited |= is_limited;
            if let Location::Ram(offset) = entry.location() {
                if bits::are_bytes(self.bits, bits) {
                    let begin = offset
                        .wrapping_add(1)
                        .wrapping_sub(u16::from(self.bits / 8));
                    if self.bits == 0 || begin == self.run {
                        run = begin;
                    }
                }
                let end = offset.saturating_add(entry.size());
                self.ram = around(self.ram, (offset, end));
            }
        }
        self.run = run;
        self.whole = if total == MOST_BITS { run } else { 0 };
        self.bits = total;
        self.length = total.div_ceil(8);
        Ok(())
    }
}

/// The shortest range with the places of both.
pub(super) fn around(first: (u16, u16), second: (u16, u16)) -> (u16, u16) {
    match (first, second) {
        ((_, 0), other) | (other, (_, 0)) => other,
        _ => (first.0.min(second.0), first.1.max(second.1)),
    }
}

/// The objects of a PDO, in places `M`.
#[derive(Debug)]
pub(super) struct Mapping<M> {
    pub(super) objects: M,
    pub(super) layout: Layout,
}

impl<M: Slots<Mapped>> Mapping<M> {
    pub(super) const NOTHING: Self = Self {
        objects: M::UNUSED,
        layout: Layout::NOTHING,
    };

    /// Bytes of the frame.
    #[inline]
    pub(super) const fn length(&self) -> u8 {
        self.layout.length
    }

    /// The objects in their order.
    #[inline]
    pub(super) fn objects(&self) -> &[Mapped] {
        let objects = self.objects.as_ref();
        objects
            .get(..usize::from(self.layout.count))
            .unwrap_or(objects)
    }

    /// Whose object the frame names; `None` for a mapping of objects.
    #[inline]
    pub(super) const fn addressing(&self) -> Option<Addressing> {
        self.layout.addressing
    }

    /// Whether an object refuses some values that fit into its bits.
    #[inline]
    pub(super) const fn is_limited(&self) -> bool {
        self.layout.is_limited
    }

    /// The places in RAM that its objects lie in, as one range.
    pub(super) const fn ram(&self) -> (u16, u16) {
        self.layout.ram
    }

    /// Whether one of these places in RAM may be written.
    pub(super) fn writes(&self, watched: &Range<u16>) -> bool {
        let (start, end) = self.layout.ram;
        self.layout.addressing.is_some() || (start < watched.end && watched.start < end)
    }

    /// The place in RAM of a frame that is one copy of eight bytes; beyond all RAM if it is not.
    #[inline]
    fn whole(&self) -> usize {
        usize::from(self.layout.whole).wrapping_sub(1)
    }

    /// Copies a frame to all its objects, without any check.
    #[inline]
    pub(super) fn unpack<D: Dictionary>(&self, frame: &[u8; 8], dictionary: &mut D) {
        // Mostly a frame is one copy of eight bytes.
        let to = dictionary.ram_mut().get_mut(self.whole()..);
        match to.and_then(<[u8]>::first_chunk_mut) {
            Some(to) => *to = *frame,
            None => self.unpack_objects(frame, dictionary),
        }
    }

    #[inline(never)]
    fn unpack_objects<D: Dictionary>(&self, frame: &[u8; 8], dictionary: &mut D) {
        for object in self.objects() {
            object.unpack(frame, dictionary);
        }
    }

    /// The frame's bytes from the dictionary; bits beyond the mapping are 0.
    #[inline]
    pub(super) fn pack<D: Dictionary>(&self, dictionary: &D) -> [u8; 8] {
        // Mostly a frame is one copy of eight bytes.
        let from = dictionary.ram().get(self.whole()..);
        match from.and_then(<[u8]>::first_chunk) {
            Some(frame) => *frame,
            None => self.pack_objects(dictionary),
        }
    }

    #[inline(never)]
    fn pack_objects<D: Dictionary>(&self, dictionary: &D) -> [u8; 8] {
        let mut frame = [0; 8];
        for object in self.objects() {
            object.pack(&mut frame, dictionary);
        }
        frame
    }

    /// Whether a frame is one copy.
    #[cfg(test)]
    pub(super) const fn is_one_copy(&self) -> bool {
        self.layout.run != 0
    }
}

/// Bytes of the dummies by their indices, the numbers of data types; 0 for what is no number.
const DUMMIES: [u8; 0x1C] = [
    0, 1, 1, 2, 4, 1, 2, 4, 4, 0, 0, 0, 0, 0, 0, 0, 3, 8, 5, 6, 7, 8, 3, 0, 5, 6, 7, 8,
];

/// Bytes of a dummy, by its index: every number has one.
fn dummy(index: u16) -> Option<u8> {
    let bytes = DUMMIES.get(usize::from(index)).copied();
    bytes.filter(|bytes| *bytes != 0)
}

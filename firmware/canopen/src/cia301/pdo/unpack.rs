//! From a frame into the dictionary: the resolved mapping of a receive PDO.

use core::ops::Range;

use super::bits;
use super::mapping::{Layout, MOST_BITS, Target, with_target};
use super::multiplexed::Addressing;
use crate::cia301::sdo::AbortCode;
use crate::copy::copy_few;
use crate::od::{Attributes, DataType, Dictionary, Entry, Slots, Table, Unused, check, put};

/// Where some bits of a frame go: four bytes of RAM for each object that the data sheet allows in a mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination {
    /// The position of its entry in the table.
    entry: u16,
    /// Its first bit in the frame (0 to 63), and [`Destination::LIMITED`].
    position: u8,
    /// Bits in the frame, 1 to 64.
    bits: u8,
}

impl Unused for Destination {
    const UNUSED: Self = Self {
        entry: u16::MAX,
        position: 0,
        bits: 0,
    };
}

impl Destination {
    /// The object refuses some values that fit into its bits.
    const LIMITED: u8 = 1 << 7;

    fn new(entry_position: u16, entry: &Entry, position: u8, bits: u8) -> Self {
        let is_limited = entry.has_limits() || (entry.data_type == DataType::Boolean && bits != 1);
        Self {
            entry: entry_position,
            position: position | if is_limited { Self::LIMITED } else { 0 },
            bits,
        }
    }

    /// Its first bit in the frame.
    #[inline]
    const fn position(self) -> u8 {
        self.position & !Self::LIMITED
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
        if bits::are_bytes(self.position(), self.bits) {
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
    #[inline]
    pub(super) fn put<D: Dictionary>(self, frame: &[u8; 8], dictionary: &mut D) {
        let Some(entry) = self.entry(D::TABLE) else {
            return;
        };
        if !bits::are_bytes(self.position(), self.bits) {
            put(dictionary, entry, self.value(entry, frame, &mut [0; 8]));
            return;
        }
        // The object lies in RAM: nothing else is mapped to receive.
        if let (Some(from), Some(to)) = (
            frame.get(usize::from(self.position() / 8)..),
            dictionary.ram_mut().get_mut(usize::from(entry.offset)..),
        ) {
            copy_few(to, from, usize::from(self.bits / 8));
        }
    }
}

/// A resolved mapping: its objects in order, dummies left out.
#[derive(Clone, Debug)]
pub(super) struct Unpacking<M> {
    objects: M,
    count: u8,
    /// Bits of the frame, dummies included; 0 when nothing is mapped.
    bits: u8,
    /// The bytes that they take.
    length: u8,
    /// The offset in RAM that the whole frame is copied to, when its objects lie there as they lie in the frame; [`NO_RUN`]
    /// otherwise.
    run: u16,
    /// Whether an object refuses some values that fit into its bits.
    is_limited: bool,
    /// Whose object the frame names, if it does.
    addressing: Option<Addressing>,
}

/// No offset.
const NO_RUN: u16 = u16::MAX;

impl<M: Slots<Destination>> Unpacking<M> {
    /// Bytes of the frame.
    #[inline]
    pub(super) const fn length(&self) -> u8 {
        self.length
    }

    /// The objects in their order.
    #[inline]
    pub(super) fn objects(&self) -> &[Destination] {
        let objects = self.objects.as_ref();
        objects.get(..usize::from(self.count)).unwrap_or(objects)
    }

    /// Whose object the frame names; `None` for a mapping of objects.
    pub(super) const fn addressing(&self) -> Option<Addressing> {
        self.addressing
    }

    /// Whether an object refuses some values that fit into its bits.
    #[inline]
    pub(super) const fn is_limited(&self) -> bool {
        self.is_limited
    }

    /// Whether one of these places in RAM is written.
    pub(super) fn writes(&self, table: &Table, watched: &Range<u16>) -> bool {
        self.addressing.is_some()
            || self.objects().iter().any(|object| {
                object.entry(table).is_some_and(|entry| {
                    let end = entry.offset.saturating_add(entry.size());
                    entry.offset < watched.end && watched.start < end
                })
            })
    }

    /// Copies a frame to all its objects, without any check.
    #[inline]
    pub(super) fn unpack<D: Dictionary>(&self, frame: &[u8; 8], dictionary: &mut D) {
        // Mostly a frame is one copy of eight bytes.
        let begin = usize::from(self.run);
        match dictionary.ram_mut().get_mut(begin..begin.saturating_add(8)) {
            Some(to) if self.length == 8 => copy_few(to, frame, 8),
            _ => self.unpack_objects(frame, dictionary),
        }
    }

    #[inline(never)]
    fn unpack_objects<D: Dictionary>(&self, frame: &[u8; 8], dictionary: &mut D) {
        for object in self.objects() {
            object.put(frame, dictionary);
        }
    }

    /// Whether an object that is added at the end goes on where the frame's place in RAM ends.
    fn run_with(&self, entry: &Entry, bits: u8) -> u16 {
        let is_plain = bits::are_bytes(self.bits, bits) && !entry.attributes.has(Attributes::ROM);
        let begin = entry.offset.checked_sub(u16::from(self.bits / 8));
        match begin {
            Some(begin) if is_plain && (self.bits == 0 || begin == self.run) => begin,
            _ => NO_RUN,
        }
    }
}

impl<M: Slots<Destination>> Layout for Unpacking<M> {
    const NOTHING: Self = Self {
        objects: M::UNUSED,
        count: 0,
        bits: 0,
        length: 0,
        run: NO_RUN,
        is_limited: false,
        addressing: None,
    };

    fn addressed(addressing: Addressing) -> Self {
        Self {
            bits: MOST_BITS,
            length: MOST_BITS / 8,
            addressing: Some(addressing),
            ..Self::NOTHING
        }
    }

    fn push(&mut self, target: Target) -> Result<(), AbortCode> {
        let bits = with_target(self.bits, &target)?;
        self.run = match target {
            Target::Object {
                position,
                entry,
                bits,
            } => {
                let place = self.objects.as_mut().get_mut(usize::from(self.count));
                let object = Destination::new(position, entry, self.bits, bits);
                *place.ok_or(AbortCode::PdoLengthExceeded)? = object;
                self.is_limited |= object.position & Destination::LIMITED != 0;
                self.count = self.count.saturating_add(1);
                self.run_with(entry, bits)
            }
            Target::Dummy(_) => NO_RUN,
        };
        self.bits = bits;
        self.length = bits.div_ceil(8);
        Ok(())
    }
}

impl<M: Slots<Destination>> PartialEq for Unpacking<M> {
    fn eq(&self, other: &Self) -> bool {
        self.bits == other.bits
            && self.addressing == other.addressing
            && self.objects() == other.objects()
    }
}

//! From a frame into the dictionary: the resolved mapping of a receive PDO.

use super::bits;
use super::mapping::{Direction, Layout, MOST_BITS, Target, with_target};
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

/// The value of an object in a frame.
pub(super) struct Value {
    bytes: [u8; 8],
    length: usize,
}

impl Value {
    /// Its bytes, as many as the object has.
    #[inline]
    pub(super) fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }
}

impl Destination {
    /// The object refuses some values that fit into its bits.
    const LIMITED: u8 = 1 << 7;

    fn new(entry_position: u16, entry: &Entry, position: u8, bits: u8) -> Self {
        let is_limited =
            entry.limits != Entry::NO_LIMITS || (entry.data_type == DataType::Boolean && bits != 1);
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

    /// Its value in a frame. Bits that are not mapped are 0.
    #[inline]
    pub(super) fn value(self, entry: &Entry, frame: &[u8; 8]) -> Value {
        let bytes = if bits::are_bytes(self.position(), self.bits) {
            let mut bytes = [0; 8];
            if let Some(from) = frame.get(usize::from(self.position() / 8)..) {
                copy_few(&mut bytes, from, usize::from(self.bits / 8));
            }
            bytes
        } else {
            bits::get(frame, self.position(), self.bits).to_le_bytes()
        };
        Value {
            bytes,
            length: usize::from(entry.size),
        }
    }

    /// Whether its value in a frame is within the limits of the data sheet.
    #[inline]
    pub(super) fn is_within_limits(self, table: &Table, entry: &Entry, frame: &[u8; 8]) -> bool {
        self.position & Self::LIMITED == 0
            || check(table, entry, self.value(entry, frame).bytes()).is_ok()
    }

    /// Writes its value in a frame, without any check.
    #[inline]
    pub(super) fn put<D: Dictionary>(self, frame: &[u8; 8], dictionary: &mut D) {
        let Some(entry) = self.entry(D::TABLE) else {
            return;
        };
        if !bits::are_bytes(self.position(), self.bits) {
            put(dictionary, entry, self.value(entry, frame).bytes());
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
    /// The offset in RAM that the whole frame is copied to, when its objects lie there as they lie in the frame; [`NO_RUN`]
    /// otherwise.
    run: u16,
    /// Whose object the frame names, if it does.
    addressing: Option<Addressing>,
}

/// No offset.
const NO_RUN: u16 = u16::MAX;

impl<M: Slots<Destination>> Unpacking<M> {
    /// Bytes of the frame.
    #[inline]
    pub(super) const fn length(&self) -> u8 {
        self.bits.div_ceil(8)
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

    /// Copies a frame to all its objects, without any check.
    #[inline]
    pub(super) fn unpack<D: Dictionary>(&self, frame: &[u8; 8], dictionary: &mut D) {
        if self.run == NO_RUN {
            for object in self.objects() {
                object.put(frame, dictionary);
            }
        } else if let Some(to) = dictionary.ram_mut().get_mut(usize::from(self.run)..) {
            copy_few(to, frame, usize::from(self.length()));
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
    const DIRECTION: Direction = Direction::Receive;

    const NOTHING: Self = Self {
        objects: M::UNUSED,
        count: 0,
        bits: 0,
        run: NO_RUN,
        addressing: None,
    };

    fn addressed(addressing: Addressing) -> Self {
        Self {
            bits: MOST_BITS,
            addressing: Some(addressing),
            ..Self::NOTHING
        }
    }

    fn is_addressed(&self) -> bool {
        self.addressing.is_some()
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
                *place.ok_or(AbortCode::PdoLengthExceeded)? =
                    Destination::new(position, entry, self.bits, bits);
                self.count = self.count.saturating_add(1);
                self.run_with(entry, bits)
            }
            Target::Dummy(_) => NO_RUN,
        };
        self.bits = bits;
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

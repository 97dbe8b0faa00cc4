//! From the dictionary into a frame: the resolved mapping of a transmit PDO.
//!
//! Values lie in the dictionary as they travel on the bus, so a mapped object is a copy of bytes. Objects that are
//! neighbours in the frame and in memory become one copy.

use core::ops::Range;

use super::bits;
use super::mapping::{Layout, MOST_BITS, Target, with_target};
use super::multiplexed::Addressing;
use crate::cia301::sdo::AbortCode;
use crate::copy::{copy, copy_few};
use crate::od::{Attributes, Entry, Slots, Unused};

/// Where some bits of a frame come from: four bytes of RAM for each object that the data sheet allows in a mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// The offset of its value in RAM, or in flash.
    offset: u16,
    /// Its first bit in the frame, 0 to 63.
    position: u8,
    /// Bits in the frame (1 to 64), and [`Source::ROM`].
    bits: u8,
}

impl Unused for Source {
    const UNUSED: Self = Self {
        offset: 0,
        position: 0,
        bits: 0,
    };
}

impl Source {
    /// The value lies in flash.
    const ROM: u8 = 1 << 7;

    fn new(entry: &Entry, position: u8, bits: u8) -> Self {
        let is_rom = entry.attributes.has(Attributes::ROM);
        Self {
            offset: entry.offset,
            position,
            bits: bits | if is_rom { Self::ROM } else { 0 },
        }
    }

    #[inline]
    const fn bits(self) -> u8 {
        self.bits & !Self::ROM
    }

    /// Its value and what lies behind it.
    #[inline]
    fn memory<'a>(self, ram: &'a [u8], rom: &'a [u8]) -> &'a [u8] {
        let block = if self.bits & Self::ROM == 0 { ram } else { rom };
        block.get(usize::from(self.offset)..).unwrap_or(&[])
    }

    /// Whether `next` goes on where this one ends, in the frame and in memory, in whole bytes.
    fn is_followed_by(self, next: Self) -> bool {
        let end = self.offset.checked_add(u16::from(self.bits() / 8));
        bits::are_bytes(self.position, self.bits())
            && bits::are_bytes(next.position, next.bits())
            && self.bits & Self::ROM == next.bits & Self::ROM
            && self.position.saturating_add(self.bits()) == next.position
            && end == Some(next.offset)
    }
}

/// No dictionary has eight bytes behind this offset.
const NOT_WHOLE: u16 = u16::MAX;

/// No place in RAM.
pub(super) const NO_RAM: Range<u16> = 0..0;

/// The shortest range with the places of both.
pub(super) fn around(first: &Range<u16>, second: &Range<u16>) -> Range<u16> {
    match (first.is_empty(), second.is_empty()) {
        (true, _) => second.clone(),
        (_, true) => first.clone(),
        _ => first.start.min(second.start)..first.end.max(second.end),
    }
}

/// A resolved mapping as few copies.
#[derive(Clone, Debug)]
pub(super) struct Packing<M> {
    sources: M,
    count: u8,
    /// Bits of the frame; 0 when nothing is mapped.
    bits: u8,
    /// The bytes that they take.
    length: u8,
    /// The offset in RAM of a frame that lies there as a whole, eight bytes; [`NOT_WHOLE`] otherwise.
    whole: u16,
    /// Whose object the frame names, if it does.
    addressing: Option<Addressing>,
}

impl<M: Slots<Source>> Packing<M> {
    /// Bytes of the frame.
    #[inline]
    pub(super) const fn length(&self) -> u8 {
        self.length
    }

    #[inline]
    fn sources(&self) -> &[Source] {
        let sources = self.sources.as_ref();
        sources.get(..usize::from(self.count)).unwrap_or(sources)
    }

    /// Whose object the frame names; `None` for a mapping of objects.
    pub(super) const fn addressing(&self) -> Option<Addressing> {
        self.addressing
    }

    /// The places in RAM that its values come from, as one range; empty if there are none.
    pub(super) fn ram_range(&self) -> Range<u16> {
        let in_ram = self
            .sources()
            .iter()
            .filter(|source| source.bits & Source::ROM == 0);
        in_ram.fold(NO_RAM, |range, source| {
            let length = u16::from(source.bits().div_ceil(8));
            around(
                &range,
                &(source.offset..source.offset.saturating_add(length)),
            )
        })
    }

    /// The frame's bytes from the dictionary; bits beyond the mapping are 0.
    #[inline]
    pub(super) fn pack(&self, ram: &[u8], rom: &[u8]) -> [u8; 8] {
        // Mostly a frame is one copy of eight bytes.
        let begin = usize::from(self.whole);
        let frame = ram.get(begin..begin.saturating_add(8));
        match frame.and_then(<[u8]>::first_chunk) {
            Some(frame) => *frame,
            None => self.pack_sources(ram, rom),
        }
    }

    #[inline(never)]
    fn pack_sources(&self, ram: &[u8], rom: &[u8]) -> [u8; 8] {
        let mut frame = [0; 8];
        for source in self.sources() {
            let from = source.memory(ram, rom);
            if !bits::are_bytes(source.position, source.bits()) {
                add_bits(&mut frame, *source, from);
            } else if let Some(to) = frame.get_mut(usize::from(source.position / 8)..) {
                copy_few(to, from, usize::from(source.bits() / 8));
            }
        }
        frame
    }

    /// How many copies a frame costs.
    #[cfg(test)]
    pub(super) fn copies(&self) -> usize {
        self.sources().len()
    }
}

/// Adds a value that is not whole bytes at whole bytes.
#[inline(never)]
fn add_bits(frame: &mut [u8; 8], source: Source, from: &[u8]) {
    let length = usize::from(source.bits().div_ceil(8));
    let mut value = [0; 8];
    copy(&mut value, from.get(..length).unwrap_or(from));
    let packed = bits::with(
        u64::from_le_bytes(*frame),
        source.position,
        source.bits(),
        u64::from_le_bytes(value),
    );
    *frame = packed.to_le_bytes();
}

impl<M: Slots<Source>> Layout for Packing<M> {
    const NOTHING: Self = Self {
        sources: M::UNUSED,
        count: 0,
        bits: 0,
        length: 0,
        whole: NOT_WHOLE,
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
        if let Target::Object { entry, bits, .. } = target {
            let next = Source::new(entry, self.bits, bits);
            let count = usize::from(self.count);
            let last = self.sources.as_mut().get_mut(count.wrapping_sub(1));
            match last {
                Some(last) if last.is_followed_by(next) => {
                    last.bits = last.bits.saturating_add(bits);
                }
                _ => {
                    let place = self.sources.as_mut().get_mut(count);
                    *place.ok_or(AbortCode::PdoLengthExceeded)? = next;
                    self.count = self.count.saturating_add(1);
                }
            }
        }
        self.bits = bits;
        self.length = bits.div_ceil(8);
        self.whole = match self.sources() {
            // All bits, and the flag of flash is not among them.
            [source] if source.bits == MOST_BITS => source.offset,
            _ => NOT_WHOLE,
        };
        Ok(())
    }
}

impl<M: Slots<Source>> PartialEq for Packing<M> {
    fn eq(&self, other: &Self) -> bool {
        self.bits == other.bits
            && self.addressing == other.addressing
            && self.sources() == other.sources()
    }
}

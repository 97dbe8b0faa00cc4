//! The memory that the DMA reads, again and again.

use core::sync::atomic::{AtomicU32, Ordering};

use super::slots::Words;
use crate::iterations::Iterations;
use crate::low;

/// Slots of the ring: half of them silent at all times, and what two time slices take fits into the other half at any rate. A power of two.
pub const SLOTS: usize = 128;

/// Words of a slot: PSC, ARR, RCR, CCR1, CCR2.
///
/// The prescaler is always 0. It stands first because a DMA stream in direct mode fetches the first word of a slot long before its
/// request: so a slot may be written up to the request itself.
pub const WORDS: usize = 5;

const _: () = assert!(SLOTS.is_power_of_two());

/// What a burst writes.
pub(super) type Slot = [AtomicU32; WORDS];

/// The slots. The processor writes them and the DMA reads them; each word is whole at all times, and which slots are whose is
/// for [`super::Output`] to know.
#[derive(Debug)]
#[repr(transparent)]
pub struct Ring {
    slots: [Slot; SLOTS],
}

impl Ring {
    /// Before the first [`Output`](super::Output), which makes it silent all around: zeros, which take no flash.
    pub const fn new() -> Self {
        Self {
            slots: [const { [const { AtomicU32::new(0) }; WORDS] }; SLOTS],
        }
    }

    /// Where the DMA finds it: addresses have 32 bits on a board.
    pub fn address(&self) -> u32 {
        low::word(core::ptr::from_ref(self).expose_provenance())
    }

    /// The words of a slot, counted round the ring, as the DMA reads them.
    pub fn words(&self, slot: u32) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        if let Some(slot) = self.slots.get(slot as usize % SLOTS) {
            for (word, cell) in words.iter_mut().zip(slot) {
                *word = cell.load(Ordering::Relaxed);
            }
        }
        words
    }

    /// The slots from one on, counted round the ring, up to the end of the memory.
    #[inline]
    pub(super) fn from(&self, slot: u32) -> &[Slot] {
        self.slots.get(slot as usize % SLOTS..).unwrap_or_default()
    }

    /// Writes a slot, counted round the ring.
    #[inline]
    pub(super) fn put(&self, slot: u32, words: Words) {
        if let Some(slot) = self.slots.get(slot as usize % SLOTS) {
            fill(slot, words);
        }
    }

    /// Makes so many slots silent, from one on and round the ring, with this level of the direction signal.
    #[inline]
    pub(super) fn silence(&self, slot: u32, number: u32, level: u32) {
        let silent = Words::silent(level);
        let slots = self.from(slot);
        if let Some(slots) = slots.get(..number as usize) {
            fill_all(slots, silent);
        } else {
            self.silence_round(slots, number, silent);
        }
    }

    /// The same round the end of the memory.
    #[cold]
    fn silence_round(&self, slots: &[Slot], number: u32, silent: Words) {
        let beyond = (number as usize).wrapping_sub(slots.len());
        let slots = slots.iter().chain(self.slots.iter().take(beyond));
        for slot in slots {
            fill(slot, silent);
        }
    }

    /// Sets the level of the direction signal of a slot, counted round the ring.
    #[inline]
    pub(super) fn set_level(&self, slot: u32, level: u32) {
        if let Some([.., cell]) = self.slots.get(slot as usize % SLOTS) {
            cell.store(level, Ordering::Relaxed);
        }
    }
}

/// Writes a slot.
#[inline(always)]
pub(super) fn fill(
    [_, reload_cell, repetitions_cell, width_cell, level_cell]: &Slot,
    words: Words,
) {
    let [reload, repetitions, width, level] = words.0;
    level_cell.store(level, Ordering::Relaxed);
    repetitions_cell.store(repetitions, Ordering::Relaxed);
    reload_cell.store(reload, Ordering::Relaxed);
    // The pulse last: should the DMA come in between, against all care, there is none.
    width_cell.store(width, Ordering::Relaxed);
}

/// Writes slots that are all alike, several at a time: a loop around one is longer than its words.
#[inline]
fn fill_all(mut slots: &[Slot], words: Words) {
    let mut iterations = Iterations::for_each(slots);
    while let [one, two, three, four, rest @ ..] = slots {
        iterations.count();
        fill(one, words);
        fill(two, words);
        fill(three, words);
        fill(four, words);
        slots = rest;
    }
    slots.iter().for_each(|slot| fill(slot, words));
}

impl Default for Ring {
    fn default() -> Self {
        Self::new()
    }
}

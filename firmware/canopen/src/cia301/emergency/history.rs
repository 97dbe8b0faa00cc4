//! The pre-defined error field 1003h: the last errors, the newest at sub-index 1.

use core::ops::Range;

use crate::cia301::sdo::AbortCode;
use crate::od::{self, Dictionary, Entry, Location};

/// Index of the pre-defined error field.
pub(super) const INDEX: u16 = 0x1003;

/// Bytes of one error.
const WORD: usize = 4;
const SIZE: u16 = WORD as u16;

/// Where 1003h lies in the RAM of one dictionary. The errors lie one behind the other there, so that moving them down is
/// one walk over memory.
#[derive(Debug)]
pub(super) struct History {
    /// Of sub-index 0, the number of errors.
    count: u16,
    /// Of sub-index 1.
    first: u16,
    /// How many errors there is room for; 0 without 1003h.
    capacity: u16,
}

impl History {
    pub(super) const fn new() -> Self {
        Self {
            count: 0,
            first: 0,
            capacity: 0,
        }
    }

    /// Looks it up. A sub-index that does not lie behind the one before it ends the field.
    #[inline(never)]
    pub(super) fn configure<D: Dictionary>(&mut self) {
        *self = Self::new();
        let mut places =
            D::TABLE
                .range(INDEX..=INDEX)
                .iter()
                .map_while(|entry| match entry.location() {
                    Location::Ram(offset) => Some((offset, entry.size())),
                    Location::Rom(_) | Location::Application => None,
                });
        if let (Some((count, 1)), Some((first, SIZE))) = (places.next(), places.next()) {
            let mut next = first;
            self.count = count;
            self.first = first;
            self.capacity = 1 + places
                .take_while(|place| {
                    next = next.saturating_add(SIZE);
                    *place == (next, SIZE)
                })
                .count() as u16;
        }
    }

    /// Whether a part of it lies in these places of RAM.
    pub(super) fn lies_in(&self, places: &Range<u16>) -> bool {
        let field_end = self
            .first
            .saturating_add(self.capacity.saturating_mul(SIZE));
        let has_count = self.capacity > 0 && places.contains(&self.count);
        has_count || self.first.max(places.start) < field_end.min(places.end)
    }

    /// Puts an error at sub-index 1 and moves the others down; the oldest falls out of a full field.
    #[inline(always)]
    pub(super) fn insert<D: Dictionary>(&self, dictionary: &mut D, word: u32) {
        if self.capacity == 0 {
            return;
        }
        let ram = dictionary.ram_mut();
        let Some(count) = ram.get_mut(usize::from(self.count)) else {
            return;
        };
        let present = *count;
        if u16::from(present) < self.capacity {
            *count = present.wrapping_add(1);
        }
        if present != 0 {
            self.move_down(ram, present);
        }
        let rest = ram.get_mut(usize::from(self.first)..);
        if let Some(newest) = rest.and_then(<[u8]>::first_chunk_mut) {
            *newest = word.to_le_bytes();
        }
    }

    /// Makes room for one more error in front of these.
    #[inline(never)]
    fn move_down(&self, ram: &mut [u8], present: u8) {
        let mut carried = [0; WORD];
        // One more than are present, as far as there is room.
        for place in self.places(ram).iter_mut().take(usize::from(present) + 1) {
            core::mem::swap(place, &mut carried);
        }
    }

    /// Writing 0 to sub-index 0 empties the field: the errors become 0 as well, so that none returns.
    pub(super) fn clear<D: Dictionary>(&self, dictionary: &mut D) {
        self.places(dictionary.ram_mut()).fill([0; WORD]);
    }

    /// The bytes of the errors, the newest first.
    fn places<'a>(&self, ram: &'a mut [u8]) -> &'a mut [[u8; WORD]] {
        let (places, _) = ram
            .get_mut(usize::from(self.first)..)
            .unwrap_or(&mut [])
            .as_chunks_mut();
        places
            .get_mut(..usize::from(self.capacity))
            .unwrap_or(&mut [])
    }
}

/// Whether a sub-index of 1003h has a value now.
///
/// # Errors
/// [`AbortCode::NoData`] above the number of errors (CiA 301, 7.5.2.6).
pub(crate) fn is_present<D: Dictionary>(dictionary: &D, entry: &Entry) -> Result<(), AbortCode> {
    if entry.sub == 0 || entry.sub <= od::read_u8(dictionary, INDEX, 0).unwrap_or(0) {
        Ok(())
    } else {
        Err(AbortCode::NoData)
    }
}

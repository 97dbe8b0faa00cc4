//! The pre-defined error field 1003h: the last errors, the newest at sub-index 1.

use core::ops::Range;

use crate::cia301::sdo::AbortCode;
use crate::od::{self, Dictionary, Entry, Table, place};

/// Index of the pre-defined error field.
pub(super) const INDEX: u16 = 0x1003;

/// Bytes of one error.
const WORD: usize = 4;
const SIZE: u16 = WORD as u16;

/// Where 1003h lies in the RAM of one dictionary. The errors lie one behind the other there, so that moving them down is
/// one walk over memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    /// Of sub-index 0, the number of errors.
    count: usize,
    /// Of sub-index 1.
    first: usize,
    /// How many errors there is room for; 0 without 1003h.
    capacity: usize,
}

impl History {
    /// That of a dictionary, known when it is compiled.
    #[inline]
    pub(super) const fn of<D: Dictionary>() -> Self {
        const { Self::find(D::TABLE) }
    }

    /// A sub-index that does not lie behind the one before it ends the field.
    const fn find(table: &Table) -> Self {
        let (count, first) = (place(table, INDEX, 0, 1), place(table, INDEX, 1, SIZE));
        let mut capacity = 0;
        if count != usize::MAX && first != usize::MAX {
            while capacity < u8::MAX
                && place(table, INDEX, capacity + 1, SIZE) == first + capacity as usize * WORD
            {
                capacity += 1;
            }
        }
        Self {
            count,
            first,
            capacity: capacity as usize,
        }
    }

    /// Whether a part of it lies in these places of RAM.
    pub(super) fn lies_in(&self, bytes: &Range<usize>) -> bool {
        let end = self
            .first
            .saturating_add(self.capacity.saturating_mul(WORD));
        let has_errors = self.first.max(bytes.start) < end.min(bytes.end);
        self.capacity > 0 && (bytes.contains(&self.count) || has_errors)
    }

    /// Puts an error at sub-index 1 and moves the others down; the oldest falls out of a full field.
    #[inline(always)]
    pub(super) fn insert<D: Dictionary>(&self, dictionary: &mut D, word: u32) {
        if self.capacity == 0 {
            return;
        }
        let ram = dictionary.ram_mut();
        let Some(count) = ram.get_mut(self.count) else {
            return;
        };
        let present = *count;
        if usize::from(present) < self.capacity {
            *count = present.wrapping_add(1);
        }
        if present != 0 {
            self.move_down(ram, present);
        }
        let rest = ram.get_mut(self.first..);
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
        let (places, _) = ram.get_mut(self.first..).unwrap_or(&mut []).as_chunks_mut();
        places.get_mut(..self.capacity).unwrap_or(&mut [])
    }
}

/// Whether a sub-index of 1003h has a value now.
///
/// # Errors
/// [`AbortCode::NoData`] above the number of errors (CiA 301, 7.5.2.6).
pub(crate) fn is_present<D: Dictionary>(dictionary: &D, entry: &Entry) -> Result<(), AbortCode> {
    if entry.sub == 0 || entry.sub <= od::fixed::<D, INDEX, 0>(dictionary).unwrap_or(0) as u8 {
        Ok(())
    } else {
        Err(AbortCode::NoData)
    }
}

//! A ring of records between two tasks: one puts in, one takes out, neither ever waits.
//!
//! A record is three words, and each word is atomic by itself; the counts of records put in and taken out say which slots
//! belong to whom. (A queue of `heapless` would do, but it divides by its length, which leaves a path to a panic.)

use core::sync::atomic::{AtomicU32, Ordering};

use crate::low;
use crate::{Direction, Record};

/// Records that fit. An axis keeps two time slices under way, each of some tens of records at worst. A power of two.
pub const CAPACITY: usize = 128;

const SLOTS: u32 = low::word(CAPACITY);

const _: () = assert!(SLOTS.is_power_of_two());

#[derive(Debug)]
struct Slot {
    period: AtomicU32,
    repeat_and_width: AtomicU32,
    reverse: AtomicU32,
}

impl Slot {
    const fn new() -> Self {
        Self {
            period: AtomicU32::new(0),
            repeat_and_width: AtomicU32::new(0),
            reverse: AtomicU32::new(0),
        }
    }
}

/// The ring.
#[derive(Debug)]
pub struct Ring {
    slots: [Slot; CAPACITY],
    /// Records put in, and records taken out; both wrap.
    put: AtomicU32,
    taken: AtomicU32,
}

impl Ring {
    /// Nothing in it.
    pub const fn new() -> Self {
        Self {
            slots: [const { Slot::new() }; CAPACITY],
            put: AtomicU32::new(0),
            taken: AtomicU32::new(0),
        }
    }

    /// Slots that are free for [`Ring::put`].
    pub fn free(&self) -> u32 {
        let put = self.put.load(Ordering::Relaxed);
        let taken = self.taken.load(Ordering::Acquire);
        SLOTS.saturating_sub(put.wrapping_sub(taken))
    }

    /// Puts a record in; gives it back when there is no room. For one task only.
    pub fn put(&self, record: Record) -> Result<(), Record> {
        let put = self.put.load(Ordering::Relaxed);
        let Some(slot) = self.slot(put).filter(|_| self.free() > 0) else {
            return Err(record);
        };
        let [repeat, width] = [record.repeat, record.width].map(u32::from);
        slot.period.store(record.period, Ordering::Relaxed);
        slot.repeat_and_width
            .store(repeat << 16 | width, Ordering::Relaxed);
        let reverse = record.direction == Direction::Reverse;
        slot.reverse.store(reverse.into(), Ordering::Relaxed);
        // From here on the slot belongs to the other side.
        self.put.store(put.wrapping_add(1), Ordering::Release);
        Ok(())
    }

    /// Takes the oldest record out. For one task only.
    pub fn take(&self) -> Option<Record> {
        let taken = self.taken.load(Ordering::Relaxed);
        if taken == self.put.load(Ordering::Acquire) {
            return None;
        }
        let slot = self.slot(taken)?;
        let repeat_and_width = slot.repeat_and_width.load(Ordering::Relaxed);
        let record = Record {
            period: slot.period.load(Ordering::Relaxed),
            repeat: (repeat_and_width >> 16) as u16,
            width: low::u16(repeat_and_width),
            direction: match slot.reverse.load(Ordering::Relaxed) {
                0 => Direction::Forward,
                _ => Direction::Reverse,
            },
        };
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(record)
    }

    fn slot(&self, count: u32) -> Option<&Slot> {
        self.slots.get((count % SLOTS) as usize)
    }
}

//! How records get into the ring: each becomes slots, and each slot is written before the DMA fetches it.

use super::{MAX_SLOTS, Output};
use crate::advanced_timer::registers::{Register, Registers};
use crate::advanced_timer::slots::{Place, Remainder, level};
use crate::iterations::Iterations;
use crate::low;
use crate::{PulseSink, Record, Ticks};

impl<R: Registers> Output<'_, R> {
    /// Writes what is left of the last record as slots, while the ring has room. `in_time` slots are sure to be in time; then the count is
    /// taken anew.
    #[inline]
    pub(super) fn fill(&mut self, mut in_time: i32) {
        let mut iterations = Iterations::at_most(MAX_SLOTS);
        while !self.remainder.is_empty() && self.has_room() {
            iterations.count();
            if in_time <= 0 {
                in_time = self.in_time();
                if in_time <= 0 {
                    return;
                }
            }
            in_time = in_time.wrapping_sub(1);
            let words = self.remainder.next();
            // The silence behind this slot must keep the direction.
            let next = self.written.wrapping_add(1);
            self.level = words.level();
            self.ring.set_level(next, self.level);
            self.ring.put(self.written, words);
            self.written = next;
            self.request = self.request.wrapping_add(self.last);
            self.last = words.ticks();
        }
    }

    /// The fast path, for nearly all records: takes those that keep the direction, while they are in time and the slots up to the end of
    /// the ring's memory suffice. Returns how many it has taken.
    #[inline(never)]
    fn push_alike(&mut self, records: &[Record]) -> usize {
        if !self.running || !self.remainder.is_empty() {
            return 0;
        }
        let free = MAX_SLOTS.saturating_sub(self.written.wrapping_sub(self.fetched));
        let max = free.min(self.in_time().max(0).cast_unsigned()) as usize;
        let slots = self.ring.from(self.written);
        let slots = slots.get(..max).unwrap_or(slots);
        let direction = self.counted.direction();
        let mut place = Place::new(slots, self.level);
        let mut left = records;
        let mut iterations = Iterations::for_each(records);
        while let Some((record, rest)) = left.split_first()
            && record.direction == direction
            && let Some(length) = place.put(record)
        {
            iterations.count();
            self.end = self.end.wrapping_add(length);
            if record.width > 0 {
                self.pulses = self.pulses.wrapping_add(record.repeat.into());
            }
            left = rest;
        }
        let written = slots.len().wrapping_sub(place.free.len());
        if written > 0 {
            self.written = self.written.wrapping_add(low::word(written));
            // The silence behind the last slot must keep the direction.
            self.ring.set_level(self.written, self.level);
            self.last = place.last;
            // The DMA fetches the next slot when the last one begins.
            self.request = self.end.wrapping_sub(place.last);
        }
        records.len().wrapping_sub(left.len())
    }

    /// Takes the records from number `taken` on: one by itself, then as many as the fast path takes, and so on. Returns how many of all are
    /// taken then.
    #[inline(never)]
    fn push_others(&mut self, records: &[Record], mut taken: usize) -> usize {
        let mut iterations = Iterations::for_each(records);
        while let Some(record) = records.get(taken)
            && self.push(*record).is_ok()
        {
            iterations.count();
            taken = taken.wrapping_add(1);
            let left = records.get(taken..).unwrap_or_default();
            taken = taken.wrapping_add(self.push_alike(left));
        }
        taken
    }

    /// Whether a slot may be written without touching the silent ones.
    pub(super) fn has_room(&self) -> bool {
        self.written.wrapping_sub(self.fetched) < MAX_SLOTS
    }
}

impl<R: Registers> PulseSink for Output<'_, R> {
    #[inline]
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if self.failed {
            return Err(record);
        }
        if !self.remainder.is_empty() || !self.has_room() {
            self.service();
            if self.failed || !self.remainder.is_empty() || !self.has_room() {
                return Err(record);
            }
        }
        let mut in_time = 0;
        if self.running {
            in_time = self.in_time();
            if in_time <= 0 {
                // Too late to continue without a gap: the next train begins when the last slot has been played.
                self.service();
                if self.failed || self.running {
                    return Err(record);
                }
            }
        }
        if !self.running {
            if self.is_broken() {
                return Err(record);
            }
            self.resync_to_counter();
        }
        if self.counted.direction() != record.direction {
            let count = self.registers.read(Register::CounterCnt);
            if !self.counted.has_room(count) {
                return Err(record);
            }
            let slot = self.written;
            self.counted.turn(self.pulses, record.direction, slot);
        }
        if record.width > 0 {
            self.pulses = self.pulses.wrapping_add(record.repeat.into());
        }
        self.remainder = Remainder::of(&record);
        if self.running {
            self.end = self.end.wrapping_add(self.remainder.ticks());
        } else {
            self.start(level(record.direction));
        }
        self.fill(in_time);
        Ok(())
    }

    #[inline]
    fn push_all(&mut self, records: &[Record]) -> usize {
        let taken = self.push_alike(records);
        if taken == records.len() {
            return taken;
        }
        self.push_others(records, taken)
    }

    #[inline]
    fn pending(&self) -> Ticks {
        if !self.running {
            return 0;
        }
        let left = self.end.wrapping_sub(self.registers.now()).cast_signed();
        if left > 0 {
            return left.cast_unsigned().into();
        }
        // At least 1 until the last slot has been played.
        u64::from(!self.has_ended(self.newly_fetched()))
    }

    fn free(&self) -> usize {
        if !self.remainder.is_empty() {
            return 0;
        }
        MAX_SLOTS.saturating_sub(self.written.wrapping_sub(self.fetched)) as usize
    }
}

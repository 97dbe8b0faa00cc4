//! The side of the control tick: it puts records into the queue.

use core::fmt;
use core::marker::PhantomData;
use core::sync::atomic::Ordering;

use super::{Shared, StepTimer, ticks};
use crate::low;
use crate::{PulseSink, Record, Ticks};

/// Records on their way to the step interrupt. It belongs to a task of lower priority than that interrupt. Records of fewer
/// than 2³¹ ticks may wait at a time, and the timer's interrupt is never masked while the queue is used.
pub struct RecordQueue<'a, T> {
    pub(super) shared: &'a Shared,
    pushed: u32,
    position: i64,
    timer: PhantomData<fn() -> T>,
}

impl<T> fmt::Debug for RecordQueue<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RecordQueue")
            .field("shared", &self.shared)
            .finish_non_exhaustive()
    }
}

impl<'a, T: StepTimer> RecordQueue<'a, T> {
    pub(super) fn new(shared: &'a Shared) -> Self {
        Self {
            shared,
            pushed: 0,
            position: 0,
            timer: PhantomData,
        }
    }

    /// Pulses that began since the start, forward less reverse. To be asked before 2³¹ of them have passed unseen.
    pub fn position(&mut self) -> i64 {
        let counted = self.shared.position.load(Ordering::Relaxed);
        // The low half of what is known tells how far the counter has moved on since.
        let moved = counted.wrapping_sub(low::i32(self.position));
        self.position = self.position.wrapping_add(i64::from(moved));
        self.position
    }

    /// Ticks pushed and not played yet, modulo 2³².
    ///
    /// The interrupt may come between any two lines of this. It stops the train at most, for only [`PulseSink::push`] starts
    /// it, and that is called by the same task: so a train found running twice was running between, and `origin` is its own.
    /// When the interrupt moves the train back just then, or is about to, what is pending comes out too small by as much as
    /// the train is late, this one time.
    fn unplayed(&self) -> u32 {
        if self.shared.running.load(Ordering::Acquire) {
            let origin = self.shared.origin.load(Ordering::Relaxed);
            let played = T::now().wrapping_sub(origin);
            if self.shared.running.load(Ordering::Acquire) {
                let left = self.pushed.wrapping_sub(played).cast_signed();
                // The last period is over when its interrupt has said so.
                return left.max(1).cast_unsigned();
            }
        }
        let played = self.shared.played.load(Ordering::Relaxed);
        self.pushed.wrapping_sub(played)
    }

    /// Drops what has not been played; a pulse that has begun is cut short but counts. It is done when the interrupt that
    /// this raises has run, which is at once.
    pub fn drop_all(&mut self) {
        self.shared.drop.store(true, Ordering::Release);
        T::interrupt();
    }
}

impl<T: StepTimer> PulseSink for RecordQueue<'_, T> {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.shared.records.put(record)?;
        self.pushed = self.pushed.wrapping_add(ticks(&record));
        if !self.shared.running.load(Ordering::Acquire) {
            T::interrupt();
        }
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.unplayed().into()
    }

    fn free(&self) -> usize {
        usize::try_from(self.shared.records.free()).unwrap_or(0)
    }
}

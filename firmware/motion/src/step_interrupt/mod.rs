//! Step pulses one interrupt at a time, where there is no timer that plays records by itself.
//!
//! The control tick puts records into a [`RecordQueue`], which is the axis's [`PulseSink`](crate::PulseSink); the interrupt of
//! the step timer plays them with a [`Player`] on a [`StepTimer`], the only part a board has to bring. The interrupt counts the
//! pulses that left in [`Shared`], and says there by the timer's counter how much has been played.
//!
//! The contract:
//! - The timer is told one edge ahead and never repeats by itself: if the processor stands still, so does the motor.
//! - Edges come at the time the records say, whatever the latency of the interrupt. One that is more than a period late moves
//!   what follows of the train back; pulses are never pushed together and never left out.
//! - However late an edge comes, the signal stays high for the width of its record and low for the driver's time, and the
//!   driver's set-up time passes between a change of the direction signal and the next pulse.
//! - What is pending is exact to the tick, in the middle of a period too.
//! - The interrupt may come at any time without a reason.

mod player;
mod queue;
mod ring;
#[cfg(test)]
mod tests;

pub use player::{Edge, Player, StepTimer};
pub use queue::RecordQueue;
pub use ring::CAPACITY;

use core::sync::atomic::{AtomicBool, AtomicI32, AtomicU32};

use ring::Ring;

use crate::{DriverTiming, Record};

/// What the control tick and the step interrupt share.
#[derive(Debug)]
pub struct Shared {
    records: Ring,
    /// Pulses that began, forward less reverse; wraps.
    position: AtomicI32,
    /// While running: what the counter showed, or would have, with nothing played; wraps. The counter less this is what has
    /// been played, so one word tells it at every moment. It moves only when the train is late.
    origin: AtomicU32,
    /// While not running: ticks of all periods that were played or dropped; wraps.
    played: AtomicU32,
    /// A train is being played, so that the interrupt comes by itself. It is set after `origin` and cleared after `played`.
    running: AtomicBool,
    /// Everything that waits is to be dropped.
    drop: AtomicBool,
}

impl Shared {
    /// Nothing has happened.
    pub const fn new() -> Self {
        Self {
            records: Ring::new(),
            position: AtomicI32::new(0),
            origin: AtomicU32::new(0),
            played: AtomicU32::new(0),
            running: AtomicBool::new(false),
            drop: AtomicBool::new(false),
        }
    }
}

impl Default for Shared {
    fn default() -> Self {
        Self::new()
    }
}

/// Both ends: one for the control tick, one for the step interrupt. `timing` is what the driver needs; records keep it by
/// themselves, the player keeps it where an interrupt comes late.
pub fn split<T: StepTimer>(
    shared: &mut Shared,
    timer: T,
    timing: DriverTiming,
) -> (RecordQueue<'_, T>, Player<'_, T>) {
    // Each side exists once, for as long as the mutable borrow lasts.
    let shared = &*shared;
    (RecordQueue::new(shared), Player::new(shared, timer, timing))
}

/// Ticks of a whole record, modulo 2³² as the counters are.
fn ticks(record: &Record) -> u32 {
    record.period.wrapping_mul(u32::from(record.repeat))
}

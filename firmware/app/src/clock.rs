//! The time: microseconds since the start, in 64 bits.
//!
//! A counter of the board runs freely; each reading adds what has passed since the one before. So no interrupt has to
//! count, and none can be missed: it is enough that somebody reads the time before the counter comes round, which takes
//! seconds, and the control tick reads it every millisecond.

use core::cell::Cell;

use canopen::Instant;
use critical_section::Mutex;

use crate::board::{Board, Selected};

// Logs carry the same time.
defmt::timestamp!("{=u64:us}", now().ticks());

/// The counter at the last whole microsecond, and the time then.
static READING: Mutex<Cell<(u32, u64)>> = Mutex::new(Cell::new((0, 0)));

/// The time now. Any task may ask; it never goes back.
#[inline(never)]
pub fn now() -> Instant {
    critical_section::with(|alone| {
        let reading = READING.borrow(alone);
        let (counter, time) = reading.get();
        let passed = Selected::ticks().wrapping_sub(counter) / Selected::TICKS_PER_MICROSECOND;
        let time = time.wrapping_add(u64::from(passed));
        reading.set((
            counter.wrapping_add(passed * Selected::TICKS_PER_MICROSECOND),
            time,
        ));
        Instant::from_ticks(time)
    })
}

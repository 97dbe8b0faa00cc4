//! Between two clocks: microseconds, in which sync events are stamped, and the axis' own time, in ticks of the step timer.
//!
//! The time of the axis stands while it is at rest. So the two are compared anew whenever it begins to move, and in motion what is
//! read a little early or late is averaged out.

use motion::low;

use super::{MicrosQ16, POINT};

/// Readings farther apart than this many microseconds mean that the axis' time has stood.
const APART: u64 = 250;

/// Where the two clocks are in comparison.
#[derive(Debug)]
pub(crate) struct Timescale {
    /// Ticks in a microsecond, Q16.
    ticks_per_micro: u32,
    /// Microseconds in a tick, Q32.
    tick: u64,
    /// The axis' time less that of the microseconds, in ticks.
    ahead: u64,
    is_running: bool,
}

impl Timescale {
    /// For a step timer with this many ticks in a second.
    pub(crate) fn new(hz: u32) -> Self {
        Self {
            // Less than 2³² / 15.
            ticks_per_micro: low::u32((u64::from(hz) << POINT) / 1_000_000),
            tick: (1_000_000_u64 << 32).checked_div(hz.into()).unwrap_or(0),
            ahead: 0,
            is_running: false,
        }
    }

    /// The axis is at rest: its time stands.
    pub(crate) const fn stop(&mut self) {
        self.is_running = false;
    }

    /// It is tick `played` of the axis' time at `now`.
    pub(crate) fn compare(&mut self, now: MicrosQ16, played: u64) {
        let measured = played.wrapping_sub(self.whole(now));
        let apart = measured.wrapping_sub(self.ahead).cast_signed();
        let max = u64::from(self.ticks_per_micro).wrapping_mul(APART) >> POINT;
        self.ahead = if self.is_running && apart.unsigned_abs() <= max {
            self.ahead.wrapping_add_signed(apart >> 6)
        } else {
            measured
        };
        self.is_running = true;
    }

    /// The tick of the axis' time at this moment.
    pub(crate) fn tick_at(&self, moment: MicrosQ16) -> u64 {
        self.whole(moment).wrapping_add(self.ahead)
    }

    /// Ticks of the axis' time that a span lasts.
    pub(crate) fn ticks(&self, time: MicrosQ16) -> u32 {
        u32::try_from(self.whole(time)).unwrap_or(u32::MAX)
    }

    /// The span that so many ticks last.
    pub(crate) fn span(&self, ticks: u32) -> MicrosQ16 {
        u64::from(ticks).wrapping_mul(self.tick) >> (32 - POINT)
    }

    fn whole(&self, time: MicrosQ16) -> u64 {
        let ticks_per_micro = u64::from(self.ticks_per_micro);
        let low = (time & u64::from(u32::MAX)).wrapping_mul(ticks_per_micro) >> (2 * POINT);
        (time >> (2 * POINT))
            .wrapping_mul(ticks_per_micro)
            .wrapping_add(low)
    }
}

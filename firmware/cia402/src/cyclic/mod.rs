//! What the cyclic modes go by: the sync events of the network, and the set-points that come with it.
//!
//! Each SYNC, with the set-point that holds at it, is a [`SyncEvent`]. The sync events drive a phase-locked loop (`pll`), and what comes out of it
//! are slots: evenly spaced moments, each with its set-point or with none. A slot is decided on once, and what comes for it
//! later is not used.
//!
//! Without SYNC the set-points themselves are the sync events; but the data records of interpolated position have a clock of their own, as
//! a master may write several ahead.

mod buffer;
mod clock;
mod pipeline;
pub(crate) mod pll;
mod record_clock;
mod schedule;
mod sync_event;
mod timer;
mod timescale;

pub(crate) use buffer::Buffer;
pub use buffer::{BufferConfiguration, RECORDS};
pub(crate) use clock::{NetworkClock, Slot, Slots};
pub(crate) use pipeline::Pipeline;
pub(crate) use record_clock::RecordClock;
pub(crate) use schedule::Schedule;
pub use sync_event::SyncEvent;
pub use timer::TickTimer;
pub(crate) use timescale::Timescale;

use canopen::Instant;

use crate::objects::Objects;

/// A time or a moment in microseconds × 2¹⁶. As a moment it wraps after nine years.
pub type MicrosQ16 = u64;

/// The bits of [`MicrosQ16`] behind the point.
pub(crate) const POINT: u32 = 16;

/// A moment in this unit.
pub(crate) const fn micros_q16(at: Instant) -> MicrosQ16 {
    at.ticks() << POINT
}

/// The time from one moment to a later one; negative if it is earlier.
pub(crate) const fn span(from: MicrosQ16, to: MicrosQ16) -> i64 {
    to.wrapping_sub(from).cast_signed()
}

/// How the cyclic modes are set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CyclicConfiguration {
    /// 60C0h = −1: cubic interpolation, and not linear.
    pub is_cubic: bool,
    /// 60C2h in microseconds, 1000 to 2,000,000.
    pub period: u32,
    /// Nobody has written 60C2h: set-points come with each SYNC, however far apart those are.
    pub is_measured: bool,
    /// 1006h in microseconds; 0 if it is not known.
    pub cycle: u32,
    /// 60C4h.
    pub buffer: BufferConfiguration,
    /// 2051h.
    pub lost: LostSetPoints,
}

/// What becomes of set-points that do not come (2051h).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LostSetPoints {
    /// 2051h:1: so many in a row are bridged at the velocity before.
    pub bridged: u8,
    /// 2051h:2: 0 the motor stops, 1 it is a fault as well (8250h), 2 the last set-point holds.
    pub reaction: u8,
}

impl LostSetPoints {
    /// A set-point that does not come is the one before.
    pub(crate) const fn is_as_before(self) -> bool {
        self.reaction == 2
    }

    /// More of them missing than are bridged is a fault.
    pub(crate) const fn is_fault(self) -> bool {
        self.reaction == 1
    }
}

impl CyclicConfiguration {
    /// What holds before anything is set up.
    pub const NONE: Self = Self {
        is_cubic: false,
        period: 1_000,
        is_measured: true,
        cycle: 0,
        buffer: BufferConfiguration::NONE,
        lost: LostSetPoints {
            bridged: 2,
            reaction: 1,
        },
    };

    /// How far apart set-points and SYNCs should be; 0 where nobody has said so.
    pub(crate) const fn periods(&self) -> (MicrosQ16, MicrosQ16) {
        let cycle = (self.cycle as MicrosQ16) << POINT;
        let period = if self.is_measured {
            cycle
        } else {
            (self.period as MicrosQ16) << POINT
        };
        (period, cycle)
    }

    /// What the objects of a dictionary say.
    pub(crate) fn of<D: Objects>(dictionary: &D) -> Self {
        let value = u32::from(dictionary.interpolation_time_value());
        let power = 10_u32
            .checked_pow(6_u32.saturating_add_signed(dictionary.interpolation_time_index().into()));
        let period = power.map_or(u32::MAX, |power| value.saturating_mul(power));
        Self {
            is_cubic: dictionary.interpolation_sub_mode() < 0,
            period: period.clamp(1_000, 2_000_000),
            is_measured: false,
            cycle: 0,
            buffer: BufferConfiguration {
                size: dictionary.interpolation_buffer_size(),
                is_ring: dictionary.interpolation_buffer_organization() == 1,
                is_open: dictionary.interpolation_buffer_clear() != 0,
            },
            lost: LostSetPoints {
                bridged: dictionary.bridged_set_points(),
                reaction: dictionary.lost_set_point_reaction(),
            },
        }
    }
}

/// [`SyncStatus::state`] of a loop that is locked.
pub const LOCKED: u8 = 2;

/// What a master may know of the sync events (2050h), and of the buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SyncStatus {
    /// 2050h:1: 0 no sync events, 1 the loop is settling, 2 locked.
    pub state: u8,
    /// 2050h:2 in nanoseconds.
    pub period: u32,
    /// 2050h:3 in nanoseconds: how far sync events are from their moments, on average.
    pub jitter: u32,
    /// 2050h:4: sync events that did not come.
    pub missed: u32,
    /// 2050h:5: sync events too far from their moment to be measured by.
    pub rejected: u32,
    /// 2050h:6: set-points that did not come in time while the motor moved.
    pub lost_set_points: u32,
    /// 2050h:7 in microseconds: from a SYNC to the moment at which the motor is at its set-point.
    pub latency: u32,
    /// 60C4h:4: records that wait.
    pub buffered: u16,
}

impl SyncStatus {
    /// Before the first sync event.
    pub const NONE: Self = Self {
        state: 0,
        period: 0,
        jitter: 0,
        missed: 0,
        rejected: 0,
        lost_set_points: 0,
        latency: 0,
        buffered: 0,
    };
}

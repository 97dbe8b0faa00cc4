//! Pulse-train records: what a step timer is to play, and the interface that takes them.

use crate::Ticks;
use crate::iterations::Iterations;

/// Which way a step goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Towards larger positions.
    Forward,
    /// Towards smaller positions.
    Reverse,
}

impl Direction {
    /// +1 or −1: what one pulse adds to the position.
    pub const fn sign(self) -> i32 {
        match self {
            Self::Forward => 1,
            Self::Reverse => -1,
        }
    }

    /// The other direction.
    #[must_use]
    pub const fn reversed(self) -> Self {
        match self {
            Self::Forward => Self::Reverse,
            Self::Reverse => Self::Forward,
        }
    }
}

/// The shortest record, in ticks: half a microsecond at 168 MHz, so that an advanced timer has loaded the next one when it
/// ends ([`crate::advanced_timer`]).
pub const SHORTEST_RECORD: u32 = 84;

/// `repeat` timer periods of `period` ticks each, each beginning with a pulse of `width` ticks; a width of 0 is silence.
///
/// On an advanced timer one DMA burst writes five words for it: prescaler, auto-reload, repetition counter and two compares.
/// The direction differs from that of the record before only in a silent record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Length of one period in ticks, at least the driver's shortest ([`DriverTiming::shortest_period`]).
    pub period: u32,
    /// How many periods, at least 1.
    pub repeat: u16,
    /// Ticks of the step signal being high; 0 in a silent record.
    pub width: u16,
    /// Level of the direction signal from the beginning of this record.
    pub direction: Direction,
}

impl Record {
    /// A record of no periods, in place of one that is not there yet.
    pub(crate) const NONE: Self = Self {
        period: 0,
        repeat: 0,
        width: 0,
        direction: Direction::Forward,
    };

    /// How long the record takes, in ticks.
    pub fn ticks(&self) -> Ticks {
        u64::from(self.period).wrapping_mul(u64::from(self.repeat))
    }

    /// What the record adds to the position, in steps.
    pub fn steps(&self) -> i32 {
        if self.width == 0 {
            0
        } else {
            i32::from(self.repeat).wrapping_mul(self.direction.sign())
        }
    }
}

impl From<Direction> for i64 {
    fn from(direction: Direction) -> Self {
        direction.sign().into()
    }
}

/// Where records go: a DMA ring, the queue of an interrupt, a simulated motor.
pub trait PulseSink {
    /// Takes a record, to be played after all those before.
    ///
    /// # Errors
    /// The record itself when there is no room; it will be offered again.
    fn push(&mut self, record: Record) -> Result<(), Record>;

    /// Takes records one behind the other, as long as there is room, and gives how many it has taken.
    #[inline]
    fn push_all(&mut self, records: &[Record]) -> usize {
        let mut taken = 0;
        let mut iterations = Iterations::for_each(records);
        while let Some(record) = records.get(taken)
            && self.push(*record).is_ok()
        {
            iterations.count();
            taken = taken.wrapping_add(1);
        }
        taken
    }

    /// Ticks of the records taken that have not been played yet.
    fn pending(&self) -> Ticks;

    /// Room left, in records.
    fn free(&self) -> usize;
}

impl<S: PulseSink + ?Sized> PulseSink for &mut S {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        (**self).push(record)
    }

    fn push_all(&mut self, records: &[Record]) -> usize {
        (**self).push_all(records)
    }

    fn pending(&self) -> Ticks {
        (**self).pending()
    }

    fn free(&self) -> usize {
        (**self).free()
    }
}

/// What the stepper driver's inputs need, in ticks (from its datasheet). Larger values than a timer can do are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DriverTiming {
    /// Shortest time of the step signal being high: 1 ..= 32767. The advanced timer's counter sees 4 or more, and so it does for
    /// `pulse_low`; [`Nanoseconds`](crate::Nanoseconds) never give less.
    pub pulse_high: u32,
    /// Shortest time of the step signal being low, at least 1. Take more where records need time to be loaded:
    /// no record is shorter than `pulse_high + pulse_low`.
    pub pulse_low: u32,
    /// From a change of direction to the next pulse.
    pub direction_setup: u32,
    /// From the end of a pulse to a change of direction.
    pub direction_hold: u32,
}

impl DriverTiming {
    /// Longest of each of these times. A tenth of a second at 168 MHz: far more than any driver needs.
    const LONGEST: u32 = 1 << 24;

    /// The widest pulse: half of what a timer of 16 bits can do, so that a longer period has two parts with the pulse in one.
    const WIDEST: u32 = i16::MAX as u32;

    /// Each time brought into its range.
    #[inline(never)]
    pub(crate) fn checked(self) -> Self {
        Self {
            pulse_high: self.pulse_high.clamp(1, Self::WIDEST),
            pulse_low: self.pulse_low.clamp(1, Self::LONGEST),
            direction_setup: self.direction_setup.min(Self::LONGEST),
            direction_hold: self.direction_hold.min(Self::LONGEST),
        }
    }

    /// The shortest period between two pulses, in ticks: `pulse_high + pulse_low`, at least 2.
    pub fn shortest_period(&self) -> u32 {
        let checked = self.checked();
        checked.pulse_high.saturating_add(checked.pulse_low)
    }
}

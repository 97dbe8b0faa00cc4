//! TIME (CiA 301, 7.2.6; object 1012h): the time of day of the network, in one frame of six bytes.
//!
//! The first four bytes are the milliseconds after midnight, the other two the days since 1 January 1984. Bit 31 of 1012h makes the
//! device a consumer, bit 30 a producer.
//!
//! The contract:
//! - The device keeps the time of day that it has heard, or that the firmware has set, and lets it run on. Before that it
//!   knows none.
//! - A frame of another length, or with more milliseconds than a day has, is ignored.
//! - A producer sends TIME when the firmware asks for it, never by itself: CiA 301 has no period for it.
//! - The time of day outlives resets: it is no parameter.

use crate::od::{self, Dictionary};
use crate::time::Instant;
use crate::wire::cob_id::CobId;

/// Index of the object COB-ID TIME.
pub const COB_ID: u16 = 0x1012;

/// Bit 31 of 1012h: the device consumes TIME.
const CONSUME: u32 = 1 << 31;
/// Bit 30 of 1012h: the device produces TIME.
const PRODUCE: u32 = 1 << 30;

/// There is none. It is that of NMT, which is nobody's to choose.
const NOT_IN_USE: u16 = 0;

/// Milliseconds of a day.
const DAY: u32 = 24 * 60 * 60 * 1000;

/// A moment of the calendar, as TIME_OF_DAY of CiA 301 (7.1.6.5) counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimeOfDay {
    days: u16,
    milliseconds: u32,
}

impl TimeOfDay {
    /// `days` since 1 January 1984 and `milliseconds` after midnight; `None` if a day does not have so many.
    pub const fn new(days: u16, milliseconds: u32) -> Option<Self> {
        if milliseconds < DAY {
            Some(Self { days, milliseconds })
        } else {
            None
        }
    }

    /// Days since 1 January 1984.
    pub const fn days(self) -> u16 {
        self.days
    }

    /// Milliseconds after midnight, 0 to 86,399,999.
    pub const fn milliseconds(self) -> u32 {
        self.milliseconds
    }

    /// The six bytes of a TIME frame; `None` if they are more milliseconds than a day has. Their four highest bits are
    /// reserved and not looked at.
    pub const fn from_bytes(bytes: [u8; 6]) -> Option<Self> {
        let [a, b, c, d, low, high] = bytes;
        let milliseconds = u32::from_le_bytes([a, b, c, d & 0x0F]);
        Self::new(u16::from_le_bytes([low, high]), milliseconds)
    }

    /// As it travels.
    pub const fn to_bytes(self) -> [u8; 6] {
        let [a, b, c, d] = self.milliseconds.to_le_bytes();
        let [low, high] = self.days.to_le_bytes();
        [a, b, c, d, low, high]
    }

    /// So many microseconds later. The calendar ends in 2163 and begins again.
    const fn after(self, microseconds: u64) -> Self {
        let (milliseconds, _) = divide(microseconds, 1000);
        let total = milliseconds.saturating_add(self.milliseconds as u64);
        let (days, milliseconds) = divide(total, DAY);
        Self {
            days: self.days.wrapping_add(days as u16),
            milliseconds,
        }
    }
}

/// Quotient and remainder, bit by bit: a division of 64 bits by the run-time library would take a kilobyte for the sake of it.
#[inline(never)]
const fn divide(number: u64, by: u32) -> (u64, u32) {
    let (mut quotient, mut rest, mut bit) = (0, 0, 64_u32);
    while bit > 0 {
        bit -= 1;
        rest = rest << 1 | number >> bit & 1;
        quotient <<= 1;
        if rest >= by as u64 {
            rest -= by as u64;
            quotient |= 1;
        }
    }
    (quotient, rest as u32)
}

/// The TIME producer and consumer of a device, and its clock.
#[derive(Debug)]
pub struct TimeStamp {
    cob_id: u16,
    is_consumer: bool,
    is_producer: bool,
    /// What the time was when.
    clock: Option<(TimeOfDay, Instant)>,
}

impl TimeStamp {
    /// Neither consumer nor producer until [`TimeStamp::configure`], and without a time of day.
    pub const fn new() -> Self {
        Self {
            cob_id: NOT_IN_USE,
            is_consumer: false,
            is_producer: false,
            clock: None,
        }
    }

    /// Takes 1012h, after power-on values were loaded and when it was written; a device without 1012h has no TIME.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D) {
        let cob_id = CobId(od::fixed::<D, COB_ID, 0>(dictionary).unwrap_or(0));
        let is_used = cob_id.is_base_frame() && cob_id.0 & (CONSUME | PRODUCE) != 0;
        self.is_consumer = is_used && cob_id.0 & CONSUME != 0;
        self.is_producer = is_used && cob_id.0 & PRODUCE != 0;
        self.cob_id = if is_used {
            cob_id.identifier()
        } else {
            NOT_IN_USE
        };
    }

    /// The identifier of TIME; above 7FFh when it is not used.
    pub const fn cob_id(&self) -> u16 {
        self.cob_id
    }

    /// Whether this device takes the time of day from others.
    pub const fn is_consumer(&self) -> bool {
        self.is_consumer
    }

    /// Whether this device may send TIME.
    pub const fn is_producer(&self) -> bool {
        self.is_producer
    }

    /// A TIME frame arrived at `now`; one that has no time of day does nothing.
    pub fn receive(&mut self, payload: &[u8], now: Instant) {
        let heard = payload.try_into().ok().and_then(TimeOfDay::from_bytes);
        if let Some(time) = heard {
            self.set(time, now);
        }
    }

    /// It is this time of day now.
    pub fn set(&mut self, time: TimeOfDay, now: Instant) {
        self.clock = Some((time, now));
    }

    /// The time of day; `None` before it was heard or set.
    pub fn get(&self, now: Instant) -> Option<TimeOfDay> {
        let (time, at) = self.clock?;
        let passed = now.ticks().saturating_sub(at.ticks());
        Some(time.after(passed))
    }
}

impl Default for TimeStamp {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Instant {
        Instant::from_ticks(milliseconds * 1000)
    }

    #[test]
    fn t01_six_bytes_are_taken_and_anything_else_is_not() {
        let mut time = TimeStamp::new();
        for payload in [&[][..], &[1, 0], &[0; 5], &[0; 7], &[0xFF; 6]] {
            time.receive(payload, at(0));
            assert_eq!(time.get(at(0)), None, "{payload:02X?}");
        }
        time.receive(&[1, 0, 0, 0xF0, 2, 0], at(0));
        assert_eq!(time.get(at(0)), TimeOfDay::new(2, 1));
    }

    #[test]
    fn t01_the_time_of_day_runs_on_over_midnight() {
        let mut time = TimeStamp::new();
        time.set(TimeOfDay::new(9, DAY - 1).unwrap(), at(5_000));
        assert_eq!(time.get(at(5_000)), TimeOfDay::new(9, DAY - 1));
        assert_eq!(time.get(at(5_001)), TimeOfDay::new(10, 0));
        assert_eq!(
            time.get(at(5_001 + 3 * u64::from(DAY))),
            TimeOfDay::new(13, 0)
        );
        assert_eq!(
            time.get(at(0)),
            TimeOfDay::new(9, DAY - 1),
            "a stamp from before"
        );
        assert_eq!(TimeOfDay::new(0, DAY), None);
    }

    #[test]
    fn what_is_written_is_read_back() {
        for (days, milliseconds) in [(0, 0), (1, DAY - 1), (u16::MAX, 0x0102_0304)] {
            let time = TimeOfDay::new(days, milliseconds).unwrap();
            assert_eq!(TimeOfDay::from_bytes(time.to_bytes()), Some(time));
        }
    }
}

//! The inputs of the Nanotec: each is debounced by itself (2008h), and the analogue one may call for its PDO (6423h to 6428h).

use canopen::od::Dictionary;
use cia402::behaviour::{number, put_number};

/// The analogue input, and where the converter itself shows.
const ANALOGUE: u16 = 0x6401;
const CONVERTER: u16 = 0x2003;

/// Digital inputs in 60FDh.
const DIGITAL: u16 = 0x60FD;
const FIRST: u32 = 16;

/// An edge counts at once, and for the time of 2008h no other one of its input does.
#[derive(Debug, Default)]
pub(super) struct Debounce {
    shown: u8,
    /// Until when edges are passed over, in microseconds.
    quiet: [u64; 6],
}

impl Debounce {
    /// The wires, as they are in a control tick at this time.
    pub(super) fn look<D: Dictionary>(&mut self, dictionary: &D, wires: u8, at: u64) {
        let time = u64::try_from(number(dictionary, 0x2008, 0)).unwrap_or(0) * 1_000;
        let mut bit = 1;
        for quiet in &mut self.quiet {
            if (self.shown ^ wires) & bit != 0 && at >= *quiet {
                self.shown ^= bit;
                *quiet = at.saturating_add(time);
            }
            bit <<= 1;
        }
    }

    pub(super) fn show<D: Dictionary>(&self, dictionary: &mut D) {
        let word = number(dictionary, DIGITAL, 0) & 0xFFFF;
        let inputs = i64::from(self.shown) << FIRST;
        put_number(dictionary, DIGITAL, 0, word | inputs);
    }
}

/// What transmit PDOs were last told of the analogue input.
#[derive(Debug, Default)]
pub(super) struct Trigger {
    told: i64,
}

impl Trigger {
    /// Whoever reads sees the input as it is; PDOs that look for changes see one when it is to be told.
    pub(super) fn show<D: Dictionary>(&mut self, dictionary: &mut D, serves_frame: bool) {
        let now = number(dictionary, CONVERTER, 3);
        if !serves_frame && self.is_worth_telling(dictionary, now) {
            self.told = now;
        }
        let shown = if serves_frame { now } else { self.told };
        put_number(dictionary, ANALOGUE, 1, shown);
    }

    fn is_worth_telling<D: Dictionary>(&self, dictionary: &D, now: i64) -> bool {
        let [upper, lower, delta] =
            [0x6424, 0x6425, 0x6426].map(|index| number(dictionary, index, 1));
        let change = now - self.told;
        let directed = number(dictionary, if change < 0 { 0x6427 } else { 0x6428 }, 1);
        // Limits that are equal bound nothing.
        let is_in_range = match upper - lower {
            0 => true,
            1.. => now < lower || now > upper,
            _ => now > upper && now < lower,
        };
        number(dictionary, 0x6423, 0) == 1 && is_in_range && change.abs() > delta.max(directed)
    }
}

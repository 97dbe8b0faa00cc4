//! Position registers, virtual inputs and outputs, and the table of speeds that inputs choose from.
//!
//! The manual has names alone. Chosen:
//! - Position register n is 5108h:n, in the user's units, and enabled by bit n − 1 of 5109h; WPOS and WPOSE show which are. Its bit of POSRSTAT is 1 from its
//!   position on, with its bit of WPOSP before it; with its bit of WPOSX it stays 1 until POSRSTAT is written. 1002h shows the first six.
//! - IN5 to IN20 are written by a master; they are channels 36F5h ff, three for each, as IN20MODE and IN20TRIG are told. INnMODE 16 starts motion task INnTRIG with
//!   the rising edge, 22 stops it. O3 to O18 lie behind them: OnMODE compares with OnTRIG as O1MODE does; with 0 a master writes them.
//! - INxMODE 35: inputs IN1 to IN4 with it are the bits of a number, from the first on, that chooses a speed of 510Ah in mode 80h; with 0 it is 60FFh. An entry of 0 is
//!   n15, and the motor stands.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{number, put_number};
use cia402::commands::Commands;
use cia402::units::Units;

use super::Seen;
use super::modes::{DIGITAL_VELOCITY, chosen, per_minute};
use super::status::level;

/// 2000h: n15.
const TABLE: i64 = 1 << 14;

/// IN5, and the three channels of each.
const INPUTS: u16 = 0x36F5;
const OUTPUTS: u16 = 0x3725;
const COUNT: u16 = 16;
/// The modes of IN1 to IN4.
const MODES: [u16; 4] = [0x3562, 0x3565, 0x3568, 0x356B];

/// What a virtual input asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Call {
    /// A motion task is to start.
    Start(u16),
    /// It is to stop.
    Stop,
}

/// The registers and what is chosen.
#[derive(Debug, Default)]
pub(super) struct Registers {
    /// Position registers that are on.
    pub(super) state: u16,
    /// Virtual inputs that are on, and virtual outputs that compare.
    inputs: u16,
    compares: u16,
    /// The speed of the table in 1/min, if inputs choose one.
    speed: Option<i64>,
    /// Bits of 2000h.
    pub(super) warnings: i64,
}

/// Number and place among its three channels.
fn virtual_channel(first: u16, entry: &Entry) -> Option<(u16, u16)> {
    let place = entry.index.checked_sub(first)?;
    (place < 3 * COUNT && entry.sub == 1).then_some((place / 3, place % 3))
}

pub(super) fn check(entry: &Entry, value: i64) -> Result<(), AbortCode> {
    let is_known = match (
        virtual_channel(INPUTS, entry),
        virtual_channel(OUTPUTS, entry),
    ) {
        (Some((_, 0)), _) | (_, Some((_, 0))) => (0..=1).contains(&value),
        // That of IN20 is gearing's.
        (Some((0..=14, 1)), _) => [0, 16, 22].contains(&value),
        (_, Some((_, 1))) => [0, 1, 2, 6, 16].contains(&value),
        _ => true,
    };
    is_known.then_some(()).ok_or(AbortCode::InvalidValue)
}

impl Registers {
    pub(super) fn written<D: Dictionary>(&mut self, dictionary: &D, entry: &Entry) -> Option<Call> {
        let value = number(dictionary, entry.index, entry.sub);
        if (entry.index, entry.sub) == (0x3643, 1) {
            self.state = value as u16;
        }
        if let Some((output, 1)) = virtual_channel(OUTPUTS, entry) {
            self.compares = self.compares & !(1 << output) | u16::from(value != 0) << output;
        }
        let (input, 0) = virtual_channel(INPUTS, entry)? else {
            return None;
        };
        let rises = value != 0 && self.inputs >> input & 1 == 0;
        self.inputs = self.inputs & !(1 << input) | u16::from(value != 0) << input;
        let trigger = u16::try_from(number(dictionary, entry.index + 2, 1)).unwrap_or(0);
        match number(dictionary, entry.index + 1, 1) {
            16 if rises => Some(Call::Start(trigger)),
            22 if rises => Some(Call::Stop),
            _ => None,
        }
    }

    /// A tick has passed. Returns whether the commands are others now.
    pub(super) fn tick<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen) -> bool {
        let enabled = number(dictionary, 0x5109, 0);
        if enabled != 0 || self.state != 0 {
            self.compare(dictionary, seen, enabled as u16);
        }
        let warnings = number(dictionary, 0x2000, 0);
        for output in (0..COUNT).filter(|output| self.compares >> output & 1 == 1) {
            let index = OUTPUTS + 3 * output;
            let (mode, trigger) = (
                number(dictionary, index + 1, 1),
                number(dictionary, index + 2, 1),
            );
            if let Some(level) = level(mode, trigger, seen, warnings) {
                put_number(dictionary, index, 1, level.into());
            }
        }
        let before = self.speed;
        self.speed = self.choose(dictionary, seen);
        self.warnings = if self.speed == Some(0) { TABLE } else { 0 };
        before != self.speed
    }

    fn compare<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen, enabled: u16) {
        let polarity = number(dictionary, 0x3640, 1) as u16;
        let stays = number(dictionary, 0x3641, 1) as u16;
        let mut levels = 0;
        for register in (0..16_u8).filter(|register| enabled >> register & 1 == 1) {
            let position = number(dictionary, 0x5108, register + 1);
            levels |= u16::from(i64::from(seen.position) >= position) << register;
        }
        self.state = ((levels ^ polarity) | self.state & stays) & enabled;
        for (index, word) in [(0x3643, self.state), (0x3636, enabled), (0x363F, enabled)] {
            put_number(dictionary, index, 1, word.into());
        }
    }

    fn choose<D: Dictionary>(&self, dictionary: &D, seen: &Seen) -> Option<i64> {
        if chosen(dictionary) != DIGITAL_VELOCITY {
            return None;
        }
        let (mut number_of_entry, mut bit) = (0_u8, 0);
        for (input, mode) in MODES.into_iter().enumerate() {
            if number(dictionary, mode, 1) == 35 {
                number_of_entry |= ((seen.inputs >> (16 + input) & 1) as u8) << bit;
                bit += 1;
            }
        }
        (number_of_entry != 0).then(|| number(dictionary, 0x510A, number_of_entry))
    }

    pub(super) fn command(&self, units: &Units, commands: &mut Commands) {
        if let Some(speed) = self.speed {
            commands.target_velocity = per_minute(speed, units);
        }
    }
}

//! What feeds the drive and what it bears: bus voltage, regeneration, mains, temperatures.
//!
//! The manual has names alone. Chosen:
//! - VBUSBAL is the line voltage in volts; VBUSMAX, one and a half times as much, is where the bus is too high (F02). The regeneration resistor is on
//!   from nine tenths of that. 0 is none of this.
//! - PBALRES 0 is a resistor of 33 Ω, 1 one of 15 Ω. PBAL is its power in watts, the mean of about a second: beyond PBALMAX n02, beyond
//!   one and a half times that F18.
//! - UVLTMODE 1 reports under-voltage, F05, also while the motor has no power. NONBTB 0 checks that there is mains where the motor is about to
//!   get power, F16. PMODE 1 warns of a missing phase, n05, which the board has to tell (3130h); 2 makes F16 of it.
//! - MAXTEMPE, MAXTEMPM and MTempLimit are degrees, 0 is none. The one sensor of the board stands for the ambient one. ANCNFG 8 makes the analogue input that of
//!   the motor, 10 mV a degree, shown by MTemp. MTempLimitPol 1 makes a fault of less than the limit.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{number, put_number};
use cia402::statusword::VOLTAGE_ENABLED;

use super::Seen;

/// 2000h: n02 and n05.
const REGENERATION: i64 = 1 << 1;
const PHASE: i64 = 1 << 4;

const NO_MAINS: u16 = 0x3100;
const UNDER_VOLTAGE: u16 = 0x3220;
const AMBIENT: u16 = 0x4110;
const MOTOR: u16 = 0x4310;
const BALLAST: u16 = 0x5420;

const READY: u16 = 0x21;

/// The supply as it was in the last tick.
#[derive(Debug, Default)]
pub(super) struct Supply {
    /// Mean power of the regeneration resistor in milliwatts.
    power: i64,
    pub(super) fault: Option<u16>,
    /// Bits of 2000h.
    pub(super) warnings: i64,
}

pub(super) fn check(entry: &Entry, value: i64) -> Result<(), AbortCode> {
    let is_known = match (entry.index, entry.sub) {
        (0x35C2 | 0x3617 | 0x35AA | 0x3B72, 1) => (0..=1).contains(&value),
        (0x35CD, 1) => (0..=2).contains(&value),
        _ => true,
    };
    is_known.then_some(()).ok_or(AbortCode::InvalidValue)
}

/// Whether n05 is to be told.
fn watches_phases<D: Dictionary>(dictionary: &D) -> bool {
    number(dictionary, 0x35CD, 1) == 1
}

/// Bits of 2000h that the drive has set and that are not to be told.
pub(super) fn hidden<D: Dictionary>(dictionary: &D) -> i64 {
    if watches_phases(dictionary) { 0 } else { PHASE }
}

/// VBUSBAL. Returns whether a threshold is another one now.
pub(super) fn written<D: Dictionary>(dictionary: &mut D, entry: &Entry) -> bool {
    if (entry.index, entry.sub) != (0x361B, 1) {
        return false;
    }
    let most = number(dictionary, 0x361B, 1).saturating_mul(3) / 2;
    put_number(dictionary, 0x361C, 1, most);
    put_number(dictionary, 0x5107, 0, most.saturating_mul(1_000));
    true
}

impl Supply {
    /// A tick has passed, so many microseconds behind the one before.
    pub(super) fn tick<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen, elapsed: u32) {
        let voltage = number(dictionary, 0x361A, 1);
        self.regenerate(dictionary, voltage, elapsed);
        let most = number(dictionary, 0x35C1, 1).saturating_mul(1_000);
        let is_beyond = |limit: i64| limit != 0 && self.power >= limit;
        self.warnings = if is_beyond(most) { REGENERATION } else { 0 };
        let has_mains = seen.statusword & VOLTAGE_ENABLED != 0;
        let is_cut =
            number(dictionary, 0x2000, 0) & PHASE != 0 && number(dictionary, 0x35CD, 1) == 2;
        let is_low = number(dictionary, 0x3617, 1) == 1 && voltage < number(dictionary, 0x361D, 1);
        let is_checked = number(dictionary, 0x35AA, 1) == 0;
        let is_ready = seen.statusword & 0x6F == READY;
        self.fault = if is_beyond(most.saturating_mul(3) / 2) {
            Some(BALLAST)
        } else if is_cut || is_checked && is_ready && !has_mains {
            Some(NO_MAINS)
        } else if is_low && !seen.has_power {
            Some(UNDER_VOLTAGE)
        } else {
            heat(dictionary)
        };
    }

    fn regenerate<D: Dictionary>(&mut self, dictionary: &mut D, voltage: i64, elapsed: u32) {
        let most = number(dictionary, 0x361C, 1);
        let is_on = most != 0 && voltage.saturating_mul(10) >= most.saturating_mul(9);
        let resistor = match number(dictionary, 0x35C2, 1) {
            1 => 15,
            _ => 33,
        };
        let power = if is_on {
            voltage.saturating_mul(voltage).saturating_mul(1_000) / resistor
        } else {
            0
        };
        let elapsed = i64::from(elapsed.min(1_000_000));
        let change = (power - self.power).saturating_mul(elapsed) / 1_000_000;
        // The last of it goes in small steps.
        self.power += if change == 0 {
            (power - self.power).signum()
        } else {
            change
        };
        put_number(dictionary, 0x35C0, 1, self.power / 1_000);
    }
}

fn heat<D: Dictionary>(dictionary: &mut D) -> Option<u16> {
    let ambient = number(dictionary, 0x3584, 1);
    if ambient != 0 && number(dictionary, 0x3B6A, 1) >= ambient {
        return Some(AMBIENT);
    }
    if number(dictionary, 0x3507, 1) != 8 {
        return None;
    }
    let motor = number(dictionary, 0x3509, 1) / 10;
    put_number(dictionary, 0x3B40, 1, motor);
    let most = number(dictionary, 0x3586, 1);
    let limit = number(dictionary, 0x3B71, 1);
    let is_beyond = match number(dictionary, 0x3B72, 1) {
        1 => motor < limit,
        _ => motor > limit,
    };
    let is_hot = most != 0 && motor >= most || limit != 0 && is_beyond;
    is_hot.then_some(MOTOR)
}

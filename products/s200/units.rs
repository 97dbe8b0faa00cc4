//! User units: what PUNIT, VUNIT and ACCUNIT make of velocities and accelerations, and the speeds that are in turns a minute whatever they say.
//!
//! A position unit is PGEARO turns in PGEARI; with PUNIT n it is 10^-n m. The formula of 6094h is not printed: position units/s are velocity
//! units times 6094h:1 and by 6094h:2, which VUNIT sets and a master may set otherwise. 6097h is what is left to the unit of ACCUNIT, which
//! is one of position units or of radians of the motor.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{number, put_number};

use super::Seen;

const PUNIT: u16 = 0x3660;
const VUNIT: u16 = 0x365F;
const ACCUNIT: u16 = 0x3659;
/// PGEARI and PGEARO.
const RESOLUTION: [u16; 2] = [0x35CA, 0x35CB];

/// Actual velocities in 1/min.
const SPEEDS: [u16; 4] = [0x3618, 0x35D7, 0x3B62, 0x3B8B];
const DEMAND: u16 = 0x361E;

pub(super) fn check(entry: &Entry, value: i64, seen: &Seen) -> Result<(), AbortCode> {
    let is_known = match (entry.index, entry.sub) {
        (PUNIT, 1) => (0..=9).contains(&value),
        (VUNIT, 1) => [0, 1, 5, 6, 7, 8].contains(&value),
        (ACCUNIT, 1) => [1, 3, 4, 5].contains(&value),
        _ => return Ok(()),
    };
    if !is_known {
        return Err(AbortCode::InvalidValue);
    }
    if seen.has_power {
        return Err(AbortCode::DeviceState);
    }
    Ok(())
}

/// Returns whether units are others now.
pub(super) fn written<D: Dictionary>(dictionary: &mut D, entry: &Entry) -> bool {
    let is_named = matches!(entry.index, PUNIT | VUNIT | ACCUNIT) && entry.sub == 1;
    let is_resolution = RESOLUTION.contains(&entry.index);
    if !is_named && !is_resolution && entry.index != 0x6094 {
        return false;
    }
    if is_named {
        show_units(dictionary);
    }
    // Without a unit of velocities 6094h is the master's.
    let is_of_it = is_resolution && number(dictionary, VUNIT, 1) != 0;
    if matches!(entry.index, PUNIT | VUNIT) || is_of_it {
        let [turns, units] = RESOLUTION.map(|index| number(dictionary, index, 1));
        let metre = power(number(dictionary, PUNIT, 1));
        let unit = match number(dictionary, VUNIT, 1) {
            1 => (turns, units.saturating_mul(60)),
            5 => (metre, 1),
            6 => (metre, 60),
            7 => (metre, 1_000),
            8 => (metre, 60_000),
            _ => (1, 1),
        };
        put(dictionary, 0x6094, unit);
    }
    let [turns, units] = RESOLUTION.map(|index| number(dictionary, index, 1));
    let metre = power(number(dictionary, PUNIT, 1));
    let unit = match number(dictionary, ACCUNIT, 1) {
        // 2 pi are 710/113.
        1 => (turns.saturating_mul(113), units.saturating_mul(710)),
        4 => (metre, 1_000),
        5 => (metre, 1),
        _ => (1, 1),
    };
    let velocity = [1, 2].map(|sub| number(dictionary, 0x6094, sub));
    put(
        dictionary,
        0x6097,
        (
            unit.1.saturating_mul(velocity[0]),
            unit.0.saturating_mul(velocity[1]),
        ),
    );
    true
}

/// 10^n.
fn power(exponent: i64) -> i64 {
    let exponent = u32::try_from(exponent.clamp(0, 9)).unwrap_or(0);
    10_i64.pow(exponent)
}

/// A fraction of two numbers of 32 bits: in lowest terms, and if that has more, as near as they are.
fn put<D: Dictionary>(dictionary: &mut D, index: u16, (numerator, divisor): (i64, i64)) {
    let (mut common, mut rest) = (numerator, divisor);
    while rest != 0 {
        (common, rest) = (rest, common.checked_rem(rest).unwrap_or(0));
    }
    let part = |number: i64| number.checked_div(common).unwrap_or(1).max(1);
    let (mut numerator, mut divisor) = (part(numerator), part(divisor));
    while numerator.max(divisor) > i64::from(u32::MAX) {
        (numerator, divisor) = ((numerator >> 1).max(1), (divisor >> 1).max(1));
    }
    put_number(dictionary, index, 1, numerator);
    put_number(dictionary, index, 2, divisor);
}

/// Turns a minute of so many increments/s.
pub(super) fn per_minute(speed: i32) -> i64 {
    i64::from(speed) * 60 / 65_536
}

/// V, PV, VelFB, Velocity and VCMD.
pub(super) fn show<D: Dictionary>(dictionary: &mut D, seen: &Seen) {
    for index in SPEEDS {
        put_number(dictionary, index, 1, per_minute(seen.speed));
    }
    put_number(dictionary, DEMAND, 1, per_minute(seen.speed_demand));
}

/// PUNIT, VUNIT and ACCUNIT name the units in 6089h to 608Eh.
fn show_units<D: Dictionary>(dictionary: &mut D) {
    let position = match number(dictionary, PUNIT, 1) {
        0 => (0, 0),
        power => (-power, 1),
    };
    let velocity = match number(dictionary, VUNIT, 1) {
        0 => (0, 0),
        1 => (0, 0xA4),
        6 => (0, 0xA7),
        7 => (-3, 0xA6),
        8 => (-3, 0xA7),
        _ => (0, 0xA6),
    };
    let acceleration = match number(dictionary, ACCUNIT, 1) {
        1 => (0, 0xAE),
        3 => (-6, 0x55),
        4 => (-3, 0x55),
        _ => (0, 0x55),
    };
    for (index, (notation, dimension)) in [
        (0x6089, position),
        (0x608B, velocity),
        (0x608D, acceleration),
    ] {
        put_number(dictionary, index, 0, notation);
        put_number(dictionary, index + 1, 0, dimension);
    }
}

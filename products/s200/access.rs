//! PASSCNFG, which locks the parameters, and DRVCNFG2.
//!
//! The manual has names alone. Chosen: a number that is written to PASSCNFG is a password from then on, and the parameters of the text
//! interface can be read and not written until it is written again; commands among them go on. What is stored and read is not the
//! password itself. DRVCNFG2 bit 0 says that the option AS with its safety relay is fitted, which bit 13 of 1002h shows.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Attributes, Dictionary, Entry};
use cia402::behaviour::{number, put_number};

const PASSWORD: u16 = 0x36D8;

/// What stands for a password: not 0.
fn hidden(password: i64) -> i64 {
    let mixed = (password as u32).wrapping_mul(0x9E37_79B1) ^ 0x5BD1_E995;
    i64::from((mixed | 1).cast_signed())
}

pub(super) fn check(held: i64, entry: &Entry, value: i64) -> Result<(), AbortCode> {
    if held == 0 || !(0x3500..0x3CD0).contains(&entry.index) {
        return Ok(());
    }
    match entry.index {
        PASSWORD if hidden(value) == held => Ok(()),
        PASSWORD => Err(AbortCode::InvalidValue),
        _ if entry.attributes.has(Attributes::READ) => Err(AbortCode::DeviceState),
        _ => Ok(()),
    }
}

/// The lock: what PASSCNFG shows.
pub(super) fn written<D: Dictionary>(dictionary: &mut D, held: &mut i64, is_starting: bool) {
    let value = number(dictionary, PASSWORD, 1);
    *held = match *held {
        // What is loaded stands for the password already.
        _ if is_starting => value,
        0 if value != 0 => hidden(value),
        _ => 0,
    };
    put_number(dictionary, PASSWORD, 1, *held);
}

//! When objects may be written, beside the rules of each object.
//!
//! A write that is not allowed now gets the abort code 08000022h:
//!
//! - While the power stage is on (or the motor moves): parameters with a lock ([`crate::rules::lock`]), and [`LOCKED_WHILE_POWERED`].
//! - While a password is set (5FF1h) and the master has not given it: objects of the manufacturer, 2000h to 5FFFh. The password
//!   guards against mistakes, not against attackers: 1011h and a factory reset delete it.
//! - Outside of production mode: [`PRODUCTION_ONLY`]. "prod" in 5FF1h:1 begins that mode, as long as the device has no serial number.
//!   It ends when the serial number is stored or the node is reset, and opens no other object.
//!
//! | object | |
//! |---|---|
//! | 5FF1h:1 | the master writes the password here, or "prod". A wrong one locks again (06090030h); for a second after it none is accepted (08000022h) |
//! | 5FF1h:2 | a new password, stored with the parameters; 0 for none |
//! | 5FF1h:3 | access: 0 no password, 1 locked, 2 open, 3 production mode |
//!
//! A dictionary without these objects has no password and no production mode.

use core::ops::RangeInclusive;

use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary, Entry};
use canopen::{Duration, Instant};

use crate::parameters::Parameter;
use crate::rules::{Lock, lock};

/// Node-ID and bit rate.
pub(crate) const NETWORK: u16 = 0x5FF0;
/// The password.
pub(crate) const PASSWORD: u16 = 0x5FF1;
/// What production writes.
pub(crate) const PRODUCTION: u16 = 0x5FF2;

/// The sub-indices of 5FF1h.
const GIVEN: u8 = 1;
const NEW: u8 = 2;
const ACCESS: u8 = 3;

/// Objects that are no parameters and must not change while the power stage is on: ratings, motor data, and settings that are written to
/// flash at once.
pub const LOCKED_WHILE_POWERED: [RangeInclusive<u16>; 6] = [
    NETWORK..=NETWORK,
    PRODUCTION..=PRODUCTION,
    0x6075..=0x6076,
    0x6402..=0x6404,
    0x6406..=0x6407,
    0x6410..=0x6410,
];

/// Objects that only production writes.
pub const PRODUCTION_ONLY: [u16; 1] = [PRODUCTION];

/// Objects that a password guards.
const GUARDED: RangeInclusive<u16> = 0x2000..=0x5FFF;

/// Written to 5FF1h:1, it begins production mode.
const PRODUCTION_MODE: u32 = u32::from_le_bytes(*b"prod");

/// How long after a wrong password none is accepted.
const PENALTY: Duration = Duration::from_ticks(1_000_000);

/// The locks, and the state of the drive on which they depend.
#[derive(Debug, Default)]
pub(crate) struct Protection {
    powered: bool,
    moving: bool,
    /// Stored parameters are being loaded. They passed the rules when they were written.
    loading: bool,
    open: bool,
    production: bool,
    now: Option<Instant>,
    /// 5FF1h:3 is out of date.
    is_stale: bool,
    /// No password is accepted before this moment.
    penalty_until: Option<Instant>,
}

impl Protection {
    /// Notes the state of the drive before a frame is served.
    pub(crate) fn prepare(&mut self, powered: bool, moving: bool, now: Instant) {
        self.powered = powered;
        self.moving = moving;
        self.loading = false;
        self.now = Some(now);
    }

    /// Stored parameters are loaded from now on, until the next [`Protection::prepare`].
    pub(crate) fn load(&mut self) {
        self.loading = true;
    }

    /// Whether an object may be written now.
    pub(crate) fn check<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        parameter: Option<Parameter>,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        if self.loading {
            return Ok(());
        }
        let index = entry.index;
        let is_locked = match parameter.and_then(lock) {
            Some(Lock::Powered) => self.powered,
            Some(Lock::Moving) => self.moving,
            None => self.powered && is_among(&LOCKED_WHILE_POWERED, index),
        };
        if is_locked {
            return Err(AbortCode::DeviceState);
        }
        if PRODUCTION_ONLY.contains(&index) {
            // Production need not know the password of the product.
            return if self.production {
                Ok(())
            } else {
                Err(AbortCode::DeviceState)
            };
        }
        if index == PASSWORD && entry.sub == GIVEN {
            return self.check_given(dictionary, value);
        }
        if GUARDED.contains(&index) && !self.is_open(dictionary) {
            return Err(AbortCode::DeviceState);
        }
        Ok(())
    }

    /// Checks a password. [`Protection::count_refusal`] sees what a wrong one sets off.
    fn check_given<D: Dictionary>(&self, dictionary: &D, value: &[u8]) -> Result<(), AbortCode> {
        let is_penalty = match (self.now, self.penalty_until) {
            (Some(now), Some(until)) => now < until,
            _ => false,
        };
        if is_penalty {
            return Err(AbortCode::DeviceState);
        }
        let is_good = value
            .first_chunk()
            .is_some_and(|bytes| self.accepts(dictionary, u32::from_le_bytes(*bytes)));
        if is_good {
            Ok(())
        } else {
            Err(AbortCode::InvalidValue)
        }
    }

    /// Whether stored parameters are being loaded, so that no master writes.
    pub(crate) const fn is_loading(&self) -> bool {
        self.loading
    }

    /// Whether the power stage is on.
    pub(crate) const fn is_powered(&self) -> bool {
        self.powered
    }

    /// [`Protection::check`] refused a write of this object. A wrong password locks again, and begins the time without another try.
    pub(crate) fn count_refusal(&mut self, entry: &Entry, code: AbortCode) {
        if entry.index == PASSWORD && entry.sub == GIVEN && code == AbortCode::InvalidValue {
            self.open = false;
            self.production = false;
            self.is_stale = true;
            self.penalty_until = self.now.and_then(|now| now.checked_add_duration(PENALTY));
        }
    }

    /// An object was written.
    pub(crate) fn written<D: Dictionary>(&mut self, dictionary: &mut D, entry: &Entry) {
        if entry.index == PASSWORD && !self.loading {
            if entry.sub == GIVEN {
                let given = od::read_u32(dictionary, PASSWORD, GIVEN).unwrap_or(0);
                // The password and "prod" each open their own objects.
                self.production |= given == PRODUCTION_MODE && has_no_serial_number(dictionary);
                self.open |= is_password(dictionary, given);
                od::write_u32(dictionary, PASSWORD, GIVEN, 0);
            } else if entry.sub == NEW {
                // The master that has set the password knows it.
                self.open = true;
            }
        }
        if entry.index == PASSWORD {
            self.show(dictionary);
        }
    }

    /// Whether [`Protection::serve`] has something to do.
    pub(crate) const fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// Shows the access again if a refused write has changed it.
    pub(crate) fn serve<D: Dictionary>(&mut self, dictionary: &mut D) {
        if core::mem::take(&mut self.is_stale) {
            self.show(dictionary);
        }
    }

    /// Ends production mode.
    pub(crate) fn end_production<D: Dictionary>(&mut self, dictionary: &mut D) {
        self.production = false;
        self.show(dictionary);
    }

    /// 5FF1h:3.
    pub(crate) fn show<D: Dictionary>(&self, dictionary: &mut D) {
        let access = if self.production {
            3
        } else if password(dictionary) == 0 {
            0
        } else if self.open {
            2
        } else {
            1
        };
        od::write_u8(dictionary, PASSWORD, ACCESS, access);
    }

    /// The device starts anew: the password is to be given again.
    pub(crate) fn reset(&mut self) {
        *self = Self {
            penalty_until: self.penalty_until,
            now: self.now,
            ..Self::default()
        };
    }

    fn accepts<D: Dictionary>(&self, dictionary: &D, given: u32) -> bool {
        is_password(dictionary, given)
            || given == PRODUCTION_MODE && has_no_serial_number(dictionary)
    }

    fn is_open<D: Dictionary>(&self, dictionary: &D) -> bool {
        self.open || password(dictionary) == 0
    }
}

/// The password; 0 for none.
fn password<D: Dictionary>(dictionary: &D) -> u32 {
    od::read_u32(dictionary, PASSWORD, NEW).unwrap_or(0)
}

fn is_password<D: Dictionary>(dictionary: &D, given: u32) -> bool {
    given != 0 && given == password(dictionary)
}

/// Whether there is an object for the serial number, and production has not written it yet.
fn has_no_serial_number<D: Dictionary>(dictionary: &D) -> bool {
    od::read_u32(dictionary, PRODUCTION, 1) == Some(0)
}

fn is_among(ranges: &[RangeInclusive<u16>], index: u16) -> bool {
    ranges.iter().any(|range| range.contains(&index))
}

//! SYNC consumer (CiA 301, 7.2.5; object 1005h): the beat that synchronous PDOs follow.
//!
//! The contract: a SYNC is a frame without data, as this device has no synchronous counter overflow value (1019h). One
//! with data is not a SYNC: it is ignored, and emergency 8240h (unexpected SYNC data length) stands until the next good
//! one. This device does not produce SYNC: bit 30 of the COB-ID is refused.

use super::emergency::{Emergency, ErrorRegister};
use super::length_error::LengthReport;
use super::sdo::AbortCode;
use crate::od::{Dictionary, read_u32};
use crate::wire::cob_id::{CobId, is_restricted};

/// Index of the object COB-ID SYNC.
pub const INDEX: u16 = 0x1005;

/// The SYNC consumer of a device.
#[derive(Debug)]
pub struct Sync {
    cob_id: u16,
    has_length_error: bool,
    is_reported: bool,
    /// Length of the last frame.
    length: u8,
    /// The length that the emergency tells of.
    reported_length: u8,
}

impl Sync {
    /// The emergency error code of a SYNC with a wrong length (CiA 301 table 26).
    const UNEXPECTED_LENGTH: u16 = 0x8240;

    /// Bit 30 of 1005h: the device produces SYNC.
    const PRODUCE: u32 = 1 << 30;

    /// No 11-bit identifier is equal to it.
    const NOT_IN_USE: u16 = u16::MAX;

    /// A consumer that hears nothing until [`Sync::configure`].
    pub const fn new() -> Self {
        Self {
            cob_id: Self::NOT_IN_USE,
            has_length_error: false,
            is_reported: false,
            length: 0,
            reported_length: 0,
        }
    }

    /// Takes its COB-ID from object 1005h, after power-on values were loaded; a device without 1005h hears no SYNC. A
    /// length error ends: ask [`Sync::length_report`] afterwards.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D) {
        self.has_length_error = false;
        self.written(dictionary);
    }

    /// Whether 1005h may get this value. Called when the value has passed the dictionary's own checks; nothing changes.
    ///
    /// # Errors
    /// - [`AbortCode::InvalidValue`]: bit 30 (produce SYNC), bit 29 (29-bit identifier) or a restricted identifier.
    /// - [`AbortCode::LengthMismatch`]: not an UNSIGNED32.
    pub fn validate(&self, value: &[u8]) -> Result<(), AbortCode> {
        let cob_id = CobId(u32::from_le_bytes(
            value.try_into().map_err(|_| AbortCode::LengthMismatch)?,
        ));
        if !is_supported(cob_id) || is_restricted(cob_id.identifier()) {
            Err(AbortCode::InvalidValue)
        } else {
            Ok(())
        }
    }

    /// 1005h was written: the new identifier counts from the next frame on.
    pub fn written<D: Dictionary>(&mut self, dictionary: &D) {
        let cob_id = read_u32(dictionary, INDEX, 0)
            .map(CobId)
            .filter(|cob_id| is_supported(*cob_id));
        self.cob_id = cob_id.map_or(Self::NOT_IN_USE, CobId::identifier);
    }

    /// The identifier that it listens to; above 7FFh when there is none.
    pub const fn cob_id(&self) -> u16 {
        self.cob_id
    }

    /// A data frame with this identifier arrived, `length` bytes long. Returns whether it is a SYNC. Ask
    /// [`Sync::length_report`] afterwards in either case.
    pub fn receive(&mut self, length: u8) -> bool {
        self.has_length_error = length != 0;
        self.length = length;
        !self.has_length_error
    }

    /// Whether [`Sync::length_report`] has something to tell.
    pub const fn has_length_report(&self) -> bool {
        self.has_length_error != self.is_reported
    }

    /// What the emergency producer has to hear; `None` when it knows everything.
    pub fn length_report(&mut self) -> Option<LengthReport> {
        if !self.has_length_report() {
            return None;
        }
        self.is_reported = self.has_length_error;
        if self.has_length_error {
            self.reported_length = self.length;
        }
        let emergency = Emergency {
            code: Self::UNEXPECTED_LENGTH,
            register: ErrorRegister::COMMUNICATION,
            info: [self.reported_length, 0, 0, 0, 0],
        };
        Some(if self.has_length_error {
            LengthReport::Appeared(emergency)
        } else {
            LengthReport::Gone(emergency)
        })
    }
}

impl Default for Sync {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether this is a consumer on an 11-bit identifier. Bit 31 is "do not care".
fn is_supported(cob_id: CobId) -> bool {
    cob_id.is_base_frame() && cob_id.0 & Sync::PRODUCE == 0
}

#[cfg(test)]
mod tests;

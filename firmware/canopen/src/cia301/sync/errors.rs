//! What can be wrong with SYNC, as it is and as the emergency producer knows it.

use crate::cia301::emergency::{Emergency, ErrorRegister, code};
use crate::cia301::error_report::ErrorReport;

/// The two errors of SYNC.
#[derive(Debug)]
pub(super) struct Errors {
    has_wrong_length: bool,
    is_missed: bool,
    /// The same, as it was told.
    told_wrong_length: bool,
    told_missed: bool,
    /// Length of the last frame.
    length: u8,
    /// The length that the emergency tells of.
    told_length: u8,
}

impl Errors {
    pub(super) const fn new() -> Self {
        Self {
            has_wrong_length: false,
            is_missed: false,
            told_wrong_length: false,
            told_missed: false,
            length: 0,
            told_length: 0,
        }
    }

    /// A frame with this length came.
    pub(super) fn length(&mut self, length: u8, is_wrong: bool) {
        self.length = length;
        self.has_wrong_length = is_wrong;
    }

    /// Whether a SYNC is missed.
    pub(super) fn missed(&mut self, is_missed: bool) {
        self.is_missed = is_missed;
    }

    /// Both are over.
    pub(super) fn end(&mut self) {
        self.has_wrong_length = false;
        self.is_missed = false;
    }

    /// Whether one stands, or has been told and is over.
    pub(super) const fn stand(&self) -> bool {
        self.has_wrong_length || self.is_missed || self.told_wrong_length || self.told_missed
    }

    #[inline]
    pub(super) const fn have_changed(&self) -> bool {
        self.has_wrong_length != self.told_wrong_length || self.is_missed != self.told_missed
    }

    /// What the emergency producer has to hear, one at a time.
    pub(super) fn report(&mut self) -> Option<ErrorReport> {
        if self.has_wrong_length != self.told_wrong_length {
            self.told_wrong_length = self.has_wrong_length;
            if self.has_wrong_length {
                self.told_length = self.length;
            }
            let info = [self.told_length, 0, 0, 0, 0];
            return Some(told(self.has_wrong_length, code::SYNC_LENGTH, info));
        }
        if self.is_missed != self.told_missed {
            self.told_missed = self.is_missed;
            let [low, high] = super::PERIOD.to_le_bytes();
            let info = [low, high, 0, 0, 0];
            return Some(told(self.is_missed, code::COMMUNICATION, info));
        }
        None
    }
}

fn told(has_appeared: bool, code: u16, info: [u8; 5]) -> ErrorReport {
    let emergency = Emergency {
        code,
        register: ErrorRegister::COMMUNICATION,
        info,
    };
    if has_appeared {
        ErrorReport::Appeared(emergency)
    } else {
        ErrorReport::Gone(emergency)
    }
}

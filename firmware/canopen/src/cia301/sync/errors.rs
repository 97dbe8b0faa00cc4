//! What can be wrong with SYNC, as it is and as the emergency producer knows it.

use crate::cia301::emergency::{Emergency, ErrorRegister, code};
use crate::cia301::error_report::ErrorReport;

/// The last SYNC had another length (8240h).
const LENGTH: u8 = 1 << 0;
/// None came in time (8100h).
const MISSED: u8 = 1 << 1;

/// The errors, a bit for each.
#[derive(Debug)]
pub(super) struct Errors {
    standing: u8,
    told: u8,
    /// The length that was wrong.
    length: u8,
}

impl Errors {
    pub(super) const fn new() -> Self {
        Self {
            standing: 0,
            told: 0,
            length: 0,
        }
    }

    /// A SYNC of this length came.
    pub(super) fn length(&mut self, length: u8, is_wrong: bool) {
        if is_wrong && self.standing & LENGTH == 0 {
            self.length = length;
        }
        self.set(LENGTH, is_wrong);
    }

    pub(super) fn missed(&mut self, is_missed: bool) {
        self.set(MISSED, is_missed);
    }

    fn set(&mut self, error: u8, stands: bool) {
        self.standing = self.standing & !error | if stands { error } else { 0 };
    }

    /// No error stands any more.
    pub(super) fn end(&mut self) {
        self.standing = 0;
    }

    /// Whether an error stands, or one that was told has not been told to be gone.
    pub(super) const fn stand(&self) -> bool {
        self.standing | self.told != 0
    }

    /// Whether there is something to report.
    #[inline]
    pub(super) const fn have_changed(&self) -> bool {
        self.standing != self.told
    }

    /// What the emergency producer has to hear, one at a time.
    pub(super) fn report(&mut self) -> Option<ErrorReport> {
        let changed = self.standing ^ self.told;
        let error = changed & changed.wrapping_neg();
        self.told ^= error;
        let (code, [low, high]) = match error {
            0 => return None,
            LENGTH => (code::SYNC_LENGTH, [self.length, 0]),
            _ => (code::COMMUNICATION, super::PERIOD.to_le_bytes()),
        };
        let emergency = Emergency {
            code,
            register: ErrorRegister::COMMUNICATION,
            info: [low, high, 0, 0, 0],
        };
        Some(match self.standing & error {
            0 => ErrorReport::Gone(emergency),
            _ => ErrorReport::Appeared(emergency),
        })
    }
}

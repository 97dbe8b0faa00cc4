//! What can be wrong with a receive PDO.

use crate::cia301::emergency::{Emergency, ErrorRegister, code};

/// The errors of one PDO that stand, a bit for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Errors(u8);

impl Errors {
    /// All is well.
    pub(super) const NONE: Self = Self(0);
    /// The last frame was shorter than the mapping (8210h: PDO not processed due to length error).
    pub(super) const SHORT: Self = Self(1 << 0);
    /// The last frame was longer than the mapping (8220h: PDO length exceeded).
    pub(super) const LONG: Self = Self(1 << 1);
    /// No frame came within the deadline (8250h: RPDO timeout).
    pub(super) const LATE: Self = Self(1 << 2);

    /// Whether these are among them.
    pub(super) const fn has(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    /// These and others.
    pub(super) const fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// A multiplexed PDO named an object that is not there (8230h: DAM MPDO not processed, destination object not available).
    pub(super) const NO_OBJECT: Self = Self(1 << 3);

    /// These without others.
    pub(super) const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// One of them; `None` if there is none.
    pub(super) const fn first(self) -> Option<Self> {
        match self.0 & self.0.wrapping_neg() {
            0 => None,
            lowest => Some(Self(lowest)),
        }
    }

    /// The emergency error code of a single error (CiA 301 table 26).
    const fn code(self) -> u16 {
        match self {
            Self::SHORT => 0x8210,
            Self::LONG => 0x8220,
            Self::NO_OBJECT => 0x8230,
            _ => code::RPDO_TIMEOUT,
        }
    }

    /// The message of a single error; the number of the PDO, from 1, is the info.
    pub(super) const fn emergency(self, number: u16) -> Emergency {
        let [low, high] = number.to_le_bytes();
        Emergency {
            code: self.code(),
            register: ErrorRegister::COMMUNICATION,
            info: [low, high, 0, 0, 0],
        }
    }
}

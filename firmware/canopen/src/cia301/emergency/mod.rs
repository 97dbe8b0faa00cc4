//! Emergency (CiA 301, 7.2.7): one message when an error appears, one when it is gone.
//!
//! A message has the emergency error code, the error register (object 1001h) and five bytes of the manufacturer. Its
//! COB-ID is object 1014h, the time that must lie between two messages object 1015h. Object 1003h keeps the last errors,
//! the newest first: the code in the low word, the first two manufacturer bytes in the high word.
//!
//! The contract of the producer:
//! - An error is told once, however often it is reported, until it is cleared. What tells two errors apart is what the
//!   history would show: the code and the first two manufacturer bytes.
//! - The error register holds the bits of every error that stands, and the generic bit as long as there is one.
//! - "No error" (code 0000h) carries what is left in the error register.
//! - Without a valid COB-ID or without a node-ID register and history go on. In a state without emergency messages (Stopped)
//!   they do as well, and the messages wait, in their order, for one that has them.
//! - The inhibit time delays messages and drops none; a new one counts at once. The queue holds sixteen. In a full one
//!   the oldest message makes room for the newest, and is counted: the last word of the device agrees with the register.
//! - An error of one source, such as the length error of one PDO, is cleared by itself; others of the same code stand.
//!
//! A device may listen to the messages of others: [`consumer`].

mod active;
pub mod consumer;
mod history;
mod parameters;
mod producer;
mod queue;

pub use active::Meant;
pub use consumer::ReceivedEmergency;
pub(crate) use history::is_present;
pub use producer::Producer;

/// Emergency error codes of the communication profile (CiA 301, table 26).
pub mod code {
    /// Communication, generic: what has no code of its own.
    pub const COMMUNICATION: u16 = 0x8100;
    /// CAN overrun: objects were lost.
    pub const OVERRUN: u16 = 0x8110;
    /// The CAN controller is error passive.
    pub const ERROR_PASSIVE: u16 = 0x8120;
    /// Life guard error or heartbeat error.
    pub const ERROR_CONTROL: u16 = 0x8130;
    /// Recovered from bus-off.
    pub const BUS_OFF: u16 = 0x8140;
    /// Transmit COB-ID collision: another device sends with an identifier of this one.
    pub const COLLISION: u16 = 0x8150;
    /// A SYNC with an unexpected data length.
    pub const SYNC_LENGTH: u16 = 0x8240;
    /// RPDO time-out: a receive PDO did not come before its deadline.
    pub const RPDO_TIMEOUT: u16 = 0x8250;
}

/// An error as CiA 301 reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Emergency {
    /// Emergency error code (CiA 301 table 26 and the device profile).
    pub code: u16,
    /// Bits of the error register 1001h that stand while the error stands; the generic bit 0 is always added.
    pub register: u8,
    /// Manufacturer-specific bytes of the frame.
    pub info: [u8; 5],
}

impl Emergency {
    /// The word of this error in the history 1003h. It also is what tells two errors apart.
    pub const fn history_word(&self) -> u32 {
        self.message().history_word()
    }

    /// The message that tells of it, with its own bits of the error register.
    #[inline]
    pub(crate) const fn message(&self) -> Message {
        let [low, high] = self.code.to_le_bytes();
        let [a, b, c, d, e] = self.info;
        Message(u64::from_le_bytes([
            low,
            high,
            self.register,
            a,
            b,
            c,
            d,
            e,
        ]))
    }
}

/// An emergency message, or an error that stands, as the number that its eight bytes are: it moves in two registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Message(u64);

impl Message {
    /// "Error reset or no error".
    const NO_ERROR: Self = Self(0);

    /// The bits by which two errors are told apart: code, and the first two bytes of the manufacturer.
    const IDENTITY: u64 = 0xFF_FF00_FFFF;

    /// Where the bits of the error register are.
    const REGISTER: u32 = 16;

    /// Whether it is the same error.
    #[inline]
    const fn is_as(self, other: Self) -> bool {
        (self.0 ^ other.0) & Self::IDENTITY == 0
    }

    /// Its bits of the error register.
    #[inline]
    const fn register(self) -> u8 {
        (self.0 >> Self::REGISTER) as u8
    }

    /// The same with these bits of the error register.
    #[inline]
    const fn with_register(self, register: u8) -> Self {
        Self(self.0 & !(0xFF << Self::REGISTER) | (register as u64) << Self::REGISTER)
    }

    /// [`Emergency::history_word`].
    #[inline]
    const fn history_word(self) -> u32 {
        self.0 as u32 & 0xFFFF | ((self.0 >> 24) as u32) << 16
    }
}

/// Bits of the error register 1001h.
#[derive(Debug)]
pub struct ErrorRegister;

#[allow(missing_docs, reason = "the names are the standard's own")]
impl ErrorRegister {
    pub const GENERIC: u8 = 1 << 0;
    pub const CURRENT: u8 = 1 << 1;
    pub const VOLTAGE: u8 = 1 << 2;
    pub const TEMPERATURE: u8 = 1 << 3;
    pub const COMMUNICATION: u8 = 1 << 4;
    pub const DEVICE_PROFILE: u8 = 1 << 5;
    pub const MANUFACTURER: u8 = 1 << 7;
}

#[cfg(test)]
mod tests;

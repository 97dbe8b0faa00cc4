//! SLCAN: CAN frames as lines of text, the protocol of serial CAN adapters (Lawicel CAN232, Linux `slcan`, python-can).
//!
//! A line ends with a carriage return. The PC opens the channel with `O`, then `t6048400010000000` + CR sends the frame
//! 604h with eight bytes, and each frame from the bus comes back as such a line. The adapter answers every line with CR,
//! or with BEL if it does not understand or cannot do it. This crate is the adapter's side without any I/O: the virtual
//! drive speaks it on TCP, the firmware in the emulator on its serial port.
//!
//! - [`Decoder`] takes bytes and gives [`Command`]s; whatever the bytes are, it stays bounded and recovers at the next CR.
//! - [`encode`] makes the line of a frame.
//! - [`Channel`] knows which command may come when, and the reply to each.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

#[cfg(test)]
extern crate std;

mod channel;
mod command;
mod decoder;
mod encode;

pub use channel::{Answer, Channel};
pub use command::{AdapterBitRate, Command};
pub use decoder::Decoder;
pub use encode::{Line, encode};

/// The longest line without its CR: `T`, 8 digits of identifier, the length, 16 digits of data.
pub const LINE_LENGTH: usize = 26;

/// The reply to a command that was carried out.
pub const OK: &[u8] = b"\r";

/// The reply to a command that was not understood or could not be carried out (BEL).
pub const ERROR: &[u8] = b"\x07";

#[cfg(test)]
mod tests;

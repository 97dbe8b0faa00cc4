//! What every host of the drive does: on a board, in the emulator, on a PC. What a host has of its own it gives by ports.
//!
//! | here | does | the host gives |
//! |---|---|---|
//! | [`Node`] | the node task: frames, deadlines, events, LSS store, bit rate, parameters | [`Controller`], [`Reception`], [`Storage`], [`Host`] |
//! | [`Control`] | the control tick, the early tick for a stop, the refill | [`PowerStage`] |
//! | [`PowerUp`] | node-ID and bit rate at power-on | [`Storage`], switches |
//! | [`Panel`] | the lights | [`Lights`] |
//! | [`Machine`] | user memory and scope data | room for them |
//! | [`inbox`] | frames on their way from an interrupt | |
//! | [`servo`] | the loops of a motor that is moved by its current | counts of the converter and the encoder |
//!
//! The contract:
//! - A host calls [`Control::tick`] each nominal period, or when the last tick said; [`Control::refill`] as often as
//!   [`cia402::DriveConfig`] says; [`Node::run`] after each of the ticks, after a frame, after room to send, and at the time that the last
//!   run has returned.
//! - [`Node`] and [`Control`] share the exchange and nothing else, and lock it for no longer than a copy ([`cia402::Share`]). The
//!   control tick may interrupt the node anywhere, never the other way round.
//! - Nothing here waits, allocates or reads a clock; every time comes from the host's.
//! - Nothing that comes from the bus leads to a panic.
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

#[macro_use]
mod log;

mod control;
pub mod inbox;
mod indicator;
mod machine;
mod node;
mod ports;
pub mod servo;
mod settings;

pub use control::Control;
pub use inbox::{Inbox, Lost, Received};
pub use indicator::{Lights, Panel, Signals};
pub use machine::{Machine, SCOPE_DATA, USER_MEMORY, is_listed};
pub use node::Node;
pub use ports::{Controller, Host, PowerStage, Reception, Stamped, Storage, Unreachable};
pub use settings::PowerUp;

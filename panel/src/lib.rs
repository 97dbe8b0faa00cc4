//! A panel for CANopen drives in the browser: `axis402 panel`.
//!
//! - [`message`]: what windows and the panel say to each other.
//! - [`session`]: the session with the bus, in one thread that owns the master.
//! - [`server`]: a WebSocket for each window, and the page ([`assets`]); [`origin`] says who may talk to it.
//! - [`desk`]: who may write, and what may not wait in a queue.
//! - [`line`](mod@line): the panel's end of the bus. [`traffic`]: what passes there, in words. [`fsa`]: the state machine of a drive. [`homing`]: its methods.
#![forbid(unsafe_code)]

mod arguments;
pub mod assets;
pub mod desk;
pub mod fsa;
pub mod homing;
pub mod line;
pub mod message;
pub mod origin;
mod program;
pub mod server;
pub mod session;
pub mod traffic;
mod virtual_drive;

pub use program::run;

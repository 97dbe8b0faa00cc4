#![doc = include_str!("../README.md")]
//!
//! ## Where to find what
//!
//! [`Node`] is the device; its module ([`node`]) holds the contract. [`od`] is the object dictionary, [`wire`] the frames, and the other folders carry
//! the numbers of the standards. [`settings`] finds node-ID and bit rate at power-on, [`Outbox`] stands between the node and the mailboxes of a controller.
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

mod agenda;
pub mod application;
pub mod bit_timing;
pub mod can_controller;
pub mod cia301;
pub mod cia302;
pub mod cia303;
pub mod cia305;
mod copy;
pub mod node;
pub mod od;
pub mod outbox;
pub mod settings;
mod slots;
pub mod stream;
pub mod time;
pub mod wire;

pub use application::Application;
pub use can_controller::{ControllerState, Counters};
pub use node::{Event, Node};
pub use outbox::Outbox;
pub use settings::{BitRate, BitTiming, Configuration, NodeId, Settings};
pub use stream::{Domain, Sink, Source};
pub use time::{Duration, Instant};
pub use wire::Frame;

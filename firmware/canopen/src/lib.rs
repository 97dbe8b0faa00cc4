//! A CANopen device: CiA 301 (communication profile), CiA 302-2 (NMT start-up), CiA 303-3 (indicators) and CiA 305 (layer setting services).
//!
//! The device is a value. Frames and time go in, frames and the next deadline come out ([`Node::receive`],
//! [`Node::poll`], [`Node::transmit`]); it never waits, allocates or reads a clock. The same code runs in the
//! firmware, in the emulator and on a PC.
//!
//! Folders carry the numbers of the standards; [`od`] is the object dictionary, [`wire`] the frames.
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

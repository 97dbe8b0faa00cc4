//! The servo: what makes a motor follow by its current, without a word of CAN or registers.
//!
//! A [`CurrentLoop`] runs once in each period of the modulation: samples in, pulse widths out. Above it a [`Cascade`] runs at the rate of the control:
//! position and velocity in, current out; a [`Control`] runs it by the orders of a drive, and watches the motor. [`feedback`] tells where the rotor is, [`protection`] what may be asked of the motor.
//!
//! # The contract
//!
//! - Currents, voltages and gains are f32 in SI units; an angle is a fraction of a turn in 32 bits ([`Angle`]); positions are whole counts of 64 bits.
//! - Vectors have the amplitude of a phase: 1 A in q is a peak of 1 A in each phase. The d axis lies along the magnet, q a quarter of an
//!   electrical turn ahead of it; a positive current in q turns the motor positively.
//! - What comes from outside is checked once, where it is set up. No input, NaN and infinity among them, makes it panic or give out
//!   NaN, more than the bus has, or a current beyond its limit.
//! - It knows no clock: each loop is told its period once, and is called that often.
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

pub mod angle;
pub mod cascade;
pub mod control;
pub mod current_loop;
pub mod feedback;
pub mod field_weakening;
pub mod filter;
pub mod interrupt;
pub mod modulation;
pub mod motor;
pub mod number;
pub mod offsets;
pub mod protection;
pub mod stage;
pub mod stepper;
pub mod transform;
pub mod tuning;

pub use angle::Angle;
pub use cascade::Cascade;
pub use control::Control;
pub use current_loop::CurrentLoop;
pub use interrupt::CurrentInterrupt;
pub use motor::{Implausible, Motor, Wiring};

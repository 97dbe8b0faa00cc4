//! CiA 303-3: the indicators of a CANopen device, a green run light and a red error light.
//!
//! A light says what it has to say by its pattern. The shortest flash is 50 ms (flickering); all other patterns are made of
//! 200 ms:
//!
//! ```text
//!                 0     200    400    600    800   1000   1200 ms
//!  on             ██████████████████████████████████████████
//!  blinking       ███████       ███████       ███████           2.5 Hz
//!  single flash   ███████                                       one flash, then dark for a second
//!  off
//! ```
//!
//! The contract:
//! - The green light is on in Operational, blinks in Pre-operational and gives a single flash in Stopped. During
//!   Initialisation it is off.
//! - The red light is on while the device has a fault (a controller that has left the bus is one), off otherwise.
//! - Both lights are at the same place of their patterns, and a light that changes its pattern joins in where the
//!   others are.
//!
//! Flickering (LSS), double and triple flashes are patterns of the standard that nothing here asks for yet.

mod indicators;
mod pattern;

pub use indicators::{Indicators, Lights, Signal};
pub use pattern::Pattern;

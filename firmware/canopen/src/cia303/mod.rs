//! CiA 303-3: the indicators of a CANopen device, a green run light and a red error light.
//!
//! A light says what it has to say by its pattern. The shortest flash is 50 ms (flickering); all other patterns are made of
//! 200 ms:
//!
//! ```text
//!                 0     200    400    600    800   1000   1200   1400   1600 ms
//!  on             ████████████████████████████████████████████████████████
//!  flickering     █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █ █    10 Hz
//!  blinking       ███████       ███████       ███████       ███████           2.5 Hz
//!  single flash   ███████                                   ███████           then dark for a second
//!  double flash   ███████       ███████                                       triple, quadruple: likewise
//!  off
//! ```
//!
//! | pattern | green: run | red: error |
//! |---|---|---|
//! | off | Initialisation | no error |
//! | flickering | LSS or search for the bit rate, in turn with red | the same, in turn with green |
//! | blinking | Pre-operational | what was stored does not fit |
//! | single flash | Stopped | the controller has counted many errors |
//! | double flash | | a watched node is silent, or nobody guards the device |
//! | triple flash | | SYNC missing |
//! | quadruple flash | | a receive PDO missing |
//! | on | Operational | bus-off |
//!
//! The contract:
//! - Of several errors the red light shows the one that is lowest in the table; bus-off goes before flickering too.
//! - Both lights are at the same place of their patterns, but for flickering, where one is lit while the other is dark. A light
//!   that changes its pattern joins in where the others are.
//! - One light with two colours is red where both would be lit ([`Lights::bicolour`]).
//! - A device without a node-ID flickers, as it waits for LSS.
//!
//! Errors of the application are not for these lights: they have one of their own.

mod indicators;
mod pattern;

pub use indicators::{CommunicationState, Indicators, Lights, Signal};
pub use pattern::Pattern;

//! The object dictionary of the drive, from the data sheet that `build.rs` chooses.

include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));

/// The positions in a turn, where a product has a number of them that is its own.
#[allow(dead_code, reason = "of a stepper a step is one")]
pub const POSITIONS: Option<u32> = include!(concat!(env!("OUT_DIR"), "/positions.rs"));

//! The object dictionary of the drive, from the data sheet that `build.rs` chooses.

include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));

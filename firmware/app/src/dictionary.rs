//! The object dictionary of the drive, from `eds/axis402.eds`.

include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));

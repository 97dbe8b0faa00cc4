//! The device that is fuzzed.
//!
//! The device under watch is the one of the random tests (`tests/src/watched/mod.rs`): its invariants, not only panics, end a run.
#![forbid(unsafe_code)]

#[path = "../../tests/src/firmware.rs"]
pub mod firmware;
#[path = "../../tests/src/watched/mod.rs"]
pub mod watched;

/// The dictionary of `tests/eds/test-device.eds`.
pub mod test_device {
    include!(concat!(env!("OUT_DIR"), "/test_device.rs"));
}

/// Ends the run where an invariant is broken.
///
/// # Panics
/// If it is.
pub fn hold<T>(result: Result<T, watched::Broken>) -> T {
    result.unwrap_or_else(|broken| panic!("{broken}"))
}

//! What is fuzzed.
//!
//! It is what the random tests play with (`tests/src/watched/mod.rs`, `tests/src/any_drive.rs`, `firmware/motion/tests/anything`,
//! `firmware/store/src/tests/stored.rs`): what these
//! hold for a broken rule, not only a panic, ends a run.
#![forbid(unsafe_code)]

#[path = "../../tests/src/any_drive.rs"]
pub mod any_drive;
#[path = "../../firmware/motion/tests/anything/axis.rs"]
pub mod axis;
#[path = "../../firmware/motion/tests/anything/bytes.rs"]
pub mod bytes;
#[path = "../../tests/src/firmware.rs"]
pub mod firmware;
#[path = "../../firmware/store/src/tests/flash.rs"]
pub mod flash;
#[path = "../../firmware/motion/tests/anything/plan.rs"]
pub mod plan;
#[path = "../../firmware/store/src/tests/stored.rs"]
pub mod stored;
#[path = "../../tests/src/watched/mod.rs"]
pub mod watched;

pub use store::Store;

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

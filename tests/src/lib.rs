//! What the tests share: the notation of the cases, a scripted station on the simulated bus, and the devices under test.
//!
//! A case says which frames go in and which come out, in virtual time:
//!
//! ```
//! let mut bench = tests::Bench::node(4);
//! bench.send("604: 40 00 10 00");
//! bench.expect("584: 43 00 10 00 ..");
//! bench.refused("604: 40 04 10 00", 0x0602_0000);
//! bench.silence(1_000);
//! ```
#![forbid(unsafe_code)]

pub mod any_drive;
pub mod bare_node;
pub mod basic;
mod block_transfer;
mod crc;
pub mod drive;
pub mod firmware;
pub mod late;
pub mod line;
// The tests of the device write frames in the same way.
#[path = "../../firmware/canopen/tests/device/notation.rs"]
pub mod notation;
pub mod plain_node;
pub mod plugged;
mod service_data;
pub mod watched;

pub use crc::crc;
pub use drive::DriveBench;
pub use plain_node::Bench;

/// The dictionary of `eds/test-device.eds`.
pub mod test_device {
    include!(concat!(env!("OUT_DIR"), "/test_device.rs"));
}

/// The dictionary of `eds/multiplexed-device.eds`.
pub mod multiplexed_device {
    include!(concat!(env!("OUT_DIR"), "/multiplexed_device.rs"));
}

/// The dictionary of `eds/basic-device.eds`.
pub mod basic_device {
    include!(concat!(env!("OUT_DIR"), "/basic_device.rs"));
}

/// The dictionary of the example of `canopen`, as it is committed there.
pub mod io_device {
    include!("../../firmware/canopen/examples/io_device/dictionary.rs");
}

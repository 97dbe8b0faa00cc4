//! Writes the dictionaries of the devices that the protocol cases are put to.

use od_gen::{Options, build};

fn main() {
    build("eds/test-device.eds", "test_device.rs", Options::DEVICE);
    build(
        "eds/multiplexed-device.eds",
        "multiplexed_device.rs",
        Options::DEVICE,
    );
    build("eds/basic-device.eds", "basic_device.rs", Options::DEVICE);
}

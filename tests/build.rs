//! Writes the dictionaries of the devices that the protocol cases are put to.

fn main() {
    od_gen::build(
        "eds/test-device.eds",
        "test_device.rs",
        od_gen::Options::DEVICE,
    );
    od_gen::build(
        "eds/multiplexed-device.eds",
        "multiplexed_device.rs",
        od_gen::Options::DEVICE,
    );
}

//! Writes the dictionary of the device that the protocol cases are put to.

fn main() {
    od_gen::build(
        "../tests/eds/test-device.eds",
        "test_device.rs",
        od_gen::Options::DEVICE,
    );
}

//! Frames of a wrong length: each PDO and SYNC has an error of its own, which its next good frame ends.

use crate::device::Device;

#[test]
fn e09_a_receive_pdo_of_a_wrong_length_is_reported_by_the_device_itself() {
    let mut device = Device::operational();
    device.send("204 [2] 01 02");
    assert_eq!(device.sent(), ["084: 10 82 11 01 00 00 00 00"]);
    device.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(device.sent(), ["084: 00 00 00 00 00 00 00 00"]);
    device.send("204 [2] 01 02");
    device.sent();
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(
        device.sent(),
        ["704 [1] 00"],
        "communication starts without its old errors, and says nothing more"
    );
    assert_eq!(device.value(0x1001, 0), [0]);
}

/// The second receive PDO listens to 304h.
fn with_two_receive_pdos() -> Device {
    let mut device = Device::operational();
    assert_eq!(
        device.ask("604: 23 01 14 01 04 03 00 00"),
        ["584: 60 01 14 01 00 00 00 00"]
    );
    device
}

#[test]
fn p21_length_errors_of_two_receive_pdos_come_and_go_by_themselves() {
    let mut device = with_two_receive_pdos();
    assert_eq!(
        device.ask("204 [2] 01 02"),
        ["084: 10 82 11 01 00 00 00 00"]
    );
    assert_eq!(
        device.ask("304 [2] 01 02"),
        ["084: 10 82 11 02 00 00 00 00"]
    );
    assert!(device.ask("204 [1] 01").is_empty(), "told once");
    assert_eq!(
        device.ask("204: 01 02 03 04 05 06 07 08"),
        ["084: 00 00 11 00 00 00 00 00"],
        "the other one stands"
    );
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(device.ask("204 [1] 01"), ["084: 10 82 11 01 00 00 00 00"]);
    assert_eq!(
        device.ask("304: 01 02 03 04 05 06 07 08"),
        ["084: 00 00 11 00 00 00 00 00"]
    );
    assert_eq!(
        device.ask("204: 01 02 03 04 05 06 07 08"),
        ["084: 00 00 00 00 00 00 00 00"]
    );
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn p21_a_receive_pdo_that_is_switched_off_ends_its_own_length_error() {
    let mut device = with_two_receive_pdos();
    device.ask("204 [2] 01 02");
    device.ask("304 [2] 01 02");
    assert_eq!(
        device.ask("604: 23 01 14 01 04 03 00 80"),
        [
            "084: 00 00 11 00 00 00 00 00",
            "584: 60 01 14 01 00 00 00 00"
        ]
    );
    assert_eq!(
        device.ask("204: 01 02 03 04 05 06 07 08"),
        ["084: 00 00 00 00 00 00 00 00"]
    );
}

#[test]
fn y06_a_sync_error_ends_whatever_lengths_came_after_it() {
    let mut device = Device::operational();
    assert_eq!(device.ask("080 [1] 01"), ["084: 40 82 11 01 00 00 00 00"]);
    assert!(device.ask("080 [2] 01 02").is_empty());
    assert_eq!(device.ask("080 [0]"), ["084: 00 00 00 00 00 00 00 00"]);
}

//! SYNC with data, in other states, on another identifier.

use super::*;

#[test]
fn y06_a_sync_with_data_is_an_error_and_no_sync() {
    let mut device = Device::operational();
    transmit_type(&mut device, 1);
    assert_eq!(device.ask("080 [1] 01"), ["084: 40 82 11 01 00 00 00 00"]);
    assert!(device.ask("080 [1] 02").is_empty());
    assert_eq!(
        device.ask("080 [0]"),
        [
            "084: 00 00 00 00 00 00 00 00",
            "184: 00 00 00 00 00 00 00 00"
        ]
    );
}

#[test]
fn y09_only_operational_follows_the_sync() {
    let mut device = Device::operational();
    transmit_type(&mut device, 1);
    device.send("000 [2] 80 04");
    assert!(device.ask("080 [0]").is_empty());
    device.send("000 [2] 02 04");
    assert!(device.ask("080 [0]").is_empty());
    assert!(
        device.ask("080 [1] 01").is_empty(),
        "no error either in Stopped"
    );
    assert_eq!(device.value(0x1001, 0), [0]);
    device.send("000 [2] 01 04");
    device.sent();
    assert_eq!(device.ask("080 [0]").len(), 1);
    assert_eq!(device.ask("080 [1] 01"), ["084: 40 82 11 01 00 00 00 00"]);
}

#[test]
fn the_sync_identifier_can_be_changed() {
    let mut device = Device::operational();
    transmit_type(&mut device, 1);
    assert_eq!(write_u32(&mut device, 0x1005, 0, 0x90), DONE);
    assert!(device.ask("080 [0]").is_empty());
    assert_eq!(device.ask("090 [0]").len(), 1);
}

//! Who gets a frame: identifiers that change, and a second device with ours (C04).

use crate::device::{Device, abort};

fn collision(cob_id: u16) -> String {
    let [low, high] = cob_id.to_le_bytes();
    format!("084: 50 81 11 {low:02X} {high:02X} 00 00 00")
}

#[test]
fn c04_a_frame_that_only_this_device_sends_is_told_once_for_each_identifier() {
    let mut device = Device::new();
    for (frame, cob_id) in [
        ("704 [1] 00", 0x704),
        ("584: 43 00 10 00 92 01 02 00", 0x584),
        ("084: 00 00 00 00 00 00 00 00", 0x084),
        ("184: 00 00 00 00 00 00 00 00", 0x184),
    ] {
        assert_eq!(device.ask(frame), [collision(cob_id)]);
        assert_eq!(device.ask(frame), [""; 0]);
    }
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(device.value(0x1003, 1)[..2], [0x50, 0x81]);
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.sent(), ["704 [1] 00"]);
    assert_eq!(device.value(0x1001, 0), [0], "communication starts anew");
}

#[test]
fn c04_what_others_may_send_is_no_collision() {
    let mut device = Device::new();
    for frame in [
        "705 [1] 05",
        "585: 43 00 10 00 92 01 02 00",
        "085: 00 00 00 00 00 00 00 00",
        "284 [1] 00",
        "185 [1] 00",
        "704 [8] rtr",
        "184 [8] rtr",
        "7E4: 50 04 00 00 00 00 00 00",
        "081 [0]",
        "204: 00 00 00 00 00 00 00 00",
        "604: 40 00 10 00 00 00 00 00",
    ] {
        device.put(frame);
    }
    device.sent();
    assert_eq!(device.value(0x1001, 0), [0]);
    assert_eq!(device.ask("704 [1] 05"), [collision(0x704)], "one that is");
}

#[test]
fn c04_an_identifier_that_moved_counts_from_then_on() {
    let mut device = Device::new();
    device.ask("604: 23 00 18 01 84 01 00 C0");
    assert_eq!(device.ask("184 [1] 00"), [""; 0], "the PDO is not valid");
    device.ask("604: 23 00 18 01 85 01 00 40");
    assert_eq!(device.ask("184 [1] 00"), [""; 0]);
    assert_eq!(device.ask("185 [1] 00"), [collision(0x185)]);
}

/// The answer to a write of this object.
fn written(index: u16, sub: u8) -> String {
    let [low, high] = index.to_le_bytes();
    format!("584: 60 {low:02X} {high:02X} {sub:02X} 00 00 00 00")
}

#[test]
fn p15_a_transmit_pdo_does_not_take_the_identifier_of_another_service() {
    let mut device = Device::new();
    // TIME is consumed, and the second SDO server is on.
    for (request, answer) in [
        ("604: 23 12 10 00 00 01 00 80", written(0x1012, 0)),
        ("604: 23 01 12 01 A0 06 00 00", written(0x1201, 1)),
        ("604: 23 01 12 02 A1 06 00 00", written(0x1201, 2)),
        ("604: 23 00 18 01 84 01 00 C0", written(0x1800, 1)),
    ] {
        assert_eq!(device.ask(request), [answer]);
    }
    let refused = [abort(0x1800, 1, 0x0609_0030)];
    for (service, cob_id) in [
        ("SYNC", "80000040"),
        ("EMCY", "84000040"),
        ("TIME", "00010040"),
        ("SDO requests", "A0060040"),
        ("SDO answers", "A1060040"),
    ] {
        assert_eq!(
            device.ask(&format!("604: 23 00 18 01 {cob_id}")),
            refused,
            "{service}"
        );
        assert_eq!(device.value(0x1800, 1), [0x84, 0x01, 0, 0xC0]);
    }
    // What is off has no identifier, and may keep any.
    assert_eq!(
        device.ask("604: 23 00 18 01 80 00 00 C0"),
        [written(0x1800, 1)]
    );
    assert_eq!(
        device.ask("604: 23 00 18 01 80 00 00 40"),
        refused,
        "SYNC, as it is made valid"
    );
    // A service that is not in use takes none.
    assert_eq!(
        device.ask("604: 23 12 10 00 00 01 00 00"),
        [written(0x1012, 0)]
    );
    assert_eq!(
        device.ask("604: 23 00 18 01 00 01 00 40"),
        [written(0x1800, 1)]
    );
}

#[test]
fn p15_no_other_service_takes_the_identifier_of_a_transmit_pdo() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 14 10 00 84 00 00 80"),
        [written(0x1014, 0)]
    );
    for (index, sub, cob_id) in [
        (0x1005_u16, 0, "84010000"),
        (0x1012, 0, "84010080"),
        (0x1012, 0, "84010040"),
        (0x1014, 0, "84010000"),
        (0x1201, 1, "84010000"),
        (0x1201, 2, "84010000"),
    ] {
        let [low, high] = index.to_le_bytes();
        let before = device.value(index, sub);
        let request = format!("604: 23 {low:02X} {high:02X} {sub:02X} {cob_id}");
        assert_eq!(device.ask(&request), [abort(index, sub, 0x0609_0030)]);
        assert_eq!(device.value(index, sub), before);
    }
    // The second one is not valid: its identifier is free, until it is.
    assert_eq!(
        device.ask("604: 23 05 10 00 84 02 00 00"),
        [written(0x1005, 0)]
    );
    assert_eq!(
        device.ask("604: 23 01 18 01 84 02 00 40"),
        [abort(0x1801, 1, 0x0609_0030)]
    );
    // Whatever is off takes any.
    assert_eq!(
        device.ask("604: 23 14 10 00 84 01 00 80"),
        [written(0x1014, 0)]
    );
    assert_eq!(
        device.ask("604: 23 12 10 00 84 01 00 00"),
        [written(0x1012, 0)]
    );
}

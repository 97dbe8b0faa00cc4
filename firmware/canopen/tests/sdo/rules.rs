//! What holds for every request: its length, who asks, limits, states, and what is changed when.

use super::*;

#[test]
fn s28_a_request_has_eight_bytes() {
    let mut device = Device::new();
    for frame in [
        "604 [4] 40 00 10 00",
        "604 [0]",
        "604 [6] 40 00 10 00 00 00",
    ] {
        assert!(device.ask(frame).is_empty());
    }
    assert_eq!(device.ask("604: 40 00 10 00 00 00 00 00").len(), 1);
}

#[test]
fn s29_requests_for_others_extended_and_remote_frames() {
    let mut device = Device::new();
    assert!(device.ask("605: 40 00 10 00 00 00 00 00").is_empty());
    assert!(device.ask("585: 40 00 10 00 00 00 00 00").is_empty());
    assert!(device.ask("604 [8] rtr").is_empty());
    let extended = Frame::new(
        ExtendedId::new(0x604).unwrap(),
        &[0x40, 0, 0x10, 0, 0, 0, 0, 0],
    )
    .unwrap();
    device
        .node
        .receive(&extended, device.now, &mut device.firmware);
    assert!(device.sent().is_empty());
    assert_eq!(device.ask("604: 40 00 10 00 00 00 00 00").len(), 1);
}

#[test]
fn s30_limits_of_the_data_sheet() {
    let mut device = Device::new();
    refused(&mut device, "2F 08 20 00 09", 0x2008, 0, 0x0609_0032);
    refused(&mut device, "2F 08 20 00 15", 0x2008, 0, 0x0609_0031);
    exchange(&mut device, "2F 08 20 00 0A", "60 08 20 00");
    exchange(&mut device, "2F 08 20 00 14", "60 08 20 00");
    refused(&mut device, "2F 0A 20 00 FA", 0x200A, 0, 0x0609_0032);
    refused(&mut device, "2F 0A 20 00 06", 0x200A, 0, 0x0609_0031);
    exchange(&mut device, "2F 0A 20 00 FB", "60 0A 20 00");
    assert_eq!(device.value(0x2008, 0), [20]);
    assert_eq!(device.value(0x200A, 0), [0xFB]);
    assert_eq!(
        device.firmware.written,
        [(0x2008, 0), (0x2008, 0), (0x200A, 0)]
    );
}

#[test]
fn s31_a_write_that_needs_another_state() {
    let mut device = Device::new();
    device.firmware.is_running = true;
    refused(&mut device, "2B 13 20 00 01 00", 0x2013, 0, 0x0800_0022);
    assert_eq!(device.value(0x2013, 0), [0, 0]);
    assert!(device.firmware.written.is_empty());
    device.firmware.is_running = false;
    exchange(&mut device, "2B 13 20 00 01 00", "60 13 20 00");
    assert_eq!(device.value(0x2013, 0), [1, 0]);
}

#[test]
fn s32_an_error_that_has_not_been_is_no_data() {
    let mut device = Device::new();
    refused(&mut device, "40 03 10 01", 0x1003, 1, 0x0800_0024);
    refused(&mut device, "40 03 10 08", 0x1003, 8, 0x0800_0024);
    refused(&mut device, "40 03 10 09", 0x1003, 9, 0x0609_0011);
    exchange(&mut device, "40 03 10 00", "4F 03 10 00 00");
}

#[test]
fn s33_a_long_download_changes_the_object_in_one_step() {
    let mut device = Device::new();
    let before = device.value(0x2007, 0);
    exchange(&mut device, "21 07 20 00 08", "60 07 20 00");
    exchange(&mut device, "00 A1 A2 A3 A4 A5 A6 A7", "20");
    assert_eq!(device.value(0x2007, 0), before);
    assert!(device.ask(&request("80 07 20 00 00 00 00 08")).is_empty());
    assert_eq!(device.value(0x2007, 0), before);
    exchange(&mut device, "21 07 20 00 08", "60 07 20 00");
    exchange(&mut device, "00 A1 A2 A3 A4 A5 A6 A7", "20");
    assert_eq!(device.value(0x2007, 0), before);
    exchange(&mut device, "1D A8", "30");
    assert_eq!(
        device.value(0x2007, 0),
        [0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8]
    );
}

#[test]
fn s34_a_long_upload_is_a_snapshot() {
    let mut device = Device::new();
    exchange(&mut device, "40 07 20 00", "41 07 20 00 08");
    device.set_value(0x2007, 0, &[0xFF; 8]);
    exchange(&mut device, "60", "00 01 02 03 04 05 06 07");
    device.set_value(0x2007, 0, &[0xEE; 8]);
    exchange(&mut device, "70", "1D 08");
}

#[test]
fn s35_an_answer_waits_for_the_bus() {
    let mut device = Device::new();
    device.send(&request("40 00 10 00"));
    for _ in 0..50 {
        device.now += canopen::Duration::from_ticks(100_000);
        device.poll();
    }
    assert_eq!(device.sent(), [answer("43 00 10 00 92 01 02 00")]);
}

#[test]
fn s36_requests_between_two_polls_are_answered_in_order() {
    let mut device = Device::new();
    device.put(&request("40 00 10 00"));
    device.put(&request("40 00 20 00"));
    device.poll();
    assert_eq!(
        device.sent(),
        [
            answer("43 00 10 00 92 01 02 00"),
            answer("43 00 20 00 78 56 34 12")
        ]
    );
}

#[test]
fn s36_a_request_whose_answer_has_no_room_is_not_executed() {
    let mut device = Device::new();
    for value in 1..=6 {
        device.put(&request(&format!("23 00 20 00 {value:02X}")));
    }
    assert_eq!(device.sent(), vec![answer("60 00 20 00"); 2]);
    assert_eq!(device.value(0x2000, 0), [2, 0, 0, 0]);
    assert_eq!(device.node.overflows(), 4, "what was lost is counted");
    exchange(&mut device, "40 00 20 00", "43 00 20 00 02");
}

#[test]
fn s37_a_string_that_is_too_long() {
    let mut device = Device::new();
    exchange(&mut device, "21 0B 20 00 20", "60 0B 20 00");
    refused(&mut device, "21 0B 20 00 21", 0x200B, 0, 0x0607_0012);
    refused(
        &mut device,
        "21 0B 20 00 00 00 00 80",
        0x200B,
        0,
        0x0607_0012,
    );
    // Not announced: refused as soon as it is too long.
    exchange(&mut device, "20 0B 20 00", "60 0B 20 00");
    for segment in 0..4 {
        let toggle = if segment % 2 == 0 { "00" } else { "10" };
        assert_eq!(
            device
                .ask(&request(&format!("{toggle} 61 62 63 64 65 66 67")))
                .len(),
            1
        );
    }
    refused(
        &mut device,
        "00 61 62 63 64 65 66 67",
        0x200B,
        0,
        0x0607_0012,
    );
    assert!(device.value(0x200B, 0).is_empty());
}

#[test]
fn s41_restricted_cob_ids_are_refused() {
    let restricted = [
        0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x77F,
        0x7FF,
    ];
    // The services are switched off first, so that nothing but the identifier can be wrong.
    let objects = [(0x1005, 0), (0x1014, 0), (0x1401, 1), (0x1801, 1)];
    for (index, sub) in objects {
        for cob_id in restricted {
            let mut device = Device::new();
            if index == 0x1014 {
                exchange(&mut device, "23 14 10 00 84 00 00 80", "60 14 10 00");
            }
            let [low, high] = u16::to_le_bytes(index);
            let [a, b] = u16::to_le_bytes(cob_id);
            let asked = format!("23 {low:02X} {high:02X} {sub:02X} {a:02X} {b:02X} 00 00");
            refused(&mut device, &asked, index, sub, 0x0609_0030);
            let asked = format!("23 {low:02X} {high:02X} {sub:02X} 90 06 00 00");
            exchange(
                &mut device,
                &asked,
                &format!("60 {low:02X} {high:02X} {sub:02X}"),
            );
        }
    }
}

//! Process data and SYNC on the bus: P01 to P40 and Y06, Y09 of the listed cases, frame by frame.
//!
//! The device maps 2003h and 2004h into its first receive PDO, 2005h and 2006h into its first transmit PDO; the second ones
//! map the same and are not valid.

mod sync;

use crate::device::{Device, abort, show};

use canopen::Frame;

const DONE: &str = "accepted";
const UNSUPPORTED_ACCESS: u32 = 0x0601_0000;
const INVALID_VALUE: u32 = 0x0609_0030;

/// Downloads a number of `length` bytes; "accepted", or the abort frame.
fn download(device: &mut Device, index: u16, sub: u8, number: u32, length: u8) -> String {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = number.to_le_bytes();
    let command = 0x23 | (4 - length) << 2;
    let request = show(&Frame::data_frame(
        0x604,
        &[command, low, high, sub, a, b, c, d],
    ));
    let done = show(&Frame::data_frame(
        0x584,
        &[0x60, low, high, sub, 0, 0, 0, 0],
    ));
    device.put(&request);
    let sent = device.sent();
    assert_eq!(sent.len(), 1, "one answer: {sent:?}");
    if sent[0] == done {
        DONE.to_owned()
    } else {
        sent[0].clone()
    }
}

fn write_u8(device: &mut Device, index: u16, sub: u8, number: u8) -> String {
    download(device, index, sub, number.into(), 1)
}

fn write_u16(device: &mut Device, index: u16, sub: u8, number: u16) -> String {
    download(device, index, sub, number.into(), 2)
}

fn write_u32(device: &mut Device, index: u16, sub: u8, number: u32) -> String {
    download(device, index, sub, number, 4)
}

/// The standard procedure.
fn map(device: &mut Device, communication: u16, cob_id: u32, kind: u8, mapping: &[u32]) {
    let record = communication + 0x200;
    assert_eq!(
        write_u32(device, communication, 1, 0x8000_0000 | cob_id),
        DONE
    );
    assert_eq!(write_u8(device, communication, 2, kind), DONE);
    assert_eq!(write_u8(device, record, 0, 0), DONE);
    for (sub, entry) in (1..).zip(mapping) {
        assert_eq!(write_u32(device, record, sub, *entry), DONE);
    }
    assert_eq!(
        write_u8(device, record, 0, u8::try_from(mapping.len()).unwrap()),
        DONE
    );
    assert_eq!(write_u32(device, communication, 1, cob_id), DONE);
}

/// The first transmit PDO gets this type, and its first transmission is over.
fn transmit_type(device: &mut Device, kind: u8) {
    assert_eq!(write_u8(device, 0x1800, 2, kind), DONE);
    device.poll();
    device.sent();
}

#[test]
fn p01_p02_a_mapping_in_use_is_not_changed() {
    let mut device = Device::new();
    assert_eq!(
        write_u8(&mut device, 0x1600, 0, 0),
        abort(0x1600, 0, UNSUPPORTED_ACCESS)
    );
    assert_eq!(write_u32(&mut device, 0x1400, 1, 0x8000_0204), DONE);
    assert_eq!(
        write_u32(&mut device, 0x1600, 1, 0x2004_0020),
        abort(0x1600, 1, UNSUPPORTED_ACCESS)
    );
}

#[test]
fn p03_the_procedure_makes_a_new_pdo() {
    let mut device = Device::new();
    map(&mut device, 0x1400, 0x20B, 255, &[0x2006_0020]);
    device.send("000 [2] 01 04");
    device.sent();
    device.send("204: 01 02 03 04 05 06 07 08");
    device.send("20B [4] 01 02 03 04");
    assert_eq!(device.value(0x2006, 0), [1, 2, 3, 4]);
    assert_eq!(device.value(0x2003, 0), [0; 4]);
}

#[test]
fn p04_p05_a_mapping_that_is_too_long_is_refused() {
    let mut device = Device::new();
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x8000_0184), DONE);
    assert_eq!(
        write_u8(&mut device, 0x1A00, 0, 9),
        abort(0x1A00, 0, 0x0604_0042)
    );
    assert_eq!(write_u8(&mut device, 0x1A00, 0, 0), DONE);
    assert_eq!(write_u32(&mut device, 0x1A00, 3, 0x2003_0020), DONE);
    assert_eq!(
        write_u8(&mut device, 0x1A00, 0, 3),
        abort(0x1A00, 0, 0x0604_0042)
    );
}

#[test]
fn p06_p08_p09_what_cannot_be_mapped_is_refused() {
    let mut device = Device::new();
    assert_eq!(write_u32(&mut device, 0x1400, 1, 0x8000_0204), DONE);
    assert_eq!(write_u8(&mut device, 0x1600, 0, 0), DONE);
    assert_eq!(
        write_u32(&mut device, 0x1600, 1, 0x5FFF_0008),
        abort(0x1600, 1, 0x0602_0000)
    );
    assert_eq!(
        write_u32(&mut device, 0x1600, 1, 0x2000_0020),
        abort(0x1600, 1, 0x0604_0041)
    );
    assert_eq!(
        write_u32(&mut device, 0x1600, 1, 0x2003_0010),
        abort(0x1600, 1, 0x0604_0041)
    );
}

#[test]
fn p12_a_pdo_without_objects_is_inert() {
    let mut device = Device::new();
    map(&mut device, 0x1800, 0x184, 255, &[]);
    map(&mut device, 0x1400, 0x204, 255, &[]);
    device.send("000 [2] 01 04");
    device.send("204 [1] 01");
    assert!(device.pass(1000).is_empty());
    device.send("000 [2] 80 04");
    map(&mut device, 0x1800, 0x184, 255, &[0x2005_0020]);
    device.send("000 [2] 01 04");
    assert_eq!(device.pass(1000).len(), 1, "with one it is not");
}

#[test]
fn p13_p14_p15_the_cob_id_of_a_valid_pdo() {
    let mut device = Device::new();
    assert_eq!(
        write_u32(&mut device, 0x1800, 1, 0x0000_018B),
        abort(0x1800, 1, INVALID_VALUE)
    );
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x4000_0184), DONE);
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x0000_0184), DONE);
    assert_eq!(
        write_u32(&mut device, 0x1800, 1, 0x2000_0184),
        abort(0x1800, 1, INVALID_VALUE)
    );
}

#[test]
fn p16_the_inhibit_time_of_a_valid_pdo_is_not_changed() {
    let mut device = Device::new();
    assert_eq!(
        write_u16(&mut device, 0x1800, 3, 100),
        abort(0x1800, 3, INVALID_VALUE)
    );
    assert_eq!(
        write_u16(&mut device, 0x1800, 3, 0),
        DONE,
        "the value that it has"
    );
    assert_eq!(write_u16(&mut device, 0x1801, 3, 100), DONE);
}

#[test]
fn p18_transmission_types() {
    let mut device = Device::new();
    for index in [0x1400, 0x1800] {
        for number in [0, 1, 240, 254, 255] {
            assert_eq!(write_u8(&mut device, index, 2, number), DONE);
        }
        for number in [241, 251] {
            assert_eq!(
                write_u8(&mut device, index, 2, number),
                abort(index, 2, INVALID_VALUE)
            );
        }
    }
    for number in [252, 253] {
        assert_eq!(write_u8(&mut device, 0x1800, 2, number), DONE);
        assert_eq!(
            write_u8(&mut device, 0x1400, 2, number),
            abort(0x1400, 2, INVALID_VALUE)
        );
    }
}

#[test]
fn s41_restricted_identifiers_are_refused() {
    let mut device = Device::new();
    for index in [0x1400, 0x1800] {
        assert_eq!(write_u32(&mut device, index, 1, 0x8000_0204), DONE);
        for identifier in [
            0x7F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701,
        ] {
            assert_eq!(
                write_u32(&mut device, index, 1, identifier),
                abort(index, 1, INVALID_VALUE)
            );
        }
    }
    for identifier in [
        0x7F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701,
    ] {
        assert_eq!(
            write_u32(&mut device, 0x1005, 0, identifier),
            abort(0x1005, 0, INVALID_VALUE)
        );
    }
}

#[test]
fn p22_with_p19_and_p21_a_short_pdo_is_an_error_in_every_place_until_a_good_one_comes() {
    let mut device = Device::operational();
    for frame in ["204 [0]", "204 [2] 01 02", "204 [7] 01 02 03 04 05 06 07"] {
        device.send(frame);
    }
    assert_eq!(
        device.sent(),
        ["084: 10 82 11 01 00 00 00 00"],
        "once, with communication and generic error"
    );
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(device.value(0x2003, 0), [0; 4]);
    device.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(device.sent(), ["084: 00 00 00 00 00 00 00 00"]);
    assert_eq!(device.value(0x1001, 0), [0]);
    assert_eq!(device.value(0x2004, 0), [5, 6, 7, 8]);
}

#[test]
fn p20_of_a_long_pdo_the_first_bytes_are_used() {
    let mut device = Device::new();
    map(&mut device, 0x1400, 0x204, 255, &[0x2003_0020]);
    device.send("000 [2] 01 04");
    device.sent();
    device.send("204 [5] 01 02 03 04 05");
    device.send("204 [5] 01 02 03 04 06");
    assert_eq!(device.value(0x2003, 0), [1, 2, 3, 4]);
    assert_eq!(device.sent(), ["084: 20 82 11 01 00 00 00 00"]);
}

#[test]
fn p21_a_length_error_does_not_outlive_a_reset() {
    let mut device = Device::operational();
    device.send("204 [0]");
    device.sent();
    assert_eq!(device.value(0x1001, 0), [0x11]);
    device.send("000 [2] 82 04");
    device.serve_reset();
    device.sent();
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn p23_only_data_frames_in_operational_are_received() {
    let mut device = Device::new();
    device.send("204: 01 02 03 04 05 06 07 08");
    device.send("000 [2] 01 04");
    device.send("204 [8] rtr");
    device.send("000 [2] 02 04");
    device.send("204: 01 02 03 04 05 06 07 08");
    device.send("204 [0]");
    assert_eq!(device.value(0x2003, 0), [0; 4]);
    assert_eq!(device.value(0x1001, 0), [0]);
    device.send("000 [2] 01 04");
    device.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(device.value(0x2003, 0), [1, 2, 3, 4]);
    device.send("204 [0]");
    assert_eq!(device.value(0x1001, 0), [0x11]);
}

#[test]
fn p25_type_1_is_sampled_at_the_sync() {
    let mut device = Device::operational();
    transmit_type(&mut device, 1);
    for value in 1..=3 {
        device.set_value(0x2005, 0, &[value, 0, 0, 0]);
        device.put("080 [0]");
        device.set_value(0x2005, 0, &[0xFF; 4]);
        device.poll();
        assert_eq!(
            device.sent(),
            [format!("184: 0{value} 00 00 00 00 00 00 00")]
        );
    }
}

#[test]
fn p26_type_3_counts_from_the_start() {
    let mut device = Device::operational();
    transmit_type(&mut device, 3);
    device.send("080 [0]");
    device.send("000 [2] 80 04");
    device.send("000 [2] 01 04");
    let sent: Vec<_> = (0..6).map(|_| device.ask("080 [0]").len()).collect();
    assert_eq!(sent, [0, 0, 1, 0, 0, 1]);
}

#[test]
fn p27_type_0_needs_an_event_and_a_sync() {
    let mut device = Device::operational();
    transmit_type(&mut device, 0);
    device.send("000 [2] 80 04");
    device.send("000 [2] 01 04");
    assert_eq!(device.ask("080 [0]"), ["184: 00 00 00 00 00 00 00 00"]);
    assert!(device.ask("080 [0]").is_empty());
    device.set_value(0x2005, 0, &[1, 0, 0, 0]);
    assert!(device.pass(100).is_empty());
    assert_eq!(device.ask("080 [0]"), ["184: 01 00 00 00 00 00 00 00"]);
    assert!(device.ask("080 [0]").is_empty());
}

#[test]
fn p29_the_inhibit_time_gathers_changes() {
    let mut device = Device::new();
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x8000_0184), DONE);
    assert_eq!(write_u16(&mut device, 0x1800, 3, 100), DONE);
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x184), DONE);
    device.send("000 [2] 01 04");
    device.pass(100);
    let mut log = Vec::new();
    for value in 1..=4 {
        device.set_value(0x2005, 0, &[value, 0, 0, 0]);
        log.push(device.pass(1));
    }
    assert_eq!(
        log[0],
        [(0, "184: 01 00 00 00 00 00 00 00".to_owned())],
        "the first at once"
    );
    assert!(log[1..].iter().all(Vec::is_empty));
    assert_eq!(
        device.pass(100),
        [(6, "184: 04 00 00 00 00 00 00 00".to_owned())],
        "the last one 10 ms after it"
    );
}

#[test]
fn p30_the_event_timer_starts_anew_with_an_event() {
    let mut device = Device::operational();
    assert_eq!(write_u16(&mut device, 0x1800, 5, 100), DONE);
    assert!(device.pass(60).is_empty());
    device.set_value(0x2005, 0, &[1, 0, 0, 0]);
    let frame = "184: 01 00 00 00 00 00 00 00".to_owned();
    assert_eq!(
        device.pass(250),
        [(0, frame.clone()), (100, frame.clone()), (200, frame)]
    );
}

#[test]
fn p31_the_inhibit_time_wins_over_the_event_timer() {
    let mut device = Device::new();
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x8000_0184), DONE);
    assert_eq!(write_u16(&mut device, 0x1800, 3, 300), DONE);
    assert_eq!(write_u16(&mut device, 0x1800, 5, 20), DONE);
    assert_eq!(write_u32(&mut device, 0x1800, 1, 0x184), DONE);
    device.send("000 [2] 01 04");
    let moments: Vec<_> = device
        .pass(100)
        .into_iter()
        .map(|(moment, _)| moment)
        .collect();
    assert_eq!(moments, [0, 30, 60, 90]);
}

#[test]
fn p32_without_a_change_nothing_is_sent() {
    let mut device = Device::operational();
    device.set_value(0x2005, 0, &[0; 4]);
    assert!(device.pass(10_000).is_empty());
    device.set_value(0x2005, 0, &[1, 0, 0, 0]);
    assert_eq!(device.pass(10_000).len(), 1);
}

#[test]
fn p33_p34_a_synchronous_pdo_is_applied_at_the_sync() {
    let mut device = Device::operational();
    assert_eq!(write_u8(&mut device, 0x1400, 2, 1), DONE);
    device.send("204: 01 00 00 00 00 00 00 00");
    device.send("204: 02 00 00 00 00 00 00 00");
    assert_eq!(device.value(0x2003, 0), [0; 4]);
    device.put("080 [0]");
    device.put("204: 03 00 00 00 00 00 00 00");
    device.poll();
    assert_eq!(device.value(0x2003, 0), [2, 0, 0, 0]);
    assert_eq!(device.firmware.written, [(0x2003, 0), (0x2004, 0)]);
    device.send("080 [0]");
    assert_eq!(device.value(0x2003, 0), [3, 0, 0, 0]);
}

#[test]
fn p37_c03_a_busy_bus_gets_the_newest_data_in_order() {
    let mut device = Device::new();
    map(&mut device, 0x1801, 0x284, 1, &[0x2005_0020]);
    assert_eq!(write_u8(&mut device, 0x1800, 2, 1), DONE);
    device.send("000 [2] 01 04");
    for value in 1..=3 {
        device.set_value(0x2005, 0, &[value, 0, 0, 0]);
        device.send("080 [0]");
    }
    assert_eq!(
        device.sent(),
        ["184: 03 00 00 00 00 00 00 00", "284 [4] 03 00 00 00"]
    );
}

#[test]
fn p38_two_pdos_with_one_identifier_are_both_executed() {
    let mut device = Device::new();
    map(&mut device, 0x1401, 0x204, 255, &[0x2006_0020, 0x2005_0020]);
    assert_eq!(write_u8(&mut device, 0x1800, 2, 1), DONE);
    device.send("000 [2] 01 04");
    device.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(device.value(0x2003, 0), [1, 2, 3, 4]);
    assert_eq!(device.value(0x2006, 0), [1, 2, 3, 4]);
    assert_eq!(device.value(0x2005, 0), [5, 6, 7, 8]);
}

#[test]
fn p38_a_second_pdo_that_gets_the_identifier_in_operational_is_executed_too() {
    let mut device = Device::operational();
    transmit_type(&mut device, 1);
    map(&mut device, 0x1401, 0x204, 255, &[0x2006_0020, 0x2005_0020]);
    device.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(device.value(0x2003, 0), [1, 2, 3, 4]);
    assert_eq!(device.value(0x2006, 0), [1, 2, 3, 4]);
    // And the first one has it alone again.
    assert_eq!(write_u32(&mut device, 0x1401, 1, 0x8000_0204), DONE);
    device.send("204: 05 06 07 08");
    device.send("204: 09 0A 0B 0C 00 00 00 00");
    assert_eq!(device.value(0x2003, 0), [9, 10, 11, 12]);
    assert_eq!(device.value(0x2006, 0), [1, 2, 3, 4]);
}

#[test]
fn p40_a_new_mapping_holds_from_the_next_frame_on() {
    let mut device = Device::operational();
    map(&mut device, 0x1400, 0x204, 255, &[0x2004_0020, 0x2003_0020]);
    device.send("204: 01 02 03 04 05 06 07 08");
    assert_eq!(device.value(0x2004, 0), [1, 2, 3, 4]);
    assert_eq!(device.value(0x2003, 0), [5, 6, 7, 8]);
}

#[test]
fn p40_a_new_mapping_is_sent_at_once() {
    let mut device = Device::operational();
    device.set_value(0x2003, 0, &[9, 8, 7, 6]);
    for (sub, request) in [(1, 0x8000_0184), (0, 0)] {
        let index = if sub == 1 { 0x1800 } else { 0x1A00 };
        assert_eq!(
            download(
                &mut device,
                index,
                sub,
                request,
                if sub == 1 { 4 } else { 1 }
            ),
            DONE
        );
    }
    assert_eq!(write_u32(&mut device, 0x1A00, 1, 0x2003_0020), DONE);
    assert_eq!(write_u8(&mut device, 0x1A00, 0, 1), DONE);
    assert_eq!(
        device.ask("604: 23 00 18 01 84 01 00 00"),
        ["184 [4] 09 08 07 06", "584: 60 00 18 01 00 00 00 00"],
        "by identifier"
    );
}

//! SDO server on 1200h, expedited and segmented: S01 to S37 and S41 of the listed cases.

use crate::device::{Device, abort};
use canopen::Frame;
use embedded_can::{ExtendedId, Frame as _};

/// Requests with bytes 5 to 8 zero are written short: `40 00 10 00`.
fn request(start: &str) -> String {
    crate::device::full("604", start)
}

fn answer(start: &str) -> String {
    request(start).replacen("604", "584", 1)
}

#[track_caller]
fn exchange(device: &mut Device, asked: &str, expected: &str) {
    assert_eq!(
        device.ask(&request(asked)),
        [answer(expected)],
        "to {asked}"
    );
}

#[track_caller]
fn refused(device: &mut Device, asked: &str, index: u16, sub: u8, code: u32) {
    assert_eq!(
        device.ask(&request(asked)),
        [abort(index, sub, code)],
        "to {asked}"
    );
}

#[test]
fn s01_expedited_upload_of_a_u32() {
    let mut device = Device::new();
    exchange(&mut device, "40 00 10 00", "43 00 10 00 92 01 02 00");
    exchange(&mut device, "40 00 20 00", "43 00 20 00 78 56 34 12");
}

#[test]
fn s02_expedited_upload_of_other_lengths() {
    let mut device = Device::new();
    exchange(&mut device, "40 01 10 00", "4F 01 10 00 00");
    exchange(&mut device, "40 17 10 00", "4B 17 10 00 00 00");
    exchange(&mut device, "40 12 20 00", "47 12 20 00 61 62 63");
}

#[test]
fn s03_constants_cannot_be_written() {
    let mut device = Device::new();
    refused(
        &mut device,
        "23 00 10 00 01 02 03 04",
        0x1000,
        0,
        0x0601_0002,
    );
    refused(&mut device, "21 08 10 00 03", 0x1008, 0, 0x0601_0002);
    exchange(&mut device, "40 00 10 00", "43 00 10 00 92 01 02 00");
}

#[test]
fn s04_a_write_only_object_cannot_be_read() {
    let mut device = Device::new();
    refused(&mut device, "40 09 20 00", 0x2009, 0, 0x0601_0001);
    exchange(&mut device, "2B 09 20 00 34 12", "60 09 20 00");
    assert_eq!(device.value(0x2009, 0), [0x34, 0x12]);
}

#[test]
fn s05_a_missing_sub_index() {
    let mut device = Device::new();
    refused(&mut device, "40 00 10 05", 0x1000, 5, 0x0609_0011);
    refused(&mut device, "2F 17 10 01 00", 0x1017, 1, 0x0609_0011);
}

#[test]
fn s06_a_missing_object() {
    let mut device = Device::new();
    refused(&mut device, "40 04 10 00", 0x1004, 0, 0x0602_0000);
    refused(&mut device, "23 FF 5F 00", 0x5FFF, 0, 0x0602_0000);
}

#[test]
fn s07_an_unknown_command_is_refused() {
    let mut device = Device::new();
    refused(&mut device, "E0 00 10 00", 0x1000, 0, 0x0504_0001);
}

#[test]
fn s08_too_long_for_the_object() {
    let mut device = Device::new();
    refused(
        &mut device,
        "23 03 10 00 00 00 00 00",
        0x1003,
        0,
        0x0607_0012,
    );
    refused(&mut device, "2B 08 20 00 0F 00", 0x2008, 0, 0x0607_0012);
}

#[test]
fn s09_too_short_for_the_object() {
    let mut device = Device::new();
    refused(&mut device, "2F 05 10 00 80", 0x1005, 0, 0x0607_0013);
    refused(&mut device, "21 05 10 00 02", 0x1005, 0, 0x0607_0013);
}

#[test]
fn s10_an_invalid_value() {
    let mut device = Device::new();
    refused(&mut device, "2F 03 10 00 FF", 0x1003, 0, 0x0609_0030);
}

#[test]
fn s11_the_parameters_of_the_server_follow_the_node_id() {
    let mut device = Device::new();
    exchange(&mut device, "40 00 12 01", "43 00 12 01 04 06 00 00");
    exchange(&mut device, "40 00 12 02", "43 00 12 02 84 05 00 00");
    refused(&mut device, "23 00 12 01 05 06", 0x1200, 1, 0x0601_0002);
}

#[test]
fn s12_expedited_download_without_a_size() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 22 17 10 00 E8 03 00 00"),
        ["584: 60 17 10 00 00 00 00 00", "704 [1] 7F"]
    );
    assert_eq!(device.value(0x1017, 0), [0xE8, 3]);
    refused(
        &mut device,
        "22 07 20 00 01 02 03 04",
        0x2007,
        0,
        0x0607_0013,
    );
}

#[test]
fn s13_segmented_download() {
    let mut device = Device::new();
    exchange(&mut device, "21 17 10 00 02 00 00 00", "60 17 10 00");
    assert_eq!(
        device.ask("604: 0B 00 00 00 00 00 00 00"),
        ["584: 20 00 00 00 00 00 00 00"]
    );
    assert_eq!(device.value(0x1017, 0), [0, 0]);
    exchange(&mut device, "21 01 20 00 09 00 00 00", "60 01 20 00");
    exchange(&mut device, "00 61 62 63 64 65 66 67", "20");
    exchange(&mut device, "1B 68 69", "30");
    assert_eq!(device.value(0x2001, 0), b"abcdefghi");
    assert_eq!(device.firmware.written, [(0x2001, 0)]);
}

#[test]
fn s14_segmented_upload() {
    let mut device = Device::new();
    exchange(&mut device, "40 08 10 00", "41 08 10 00 10");
    exchange(&mut device, "60", "00 41 78 69 73 34 30 32");
    exchange(&mut device, "70", "10 20 74 65 73 74 20 30");
    exchange(&mut device, "60", "0B 33 32");
}

#[test]
fn s15_first_segment_with_wrong_toggle_is_refused() {
    let mut device = Device::new();
    exchange(&mut device, "40 08 10 00", "41 08 10 00 10");
    refused(&mut device, "70", 0x1008, 0, 0x0503_0000);
    refused(&mut device, "60", 0, 0, 0x0504_0001);
}

#[test]
fn s16_first_download_segment_with_wrong_toggle_is_refused() {
    let mut device = Device::new();
    exchange(&mut device, "21 17 10 00 02", "60 17 10 00");
    refused(&mut device, "1B 01 02", 0x1017, 0, 0x0503_0000);
    assert_eq!(device.value(0x1017, 0), [0, 0]);
}

#[test]
fn s16_a_repeated_segment_is_refused() {
    let mut device = Device::new();
    exchange(&mut device, "20 01 20 00", "60 01 20 00");
    exchange(&mut device, "00 61 62 63 64 65 66 67", "20");
    refused(
        &mut device,
        "00 61 62 63 64 65 66 67",
        0x2001,
        0,
        0x0503_0000,
    );
    assert_eq!(device.value(0x2001, 0), b"hello");
}

#[test]
fn s17_segmented_download_without_a_size() {
    let mut device = Device::new();
    exchange(&mut device, "20 17 10 00", "60 17 10 00");
    assert_eq!(
        device.ask("604: 0B F4 01 00 00 00 00 00"),
        ["584: 20 00 00 00 00 00 00 00", "704 [1] 7F"]
    );
    assert_eq!(device.value(0x1017, 0), [0xF4, 1]);
}

#[test]
fn s18_more_bytes_than_announced() {
    let mut device = Device::new();
    exchange(&mut device, "21 17 10 00 02", "60 17 10 00");
    refused(&mut device, "09 01 02 03", 0x1017, 0, 0x0607_0012);
    exchange(&mut device, "21 01 20 00 02", "60 01 20 00");
    refused(&mut device, "09 01 02 03", 0x2001, 0, 0x0607_0012);
    assert_eq!(device.value(0x2001, 0), b"hello");
}

#[test]
fn s19_fewer_bytes_than_announced() {
    let mut device = Device::new();
    exchange(&mut device, "21 00 20 00 04", "60 00 20 00");
    refused(&mut device, "0B 01 02", 0x2000, 0, 0x0607_0013);
    exchange(&mut device, "21 01 20 00 03", "60 01 20 00");
    refused(&mut device, "0B 01 02", 0x2001, 0, 0x0607_0013);
    assert_eq!(device.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
    assert_eq!(device.value(0x2001, 0), b"hello");
}

#[test]
fn s20_no_byte_for_a_number() {
    let mut device = Device::new();
    exchange(&mut device, "20 00 16 00", "60 00 16 00");
    refused(&mut device, "0F", 0x1600, 0, 0x0607_0013);
}

#[test]
fn s21_the_empty_string() {
    let mut device = Device::new();
    exchange(&mut device, "21 01 20 00 00", "60 01 20 00");
    exchange(&mut device, "0F", "20");
    assert!(device.value(0x2001, 0).is_empty());
    exchange(&mut device, "40 01 20 00", "41 01 20 00 00");
    exchange(&mut device, "60", "0F");
    refused(&mut device, "70", 0, 0, 0x0504_0001);
}

#[test]
fn s22_strings_around_multiples_of_seven() {
    let cases = [
        (0x0C, 6, "03"),
        (0x0D, 7, "01"),
        (0x0E, 8, "1D"),
        (0x0F, 13, "13"),
        (0x10, 14, "11"),
        (0x11, 15, "0D"),
    ];
    for (low, length, last) in cases {
        let mut device = Device::new();
        exchange(
            &mut device,
            &format!("40 {low:02X} 20 00"),
            &format!("41 {low:02X} 20 00 {length:02X}"),
        );
        let mut text = Vec::new();
        for segment in 0.. {
            let sent = device
                .ask(&request(if segment % 2 == 0 { "60" } else { "70" }))
                .remove(0);
            let frame = crate::device::frame(&sent);
            let [command, data @ ..] = frame.bytes();
            text.extend_from_slice(&data[..7 - usize::from(command >> 1 & 7)]);
            if command & 1 == 1 {
                assert_eq!(format!("{command:02X}"), last);
                break;
            }
        }
        assert_eq!(text, &b"123456789012345"[..length]);
    }
}

#[test]
fn s23_a_new_request_drops_the_open_transfer() {
    let mut device = Device::new();
    exchange(&mut device, "40 08 10 00", "41 08 10 00 10");
    exchange(&mut device, "40 00 10 00", "43 00 10 00 92 01 02 00");
    refused(&mut device, "60", 0, 0, 0x0504_0001);
    exchange(&mut device, "21 01 20 00 03", "60 01 20 00");
    exchange(&mut device, "21 0B 20 00 03", "60 0B 20 00");
    exchange(&mut device, "09 61 62 63", "20");
    assert_eq!(device.value(0x2001, 0), b"hello");
    assert_eq!(device.value(0x200B, 0), b"abc");
    assert!(
        device.pass(3000).is_empty(),
        "the dropped transfers have no time-out"
    );
}

#[test]
fn s24_a_segment_without_a_transfer() {
    let mut device = Device::new();
    refused(&mut device, "60", 0, 0, 0x0504_0001);
    refused(&mut device, "0B 01 02", 0, 0, 0x0504_0001);
    exchange(&mut device, "40 08 10 00", "41 08 10 00 10");
    refused(&mut device, "0B 01 02", 0x1008, 0, 0x0504_0001);
}

#[test]
fn s25_an_abort_gets_no_answer() {
    let mut device = Device::new();
    let abort = request("80 08 10 00 00 00 04 05");
    assert!(device.ask(&abort).is_empty());
    exchange(&mut device, "40 00 10 00", "43 00 10 00 92 01 02 00");
    exchange(&mut device, "40 08 10 00", "41 08 10 00 10");
    assert!(device.ask(&abort).is_empty());
    refused(&mut device, "60", 0, 0, 0x0504_0001);
    exchange(&mut device, "40 00 10 00", "43 00 10 00 92 01 02 00");
}

#[test]
fn s26_a_silent_client_is_aborted() {
    let mut device = Device::new();
    exchange(&mut device, "21 17 10 00 02", "60 17 10 00");
    assert_eq!(device.pass(5000), [(1000, abort(0x1017, 0, 0x0504_0000))]);
    refused(&mut device, "0B", 0, 0, 0x0504_0001);
    exchange(&mut device, "40 08 10 00", "41 08 10 00 10");
    assert_eq!(device.pass(5000), [(1000, abort(0x1008, 0, 0x0504_0000))]);
}

#[test]
fn s27_a_slow_client_completes() {
    let mut device = Device::new();
    exchange(&mut device, "21 01 20 00 38", "60 01 20 00");
    for segment in 0..8 {
        assert!(device.pass(999).is_empty());
        let (asked, expected) = match segment {
            7 => ("11 61 62 63 64 65 66 67", "30"),
            s if s % 2 == 0 => ("00 61 62 63 64 65 66 67", "20"),
            _ => ("10 61 62 63 64 65 66 67", "30"),
        };
        exchange(&mut device, asked, expected);
    }
    assert_eq!(device.value(0x2001, 0), b"abcdefg".repeat(8));
    exchange(&mut device, "40 01 20 00", "41 01 20 00 38");
    for segment in 0..8 {
        assert!(device.pass(999).is_empty());
        assert_eq!(
            device
                .ask(&request(if segment % 2 == 0 { "60" } else { "70" }))
                .len(),
            1
        );
    }
    assert!(device.pass(3000).is_empty());
}

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

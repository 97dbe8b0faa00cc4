//! SDO server on 1200h, expedited and segmented: S01 to S37 and S41 of the listed cases.

mod rules;

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

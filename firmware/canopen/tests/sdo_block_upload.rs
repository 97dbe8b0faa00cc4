//! SDO block upload: those of B01 to B28 of the listed cases in which the client reads.

use crate::device::block::{answer, crc, exchange, idle, refused, request};
use crate::device::{Device, abort};
use canopen::cia301::sdo::AbortCode;

#[test]
fn b03_an_upload_without_a_checksum() {
    let mut device = Device::new();
    exchange(&mut device, "A0 00 10 00 14", &["C6 00 10 00 04"]);
    exchange(&mut device, "A3", &["81 92 01 02 00"]);
    exchange(&mut device, "A2 01 14", &["CD 00 00"]);
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn b04_an_upload_with_a_checksum() {
    let mut device = Device::new();
    exchange(&mut device, "A4 00 10 00 14", &["C6 00 10 00 04"]);
    exchange(&mut device, "A3", &["81 92 01 02 00"]);
    let [low, high] = crc(&[0x92, 1, 2, 0]);
    exchange(
        &mut device,
        "A2 01 14",
        &[&format!("CD {low:02X} {high:02X}")],
    );
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn b05_a_block_size_of_0_or_128() {
    let mut device = Device::new();
    refused(&mut device, "A4 00 10 00 00", (0x1000, 0), 0x0504_0002);
    refused(&mut device, "A4 00 10 00 80", (0x1000, 0), 0x0504_0002);
    // In a confirmation as well, if a sub-block is to follow.
    exchange(&mut device, "A4 08 10 00 01", &["C6 08 10 00 10"]);
    exchange(&mut device, "A3", &["01 41 78 69 73 34 30 32"]);
    refused(&mut device, "A2 01 80", (0x1008, 0), 0x0504_0002);
    exchange(&mut device, "A4 08 10 00 01", &["C6 08 10 00 10"]);
    exchange(&mut device, "A3", &["01 41 78 69 73 34 30 32"]);
    refused(&mut device, "A2 01 00", (0x1008, 0), 0x0504_0002);
    // Behind the last segment it means nothing.
    exchange(&mut device, "A0 00 10 00 14", &["C6 00 10 00 04"]);
    exchange(&mut device, "A3", &["81 92 01 02 00"]);
    exchange(&mut device, "A2 01 00", &["CD"]);
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn b06_a_confirmation_of_segment_128() {
    refused_confirmation("A2 80 14");
}

#[test]
fn b07_a_confirmation_of_more_than_was_sent() {
    refused_confirmation("A2 02 14");
    refused_confirmation("A2 7F 14");
    // One that was sent and others that were not.
    let mut device = Device::new();
    exchange(&mut device, "A4 08 10 00 01", &["C6 08 10 00 10"]);
    exchange(&mut device, "A3", &["01 41 78 69 73 34 30 32"]);
    refused(&mut device, "A2 02 01", (0x1008, 0), 0x0504_0003);
}

/// One segment was sent, and this is no answer to it.
fn refused_confirmation(ack: &str) {
    let mut device = Device::new();
    exchange(&mut device, "A0 00 10 00 14", &["C6 00 10 00 04"]);
    exchange(&mut device, "A3", &["81 92 01 02 00"]);
    refused(&mut device, ack, (0x1000, 0), 0x0504_0003);
    idle(&mut device);
}

#[test]
fn b17_objects_that_cannot_be_read() {
    let mut device = Device::new();
    refused(&mut device, "A4 09 20 00 7F", (0x2009, 0), 0x0601_0001);
    refused(&mut device, "A4 FF 5F 00 7F", (0x5FFF, 0), 0x0602_0000);
    refused(&mut device, "A4 00 10 05 7F", (0x1000, 5), 0x0609_0011);
    refused(&mut device, "A4 03 10 01 7F", (0x1003, 1), 0x0800_0024);
    idle(&mut device);
}

#[test]
fn b21_the_client_changes_the_block_size() {
    let mut device = Device::new();
    device.firmware.stream.value = (0..=255).cycle().take(7 * 140).collect();
    exchange(&mut device, "A0 14 20 00 01", &["C6 14 20 00 D4 03"]);
    for (asked, segments) in [
        ("A3", 1),
        ("A2 01 7F", 127),
        ("A2 7F 04", 4),
        ("A2 04 05", 5),
    ] {
        let sent = device.ask(&request(asked));
        assert_eq!(sent.len(), segments, "after {asked}");
        for (seqno, frame) in (1..).zip(sent) {
            assert!(frame.starts_with(&format!("584: {seqno:02X}")), "{frame}");
        }
    }
    let rest = device.ask(&request("A2 05 7F"));
    assert_eq!(rest.len(), 3);
    assert!(rest[2].starts_with("584: 83"));
    exchange(&mut device, "A2 03 7F", &["C1 00 00"]);
}

#[test]
fn b22_a_last_segment_that_is_full() {
    let mut device = Device::new();
    device.set_value(0x2001, 0, b"ABCDEFGHIJKLMN");
    exchange(&mut device, "A4 01 20 00 7F", &["C6 01 20 00 0E"]);
    exchange(
        &mut device,
        "A3",
        &["01 41 42 43 44 45 46 47", "82 48 49 4A 4B 4C 4D 4E"],
    );
    exchange(&mut device, "A2 02 7F", &["C1 D6 38"]);
    exchange(&mut device, "A1", &[]);
    // Said once more it is no request.
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn b23_what_was_lost_is_sent_again() {
    let mut device = Device::new();
    device.set_value(0x2001, 0, b"ABCDEFGHIJKLMNOPQRST");
    exchange(&mut device, "A4 01 20 00 03", &["C6 01 20 00 14"]);
    let all = [
        "01 41 42 43 44 45 46 47",
        "02 48 49 4A 4B 4C 4D 4E",
        "83 4F 50 51 52 53 54",
    ];
    exchange(&mut device, "A3", &all);
    exchange(
        &mut device,
        "A2 01 03",
        &["01 48 49 4A 4B 4C 4D 4E", "82 4F 50 51 52 53 54"],
    );
    // Nothing of it has come.
    exchange(&mut device, "A2 00 01", &["01 48 49 4A 4B 4C 4D 4E"]);
    exchange(&mut device, "A2 01 01", &["81 4F 50 51 52 53 54"]);
    exchange(&mut device, "A2 01 03", &["C5 34 10"]);
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn an_upload_gives_way_to_a_new_request() {
    let mut device = Device::new();
    exchange(&mut device, "A4 08 10 00 01", &["C6 08 10 00 10"]);
    exchange(&mut device, "A3", &["01 41 78 69 73 34 30 32"]);
    exchange(&mut device, "40 00 10 00", &["43 00 10 00 92 01 02 00"]);
    assert!(device.pass(2_000).is_empty());
}

#[test]
fn b23_a_client_confirms_before_all_is_sent() {
    let mut device = Device::new();
    device.set_value(0x2001, 0, b"ABCDEFGHIJKLMNOPQRST");
    exchange(&mut device, "A4 01 20 00 03", &["C6 01 20 00 14"]);
    device.send(&request("A3"));
    let first = device.node.transmit(&mut device.firmware).unwrap();
    assert_eq!(
        crate::device::show(&first),
        answer("01 41 42 43 44 45 46 47")
    );
    let second = device.node.transmit(&mut device.firmware).unwrap();
    assert_eq!(
        crate::device::show(&second),
        answer("02 48 49 4A 4B 4C 4D 4E")
    );
    exchange(
        &mut device,
        "A2 01 7F",
        &["01 48 49 4A 4B 4C 4D 4E", "82 4F 50 51 52 53 54"],
    );
    exchange(&mut device, "A2 02 03", &["C5 34 10"]);
}

#[test]
fn b24_an_abort_stops_the_segments() {
    let mut device = Device::new();
    device.firmware.stream.value = vec![1; 500];
    exchange(&mut device, "A4 14 20 00 7F", &["C6 14 20 00 F4 01"]);
    device.send(&request("A3"));
    for _ in 0..5 {
        assert!(device.node.transmit(&mut device.firmware).is_some());
    }
    exchange(&mut device, "80 14 20 00 00 00 00 08", &[]);
    idle(&mut device);
}

#[test]
fn b24_an_abort_lets_heartbeats_go_on() {
    let mut device = Device::new();
    device.firmware.stream.value = vec![1; 500];
    device.ask(&request("2B 17 10 00 64"));
    exchange(&mut device, "A4 14 20 00 7F", &["C6 14 20 00 F4 01"]);
    device.send(&request("A3"));
    assert!(device.node.transmit(&mut device.firmware).is_some());
    exchange(&mut device, "80 14 20 00 00 00 00 08", &[]);
    let sent = device.pass(350);
    assert_eq!(sent.len(), 3, "{sent:?}");
}

#[test]
fn b24_process_data_goes_between_the_segments() {
    let mut device = Device::operational();
    device.firmware.stream.value = vec![1; 70];
    exchange(&mut device, "A4 14 20 00 7F", &["C6 14 20 00 46"]);
    device.send(&request("A3"));
    let first = device.node.transmit(&mut device.firmware).unwrap();
    assert_eq!(first.standard_id(), Some(0x584));
    device.set_value(0x2005, 0, &[1, 2, 3, 4]);
    device.poll();
    let sent = device.sent();
    assert_eq!(sent.len(), 10);
    assert_eq!(sent[0], "184: 01 02 03 04 00 00 00 00");
    assert!(sent[1].starts_with("584: 02"));
}

#[test]
fn b25_a_short_value_is_sent_without_blocks() {
    let mut device = Device::new();
    exchange(
        &mut device,
        "A0 00 10 00 01 14",
        &["43 00 10 00 92 01 02 00"],
    );
    exchange(&mut device, "A4 08 10 00 7F 10", &["41 08 10 00 10"]);
    exchange(&mut device, "60", &["00 41 78 69 73 34 30 32"]);
    // One byte more than the client wants so.
    exchange(&mut device, "A4 08 10 00 7F 0F", &["C6 08 10 00 10"]);
    exchange(&mut device, "80", &[]);
    device.firmware.stream.value = vec![7, 8];
    exchange(&mut device, "A4 14 20 00 7F 02", &["4B 14 20 00 07 08"]);
    idle(&mut device);
}

#[test]
fn b26_a_sub_block_that_waits_for_the_bus_is_no_silence() {
    let mut device = Device::new();
    device.firmware.stream.value = vec![1; 7 * 127];
    exchange(&mut device, "A4 14 20 00 7F", &["C6 14 20 00 79 03"]);
    device.send(&request("A3"));
    // A slow bus: each segment takes 13 ms, the sub-block more than the time-out.
    for _ in 0..127 {
        assert!(device.node.transmit(&mut device.firmware).is_some());
        device.now += canopen::Duration::millis(13);
        device.poll();
    }
    assert!(device.sent().is_empty());
    device.now += canopen::Duration::millis(900);
    let [low, high] = crc(&[1; 7 * 127]);
    exchange(
        &mut device,
        "A2 7F 7F",
        &[&format!("C1 {low:02X} {high:02X}")],
    );
}

#[test]
fn b27_the_application_cannot_give_more() {
    let mut device = Device::new();
    device.firmware.stream.value = vec![1; 1000];
    device.firmware.stream.fails_at = Some((950, AbortCode::HardwareError));
    exchange(&mut device, "A4 14 20 00 7F", &["C6 14 20 00 E8 03"]);
    assert_eq!(device.ask(&request("A3")).len(), 127);
    // It was asked for 900 bytes at once, as many as the buffer holds: there is one segment more.
    let sent = device.ask(&request("A2 7F 7F"));
    assert_eq!(sent.len(), 2);
    assert_eq!(sent[1], abort(0x2014, 0, 0x0606_0000));
    idle(&mut device);
}

#[test]
fn b27_the_application_has_less_than_it_has_said() {
    for first in ["A4 14 20 00 7F", "40 14 20 00"] {
        let mut device = Device::new();
        device.firmware.stream.value = vec![1; 1_000];
        device.firmware.stream.missing = 10;
        let mut sent = device.ask(&request(first));
        let next = if first.starts_with('A') {
            ["A3", "A2 7F 7F"]
        } else {
            ["60", "70"]
        };
        for number in 0..200 {
            if sent.last() == Some(&abort(0x2014, 0, 0x0800_0020)) {
                break;
            }
            let segments = sent.len();
            sent = device.ask(&request(next[number % 2]));
            assert!(!sent.is_empty(), "behind {segments} frames");
            if first.starts_with('A') && number > 0 {
                assert!(number < 3, "{sent:?}");
            }
        }
        assert_eq!(sent.last(), Some(&abort(0x2014, 0, 0x0800_0020)), "{first}");
        idle(&mut device);
    }
}

#[test]
fn b28_a_request_right_after_the_end() {
    let mut device = Device::new();
    exchange(&mut device, "A4 00 10 00 7F", &["C6 00 10 00 04"]);
    exchange(&mut device, "A3", &["81 92 01 02 00"]);
    device.ask(&request("A2 01 7F"));
    device.put(&request("A1"));
    device.put(&request("40 00 10 00"));
    assert_eq!(device.sent(), [answer("43 00 10 00 92 01 02 00")]);
}

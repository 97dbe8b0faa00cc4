//! SDO block download: those of B01 to B28 of the listed cases in which the client writes.

use crate::device::block::{
    INVALID_COMMAND, LETTERS, OPEN, READY, TIMED_OUT, answer, crc, exchange, idle, open_letters,
    refused, request, segment,
};
use crate::device::{Device, abort};
use canopen::cia301::sdo::AbortCode;

#[test]
fn b01_a_download_of_twenty_bytes() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[2], &["A2 03 7F"]);
    assert_eq!(device.value(0x2001, 0), b"hello");
    exchange(&mut device, "C5 34 10", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
    assert_eq!(device.firmware.written, [(0x2001, 0)]);
    idle(&mut device);
}

#[test]
fn b02_a_download_without_a_checksum() {
    let mut device = Device::new();
    exchange(&mut device, "C2 17 10 00 02", &["A4 17 10 00 7F"]);
    exchange(&mut device, "81 00 00", &["A2 01 7F"]);
    exchange(&mut device, "D5", &["A1"]);
    // What stands in its place is no checksum.
    exchange(&mut device, "C2 01 20 00 03", &["A4 01 20 00 7F"]);
    exchange(&mut device, "81 41 42 43", &["A2 01 7F"]);
    exchange(&mut device, "D1 FF FF", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABC");
    idle(&mut device);
}

#[test]
fn b08_a_segment_is_lost() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[2], &["A2 01 7F"]);
    exchange(&mut device, "01 48 49 4A 4B 4C 4D 4E", &[]);
    exchange(&mut device, "82 4F 50 51 52 53 54 00", &["A2 02 7F"]);
    exchange(&mut device, "C5 34 10", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
}

/// Half of the server's patience is over without a word of the client, and there is nothing to confirm.
#[test]
fn b09_the_first_segment_of_a_slow_client_is_lost() {
    let mut device = Device::new();
    open_letters(&mut device);
    assert!(device.pass(600).is_empty());
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[2], &["A2 00 7F"]);
    for segment in &LETTERS[..2] {
        exchange(&mut device, segment, &[]);
    }
    exchange(&mut device, LETTERS[2], &["A2 03 7F"]);
    exchange(&mut device, "C5 34 10", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
}

/// A client that has missed the reminder, and falls silent when it is told.
#[test]
fn b26_a_transfer_that_was_aborted_in_a_sub_block_has_no_time_out() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    assert_eq!(device.pass(600), [(500, answer("A2 01 7F"))]);
    refused(&mut device, LETTERS[1], (0x2001, 0), 0x0504_0003);
    assert!(device.pass(3_000).is_empty());
    assert_eq!(device.value(0x2001, 0), b"hello");
    idle(&mut device);
}

#[test]
fn b09_the_first_segment_is_lost() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[2], &["A2 00 7F"]);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[2], &["A2 03 7F"]);
    exchange(&mut device, "C5 34 10", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b10_the_last_segment_is_lost() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    let sent = device.pass(2000);
    let expected = [
        (500, answer("A2 02 7F")),
        (1000, abort(0x2001, 0, TIMED_OUT)),
    ];
    assert_eq!(sent, expected);
    // A client that listens goes on.
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    assert_eq!(device.pass(700), [(500, answer("A2 02 7F"))]);
    exchange(&mut device, "81 4F 50 51 52 53 54 00", &["A2 01 7F"]);
    exchange(&mut device, "C5 34 10", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b10_a_client_that_pauses_and_goes_on_in_its_sub_block_does_not_write_twice() {
    // A size and a checksum are not told: nothing else would find it.
    let mut device = Device::new();
    exchange(&mut device, "C0 01 20 00", &[READY]);
    exchange(&mut device, LETTERS[0], &[]);
    assert_eq!(device.pass(600), [(500, answer("A2 01 7F"))]);
    refused(&mut device, LETTERS[1], (0x2001, 0), 0x0504_0003);
    // The rest of the sub-block is under way.
    exchange(&mut device, LETTERS[2], &[]);
    assert_eq!(device.value(0x2001, 0), b"hello");
    idle(&mut device);

    // One that has heard it begins anew with what was not confirmed.
    exchange(&mut device, "C0 01 20 00", &[READY]);
    exchange(&mut device, LETTERS[0], &[]);
    assert_eq!(device.pass(600), [(500, answer("A2 01 7F"))]);
    exchange(&mut device, "01 48 49 4A 4B 4C 4D 4E", &[]);
    exchange(&mut device, "82 4F 50 51 52 53 54 00", &["A2 02 7F"]);
    exchange(&mut device, "C5", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b11_repeated_segments_count_once() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[2], &["A2 03 7F"]);
    // It looks like an abort, and is none.
    exchange(&mut device, LETTERS[2], &[]);
    exchange(&mut device, "C5 34 10", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"ABCDEFGHIJKLMNOPQRST");
}

#[test]
fn b11_the_segment_that_closes_a_sub_block_is_repeated() {
    let mut device = Device::new();
    exchange(&mut device, "C0 14 20 00", &["A4 14 20 00 7F"]);
    for seqno in 1..=126 {
        assert!(device.ask(&segment(seqno, false, &[seqno; 7])).is_empty());
    }
    assert_eq!(
        device.ask(&segment(127, false, &[127; 7])),
        [answer("A2 7F 7F")]
    );
    assert!(device.ask(&segment(127, false, &[127; 7])).is_empty());
    assert_eq!(device.ask(&segment(1, true, &[1; 7])), [answer("A2 01 7F")]);
    exchange(&mut device, "C1", &["A1"]);
    assert_eq!(device.firmware.stream.value.len(), 128 * 7);
}

#[test]
fn b12_a_segment_number_of_0() {
    let mut device = Device::new();
    open_letters(&mut device);
    refused(
        &mut device,
        "00 41 42 43 44 45 46 47",
        (0x2001, 0),
        0x0504_0003,
    );
    idle(&mut device);
}

#[test]
fn b13_the_client_aborts_within_a_sub_block() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, "80 01 20 00 00 00 00 08", &[]);
    idle(&mut device);
    assert_eq!(device.value(0x2001, 0), b"hello");
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    exchange(&mut device, LETTERS[2], &["A2 03 7F"]);
    exchange(&mut device, "80 01 20 00 00 00 00 08", &[]);
    idle(&mut device);
    assert_eq!(device.value(0x2001, 0), b"hello");
}

#[test]
fn b14_a_wrong_checksum() {
    let mut device = Device::new();
    exchange(&mut device, "C6 17 10 00 02", &["A4 17 10 00 7F"]);
    exchange(&mut device, "81 E8 03", &["A2 01 7F"]);
    refused(&mut device, "D5 FF FF", (0x1017, 0), 0x0504_0004);
    assert_eq!(device.value(0x1017, 0), [0, 0]);
    idle(&mut device);
}

#[test]
fn b15_an_end_that_does_not_fit_the_size() {
    for end in ["C1 34 10", "C9 34 10", "D9 34 10"] {
        let mut device = Device::new();
        open_letters(&mut device);
        exchange(&mut device, LETTERS[0], &[]);
        exchange(&mut device, LETTERS[1], &[]);
        exchange(&mut device, LETTERS[2], &["A2 03 7F"]);
        refused(&mut device, end, (0x2001, 0), 0x0607_0010);
        assert_eq!(device.value(0x2001, 0), b"hello");
        idle(&mut device);
    }
}

#[test]
fn b16_an_end_before_the_last_segment() {
    let mut device = Device::new();
    open_letters(&mut device);
    exchange(&mut device, LETTERS[0], &[]);
    exchange(&mut device, LETTERS[1], &[]);
    refused(&mut device, "C5 34 10", (0x2001, 0), INVALID_COMMAND);
    idle(&mut device);
    open_letters(&mut device);
    refused(&mut device, "C1 34 10", (0x2001, 0), INVALID_COMMAND);
    refused(&mut device, "C1 34 10", (0, 0), INVALID_COMMAND);
}

#[test]
fn b16_a_last_segment_behind_a_gap_is_no_end() {
    // The 65th segment has the command of an end frame, and here nothing but zeros after its first bytes.
    let mut device = Device::new();
    let size = 64 * 7 + 2;
    exchange(
        &mut device,
        &format!("C2 14 20 00 {:02X} {:02X}", size % 256, size / 256),
        &["A4 14 20 00 7F"],
    );
    for seqno in 1..=63 {
        device.ask(&segment(seqno, false, &[1; 7]));
    }
    assert_eq!(
        device.ask(&segment(65, true, &[1, 1])),
        [answer("A2 3F 7F")]
    );
    device.ask(&segment(1, false, &[1; 7]));
    assert_eq!(device.ask(&segment(2, true, &[1, 1])), [answer("A2 02 7F")]);
    exchange(&mut device, "D5", &["A1"]);
    assert_eq!(device.firmware.stream.value, vec![1; size]);
}

#[test]
fn b17_objects_that_cannot_be_written() {
    let mut device = Device::new();
    refused(&mut device, "C2 00 10 00 04", (0x1000, 0), 0x0601_0002);
    refused(&mut device, "C2 04 10 00 04", (0x1004, 0), 0x0602_0000);
    refused(&mut device, "C2 00 10 05 04", (0x1000, 5), 0x0609_0011);
    idle(&mut device);
}

#[test]
fn b18_sizes_that_do_not_fit() {
    let mut device = Device::new();
    refused(&mut device, "C2 00 20 00 05", (0x2000, 0), 0x0607_0012);
    refused(&mut device, "C2 00 20 00 03", (0x2000, 0), 0x0607_0013);
    refused(&mut device, "C2 01 20 00 41", (0x2001, 0), 0x0607_0012);
    refused(
        &mut device,
        "C2 01 20 00 00 00 00 80",
        (0x2001, 0),
        0x0607_0012,
    );
    // Not announced: as soon as it shows. The rest of the sub-block are no requests.
    exchange(&mut device, "C0 0B 20 00", &["A4 0B 20 00 7F"]);
    for seqno in 1..=4 {
        assert!(device.ask(&segment(seqno, false, &[1; 7])).is_empty());
    }
    assert_eq!(
        device.ask(&segment(5, false, &[1; 7])),
        [abort(0x200B, 0, 0x0607_0012)]
    );
    for seqno in 6..=127 {
        assert!(device.ask(&segment(seqno, false, &[0; 7])).is_empty());
    }
    idle(&mut device);
}

#[test]
fn b19_a_download_of_nothing() {
    let mut device = Device::new();
    // A number has bytes.
    refused(&mut device, "C2 00 20 00", (0x2000, 0), 0x0607_0013);
    exchange(&mut device, "C0 00 20 00", &["A4 00 20 00 7F"]);
    exchange(&mut device, "81", &["A2 01 7F"]);
    refused(&mut device, "DD", (0x2000, 0), 0x0607_0013);
    // A string may be empty, with a segment that holds nothing or without one.
    exchange(&mut device, "C2 01 20 00", &["A4 01 20 00 7F"]);
    exchange(&mut device, "81", &["A2 01 7F"]);
    exchange(&mut device, "DD", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"");
    device.set_value(0x2001, 0, b"full");
    exchange(&mut device, "C6 01 20 00", &["A4 01 20 00 7F"]);
    exchange(&mut device, "C1", &["A1"]);
    assert_eq!(device.value(0x2001, 0), b"");
    // And it is read in one segment.
    exchange(&mut device, "A4 01 20 00 7F", &["C6 01 20 00 00"]);
    exchange(&mut device, "A3", &["81"]);
    exchange(&mut device, "A2 01 7F", &["DD"]);
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn b20_two_sub_blocks() {
    let mut device = Device::new();
    let data: Vec<u8> = (0..890_u32).map(|n| (n * 7) as u8).collect();
    // To the buffer, as the object is a string; the whole of it is written at the end.
    exchange(&mut device, "C6 16 20 00 7A 03", &["A4 16 20 00 7F"]);
    for (number, chunk) in data.chunks(7).enumerate() {
        let seqno = (number % 127 + 1) as u8;
        let sent = device.ask(&segment(seqno, number == 127, chunk));
        match number {
            126 => assert_eq!(sent, [answer("A2 7F 7F")]),
            127 => assert_eq!(sent, [answer("A2 01 7F")]),
            _ => assert!(sent.is_empty()),
        }
    }
    let [low, high] = crc(&data);
    exchange(&mut device, &format!("D9 {low:02X} {high:02X}"), &["A1"]);
    assert_eq!(device.value(0x2016, 0), data);
    // And back.
    exchange(&mut device, "A4 16 20 00 7F", &["C6 16 20 00 7A 03"]);
    let first = device.ask(&request("A3"));
    assert_eq!(first.len(), 127);
    let second = device.ask(&request("A2 7F 7F"));
    assert_eq!(second.len(), 1);
    for (number, chunk) in data.chunks(7).enumerate() {
        let seqno = (number % 127 + 1) as u8;
        let expected = segment(seqno, number == 127, chunk).replacen("604", "584", 1);
        let sent = first.iter().chain(&second).nth(number);
        assert_eq!(sent, Some(&expected));
    }
    exchange(
        &mut device,
        "A2 01 7F",
        &[&format!("D9 {low:02X} {high:02X}")],
    );
    exchange(&mut device, "A1", &[]);
    idle(&mut device);
}

#[test]
fn b26_the_client_falls_silent() {
    let waits: [(&[&str], u16); 5] = [
        (&[OPEN, LETTERS[0], LETTERS[1], LETTERS[2]], 0x2001),
        (&["A4 08 10 00 7F"], 0x1008),
        (&["A4 08 10 00 7F", "A3"], 0x1008),
        (&["A4 08 10 00 7F", "A3", "A2 03 7F"], 0x1008),
        (&[OPEN], 0x2001),
    ];
    for (requests, index) in waits {
        let mut device = Device::new();
        for asked in requests {
            device.ask(&request(asked));
        }
        let mut sent = device.pass(5000);
        sent.retain(|(_, frame)| !frame.starts_with("584: A2"));
        assert_eq!(
            sent,
            [(1000, abort(index, 0, TIMED_OUT))],
            "after {requests:?}"
        );
        exchange(&mut device, "A3", &[&abort(0, 0, INVALID_COMMAND)[5..]]);
    }
}

#[test]
fn b27_the_application_cannot_take_more() {
    for code in [AbortCode::HardwareError, AbortCode::NotTransferable] {
        let mut device = Device::new();
        device.firmware.stream.fails_at = Some((10, code));
        exchange(&mut device, "C2 14 20 00 46", &["A4 14 20 00 7F"]);
        assert!(device.ask(&segment(1, false, &[1; 7])).is_empty());
        assert_eq!(
            device.ask(&segment(2, false, &[1; 7])),
            [abort(0x2014, 0, code.get())]
        );
        // Segments under way.
        assert!(device.ask(&segment(3, false, &[1; 7])).is_empty());
        assert!(device.ask(&segment(4, false, &[1; 7])).is_empty());
        idle(&mut device);
        assert_eq!(device.firmware.stream.abandoned, 0, "it knows");
    }
}

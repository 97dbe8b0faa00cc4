//! Frames of block transfers, and twenty letters that go to 2001h.

use super::{Device, abort, full};

pub const TIMED_OUT: u32 = 0x0504_0000;
pub const INVALID_COMMAND: u32 = 0x0504_0001;

/// A frame of the client; bytes that are left out are zero.
pub fn request(start: &str) -> String {
    full("604", start)
}

pub fn answer(start: &str) -> String {
    request(start).replacen("604", "584", 1)
}

/// Sends a frame and expects these answers, none for an empty list.
#[track_caller]
pub fn exchange(device: &mut Device, asked: &str, expected: &[&str]) {
    let expected: Vec<String> = expected.iter().map(|start| answer(start)).collect();
    assert_eq!(device.ask(&request(asked)), expected, "to {asked}");
}

#[track_caller]
pub fn refused(device: &mut Device, asked: &str, object: (u16, u8), code: u32) {
    let expected = [abort(object.0, object.1, code)];
    assert_eq!(device.ask(&request(asked)), expected, "to {asked}");
}

/// Nothing is open: the next request is served, and no time-out comes.
#[track_caller]
pub fn idle(device: &mut Device) {
    exchange(device, "40 00 10 00", &["43 00 10 00 92 01 02 00"]);
    assert!(device.pass(3000).is_empty());
}

/// Segment number `seqno` of a sub-block as a client writes it.
pub fn segment(seqno: u8, last: bool, data: &[u8]) -> String {
    let bytes: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
    request(&format!("{:02X}{bytes}", seqno | u8::from(last) << 7))
}

/// CRC-16/XMODEM, bit by bit.
pub fn crc(data: &[u8]) -> [u8; 2] {
    let mut crc = 0_u16;
    for byte in data {
        crc ^= u16::from(*byte) << 8;
        for _ in 0..8 {
            crc = crc << 1 ^ if crc >> 15 == 1 { 0x1021 } else { 0 };
        }
    }
    crc.to_le_bytes()
}

/// Twenty letters go to 2001h.
pub const LETTERS: [&str; 3] = [
    "01 41 42 43 44 45 46 47",
    "02 48 49 4A 4B 4C 4D 4E",
    "83 4F 50 51 52 53 54 00",
];
pub const OPEN: &str = "C6 01 20 00 14";
pub const READY: &str = "A4 01 20 00 7F";

#[track_caller]
pub fn open_letters(device: &mut Device) {
    exchange(device, OPEN, &[READY]);
}

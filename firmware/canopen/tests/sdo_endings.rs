//! How a transfer ends beside its last segment: by the client's abort on a busy bus or in silence, and by the time of
//! its frames. What comes after it is served at once.

use crate::device::{Device, abort};
use canopen::Duration;

const OPEN_DOWNLOAD: &str = "604: 21 01 20 00 05 00 00 00";
const TIMED_OUT: u32 = 0x0504_0000;
/// Opens a block download of 2014h, and the answer.
const OPEN_BLOCK: &str = "604: C0 14 20 00 00 00 00 00";
const READY: &str = "584: A4 14 20 00 7F 00 00 00";
/// Aborts a transfer of 2014h.
const ABORT: &str = "604: 80 14 20 00 00 00 00 08";
const READ: &str = "604: 40 00 10 00 00 00 00 00";
const VALUE: &str = "584: 43 00 10 00 92 01 02 00";

/// Time passes; the device is not called.
fn wait(device: &mut Device, milliseconds: u64) {
    device.now += Duration::millis(milliseconds);
}

/// The first segments of a sub-block of 500 bytes from 2014h have been sent.
fn in_sub_block(device: &mut Device) {
    device.firmware.stream.value = vec![1; 500];
    assert_eq!(
        device.ask("604: A4 14 20 00 7F 00 00 00"),
        ["584: C6 14 20 00 F4 01 00 00"]
    );
    device.send("604: A3 00 00 00 00 00 00 00");
    for _ in 0..5 {
        let segment = device.node.transmit(&mut device.firmware).unwrap();
        assert_eq!(segment.standard_id(), Some(0x584));
    }
}

/// Segments 1 to `last`, of ones.
fn send_segments(device: &mut Device, last: u8) {
    for seqno in 1..=last {
        assert!(
            device
                .ask(&format!("604: {seqno:02X} 01 01 01 01 01 01 01"))
                .is_empty()
        );
    }
}

/// Orders another bit rate by LSS: 600 ms of silence.
fn switch_bit_rate(device: &mut Device) {
    for request in [
        "7E5: 04 01 00 00 00 00 00 00",
        "7E5: 13 00 02 00 00 00 00 00",
        "7E5: 15 2C 01 00 00 00 00 00",
    ] {
        device.send(request);
    }
}

#[test]
fn an_abort_needs_no_room_for_an_answer() {
    let mut device = Device::new();
    assert_eq!(device.ask("604: 40 01 20 00 00 00 00 00").len(), 1);
    device.put("604: 40 00 10 00 00 00 00 00");
    device.put("604: 21 01 20 00 03 00 00 00");
    assert_eq!(device.node.overflows(), 0);
    device.put("604: 80 01 20 00 00 00 00 00");
    assert_eq!(device.node.overflows(), 0, "nothing is lost");
    assert_eq!(device.sent().len(), 2);
    assert_eq!(
        device.ask("604: 09 61 62 63 00 00 00 00"),
        [abort(0, 0, 0x0504_0001)],
        "no transfer is open"
    );
    assert!(device.pass(2000).is_empty(), "nor times out");
}

#[test]
fn s26_a_segment_that_comes_too_late_ends_the_transfer() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_DOWNLOAD), ["584: 60 01 20 00 00 00 00 00"]);
    wait(&mut device, 1000);
    // The frame is served before time is.
    device.put("604: 05 61 62 63 64 65 00 00");
    assert_eq!(device.sent(), [abort(0x2001, 0, TIMED_OUT)]);
    assert_eq!(device.value(0x2001, 0)[..5], *b"hello");
    assert!(device.pass(2000).is_empty(), "told once");

    assert_eq!(
        device.ask("604: 40 01 20 00 00 00 00 00"),
        ["584: 41 01 20 00 05 00 00 00"]
    );
    wait(&mut device, 1000);
    device.put("604: 60 00 00 00 00 00 00 00");
    assert_eq!(device.sent(), [abort(0x2001, 0, TIMED_OUT)]);
}

#[test]
fn s26_a_block_upload_that_goes_on_too_late_is_ended() {
    const OPEN: &str = "604: A4 14 20 00 7F 00 00 00";
    const START: &str = "604: A3 00 00 00 00 00 00 00";
    let mut device = Device::new();
    device.firmware.stream.value = vec![1; 7];
    assert_eq!(device.ask(OPEN), ["584: C6 14 20 00 07 00 00 00"]);
    wait(&mut device, 1000);
    // The frame is served before time is.
    device.put(START);
    assert_eq!(device.sent(), [abort(0x2014, 0, TIMED_OUT)]);

    assert_eq!(device.ask(OPEN), ["584: C6 14 20 00 07 00 00 00"]);
    assert_eq!(device.ask(START), ["584: 81 01 01 01 01 01 01 01"]);
    let end = device.ask("604: A2 01 7F 00 00 00 00 00");
    assert_eq!(end, ["584: C1 04 35 00 00 00 00 00"]);
    wait(&mut device, 1000);
    device.put("604: A1 00 00 00 00 00 00 00");
    assert_eq!(device.sent(), [abort(0x2014, 0, TIMED_OUT)]);
}

#[test]
fn s27_a_segment_just_in_time_is_taken() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_DOWNLOAD), ["584: 60 01 20 00 00 00 00 00"]);
    device.now += Duration::micros(999_999);
    device.put("604: 05 61 62 63 64 65 00 00");
    assert_eq!(device.sent(), ["584: 20 00 00 00 00 00 00 00"]);
}

#[test]
fn b24_heartbeats_go_on_after_an_abort_within_a_sub_block() {
    let mut device = Device::new();
    let answered = ["584: 60 17 10 00 00 00 00 00", "704 [1] 7F"];
    assert_eq!(device.ask("604: 2B 17 10 00 64 00 00 00"), answered);
    in_sub_block(&mut device);
    assert!(device.ask(ABORT).is_empty());
    let expected = [100, 200, 300].map(|moment| (moment, "704 [1] 7F".to_owned()));
    assert_eq!(device.pass(350), expected);
}

#[test]
fn b24_other_servers_go_on_after_an_abort_within_a_sub_block() {
    let mut device = Device::new();
    for write in [
        "604: 23 01 12 01 A4 06 00 00",
        "604: 23 01 12 02 84 06 00 00",
    ] {
        assert_eq!(device.ask(write).len(), 1);
    }
    in_sub_block(&mut device);
    device.put("6A4: 40 00 10 00 00 00 00 00");
    device.put(ABORT);
    assert_eq!(device.sent(), [VALUE.replacen("584", "684", 1)]);
    assert_eq!(device.ask(READ), [VALUE]);
}

#[test]
fn b26_a_request_right_after_the_time_out_of_a_sub_block() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_BLOCK), [READY]);
    // The command of the request looks like the next segment.
    send_segments(&mut device, 0x3F);
    wait(&mut device, 1000);
    device.poll();
    assert_eq!(device.sent(), [abort(0x2014, 0, TIMED_OUT)]);
    assert_eq!(device.ask(READ), [VALUE]);
}

#[test]
fn b10_nothing_is_confirmed_before_a_segment_has_come() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_BLOCK), [READY]);
    let expected = [(1000, abort(0x2014, 0, TIMED_OUT))];
    assert_eq!(device.pass(2000), expected);
}

#[test]
fn b10_a_sub_block_without_its_first_and_its_last_segment() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_BLOCK), [READY]);
    assert!(device.ask("604: 02 02 02 02 02 02 02 02").is_empty());
    let expected = [(500, "584: A2 00 7F 00 00 00 00 00".to_owned())];
    assert_eq!(device.pass(600), expected);
    assert!(device.ask("604: 01 01 01 01 01 01 01 01").is_empty());
    assert!(device.ask("604: 02 02 02 02 02 02 02 02").is_empty());
    assert_eq!(
        device.ask("604: 83 03 03 03 03 03 03 03"),
        ["584: A2 03 7F 00 00 00 00 00"]
    );
}

#[test]
fn an_abort_counts_in_the_silence_around_a_switch_of_the_bit_rate() {
    let mut device = Device::new();
    in_sub_block(&mut device);
    switch_bit_rate(&mut device);
    device.put(ABORT);
    assert!(device.pass(590).is_empty());
    assert_eq!(
        device.pass(20),
        [(10, "7E4: 13 00 00 00 00 00 00 00".to_owned())],
        "the answer that waited, and no segment"
    );
}

#[test]
fn a_streamed_object_is_free_after_an_abort_in_silence() {
    let mut device = Device::new();
    assert_eq!(device.ask(OPEN_BLOCK), [READY]);
    switch_bit_rate(&mut device);
    device.put(ABORT);
    assert_eq!(device.firmware.stream.abandoned, 1);
    // Anything else has no effect: no heartbeat comes.
    device.put("604: 2B 17 10 00 64 00 00 00");
    assert_eq!(
        device.pass(1000),
        [(600, "7E4: 13 00 00 00 00 00 00 00".to_owned())]
    );
    assert_eq!(device.ask(OPEN_BLOCK), [READY]);
}

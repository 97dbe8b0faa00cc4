//! Transmit PDOs that are asked for, and those that begin at a certain SYNC.

use std::vec::Vec;

use super::device::{Device, mapped};

const U8: u32 = mapped(0x2000, 0, 8);

/// PDO 1 with this type, requests allowed or not; nothing waits any more after entering Operational.
fn operational(kind: u8, allows_request: bool) -> Device {
    let mut device = Device::new();
    device.put(0x2000, &[1]);
    device.map(0x1800, 0, kind, &[U8]).unwrap();
    if !allows_request {
        device.write_u32(0x1800, 1, 0x4000_0184).unwrap();
    }
    device.enter_operational();
    device.sent();
    device
}

fn frame(byte: u8) -> Vec<(u16, Vec<u8>)> {
    std::vec![(0x184, std::vec![byte])]
}

#[test]
fn p39_type_252_answers_with_the_values_of_the_last_sync() {
    let mut device = operational(252, true);
    device.put(0x2000, &[2]);
    device.sync();
    device.put(0x2000, &[3]);
    assert_eq!(device.after(1), [], "only on request");
    device.request(0x184);
    assert_eq!(device.sent(), frame(2));
    device.request(0x184);
    assert_eq!(device.sent(), frame(2));
    device.sync();
    device.request(0x184);
    assert_eq!(device.sent(), frame(3));
}

#[test]
fn p39_type_252_answers_before_the_first_sync_with_the_values_of_the_start() {
    let mut device = operational(252, true);
    device.put(0x2000, &[2]);
    device.request(0x184);
    assert_eq!(device.sent(), frame(1));
}

#[test]
fn p39_type_253_answers_with_the_present_values() {
    let mut device = operational(253, true);
    device.put(0x2000, &[2]);
    assert_eq!(device.after(1), [], "only on request");
    device.request(0x184);
    assert_eq!(device.sent(), frame(2));
    device.sync();
    assert_eq!(device.after(1000), []);
}

#[test]
fn p39_types_that_are_for_requests_answer_whatever_bit_30_says() {
    for kind in [252, 253] {
        let mut device = operational(kind, false);
        device.request(0x184);
        assert_eq!(device.sent(), frame(1));
    }
}

#[test]
fn p14_bit_30_decides_whether_the_other_types_answer() {
    for kind in [0, 1, 240, 254, 255] {
        let mut device = operational(kind, true);
        device.request(0x184);
        assert_eq!(device.sent(), frame(1), "type {kind}");
        let mut device = operational(kind, false);
        device.request(0x184);
        assert_eq!(device.sent(), [], "type {kind}");
        device.write_u32(0x1800, 1, 0x184).unwrap();
        device.sent();
        device.request(0x184);
        assert_eq!(device.sent(), frame(1), "type {kind}, allowed meanwhile");
    }
}

#[test]
fn p14_a_synchronous_pdo_answers_with_what_was_last_sent() {
    let mut device = operational(1, true);
    device.put(0x2000, &[2]);
    device.sync();
    assert_eq!(device.sent(), frame(2));
    device.put(0x2000, &[3]);
    device.request(0x184);
    assert_eq!(device.sent(), frame(2));
    device.sync();
    assert_eq!(device.sent(), frame(3));
}

#[test]
fn p29_the_inhibit_time_holds_for_requests_too() {
    let mut device = Device::new();
    device.write_u16(0x1800, 3, 100).unwrap();
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    device.enter_operational();
    assert_eq!(device.sent(), frame(0));
    device.after(3);
    for _ in 0..5 {
        device.request(0x184);
    }
    assert_eq!(device.sent(), []);
    assert_eq!(device.after(7), frame(0));
    assert_eq!(device.after(100), []);
}

#[test]
fn p23_no_request_is_answered_outside_of_operational_or_for_another() {
    let mut device = operational(253, true);
    device.request(0x185);
    assert_eq!(device.sent(), []);
    device.leave_operational();
    device.request(0x184);
    assert_eq!(device.sent(), []);
    device.enter_operational();
    device.request(0x184);
    assert_eq!(device.sent(), frame(1));
}

/// The counters of the SYNCs at which something is sent, of 40 SYNCs that begin with this counter and overflow at 10.
fn counters(device: &mut Device, first: u8) -> Vec<u8> {
    let mut sent = Vec::new();
    let mut counter = first;
    for _ in 0..40 {
        device.counted_sync(Some(counter));
        if !device.sent().is_empty() {
            sent.push(counter);
        }
        counter = counter % 10 + 1;
    }
    sent
}

fn starting_at(start: u8, kind: u8) -> Device {
    let mut device = Device::new();
    device.write_u8(0x1800, 6, start).unwrap();
    device.map(0x1800, 0, kind, &[U8]).unwrap();
    device.enter_operational();
    device
}

#[test]
fn p28_a_pdo_begins_at_the_sync_with_its_start_value() {
    let mut device = starting_at(5, 3);
    assert_eq!(
        counters(&mut device, 1),
        [5, 8, 1, 4, 7, 10, 3, 6, 9, 2, 5, 8]
    );
    let mut device = starting_at(5, 10);
    assert_eq!(counters(&mut device, 7), [5, 5, 5, 5]);
}

#[test]
fn p28_operational_begins_anew_with_the_start_value() {
    let mut device = starting_at(5, 1);
    device.counted_sync(Some(5));
    assert_eq!(device.sent().len(), 1);
    device.leave_operational();
    device.enter_operational();
    device.counted_sync(Some(6));
    assert_eq!(device.sent(), []);
    device.counted_sync(Some(5));
    assert_eq!(device.sent().len(), 1);
}

#[test]
fn p28_without_a_counter_there_is_no_start_to_wait_for() {
    let mut device = starting_at(5, 2);
    device.sync();
    assert_eq!(device.sent(), []);
    device.sync();
    assert_eq!(device.sent().len(), 1);
}

#[test]
fn p28_a_start_value_that_never_comes_sends_nothing() {
    let mut device = starting_at(11, 1);
    assert_eq!(counters(&mut device, 1), []);
}

#[test]
fn p36_what_is_not_taken_within_the_sync_window_is_dropped() {
    let mut device = operational(1, false);
    device.sync();
    device.transmit.window_passed(&mut device.agenda);
    assert_eq!(device.sent(), []);
    device.sync();
    assert_eq!(device.sent(), frame(1), "the next one is in time");
}

#[test]
fn p36_an_event_of_type_0_waits_for_the_next_sync() {
    let mut device = operational(0, false);
    device.put(0x2000, &[2]);
    device.sync();
    device.transmit.window_passed(&mut device.agenda);
    assert_eq!(device.sent(), []);
    device.sync();
    assert_eq!(device.sent(), frame(2));
    device.transmit.window_passed(&mut device.agenda);
    device.sync();
    assert_eq!(device.sent(), []);
}

#[test]
fn p36_events_and_requests_know_no_window() {
    for kind in [252, 253, 255] {
        let mut device = operational(kind, true);
        device.sync();
        device.request(0x184);
        device.transmit.window_passed(&mut device.agenda);
        assert_eq!(device.sent(), frame(1), "type {kind}");
    }
}

//! The queue and its inhibit time on a bus that is not always free.

use super::Message;
use super::queue::EmergencyQueue;
use crate::time::{Instant, NEVER};
use crate::wire::cob_id::CobId;

const INHIBIT: u32 = 100_000;

fn at(milliseconds: u64) -> Instant {
    Instant::from_ticks(milliseconds * 1000)
}

/// A message of eight equal bytes.
fn message(byte: u8) -> Message {
    Message(u64::from_le_bytes([byte; 8]))
}

fn queue() -> EmergencyQueue {
    let mut queue = EmergencyQueue::new();
    queue.set_cob_id(CobId(0x84));
    queue.set_inhibit_time(INHIBIT);
    queue.start(at(0));
    queue
}

#[test]
fn e07_the_inhibit_time_starts_when_a_message_has_left() {
    let mut queue = queue();
    queue.push(message(1), at(0));
    queue.push(message(2), at(0));
    // The bus is busy until 250 ms.
    for time in 0..=250 {
        queue.poll(at(time));
    }
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([1; 8]));
    assert_eq!(queue.take(), None);
    queue.poll(at(250));
    queue.poll(at(251));
    assert_eq!(queue.deadline(), at(350));
    assert!(!queue.is_released());
    queue.poll(at(350));
    assert_eq!(queue.deadline(), NEVER);
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([2; 8]));
}

#[test]
fn without_an_inhibit_time_all_may_leave_at_once() {
    let mut queue = queue();
    queue.set_inhibit_time(0);
    for number in 0..8 {
        queue.push(message(number), at(0));
    }
    for number in 0..8 {
        assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([number; 8]));
    }
    assert!(!queue.is_released());
    assert_eq!(queue.overflows(), 0);
}

#[test]
fn e01_switching_off_drops_what_waits() {
    let mut queue = queue();
    queue.push(message(1), at(0));
    queue.set_cob_id(CobId(0x8000_0084));
    assert_eq!(queue.take(), None);
    queue.push(message(2), at(0));
    queue.set_cob_id(CobId(0x84));
    assert_eq!(queue.take(), None);
    queue.push(message(3), at(0));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([3; 8]));
}

#[test]
fn a_message_that_waits_for_the_bus_has_no_deadline_and_one_behind_it_has() {
    let mut queue = queue();
    assert_eq!(queue.deadline(), NEVER);
    queue.push(message(1), at(0));
    assert_eq!(queue.deadline(), NEVER);
    queue.push(message(2), at(0));
    assert_eq!(queue.deadline(), NEVER);
    queue.take();
    assert_eq!(queue.deadline(), at(0), "its inhibit time begins");
    queue.poll(at(1));
    assert_eq!(queue.deadline(), at(101));
    queue.set_inhibit_time(0);
    queue.poll(at(1));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([2; 8]));
}

#[test]
fn what_comes_before_communication_has_begun_is_not_kept_and_not_counted() {
    let mut queue = queue();
    queue.push(message(1), at(0));
    queue.end();
    for number in 0..20 {
        queue.push(message(number), at(0));
    }
    queue.start(at(1));
    assert_eq!(queue.take(), None);
    assert_eq!(queue.overflows(), 0);
}

#[test]
fn e10_what_waits_in_stopped_keeps_its_order() {
    let mut queue = queue();
    queue.push(message(1), at(0));
    queue.stop();
    queue.hold_back();
    queue.push(message(2), at(10));
    queue.poll(at(500));
    assert_eq!(queue.deadline(), NEVER);
    assert_eq!(queue.take(), None);
    queue.start(at(500));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([1; 8]));
    queue.poll(at(500));
    assert_eq!(queue.deadline(), at(600));
    queue.poll(at(600));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([2; 8]));
}

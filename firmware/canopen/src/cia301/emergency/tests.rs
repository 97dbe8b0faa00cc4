//! The queue and its inhibit time on a bus that is not always free.

use super::queue::EmergencyQueue;
use crate::time::{Instant, NEVER};
use crate::wire::cob_id::CobId;

const INHIBIT: u32 = 100_000;

fn at(milliseconds: u64) -> Instant {
    Instant::from_ticks(milliseconds * 1000)
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
    queue.push([1; 8], at(0));
    queue.push([2; 8], at(0));
    // The bus is busy until 250 ms.
    for time in 0..=250 {
        queue.release(at(time));
    }
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([1; 8]));
    assert_eq!(queue.take(), None);
    queue.release(at(251));
    assert_eq!(queue.deadline(), at(350));
    assert!(!queue.is_pending());
    queue.release(at(350));
    assert_eq!(queue.deadline(), NEVER);
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([2; 8]));
}

#[test]
fn without_an_inhibit_time_all_may_leave_at_once() {
    let mut queue = queue();
    queue.set_inhibit_time(0);
    for number in 0..8 {
        queue.push([number; 8], at(0));
    }
    for number in 0..8 {
        assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([number; 8]));
    }
    assert!(!queue.is_pending());
    assert_eq!(queue.overflows(), 0);
}

#[test]
fn e01_switching_off_drops_what_waits() {
    let mut queue = queue();
    queue.push([1; 8], at(0));
    queue.set_cob_id(CobId(0x8000_0084));
    assert_eq!(queue.take(), None);
    queue.push([2; 8], at(0));
    queue.set_cob_id(CobId(0x84));
    assert_eq!(queue.take(), None);
}

#[test]
fn a_message_that_waits_for_the_bus_has_no_deadline_and_one_behind_it_has() {
    let mut queue = queue();
    assert_eq!(queue.deadline(), NEVER);
    assert!(!queue.needs_time());
    queue.push([1; 8], at(0));
    assert!(queue.needs_time(), "its inhibit time begins when it leaves");
    assert_eq!(queue.deadline(), NEVER);
    queue.push([2; 8], at(0));
    assert_eq!(queue.deadline(), NEVER);
    queue.take();
    assert!(!queue.needs_time(), "the second has a deadline");
    queue.release(at(1));
    assert_eq!(queue.deadline(), at(100));
    queue.set_inhibit_time(0);
    queue.release(at(1));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([2; 8]));
}

#[test]
fn e10_what_waits_in_stopped_keeps_its_order() {
    let mut queue = queue();
    queue.push([1; 8], at(0));
    queue.stop();
    queue.hold_back();
    queue.push([2; 8], at(10));
    queue.release(at(500));
    assert_eq!(queue.deadline(), NEVER);
    assert_eq!(queue.take(), None);
    queue.start(at(500));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([1; 8]));
    queue.release(at(500));
    assert_eq!(queue.deadline(), at(600));
    queue.release(at(600));
    assert_eq!(queue.take().map(|frame| *frame.bytes()), Some([2; 8]));
}

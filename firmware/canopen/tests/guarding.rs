//! Node guarding and life guarding: G01 to G07 of the listed cases.

use crate::device::{Device, Sent};
use canopen::Event;
use canopen::cia301::error_behaviour::CommunicationError;
use canopen::cia301::nmt::NmtState;

const LOST: &str = "084: 30 81 11 00 00 00 00 00";
const ENDED: &str = "084: 00 00 00 00 00 00 00 00";

/// Guard time 100 ms, life time factor 3.
fn guarded() -> Device {
    let mut device = Device::new();
    device.ask("604: 2B 0C 10 00 64 00 00 00");
    device.ask("604: 2F 0D 10 00 03 00 00 00");
    assert!(device.pass(5000).is_empty(), "the first question arms it");
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 7F"]);
    device
}

fn lost_at(milliseconds: u64) -> [Sent; 1] {
    [(milliseconds, LOST.to_string())]
}

#[test]
fn g01_the_toggle_changes_with_each_answer() {
    let mut device = Device::new();
    for answer in ["704 [1] 7F", "704 [1] FF", "704 [1] 7F", "704 [1] FF"] {
        assert_eq!(device.ask("704 [8] rtr"), [answer]);
    }
}

#[test]
fn g01_questions_that_wait_for_the_bus_get_one_answer() {
    let mut device = Device::new();
    device.send("704 [8] rtr");
    device.send("704 [8] rtr");
    assert_eq!(device.sent(), ["704 [1] 7F"]);
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] FF"]);
}

#[test]
fn g01_the_questions_to_others_are_not_answered() {
    let mut device = Device::new();
    assert_eq!(device.ask("705 [8] rtr"), [""; 0]);
    assert_eq!(device.ask("703 [8] rtr"), [""; 0]);
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 7F"]);
}

#[test]
fn g02_the_answer_has_the_state() {
    let mut device = Device::operational();
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 05"]);
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 85"]);
    device.send("000 [2] 02 04");
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 04"]);
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 84"]);
}

#[test]
fn g03_the_toggle_starts_anew_with_communication() {
    let mut device = Device::new();
    device.ask("704 [8] rtr");
    device.send("000 [2] 82 04");
    device.serve_reset();
    device.sent();
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 7F"]);
}

#[test]
fn g04_a_heartbeat_producer_is_not_guarded() {
    let mut device = Device::new();
    device.ask("604: 2B 17 10 00 E8 03 00 00");
    assert_eq!(device.ask("704 [8] rtr"), [""; 0]);
    device.ask("604: 2B 17 10 00 00 00 00 00");
    assert_eq!(device.ask("704 [8] rtr"), ["704 [1] 7F"]);
}

#[test]
fn g05_a_master_that_asks_no_more_is_lost_once() {
    let mut device = guarded();
    assert!(device.pass(299).is_empty());
    device.ask("704 [8] rtr");
    device.events();
    assert_eq!(device.pass(5000), lost_at(300));
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(
        device.events(),
        [Event::CommunicationError(CommunicationError::LifeGuarding)]
    );
}

#[test]
fn g05_the_error_behaviour_follows() {
    let mut device = guarded();
    device.send("000 [2] 01 04");
    device.sent();
    device.pass(400);
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn g06_the_next_question_ends_the_error() {
    let mut device = guarded();
    assert_eq!(device.pass(300), lost_at(300));
    assert_eq!(device.ask("704 [8] rtr"), [ENDED, "704 [1] FF"]);
    assert_eq!(device.pass(5000), lost_at(300));
}

#[test]
fn g07_heartbeats_take_over() {
    let mut device = guarded();
    device.ask("604: 2B 17 10 00 00 10 00 00");
    assert!(device.pass(1000).is_empty());

    let mut device = guarded();
    assert_eq!(device.pass(300), lost_at(300));
    assert_eq!(
        device.ask("604: 2B 17 10 00 00 10 00 00"),
        [ENDED, "584: 60 17 10 00 00 00 00 00", "704 [1] 7F"]
    );
}

#[test]
fn new_times_count_from_when_they_are_written() {
    let mut device = guarded();
    assert!(device.pass(200).is_empty());
    device.ask("604: 2F 0D 10 00 02 00 00 00");
    assert_eq!(device.pass(5000), lost_at(200));
    assert_eq!(
        device.ask("604: 2F 0D 10 00 00 00 00 00"),
        [ENDED, "584: 60 0D 10 00 00 00 00 00"]
    );
    device.ask("704 [8] rtr");
    assert!(device.pass(5000).is_empty(), "switched off");
}

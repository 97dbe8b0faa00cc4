//! Node guarding and life guarding: G01 to G07 of the listed cases.

use crate::device::{Device, Sent};
use canopen::Event;
use canopen::cia301::error_behaviour::CommunicationError;
use canopen::cia301::nmt::NmtState;

const LOST: &str = "084#3081110000000000";
const ENDED: &str = "084#0000000000000000";

/// Guard time 100 ms, life time factor 3.
fn guarded() -> Device {
    let mut device = Device::new();
    device.ask("604#2B0C100064000000");
    device.ask("604#2F0D100003000000");
    assert!(device.pass(5000).is_empty(), "the first question arms it");
    assert_eq!(device.ask("704#R"), ["704#7F"]);
    device
}

fn lost_at(milliseconds: u64) -> [Sent; 1] {
    [(milliseconds, LOST.to_string())]
}

#[test]
fn g01_the_toggle_changes_with_each_answer() {
    let mut device = Device::new();
    for answer in ["704#7F", "704#FF", "704#7F", "704#FF"] {
        assert_eq!(device.ask("704#R"), [answer]);
    }
}

#[test]
fn g01_questions_that_wait_for_the_bus_get_one_answer() {
    let mut device = Device::new();
    device.send("704#R");
    device.send("704#R");
    assert_eq!(device.sent(), ["704#7F"]);
    assert_eq!(device.ask("704#R"), ["704#FF"]);
}

#[test]
fn g01_the_questions_to_others_are_not_answered() {
    let mut device = Device::new();
    assert_eq!(device.ask("705#R"), [""; 0]);
    assert_eq!(device.ask("703#R"), [""; 0]);
    assert_eq!(device.ask("704#R"), ["704#7F"]);
}

#[test]
fn g02_the_answer_has_the_state() {
    let mut device = Device::operational();
    assert_eq!(device.ask("704#R"), ["704#05"]);
    assert_eq!(device.ask("704#R"), ["704#85"]);
    device.send("000#0204");
    assert_eq!(device.ask("704#R"), ["704#04"]);
    assert_eq!(device.ask("704#R"), ["704#84"]);
}

#[test]
fn g03_the_toggle_starts_anew_with_communication() {
    let mut device = Device::new();
    device.ask("704#R");
    device.send("000#8204");
    device.serve_reset();
    device.sent();
    assert_eq!(device.ask("704#R"), ["704#7F"]);
}

#[test]
fn g04_a_heartbeat_producer_is_not_guarded() {
    let mut device = Device::new();
    device.ask("604#2B171000E8030000");
    assert_eq!(device.ask("704#R"), [""; 0]);
    device.ask("604#2B17100000000000");
    assert_eq!(device.ask("704#R"), ["704#7F"]);
}

#[test]
fn g05_a_master_that_asks_no_more_is_lost_once() {
    let mut device = guarded();
    assert!(device.pass(299).is_empty());
    device.ask("704#R");
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
    device.send("000#0104");
    device.sent();
    device.pass(400);
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn g06_the_next_question_ends_the_error() {
    let mut device = guarded();
    assert_eq!(device.pass(300), lost_at(300));
    assert_eq!(device.ask("704#R"), [ENDED, "704#FF"]);
    assert_eq!(device.pass(5000), lost_at(300));
}

#[test]
fn g07_heartbeats_take_over() {
    let mut device = guarded();
    device.ask("604#2B17100000100000");
    assert!(device.pass(1000).is_empty());

    let mut device = guarded();
    assert_eq!(device.pass(300), lost_at(300));
    assert_eq!(
        device.ask("604#2B17100000100000"),
        [ENDED, "584#6017100000000000", "704#7F"]
    );
}

#[test]
fn new_times_count_from_when_they_are_written() {
    let mut device = guarded();
    assert!(device.pass(200).is_empty());
    device.ask("604#2F0D100002000000");
    assert_eq!(device.pass(5000), lost_at(200));
    assert_eq!(
        device.ask("604#2F0D100000000000"),
        [ENDED, "584#600D100000000000"]
    );
    device.ask("704#R");
    assert!(device.pass(5000).is_empty(), "switched off");
}

//! The CAN controller: C01, C02, E09 of the listed cases.

use crate::device::Device;
use canopen::cia301::error_behaviour::CommunicationError;
use canopen::cia301::nmt::NmtState;
use canopen::{ControllerState, Duration, Event};

const ENDED: &str = "084: 00 00 00 00 00 00 00 00";

fn enter(device: &mut Device, state: ControllerState) {
    device.node.controller_changed(state, device.now);
    device.poll();
}

/// How often the firmware is asked to start the controller again while milliseconds pass.
fn restarts(device: &mut Device, milliseconds: u64) -> usize {
    assert!(device.pass(milliseconds).is_empty(), "it is off the bus");
    let events = device.events();
    let asked = events
        .iter()
        .filter(|event| **event == Event::RestartController);
    asked.count()
}

#[test]
fn c01_after_bus_off_the_controller_starts_again_and_the_messages_leave() {
    let mut device = Device::operational();
    device.ask("604: 2B 17 10 00 C8 00 00 00");
    enter(&mut device, ControllerState::BusOff);
    assert!(device.node.is_mute());
    assert!(
        device
            .events()
            .contains(&Event::CommunicationError(CommunicationError::BusOff))
    );
    assert_eq!(device.node.state(), NmtState::PreOperational, "1029h is 0");
    assert_eq!(restarts(&mut device, 99), 0);
    assert_eq!(restarts(&mut device, 1), 1);
    enter(&mut device, ControllerState::ErrorActive);
    assert_eq!(
        device.sent(),
        ["084: 40 81 11 00 00 00 00 00", ENDED],
        "no second boot-up message"
    );
    assert_eq!(device.value(0x1001, 0), [0]);
    assert_eq!(device.value(0x1003, 1)[..2], [0x40, 0x81]);
    assert_eq!(device.pass(100), [(100, "704 [1] 7F".to_string())]);
    let counters = device.node.counters();
    assert_eq!((counters.bus_off, counters.restarts), (1, 1));
}

#[test]
fn c01_the_delay_is_the_firmwares_and_a_restart_is_asked_for_again() {
    let mut device = Device::new();
    device
        .node
        .set_restart_delay(Some(Duration::from_ticks(300_000)));
    enter(&mut device, ControllerState::BusOff);
    for _ in 0..10 {
        enter(&mut device, ControllerState::BusOff);
        device.pass(29);
    }
    assert_eq!(restarts(&mut device, 9), 0);
    assert_eq!(restarts(&mut device, 1), 1);
    assert_eq!(restarts(&mut device, 999), 0, "it may take a while");
    assert_eq!(restarts(&mut device, 1), 1);
    enter(&mut device, ControllerState::ErrorActive);
    device.sent();
    assert_eq!(restarts(&mut device, 5_000), 0);

    device.node.set_restart_delay(None);
    enter(&mut device, ControllerState::BusOff);
    assert_eq!(restarts(&mut device, 60_000), 0, "it stays off the bus");
}

#[test]
fn c01_the_error_behaviour_of_bus_off_is_1029h() {
    for (behaviour, state) in [(1, NmtState::Operational), (2, NmtState::Stopped)] {
        let mut device = Device::operational();
        device.ask(&format!("604: 2F 29 10 01 {behaviour:02X} 00 00 00"));
        enter(&mut device, ControllerState::BusOff);
        assert_eq!(device.node.state(), state);
        enter(&mut device, ControllerState::ErrorActive);
        assert_eq!(device.sent()[0], "084: 40 81 11 00 00 00 00 00");
    }
}

#[test]
fn c01_a_reset_during_bus_off_waits_for_the_bus() {
    let mut device = Device::new();
    device.put("000 [2] 81 04");
    enter(&mut device, ControllerState::BusOff);
    device.serve_reset();
    assert!(device.pass(50).is_empty());
    assert_eq!(device.value(0x1001, 0), [0x11], "it is still off the bus");
    device.pass(50);
    assert!(device.events().contains(&Event::RestartController));
    enter(&mut device, ControllerState::ErrorActive);
    assert_eq!(device.sent()[0], "704 [1] 00");
    assert_eq!(device.value(0x1001, 0), [0]);
}

#[test]
fn e09_error_passive_is_told_again_after_a_reset_of_the_node() {
    let mut device = Device::new();
    enter(&mut device, ControllerState::ErrorPassive);
    device.sent();
    device.put("000 [2] 81 04");
    device.serve_reset();
    device.poll();
    assert_eq!(
        device.sent(),
        ["704 [1] 00", "084: 20 81 11 00 00 00 00 00"]
    );
    enter(&mut device, ControllerState::ErrorActive);
    assert_eq!(device.sent(), [ENDED]);
}

#[test]
fn c03_process_data_of_the_time_off_the_bus_is_the_newest() {
    let mut device = Device::operational();
    device.ask("604: 2F 29 10 01 01 00 00 00");
    enter(&mut device, ControllerState::BusOff);
    for value in 1..=9 {
        device.set_value(0x2005, 0, &[value, 0, 0, 0]);
        assert!(device.pass(5).is_empty());
    }
    enter(&mut device, ControllerState::ErrorActive);
    let sent = device.sent();
    let pdos: Vec<_> = sent
        .iter()
        .filter(|frame| frame.starts_with("184"))
        .collect();
    assert_eq!(pdos, ["184: 09 00 00 00 00 00 00 00"]);
}

#[test]
fn e09_error_passive_is_told_once_with_its_end() {
    let mut device = Device::new();
    for _ in 0..3 {
        enter(&mut device, ControllerState::ErrorPassive);
    }
    assert_eq!(device.sent(), ["084: 20 81 11 00 00 00 00 00"]);
    enter(&mut device, ControllerState::ErrorActive);
    assert_eq!(device.sent(), [ENDED]);
    assert_eq!(device.node.counters().error_passive, 1);
}

#[test]
fn e09_the_warning_limit_is_for_the_light_alone() {
    let mut device = Device::new();
    enter(&mut device, ControllerState::Warning);
    assert!(device.sent().is_empty());
    enter(&mut device, ControllerState::ErrorPassive);
    assert_eq!(device.sent(), ["084: 20 81 11 00 00 00 00 00"]);
    enter(&mut device, ControllerState::Warning);
    assert_eq!(device.sent(), [ENDED]);
    assert_eq!(device.node.counters().error_passive, 1);
}

#[test]
fn e09_error_passive_and_bus_off_end_together() {
    let mut device = Device::new();
    enter(&mut device, ControllerState::ErrorPassive);
    enter(&mut device, ControllerState::BusOff);
    enter(&mut device, ControllerState::ErrorActive);
    assert_eq!(
        device.sent(),
        [
            "084: 20 81 11 00 00 00 00 00",
            "084: 40 81 11 00 00 00 00 00",
            "084: 00 00 11 00 00 00 00 00",
            ENDED
        ]
    );
}

#[test]
fn c02_lost_frames_are_counted_and_told_once() {
    let mut device = Device::new();
    device.node.frames_lost(3, device.now);
    assert_eq!(device.sent(), ["084: 10 81 11 00 00 00 00 00"]);
    assert!(device.pass(900).is_empty());
    device.node.frames_lost(1, device.now);
    assert_eq!(
        device.pass(5_000),
        [(1_000, ENDED.to_string())],
        "a second after the last one"
    );
    assert_eq!(device.node.counters().lost_frames, 4);
}

//! What the lights of CiA 303-3 are to say of a device, in its states and with its errors.

use crate::device::Device;
use canopen::ControllerState;
use canopen::cia301::emergency::{Emergency, ErrorRegister};
use canopen::cia301::nmt::{NmtState, Reset};
use canopen::cia303::CommunicationState;

fn communication(device: &Device) -> CommunicationState {
    device.node.signal().communication
}

fn report(device: &mut Device, code: u16, info: [u8; 5]) {
    let emergency = Emergency {
        code,
        register: ErrorRegister::COMMUNICATION,
        info,
    };
    device.node.report(emergency, device.now);
}

#[test]
fn the_state_is_the_nmt_state() {
    let mut device = Device::new();
    for (command, state) in [
        ("000 [2] 01 04", NmtState::Operational),
        ("000 [2] 02 04", NmtState::Stopped),
        ("000 [2] 80 04", NmtState::PreOperational),
    ] {
        device.send(command);
        assert_eq!(device.node.signal().state, state);
        assert!(!device.node.signal().configuring);
    }
}

#[test]
fn a_device_that_is_being_configured_says_so() {
    let mut device = Device::new();
    device.send("7E5: 04 01 00 00 00 00 00 00");
    assert!(device.node.signal().configuring);
    device.send("7E5: 04 00 00 00 00 00 00 00");
    assert!(!device.node.signal().configuring);
    // Without a node-ID it waits for that.
    let mut device = Device::off_with(255);
    device.boot(Reset::Node);
    assert!(device.node.signal().configuring);
}

#[test]
fn the_controller_shows_in_the_red_light() {
    let mut device = Device::new();
    for (state, expected) in [
        (ControllerState::Warning, CommunicationState::WarningLimit),
        (
            ControllerState::ErrorPassive,
            CommunicationState::WarningLimit,
        ),
        (ControllerState::BusOff, CommunicationState::BusOff),
        (ControllerState::ErrorActive, CommunicationState::NoError),
    ] {
        device.node.controller_changed(state, device.now);
        assert_eq!(communication(&device), expected);
    }
}

#[test]
fn of_several_errors_the_gravest_shows() {
    let mut device = Device::new();
    let errors = [
        (0x6320, [0; 5], CommunicationState::InvalidConfiguration),
        (0x8130, [9, 0, 0, 0, 0], CommunicationState::ErrorControl),
        (0x8100, [0x06, 0x10, 0, 0, 0], CommunicationState::Sync),
        (0x8250, [1, 0, 0, 0, 0], CommunicationState::EventTimer),
    ];
    for (code, info, expected) in errors {
        report(&mut device, code, info);
        assert_eq!(communication(&device), expected);
    }
    for (code, _, expected) in errors.into_iter().rev() {
        assert_eq!(communication(&device), expected);
        device.node.clear(code, device.now);
    }
    assert_eq!(communication(&device), CommunicationState::NoError);
}

#[test]
fn an_error_of_the_drive_is_none_of_the_communication() {
    let mut device = Device::new();
    report(&mut device, 0x5400, [0; 5]);
    // A network that was lost without an error of SYNC has the same code.
    report(&mut device, 0x8100, [0; 5]);
    assert_eq!(communication(&device), CommunicationState::NoError);
}

#[test]
fn a_guarding_master_that_falls_silent_shows_and_goes_with_it() {
    let mut device = Device::new();
    // Guard time 50 ms, life time factor 2.
    device.send("604: 2B 0C 10 00 32 00 00 00");
    device.send("604: 2F 0D 10 00 02 00 00 00");
    device.sent();
    device.send("704 [8] rtr");
    device.pass(150);
    assert_eq!(communication(&device), CommunicationState::ErrorControl);
    device.send("704 [8] rtr");
    assert_eq!(communication(&device), CommunicationState::NoError);
}

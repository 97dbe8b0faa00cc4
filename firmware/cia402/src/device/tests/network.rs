//! What the drive does when NMT stops it, resets it, or the network is lost.

use super::*;

#[test]
fn d30_nmt_stop_brings_the_motor_to_rest_and_start_moves_nothing() {
    let mut station = Station::enabled();
    station.go_to(100_000);
    station.milliseconds(200);
    station.send(0x000, &[0x02, 0x04]);
    let stopped = station.rest();
    assert!(stopped < 3_000);
    station.milliseconds(5);
    assert!(!station.power);
    station.send(0x000, &[0x01, 0x04]);
    station.milliseconds(50);
    assert_eq!(station.motor.position, stopped);
    assert_eq!(station.upload(0x6041, 0), 0x0250);
}

/// A drive that moves and watches node 5 with a time of 100 ms; 1029h:1 as given.
fn moving_and_watching(behaviour: u32) -> Station {
    let mut station = Station::enabled();
    station.download(0x1016, 1, 4, 0x0005_0064).unwrap();
    station.download(0x1029, 1, 1, behaviour).unwrap();
    station.send(0x705, &[0x05]);
    station.go_to(100_000);
    station.milliseconds(90);
    assert_eq!(station.state(), State::OperationEnabled);
    station.take();
    station
}

#[test]
fn d29_a_lost_heartbeat_stops_the_motor_whatever_1029h_says() {
    for behaviour in [0, 1, 2] {
        let mut station = moving_and_watching(behaviour);
        station.milliseconds(20);
        assert!(
            station
                .take()
                .contains(&"084 30 81 11 05 00 00 00 00".into()),
            "1029h = {behaviour}"
        );
        let stopped = station.rest();
        assert!(stopped < 3_000);
        station.milliseconds(5);
        assert!(!station.power);
        assert_eq!(station.state(), State::SwitchOnDisabled);
        let lost = |event: &Event| matches!(event, Event::CommunicationError(_));
        assert_eq!(
            station.events().iter().filter(|event| lost(event)).count(),
            1
        );
        station.send(0x705, &[0x05]);
        station.send(0x000, &[0x01, 0x04]);
        station.milliseconds(50);
        assert_eq!(station.motor.position, stopped, "no jump at the return");
    }
}

#[test]
fn d29_bus_off_stops_the_motor() {
    let mut station = moving_and_watching(1);
    station.controller(ControllerState::BusOff);
    let stopped = station.rest();
    assert!(stopped < 3_000);
    station.milliseconds(5);
    assert!(!station.power);
    station.controller(ControllerState::ErrorActive);
    station.send(0x705, &[0x05]);
    station.milliseconds(50);
    assert_eq!(station.state(), State::SwitchOnDisabled);
    assert_eq!(station.motor.position, stopped, "no jump at the return");
}

#[test]
fn d29_after_a_lost_heartbeat_the_drive_can_be_enabled_again() {
    let mut station = moving_and_watching(1);
    station.milliseconds(20);
    station.rest();
    assert_eq!(station.state(), State::SwitchOnDisabled);
    for controlword in [0x06, 0x07, 0x0F] {
        station.send(0x204, &[controlword, 0x00, 0x01]);
        station.milliseconds(2);
    }
    assert_eq!(station.state(), State::OperationEnabled);
}

#[test]
fn n18_reset_node_stops_the_motor_before_the_device_boots() {
    let mut station = Station::enabled();
    station.download(0x1017, 0, 2, 1000).unwrap();
    station.go_to(100_000);
    station.milliseconds(200);
    station.take();
    station.send(0x000, &[0x81, 0x04]);
    station.milliseconds(5);
    assert!(!station.take().contains(&"704 00".into()), "it stops first");
    assert!(station.power);
    station.milliseconds(60);
    assert_eq!(station.take().last().unwrap(), "704 00");
    assert!(!station.power);
    assert_eq!(station.upload(0x6041, 0), 0x0250);
    assert_eq!(station.upload(0x6040, 0), 0);
    assert_eq!(station.upload(0x1018, 4), 0x0402_1234);
    assert_eq!(
        station.upload(0x6064, 0),
        u32::try_from(station.motor.position).unwrap()
    );
}

#[test]
fn n18_reset_node_while_stopped_resets_a_fault() {
    let mut station = Station::enabled();
    station.fault = Some(0x4210);
    station.milliseconds(10);
    station.fault = None;
    station.send(0x000, &[0x02, 0x04]);
    station.milliseconds(5);
    station.take();
    station.send(0x000, &[0x81, 0x04]);
    station.milliseconds(10);
    assert_eq!(station.take(), ["704 00"]);
    assert_eq!(station.upload(0x6041, 0), 0x0250);
    assert_eq!(station.upload(0x1001, 0), 0);
}

#[test]
fn reset_node_with_the_cause_of_a_fault_present_tells_it_again() {
    let mut station = Station::enabled();
    station.fault = Some(0x4210);
    station.milliseconds(10);
    station.take();
    station.send(0x000, &[0x81, 0x04]);
    station.milliseconds(10);
    assert_eq!(station.take(), ["704 00", "084 10 42 09 00 00 00 00 00"]);
    assert_eq!(station.state(), State::Fault);
}

#[test]
fn reset_communication_keeps_a_fault_and_the_objects_of_the_drive() {
    let mut station = Station::enabled();
    station.download(0x6081, 0, 4, 4_321).unwrap();
    station.fault = Some(0x4210);
    station.milliseconds(10);
    station.fault = None;
    station.milliseconds(2);
    station.send(0x000, &[0x82, 0x04]);
    station.milliseconds(5);
    assert!(station.take().contains(&"704 00".into()));
    assert_eq!(station.state(), State::Fault);
    assert_eq!(station.upload(0x6081, 0), 4_321);
    assert_eq!(station.upload(0x1001, 0), 0x09);
    station.download(0x6040, 0, 2, 0x80).unwrap();
    station.milliseconds(3);
    assert_eq!(station.state(), State::SwitchOnDisabled);
    assert_eq!(station.upload(0x1001, 0), 0);
}

#[test]
fn m01_remote_is_0_while_the_node_is_stopped() {
    let mut station = Station::operational();
    let remote =
        |station: &Station| station.exchange.actuals_at(station.now).statusword & REMOTE != 0;
    assert!(remote(&station));
    station.send(0x000, &[0x02, 0x04]);
    station.milliseconds(2);
    assert!(!remote(&station));
    station.send(0x000, &[0x80, 0x04]);
    station.milliseconds(2);
    assert!(remote(&station));
}

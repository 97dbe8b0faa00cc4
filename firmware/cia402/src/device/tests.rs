//! Device and drive together, at the level of frames, on virtual time. Node 4.

mod application;
mod dictionary;
mod network;
mod rig;
mod transient;

use std::format;

use canopen::cia301::nmt::NmtState;
use canopen::{ControllerState, Event};

use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::state_machine::State;
use crate::statusword::{REMOTE, SET_POINT_ACKNOWLEDGE, TARGET_REACHED};
use rig::Station;

#[test]
fn the_device_boots_at_once_and_the_drive_by_itself() {
    let mut station = Station::new();
    assert_eq!(station.take(), ["704 00"]);
    station.milliseconds(3);
    assert_eq!(station.upload(0x6041, 0), 0x0250);
    assert_eq!(
        station.upload(0x1018, 4),
        0x0402_1234,
        "the serial number is the board's"
    );
}

#[test]
fn d02_a_drive_is_enabled_by_sdo_in_pre_operational() {
    let mut station = Station::new();
    for (controlword, state) in [(0x06, 0x0231), (0x07, 0x0233), (0x0F, 0x0237)] {
        station.download(0x6040, 0, 2, controlword).unwrap();
        station.milliseconds(2);
        assert_eq!(
            station.upload(0x6041, 0) & !u32::from(TARGET_REACHED),
            state
        );
    }
}

#[test]
fn what_comes_with_each_rpdo_is_no_new_configuration() {
    let mut station = Station::new();
    station.milliseconds(3);
    let (mut commands, mut configuration) = (Commands::NONE, Configuration::NONE);
    for (index, sub, size, is_configuration) in [
        (0x6067, 0, 4, true),
        (0x6040, 0, 2, false),
        (0x607A, 0, 4, false),
        (0x60B8, 0, 2, false),
        (0x60FE, 1, 4, false),
        (0x60FE, 2, 4, false),
        (0x60FF, 0, 4, false),
    ] {
        station.download(index, sub, size, 1).unwrap();
        let waiting = station.exchange.take(&mut commands);
        station.exchange.take_configuration(&mut configuration);
        assert_eq!(
            waiting.is_configured, is_configuration,
            "{index:04X}h:{sub}"
        );
    }
}

#[test]
fn m18_an_unsupported_mode_in_a_pdo_is_ignored() {
    let mut station = Station::operational();
    station.send(0x204, &[0x06, 0x00, 0x05]);
    station.milliseconds(2);
    assert_eq!(station.upload(0x6061, 0), 1);
    assert_eq!(station.upload(0x6060, 0), 1);
    assert_eq!(
        station.state(),
        State::ReadyToSwitchOn,
        "the controlword beside it counts"
    );
}

#[test]
fn m07_quick_stop_options_are_those_of_the_standard() {
    let mut station = Station::new();
    for option in [-1i16, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, i16::MIN] {
        let result = station.download(0x605A, 0, 2, u32::from(option.cast_unsigned()));
        let expected = match option {
            0..=8 => Ok(()),
            _ => Err(0x0609_0030),
        };
        assert_eq!(result, expected, "option {option}");
    }
}

#[test]
fn option_codes_are_those_of_the_standard() {
    let mut station = Station::new();
    for (index, last, first) in [
        (0x6007, 3, 0),
        (0x605B, 1, 0),
        (0x605C, 1, 0),
        (0x605D, 4, 1),
        (0x605E, 4, 0),
    ] {
        for option in -1..=5i16 {
            let result = station.download(index, 0, 2, u32::from(option.cast_unsigned()));
            let expected = if (first..=last).contains(&option) {
                Ok(())
            } else {
                Err(0x0609_0030)
            };
            assert_eq!(result, expected, "{index:04X}h = {option}");
        }
    }
}

#[test]
fn ramps_of_0_are_refused() {
    let mut station = Station::new();
    for index in [0x6083, 0x6084, 0x6085] {
        assert_eq!(station.download(index, 0, 4, 0), Err(0x0609_0032));
        assert_eq!(station.download(index, 0, 4, 1), Ok(()));
    }
    assert_eq!(
        station.download(0x6081, 0, 4, 0),
        Ok(()),
        "a velocity of 0 is legal: no motion"
    );
}

#[test]
fn m02_every_step_of_enabling_shows_in_a_pdo() {
    let mut station = Station::operational();
    for (controlword, statusword) in [
        (0x06, "184 31 02 01"),
        (0x07, "184 33 02 01"),
        (0x0F, "184 37 02 01"),
    ] {
        station.send(0x204, &[controlword, 0x00, 0x01]);
        station.milliseconds(2);
        assert_eq!(station.take(), [statusword]);
    }
}

#[test]
fn m10_a_fault_sends_one_emergency_with_the_code_of_603fh() {
    let mut station = Station::enabled();
    station.fault = Some(0x4210);
    station.milliseconds(20);
    assert_eq!(station.upload(0x603F, 0), 0x4210);
    let frames = station.take();
    let emergencies: std::vec::Vec<_> = frames
        .iter()
        .filter(|frame| frame.starts_with("084"))
        .collect();
    assert_eq!(emergencies, ["084 10 42 09 00 00 00 00 00"]);
    assert!(
        frames.contains(&"184 1F 02 01".into()),
        "fault reaction active shows: {frames:?}"
    );
    assert_eq!(station.upload(0x1003, 1) & 0xFFFF, 0x4210);

    station.fault = None;
    station.milliseconds(2);
    station.send(0x204, &[0x80, 0x00, 0x01]);
    station.milliseconds(2);
    assert!(
        station
            .take()
            .contains(&"084 00 00 00 00 00 00 00 00".into())
    );
    assert_eq!(station.upload(0x1001, 0), 0);
}

#[test]
fn m08_quick_stop_active_shows_in_a_pdo() {
    let mut station = Station::enabled();
    station.send(0x204, &[0x02, 0x00, 0x01]);
    station.milliseconds(5);
    assert_eq!(station.take(), ["184 17 02 01", "184 50 02 01"]);
}

#[test]
fn m27_target_and_edge_in_one_pdo_is_the_new_target() {
    let mut station = Station::enabled();
    station.go_to(1_234);
    assert_eq!(station.rest(), 1_234);
    assert_eq!(station.upload(0x6064, 0), 1_234);
    assert_eq!(station.upload(0x6062, 0), 1_234);
    assert_eq!(station.upload(0x6063, 0), 1_234);
}

#[test]
fn m24_acknowledge_and_target_reached_change_in_one_statusword() {
    let mut station = Station::enabled();
    station.milliseconds(20);
    station.take();
    station.go_to(500);
    station.milliseconds(2);
    let word = 0x0237 | SET_POINT_ACKNOWLEDGE;
    let [low, high] = word.to_le_bytes();
    assert_eq!(station.take(), [format!("184 {low:02X} {high:02X} 01")]);
}

#[test]
fn a_sync_shows_the_drive_as_it_was_when_it_arrived() {
    let mut station = Station::enabled();
    station.go_to(10_000);
    station.milliseconds(100);
    station.take();
    let before = station.exchange.actuals_at(station.now);
    let stamp = station.now;
    station.control_tick();
    station.deliver(0x080, &[], stamp);
    let [p0, p1, p2, p3] = before.position_actual.to_le_bytes();
    let [s0, s1] = before.statusword.to_le_bytes();
    let expected = format!("284 {s0:02X} {s1:02X} {p0:02X} {p1:02X} {p2:02X} {p3:02X}");
    assert!(station.take().contains(&expected));

    // The tick before a SYNC counts, even when the device has not been called in between.
    station.control_tick();
    let newest = station.exchange.actuals_at(station.now);
    assert_ne!(newest.position_actual, before.position_actual);
    station.send(0x080, &[]);
    let [p0, p1, p2, p3] = newest.position_actual.to_le_bytes();
    let expected = format!("284 {s0:02X} {s1:02X} {p0:02X} {p1:02X} {p2:02X} {p3:02X}");
    assert!(station.take().contains(&expected));
}

#[test]
fn after_reset_node_edges_count_from_the_power_on_value() {
    let mut station = Station::enabled();
    station.send(0x204, &[0x8F, 0x00, 0x01]);
    station.send(0x000, &[0x81, 0x04]);
    station.milliseconds(10);
    station.fault = Some(0x4210);
    station.milliseconds(3);
    station.fault = None;
    station.milliseconds(2);
    assert_eq!(station.state(), State::Fault);
    station.download(0x6040, 0, 2, 0x80).unwrap();
    station.milliseconds(2);
    assert_eq!(station.state(), State::SwitchOnDisabled);
}

#[test]
fn what_the_firmware_has_to_do_waits_behind_any_number_of_changes_of_state() {
    let mut station = Station::new();
    for _ in 0..20 {
        station.send(0x000, &[0x01, 0x04]);
        station.send(0x000, &[0x80, 0x04]);
    }
    station.send(0x7E5, &[0x04, 0x01, 0, 0, 0, 0, 0, 0]);
    station.send(0x7E5, &[0x17, 0, 0, 0, 0, 0, 0, 0]);
    station.send(0x7E5, &[0x15, 0x0A, 0, 0, 0, 0, 0, 0]);
    let events = station.events();
    let has = |wanted: fn(&Event) -> bool| events.iter().any(wanted);
    assert!(has(|event| matches!(event, Event::StoreSettings(_))));
    assert!(has(|event| matches!(event, Event::SwitchBitRate { .. })));
    let last_state = events.iter().rev().find_map(|event| match event {
        Event::StateChanged(state) => Some(*state),
        _ => None,
    });
    assert_eq!(last_state, Some(NmtState::PreOperational));
}

#[test]
fn no_bit_rate_makes_a_drive_with_power_deaf_for_long() {
    let mut station = Station::enabled();
    let switch = |station: &mut Station| {
        station.events();
        station.send(0x7E5, &[0x04, 0x01, 0, 0, 0, 0, 0, 0]);
        station.send(0x7E5, &[0x13, 0, 0x03, 0, 0, 0, 0, 0]);
        station.send(0x7E5, &[0x15, 0xE9, 0x03, 0, 0, 0, 0, 0]);
        let events = station.events();
        let is_switch = |event: &Event| matches!(event, Event::SwitchBitRate { .. });
        events.iter().any(is_switch)
    };
    assert!(!switch(&mut station), "a second and more");
    // It still hears what stops it.
    station.download(0x6040, 0, 2, 0).unwrap();
    station.milliseconds(50);
    assert_eq!(station.state(), State::SwitchOnDisabled);
    assert!(switch(&mut station), "without power");
}

#[test]
fn a_reset_shows_as_a_change_of_state_and_not_as_a_task() {
    let mut station = Station::new();
    station.events();
    station.send(0x000, &[0x82, 0x04]);
    station.milliseconds(5);
    assert_eq!(
        station.events(),
        [
            Event::StateChanged(NmtState::Initialisation),
            Event::StateChanged(NmtState::PreOperational)
        ]
    );
}

#[test]
fn lost_frames_that_stop_the_motor_are_one_error_until_the_fault_is_reset() {
    let mut station = Station::enabled();
    station.device.frames_lost(1, station.now);
    station.fault = Some(0x8110);
    station.milliseconds(1);
    station.fault = None;
    station.milliseconds(2_500);
    let emergencies = |station: &mut Station| {
        let mut frames = station.take();
        frames.retain(|frame| frame.starts_with("084"));
        frames
    };
    assert_eq!(emergencies(&mut station), ["084 10 81 11 00 00 00 00 00"]);
    station.send(0x204, &[0x80, 0x00, 0x01]);
    station.milliseconds(3_000);
    assert_eq!(emergencies(&mut station), ["084 00 00 00 00 00 00 00 00"]);
}

//! Network management: N01 to N19 of the listed cases, and C05, L19.

use crate::device::{Device, entries};
use canopen::cia301::nmt::{NmtState, Reset};
use canopen::{Event, Frame};
use embedded_can::{ExtendedId, Frame as _};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

const BOOT_UP: &str = "704 [1] 00";

#[test]
fn n01_the_boot_up_message_is_the_first_frame_and_comes_once() {
    let mut device = Device::off();
    assert!(device.sent().is_empty(), "silent before the boot");
    device.boot(Reset::Node);
    // An emergency has the lower identifier, and waits all the same.
    device.node.report(
        canopen::cia301::emergency::Emergency {
            code: 0x2310,
            register: 2,
            info: [0; 5],
        },
        device.now,
    );
    assert_eq!(device.sent(), [BOOT_UP, "084: 10 23 03 00 00 00 00 00"]);
    assert!(device.pass(5000).is_empty());
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn n02_pre_operational_without_heartbeat_is_silent() {
    let mut device = Device::new();
    device.set_value(0x2005, 0, &[1, 2, 3, 4]);
    assert!(device.pass(5000).is_empty());
    device.send("000 [2] 01 04");
    assert_eq!(device.pass(5000).len(), 1, "Operational is not");
}

#[test]
fn n03_start_sends_each_valid_event_driven_tpdo_once() {
    let mut device = Device::new();
    device.send("000 [2] 01 04");
    assert_eq!(device.node.state(), NmtState::Operational);
    assert_eq!(device.sent(), ["184: 00 00 00 00 00 00 00 00"]);
    assert!(device.pass(1000).is_empty());
    assert_eq!(
        device.events(),
        [Event::StateChanged(NmtState::Operational)]
    );
}

#[test]
fn n04_the_broadcast_starts_too() {
    let mut device = Device::new();
    device.send("000 [2] 01 00");
    assert_eq!(device.node.state(), NmtState::Operational);
    assert_eq!(device.sent(), ["184: 00 00 00 00 00 00 00 00"]);
}

#[test]
fn n05_commands_for_other_nodes_change_nothing() {
    let mut device = Device::new();
    for frame in ["000 [2] 01 05", "000 [2] 02 0B", "000 [2] 81 05"] {
        device.send(frame);
    }
    assert_eq!(device.node.state(), NmtState::PreOperational);
    assert!(device.events().is_empty());
}

#[test]
fn n06_a_command_of_another_length_is_ignored() {
    let mut device = Device::new();
    for frame in [
        "000 [1] 01",
        "000 [0]",
        "000: 01 04 00 00 00 00 00 00",
        "000 [3] 01 04 00",
    ] {
        device.send(frame);
    }
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn n07_unknown_commands_and_node_ids_are_ignored() {
    let mut device = Device::new();
    for frame in [
        "000 [2] 77 04",
        "000 [2] 01 84",
        "000 [2] 00 04",
        "000 [2] FF 04",
    ] {
        device.send(frame);
    }
    assert_eq!(device.node.state(), NmtState::PreOperational);
}

#[test]
fn n08_stopped_has_no_sdo_but_a_heartbeat() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 2B 17 10 00 64 00 00 00"),
        ["584: 60 17 10 00 00 00 00 00", "704 [1] 7F"]
    );
    device.send("000 [2] 02 04");
    assert!(device.ask("604: 40 00 10 00 00 00 00 00").is_empty());
    assert_eq!(device.pass(100), [(100, "704 [1] 04".into())]);
}

#[test]
fn n09_stopped_does_nothing_but_nmt_error_control_and_lss() {
    let mut device = Device::operational();
    // An upload is open, and an answer waits: both are gone after the stop.
    device.put("604: 40 08 10 00 00 00 00 00");
    device.send("000 [2] 02 04");
    assert!(device.sent().is_empty());

    device.send("204: 01 02 03 04 05 06 07 08");
    device.send("080 [0]");
    device.send("100 [6] 00 00 00 00 00 00");
    device.set_value(0x2005, 0, &[1, 2, 3, 4]);
    device.node.report(
        canopen::cia301::emergency::Emergency {
            code: 0x2310,
            register: 2,
            info: [0; 5],
        },
        device.now,
    );
    assert!(device.pass(2000).is_empty());
    assert_eq!(device.value(0x2003, 0), [0; 4], "no receive PDO");
    assert_eq!(
        device.value(0x1001, 0),
        [3],
        "the error register shows the error"
    );

    // Switch state global, inquire node-ID.
    device.send("7E5: 04 01 00 00 00 00 00 00");
    device.send("7E5: 5E 00 00 00 00 00 00 00");
    assert_eq!(device.sent(), ["7E4: 5E 04 00 00 00 00 00 00"]);

    device.send("000 [2] 80 04");
    assert_eq!(device.node.state(), NmtState::PreOperational);
    assert_eq!(
        device.sent(),
        ["084: 10 23 03 00 00 00 00 00"],
        "of what was not sent in Stopped only the error is told later"
    );
    assert_eq!(
        device.ask("604: 60 00 00 00 00 00 00 00"),
        [crate::device::abort(0, 0, 0x0504_0001)]
    );
}

#[test]
fn n10_reset_node_loads_all_power_on_values() {
    let mut device = Device::operational();
    device.ask("604: 23 00 20 00 01 02 03 04");
    device.ask("604: 2B 17 10 00 E8 03 00 00");
    device.send("000 [2] 81 04");
    assert_eq!(device.serve_reset(), Reset::Node);
    assert_eq!(device.sent(), [BOOT_UP]);
    assert_eq!(device.node.state(), NmtState::PreOperational);
    assert_eq!(device.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
    assert_eq!(device.value(0x1017, 0), [0, 0]);
    assert_eq!(device.firmware.power_ons, 2);
    assert!(device.pass(5000).is_empty(), "the heartbeat is off again");
}

#[test]
fn n11_reset_communication_keeps_the_application_objects() {
    let mut device = Device::new();
    device.ask("604: 23 00 20 00 01 02 03 04");
    device.ask("604: 2B 17 10 00 E8 03 00 00");
    device.send("000 [2] 82 04");
    assert_eq!(device.serve_reset(), Reset::Communication);
    assert_eq!(device.sent(), [BOOT_UP]);
    assert_eq!(device.value(0x2000, 0), [1, 2, 3, 4]);
    assert_eq!(device.value(0x1017, 0), [0, 0]);
    assert_eq!(
        device.value(0x1018, 4),
        [0x78, 0x56, 0x34, 0x12],
        "the serial number is no parameter"
    );
    assert_eq!(device.firmware.power_ons, 1);
}

#[test]
fn n12_two_commands_between_two_polls_are_both_executed() {
    let mut device = Device::operational();
    device.put("000 [2] 02 04");
    device.put("000 [2] 01 04");
    device.poll();
    let expected = [
        Event::StateChanged(NmtState::Stopped),
        Event::StateChanged(NmtState::Operational),
    ];
    assert_eq!(device.events(), expected);
    assert_eq!(device.sent(), ["184: 00 00 00 00 00 00 00 00"]);
}

#[test]
fn n13_a_reset_ends_an_open_transfer_without_an_abort() {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 21 17 10 00 02 00 00 00"),
        ["584: 60 17 10 00 00 00 00 00"]
    );
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.sent(), [BOOT_UP]);
    assert!(device.pass(3000).is_empty());
    assert_eq!(
        device.ask("604: 40 00 10 00 00 00 00 00"),
        ["584: 43 00 10 00 92 01 02 00"]
    );
}

#[test]
fn n14_extended_and_remote_frames_are_no_nmt() {
    let mut device = Device::new();
    let extended = Frame::new(ExtendedId::ZERO, &[1, 4]).unwrap();
    device
        .node
        .receive(&extended, device.now, &mut device.firmware);
    for frame in ["000 [8] rtr", "080 [8] rtr", "604 [8] rtr", "7E5 [8] rtr"] {
        device.send(frame);
    }
    assert_eq!(device.node.state(), NmtState::PreOperational);
    assert!(
        device.sent().is_empty(),
        "a remote frame is not a SYNC of a wrong length either"
    );
}

#[test]
fn n15_start_in_operational_changes_nothing() {
    let mut device = Device::operational();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    device.pass(30);
    device.send("000 [2] 01 04");
    assert!(device.sent().is_empty(), "no second burst, no heartbeat");
    assert_eq!(device.pass(100), [(70, "704 [1] 05".into())]);
    assert!(device.events().is_empty());
}

#[test]
fn a_reset_waits_in_silence_until_the_motor_has_stopped() {
    let mut device = Device::operational();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    device.put("604: 40 00 10 00 00 00 00 00");
    device.send("000 [2] 81 04");
    assert_eq!(device.node.state(), NmtState::Initialisation);
    assert_eq!(device.pass(500), [], "no answer, no heartbeat, no PDO");
    device.send("000 [2] 01 04");
    device.send("604: 40 00 10 00 00 00 00 00");
    device.send("7E5: 04 01 00 00 00 00 00 00");
    device.send("7E5: 5E 00 00 00 00 00 00 00");
    assert_eq!(device.pass(500), [], "deaf as well");
    assert_eq!(
        device.events(),
        [
            Event::StateChanged(NmtState::Initialisation),
            Event::ResetRequested(Reset::Node)
        ]
    );
    device.boot(Reset::Node);
    assert_eq!(device.pass(500), [(0, BOOT_UP.into())]);
    assert_eq!(
        device.events(),
        [Event::StateChanged(NmtState::PreOperational)]
    );
}

#[test]
fn a_reset_that_is_held_back_lets_the_device_go_on_until_the_boot() {
    let mut device = Device::operational();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    device.node.hold_resets(true);
    device.send("000 [2] 81 04");
    assert!(device.node.holds_reset());
    assert_eq!(device.events(), [Event::ResetRequested(Reset::Node)]);
    assert_eq!(device.pass(100), [(100, "704 [1] 05".into())]);
    assert_eq!(
        device.ask("604: 40 00 10 00 00 00 00 00").len(),
        1,
        "SDO is served"
    );
    device.send("000 [2] 82 04");
    assert_eq!(
        device.events(),
        [Event::ResetRequested(Reset::Communication)],
        "a second one is told as well"
    );
    device.node.hold_resets(false);
    assert!(!device.node.holds_reset() && device.node.is_mute());
    assert_eq!(device.pass(500), [], "silent now");
    device.boot(Reset::Node);
    assert_eq!(device.pass(500), [(0, BOOT_UP.into())]);
    assert!(!device.node.holds_reset());
}

#[test]
fn a_boot_serves_a_reset_that_nobody_has_asked_for_yet() {
    let mut device = Device::new();
    device.send("000 [2] 82 04");
    device.boot(Reset::Communication);
    assert_eq!(device.sent(), [BOOT_UP]);
    assert_eq!(
        device.events(),
        [
            Event::StateChanged(NmtState::Initialisation),
            Event::StateChanged(NmtState::PreOperational)
        ]
    );
}

#[test]
fn l19_a_device_without_a_node_id_is_silent_but_for_lss() {
    let mut device = Device::off_with(255);
    device.boot(Reset::Node);
    for frame in [
        "000 [2] 01 00",
        "000 [2] 81 00",
        "67F: 40 00 10 00 00 00 00 00",
        "080 [0]",
        "6FF: 40 00 10 00 00 00 00 00",
    ] {
        device.send(frame);
    }
    assert!(device.pass(5000).is_empty());
    assert_eq!(device.node.state(), NmtState::Initialisation);
    assert!(device.events().is_empty());
    device.send("7E5: 04 01 00 00 00 00 00 00");
    assert_eq!(
        device.ask("7E5: 5E 00 00 00 00 00 00 00"),
        ["7E4: 5E FF 00 00 00 00 00 00"]
    );
}

#[test]
fn l16_a_first_node_id_boots_the_device() {
    let mut device = Device::off_with(255);
    device.boot(Reset::Node);
    device.send("7E5: 04 01 00 00 00 00 00 00");
    assert_eq!(
        device.ask("7E5: 11 0B 00 00 00 00 00 00"),
        ["7E4: 11 00 00 00 00 00 00 00"]
    );
    device.send("7E5: 04 00 00 00 00 00 00 00");
    assert_eq!(device.serve_reset(), Reset::Communication);
    assert_eq!(device.sent(), ["70B [1] 00"]);
    assert_eq!(device.value(0x1200, 1), [0x0B, 0x06, 0, 0]);
    assert_eq!(device.value(0x1018, 4), [0x78, 0x56, 0x34, 0x12]);
    assert_eq!(
        device.ask("60B: 40 00 10 00 00 00 00 00"),
        ["58B: 43 00 10 00 92 01 02 00"]
    );
}

#[test]
fn l18_a_new_node_id_needs_a_reset_of_communication() {
    let mut device = Device::operational();
    device.send("7E5: 04 01 00 00 00 00 00 00");
    assert_eq!(
        device.ask("7E5: 11 0B 00 00 00 00 00 00"),
        ["7E4: 11 00 00 00 00 00 00 00"]
    );
    device.send("7E5: 04 00 00 00 00 00 00 00");
    assert_eq!(
        device.ask("604: 40 00 10 00 00 00 00 00"),
        ["584: 43 00 10 00 92 01 02 00"]
    );
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.sent(), ["70B [1] 00"]);
    assert!(device.ask("604: 40 00 10 00 00 00 00 00").is_empty());
    assert_eq!(
        device.ask("60B: 40 00 10 00 00 00 00 00"),
        ["58B: 43 00 10 00 92 01 02 00"]
    );
}

#[test]
fn c05_frames_that_classic_can_cannot_carry_do_not_exist() {
    assert!(Frame::new(ExtendedId::ZERO, &[0; 9]).is_none());
    assert!(Frame::new_remote(ExtendedId::ZERO, 9).is_none());
    // An identifier beyond 11 bits is an extended frame, and means nothing here.
    let mut device = Device::new();
    let extended = Frame::new(
        ExtendedId::new(0x604).unwrap(),
        &[0x40, 0, 0x10, 0, 0, 0, 0, 0],
    )
    .unwrap();
    assert!(extended.is_extended() && !extended.is_standard());
    let base = Frame::data_frame(0x604, &[]);
    assert!(base.is_standard() && !base.is_extended());
    device
        .node
        .receive(&extended, device.now, &mut device.firmware);
    assert!(device.sent().is_empty());
    assert_eq!(Frame::data_frame(0x604, &[0; 10]).length(), 8);
    // Nor does a remote frame where data is expected.
    for id in ["000", "080", "204", "604", "7E5"] {
        assert!(device.ask(&format!("{id} [8] rtr")).is_empty(), "{id}");
    }
    assert_eq!(device.node.state(), NmtState::PreOperational);
    assert_eq!(device.ask("604: 40 00 10 00 00 00 00 00").len(), 1);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(64)))]

    #[test]
    fn n19_random_values_in_communication_objects_do_not_survive_a_reset(
        writes in proptest::collection::vec((0..150_usize, any::<u32>()), 1..200),
        start in any::<bool>(),
    ) {
        let mut device = Device::new();
        let fresh: Vec<_> = entries().iter().map(|entry| device.value(entry.index, entry.sub)).collect();
        if start {
            device.send("000 [2] 01 04");
        }
        for (number, value) in writes {
            let communication = entries().iter().filter(|entry| entry.index < 0x2000);
            let entry = communication.clone().nth(number % communication.count()).unwrap();
            let [low, high] = entry.index.to_le_bytes();
            let [a, b, c, d] = value.to_le_bytes();
            let request = [0x22, low, high, entry.sub, a, b, c, d];
            device.node.receive(&Frame::data_frame(0x604, &request), device.now, &mut device.firmware);
            device.poll();
            device.sent();
        }
        device.send("000 [2] 81 04");
        device.serve_reset();
        prop_assert_eq!(device.pass(1000), [(0, BOOT_UP.to_owned())]);
        for (entry, value) in entries().iter().zip(fresh) {
            prop_assert_eq!(device.value(entry.index, entry.sub), value);
        }
    }
}

//! Layer setting services across resets, stores that overlap, and a bus that is not free: frame by frame.

use crate::device::{Device, full};
use canopen::cia301::nmt::{NmtState, Reset};
use canopen::node::StoreError;
use canopen::{BitRate, Configuration, Event, NodeId};

/// A request with its bytes filled up to eight; what is sent then.
fn ask(device: &mut Device, bytes: &str) -> Vec<String> {
    device.ask(&request(bytes))
}

fn request(bytes: &str) -> String {
    full("7E5", bytes)
}

/// The answer with its bytes filled up to eight.
fn answer(bytes: &str) -> [String; 1] {
    [full("7E4", bytes)]
}

/// Node 4 in the configuration state.
fn in_configuration() -> Device {
    let mut device = Device::new();
    assert!(ask(&mut device, "0401").is_empty());
    device
}

/// Without a node-ID, in the waiting state.
fn unconfigured() -> Device {
    let mut device = Device::off_with(255);
    device.boot(Reset::Node);
    device
}

fn settings(node_id: u8) -> Configuration {
    Configuration {
        node_id: NodeId::new(node_id).unwrap(),
        ..Configuration::default()
    }
}

#[test]
fn every_reset_leads_to_the_waiting_state() {
    for reset in ["000 [2] 82 04", "000 [2] 81 04"] {
        let mut device = in_configuration();
        assert_eq!(ask(&mut device, "110B"), answer("1100"));
        device.send(reset);
        device.serve_reset();
        assert_eq!(device.sent(), ["70B [1] 00"], "what was configured counts");
        assert!(ask(&mut device, "5E").is_empty(), "after {reset}");
    }
}

#[test]
fn a_reset_ends_a_service_of_several_messages() {
    let mut device = Device::new();
    let words = ["4044332211", "4188776655", "42CCBBAA99"];
    for request in words {
        assert!(ask(&mut device, request).is_empty());
    }
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.sent(), ["704 [1] 00"]);
    assert!(ask(&mut device, "4378563412").is_empty());
    for request in words {
        ask(&mut device, request);
    }
    assert_eq!(ask(&mut device, "4378563412"), answer("44"), "without one");
}

#[test]
fn a_scan_ends_with_a_change_of_state_and_with_a_reset() {
    let mut device = unconfigured();
    assert_eq!(ask(&mut device, "5100000000800000"), answer("4F"));
    ask(&mut device, "0401");
    ask(&mut device, "0400");
    assert!(ask(&mut device, "51000000001F0000").is_empty());

    assert_eq!(ask(&mut device, "5100000000800000"), answer("4F"));
    assert_eq!(ask(&mut device, "51000000001F0000"), answer("4F"));
    device.boot(Reset::Communication);
    assert!(ask(&mut device, "51000000001F0000").is_empty());
}

#[test]
fn identifying_is_interrupted_by_any_other_service_in_both_states() {
    let words = ["4644332211", "4788776655", "4800000000", "49FFFFFFFF"];
    let last = ["4A78563412", "4B78563412"];
    for state in ["0400", "0401"] {
        for other in ["4044332211", "4188776655", "4300000000", "4C", "99"] {
            let mut device = Device::new();
            ask(&mut device, state);
            for request in words {
                assert!(ask(&mut device, request).is_empty());
            }
            assert!(ask(&mut device, other).is_empty());
            for request in last {
                assert!(ask(&mut device, request).is_empty(), "{state}, {other}");
            }
        }
    }
    let mut device = Device::new();
    for request in words.iter().chain(&last[..1]) {
        assert!(ask(&mut device, request).is_empty());
    }
    assert_eq!(
        ask(&mut device, last[1]).len(),
        1,
        "without another service"
    );
}

#[test]
fn a_second_store_is_answered_when_the_newest_settings_are_stored() {
    let mut device = in_configuration();
    assert_eq!(ask(&mut device, "110B"), answer("1100"));
    assert!(!device.node.is_storing_settings());
    assert!(ask(&mut device, "17").is_empty());
    assert_eq!(device.events(), [Event::StoreSettings(settings(11))]);
    for node_id in ["110C", "110D"] {
        assert_eq!(ask(&mut device, node_id), answer("1100"));
        assert!(ask(&mut device, "17").is_empty());
    }
    assert_eq!(ask(&mut device, "110E"), answer("1100"));
    assert!(device.events().is_empty(), "one at a time");
    device.node.settings_stored(Ok(()));
    assert!(device.node.is_storing_settings());
    assert!(device.sent().is_empty(), "not yet");
    assert_eq!(
        device.events(),
        [Event::StoreSettings(settings(13))],
        "what the last request has seen"
    );
    device.node.settings_stored(Err(StoreError::Medium));
    assert!(!device.node.is_storing_settings());
    assert_eq!(device.sent(), answer("1702"));
    device.node.settings_stored(Ok(()));
    assert!(device.sent().is_empty(), "one answer");
    assert!(ask(&mut device, "17").is_empty());
    assert_eq!(device.events(), [Event::StoreSettings(settings(14))]);
}

#[test]
fn a_second_store_survives_a_reset() {
    let mut device = in_configuration();
    assert_eq!(ask(&mut device, "110B"), answer("1100"));
    assert!(ask(&mut device, "17").is_empty());
    device.send("000 [2] 82 04");
    assert!(
        device
            .events()
            .contains(&Event::StoreSettings(settings(11)))
    );
    device.boot(Reset::Communication);
    assert_eq!(device.sent(), ["70B [1] 00"]);
    ask(&mut device, "0401");
    assert_eq!(ask(&mut device, "110C"), answer("1100"));
    assert!(ask(&mut device, "17").is_empty());
    device.events();
    device.node.settings_stored(Ok(()));
    assert!(device.sent().is_empty(), "12 is not stored yet");
    assert_eq!(device.events(), [Event::StoreSettings(settings(12))]);
    device.node.settings_stored(Ok(()));
    assert_eq!(device.sent(), answer("1700"));
}

#[test]
fn what_lss_wants_done_finds_room_behind_any_number_of_changes_of_state() {
    let mut device = in_configuration();
    for _ in 0..20 {
        device.put("000 [2] 01 04");
        device.put("000 [2] 80 04");
    }
    device.put(&request("17"));
    device.put(&request("130002"));
    device.put(&request("150A00"));
    let events = device.events();
    assert!(events.contains(&Event::StoreSettings(settings(4))));
    assert!(
        events.iter().any(|event| matches!(
            event,
            Event::SwitchBitRate {
                bit_rate: BitRate::Kbit500,
                ..
            }
        )),
        "{events:?}"
    );
    assert!(
        device.node.overflows() > 0,
        "changes of state were left out"
    );
}

#[test]
fn answers_that_wait_for_the_bus_keep_their_order() {
    let mut device = in_configuration();
    for bytes in ["5A", "5B", "5E"] {
        device.put(&request(bytes));
    }
    assert_eq!(
        device.sent(),
        [
            "7E4: 5A 44 33 22 11 00 00 00",
            "7E4: 5B 88 77 66 55 00 00 00",
            "7E4: 5E 04 00 00 00 00 00 00"
        ]
    );
    assert_eq!(device.node.overflows(), 0);
}

#[test]
fn an_answer_without_room_is_counted() {
    let mut device = in_configuration();
    for bytes in ["5A", "5B", "5C", "5D", "5E", "5E"] {
        device.put(&request(bytes));
    }
    let sent = device.sent();
    assert_eq!(sent.len(), 4);
    assert_eq!(sent[3], "7E4: 5D 78 56 34 12 00 00 00");
    assert_eq!(device.node.overflows(), 2);
    assert_eq!(ask(&mut device, "5E"), answer("5E04"));
}

#[test]
fn an_answer_that_waits_outlives_a_reset_and_follows_the_boot_up_message() {
    let mut device = in_configuration();
    device.put(&request("5E"));
    device.send("000 [2] 82 04");
    assert!(device.sent().is_empty(), "silent until it boots");
    device.serve_reset();
    assert_eq!(
        device.sent(),
        ["704 [1] 00", "7E4: 5E 04 00 00 00 00 00 00"]
    );
}

#[test]
fn the_boot_up_message_waits_for_the_new_bit_rate() {
    let mut device = in_configuration();
    assert!(ask(&mut device, "156400").is_empty());
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert!(device.sent().is_empty());
    assert_eq!(device.pass(1000), [(200, "704 [1] 00".to_owned())]);
}

#[test]
fn an_sdo_request_in_the_silence_of_a_bit_rate_switch_is_not_executed() {
    let mut device = in_configuration();
    assert!(ask(&mut device, "156400").is_empty());
    device.send("604: 23 00 20 00 AA BB CC DD");
    assert_eq!(device.value(0x2000, 0), [0x78, 0x56, 0x34, 0x12]);
    assert!(device.pass(199).is_empty(), "nor answered");
    device.pass(1);
    assert_eq!(
        device.ask("604: 23 00 20 00 AA BB CC DD"),
        ["584: 60 00 20 00 00 00 00 00"]
    );
    assert_eq!(device.value(0x2000, 0), [0xAA, 0xBB, 0xCC, 0xDD]);
}

#[test]
fn the_silence_ends_by_the_stamp_of_a_request() {
    let mut device = in_configuration();
    assert!(ask(&mut device, "156400").is_empty());
    device.now += canopen::Duration::millis(200);
    assert_eq!(
        device.ask("604: 40 00 10 00 00 00 00 00"),
        ["584: 43 00 10 00 92 01 02 00"]
    );
}

#[test]
fn becoming_unconfigured_is_a_change_of_state() {
    let mut device = in_configuration();
    assert_eq!(ask(&mut device, "11FF"), answer("1100"));
    device.send("000 [2] 82 04");
    device.boot(Reset::Communication);
    assert_eq!(device.node.state(), NmtState::Initialisation);
    assert!(device.sent().is_empty());
    assert_eq!(
        device.events(),
        [Event::StateChanged(NmtState::Initialisation)]
    );
}

#[test]
fn a_reset_passes_through_initialisation() {
    let mut device = Device::new();
    device.send("000 [2] 82 04");
    assert_eq!(
        device.events(),
        [
            Event::StateChanged(NmtState::Initialisation),
            Event::ResetRequested(Reset::Communication)
        ]
    );
    device.boot(Reset::Communication);
    assert_eq!(
        device.events(),
        [Event::StateChanged(NmtState::PreOperational)]
    );
}

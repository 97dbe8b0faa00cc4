//! Heartbeat consumers: H03 to H09 of the listed cases, and the error behaviour N17 that follows a loss.

use crate::device::{Device, abort};
use canopen::cia301::error_behaviour::CommunicationError;
use canopen::cia301::heartbeat::HeartbeatError;
use canopen::cia301::nmt::NmtState;
use canopen::{Event, NodeId};
use proptest::prelude::*;

fn five() -> NodeId {
    NodeId::new(5).unwrap()
}

/// Watches node 5 with a time of one second.
fn watching() -> Device {
    let mut device = Device::new();
    assert_eq!(
        device.ask("604: 23 16 10 01 E8 03 05 00"),
        ["584: 60 16 10 01 00 00 00 00"]
    );
    device
}

/// Node 5 has been lost.
fn lost() -> Device {
    let mut device = watching();
    device.send("705 [1] 05");
    assert_eq!(
        device.pass(1000),
        [(1000, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
    device
}

fn errors(device: &mut Device) -> Vec<CommunicationError> {
    let events = device.events().into_iter();
    events
        .filter_map(|event| match event {
            Event::CommunicationError(error) => Some(error),
            _ => None,
        })
        .collect()
}

#[test]
fn h03_a_node_is_watched_once() {
    let mut device = watching();
    assert_eq!(
        device.ask("604: 23 16 10 02 F4 01 05 00"),
        [abort(0x1016, 2, 0x0604_0043)]
    );
    assert_eq!(device.value(0x1016, 2), [0; 4]);
    assert_eq!(
        device.ask("604: 23 16 10 01 F4 01 05 00"),
        ["584: 60 16 10 01 00 00 00 00"],
        "the same entry may change its time"
    );
    assert_eq!(
        device.ask("604: 23 16 10 02 00 00 05 00"),
        ["584: 60 16 10 02 00 00 00 00"],
        "an entry without a time watches nobody"
    );
    assert_eq!(
        device.ask("604: 23 16 10 01 00 00 00 00"),
        ["584: 60 16 10 01 00 00 00 00"]
    );
    assert_eq!(
        device.ask("604: 23 16 10 02 F4 01 05 00"),
        ["584: 60 16 10 02 00 00 00 00"],
        "nobody else watches it now"
    );
}

#[test]
fn h04_a_boot_up_message_does_not_arm_the_consumer() {
    let mut device = watching();
    assert!(device.pass(5000).is_empty(), "not heard of yet");
    device.send("705 [1] 00");
    assert!(device.pass(5000).is_empty());
    assert_eq!(device.node.remote_state(five()), None);
    for (state, number) in [("7F", 0x7F), ("04", 4), ("05", 5)] {
        let mut device = watching();
        device.send(&format!("705 [1] {state}"));
        let state = device.node.remote_state(five());
        assert_eq!(state.map(|state| state as u8), Some(number));
        assert_eq!(device.pass(1000).len(), 1);
        assert_eq!(device.node.remote_state(five()), None);
    }
}

#[test]
fn h05_silence_is_told_once() {
    let mut device = watching();
    device.send("705 [1] 05");
    assert!(device.pass(999).is_empty());
    device.send("705 [1] 05");
    assert_eq!(
        device.pass(5000),
        [(1000, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(
        errors(&mut device),
        [CommunicationError::Heartbeat(HeartbeatError::Lost(five()))]
    );
}

#[test]
fn h05_what_is_no_heartbeat_of_the_node_does_not_count() {
    let mut device = watching();
    device.send("705 [1] 05");
    assert!(device.pass(900).is_empty());
    for frame in ["706 [1] 05", "705 [2] 05 05", "705 [8] rtr"] {
        assert!(device.ask(frame).is_empty(), "{frame}");
    }
    assert_eq!(
        device.pass(5000),
        [(100, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
}

#[test]
fn h06_a_heartbeat_that_returns_resets_the_error() {
    let mut device = lost();
    assert_eq!(
        device.ask("705 [1] 00"),
        [""; 0],
        "a boot-up message is none"
    );
    assert_eq!(device.ask("705 [1] 7F"), ["084: 00 00 00 00 00 00 00 00"]);
    assert_eq!(
        device.pass(5000),
        [(1000, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
}

#[test]
fn h06_each_node_has_its_own_error() {
    let mut device = watching();
    device.ask("604: 23 16 10 02 D0 07 06 00");
    device.send("705 [1] 05");
    device.send("706 [1] 05");
    assert_eq!(
        device.pass(3000),
        [
            (1000, "084: 30 81 11 05 00 00 00 00".to_string()),
            (2000, "084: 30 81 11 06 00 00 00 00".to_string())
        ]
    );
    assert_eq!(device.ask("705 [1] 05"), ["084: 00 00 11 00 00 00 00 00"]);
    assert_eq!(device.ask("706 [1] 05"), ["084: 00 00 00 00 00 00 00 00"]);
}

#[test]
fn h07_the_boot_up_of_a_node_that_lived_is_told() {
    let mut device = watching();
    device.send("705 [1] 05");
    assert_eq!(device.ask("705 [1] 00"), ["084: 30 81 11 05 01 00 00 00"]);
    assert_eq!(
        errors(&mut device),
        [CommunicationError::Heartbeat(HeartbeatError::Restarted(
            five()
        ))]
    );
    assert!(device.pass(5000).is_empty(), "waited for, and told already");
    assert_eq!(device.ask("705 [1] 7F"), ["084: 00 00 00 00 00 00 00 00"]);
}

#[test]
fn h08_time_0_and_what_is_no_node_are_stored_and_off() {
    for value in [
        "E8030000", "00000500", "00000000", "E8038000", "E803FF00", "00008000",
    ] {
        let mut device = Device::new();
        assert_eq!(
            device.ask(&format!("604: 23 16 10 01 {value}")),
            ["584: 60 16 10 01 00 00 00 00"]
        );
        let stored: String = device
            .value(0x1016, 1)
            .iter()
            .map(|byte| format!("{byte:02X}"))
            .collect();
        assert_eq!(stored, value);
        device.send("705 [1] 05");
        assert!(device.pass(5000).is_empty());
    }
    assert_eq!(
        Device::new().ask("604: 23 16 10 01 E8 03 05 01"),
        [abort(0x1016, 1, 0x0609_0030)],
        "reserved bits"
    );
}

#[test]
fn h09_a_new_time_counts_from_when_it_is_written() {
    let mut device = watching();
    device.send("705 [1] 05");
    assert!(device.pass(900).is_empty());
    device.ask("604: 23 16 10 01 F4 01 05 00");
    assert_eq!(
        device.pass(2000),
        [(500, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
    device.send("705 [1] 05");
    device.sent();
    device.ask("604: 23 16 10 01 D0 07 05 00");
    assert_eq!(
        device.pass(5000),
        [(2000, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
}

#[test]
fn h09_another_node_is_waited_for_anew_and_ends_the_error() {
    let mut device = lost();
    assert_eq!(
        device.ask("604: 23 16 10 01 E8 03 06 00"),
        [
            "084: 00 00 00 00 00 00 00 00",
            "584: 60 16 10 01 00 00 00 00"
        ]
    );
    device.send("705 [1] 05");
    assert!(device.pass(5000).is_empty());
    device.send("706 [1] 05");
    assert_eq!(device.pass(1000).len(), 1);
}

#[test]
fn h09_a_reset_waits_for_every_node_anew() {
    let mut device = lost();
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.sent(), ["704 [1] 00"]);
    assert_eq!(device.value(0x1001, 0), [0], "the error is void");
    device.send("705 [1] 05");
    assert!(device.pass(5000).is_empty(), "1016h has its power-on value");
}

#[test]
fn a_heartbeat_has_one_byte() {
    let mut device = watching();
    device.send("705 [2] 05 05");
    device.send("705 [0]");
    device.send("705 [8] rtr");
    assert!(device.pass(5000).is_empty());
    device.send("705 [1] 05");
    assert_eq!(device.pass(5000).len(), 1, "from now on it is awaited");
}

/// Operational, 1029h:1 as given, then node 5 falls silent.
fn n17(behaviour: u8, state: &str) -> (Device, Vec<crate::device::Sent>) {
    let mut device = watching();
    device.ask(&format!("604: 2F 29 10 01 {behaviour:02X} 00 00 00"));
    device.send(&format!("000 [2] {state} 04"));
    device.send("705 [1] 05");
    device.sent();
    let sent = device.pass(1500);
    (device, sent)
}

#[test]
fn n17_1029h_says_where_the_device_goes_when_a_heartbeat_is_lost() {
    let message = [(1000, "084: 30 81 11 05 00 00 00 00".to_string())];
    for (behaviour, state) in [
        (0, NmtState::PreOperational),
        (1, NmtState::Operational),
        (2, NmtState::Stopped),
    ] {
        let (device, sent) = n17(behaviour, "01");
        assert_eq!(device.node.state(), state);
        assert_eq!(sent, message, "the device tells why, whatever comes next");
    }
}

#[test]
fn n17_in_pre_operational_only_2_changes_the_state() {
    for (behaviour, state) in [
        (0, NmtState::PreOperational),
        (1, NmtState::PreOperational),
        (2, NmtState::Stopped),
    ] {
        assert_eq!(n17(behaviour, "80").0.node.state(), state);
    }
    let (device, sent) = n17(0, "02");
    assert_eq!(device.node.state(), NmtState::Stopped);
    assert!(sent.is_empty(), "no emergency messages in Stopped");
    assert_eq!(device.value(0x1001, 0), [0x11]);
}

/// Watches nodes 5 and 6 with the given settings, and both live.
fn watching_two(settings: &[&str]) -> Device {
    let mut device = Device::new();
    let watched = [
        "604: 23 16 10 01 C8 00 05 00",
        "604: 23 16 10 02 C8 00 06 00",
    ];
    for request in watched.iter().chain(settings) {
        assert_eq!(device.ask(request).len(), 1);
    }
    device.send("705 [1] 05");
    device.send("706 [1] 05");
    device
}

#[test]
fn e10_a_loss_in_stopped_is_told_behind_it() {
    let mut device = Device::new();
    device.ask("604: 23 16 10 01 C8 00 7F 00");
    device.send("77F [1] 05");
    device.send("000 [2] 02 04");
    assert!(device.pass(500).is_empty(), "no message in Stopped");
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(
        device.ask("000 [2] 80 04"),
        ["084: 30 81 11 7F 00 00 00 00"]
    );
}

#[test]
fn e10_a_heartbeat_that_returns_in_stopped_is_told_behind_it() {
    let mut device = lost();
    device.send("000 [2] 02 04");
    assert!(device.ask("705 [1] 05").is_empty());
    assert_eq!(
        device.ask("000 [2] 80 04"),
        ["084: 00 00 00 00 00 00 00 00"]
    );
}

#[test]
fn e10_what_the_inhibit_time_holds_back_outlives_stopped() {
    let mut device = watching_two(&["604: 2B 15 10 00 88 13 00 00"]);
    assert_eq!(
        device.pass(300),
        [(200, "084: 30 81 11 05 00 00 00 00".to_string())]
    );
    device.send("000 [2] 02 04");
    assert!(device.pass(1000).is_empty());
    assert_eq!(
        device.ask("000 [2] 80 04"),
        ["084: 30 81 11 06 00 00 00 00"]
    );
}

#[test]
fn n17_two_losses_at_once_are_both_told() {
    let mut device = watching_two(&["604: 2F 29 10 01 02 00 00 00"]);
    assert_eq!(
        device.pass(300),
        [
            (200, "084: 30 81 11 05 00 00 00 00".to_string()),
            (200, "084: 30 81 11 06 00 00 00 00".to_string())
        ]
    );
    assert_eq!(device.node.state(), NmtState::Stopped);
    assert!(device.ask("000 [2] 80 04").is_empty());
}

#[test]
fn n17_reserved_values_are_refused() {
    let mut device = Device::new();
    for value in [3, 4, 255] {
        assert_eq!(
            device.ask(&format!("604: 2F 29 10 01 {value:02X} 00 00 00")),
            [abort(0x1029, 1, 0x0609_0030)]
        );
    }
}

/// What may happen between a device and the three nodes that it watches.
#[derive(Clone, Debug)]
enum Step {
    /// The byte of an error control message of node 5, 6 or 7.
    Heard(u8, u8),
    /// Milliseconds.
    Pass(u64),
}

fn step() -> impl Strategy<Value = Step> {
    let state = prop::sample::select(vec![0x00, 0x04, 0x05, 0x7F]);
    prop_oneof![
        (5..8_u8, state).prop_map(|(node, state)| Step::Heard(node, state)),
        (0..150_u64).prop_map(Step::Pass),
    ]
}

/// A watched node as the standard describes it.
#[derive(Clone, Copy, Default)]
struct Model {
    /// When it is lost; `None` while nobody waits for it.
    deadline: Option<u64>,
    has_error: bool,
}

proptest! {
    #[test]
    fn h05_a_node_is_lost_exactly_when_it_was_silent_for_its_time(
        steps in prop::collection::vec(step(), 1..60),
        times in prop::array::uniform3(1..200_u16),
    ) {
        let mut device = Device::new();
        for (place, time) in times.iter().enumerate() {
            let [low, high] = time.to_le_bytes();
            let request = format!("604: 23 16 10 {:02X} {low:02X} {high:02X} {:02X} 00", place + 1, place + 5);
            prop_assert_eq!(device.ask(&request).len(), 1);
        }
        let mut models = [Model::default(); 3];
        let mut now = 0;
        for step in &steps {
            match *step {
                Step::Heard(node, state) => {
                    device.send(&format!("7{node:02X} [1] {state:02X}"));
                    let place = usize::from(node - 5);
                    let model = &mut models[place];
                    if state != 0 {
                        *model = Model { deadline: Some(now + u64::from(times[place])), has_error: false };
                    } else if model.deadline.take().is_some() {
                        model.has_error = true;
                    }
                }
                Step::Pass(milliseconds) => {
                    now += milliseconds;
                    device.pass(milliseconds);
                    device.poll();
                    for model in &mut models {
                        if model.deadline.is_some_and(|deadline| deadline <= now) {
                            *model = Model { deadline: None, has_error: true };
                        }
                    }
                }
            }
            for (node, model) in (5..8).zip(&models) {
                let alive = device.node.remote_state(NodeId::new(node).unwrap()).is_some();
                prop_assert_eq!(alive, model.deadline.is_some(), "node {}", node);
            }
            let has_error = models.iter().any(|model| model.has_error);
            prop_assert_eq!(device.value(0x1001, 0), [if has_error { 0x11 } else { 0 }]);
        }
    }
}

#[test]
fn n17_a_loss_that_stops_the_device_abandons_a_write_at_once() {
    let mut device = watching();
    device.ask("604: 2F 29 10 01 02 00 00 00");
    device.send("705 [1] 05");
    device.ask("604: 21 14 20 00 64 00 00 00");
    device.ask("604: 00 01 02 03 04 05 06 07");
    assert!(device.firmware.stream.incoming.is_some());
    // Kept alive until shortly before the loss: no time-out of SDO comes with it.
    for _ in 0..9 {
        device.pass(100);
    }
    device.ask("604: 10 01 02 03 04 05 06 07");
    device.now += canopen::Duration::from_ticks(100_000);
    device.poll();
    assert_eq!(device.node.state(), NmtState::Stopped);
    assert_eq!(device.firmware.stream.abandoned, 1);
}

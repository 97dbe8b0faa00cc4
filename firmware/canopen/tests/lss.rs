//! Layer setting services on the bus: L01 to L19 of the listed cases, frame by frame.

use crate::device::{Device, frame, full};
use canopen::cia301::nmt::Reset;
use canopen::node::StoreError;
use canopen::{BitRate, Event, Frame, NodeId, Settings};
use embedded_can::{ExtendedId, Frame as _};

/// A request with its bytes filled up to eight; what is sent then.
fn ask(device: &mut Device, bytes: &str) -> Vec<String> {
    device.ask(&full("7E5", bytes))
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

#[test]
fn l01_the_waiting_state_tells_nothing() {
    let mut device = Device::new();
    for request in ["5E", "5A", "110B", "130002", "17"] {
        assert!(ask(&mut device, request).is_empty());
    }
    assert!(device.events().is_empty());
    ask(&mut device, "0401");
    for request in ["5E", "5A", "110B", "130002"] {
        assert_eq!(ask(&mut device, request).len(), 1, "{request}");
    }
}

#[test]
fn l02_l03_the_configuration_state_tells_node_id_and_identity() {
    let mut device = in_configuration();
    assert_eq!(ask(&mut device, "5E"), answer("5E04"));
    assert_eq!(ask(&mut device, "5A"), answer("5A44332211"));
    assert_eq!(ask(&mut device, "5B"), answer("5B88776655"));
    assert_eq!(ask(&mut device, "5C"), answer("5CCCBBAA99"));
    assert_eq!(ask(&mut device, "5D"), answer("5D78563412"));

    let mut device = unconfigured();
    ask(&mut device, "0401");
    assert_eq!(ask(&mut device, "5D"), answer("5D78563412"));
    assert_eq!(ask(&mut device, "5E"), answer("5EFF"));
}

#[test]
fn l04_configure_node_id() {
    let mut device = in_configuration();
    for refused in ["00", "80", "FE"] {
        assert_eq!(ask(&mut device, &format!("11{refused}")), answer("1101"));
    }
    for taken in ["01", "0B", "7F", "FF"] {
        assert_eq!(ask(&mut device, &format!("11{taken}")), answer("1100"));
    }
}

#[test]
fn l05_a_bit_rate_that_is_not_there_is_answered() {
    let mut device = in_configuration();
    for request in ["130005", "130063", "130100"] {
        assert_eq!(ask(&mut device, request), answer("1301"));
    }
    for index in [0, 1, 2, 3, 4, 6, 7, 8] {
        let request = format!("13000{index}");
        assert_eq!(ask(&mut device, &request), answer("1300"), "{request}");
    }
}

#[test]
fn l06_the_bit_rate_is_switched_in_silence() {
    let mut device = in_configuration();
    assert_eq!(
        device.ask("604: 2B 17 10 00 2C 01 00 00"),
        ["584: 60 17 10 00 00 00 00 00", "704 [1] 7F"]
    );
    assert_eq!(ask(&mut device, "130002"), answer("1300"));
    let start = device.now.ticks();
    assert!(ask(&mut device, "15E803").is_empty());
    let events = device.events();
    let [
        Event::SwitchBitRate {
            bit_rate: BitRate::Kbit500,
            at,
        },
    ] = events[..]
    else {
        panic!("{events:?}");
    };
    assert_eq!(at.ticks(), start + 1_000_000);
    let log = device.pass(2500);
    assert!(log.iter().all(|(moment, _)| *moment >= 2000), "{log:?}");
    assert!(!log.is_empty(), "the heartbeat is back");
    assert_eq!(device.node.settings().bit_rate, BitRate::Kbit500);
}

#[test]
fn l07_the_answer_to_store_comes_when_it_is_done() {
    for (result, expected) in [
        (Ok(()), "1700"),
        (Err(StoreError::NotSupported), "1701"),
        (Err(StoreError::Medium), "1702"),
    ] {
        let mut device = in_configuration();
        assert_eq!(ask(&mut device, "110B"), answer("1100"));
        assert_eq!(ask(&mut device, "130003"), answer("1300"));
        assert!(ask(&mut device, "17").is_empty());
        let settings = Settings {
            node_id: NodeId::new(11).unwrap(),
            bit_rate: BitRate::Kbit250,
        };
        assert_eq!(device.events(), [Event::StoreSettings(settings.into())]);
        device.node.settings_stored(result);
        assert_eq!(device.sent(), answer(expected));
    }
}

#[test]
fn l08_l09_switch_state_selective() {
    let right = ["4044332211", "4188776655", "42CCBBAA99", "4378563412"];
    let mut device = Device::new();
    for request in &right[..3] {
        assert!(ask(&mut device, request).is_empty());
    }
    assert_eq!(ask(&mut device, right[3]), answer("44"));
    assert_eq!(ask(&mut device, "5E"), answer("5E04"));

    let mut broken = Vec::new();
    for number in 0..4 {
        let mut wrong_word = right;
        wrong_word[number] = ["4099999999", "4199999999", "4299999999", "4399999999"][number];
        broken.push(wrong_word.to_vec());
    }
    for [a, b, c, d] in [[1, 0, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2]] {
        broken.push(vec![right[a], right[b], right[c], right[d]]);
    }
    for other in ["4C", "5E"] {
        broken.push(vec![right[0], right[1], other, right[2], right[3]]);
    }
    for requests in broken {
        let mut device = Device::new();
        for request in &requests {
            assert!(ask(&mut device, request).is_empty(), "{requests:?}");
        }
        assert!(ask(&mut device, "5E").is_empty(), "{requests:?}");
        // It is no worse for it.
        for request in &right[..3] {
            assert!(ask(&mut device, request).is_empty());
        }
        assert_eq!(ask(&mut device, right[3]), answer("44"));
    }
}

#[test]
fn l10_identify_remote_slave() {
    let hit = [
        "4644332211",
        "4788776655",
        "4800000000",
        "49FFFFFFFF",
        "4A78563412",
        "4B78563412",
    ];
    let any_serial_number = [&hit[..4], &["4A00000000", "4BFFFFFFFF"]].concat();
    let miss = [
        "4644332211",
        "4788776655",
        "4800000000",
        "49FFFFFFFF",
        "4A79563412",
        "4BFFFFFFFF",
    ];
    for state in ["0400", "0401"] {
        let mut device = Device::new();
        ask(&mut device, state);
        for request in &hit[..5] {
            assert!(ask(&mut device, request).is_empty());
        }
        assert_eq!(ask(&mut device, hit[5]), answer("4F"));
        for request in &any_serial_number[..5] {
            assert!(ask(&mut device, request).is_empty());
        }
        assert_eq!(ask(&mut device, any_serial_number[5]), answer("4F"));
        for request in miss {
            assert!(ask(&mut device, request).is_empty());
        }
    }
}

#[test]
fn l11_identify_non_configured_remote_slave() {
    for state in ["0400", "0401"] {
        let mut without = unconfigured();
        ask(&mut without, state);
        assert_eq!(ask(&mut without, "4C"), answer("50"));
        let mut with = Device::new();
        ask(&mut with, state);
        assert!(ask(&mut with, "4C").is_empty());
    }
}

#[test]
fn l12_l14_fastscan_begins_with_an_unconfigured_device() {
    let mut device = unconfigured();
    assert_eq!(ask(&mut device, "5100000000800000"), answer("4F"));
    for request in [
        "5100000000200000",
        "51000000007F0000",
        "5100000000000100",
        "5100000000000400",
        "51000000001F0400",
        "51000000001F0101",
    ] {
        assert!(ask(&mut device, request).is_empty(), "{request}");
    }
    // The scan is where it was: the first bit of the vendor-ID is 0.
    assert_eq!(ask(&mut device, "51000000001F0000"), answer("4F"));
    assert!(ask(&mut Device::new(), "5100000000800000").is_empty());
}

/// Scans the bus of all these devices; the four words of the one that was found.
fn scan(devices: &mut [Device]) -> Option<[u32; 4]> {
    let mut is_answered = |word: u32, bit_check: u8, sub: u8, next: u8| {
        let [a, b, c, d] = word.to_le_bytes();
        let request = Frame::data_frame(0x7E5, &[0x51, a, b, c, d, bit_check, sub, next]);
        let answers = devices.iter_mut().map(|device| {
            device
                .node
                .receive(&request, device.now, &mut device.firmware);
            device.sent()
        });
        let answers: Vec<_> = answers.flatten().collect();
        assert!(
            answers.iter().all(|sent| *sent == answer("4F")[0]),
            "{answers:?}"
        );
        !answers.is_empty()
    };
    if !is_answered(0, 128, 0, 0) {
        return None;
    }
    let mut words = [0; 4];
    for (sub, word) in (0..).zip(&mut words) {
        for bit in (0..32).rev() {
            if !is_answered(*word, bit, sub, sub) {
                *word |= 1 << bit;
            }
        }
        if !is_answered(*word, 0, sub, (sub + 1) % 4) {
            return None;
        }
    }
    Some(words)
}

#[test]
fn l13_a_full_fastscan_ends_in_the_configuration_state() {
    let mut devices = [unconfigured()];
    assert_eq!(
        scan(&mut devices),
        Some([0x1122_3344, 0x5566_7788, 0x99AA_BBCC, 0x1234_5678])
    );
    assert_eq!(ask(&mut devices[0], "5E"), answer("5EFF"));
}

#[test]
fn l15_l16_two_devices_are_found_in_turn_and_boot() {
    let mut devices = [unconfigured(), unconfigured()];
    devices[1].set_value(0x1018, 4, &[0x78, 0x56, 0x34, 0x32]);
    for (node_id, expected) in [("0B", 0x1234_5678), ("0C", 0x3234_5678)] {
        assert_eq!(scan(&mut devices).map(|words| words[3]), Some(expected));
        let configured = devices.iter_mut().filter_map(|device| {
            let answers = ask(device, &format!("11{node_id}"));
            (!answers.is_empty()).then_some((device, answers))
        });
        let mut configured: Vec<_> = configured.collect();
        assert_eq!(
            configured.len(),
            1,
            "one device is in the configuration state"
        );
        let (device, answers) = &mut configured[0];
        assert_eq!(*answers, answer("1100"));
        assert!(ask(device, "0400").is_empty());
        assert_eq!(device.serve_reset(), Reset::Communication);
        assert_eq!(device.sent(), [format!("7{node_id} [1] 00")]);
    }
    assert_eq!(scan(&mut devices), None);
}

#[test]
fn l17_only_data_frames_of_eight_bytes_are_requests() {
    let mut device = Device::new();
    for request in [
        "7E5 [2] 04 01",
        "7E5 [7] 04 01 00 00 00 00 00",
        "7E5 [8] rtr",
    ] {
        device.send(request);
    }
    let id = ExtendedId::new(0x7E5).unwrap();
    let extended = Frame::new(id, frame("7E5: 04 01 00 00 00 00 00 00").payload()).unwrap();
    device
        .node
        .receive(&extended, device.now, &mut device.firmware);
    assert!(ask(&mut device, "5E").is_empty());
    device.send("7E5: 04 01 00 00 00 00 00 00");
    assert_eq!(ask(&mut device, "5E"), answer("5E04"));
}

/// Node 4 in each NMT state, with what error control says of it.
fn in_each_state() -> [(Device, &'static str); 3] {
    [
        ("000 [2] 80 04", "7F"),
        ("000 [2] 01 04", "05"),
        ("000 [2] 02 04", "04"),
    ]
    .map(|(command, state)| {
        let mut device = Device::new();
        device.send(command);
        device.sent();
        (device, state)
    })
}

/// What error control says of the node at this identifier.
fn state_at(device: &mut Device, error_control: &str) -> Vec<String> {
    device.ask(&format!("{error_control} [1] rtr"))
}

#[test]
fn l18_every_service_is_answered_in_each_nmt_state_and_leaves_it() {
    for (mut device, state) in in_each_state() {
        // Identify remote slave, in the waiting state.
        for request in ["4644332211", "4788776655", "48", "49FFFFFFFF", "4A"] {
            assert!(ask(&mut device, request).is_empty());
        }
        assert_eq!(ask(&mut device, "4BFFFFFFFF"), answer("4F"));
        // Switch state selective.
        for request in ["4044332211", "4188776655", "42CCBBAA99"] {
            assert!(ask(&mut device, request).is_empty());
        }
        assert_eq!(ask(&mut device, "4378563412"), answer("44"));
        assert_eq!(ask(&mut device, "5A"), answer("5A44332211"));
        assert_eq!(ask(&mut device, "110B"), answer("1100"));
        assert_eq!(ask(&mut device, "5E"), answer("5E04"), "the one in force");
        assert_eq!(ask(&mut device, "130002"), answer("1300"));
        assert!(ask(&mut device, "17").is_empty());
        device.node.settings_stored(Ok(()));
        assert_eq!(device.sent(), answer("1700"));
        // A configured node is silent for these.
        for request in ["4C", "5100000000800000", "0400"] {
            assert!(ask(&mut device, request).is_empty());
        }
        assert_eq!(state_at(&mut device, "704"), [format!("704 [1] {state}")]);
    }
}

#[test]
fn l18_a_new_node_id_waits_for_reset_communication_in_each_nmt_state() {
    for (mut device, state) in in_each_state() {
        ask(&mut device, "0401");
        assert_eq!(ask(&mut device, "110B"), answer("1100"));
        assert!(ask(&mut device, "0400").is_empty());
        assert!(device.pass(20).is_empty());
        assert_eq!(state_at(&mut device, "704"), [format!("704 [1] {state}")]);
        device.send("000 [2] 82 04");
        device.serve_reset();
        assert_eq!(device.sent(), ["70B [1] 00"]);
        assert_eq!(state_at(&mut device, "70B"), ["70B [1] 7F"]);
    }
}

#[test]
fn l06_the_bit_rate_is_switched_in_each_nmt_state() {
    for (mut device, state) in in_each_state() {
        ask(&mut device, "0401");
        assert_eq!(ask(&mut device, "130002"), answer("1300"));
        assert!(ask(&mut device, "151400").is_empty());
        let events = device.events();
        let switch = |event: &Event| matches!(event, Event::SwitchBitRate { .. });
        assert!(events.iter().any(switch), "{events:?}");
        assert!(device.pass(41).is_empty());
        assert_eq!(device.node.settings().bit_rate, BitRate::Kbit500);
        assert_eq!(state_at(&mut device, "704"), [format!("704 [1] {state}")]);
    }
}

#[test]
fn l19_a_device_that_gives_its_node_id_away_is_silent_after_the_next_reset() {
    let mut device = Device::new();
    device.send("7E5: 04 01 00 00 00 00 00 00");
    assert_eq!(
        device.ask("7E5: 11 FF 00 00 00 00 00 00"),
        ["7E4: 11 00 00 00 00 00 00 00"]
    );
    device.send("7E5: 04 00 00 00 00 00 00 00");
    // Not before the reset.
    assert_eq!(device.ask("604: 40 00 10 00 00 00 00 00").len(), 1);
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert!(device.pass(2_000).is_empty());
    assert!(device.ask("604: 40 00 10 00 00 00 00 00").is_empty());
    assert_eq!(
        device.ask("7E5: 4C 00 00 00 00 00 00 00"),
        ["7E4: 50 00 00 00 00 00 00 00"]
    );
}

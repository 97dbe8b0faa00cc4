//! What writing the parameters of a live transmit PDO changes, and what it leaves: frame by frame.

use crate::device::{Device, Objects, frame, show};
use canopen::cia301::nmt::Reset;
use canopen::{Duration, Instant, Node, NodeId, Settings};

/// Writes with one SDO request, which must succeed; what else is sent then.
fn write(device: &mut Device, request: &str) -> Vec<String> {
    let sent = device.ask(request);
    let (answers, others): (Vec<_>, Vec<_>) =
        sent.into_iter().partition(|frame| frame.starts_with("584"));
    assert_eq!(answers.len(), 1);
    assert!(answers[0].starts_with("584: 60"), "{answers:?}");
    others
}

/// Operational, with an inhibit time of 100 ms and 1800h on this transmission type; all that was due is sent.
fn operational(transmission_type: u8) -> Device {
    let mut device = Device::new();
    write(&mut device, "604: 23 00 18 01 84 01 00 80");
    write(&mut device, "604: 2B 00 18 03 E8 03 00 00");
    write(
        &mut device,
        &format!("604: 2F 00 18 02 {transmission_type:02X} 00 00 00"),
    );
    write(&mut device, "604: 23 00 18 01 84 01 00 00");
    device.send("000 [2] 01 04");
    device.pass(1000);
    device
}

/// Changes the first mapped value.
fn change(device: &mut Device, value: u8) {
    device.set_value(0x2005, 0, &[value, 0, 0, 0]);
    device.poll();
}

#[test]
fn writing_what_is_there_sends_nothing() {
    let mut device = operational(255);
    for request in [
        "604: 23 00 18 01 84 01 00 00",
        "604: 2F 00 18 02 FF 00 00 00",
        "604: 2F 00 18 02 FE 00 00 00",
    ] {
        assert!(write(&mut device, request).is_empty(), "{request}");
        assert!(device.pass(1000).is_empty(), "{request}");
    }
    assert_eq!(write(&mut device, "604: 23 00 18 01 84 01 00 80"), [""; 0]);
    assert_eq!(
        write(&mut device, "604: 23 00 18 01 84 01 00 00").len(),
        1,
        "a change does"
    );
}

#[test]
fn writing_what_is_there_leaves_the_inhibit_time() {
    let mut device = operational(255);
    change(&mut device, 1);
    assert_eq!(device.sent(), ["184: 01 00 00 00 00 00 00 00"]);
    device.pass(10);
    change(&mut device, 2);
    assert!(write(&mut device, "604: 23 00 18 01 84 01 00 00").is_empty());
    assert_eq!(
        device.pass(1000),
        [(90, "184: 02 00 00 00 00 00 00 00".to_owned())]
    );
}

#[test]
fn writing_what_is_there_leaves_the_event_timer() {
    let mut device = operational(255);
    write(&mut device, "604: 2B 00 18 05 C8 00 00 00");
    device.pass(150);
    assert!(write(&mut device, "604: 2B 00 18 05 C8 00 00 00").is_empty());
    assert_eq!(device.pass(60).first().map(|(moment, _)| *moment), Some(50));
}

#[test]
fn writing_what_is_there_leaves_an_event_that_waits_for_sync() {
    let mut device = operational(0);
    change(&mut device, 1);
    assert!(write(&mut device, "604: 23 00 18 01 84 01 00 00").is_empty());
    assert!(write(&mut device, "604: 2F 00 18 02 00 00 00 00").is_empty());
    assert_eq!(device.ask("080 [0]"), ["184: 01 00 00 00 00 00 00 00"]);
}

#[test]
fn writing_what_is_there_leaves_the_count_of_syncs() {
    let mut device = operational(3);
    for _ in 0..2 {
        assert!(device.ask("080 [0]").is_empty());
    }
    assert!(write(&mut device, "604: 2F 00 18 02 03 00 00 00").is_empty());
    assert_eq!(device.ask("080 [0]").len(), 1);
}

#[test]
fn another_setting_does_not_shorten_the_inhibit_time() {
    let mut device = operational(255);
    change(&mut device, 1);
    assert_eq!(device.sent().len(), 1);
    device.pass(10);
    // Switched off and on again: it is told anew, but not before its time.
    assert!(write(&mut device, "604: 23 00 18 01 84 01 00 80").is_empty());
    assert!(write(&mut device, "604: 23 00 18 01 84 01 00 00").is_empty());
    assert_eq!(
        device.pass(1000),
        [(90, "184: 01 00 00 00 00 00 00 00".to_owned())]
    );
    // And from a synchronous type.
    change(&mut device, 2);
    assert_eq!(device.sent().len(), 1);
    assert!(write(&mut device, "604: 2F 00 18 02 01 00 00 00").is_empty());
    assert!(write(&mut device, "604: 2F 00 18 02 FF 00 00 00").is_empty());
    assert_eq!(
        device.pass(1000),
        [(100, "184: 02 00 00 00 00 00 00 00".to_owned())]
    );
}

#[test]
fn a_new_inhibit_time_counts_from_the_last_transmission() {
    let mut device = operational(255);
    change(&mut device, 1);
    assert_eq!(device.sent().len(), 1);
    device.pass(10);
    write(&mut device, "604: 23 00 18 01 84 01 00 80");
    write(&mut device, "604: 2B 00 18 03 C8 00 00 00");
    assert!(write(&mut device, "604: 23 00 18 01 84 01 00 00").is_empty());
    assert_eq!(
        device.pass(1000).first().map(|(moment, _)| *moment),
        Some(10)
    );
    write(&mut device, "604: 23 00 18 01 84 01 00 80");
    write(&mut device, "604: 2B 00 18 03 E8 03 00 00");
    assert_eq!(write(&mut device, "604: 23 00 18 01 84 01 00 00").len(), 1);
    device.pass(10);
    write(&mut device, "604: 23 00 18 01 84 01 00 80");
    write(&mut device, "604: 2B 00 18 03 D0 07 00 00");
    assert!(write(&mut device, "604: 23 00 18 01 84 01 00 00").is_empty());
    assert_eq!(
        device.pass(1000).first().map(|(moment, _)| *moment),
        Some(190)
    );
}

#[test]
fn a_pdo_that_waits_is_dropped_with_operational() {
    let mut device = operational(255);
    change(&mut device, 1);
    device.send("000 [2] 80 04");
    assert!(device.sent().is_empty());
    device.set_value(0x2005, 0, &[2, 0, 0, 0]);
    device.now += Duration::millis(1000);
    device.send("000 [2] 01 04");
    assert_eq!(device.sent(), ["184: 02 00 00 00 00 00 00 00"]);
}

#[test]
fn an_event_that_waits_for_sync_counts_once_across_operational() {
    let mut device = operational(0);
    change(&mut device, 1);
    device.send("000 [2] 80 04");
    device.send("000 [2] 01 04");
    assert_eq!(device.ask("080 [0]"), ["184: 01 00 00 00 00 00 00 00"]);
    assert!(device.ask("080 [0]").is_empty());
    change(&mut device, 2);
    assert_eq!(device.ask("080 [0]"), ["184: 02 00 00 00 00 00 00 00"]);
}

/// An application that writes nothing back: transmit PDOs are looked at only when a receive PDO writes what they map.
#[test]
fn a_value_that_a_receive_pdo_brings_is_sent_by_the_transmit_pdo_that_maps_it() {
    let mut node = Node::new(
        Objects::new(),
        Settings {
            node_id: NodeId::new(4).unwrap(),
            ..Settings::default()
        },
    );
    let now = Instant::from_ticks(1_000_000);
    node.boot(Reset::Node, now, &mut ());
    let mut ask = |text: &str| -> Vec<String> {
        node.receive(&frame(text), now, &mut ());
        node.poll(now, &mut ());
        std::iter::from_fn(|| node.transmit(&mut ()))
            .map(|frame| show(&frame))
            .collect()
    };
    for request in [
        "604: 23 00 18 01 84 01 00 C0",
        "604: 2F 00 1A 00 00 00 00 00",
        "604: 23 00 1A 01 20 00 03 20",
        "604: 2F 00 1A 00 01 00 00 00",
        "604: 23 00 18 01 84 01 00 40",
    ] {
        let answers = ask(request);
        let answer = answers.last().unwrap();
        assert!(answer.starts_with("584: 60"), "{request}: {answer}");
    }
    assert_eq!(ask("000 [2] 01 04"), ["184 [4] 00 00 00 00"]);
    assert_eq!(ask("204: 01 02 03 04 00 00 00 00"), ["184 [4] 01 02 03 04"]);
    assert_eq!(ask("204: 01 02 03 04 09 00 00 00"), [""; 0], "not 2004h");
}

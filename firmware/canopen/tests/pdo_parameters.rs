//! What writing the parameters of a live transmit PDO changes, and what it leaves: frame by frame.

use crate::device::Device;
use canopen::Duration;

/// Writes with one SDO request, which must succeed; what else is sent then.
fn write(device: &mut Device, request: &str) -> Vec<String> {
    let sent = device.ask(request);
    let (answers, others): (Vec<_>, Vec<_>) =
        sent.into_iter().partition(|frame| frame.starts_with("584"));
    assert_eq!(answers.len(), 1);
    assert!(answers[0].starts_with("584#60"), "{answers:?}");
    others
}

/// Operational, with an inhibit time of 100 ms and 1800h on this transmission type; all that was due is sent.
fn operational(transmission_type: u8) -> Device {
    let mut device = Device::new();
    write(&mut device, "604#2300180184010080");
    write(&mut device, "604#2B001803E8030000");
    write(
        &mut device,
        &format!("604#2F001802{transmission_type:02X}000000"),
    );
    write(&mut device, "604#2300180184010000");
    device.send("000#0104");
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
        "604#2300180184010000",
        "604#2F001802FF000000",
        "604#2F001802FE000000",
    ] {
        assert!(write(&mut device, request).is_empty(), "{request}");
        assert!(device.pass(1000).is_empty(), "{request}");
    }
    assert_eq!(write(&mut device, "604#2300180184010080"), [""; 0]);
    assert_eq!(
        write(&mut device, "604#2300180184010000").len(),
        1,
        "a change does"
    );
}

#[test]
fn writing_what_is_there_leaves_the_inhibit_time() {
    let mut device = operational(255);
    change(&mut device, 1);
    assert_eq!(device.sent(), ["184#0100000000000000"]);
    device.pass(10);
    change(&mut device, 2);
    assert!(write(&mut device, "604#2300180184010000").is_empty());
    assert_eq!(device.pass(1000), [(90, "184#0200000000000000".to_owned())]);
}

#[test]
fn writing_what_is_there_leaves_the_event_timer() {
    let mut device = operational(255);
    write(&mut device, "604#2B001805C8000000");
    device.pass(150);
    assert!(write(&mut device, "604#2B001805C8000000").is_empty());
    assert_eq!(device.pass(60).first().map(|(moment, _)| *moment), Some(50));
}

#[test]
fn writing_what_is_there_leaves_an_event_that_waits_for_sync() {
    let mut device = operational(0);
    change(&mut device, 1);
    assert!(write(&mut device, "604#2300180184010000").is_empty());
    assert!(write(&mut device, "604#2F00180200000000").is_empty());
    assert_eq!(device.ask("080#"), ["184#0100000000000000"]);
}

#[test]
fn writing_what_is_there_leaves_the_count_of_syncs() {
    let mut device = operational(3);
    for _ in 0..2 {
        assert!(device.ask("080#").is_empty());
    }
    assert!(write(&mut device, "604#2F00180203000000").is_empty());
    assert_eq!(device.ask("080#").len(), 1);
}

#[test]
fn another_setting_does_not_shorten_the_inhibit_time() {
    let mut device = operational(255);
    change(&mut device, 1);
    assert_eq!(device.sent().len(), 1);
    device.pass(10);
    // Switched off and on again: it is told anew, but not before its time.
    assert!(write(&mut device, "604#2300180184010080").is_empty());
    assert!(write(&mut device, "604#2300180184010000").is_empty());
    assert_eq!(device.pass(1000), [(90, "184#0100000000000000".to_owned())]);
    // And from a synchronous type.
    change(&mut device, 2);
    assert_eq!(device.sent().len(), 1);
    assert!(write(&mut device, "604#2F00180201000000").is_empty());
    assert!(write(&mut device, "604#2F001802FF000000").is_empty());
    assert_eq!(
        device.pass(1000),
        [(100, "184#0200000000000000".to_owned())]
    );
}

#[test]
fn a_new_inhibit_time_counts_from_the_last_transmission() {
    let mut device = operational(255);
    change(&mut device, 1);
    assert_eq!(device.sent().len(), 1);
    device.pass(10);
    write(&mut device, "604#2300180184010080");
    write(&mut device, "604#2B001803C8000000");
    assert!(write(&mut device, "604#2300180184010000").is_empty());
    assert_eq!(
        device.pass(1000).first().map(|(moment, _)| *moment),
        Some(10)
    );
    write(&mut device, "604#2300180184010080");
    write(&mut device, "604#2B001803E8030000");
    assert_eq!(write(&mut device, "604#2300180184010000").len(), 1);
    device.pass(10);
    write(&mut device, "604#2300180184010080");
    write(&mut device, "604#2B001803D0070000");
    assert!(write(&mut device, "604#2300180184010000").is_empty());
    assert_eq!(
        device.pass(1000).first().map(|(moment, _)| *moment),
        Some(190)
    );
}

#[test]
fn a_pdo_that_waits_is_dropped_with_operational() {
    let mut device = operational(255);
    change(&mut device, 1);
    device.send("000#8004");
    assert!(device.sent().is_empty());
    device.set_value(0x2005, 0, &[2, 0, 0, 0]);
    device.now += Duration::millis(1000);
    device.send("000#0104");
    assert_eq!(device.sent(), ["184#0200000000000000"]);
}

#[test]
fn an_event_that_waits_for_sync_counts_once_across_operational() {
    let mut device = operational(0);
    change(&mut device, 1);
    device.send("000#8004");
    device.send("000#0104");
    assert_eq!(device.ask("080#"), ["184#0100000000000000"]);
    assert!(device.ask("080#").is_empty());
    change(&mut device, 2);
    assert_eq!(device.ask("080#"), ["184#0200000000000000"]);
}

//! Heartbeat producer: H01, H02 of the listed cases, and its place in the transmit queue.

use crate::device::Device;
use canopen::Duration;

fn heartbeats(times: &[u64], state: &str) -> Vec<crate::device::Sent> {
    times
        .iter()
        .map(|time| (*time, format!("704 [1] {state}")))
        .collect()
}

#[test]
fn h01_the_first_heartbeat_comes_at_once_and_then_every_period() {
    let mut device = Device::new();
    device.put("604: 2B 17 10 00 64 00 00 00");
    let sent = device.pass(350);
    assert_eq!(sent[0], (0, "584: 60 17 10 00 00 00 00 00".into()));
    assert_eq!(sent[1..], heartbeats(&[0, 100, 200, 300], "7F"));
}

#[test]
fn h01_a_new_period_starts_now_and_zero_ends_it() {
    let mut device = Device::new();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    device.pass(50);
    assert_eq!(
        device.ask("604: 2B 17 10 00 32 00 00 00"),
        ["584: 60 17 10 00 00 00 00 00", "704 [1] 7F"]
    );
    assert_eq!(device.pass(120), heartbeats(&[50, 100], "7F"));
    assert_eq!(
        device.ask("604: 2B 17 10 00 00 00 00 00"),
        ["584: 60 17 10 00 00 00 00 00"]
    );
    assert!(device.pass(1000).is_empty());
}

#[test]
fn h02_a_new_state_is_told_by_the_next_heartbeat() {
    let mut device = Device::new();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    assert!(device.pass(60).is_empty());
    device.send("000 [2] 02 04");
    assert_eq!(device.pass(100), heartbeats(&[40], "04"));
    device.send("000 [2] 80 04");
    assert_eq!(device.pass(100), heartbeats(&[40], "7F"));
}

#[test]
fn c03_a_heartbeat_that_cannot_leave_waits_once_and_tells_the_present_state() {
    let mut device = Device::new();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    for _ in 0..10 {
        device.now += Duration::from_ticks(100_000);
        device.poll();
    }
    device.send("000 [2] 02 04");
    assert_eq!(device.sent(), ["704 [1] 04"]);
}

#[test]
fn the_lowest_identifier_leaves_first() {
    let mut device = Device::operational();
    device.ask("604: 2B 17 10 00 64 00 00 00");
    device.now += Duration::from_ticks(100_000);
    device.put("7E5: 04 01 00 00 00 00 00 00");
    device.put("7E5: 5E 00 00 00 00 00 00 00");
    device.put("604: 40 00 10 00 00 00 00 00");
    device.set_value(0x2005, 0, &[9, 0, 0, 0]);
    device.poll();
    device.node.report(
        canopen::cia301::emergency::Emergency {
            code: 0x2310,
            register: 2,
            info: [0; 5],
        },
        device.now,
    );
    let identifiers: Vec<_> = device
        .sent()
        .iter()
        .map(|frame| frame[..3].to_owned())
        .collect();
    assert_eq!(identifiers, ["084", "184", "584", "704", "7E4"]);
}

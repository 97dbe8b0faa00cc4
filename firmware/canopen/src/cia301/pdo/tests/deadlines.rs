//! The deadlines of receive PDOs.

use super::device::{Device, mapped};

const U8: u32 = mapped(0x2000, 0, 8);

/// PDO 1, and PDO 2 with the identifier behind it, each with 50 ms.
fn operational(kind: u8) -> Device {
    let mut device = Device::new();
    for number in 0..2 {
        device.map(0x1400, number, kind, &[U8]).unwrap();
        device.write_u16(0x1400 + number, 5, 50).unwrap();
    }
    device.enter_operational();
    device
}

#[test]
fn p35_a_missed_deadline_is_told_once_and_ends_with_the_next_frame() {
    for kind in [255, 1] {
        let mut device = operational(kind);
        device.frame(0x204, &[1]);
        device.after(49);
        assert_eq!(device.reports(), []);
        device.after(1);
        assert_eq!(device.reports(), [(0x8250, 1, true)]);
        device.after(200);
        assert_eq!(device.reports(), []);
        device.frame(0x204, &[1]);
        assert_eq!(device.reports(), [(0x8250, 1, false)]);
        device.after(50);
        assert_eq!(device.reports(), [(0x8250, 1, true)]);
    }
}

#[test]
fn p35_each_frame_starts_it_anew() {
    let mut device = operational(255);
    for _ in 0..5 {
        device.frame(0x204, &[1]);
        device.after(49);
        assert_eq!(device.reports(), []);
    }
    device.after(1);
    assert_eq!(device.reports().len(), 1, "the last one ends");
}

#[test]
fn p35_nothing_is_expected_before_the_first_frame() {
    let mut device = operational(255);
    device.after(5000);
    assert_eq!(device.reports(), []);
    device.frame(0x204, &[1]);
    device.leave_operational();
    device.after(5000);
    assert_eq!(device.reports(), [], "nor outside of Operational");
    device.enter_operational();
    device.frame(0x204, &[1]);
    device.after(5000);
    assert_eq!(device.reports().len(), 1, "but behind the first frame");
}

#[test]
fn p35_two_pdos_have_a_deadline_each() {
    let mut device = operational(255);
    device.frame(0x204, &[1]);
    device.after(30);
    device.frame(0x304, &[1]);
    device.after(20);
    assert_eq!(device.reports(), [(0x8250, 1, true)]);
    device.after(10);
    device.frame(0x304, &[1]);
    device.frame(0x204, &[1]);
    assert_eq!(device.reports(), [(0x8250, 1, false)]);
}

#[test]
fn p35_a_short_frame_keeps_no_deadline() {
    let mut device = operational(255);
    device.frame(0x204, &[1]);
    device.after(40);
    device.frame(0x204, &[]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.after(10);
    assert_eq!(device.reports(), [(0x8250, 1, true)]);
    device.frame(0x204, &[]);
    assert_eq!(device.reports(), []);
    device.frame(0x204, &[1]);
    assert_eq!(device.reports(), [(0x8210, 1, false), (0x8250, 1, false)]);
}

#[test]
fn p35_a_new_deadline_counts_from_the_next_frame_on() {
    let mut device = operational(255);
    device.frame(0x204, &[1]);
    device.write_u16(0x1400, 5, 20).unwrap();
    device.after(100);
    assert_eq!(device.reports(), []);
    device.frame(0x204, &[1]);
    device.after(20);
    assert_eq!(device.reports(), [(0x8250, 1, true)]);
    device.write_u16(0x1400, 5, 0).unwrap();
    assert_eq!(device.reports(), [(0x8250, 1, false)]);
    device.frame(0x204, &[1]);
    device.after(5000);
    assert_eq!(device.reports(), []);
}

#[test]
fn p35_the_next_deadline_is_told() {
    let mut device = operational(255);
    let begin = device.now.ticks();
    assert!(device.frame(0x204, &[1]).has_news(), "a deadline has begun");
    assert_eq!(device.receive.poll(device.now).ticks(), begin + 50_000);
    assert_eq!(device.reports(), []);
    device.after(10);
    assert!(!device.frame(0x204, &[1]).has_news(), "it ran already");
    assert_eq!(device.receive.poll(device.now).ticks(), begin + 60_000);
}

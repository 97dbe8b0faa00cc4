//! Transmit PDOs at work, on virtual time.

use super::device::{Device, mapped};
use crate::agenda::Object;
use crate::time::{Instant, NEVER};

const U8: u32 = mapped(0x2000, 0, 8);
const U16: u32 = mapped(0x2001, 0, 16);

/// PDO 1 with this type; nothing waits any more after entering Operational.
fn operational(kind: u8, mapping: &[u32]) -> Device {
    let mut device = Device::new();
    device.map(0x1800, 0, kind, mapping).unwrap();
    device.enter_operational();
    device.sent();
    device
}

fn frame(bytes: &[u8]) -> std::vec::Vec<(u16, std::vec::Vec<u8>)> {
    std::vec![(0x184, bytes.to_vec())]
}

#[test]
fn n03_event_driven_pdos_are_sent_once_when_operational_is_entered() {
    let mut device = Device::new();
    for (number, kind) in [(0, 255), (1, 1), (2, 254), (3, 0)] {
        device.map(0x1800, number, kind, &[U8]).unwrap();
    }
    device.put(0x2000, &[5]);
    assert_eq!(device.after(0), []);
    device.enter_operational();
    assert_eq!(
        device.after(0),
        [(0x184, std::vec![5]), (0x384, std::vec![5])]
    );
    assert_eq!(device.after(1000), []);
}

#[test]
fn n15_a_repeated_start_sends_nothing() {
    let mut device = operational(255, &[U8]);
    device.enter_operational();
    assert_eq!(device.after(10), []);
    device.leave_operational();
    device.enter_operational();
    assert_eq!(device.after(10).len(), 1, "a start sends");
}

#[test]
fn n02_outside_of_operational_nothing_is_sent() {
    let mut device = operational(255, &[U8]);
    device.put(0x2000, &[1]);
    device.poll();
    device.leave_operational();
    assert_eq!(device.sent(), [], "what waited is dropped");
    device.put(0x2000, &[2]);
    device.sync();
    assert_eq!(device.after(5000), []);
    device.enter_operational();
    assert_eq!(device.sent(), frame(&[2]));
}

#[test]
fn p14_a_type_change_of_a_valid_pdo_works_from_then_on() {
    let mut device = operational(255, &[U8]);
    device.write_u8(0x1800, 2, 1).unwrap();
    device.put(0x2000, &[1]);
    assert_eq!(device.after(10), []);
    device.sync();
    assert_eq!(device.sent(), frame(&[1]));
}

#[test]
fn p24_a_frame_is_as_long_as_its_mapping() {
    let entries = [1, 2, 3, 4, 5, 6, 7, 8].map(|sub| mapped(0x200C, sub, 8));
    for length in 1..=8 {
        let mut device = Device::new();
        for kind in [255, 1] {
            device.map(0x1800, 0, kind, &entries[..length]).unwrap();
        }
        device.enter_operational();
        device.sync();
        assert_eq!(device.sent(), frame(&[0; 8][..length]));
    }
}

#[test]
fn p25_type_1_sends_the_content_of_each_sync() {
    let mut device = operational(1, &[U8]);
    for value in 1..=3 {
        device.put(0x2000, &[value]);
        device.sync();
        device.put(0x2000, &[0xFF]);
        assert_eq!(device.sent(), frame(&[value]));
    }
}

#[test]
fn p25_the_sample_is_older_than_what_the_same_sync_applies() {
    let mut device = operational(1, &[U8]);
    device.map(0x1400, 0, 1, &[U8]).unwrap();
    device.put(0x2000, &[1]);
    device.frame(0x204, &[2]);
    device.sync();
    assert_eq!(device.sent(), frame(&[1]));
    assert_eq!(device.u8(0x2000), 2);
    device.sync();
    assert_eq!(device.sent(), frame(&[2]));
}

#[test]
fn p26_type_3_sends_at_the_third_and_sixth_sync_in_operational() {
    let mut device = operational(3, &[U8]);
    let count = |device: &mut Device| {
        device.sync();
        device.sent().len()
    };
    let counts: std::vec::Vec<_> = (0..6).map(|_| count(&mut device)).collect();
    assert_eq!(counts, [0, 0, 1, 0, 0, 1]);
    count(&mut device);
    count(&mut device);
    device.leave_operational();
    count(&mut device);
    device.enter_operational();
    let counts: std::vec::Vec<_> = (0..3).map(|_| count(&mut device)).collect();
    assert_eq!(counts, [0, 0, 1], "counted anew");
}

#[test]
fn p27_type_0_needs_an_event_and_a_sync() {
    let mut device = operational(0, &[U8]);
    device.sync();
    assert_eq!(device.sent(), frame(&[0]), "Operational was entered");
    device.sync();
    assert_eq!(device.sent(), [], "no event");
    device.put(0x2000, &[1]);
    assert_eq!(device.after(10), [], "no SYNC");
    device.sync();
    assert_eq!(device.sent(), frame(&[1]));
    device.sync();
    assert_eq!(device.sent(), [], "no new event");
}

#[test]
fn p27_a_change_that_was_taken_back_is_an_event_too() {
    let mut device = operational(0, &[U8]);
    device.put(0x2000, &[1]);
    device.after(1);
    device.put(0x2000, &[0]);
    device.sync();
    assert_eq!(device.sent(), frame(&[0]));
}

#[test]
fn p27_what_was_sampled_at_the_sync_stays_as_it_was() {
    for kind in [0, 1] {
        let mut device = operational(kind, &[U8]);
        device.put(0x2000, &[1]);
        device.sync();
        device.put(0x2000, &[2]);
        assert_eq!(device.after(1), frame(&[1]), "type {kind}");
        device.sync();
        assert_eq!(device.sent(), frame(&[2]));
    }
}

#[test]
fn p29_the_inhibit_time_gathers_changes() {
    let mut device = Device::new();
    device.write_u16(0x1800, 3, 100).unwrap();
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    device.enter_operational();
    assert_eq!(device.after(0).len(), 1);
    device.after(1000);
    let start = device.now.ticks();
    device.put(0x2000, &[1]);
    assert_eq!(device.after(0), frame(&[1]), "the first at once");
    for value in 2..=4 {
        device.put(0x2000, &[value]);
        assert_eq!(device.after(1), []);
    }
    let deadline = device.poll();
    assert_eq!(deadline.ticks(), start + 10_000);
    device.put(0x2000, &[5]);
    assert_eq!(device.after(7), frame(&[5]), "the last value at 10 ms");
    assert_eq!(device.after(100), []);
}

#[test]
fn p29_the_inhibit_time_holds_across_a_short_visit_to_another_state() {
    let mut device = Device::new();
    device.write_u16(0x1800, 3, 100).unwrap();
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    device.enter_operational();
    assert_eq!(device.after(0).len(), 1);
    device.leave_operational();
    device.enter_operational();
    assert_eq!(device.after(9), []);
    assert_eq!(device.after(1).len(), 1);
}

#[test]
fn p30_the_event_timer_starts_anew_with_each_transmission() {
    let mut device = operational(255, &[U8]);
    device.write_u16(0x1800, 5, 100).unwrap();
    device.put(0x2000, &[1]);
    assert_eq!(device.after(60), frame(&[1]));
    let deadline = device.poll();
    assert_eq!(deadline.ticks(), device.now.ticks() + 100_000);
    assert_eq!(device.after(40), [], "not at 100 ms");
    assert_eq!(device.after(59), []);
    assert_eq!(device.after(1), frame(&[1]), "at 160 ms");
    assert_eq!(device.after(100), frame(&[1]));
}

#[test]
fn p31_the_inhibit_time_wins_over_the_event_timer() {
    let mut device = Device::new();
    device.write_u16(0x1800, 3, 100).unwrap();
    device.write_u16(0x1800, 5, 4).unwrap();
    device.map(0x1800, 0, 254, &[U8]).unwrap();
    device.enter_operational();
    device.sent();
    let sent: std::vec::Vec<_> = (1..=20).filter(|_| !device.after(1).is_empty()).collect();
    assert_eq!(sent, [10, 20]);
}

#[test]
fn p32_without_a_change_only_the_event_timer_sends() {
    let mut device = operational(255, &[U8]);
    device.put(0x2000, &[0]);
    assert_eq!(device.after(10_000), []);
    assert_eq!(device.poll(), NEVER);
    device.write_u16(0x1800, 5, 250).unwrap();
    assert_eq!(device.after(249), []);
    assert_eq!(device.after(1), frame(&[0]));
    device.write_u16(0x1800, 5, 0).unwrap();
    assert_eq!(device.after(10_000), []);
}

#[test]
fn p37_pdos_of_one_sync_leave_by_identifier() {
    let mut device = Device::new();
    for number in [2, 0, 3, 1] {
        device.map(0x1800, number, 1, &[U8]).unwrap();
    }
    device.enter_operational();
    device.sync();
    let identifiers: std::vec::Vec<_> = device
        .sent()
        .into_iter()
        .map(|(cob_id, _)| cob_id)
        .collect();
    assert_eq!(identifiers, [0x184, 0x284, 0x384, 0x484]);
}

#[test]
fn p37_newer_data_replaces_what_has_not_been_sent() {
    let mut device = operational(1, &[U8]);
    for value in 1..=3 {
        device.put(0x2000, &[value]);
        device.sync();
    }
    assert_eq!(device.sent(), frame(&[3]));
}

#[test]
fn c03_an_event_driven_pdo_that_waits_gets_the_newest_values() {
    let mut device = Device::new();
    device.write_u16(0x1800, 3, 100).unwrap();
    device.map(0x1800, 0, 255, &[U8]).unwrap();
    device.enter_operational();
    for value in 1..=3 {
        device.put(0x2000, &[value]);
        device.transmit.poll(
            &device.objects,
            Instant::from_ticks(device.now.ticks() + u64::from(value)),
            &mut device.agenda,
        );
    }
    assert_eq!(device.sent(), frame(&[3]), "even within the inhibit time");
    assert_eq!(device.after(100), [], "and they have been sent then");
}

#[test]
fn p40_the_new_mapping_is_sent_when_it_becomes_valid() {
    let mut device = operational(255, &[U8]);
    device.put(0x2001, &[1, 2]);
    device.map(0x1800, 0, 255, &[U16, U8]).unwrap();
    assert_eq!(device.after(0), frame(&[1, 2, 0]));
    assert_eq!(device.after(10), []);
}

#[test]
fn p40_an_old_frame_that_waits_is_not_sent_with_a_new_mapping() {
    let mut device = operational(1, &[U8]);
    device.sync();
    device.map(0x1800, 0, 1, &[U16]).unwrap();
    assert_eq!(device.sent(), []);
    device.sync();
    assert_eq!(device.sent(), frame(&[0, 0]));
}

#[test]
fn a_constant_can_be_sent() {
    let mut device = Device::new();
    device
        .map(
            0x1800,
            0,
            255,
            &[mapped(0x1018, 1, 32), mapped(0x1018, 2, 32)],
        )
        .unwrap();
    device.enter_operational();
    assert_eq!(
        device.sent(),
        frame(&[0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88])
    );
}

#[test]
fn a_pdo_that_waits_is_taken_once() {
    let mut device = Device::new();
    device.map(0x1800, 0, 1, &[U8]).unwrap();
    device.enter_operational();
    device.sync();
    assert_eq!(device.agenda.first(), Some(Object::pdo(0)));
    assert!(device.transmit.take(0, &mut device.agenda).is_some());
    assert_eq!(device.agenda.first(), None);
}

#[test]
fn values_are_looked_at_only_where_a_change_may_be_sent() {
    for (kind, is_watching) in [
        (255, true),
        (254, true),
        (0, true),
        (1, false),
        (252, false),
    ] {
        let mut device = operational(kind, &[U8]);
        assert_eq!(device.transmit.is_watching(), is_watching, "type {kind}");
        device.leave_operational();
        assert!(!device.transmit.is_watching(), "type {kind}");
    }
}

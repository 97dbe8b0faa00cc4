//! Multiplexed PDOs, both modes, both ways.

use std::vec::Vec;

use super::device::{Device, mapped};
use crate::cia301::pdo::NotSent;
use crate::cia301::sdo::AbortCode;

const SOURCE: u8 = 254;
const DESTINATION: u8 = 255;

/// A scanner list entry.
const fn scanned(index: u16, sub: u8, block: u8) -> u32 {
    (block as u32) << 24 | (index as u32) << 8 | sub as u32
}

/// A dispatcher list entry: who, the object there, the object here.
const fn dispatched(node_id: u8, theirs: (u16, u8), own: (u16, u8), block: u8) -> u64 {
    (block as u64) << 56
        | (own.0 as u64) << 40
        | (own.1 as u64) << 32
        | (theirs.0 as u64) << 16
        | (theirs.1 as u64) << 8
        | node_id as u64
}

fn receiver(count: u8) -> Device {
    let mut device = Device::new();
    device.multiplex(0x1400, 0, count).unwrap();
    device.enter_operational();
    device
}

fn sender(count: u8) -> Device {
    let mut device = Device::new();
    device.multiplex(0x1800, 0, count).unwrap();
    device
}

fn frame(bytes: [u8; 8]) -> Vec<(u16, Vec<u8>)> {
    std::vec![(0x184, bytes.to_vec())]
}

#[test]
fn a_value_for_this_node_or_for_all_is_written() {
    let mut device = receiver(DESTINATION);
    device.frame(0x204, &[0x84, 0x02, 0x20, 0, 1, 2, 3, 4]);
    assert_eq!(device.bytes(0x2002, 0), [1, 2, 3, 4]);
    device.frame(0x204, &[0x80, 0x0C, 0x20, 3, 9, 0xEE, 0xEE, 0xEE]);
    assert_eq!(device.bytes(0x200C, 3), [9], "as many bytes as it has");
    assert_eq!(device.recorder.written, [0x2002, 0x200C]);
    device.frame(0x204, &[0x85, 0x02, 0x20, 0, 5, 5, 5, 5]);
    device.frame(0x204, &[0x04, 0x02, 0x20, 0, 5, 5, 5, 5]);
    assert_eq!(device.bytes(0x2002, 0), [1, 2, 3, 4], "others are meant");
    assert_eq!(device.reports(), []);
}

#[test]
fn e09_an_object_that_cannot_be_written_is_reported_until_a_good_frame() {
    for (low, high, sub) in [
        (0xFF_u8, 0x5F_u8, 0_u8),
        (0x0C, 0x20, 99),
        (0x05, 0x20, 0),
        (0x04, 0x20, 0),
        (0x03, 0x20, 0),
        (0x05, 0x10, 0),
        (0x08, 0x20, 0),
    ] {
        let mut device = receiver(DESTINATION);
        device.frame(0x204, &[0x84, low, high, sub, 0, 0, 0, 0]);
        device.frame(0x204, &[0x84, low, high, sub, 0, 0, 0, 0]);
        assert_eq!(
            device.reports(),
            [(0x8230, 1, true)],
            "{high:02X}{low:02X}h"
        );
        assert!(device.recorder.written.is_empty());
        device.frame(0x204, &[0x84, 0x02, 0x20, 0, 1, 2, 3, 4]);
        assert_eq!(device.reports(), [(0x8230, 1, false)]);
    }
}

#[test]
fn e09_a_frame_for_another_node_ends_nothing() {
    let mut device = receiver(DESTINATION);
    device.frame(0x204, &[0x84, 0xFF, 0x5F, 0, 0, 0, 0, 0]);
    assert_eq!(device.reports(), [(0x8230, 1, true)]);
    device.frame(0x204, &[0x85, 0x02, 0x20, 0, 0, 0, 0, 0]);
    device.frame(0x204, &[0x04, 0x02, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(device.reports(), []);
    // Of other errors the length is enough to know.
    device.frame(0x204, &[0x85, 0x02, 0x20]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.frame(0x204, &[0x85, 0x02, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(device.reports(), [(0x8210, 1, false)]);
    device.frame(0x204, &[0x80, 0x02, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(device.reports(), [(0x8230, 1, false)]);
}

#[test]
fn m18_limits_and_the_application_have_their_word() {
    let mut device = receiver(DESTINATION);
    device.frame(0x204, &[0x84, 0x07, 0x20, 0, 11, 0, 0, 0]);
    device.frame(0x204, &[0x84, 0x00, 0x20, 0, 7, 0, 0, 0]);
    assert!(device.recorder.written.is_empty());
    assert_eq!(device.reports(), [], "the object is there");
    device.frame(0x204, &[0x84, 0x00, 0x20, 0, 6, 0, 0, 0]);
    assert_eq!(device.recorder.written, [0x2000]);
}

#[test]
fn p19_a_multiplexed_frame_has_eight_bytes() {
    let mut device = receiver(DESTINATION);
    device.frame(0x204, &[0x84, 0x02, 0x20, 0, 1]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    assert!(device.recorder.written.is_empty());
}

#[test]
fn the_dispatcher_list_says_what_stands_for_whose_object() {
    let mut device = receiver(SOURCE);
    let block = dispatched(5, (0x6000, 1), (0x200C, 3), 2);
    device.write(0x1FD0, 2, &block.to_le_bytes()).unwrap();
    for (node_id, sub, value) in [(5, 1, 10), (5, 2, 20), (5, 3, 30), (6, 1, 40), (5, 0, 50)] {
        device.frame(0x204, &[node_id, 0x00, 0x60, sub, value, 0, 0, 0]);
    }
    device.frame(0x204, &[0x85, 0x00, 0x60, 1, 60, 0, 0, 0]);
    assert_eq!(device.bytes(0x200C, 3), [10]);
    assert_eq!(device.bytes(0x200C, 4), [20]);
    assert_eq!(device.recorder.written, [0x200C, 0x200C]);
    assert_eq!(device.reports(), [], "objects of others are no errors");
}

#[test]
fn a_scan_sends_every_listed_object_once() {
    let mut device = sender(SOURCE);
    device.write_u32(0x1FA0, 1, scanned(0x200C, 2, 3)).unwrap();
    device.write_u32(0x1FA1, 1, scanned(0x2002, 0, 1)).unwrap();
    for sub in 1..=8 {
        device.write(0x200C, sub, &[sub]).unwrap();
    }
    device.put(0x2002, &[1, 2, 3, 4]);
    device.enter_operational();
    let mut frames = Vec::new();
    for _ in 0..20 {
        frames.extend(device.after(1));
    }
    let expected = [
        [4, 0x0C, 0x20, 2, 2, 0, 0, 0],
        [4, 0x0C, 0x20, 3, 3, 0, 0, 0],
        [4, 0x0C, 0x20, 4, 4, 0, 0, 0],
        [4, 0x02, 0x20, 0, 1, 2, 3, 4],
    ];
    assert_eq!(frames, expected.map(|bytes| (0x184, bytes.to_vec())));
}

#[test]
fn a_scan_leaves_out_what_a_block_does_not_have_and_goes_on() {
    let mut device = sender(SOURCE);
    device.write_u32(0x1FA0, 1, scanned(0x2010, 1, 4)).unwrap();
    device.write_u32(0x1FA1, 1, scanned(0x200C, 1, 1)).unwrap();
    device.write(0x2010, 1, &[7]).unwrap();
    device.enter_operational();
    let mut frames = Vec::new();
    for _ in 0..20 {
        frames.extend(device.after(1));
    }
    let expected = [
        [4, 0x10, 0x20, 1, 7, 0, 0, 0],
        [4, 0x10, 0x20, 4, 0, 0, 0, 0],
        [4, 0x0C, 0x20, 1, 0, 0, 0, 0],
    ];
    assert_eq!(frames, expected.map(|bytes| (0x184, bytes.to_vec())));
}

#[test]
fn p30_the_event_timer_begins_a_scan() {
    let mut device = sender(SOURCE);
    device.write_u32(0x1FA0, 1, scanned(0x2001, 0, 1)).unwrap();
    device.write_u16(0x1800, 5, 50).unwrap();
    device.put(0x2001, &[7, 8]);
    device.enter_operational();
    assert_eq!(device.after(0), frame([4, 0x01, 0x20, 0, 7, 8, 0, 0]));
    let mut times = Vec::new();
    for time in 1..=200 {
        if !device.after(1).is_empty() {
            times.push(time);
        }
    }
    assert_eq!(times, [50, 100, 150, 200]);
}

#[test]
fn p29_the_inhibit_time_holds_between_the_objects_of_a_scan() {
    let mut device = Device::new();
    device.write_u16(0x1800, 3, 100).unwrap();
    device.multiplex(0x1800, 0, SOURCE).unwrap();
    device.write_u32(0x1FA0, 1, scanned(0x200C, 1, 3)).unwrap();
    device.enter_operational();
    let mut times = Vec::new();
    for time in 0..100 {
        let sent = device.after(u64::from(time > 0)).len();
        assert!(sent <= 1);
        if sent > 0 {
            times.push(time);
        }
    }
    assert_eq!(times, [0, 10, 20]);
}

#[test]
fn the_application_announces_objects_of_the_list() {
    let mut device = sender(SOURCE);
    device.write_u32(0x1FA0, 2, scanned(0x200C, 1, 2)).unwrap();
    let announce = |device: &mut Device, index, sub| {
        let now = device.now;
        device
            .transmit
            .announce(index, sub, &device.objects, now, &mut device.agenda)
    };
    assert_eq!(
        announce(&mut device, 0x200C, 2),
        Err(NotSent::NoPdo),
        "not Operational"
    );
    device.enter_operational();
    for _ in 0..5 {
        device.after(1);
    }
    device.write(0x200C, 2, &[9]).unwrap();
    assert_eq!(announce(&mut device, 0x200C, 3), Err(NotSent::NotListed));
    assert_eq!(announce(&mut device, 0x5FFF, 0), Err(NotSent::NotListed));
    assert_eq!(announce(&mut device, 0x200C, 2), Ok(()));
    assert_eq!(announce(&mut device, 0x200C, 1), Err(NotSent::Busy));
    assert_eq!(device.sent(), frame([4, 0x0C, 0x20, 2, 9, 0, 0, 0]));
}

#[test]
fn the_application_sends_to_objects_of_others() {
    let mut device = sender(DESTINATION);
    device.enter_operational();
    assert_eq!(device.after(100), [], "nothing by itself");
    let now = device.now;
    let value = [1, 2, 3, 4];
    assert_eq!(
        device
            .transmit
            .send_to(128, 0x6000, 1, value, now, &mut device.agenda),
        Err(NotSent::NotListed)
    );
    assert_eq!(
        device
            .transmit
            .send_to(9, 0x6000, 1, value, now, &mut device.agenda),
        Ok(())
    );
    assert_eq!(
        device
            .transmit
            .send_to(9, 0x6000, 1, value, now, &mut device.agenda),
        Err(NotSent::Busy)
    );
    assert_eq!(device.sent(), frame([0x89, 0x00, 0x60, 1, 1, 2, 3, 4]));
    assert_eq!(
        device
            .transmit
            .announce(0x200C, 1, &device.objects, now, &mut device.agenda),
        Err(NotSent::NotListed)
    );
}

#[test]
fn p18_a_multiplexed_pdo_is_event_driven() {
    for communication in [0x1400, 0x1800] {
        for count in [SOURCE, DESTINATION] {
            let mut device = Device::new();
            device.write_u8(communication, 2, 1).unwrap();
            assert_eq!(
                device.multiplex(communication, 0, count),
                Err(AbortCode::InvalidValue)
            );
            device.write_u8(communication, 2, 254).unwrap();
            assert_eq!(device.multiplex(communication, 0, count), Ok(()));
            for kind in [0, 1, 240] {
                assert_eq!(
                    device.write_u8(communication, 2, kind),
                    Err(AbortCode::InvalidValue)
                );
            }
            assert_eq!(device.write_u8(communication, 2, 255), Ok(()));
        }
    }
}

#[test]
fn p07_list_entries_name_objects_that_can_be_mapped() {
    let mut device = Device::new();
    for (entry, expected) in [
        (scanned(0x200C, 1, 8), Ok(())),
        (scanned(0x5FFF, 0, 0), Ok(())),
        (scanned(0x200C, 1, 9), Err(AbortCode::NotMappable)),
        (scanned(0x2003, 0, 1), Err(AbortCode::NotMappable)),
        (scanned(0x2006, 0, 1), Err(AbortCode::NotMappable)),
        (scanned(0x5FFF, 0, 1), Err(AbortCode::NotMappable)),
        (scanned(0x200C, 255, 2), Err(AbortCode::NotMappable)),
    ] {
        assert_eq!(device.write_u32(0x1FA0, 1, entry), expected);
    }
    for (entry, expected) in [
        (dispatched(5, (1, 2), (0x200C, 1), 8), Ok(())),
        (dispatched(0, (0, 0), (0, 0), 0), Ok(())),
        (
            dispatched(128, (1, 2), (0x200C, 1), 1),
            Err(AbortCode::InvalidValue),
        ),
        (
            dispatched(5, (1, 2), (0x2005, 0), 1),
            Err(AbortCode::NotMappable),
        ),
    ] {
        assert_eq!(device.write(0x1FD0, 1, &entry.to_le_bytes()), expected);
    }
}

#[test]
fn p40_a_multiplexed_pdo_becomes_one_of_objects_again() {
    let mut device = receiver(DESTINATION);
    device
        .map(0x1400, 0, 255, &[mapped(0x2002, 0, 32)])
        .unwrap();
    device.frame(0x204, &[0x84, 0x01, 0x20, 0]);
    assert_eq!(device.bytes(0x2002, 0), [0x84, 0x01, 0x20, 0]);
}

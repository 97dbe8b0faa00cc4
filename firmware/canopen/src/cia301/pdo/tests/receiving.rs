//! Receive PDOs at work.

use super::device::{Device, mapped};
use super::objects::Objects;
use crate::cia301::pdo::Received;
use crate::od::find;
use crate::wire::Frame;

const U8: u32 = mapped(0x2000, 0, 8);
const U16: u32 = mapped(0x2001, 0, 16);
const U32: u32 = mapped(0x2002, 0, 32);
const LIMITED: u32 = mapped(0x2007, 0, 8);

fn operational(kind: u8, mapping: &[u32]) -> Device {
    let mut device = Device::new();
    device.map(0x1400, 0, kind, mapping).unwrap();
    device.enter_operational();
    device
}

#[test]
fn p10_dummies_are_skipped() {
    let mut device = operational(255, &[mapped(2, 0, 8), U8, mapped(6, 0, 16), U16]);
    assert_eq!(device.writes(0x204, &[0xAA, 1, 0xBB, 0xCC, 2, 3]), 2);
    assert_eq!(device.bytes(0x2000, 0), [1]);
    assert_eq!(device.bytes(0x2001, 0), [2, 3]);
    assert_eq!(device.recorder.written, [0x2000, 0x2001]);
}

#[test]
fn p19_a_short_frame_changes_nothing_and_is_reported_once() {
    let mut device = operational(255, &[U8, U16]);
    for bytes in [&[][..], &[1, 2], &[5]] {
        assert_ne!(device.frame(0x204, bytes), Received::NOTHING);
    }
    assert_eq!(device.bytes(0x2000, 0), [0]);
    assert_eq!(device.bytes(0x2001, 0), [0, 0]);
    assert!(device.recorder.written.is_empty());
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.frame(0x204, &[1]);
    assert_eq!(device.reports(), []);
}

#[test]
fn p20_of_a_long_frame_the_first_bytes_are_used() {
    let mut device = operational(255, &[U8]);
    device.frame(0x204, &[5, 6]);
    assert_eq!(device.u8(0x2000), 5);
    assert_eq!(device.reports(), [(0x8220, 1, true)]);
    device.frame(0x204, &[8, 6, 9]);
    assert_eq!(device.u8(0x2000), 8);
    assert_eq!(device.reports(), []);
}

#[test]
fn p21_a_good_frame_clears_a_length_error() {
    let mut device = operational(255, &[U16]);
    device.frame(0x204, &[1]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.frame(0x204, &[1, 2]);
    assert_eq!(device.reports(), [(0x8210, 1, false)]);
    device.frame(0x204, &[1]);
    device.frame(0x204, &[1, 2, 3]);
    assert_eq!(
        device.reports(),
        [(0x8220, 1, true)],
        "short came and went unseen, long stands"
    );
    device.frame(0x204, &[1]);
    assert_eq!(device.reports(), [(0x8220, 1, false), (0x8210, 1, true)]);
}

#[test]
fn p21_each_pdo_has_its_own_length_error() {
    let mut device = Device::new();
    device.map(0x1400, 0, 255, &[U16]).unwrap();
    device.map(0x1400, 2, 255, &[U16]).unwrap();
    device.enter_operational();
    device.frame(0x404, &[]);
    assert_eq!(device.reports(), [(0x8210, 3, true)]);
    device.frame(0x204, &[]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.frame(0x404, &[1, 2]);
    assert_eq!(device.reports(), [(0x8210, 3, false)]);
    device.frame(0x404, &[1, 2]);
    assert_eq!(device.reports(), []);
    device.frame(0x204, &[1, 2]);
    assert_eq!(device.reports(), [(0x8210, 1, false)]);
}

#[test]
fn p21_a_pdo_that_is_switched_off_takes_its_error_along() {
    let mut device = operational(255, &[U16]);
    device.frame(0x204, &[]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.write_u32(0x1400, 1, 0x8000_0204).unwrap();
    assert_eq!(device.reports(), [(0x8210, 1, false)]);
}

#[test]
fn p21_a_reset_ends_a_length_error() {
    let mut device = operational(255, &[U16]);
    device.frame(0x204, &[]);
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    device.receive.configure_all(&device.objects, 4);
    assert_eq!(device.reports(), [(0x8210, 1, false)]);
    assert_eq!(device.writes(0x204, &[1, 2]), 0, "Operational was left");
}

#[test]
fn p23_outside_of_operational_nothing_is_received() {
    let mut device = Device::new();
    device.map(0x1400, 0, 255, &[U8]).unwrap();
    assert_eq!(device.writes(0x204, &[5]), 0);
    device.enter_operational();
    device.leave_operational();
    assert_eq!(device.writes(0x204, &[5]), 0);
    assert_eq!(device.u8(0x2000), 0);
    assert_eq!(device.reports(), []);
}

#[test]
fn p24_bits_are_mapped_one_behind_the_other() {
    let mapping = [
        mapped(0x2009, 0, 1),
        mapped(0x2000, 0, 7),
        mapped(0x2001, 0, 16),
    ];
    let mut device = operational(255, &mapping);
    device.frame(0x204, &[0xAB, 0x34, 0x12]);
    assert_eq!(device.reports(), []);
    assert_eq!(device.u8(0x2009), 1);
    assert_eq!(device.u8(0x2000), 0x55);
    assert_eq!(device.bytes(0x2001, 0), [0x34, 0x12]);
    assert_eq!(device.recorder.written, [0x2009, 0x2000, 0x2001]);
}

#[test]
fn p24_64_bits_are_64_objects() {
    let mapping: std::vec::Vec<_> = (1..=64).map(|sub| mapped(0x200F, sub, 1)).collect();
    let mut device = Device::new();
    device.map(0x1400, 3, 255, &mapping).unwrap();
    device.enter_operational();
    assert_eq!(device.writes(0x504, &[0x01, 0, 0, 0, 0, 0, 0, 0x82]), 64);
    for sub in 1..=64 {
        let expected = u8::from([1, 58, 64].contains(&sub));
        assert_eq!(device.bytes(0x200F, sub), [expected], "sub-index {sub}");
    }
}

#[test]
fn p10_dummies_of_a_bit_are_skipped() {
    let dummy = mapped(1, 0, 1);
    let mut device = operational(255, &[dummy, dummy, mapped(0x2000, 0, 7), dummy, U8]);
    assert_eq!(device.writes(0x204, &[0b1111_1111, 0xFF]), 0, "three bytes");
    assert_eq!(device.reports(), [(0x8210, 1, true)]);
    assert_eq!(device.writes(0x204, &[0b0101_0110, 0b0000_0101, 0]), 2);
    assert_eq!(device.u8(0x2000), 1, "the last one mapped");
}

#[test]
fn p09_bits_that_are_not_mapped_become_zero() {
    let mut device = operational(255, &[mapped(0x2001, 0, 12)]);
    device.put(0x2001, &[0xFF, 0xFF]);
    device.frame(0x204, &[0x21, 0xF3]);
    assert_eq!(device.bytes(0x2001, 0), [0x21, 0x03]);
}

#[test]
fn p33_a_synchronous_pdo_applies_its_last_frame_at_sync() {
    for kind in [0, 1, 240] {
        let mut device = operational(kind, &[U8]);
        device.frame(0x204, &[1]);
        device.frame(0x204, &[2]);
        assert_eq!(device.u8(0x2000), 0);
        device.sync();
        assert_eq!(device.u8(0x2000), 2);
        assert_eq!(device.recorder.written, [0x2000], "applied once");
        device.sync();
        assert_eq!(device.recorder.written, [0x2000], "and not again");
    }
}

#[test]
fn p34_a_frame_behind_the_sync_waits_for_the_next_one() {
    let mut device = operational(1, &[U8]);
    device.frame(0x204, &[1]);
    device.sync();
    device.frame(0x204, &[2]);
    assert_eq!(device.u8(0x2000), 1);
    device.sync();
    assert_eq!(device.u8(0x2000), 2);
}

#[test]
fn p33_parameters_written_with_their_own_values_leave_a_frame_waiting() {
    let mut device = operational(1, &[U8]);
    device.frame(0x204, &[5]);
    device.write_u32(0x1400, 1, 0x204).unwrap();
    device.write_u8(0x1400, 2, 1).unwrap();
    device.write_u16(0x1400, 3, 7).unwrap();
    device.write_u16(0x1400, 5, 0).unwrap();
    device.sync();
    assert_eq!(device.u8(0x2000), 5);
}

#[test]
fn p36_behind_the_sync_window_synchronous_frames_are_discarded() {
    let mut device = operational(1, &[U8]);
    device.map(0x1400, 1, 255, &[U16]).unwrap();
    device.sync();
    device.frame(0x204, &[1]);
    device.receive.window_passed();
    device.frame(0x204, &[2]);
    assert_eq!(device.writes(0x304, &[3, 4]), 1, "no synchronous one");
    device.sync();
    assert_eq!(device.u8(0x2000), 1, "it came within the window");
    device.frame(0x204, &[5]);
    device.sync();
    assert_eq!(device.u8(0x2000), 5);
}

#[test]
fn p34_what_waits_is_dropped_when_operational_is_left() {
    let mut device = operational(1, &[U8]);
    device.frame(0x204, &[1]);
    device.leave_operational();
    device.enter_operational();
    device.sync();
    assert_eq!(device.u8(0x2000), 0);
}

#[test]
fn p34_a_short_frame_does_not_replace_one_that_waits() {
    let mut device = operational(1, &[U16]);
    device.frame(0x204, &[1, 2]);
    device.frame(0x204, &[9]);
    device.sync();
    assert_eq!(device.bytes(0x2001, 0), [1, 2]);
}

#[test]
fn p38_two_pdos_with_one_identifier_both_get_the_frame() {
    let mut device = Device::new();
    device.map(0x1400, 0, 255, &[U8]).unwrap();
    device.map(0x1400, 1, 255, &[mapped(0x200C, 1, 8)]).unwrap();
    device.write_u32(0x1400 + 1, 1, 0x8000_0204).unwrap();
    device.write_u32(0x1400 + 1, 1, 0x204).unwrap();
    device.enter_operational();
    device.frame(0x204, &[3]);
    assert_eq!(device.u8(0x2000), 3);
    assert_eq!(device.bytes(0x200C, 1), [3]);
    assert_eq!(device.writes(0x304, &[4]), 0);
}

#[test]
fn p40_the_next_frame_has_the_new_layout() {
    let mut device = operational(255, &[U8, U16]);
    device.frame(0x204, &[1, 2, 3]);
    device.map(0x1400, 0, 255, &[U32, U8]).unwrap();
    device.frame(0x204, &[4, 5, 6, 8, 9]);
    assert_eq!(device.bytes(0x2002, 0), [4, 5, 6, 8]);
    assert_eq!(device.u8(0x2000), 9);
    assert_eq!(device.bytes(0x2001, 0), [2, 3], "of the old layout");
}

#[test]
fn p40_a_frame_in_the_middle_of_the_procedure_is_nobodys() {
    let mut device = operational(255, &[U8]);
    device.write_u32(0x1400, 1, 0x8000_0204).unwrap();
    assert_eq!(device.writes(0x204, &[1]), 0);
    device.write_u8(0x1600, 0, 0).unwrap();
    assert_eq!(device.writes(0x204, &[1]), 0);
    device.write_u32(0x1400, 1, 0x204).unwrap();
    assert_eq!(device.writes(0x204, &[1]), 0, "it maps nothing yet");
    assert_eq!(device.u8(0x2000), 0);
}

#[test]
fn m18_a_refused_value_leaves_its_object_and_the_others_are_applied() {
    let mut device = operational(
        255,
        &[U8, U16, LIMITED, mapped(0x2009, 0, 8), mapped(0x200C, 1, 8)],
    );
    device.frame(0x204, &[7, 1, 2, 11, 2, 9]);
    assert_eq!(device.u8(0x2000), 0, "refused by the application");
    assert_eq!(device.bytes(0x2001, 0), [1, 2]);
    assert_eq!(device.u8(0x2007), 0, "above its limit");
    assert_eq!(device.u8(0x2009), 0, "no BOOLEAN");
    assert_eq!(device.bytes(0x200C, 1), [9]);
    assert_eq!(device.recorder.written, [0x2001, 0x200C]);
    assert_eq!(device.reports(), []);
    device.frame(0x204, &[8, 1, 2, 0xF6, 1, 9]);
    assert_eq!(
        (device.u8(0x2000), device.u8(0x2007), device.u8(0x2009)),
        (8, 0xF6, 1)
    );
}

#[test]
fn the_application_hears_of_each_object_in_the_order_of_the_mapping() {
    let mut device = operational(255, &[U32, U8, mapped(0x200A, 0, 16)]);
    device.frame(0x204, &[1, 2, 3, 4, 5, 6, 8]);
    assert_eq!(device.recorder.written, [0x2002, 0x2000, 0x200A]);
}

#[test]
fn transmit_pdos_have_to_look_only_if_a_place_of_theirs_is_written() {
    let mut device = operational(255, &[U16]);
    let entry = find::<Objects>(0x2001, 0).unwrap();
    let (start, end) = (entry.offset, entry.offset + entry.size());
    // Behind it, before it, its last byte, its first byte, and nothing.
    for (places, received) in [
        (end..end + 4, Received::KEPT),
        (0..start, Received::KEPT),
        (end - 1..end + 4, Received::APPLIED),
        (0..start + 1, Received::APPLIED),
        (0..0, Received::KEPT),
    ] {
        device.receive.watch(&places);
        let frame = Frame::data_frame(0x204, &[1, 2]);
        let objects = &mut device.objects;
        assert_eq!(
            device
                .receive
                .receive(0x204, &frame, device.now, || false, objects, &mut ()),
            received,
            "{places:?}"
        );
    }
}

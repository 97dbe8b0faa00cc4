//! What holds for every mapping and every frame.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;

use super::device::{Device, mapped};
use super::objects::Objects;
use crate::cia301::pdo::copy_plan::CopyPlan;
use crate::cia301::pdo::mapping::{Direction, Mapping, MappingEntry};
use crate::od::{Dictionary, find, put, value};

/// Objects that go both ways, without limits.
const MAPPABLE: [u32; 12] = [
    mapped(0x2000, 0, 8),
    mapped(0x2001, 0, 16),
    mapped(0x2002, 0, 32),
    mapped(0x2003, 0, 64),
    mapped(0x200A, 0, 16),
    mapped(0x200B, 0, 32),
    mapped(0x200C, 1, 8),
    mapped(0x200C, 2, 8),
    mapped(0x200C, 3, 8),
    mapped(0x200C, 4, 8),
    mapped(0x200C, 7, 8),
    mapped(0x200C, 8, 8),
];

/// Mappings of at most 64 bits with no object twice.
fn legal_mapping() -> impl Strategy<Value = Vec<u32>> {
    Just(MAPPABLE.to_vec()).prop_shuffle().prop_map(|entries| {
        let mut bits = 0;
        entries
            .into_iter()
            .take_while(|entry| {
                bits += entry & 0xFF;
                bits <= 64
            })
            .collect()
    })
}

fn resolve(entries: &[u32], direction: Direction) -> Mapping {
    let mut mapping = Mapping::new();
    for entry in entries {
        mapping
            .push(
                MappingEntry(*entry)
                    .resolve(Objects::TABLE, direction)
                    .unwrap(),
            )
            .unwrap();
    }
    mapping
}

proptest! {
    #[test]
    fn p41_what_is_packed_is_unpacked(entries in legal_mapping(), frame in any::<[u8; 8]>()) {
        let mapping = resolve(&entries, Direction::Receive);
        let plan = CopyPlan::of(&mapping);
        let mut objects = Objects::new();
        plan.unpack(&frame, objects.ram_mut());
        let used = usize::from(mapping.length);
        let packed = plan.pack(objects.ram(), &[]);
        prop_assert_eq!(&packed[..used], &frame[..used]);
        prop_assert!(packed[used..].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn p41_a_plan_does_what_entry_by_entry_does(entries in legal_mapping(), frame in any::<[u8; 8]>()) {
        let mapping = resolve(&entries, Direction::Receive);
        let (mut planned, mut plain) = (Objects::new(), Objects::new());
        CopyPlan::of(&mapping).unpack(&frame, planned.ram_mut());
        let mut position = 0;
        for entry in &entries {
            let [bits, sub, low, high] = entry.to_le_bytes();
            let length = usize::from(bits / 8);
            let entry = find::<Objects>(u16::from_le_bytes([low, high]), sub).unwrap();
            put(&mut plain, entry, &frame[position..position + length]);
            prop_assert_eq!(value(&planned, entry), &frame[position..position + length]);
            position += length;
        }
        prop_assert_eq!(planned.ram(), plain.ram());
    }

    /// Whatever is written and received, only the mapped objects change, and nothing panics.
    #[test]
    fn p19_frames_change_mapped_objects_only(
        entries in legal_mapping(),
        kind in prop::sample::select(&[0_u8, 1, 240, 254, 255][..]),
        frames in vec((0x200_u16..0x210, vec(any::<u8>(), 0..=8)), 0..20),
    ) {
        let mut device = Device::new();
        device.map(0x1400, 0, kind, &entries).unwrap();
        device.enter_operational();
        let before = device.objects.clone();
        for (cob_id, bytes) in &frames {
            let is_ours = *cob_id == 0x204;
            let written = device.writes(*cob_id, bytes);
            prop_assert!(written == 0 || is_ours);
            prop_assert!(device.reports().is_empty() || is_ours);
            device.sync();
        }
        for entry in Objects::TABLE.entries {
            let is_mapped = entries.iter().any(|mapped| mapped >> 8 == entry.key());
            if !is_mapped {
                prop_assert_eq!(value(&before, entry), value(&device.objects, entry));
            }
        }
    }

    /// Random parameters never make a PDO that is longer than a frame, whatever was accepted.
    #[test]
    fn p05_no_sequence_of_writes_breaks_a_pdo(
        writes in vec((0_u8..4, 0_u8..=8, prop::sample::select(&MAPPABLE[..]), any::<u8>()), 0..60),
    ) {
        let mut device = Device::new();
        device.enter_operational();
        for (what, sub, entry, number) in writes {
            let _ = match what {
                0 => device.write_u32(0x1A00, sub.max(1), entry),
                1 => device.write_u8(0x1A00, 0, sub),
                2 => device.write_u32(0x1800, 1, if number < 128 { 0x184 } else { 0x8000_0184 }),
                _ => device.write_u8(0x1800, 2, number),
            };
            device.sync();
            for (cob_id, bytes) in device.after(u64::from(number)) {
                prop_assert_eq!(cob_id, 0x184);
                prop_assert!((1..=8).contains(&bytes.len()));
            }
        }
    }
}

#[test]
fn neighbours_become_one_copy() {
    let eight: Vec<_> = (1..=8).map(|sub| mapped(0x200C, sub, 8)).collect();
    assert_eq!(
        CopyPlan::of(&resolve(&eight, Direction::Transmit)).step_count(),
        1
    );
    let backwards: Vec<_> = eight.iter().rev().copied().collect();
    assert_eq!(
        CopyPlan::of(&resolve(&backwards, Direction::Transmit)).step_count(),
        8
    );
    let gap = [mapped(0x200C, 1, 8), mapped(5, 0, 8), mapped(0x200C, 2, 8)];
    assert_eq!(
        CopyPlan::of(&resolve(&gap, Direction::Receive)).step_count(),
        2
    );
}

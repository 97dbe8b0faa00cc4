//! What holds for every mapping and every frame.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;

use super::device::{Device, Places, mapped};
use super::objects::Objects;
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

/// A part of an object with many: a mapping entry, and its length in bits.
fn any_part() -> impl Strategy<Value = u32> {
    prop_oneof![
        (0_u8..64).prop_map(|number| mapped(0x200F, number + 1, 1)),
        (1_u8..8).prop_map(|bits| mapped(0x2000, 0, bits)),
        (1_u8..16).prop_filter_map("no whole byte", |bits| {
            (bits != 8).then(|| mapped(0x2001, 0, bits))
        }),
        (33_u8..64).prop_filter_map("no whole byte", |bits| {
            (bits % 8 != 0).then(|| mapped(0x2003, 0, bits))
        }),
        Just(mapped(0x2009, 0, 8)),
        Just(mapped(0x200D, 0, 48)),
        Just(mapped(0x200E, 0, 24)),
        Just(mapped(0x2002, 0, 32)),
        Just(mapped(0x200A, 0, 16)),
    ]
}

/// Mappings of at most 64 bits at odd places, with no object twice.
fn odd_mapping() -> impl Strategy<Value = Vec<u32>> {
    vec(any_part(), 1..64).prop_map(|entries| {
        let mut mapping: Vec<u32> = Vec::new();
        let mut bits = 0;
        for entry in entries {
            let is_new = mapping.iter().all(|mapped| mapped >> 8 != entry >> 8);
            if is_new && bits + (entry & 0xFF) <= 64 {
                bits += entry & 0xFF;
                mapping.push(entry);
            }
        }
        mapping
    })
}

fn resolve(direction: Direction, entries: &[u32]) -> Mapping<Places> {
    let mut mapping: Mapping<Places> = Mapping::NOTHING;
    for entry in entries {
        let entry = MappingEntry(*entry);
        let object = entry.resolve(Objects::TABLE, u32::MAX, direction).unwrap();
        mapping
            .layout
            .push(
                &mut mapping.objects[..],
                Objects::TABLE,
                object,
                entry.bits(),
            )
            .unwrap();
    }
    mapping
}

/// A mapping with dummies between its objects.
fn with_dummies() -> impl Strategy<Value = Vec<u32>> {
    (
        odd_mapping(),
        vec((any::<prop::sample::Index>(), 0_usize..4), 0..8),
    )
        .prop_map(|(mut mapping, dummies)| {
            let dummy = [
                mapped(1, 0, 1),
                mapped(5, 0, 8),
                mapped(0x16, 0, 24),
                mapped(1, 0, 8),
            ];
            for (place, kind) in dummies {
                let bits: u32 = mapping.iter().map(|entry| entry & 0xFF).sum();
                if bits + (dummy[kind] & 0xFF) <= 64 {
                    mapping.insert(place.index(mapping.len() + 1), dummy[kind]);
                }
            }
            mapping
        })
}

proptest! {
    #[test]
    fn p41_what_is_unpacked_is_packed_again(
        entries in prop_oneof![legal_mapping(), odd_mapping()],
        frame in any::<[u8; 8]>(),
    ) {
        let mut objects = Objects::new();
        resolve(Direction::Receive, &entries).unpack(&frame, &mut objects);
        let packing = resolve(Direction::Transmit, &entries);
        let bits: u32 = entries.iter().map(|entry| entry & 0xFF).sum();
        prop_assert_eq!(u32::from(packing.length()), bits.div_ceil(8));
        let used = u64::MAX.checked_shr(64 - bits).unwrap_or(0);
        let expected = u64::from_le_bytes(frame) & used;
        let packed = packing.pack(&objects);
        prop_assert_eq!(u64::from_le_bytes(packed), expected);
    }

    /// A frame does what the model does, object by object: a shift and a mask of one number.
    #[test]
    fn p41_each_object_gets_its_bits_and_no_other(entries in with_dummies(), frame in any::<[u8; 8]>()) {
        let (mut planned, mut plain) = (Objects::new(), Objects::new());
        planned.ram_mut().fill(0xA5);
        plain.ram_mut().fill(0xA5);
        resolve(Direction::Receive, &entries).unpack(&frame, &mut planned);
        let mut rest = u128::from(u64::from_le_bytes(frame));
        for entry in &entries {
            let [bits, sub, low, high] = entry.to_le_bytes();
            let number = rest & ((1 << bits) - 1);
            rest >>= bits;
            if let Ok(entry) = find::<Objects>(u16::from_le_bytes([low, high]), sub) {
                let bytes = number.to_le_bytes();
                put(&mut plain, entry, &bytes[..usize::from(entry.size())]);
            }
        }
        prop_assert_eq!(planned.ram(), plain.ram());
    }

    /// Whatever is written and received, only the mapped objects change, and nothing panics.
    #[test]
    fn p19_frames_change_mapped_objects_only(
        entries in prop_oneof![legal_mapping(), odd_mapping()],
        kind in prop::sample::select(&[0_u8, 1, 240, 254, 255][..]),
        frames in vec((0x500_u16..0x510, vec(any::<u8>(), 0..=8)), 0..20),
    ) {
        let mut device = Device::new();
        device.map(0x1400, 3, kind, &entries).unwrap();
        device.enter_operational();
        let before = device.objects.clone();
        for (cob_id, bytes) in &frames {
            let is_ours = *cob_id == 0x504;
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
    let is_one_copy = |entries: &[u32]| resolve(Direction::Transmit, entries).is_one_copy();
    let eight: Vec<_> = (1..=8).map(|sub| mapped(0x200C, sub, 8)).collect();
    assert!(is_one_copy(&eight));
    let backwards: Vec<_> = eight.iter().rev().copied().collect();
    assert!(!is_one_copy(&backwards));
    let shifted = [
        mapped(0x2009, 0, 1),
        mapped(0x200C, 1, 8),
        mapped(0x200C, 2, 8),
    ];
    assert!(!is_one_copy(&shifted));
}

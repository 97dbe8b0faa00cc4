//! A small dictionary written by hand: each kind of value once.

mod finding;

use std::collections::{BTreeMap, BTreeSet};
use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::od::key;
use crate::od::{Count, StorageGroup, buckets};

const RW: u16 = Attributes::READ | Attributes::WRITE;
const CONST: u16 = Attributes::READ | Attributes::ROM | Attributes::CONSTANT;

const fn entry(
    index: u16,
    sub: u8,
    data_type: DataType,
    offset: u16,
    size: u16,
    attributes: u16,
) -> Entry {
    let detail = match data_type.is_variable() {
        true => size,
        false => Entry::NO_LIMITS,
    };
    Entry::new((index, sub), data_type, offset, detail, attributes)
}

const fn limited(entry: Entry, limits: u16) -> Entry {
    let key = (entry.index, entry.sub);
    Entry::new(
        key,
        entry.data_type,
        entry.offset,
        limits,
        entry.attributes.0,
    )
}

const ENTRIES: [Entry; 11] = [
    entry(0x1000, 0, DataType::Unsigned32, 0, 4, CONST),
    entry(0x1008, 0, DataType::VisibleString, 4, 5, CONST),
    entry(
        0x1014,
        0,
        DataType::Unsigned32,
        0,
        4,
        RW | Attributes::NODE_ID,
    ),
    entry(0x1018, 0, DataType::Unsigned8, 9, 1, CONST),
    entry(0x1018, 2, DataType::Unsigned32, 4, 4, Attributes::READ),
    limited(entry(0x2000, 0, DataType::Integer16, 8, 2, RW), 0),
    entry(0x2001, 0, DataType::VisibleString, 10, 6, RW),
    limited(entry(0x2002, 0, DataType::Unsigned64, 18, 8, RW), 2),
    entry(0x2003, 0, DataType::Boolean, 26, 1, RW),
    entry(0x6000, 0, DataType::Integer8, 27, 1, RW),
    entry(0xFFFF, 0xFF, DataType::Unsigned16, 28, 2, RW),
];

static TABLE: Table = Table {
    entries: &ENTRIES,
    buckets: &buckets::<16>(&ENTRIES),
    rom: &[0x92, 0x01, 0x04, 0x00, b'A', b'x', b'i', b's', b'4', 2],
    defaults: &[
        0x80, 0, 0, 0, // 1014h
        1, 2, 3, 4, // 1018h:2
        0xFE, 0xFF, // 2000h
        2, 0, b'h', b'i', 0, 0, 0, 0, // 2001h
        1, 0, 0, 0, 0, 0, 0, 0,    // 2002h
        1,    // 2003h
        0xFF, // 6000h
        0x34, 0x12, // FFFFh:FFh
    ],
    limits: &[
        0xF6, 0xFF, 0x2C, 0x01, // 2000h: -10 to 300
        1, 0, 0, 0, 0, 0, 0, 0, // 2002h: 1 to 2^64 - 1
        255, 255, 255, 255, 255, 255, 255, 255, //
        0, 0, 0, 0, 0, 0, 0, 0, // 0 to 2^63
        0, 0, 0, 0, 0, 0, 0, 0x80,
    ],
    storage: [0..4, 8..10, 18..31],
};

const EMPTY: Table = Table {
    entries: &[],
    buckets: &[],
    rom: &[],
    defaults: &[],
    limits: &[],
    storage: Table::NO_STORAGE,
};

#[derive(Clone, Debug, PartialEq)]
struct Small([u8; 30]);

impl Dictionary for Small {
    type Counts = Count<2, 2, 1, 0>;
    const TABLE: &'static Table = &TABLE;
    fn ram(&self) -> &[u8] {
        &self.0
    }
    fn ram_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }
}

fn small() -> Small {
    let mut dictionary = Small([0xEE; 30]);
    load_defaults(&mut dictionary, 4, 0..=u16::MAX);
    dictionary
}

fn at(index: u16, sub: u8) -> &'static Entry {
    find::<Small>(index, sub).unwrap()
}

#[test]
fn a_missing_object_and_a_missing_sub_index_have_their_abort_codes() {
    assert_eq!(AbortCode::from(AccessError::NoObject), AbortCode::NoObject);
    assert_eq!(
        AbortCode::from(AccessError::NoSubIndex),
        AbortCode::NoSubIndex
    );
}

#[test]
fn power_on_values_come_with_the_node_id() {
    let dictionary = small();
    assert_eq!(read_u32(&dictionary, 0x1014, 0), Some(0x84));
    assert_eq!(read_u32(&dictionary, 0x1018, 2), Some(0x0403_0201));
    assert_eq!(value(&dictionary, at(0x1000, 0)), [0x92, 0x01, 0x04, 0x00]);
    assert_eq!(value(&dictionary, at(0x1008, 0)), b"Axis4");
    assert_eq!(value(&dictionary, at(0x2001, 0)), b"hi");
    assert!(
        !dictionary.0.contains(&0xEE),
        "every byte has a power-on value"
    );
}

#[test]
fn reset_communication_leaves_the_other_objects() {
    let mut dictionary = small();
    assert!(write_u32(&mut dictionary, 0x1014, 0, 0x8000_0001));
    assert!(write_u16(&mut dictionary, 0x2000, 0, 7));
    assert!(write_u16(&mut dictionary, 0xFFFF, 0xFF, 8));
    load_defaults(&mut dictionary, 127, 0x1000..=0x1FFF);
    assert_eq!(read_u32(&dictionary, 0x1014, 0), Some(0xFF));
    assert_eq!(read_u16(&dictionary, 0x2000, 0), Some(7));
    assert_eq!(read_u16(&dictionary, 0xFFFF, 0xFF), Some(8));
}

#[test]
fn a_number_takes_exactly_its_length() {
    let mut dictionary = small();
    let before = dictionary.clone();
    assert_eq!(
        set(&mut dictionary, at(0x2000, 0), &[]),
        Err(AbortCode::LengthTooLow)
    );
    assert_eq!(
        set(&mut dictionary, at(0x2000, 0), &[1]),
        Err(AbortCode::LengthTooLow)
    );
    assert_eq!(
        set(&mut dictionary, at(0x2000, 0), &[1, 0, 0]),
        Err(AbortCode::LengthTooHigh)
    );
    assert_eq!(dictionary, before);
    assert_eq!(set(&mut dictionary, at(0x2000, 0), &[1, 0]), Ok(()));
    assert_eq!(value(&dictionary, at(0x2000, 0)), [1, 0]);
}

#[test]
fn limits_include_their_ends() {
    let mut dictionary = small();
    let entry = at(0x2000, 0);
    for (number, result) in [
        (-11i16, Err(AbortCode::ValueTooLow)),
        (-10, Ok(())),
        (300, Ok(())),
        (301, Err(AbortCode::ValueTooHigh)),
        (i16::MIN, Err(AbortCode::ValueTooLow)),
    ] {
        assert_eq!(
            set(&mut dictionary, entry, &number.to_le_bytes()),
            result,
            "{number}"
        );
    }
    assert_eq!(value(&dictionary, entry), 300i16.to_le_bytes());
}

#[test]
fn limits_of_an_unsigned64_reach_above_the_signed_numbers() {
    let entry = at(0x2002, 0);
    assert_eq!(check(&TABLE, entry, &u64::MAX.to_le_bytes()), Ok(()));
    assert_eq!(check(&TABLE, entry, &[0; 8]), Err(AbortCode::ValueTooLow));
    let bounded = limited(*entry, 10);
    let checked = |number: u64| check(&TABLE, &bounded, &number.to_le_bytes());
    assert_eq!(checked((1 << 63) + 1), Err(AbortCode::ValueTooHigh));
    assert_eq!(checked(1 << 63), Ok(()));
    assert_eq!(checked(0), Ok(()));
}

#[test]
fn a_boolean_is_0_or_1() {
    let entry = at(0x2003, 0);
    assert_eq!(check(&TABLE, entry, &[0]), Ok(()));
    assert_eq!(check(&TABLE, entry, &[1]), Ok(()));
    assert_eq!(check(&TABLE, entry, &[2]), Err(AbortCode::ValueTooHigh));
}

#[test]
fn a_string_grows_to_its_capacity_and_shrinks_to_nothing() {
    let mut dictionary = small();
    let entry = at(0x2001, 0);
    for text in [&b"abcdef"[..], b"", b"x"] {
        assert_eq!(set(&mut dictionary, entry, text), Ok(()));
        assert_eq!(value(&dictionary, entry), text);
    }
    assert_eq!(
        set(&mut dictionary, entry, b"abcdefg"),
        Err(AbortCode::LengthTooHigh)
    );
    assert_eq!(value(&dictionary, entry), b"x");
}

#[test]
fn what_lies_in_flash_stays() {
    let mut dictionary = small();
    let before = dictionary.clone();
    assert_eq!(
        set(&mut dictionary, at(0x1000, 0), &[0; 4]),
        Err(AbortCode::ReadOnly)
    );
    put(&mut dictionary, at(0x1000, 0), &[0; 4]);
    assert!(!write_u32(&mut dictionary, 0x1000, 0, 0));
    assert_eq!(read_u32(&dictionary, 0x1000, 0), Some(0x0004_0192));
    assert_eq!(dictionary, before);
}

#[test]
fn typed_reads_and_writes_need_the_right_length() {
    let mut dictionary = small();
    assert_eq!(read_u8(&dictionary, 0x2000, 0), None);
    assert_eq!(read_u32(&dictionary, 0x2000, 0), None);
    assert_eq!(
        read_u16(&dictionary, 0x2001, 0),
        None,
        "a string of two characters is no number"
    );
    assert_eq!(read_u8(&dictionary, 0x1001, 0), None);
    assert!(!write_u8(&mut dictionary, 0x2000, 0, 1));
    assert!(!write_u8(&mut dictionary, 0x2001, 0, 1));
    assert!(write_u8(&mut dictionary, 0x6000, 0, 9));
    assert_eq!(read_u8(&dictionary, 0x6000, 0), Some(9));
    assert_eq!(dictionary.0[28..], [0x34, 0x12], "its neighbour");
}

#[test]
fn numbers_are_sign_extended() {
    assert_eq!(number(at(0x6000, 0), &[0xFF]), Some(-1));
    assert_eq!(number(at(0x2000, 0), &[0x00, 0x80]), Some(-32768));
    assert_eq!(number(at(0x1014, 0), &[0xFF; 4]), Some(0xFFFF_FFFF));
    assert_eq!(number(at(0x2002, 0), &[0xFF; 8]), None);
    assert_eq!(number(at(0x2001, 0), b"hi"), None);
    assert_eq!(number(at(0x2000, 0), &[1]), None);
}

#[test]
fn an_entry_that_points_outside_reads_nothing_and_writes_nothing() {
    let mut dictionary = small();
    let before = dictionary.clone();
    for (data_type, attributes) in [
        (DataType::Unsigned32, RW),
        (DataType::VisibleString, RW),
        (DataType::Unsigned32, CONST),
    ] {
        let stray = entry(0x3000, 0, data_type, u16::MAX, u16::MAX, attributes);
        assert_eq!(value(&dictionary, &stray), []);
        put(&mut dictionary, &stray, &[1, 2, 3, 4]);
    }
    assert_eq!(dictionary, before);
}

proptest! {
    #[test]
    fn a_write_that_is_accepted_is_read_back_and_touches_nothing_else(
        which in 0..TABLE.entries.len(),
        bytes in prop::collection::vec(any::<u8>(), 0..10),
        start in any::<[u8; 30]>(),
    ) {
        let entry = &TABLE.entries[which];
        let mut dictionary = Small(start);
        let checked = check(&TABLE, entry, &bytes);
        let result = set(&mut dictionary, entry, &bytes);
        match result {
            Ok(()) => {
                prop_assert_eq!(checked, Ok(()));
                prop_assert_eq!(value(&dictionary, entry), &bytes[..]);
                let own = usize::from(entry.offset)..usize::from(entry.offset) + usize::from(room(entry));
                let outside: Vec<usize> = (0..30)
                    .filter(|at| !own.contains(at) && dictionary.0[*at] != start[*at])
                    .collect();
                prop_assert_eq!(outside, []);
            }
            Err(code) => {
                prop_assert!(checked == Err(code) || code == AbortCode::ReadOnly);
                prop_assert_eq!(dictionary.0, start);
            }
        }
    }

    #[test]
    fn a_number_is_the_one_that_was_written(signed in any::<i64>(), unsigned in any::<u64>()) {
        let of = |data_type, size| entry(0x2000, 0, data_type, 0, size, RW);
        let bytes = signed.to_le_bytes();
        prop_assert_eq!(number(&of(DataType::Integer8, 1), &bytes[..1]), Some(i64::from(signed as i8)));
        prop_assert_eq!(number(&of(DataType::Integer16, 2), &bytes[..2]), Some(i64::from(signed as i16)));
        prop_assert_eq!(number(&of(DataType::Integer32, 4), &bytes[..4]), Some(i64::from(signed as i32)));
        prop_assert_eq!(number(&of(DataType::Integer64, 8), &bytes), Some(signed));
        let bytes = unsigned.to_le_bytes();
        prop_assert_eq!(number(&of(DataType::Unsigned8, 1), &bytes[..1]), Some(i64::from(unsigned as u8)));
        prop_assert_eq!(number(&of(DataType::Unsigned16, 2), &bytes[..2]), Some(i64::from(unsigned as u16)));
        prop_assert_eq!(number(&of(DataType::Unsigned32, 4), &bytes[..4]), Some(i64::from(unsigned as u32)));
        prop_assert_eq!(number(&of(DataType::Unsigned64, 8), &bytes), i64::try_from(unsigned).ok());
    }

    #[test]
    fn any_entry_on_any_memory_is_safe_to_read(ram in any::<[u8; 30]>(), offset in any::<u16>(), size in any::<u16>()) {
        let dictionary = Small(ram);
        for data_type in [DataType::Unsigned32, DataType::OctetString] {
            let entry = entry(0x2000, 0, data_type, offset, size, RW);
            let length = value(&dictionary, &entry).len();
            prop_assert!(length <= 30 && length <= usize::from(entry.size()));
        }
    }

    #[test]
    fn limits_are_compared_as_numbers_of_every_length(low in any::<i64>(), high in any::<i64>(), number in any::<i64>()) {
        for (data_type, unused) in [
            (DataType::Integer8, 56),
            (DataType::Integer24, 40),
            (DataType::Integer32, 32),
            (DataType::Integer56, 8),
            (DataType::Integer64, 0),
        ] {
            let narrow = |number: i64| number >> unused;
            let unsigned = |number: i64| number.cast_unsigned() >> unused;
            let expected = |is_low: bool, is_high: bool| match (is_low, is_high) {
                (_, true) => Err(AbortCode::ValueTooHigh),
                (true, _) => Err(AbortCode::ValueTooLow),
                _ => Ok(()),
            };
            let signed = [low, high, number].map(narrow);
            let is_out = expected(signed[2] < signed[0], signed[2] > signed[1]);
            prop_assert_eq!(checked(data_type, signed), is_out);
            let is_out = expected(
                unsigned(number) < unsigned(low),
                unsigned(number) > unsigned(high),
            );
            let same_length = match data_type {
                DataType::Integer8 => DataType::Unsigned8,
                DataType::Integer24 => DataType::Unsigned24,
                DataType::Integer32 => DataType::Unsigned32,
                DataType::Integer56 => DataType::Unsigned56,
                _ => DataType::Unsigned64,
            };
            prop_assert_eq!(checked(same_length, signed), is_out);
        }
    }
}

/// What a write of the third number is answered between the first and the second one.
fn checked(data_type: DataType, [low, high, number]: [i64; 3]) -> Result<(), AbortCode> {
    let size = usize::from(data_type.size());
    let bytes = |number: i64| number.to_le_bytes()[..size].to_vec();
    let table = Table {
        limits: [bytes(low), bytes(high)].concat().leak(),
        ..EMPTY
    };
    let entry = limited(entry(0x2000, 0, data_type, 0, 0, RW), 0);
    check(&table, &entry, &bytes(number))
}

#[test]
fn a_storage_group_is_a_range_of_the_ram_block() {
    assert_eq!(TABLE.stored(StorageGroup::Communication), 0..4);
    assert_eq!(TABLE.stored(StorageGroup::Application), 8..10);
    // Beyond the block of 30 bytes: nothing, instead of a range that cannot be copied.
    assert_eq!(TABLE.stored(StorageGroup::Manufacturer), 0..0);
}

#[test]
fn a_value_with_the_application_is_not_in_memory() {
    let streamed = entry(0x2000, 0, DataType::Domain, 0, 8, RW | Attributes::STREAMED);
    let mut dictionary = small();
    let before = dictionary.clone();
    assert!(value(&dictionary, &streamed).is_empty());
    assert_eq!(
        set(&mut dictionary, &streamed, &[1; 4]),
        Err(AbortCode::ReadOnly)
    );
    put(&mut dictionary, &streamed, &[1; 8]);
    assert_eq!(dictionary, before);
}

#[test]
fn limits_of_real_numbers_are_in_the_order_of_the_numbers() {
    // -1.5 and 2.25.
    static LIMITS: [u8; 8] = [0, 0, 0xC0, 0xBF, 0, 0, 0x10, 0x40];
    let table = Table {
        limits: &LIMITS,
        ..EMPTY
    };
    let real = limited(entry(0x2000, 0, DataType::Real32, 0, 4, RW), 0);
    let checked = |value: f32| check(&table, &real, &value.to_le_bytes());
    for value in [-1.5, -1.0, -0.0, 0.0, 1.0, 2.25] {
        assert_eq!(checked(value), Ok(()), "{value}");
    }
    for value in [2.5, f32::INFINITY, f32::NAN] {
        assert_eq!(checked(value), Err(AbortCode::ValueTooHigh), "{value}");
    }
    for value in [-1.75, -1e30, f32::NEG_INFINITY, -f32::NAN] {
        assert_eq!(checked(value), Err(AbortCode::ValueTooLow), "{value}");
    }
}

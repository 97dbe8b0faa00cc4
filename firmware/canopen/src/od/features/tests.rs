use super::*;
use crate::od::DataType;

/// A table with entries of these indices, sub-indices and attributes; all values are at the same place.
const fn entry(index: u16, sub: u8, attributes: u16, limits: u16) -> Entry {
    Entry::new((index, sub), DataType::Unsigned8, 0, limits, attributes)
}

fn features(entries: &'static [Entry], default: &'static [u8]) -> Features {
    Features::of(&Table {
        entries,
        buckets: &[],
        rom: default,
        defaults: default,
        limits: &[0, 8, 0, 254],
        storage: Table::NO_STORAGE,
    })
}

#[test]
fn what_is_not_listed_is_not_there() {
    static ENTRIES: [Entry; 2] = [
        entry(0x1000, 0, Attributes::READ, Entry::NO_LIMITS),
        entry(0x1F9F, 0, Attributes::READ, Entry::NO_LIMITS),
    ];
    let found = features(&ENTRIES, &[0]);
    let expected = Features {
        sync: false,
        time: false,
        guarding: false,
        parameters: false,
        configuration_date: false,
        emergency_consumer: false,
        multiplexed_pdo: false,
        streams: false,
        ..Features::ALL
    };
    assert_eq!(found, expected);
}

#[test]
fn what_is_listed_is_there() {
    const READ: u16 = Attributes::READ;
    static ENTRIES: [Entry; 8] = [
        entry(0x1005, 0, READ, Entry::NO_LIMITS),
        entry(0x100D, 0, READ, Entry::NO_LIMITS),
        entry(0x1010, 0, READ, Entry::NO_LIMITS),
        entry(0x1012, 0, READ, Entry::NO_LIMITS),
        entry(0x1020, 0, READ, Entry::NO_LIMITS),
        entry(0x1028, 0, READ, Entry::NO_LIMITS),
        entry(0x1FFF, 0, READ, Entry::NO_LIMITS),
        entry(0x2000, 0, READ | Attributes::STREAMED, Entry::NO_LIMITS),
    ];
    assert_eq!(features(&ENTRIES, &[0]), Features::ALL);
}

#[test]
fn p51_a_mapping_is_multiplexed_if_its_sub_index_0_may_say_so() {
    const RW: u16 = Attributes::READ | Attributes::WRITE;
    const CONSTANT: u16 = Attributes::READ | Attributes::ROM;
    static COUNTED: [Entry; 1] = [entry(0x1600, 0, RW, 0)];
    static LIMITED: [Entry; 1] = [entry(0x1A00, 0, RW, 1)];
    static UNLIMITED: [Entry; 1] = [entry(0x17FF, 0, RW, Entry::NO_LIMITS)];
    static FIXED: [Entry; 1] = [entry(0x1BFF, 0, CONSTANT, Entry::NO_LIMITS)];
    static ELSEWHERE: [Entry; 2] = [
        entry(0x1600, 1, RW, Entry::NO_LIMITS),
        entry(0x1C00, 0, RW, Entry::NO_LIMITS),
    ];
    let is_multiplexed = |entries, default| features(entries, default).multiplexed_pdo;
    assert!(!is_multiplexed(&COUNTED, &[8]));
    assert!(is_multiplexed(&LIMITED, &[0]));
    assert!(is_multiplexed(&UNLIMITED, &[0]));
    assert!(!is_multiplexed(&FIXED, &[2]));
    assert!(is_multiplexed(&FIXED, &[255]));
    assert!(is_multiplexed(&COUNTED, &[254]), "by default");
    assert!(!is_multiplexed(&ELSEWHERE, &[0]));
}

//! Entries are found by index and sub-index, and nothing else is.

use super::*;

#[test]
fn every_entry_is_found_and_its_neighbours_are_not() {
    for entry in TABLE.entries {
        assert_eq!(find::<Small>(entry.index, entry.sub), Ok(entry));
    }
    assert_eq!(find::<Small>(0x1018, 1), Err(AccessError::NoSubIndex));
    assert_eq!(find::<Small>(0x1018, 3), Err(AccessError::NoSubIndex));
    assert_eq!(find::<Small>(0xFFFF, 0), Err(AccessError::NoSubIndex));
    assert_eq!(find::<Small>(0x0FFF, 255), Err(AccessError::NoObject));
    assert_eq!(find::<Small>(0x1001, 0), Err(AccessError::NoObject));
    assert_eq!(find::<Small>(0, 0), Err(AccessError::NoObject));
    assert_eq!(find::<Small>(0xFFFE, 0xFF), Err(AccessError::NoObject));
}

/// Objects of these indices with these sub-indices.
fn table_of(objects: &BTreeMap<u16, BTreeSet<u8>>) -> Table {
    let entries: Vec<_> = objects
        .iter()
        .flat_map(|(index, subs)| subs.iter().map(|sub| (*index, *sub)))
        .map(|(index, sub)| entry(index, sub, DataType::Unsigned8, 0, 1, CONST))
        .collect();
    // As few buckets as 60 objects may have: many are not in their own.
    let buckets = buckets::<64>(&entries);
    Table {
        entries: entries.leak(),
        buckets: buckets.to_vec().leak(),
        ..EMPTY
    }
}

proptest! {
    #[test]
    fn an_entry_is_found_if_it_is_there(
        objects in prop::collection::btree_map(1..=0x60_u16, prop::collection::btree_set(0..=6_u8, 1..5), 0..60),
        spread in prop::sample::select(vec![1, 2, 0x20, 0x100, 0x2A0]),
    ) {
        let objects: BTreeMap<_, _> = objects.into_iter().map(|(index, subs)| (index * spread, subs)).collect();
        let table = table_of(&objects);
        for index in (0..=0x61).map(|index| index * spread) {
            for sub in (0..=8).chain([255]) {
                let found = table.find(index, sub).map(|entry| table.entries[usize::from(table.position(entry).unwrap())].key());
                let expected = match objects.get(&index) {
                    None => Err(AccessError::NoObject),
                    Some(subs) if subs.contains(&sub) => Ok(key(index, sub)),
                    Some(_) => Err(AccessError::NoSubIndex),
                };
                prop_assert_eq!(found, expected);
            }
        }
    }
}

#[test]
fn most_objects_of_a_device_are_in_their_own_bucket() {
    // The communication profile of a drive, and what CiA 402 has.
    let ranges = [
        0x1000..=0x1029_u16,
        0x1400..=0x1403,
        0x1600..=0x1603,
        0x1800..=0x1803,
        0x1A00..=0x1A03,
        0x6040..=0x60FF,
    ];
    let entries: Vec<_> = ranges
        .into_iter()
        .flatten()
        .map(|index| entry(index, 0, DataType::Unsigned8, 0, 1, CONST))
        .collect();
    let buckets = buckets::<512>(&entries);
    let is_at_home = |(position, entry): &(usize, &Entry)| {
        usize::from(buckets[buckets::first(entry.index, 512)]) == *position
    };
    let at_home = entries.iter().enumerate().filter(is_at_home).count();
    assert!(
        at_home * 10 >= entries.len() * 8,
        "{at_home} of {}",
        entries.len()
    );
}

#[test]
#[should_panic = "too few buckets"]
fn as_many_objects_as_buckets_are_too_many() {
    buckets::<2>(&[
        entry(1, 0, DataType::Unsigned8, 0, 1, CONST),
        entry(2, 0, DataType::Unsigned8, 0, 1, CONST),
    ]);
}

#[test]
fn an_empty_table_holds_nothing() {
    assert_eq!(EMPTY.find(0x1000, 0), Err(AccessError::NoObject));
    assert!(EMPTY.range(0..=u16::MAX).is_empty());
}

//! Sets of parameters.

use std::collections::{HashMap, HashSet};
use std::vec;
use std::vec::Vec;

use canopen::cia301::parameters::{CHUNK, ParameterSet, ParameterSets, ParameterStore};
use canopen::node::StoreError;
use canopen::{BitRate, BitTiming, Configuration, NodeId};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::Flash;
use super::stored::{Contents, contents, load_set, save};
use crate::Store;

const SETTINGS: Configuration = Configuration {
    node_id: NodeId::new(33).unwrap(),
    bit_timing: BitTiming::Fixed(BitRate::Kbit250),
};

fn load<S: ParameterStore>(store: &mut S) -> Result<Contents, StoreError> {
    let mut contents = Contents::default();
    for (set, chunks) in ParameterSet::ALL.into_iter().zip(&mut contents) {
        *chunks = load_set(store, set)?;
    }
    Ok(contents)
}

#[test]
fn what_was_never_stored_is_empty() {
    let mut store = Flash::<1024, 4>::new(2).store();
    assert_eq!(load(&mut store), Ok(Contents::default()));
}

#[test]
fn what_was_committed_last_is_there_after_a_restart() {
    let mut store = Flash::<4096, 4>::new(2).store();
    save(&mut store, ParameterSets::ALL, &contents(1, 3, CHUNK)).unwrap();
    save(&mut store, ParameterSets::ALL, &contents(2, 2, 17)).unwrap();
    let mut store = store.release().store();
    assert_eq!(load(&mut store), Ok(contents(2, 2, 17)));
}

#[test]
fn a_set_is_stored_and_forgotten_without_the_others() {
    let mut store = Flash::<4096, 4>::new(2).store();
    save(&mut store, ParameterSets::ALL, &contents(1, 2, 40)).unwrap();
    let application = ParameterSets::of_sub_index(3).unwrap();
    save(&mut store, application, &contents(2, 1, 9)).unwrap();
    let [communication, _, manufacturer, _] = contents(1, 2, 40);
    let [_, newer, _, date] = contents(2, 1, 9);
    assert_eq!(
        load(&mut store).unwrap(),
        [communication.clone(), newer.clone(), manufacturer, date]
    );
    let forgotten = ParameterSets::of_sub_index(4).unwrap();
    save(&mut store, forgotten, &Contents::default()).unwrap();
    let none = Vec::new();
    assert_eq!(
        load(&mut store).unwrap(),
        [communication, newer, none.clone(), none]
    );
}

#[test]
fn what_was_not_committed_never_was() {
    let mut store = Flash::<4096, 4>::new(2).store();
    save(&mut store, ParameterSets::ALL, &contents(1, 2, 40)).unwrap();
    store.begin(ParameterSets::ALL).unwrap();
    ParameterStore::append(&mut store, ParameterSet::Application, &[9; 30]).unwrap();
    assert_eq!(load(&mut store), Ok(contents(1, 2, 40)));
    let mut store = store.release().store();
    assert_eq!(load(&mut store), Ok(contents(1, 2, 40)));
    assert_eq!(store.commit(), Err(StoreError::Medium), "nothing was begun");
}

#[test]
fn settings_and_parameters_leave_each_other_alone() {
    let mut store = Flash::<2048, 4>::new(2).store();
    store.save(&SETTINGS).unwrap();
    // Many times round the sectors.
    for seed in 0..50 {
        save(&mut store, ParameterSets::ALL, &contents(seed, 3, 50)).unwrap();
        assert_eq!(store.load(), Ok(Some(SETTINGS)));
    }
    for node_id in 1..=100 {
        let node_id = NodeId::new(node_id).unwrap();
        let settings = Configuration {
            node_id,
            ..SETTINGS
        };
        store.save(&settings).unwrap();
    }
    assert_eq!(load(&mut store), Ok(contents(49, 3, 50)));
}

#[test]
fn sets_that_are_too_long_are_refused_and_the_old_ones_stay() {
    let mut store = Flash::<1024, 4>::new(2).store();
    store.save(&SETTINGS).unwrap();
    let small = contents(1, 1, 60);
    save(&mut store, ParameterSets::ALL, &small).unwrap();
    for chunks in 2..40 {
        let large = contents(2, chunks, 100);
        let result = save(&mut store, ParameterSets::ALL, &large);
        assert_eq!(result, Err(StoreError::Medium), "{chunks} chunks");
        assert_eq!(load(&mut store), Ok(small.clone()));
        // The log has room for everything else.
        store.save(&SETTINGS).unwrap();
        save(&mut store, ParameterSets::ALL, &small).unwrap();
    }
    assert_eq!(store.load(), Ok(Some(SETTINGS)));
}

#[test]
fn the_longest_set_fits_the_sectors_of_the_board_twice() {
    let mut store = Flash::<16_384, 4>::new(2).store();
    let longest = |seed| {
        let mut contents = Contents::default();
        contents[0] = vec![vec![seed; CHUNK]; 29];
        contents
    };
    for seed in 0..8 {
        save(&mut store, ParameterSets::ALL, &longest(seed)).unwrap();
        assert_eq!(load(&mut store), Ok(longest(seed)));
    }
}

#[test]
fn flash_that_does_not_keep_a_byte_is_reported() {
    let mut flash = Flash::<1024, 4>::new(2);
    flash.deaf = true;
    let mut store = flash.store();
    assert_eq!(
        save(&mut store, ParameterSets::ALL, &contents(1, 1, 9)),
        Err(StoreError::Medium)
    );
}

#[test]
fn a_chunk_that_is_gone_makes_the_set_damaged_and_no_other() {
    let mut store = Flash::<1024, 4>::new(2).store();
    save(&mut store, ParameterSets::ALL, &contents(0x55, 1, 24)).unwrap();
    let mut flash = store.release();
    // The only chunk of the application set.
    let needle = [0x55 ^ 16; 24];
    let at = flash
        .bytes
        .windows(24)
        .position(|bytes| bytes == needle)
        .unwrap();
    flash.bytes[at] = 0;
    let mut store = flash.store();
    assert_eq!(
        store.open(ParameterSet::Application),
        Err(StoreError::Medium)
    );
    assert_eq!(store.open(ParameterSet::Communication), Ok(1));
    // The next save heals it.
    save(&mut store, ParameterSets::ALL, &contents(2, 1, 24)).unwrap();
    assert_eq!(load(&mut store), Ok(contents(2, 1, 24)));
}

#[test]
fn flash_full_of_anything_never_stops_the_next_save() {
    for byte in [0x00, 0x01, 0x55, 0xA5, 0xFE] {
        let mut store = Flash::<1024, 4>::filled(2, byte).store();
        save(&mut store, ParameterSets::ALL, &contents(1, 1, 24)).unwrap();
        assert_eq!(load(&mut store), Ok(contents(1, 1, 24)), "bytes {byte:02X}");
    }
}

/// A power cut at every byte of one save, and after each of them at every byte of the save after it.
fn cut_everywhere<const SECTOR: usize>(
    flash: &Flash<SECTOR, 4>,
    old: &Contents,
    sets: ParameterSets,
) {
    let [new, newest] = [contents(0x40, 1, 9), contents(0x80, 2, 5)];
    let after = |before: &Contents, saved: &Contents| {
        let mut after = before.clone();
        for (number, set) in ParameterSet::ALL.into_iter().enumerate() {
            if sets.has(set) {
                after[number].clone_from(&saved[number]);
            }
        }
        after
    };
    // Many cuts leave the same bytes: an erase that was cut begins again at the first byte.
    let mut known: HashMap<Vec<u8>, Contents> = HashMap::new();
    let mut found_in = |bytes: &Vec<u8>| {
        if let Some(found) = known.get(bytes) {
            return found.clone();
        }
        let mut store = flash.holding(bytes).store();
        let found = load(&mut store).unwrap();
        assert_eq!(store.load(), Ok(Some(SETTINGS)));
        known.insert(bytes.clone(), found.clone());
        found
    };

    let mut seen = [0; 2];
    let mut done = HashSet::new();
    let firsts = flash.cuts(|store| save(store, sets, &new).unwrap());
    for (cut, left) in firsts.iter().enumerate() {
        let found = found_in(left);
        let is_new = found == after(old, &new);
        assert!(is_new || found == *old, "cut at byte {cut}: {found:?}");
        assert!(is_new || cut + 1 < firsts.len(), "the whole save");
        seen[usize::from(is_new)] += 1;

        if !done.insert(left) {
            continue;
        }
        let then = flash
            .holding(left)
            .cuts(|store| save(store, sets, &newest).unwrap());
        let wanted = after(&found, &newest);
        for (cut_again, left) in then.iter().enumerate() {
            let then_found = found_in(left);
            let is_newest = then_found == wanted;
            assert!(
                is_newest || then_found == found,
                "cut at byte {cut}, then at {cut_again}: {then_found:?} where {found:?} was"
            );
            assert!(is_newest || cut_again + 1 < then.len(), "the whole save");
        }
    }
    assert!(seen.iter().all(|&count| count > 0), "old and new: {seen:?}");
}

/// Flash after so many saves of all sets.
fn filled(saves: u8) -> (Flash<512, 4>, Contents) {
    let mut store = Flash::new(2).store();
    store.save(&SETTINGS).unwrap();
    for seed in 0..saves {
        save(&mut store, ParameterSets::ALL, &contents(seed, 1, 8)).unwrap();
    }
    let last = saves.checked_sub(1);
    let found = last.map_or(Contents::default(), |seed| contents(seed, 1, 8));
    (store.release(), found)
}

#[test]
fn r06_a_power_cut_at_any_byte_leaves_the_old_sets_or_the_new_ones() {
    let (flash, old) = filled(1);
    cut_everywhere(&flash, &old, ParameterSets::ALL);
}

#[test]
fn r06_a_power_cut_in_the_save_of_one_group_leaves_the_others() {
    let (flash, old) = filled(1);
    cut_everywhere(&flash, &old, ParameterSets::of_sub_index(3).unwrap());
}

#[test]
fn r06_a_power_cut_is_survived_at_every_fill_of_the_sectors_including_those_that_erase() {
    let mut erases = 0;
    for saves in 0..7 {
        let (flash, old) = filled(saves);
        erases = flash.erases;
        cut_everywhere(&flash, &old, ParameterSets::ALL);
    }
    assert!(
        erases > 1,
        "the log went round its sectors: {erases} erases"
    );
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 64, ..ProptestConfig::default() }))]

    #[test]
    fn the_last_completed_save_wins_whatever_was_cut(
        steps in prop::collection::vec(
            (0..=255_u8, 1..=4_u8, 0..4_usize, 1..60_usize, prop::option::weighted(0.5, 1..900_usize)),
            1..20,
        )
    ) {
        let mut flash = Flash::<2048, 4>::new(2);
        let mut expected = Contents::default();
        for (seed, sub, chunks, length, budget) in steps {
            let sets = ParameterSets::of_sub_index(sub).unwrap();
            let wanted = contents(seed, chunks, length);
            let mut store = flash.powered(budget.unwrap_or(usize::MAX)).store();
            let result = save(&mut store, sets, &wanted);
            flash = store.release().powered(usize::MAX);
            let mut store = flash.store();
            let found = load(&mut store).unwrap();
            let mut new = expected.clone();
            for (number, set) in ParameterSet::ALL.into_iter().enumerate() {
                if sets.has(set) {
                    new[number].clone_from(&wanted[number]);
                }
            }
            prop_assert!(found == new || (result.is_err() && found == expected));
            expected = found;
            flash = store.release();
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 2048)) {
        let mut flash = Flash::<1024, 4>::new(2);
        flash.bytes = bytes;
        let mut store: Store<_> = flash.store();
        let _ = load(&mut store);
        let now = contents(1, 1, 12);
        prop_assert_eq!(save(&mut store, ParameterSets::ALL, &now), Ok(()));
        prop_assert_eq!(load(&mut store), Ok(now));
    }
}

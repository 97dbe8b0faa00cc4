//! The settings of the layer setting services.

use canopen::{BitRate, BitTiming, Configuration, NodeId};
use proptest::prelude::*;

use super::Flash;
use crate::directory::DIRECTORY;
use crate::log::Log;
use crate::{Error, Store};

fn settings(node_id: u8, bit_rate: BitRate) -> Configuration {
    Configuration {
        node_id: NodeId::new(node_id).unwrap(),
        bit_timing: BitTiming::Fixed(bit_rate),
    }
}

fn any_settings() -> impl Strategy<Value = Configuration> {
    let node_id = prop_oneof![1..=127u8, Just(255)];
    (node_id, prop::sample::select(&BitRate::ALL[..]))
        .prop_map(|(node_id, bit_rate)| settings(node_id, bit_rate))
}

#[test]
fn an_erased_flash_is_an_empty_store() {
    let mut store = Flash::<256, 4>::new(2).store();
    assert_eq!(store.load(), Ok(None));
}

#[test]
fn what_was_stored_last_is_loaded_after_a_restart() {
    let first = settings(5, BitRate::Kbit250);
    let last = settings(127, BitRate::Kbit10);
    let mut store = Flash::<256, 4>::new(2).store();
    store.save(&first).unwrap();
    store.save(&last).unwrap();
    assert_eq!(store.release().store().load(), Ok(Some(last)));
}

#[test]
fn an_unconfigured_node_id_is_kept_like_any_other() {
    let factory = Configuration::default();
    let mut store = Flash::<256, 4>::new(2).store();
    store.save(&settings(9, BitRate::Kbit125)).unwrap();
    store.save(&factory).unwrap();
    assert_eq!(store.load(), Ok(Some(factory)));
}

#[test]
fn the_order_to_find_the_bit_rate_is_kept() {
    let automatic = Configuration {
        bit_timing: BitTiming::Automatic,
        ..settings(9, BitRate::Kbit125)
    };
    let mut store = Flash::<256, 4>::new(2).store();
    store.save(&automatic).unwrap();
    assert_eq!(store.release().store().load(), Ok(Some(automatic)));
}

#[test]
fn the_same_settings_again_cost_no_flash() {
    let mut store = Flash::<256, 4>::new(2).store();
    store.save(&settings(9, BitRate::Kbit125)).unwrap();
    let before = store.release();
    let mut store = before.clone().store();
    store.save(&settings(9, BitRate::Kbit125)).unwrap();
    assert_eq!(store.release().bytes, before.bytes);
}

/// Cuts the power at every byte of one save and, for each state this leaves, at every byte of the next.
fn cut_everywhere<const SECTOR: usize, const WORD: usize>(
    mut flash: Flash<SECTOR, WORD>,
    old: Configuration,
) {
    let new = settings(42, BitRate::Kbit500);
    let newest = settings(43, BitRate::Kbit20);
    let mut store = flash.store();
    store.save(&old).unwrap();
    flash = store.release();

    let mut seen = [0usize; 2];
    for cut in 1.. {
        let mut store = flash.clone().powered(cut).store();
        let finished = store.save(&new).is_ok();
        let left = store.release();

        let mut store = left.clone().powered(usize::MAX).store();
        let found = store.load().unwrap().unwrap();
        assert!(found == old || found == new, "cut at byte {cut}: {found:?}");
        assert!(!finished || found == new);
        seen[usize::from(found == new)] += 1;

        for cut_again in 1.. {
            let mut store = left.clone().powered(cut_again).store();
            let finished_again = store.save(&newest).is_ok();
            let mut store = store.release().powered(usize::MAX).store();
            let then = store.load().unwrap().unwrap();
            assert!(
                then == found || then == newest,
                "cut at byte {cut}, then at {cut_again}: {then:?} where {found:?} was"
            );
            assert!(!finished_again || then == newest);
            if finished_again {
                break;
            }
        }
        if finished {
            break;
        }
    }
    assert!(seen.iter().all(|&count| count > 0), "old and new: {seen:?}");
}

#[test]
fn a_power_cut_at_any_byte_leaves_the_old_settings_or_the_new_ones() {
    cut_everywhere(Flash::<128, 4>::new(2), settings(7, BitRate::Kbit1000));
    cut_everywhere(Flash::<128, 1>::new(3), settings(7, BitRate::Kbit1000));
}

#[test]
fn a_power_cut_is_survived_at_every_fill_of_the_sectors_including_those_that_erase() {
    // Ten records and more fit a sector of 128 bytes with byte words: every phase of the log, twice round the sectors.
    let mut erases = 0;
    for records in 0..24 {
        let mut store = Flash::<128, 4>::new(2).store();
        for i in 0..records {
            store.save(&settings(100 + i, BitRate::Kbit50)).unwrap();
        }
        let flash = store.release();
        erases = flash.erases;
        cut_everywhere(flash, settings(7, BitRate::Kbit1000));
    }
    assert!(
        erases > 1,
        "the log went round its sectors: {erases} erases"
    );
}

#[test]
fn sectors_are_used_in_turn_for_as_long_as_one_likes() {
    let mut store = Flash::<128, 4>::new(2).store();
    for i in 0..10_000u32 {
        let now = settings((i % 127 + 1) as u8, BitRate::ALL[(i % 8) as usize]);
        store.save(&now).unwrap();
        assert_eq!(store.load(), Ok(Some(now)));
    }
    let flash = store.release();
    assert!(flash.erases < 2_000, "{} erases", flash.erases);
}

#[test]
fn flash_full_of_anything_never_stops_the_next_save() {
    for byte in [0x00, 0x01, 0x55, 0xA5, 0xFE] {
        let mut store = Flash::<256, 4>::filled(2, byte).store();
        // What it says of garbage may differ; it must say something and never make settings up.
        assert!(!matches!(store.load(), Ok(Some(_))), "bytes {byte:02X}");
        let now = settings(3, BitRate::Kbit800);
        store.save(&now).unwrap();
        assert_eq!(store.load(), Ok(Some(now)));
    }
}

#[test]
fn a_later_layout_is_told_from_none() {
    let mut store = Flash::<256, 4>::new(2).store();
    let mut flash = {
        store.save(&settings(3, BitRate::Kbit800)).unwrap();
        store.release()
    };
    // Append what a later firmware may have written: the same record, another layout, one byte more.
    append(
        &mut flash,
        20,
        &[2, 9, 0, 0, 0, 3, 1, 77, 1, 5, 0, 0, 0, 99],
    );
    let mut store = flash.store();
    assert_eq!(store.load(), Err(Error::Layout(2)));
    assert_eq!(store.serial_number(), Ok(Some(5)), "all layouts have it");
    store.save(&settings(4, BitRate::Kbit800)).unwrap();
    assert_eq!(store.load(), Ok(Some(settings(4, BitRate::Kbit800))));
    assert_eq!(store.serial_number(), Ok(Some(5)));
}

/// Puts a directory with these bytes at an address.
fn append(flash: &mut Flash<256, 4>, at: u32, bytes: &[u8]) {
    let mut log = Log::new(flash.clone(), &flash.range()).unwrap();
    log.append(at..256, DIRECTORY, bytes).unwrap().unwrap();
    *flash = log.flash;
}

#[test]
fn a_node_id_that_does_not_exist_is_not_believed() {
    let mut flash = Flash::<256, 4>::new(2);
    append(&mut flash, 0, &[1, 0, 0, 0, 0, 1, 200, 0]);
    assert_eq!(flash.store().load(), Err(Error::Content));
}

#[test]
fn flash_that_does_not_keep_a_byte_is_reported() {
    let mut flash = Flash::<256, 4>::new(2);
    flash.deaf = true;
    let mut store = flash.store();
    assert!(store.save(&settings(3, BitRate::Kbit800)).is_err());
    assert_eq!(store.load(), Ok(None));
}

#[test]
#[allow(
    clippy::reversed_empty_ranges,
    reason = "that such a range is refused is tested"
)]
fn a_range_that_is_not_whole_sectors_is_refused() {
    for range in [0..256, 0..300, 4..516, 256..256, 512..0, 256..1024] {
        let refused = Store::new(Flash::<256, 4>::new(3), range.clone()).unwrap_err();
        assert_eq!(refused, Error::Range, "{range:?}");
    }
    assert!(
        Store::new(Flash::<256, 64>::new(3), 0..768).is_err(),
        "words of 64 bytes"
    );
}

proptest! {
    #[test]
    fn the_last_completed_save_wins_whatever_was_cut(
        steps in prop::collection::vec((any_settings(), prop::option::weighted(0.5, 1..200usize)), 1..40)
    ) {
        let mut flash = Flash::<128, 4>::new(2);
        let mut expected = None;
        for (wanted, budget) in steps {
            let mut store = flash.powered(budget.unwrap_or(usize::MAX)).store();
            let finished = store.save(&wanted).is_ok();
            flash = store.release().powered(usize::MAX);
            let mut store = flash.store();
            let found = store.load().unwrap();
            prop_assert!(found == Some(wanted) || (!finished && found == expected));
            expected = found;
            flash = store.release();
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 512)) {
        let mut flash = Flash::<256, 4>::new(2);
        flash.bytes = bytes;
        let mut store = flash.store();
        let _ = store.load();
        let now = settings(3, BitRate::Kbit800);
        prop_assert_eq!(store.save(&now), Ok(()));
        prop_assert_eq!(store.load(), Ok(Some(now)));
    }
}

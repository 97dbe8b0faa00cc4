//! Somebody else has written into the flash.

use std::vec::Vec;

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::stored::{Filled, Stored, hold};

/// With any byte changed to any of these the store was full for ever, or began anew without what was intact.
#[test]
fn r08_one_byte_that_was_changed_costs_what_it_belongs_to_and_the_next_save_is_taken() {
    let before = Filled::new(9);
    let flash = &before.flash;
    let mut kept = 0;
    for at in 0..flash.bytes.len() {
        for byte in [0x00, 0x55, !flash.bytes[at]] {
            let mut bytes = flash.bytes.clone();
            bytes[at] = byte;
            kept += usize::from(Stored::found(&bytes) == *before.last());
            hold(&bytes, Some(&before), 1, usize::MAX);
        }
    }
    // The newest directory and what it names are a quarter of the flash.
    let all = 3 * flash.bytes.len();
    assert!((all / 2..all).contains(&kept), "{kept} of {all}");
}

#[test]
fn what_is_lost_is_told_until_it_is_stored_again() {
    let Filled { mut flash, states } = Filled::new(9);
    let end = flash.bytes.iter().rposition(|byte| *byte != 0xFF).unwrap();
    flash.bytes[end - 20..end].fill(0x5A);
    let found = Stored::found(&flash.bytes);
    assert_eq!(
        (&found.settings, &found.sets),
        (&None, &[None, None, None, None])
    );
    assert_eq!(found.serial_number, states[states.len() - 1].serial_number);
    let mut store = flash.store();
    store.save(&canopen::Configuration::default()).unwrap();
    let found = Stored::found(&store.release().bytes);
    assert_eq!(
        found.settings,
        Some(Some(canopen::Configuration::default()))
    );
    assert_eq!(found.sets, [None, None, None, None]);
}

/// An image that a power cut could have left as well is one: the store cannot tell them apart, and after a cut what was there before counts.
#[test]
fn r08_a_record_whose_mark_was_erased_is_one_that_a_power_cut_has_left() {
    let before = Filled::new(12);
    let [.., earlier, last] = before.states.as_slice() else {
        panic!("too few saves")
    };
    let mut bytes = before.flash.bytes.clone();
    let mark = bytes.iter().rposition(|byte| *byte != 0xFF).unwrap();
    bytes[mark] = 0xFF;
    assert_eq!(Stored::found(&bytes), *last, "it is whole without its mark");
    bytes[mark - 10] ^= 0x10;
    assert!(Stored::found(&bytes).is_left_of(earlier));
    hold(&bytes, Some(&before), 1, 7);
    bytes[mark] = 0x01;
    assert_eq!(Stored::found(&bytes).sets, [None, None, None, None]);
    hold(&bytes, Some(&before), 1, 7);
}

/// Found by the fuzz target `store`: changes in many places, among them a mark that was erased.
#[test]
fn r08_what_is_found_behind_an_erased_mark_is_of_one_moment() {
    let before = Filled::new(12);
    let mut bytes = before.flash.bytes.clone();
    for (at, byte) in [
        (0, 0xFF),
        (26, 0x2D),
        (28, 0x1C),
        (64, 0x60),
        (255, 0x60),
        (477, 0x00),
        (644, 0x84),
        (796, 0xDD),
        (827, 0xFF),
        (966, 0xCA),
        (1023, 0xFF),
    ] {
        bytes[at] = byte;
    }
    hold(&bytes, Some(&before), 0, 97);
}

fn any_damage() -> impl Strategy<Value = Vec<(usize, Vec<u8>)>> {
    let bytes = prop_oneof![
        prop::collection::vec(any::<u8>(), 1..80),
        (any::<u8>(), 1..200_usize).prop_map(|(byte, length)| std::vec![byte; length]),
    ];
    prop::collection::vec((0..1024_usize, bytes), 1..4)
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 64, ..ProptestConfig::default() }))]

    #[test]
    fn r08_bytes_that_were_changed_anywhere_cost_what_they_belong_to_and_the_next_save_is_taken(
        saves in 0..20_u8,
        damage in any_damage(),
        sub in 0..=4_u8,
    ) {
        let before = Filled::new(saves);
        let mut bytes = before.flash.bytes.clone();
        for (at, written) in damage {
            for (cell, byte) in bytes.iter_mut().skip(at).zip(written) {
                *cell = byte;
            }
        }
        hold(&bytes, Some(&before), sub, 7);
    }

    #[test]
    fn r08_a_flash_that_holds_anything_takes_a_save(
        bytes in prop::collection::vec(any::<u8>(), 1024),
        sub in 0..=4_u8,
    ) {
        hold(&bytes, None, sub, 7);
    }
}

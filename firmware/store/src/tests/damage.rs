//! Somebody else has written into the flash.

use std::vec::Vec;

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::stored::{Stored, filled, hold};

/// With any byte changed to any of these the store was full for ever, or began anew without what was intact.
#[test]
fn r08_one_byte_that_was_changed_costs_what_it_belongs_to_and_the_next_save_is_taken() {
    let (flash, before) = filled(9);
    let mut kept = 0;
    for at in 0..flash.bytes.len() {
        for byte in [0x00, 0x55, !flash.bytes[at]] {
            let mut bytes = flash.bytes.clone();
            bytes[at] = byte;
            kept += usize::from(Stored::found(&bytes) == before);
            hold(&bytes, Some(&before), 1, usize::MAX);
        }
    }
    // The newest directory and what it names are a quarter of the flash.
    let all = 3 * flash.bytes.len();
    assert!((all / 2..all).contains(&kept), "{kept} of {all}");
}

#[test]
fn what_is_lost_is_told_until_it_is_stored_again() {
    let (mut flash, before) = filled(9);
    let end = flash.bytes.iter().rposition(|byte| *byte != 0xFF).unwrap();
    flash.bytes[end - 20..end].fill(0x5A);
    let found = Stored::found(&flash.bytes);
    assert_eq!(
        (&found.settings, &found.sets),
        (&None, &[None, None, None, None])
    );
    assert_eq!(found.serial_number, before.serial_number);
    let mut store = flash.store();
    store.save(&canopen::Configuration::default()).unwrap();
    let found = Stored::found(&store.release().bytes);
    assert_eq!(
        found.settings,
        Some(Some(canopen::Configuration::default()))
    );
    assert_eq!(found.sets, [None, None, None, None]);
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
        let (flash, before) = filled(saves);
        let mut bytes = flash.bytes;
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

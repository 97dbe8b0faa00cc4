//! Switch state selective: four words in order.

use std::vec;
use std::vec::Vec;

use super::{IDENTITY, START, message, slave, word};
use crate::cia305::Slave;

/// The four words of switch state selective.
const ADDRESS: [(u8, u32); 4] = [
    (0x40, 0x1122_3344),
    (0x41, 0x5566_7788),
    (0x42, 0x99AA_BBCC),
    (0x43, 0xDDEE_FF01),
];

fn select(slave: &mut Slave, words: &[(u8, u32)]) -> Vec<Option<[u8; 8]>> {
    words
        .iter()
        .map(|(specifier, number)| slave.receive(&word(*specifier, *number), &IDENTITY, START))
        .collect()
}

#[test]
fn l08_all_four_words_in_order_select_a_slave() {
    let mut slave = slave(4);
    assert_eq!(
        select(&mut slave, &ADDRESS),
        [None, None, None, Some(message(&[0x44]))]
    );
    assert!(slave.is_in_configuration());
}

#[test]
fn l08_a_new_first_word_begins_anew() {
    let mut slave = slave(4);
    select(&mut slave, &ADDRESS[..2]);
    assert_eq!(select(&mut slave, &ADDRESS)[3], Some(message(&[0x44])));
}

#[test]
fn l09_one_wrong_word_selects_nobody() {
    for wrong in 0..4 {
        let mut slave = slave(4);
        let mut address = ADDRESS;
        address[wrong].1 ^= 1;
        assert_eq!(select(&mut slave, &address), [None; 4]);
        assert!(!slave.is_in_configuration());
    }
}

#[test]
fn l09_another_order_selects_nobody() {
    for (first, second) in [(0, 1), (1, 2), (2, 3), (0, 3)] {
        let mut slave = slave(4);
        let mut address = ADDRESS;
        address.swap(first, second);
        assert_eq!(select(&mut slave, &address), [None; 4]);
        assert_eq!(select(&mut slave, &ADDRESS[3..]), [None]);
    }
    assert_eq!(
        select(&mut slave(4), &ADDRESS).pop(),
        Some(Some(message(&[0x44])))
    );
}

#[test]
fn l09_another_service_between_the_words_selects_nobody() {
    let others = [
        message(&[0x04, 0x00]),
        message(&[0x4C]),
        message(&[0x5E]),
        message(&[0xEE]),
        word(0x46, 0x1122_3344),
    ];
    for other in others {
        for place in 1..4 {
            let mut slave = slave(4);
            assert_eq!(select(&mut slave, &ADDRESS[..place]), vec![None; place]);
            slave.receive(&other, &IDENTITY, START);
            assert_eq!(
                select(&mut slave, &ADDRESS[place..]),
                vec![None; 4 - place],
                "{other:02X?} at {place}"
            );
        }
    }
    let mut slave = slave(4);
    select(&mut slave, &ADDRESS[..2]);
    assert_eq!(
        select(&mut slave, &ADDRESS[2..]),
        [None, Some(message(&[0x44]))]
    );
}

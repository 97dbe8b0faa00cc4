//! Identifying slaves, and fastscan.

use std::vec;
use std::vec::Vec;

use super::{IDENTITY, START, fastscan, message, slave, word};
use crate::cia305::{Identity, Slave};

/// The six limits of identify remote slave.
type Range = [u32; 6];

fn identify(slave: &mut Slave, range: Range) -> Option<[u8; 8]> {
    let mut answer = None;
    for (specifier, limit) in (0x46..).zip(range) {
        assert_eq!(answer, None, "only the last one is answered");
        answer = slave.receive(&word(specifier, limit), &IDENTITY, START);
    }
    answer
}

const EXACT: Range = [
    0x1122_3344,
    0x5566_7788,
    0x99AA_BBCC,
    0x99AA_BBCC,
    0xDDEE_FF01,
    0xDDEE_FF01,
];

#[test]
fn l10_a_slave_within_the_range_answers_in_both_states() {
    for is_configuring in [0, 1] {
        let mut slave = slave(4);
        slave.ask(&[0x04, is_configuring]);
        assert_eq!(identify(&mut slave, EXACT), Some(message(&[0x4F])));
        let widest = [EXACT[0], EXACT[1], 0, u32::MAX, 0, u32::MAX];
        assert_eq!(identify(&mut slave, widest), Some(message(&[0x4F])));
        assert_eq!(slave.is_in_configuration(), is_configuring == 1);
    }
}

#[test]
fn l10_a_slave_outside_of_the_range_is_silent() {
    let misses = [
        (0, 1),
        (0, -1),
        (1, 1),
        (1, -1),
        (2, 1),
        (3, -1),
        (4, 1),
        (5, -1),
    ];
    for (position, step) in misses {
        let mut range = EXACT;
        range[position] = range[position].wrapping_add_signed(step);
        assert_eq!(identify(&mut slave(4), range), None, "limit {position}");
    }
    assert!(identify(&mut slave(4), EXACT).is_some());
}

#[test]
fn l10_the_limits_come_in_order_and_without_another_service() {
    for place in 1..6 {
        let mut slave = slave(4);
        for (specifier, limit) in (0x46..).zip(EXACT).take(place) {
            slave.receive(&word(specifier, limit), &IDENTITY, START);
        }
        slave.ask(&[0x4C]);
        for (specifier, limit) in (0x46..).zip(EXACT).skip(place) {
            assert_eq!(
                slave.receive(&word(specifier, limit), &IDENTITY, START),
                None
            );
        }
    }
    assert!(identify(&mut slave(4), EXACT).is_some());
}

#[test]
fn l11_a_slave_without_a_node_id_says_so_in_both_states() {
    for is_configuring in [0, 1] {
        let mut without = slave(255);
        without.ask(&[0x04, is_configuring]);
        assert_eq!(without.ask(&[0x4C]), Some(message(&[0x50])));
        let mut with = slave(4);
        with.ask(&[0x04, is_configuring]);
        assert_eq!(with.ask(&[0x4C]), None);
    }
}

#[test]
fn l12_fastscan_is_answered_without_a_node_id_only() {
    assert_eq!(
        slave(255).receive(&fastscan(0, 128, 0, 0), &IDENTITY, START),
        Some(message(&[0x4F]))
    );
    assert_eq!(
        slave(4).receive(&fastscan(0, 128, 0, 0), &IDENTITY, START),
        None
    );
}

#[test]
fn l12_a_slave_that_was_just_given_a_node_id_is_found_no_more() {
    let mut slave = slave(255);
    assert!(slave.ask(&[0x4C]).is_some());
    slave.ask(&[0x04, 0x01]);
    slave.ask(&[0x11, 0x0B]);
    slave.ask(&[0x04, 0x00]);
    assert_eq!(
        slave.receive(&fastscan(0, 128, 0, 0), &IDENTITY, START),
        None
    );
    assert_eq!(slave.ask(&[0x4C]), None);
}

/// Slaves on one bus, and the master's way to find one of them.
pub(super) struct Bus(pub(super) Vec<(Slave, Identity)>);

impl Bus {
    /// Whether anyone answers.
    fn ask(&mut self, request: &[u8; 8]) -> bool {
        let mut is_answered = false;
        for (slave, identity) in &mut self.0 {
            if let Some(answer) = slave.receive(request, identity, START) {
                assert_eq!(
                    answer,
                    message(&[0x4F]),
                    "this answer only, or they collide"
                );
                is_answered = true;
            }
        }
        is_answered
    }

    /// A scan: the four words that were found.
    pub(super) fn scan(&mut self) -> Option<[u32; 4]> {
        if !self.ask(&fastscan(0, 128, 0, 0)) {
            return None;
        }
        let mut words = [0; 4];
        for (sub, found) in (0..).zip(&mut words) {
            for bit in (0..32).rev() {
                if !self.ask(&fastscan(*found, bit, sub, sub)) {
                    *found |= 1 << bit;
                }
            }
            assert!(
                self.ask(&fastscan(*found, 0, sub, (sub + 1) & 3)),
                "word {sub} is confirmed"
            );
        }
        Some(words)
    }

    /// Which slaves are in the configuration state.
    fn in_configuration(&mut self) -> Vec<usize> {
        let slaves = self.0.iter_mut().enumerate();
        slaves
            .filter_map(|(number, (slave, _))| slave.is_in_configuration().then_some(number))
            .collect()
    }
}

#[test]
fn l13_a_scan_finds_every_bit_and_ends_in_the_configuration_state() {
    let mut bus = Bus(vec![(slave(255), IDENTITY)]);
    assert_eq!(
        bus.scan(),
        Some([0x1122_3344, 0x5566_7788, 0x99AA_BBCC, 0xDDEE_FF01])
    );
    assert_eq!(bus.in_configuration(), [0]);
}

#[test]
fn l13_a_right_bit_is_answered_and_a_wrong_one_is_not() {
    let mut slave = slave(255);
    slave.receive(&fastscan(0, 128, 0, 0), &IDENTITY, START);
    let word = IDENTITY.vendor_id;
    for bit in (0..32).rev() {
        let (right, wrong) = (
            fastscan(word, bit, 0, 0),
            fastscan(word ^ 1 << bit, bit, 0, 0),
        );
        assert_eq!(
            slave.receive(&right, &IDENTITY, START),
            Some(message(&[0x4F])),
            "bit {bit}"
        );
        assert_eq!(slave.receive(&wrong, &IDENTITY, START), None, "bit {bit}");
    }
}

#[test]
fn l13_only_the_serial_number_ends_a_scan() {
    let mut slave = slave(255);
    slave.receive(&fastscan(0, 128, 0, 0), &IDENTITY, START);
    slave.receive(&fastscan(IDENTITY.vendor_id, 0, 0, 1), &IDENTITY, START);
    slave.receive(&fastscan(IDENTITY.product_code, 0, 1, 0), &IDENTITY, START);
    assert!(!slave.is_in_configuration());
}

#[test]
fn l14_a_scan_that_is_not_at_this_word_is_not_answered() {
    let mut slave = slave(255);
    assert_eq!(
        slave.receive(&fastscan(0, 31, 0, 0), &IDENTITY, START),
        None,
        "no scan has begun"
    );
    slave.receive(&fastscan(0, 128, 0, 0), &IDENTITY, START);
    assert_eq!(
        slave.receive(&fastscan(IDENTITY.product_code, 0, 1, 1), &IDENTITY, START),
        None
    );
    assert_eq!(
        slave.receive(&fastscan(IDENTITY.vendor_id, 0, 0, 1), &IDENTITY, START),
        Some(message(&[0x4F]))
    );
    assert_eq!(
        slave.receive(&fastscan(IDENTITY.vendor_id, 0, 0, 0), &IDENTITY, START),
        None
    );
}

#[test]
fn l14_numbers_out_of_range_are_not_answered() {
    let mut slave = slave(255);
    slave.receive(&fastscan(0, 128, 0, 0), &IDENTITY, START);
    let word = IDENTITY.vendor_id;
    for bit_check in (32..128).chain(129..=255) {
        assert_eq!(
            slave.receive(&fastscan(word, bit_check, 0, 0), &IDENTITY, START),
            None,
            "bit check {bit_check}"
        );
    }
    for number in 4..=255 {
        assert_eq!(
            slave.receive(&fastscan(word, 0, number, 0), &IDENTITY, START),
            None,
            "sub {number}"
        );
        assert_eq!(
            slave.receive(&fastscan(word, 0, 0, number), &IDENTITY, START),
            None,
            "next {number}"
        );
    }
    assert_eq!(
        slave.receive(&fastscan(word, 0, 0, 1), &IDENTITY, START),
        Some(message(&[0x4F]))
    );
}

#[test]
fn l15_two_slaves_that_differ_in_one_bit_are_found_in_turn() {
    for bit in 0..32 {
        let twin = Identity {
            serial_number: IDENTITY.serial_number ^ 1 << bit,
            ..IDENTITY
        };
        let mut bus = Bus(vec![(slave(255), IDENTITY), (slave(255), twin)]);
        let mut found = Vec::new();
        for node_id in [11, 12] {
            found.push(bus.scan().unwrap()[3]);
            let selected = bus.in_configuration();
            assert_eq!(selected.len(), 1, "one at a time");
            let (slave, _) = &mut bus.0[selected[0]];
            assert_eq!(slave.ask(&[0x11, node_id]), Some(message(&[0x11, 0x00])));
            slave.ask(&[0x04, 0x00]);
            assert_eq!(slave.reset().get(), node_id);
        }
        found.sort_unstable();
        let mut expected = [IDENTITY.serial_number, twin.serial_number];
        expected.sort_unstable();
        assert_eq!(found, expected);
        assert_eq!(bus.scan(), None, "nobody is left");
    }
}

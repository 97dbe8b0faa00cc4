//! Many devices without a node-ID on one bus: a master finds one after the other by fastscan and numbers them.
//!
//! Their identities decide how a scan goes. Random ones part the devices in the first bits, nearly equal ones keep all of them
//! in the scan up to the last bit.

use std::collections::BTreeSet;

use canopen::{BitRate, Duration, NodeId};
use master::Master;
use master::bus::Station;
use master::bus::simulated::Bus;
use proptest::prelude::Rng as _;
use sim::Axis402;
use sim::drive::Setup;
use tests::late::Late;
use tests::plain_node::PlainNode;

use crate::seeded::generator;

const SECOND: Duration = Duration::from_ticks(1_000_000);

/// As many devices as there are node-IDs.
const ALL: usize = 127;

/// The four words of 1018h.
type Words = [u32; 4];

/// Puts devices with these identities on a bus, then finds and numbers them until none is left.
fn number_all<S: Station>(identities: &BTreeSet<Words>, make: impl Fn(Words) -> S) {
    let mut master = Master::new(Bus::new(BitRate::Kbit1000));
    for identity in identities {
        master.bus_mut().attach(make(*identity));
    }
    let mut found = Vec::new();
    while let Some(identity) = master.lss_fastscan().unwrap() {
        found.push(identity.words());
        let node = u8::try_from(found.len()).expect("no device is found twice");
        let node_id = NodeId::new(node).expect("there are no more devices than node-IDs");
        master.lss_configure_node_id(node_id).unwrap();
        master.lss_switch_to_waiting();
        master.expect_boot_up(node, SECOND).unwrap();
    }

    // A scan goes the way of the zeros, so the lowest number comes first.
    let expected: Vec<_> = identities.iter().copied().collect();
    assert_eq!(found, expected);
    for (node, identity) in (1..).zip(identities) {
        for (sub, word) in (1..).zip(identity) {
            assert_eq!(master.read::<u32>(node, 0x1018, sub), Ok(*word));
        }
    }
    // No two devices have ever sent different frames with one identifier.
    assert_eq!(master.bus().collisions(), 0);
}

/// Virtual drives with these serial numbers.
fn number_drives(serial_numbers: impl IntoIterator<Item = u32>) {
    // The other words are those of the data sheet.
    let identity = |serial_number| [0, 0x402, 0x1_0000, serial_number];
    let identities = serial_numbers.into_iter().map(identity).collect();
    number_all(&identities, |[.., serial_number]| {
        Axis402::new(Setup::unconfigured(serial_number))
    });
}

/// Different numbers that look random.
fn random_numbers(count: usize, seed: u8) -> BTreeSet<u32> {
    let mut random = generator(seed);
    let mut numbers = BTreeSet::new();
    while numbers.len() < count {
        numbers.insert(random.next_u32());
    }
    numbers
}

#[test]
fn one_drive_is_found_whatever_its_serial_number_is() {
    let corners = [0, 1, 0x8000_0000, 0x7FFF_FFFF, u32::MAX];
    for number in corners.into_iter().chain(random_numbers(5, 1)) {
        number_drives([number]);
    }
}

#[test]
fn two_drives_whose_serial_numbers_differ_in_one_bit_are_found_in_turn() {
    for bit in 0..32 {
        let number = generator(2 + bit).next_u32();
        number_drives([number, number ^ 1 << bit]);
    }
}

#[test]
fn two_drives_with_random_serial_numbers_are_found_in_turn() {
    for seed in 40..50 {
        number_drives(random_numbers(2, seed));
    }
}

#[test]
fn a_bus_full_of_devices_with_random_serial_numbers_is_numbered() {
    let identities = random_numbers(ALL, 3);
    let identities = identities.iter().map(|number| [0x21B, 7, 1, *number]);
    number_all(&identities.collect(), PlainNode::with_identity);
}

#[test]
fn a_bus_full_of_devices_with_serial_numbers_in_a_row_is_numbered() {
    let identities = (0x0040_1FC0..).map(|number| [0x21B, 7, 1, number]);
    number_all(&identities.take(ALL).collect(), PlainNode::with_identity);
}

#[test]
fn devices_that_differ_in_single_bits_of_any_word_are_told_apart() {
    let bits = (0..4).flat_map(|word| (0..32).step_by(3).map(move |bit| (word, bit)));
    let identities = bits.map(|(word, bit)| {
        let mut identity = [0x5555_AAAA, 0xAAAA_5555, 0, u32::MAX];
        identity[word] ^= 1 << bit;
        identity
    });
    number_all(&identities.collect(), PlainNode::with_identity);
}

#[test]
fn devices_that_answer_one_after_the_other_are_told_apart() {
    let serial_numbers = random_numbers(20, 4);
    let identities = serial_numbers.iter().map(|number| [0x21B, 7, 1, *number]);
    number_all(&identities.collect(), |identity| {
        let delay = Duration::from_ticks(u64::from(identity[3] % 9_000));
        Late::new(PlainNode::with_identity(identity), delay)
    });
}

//! What holds for every identity and every request.

use std::vec;

use proptest::collection::vec;
use proptest::prelude::*;

use super::finding::Bus;
use super::{IDENTITY, slave};
use crate::cia305::{Identity, LssEvent};
use crate::time::Instant;

fn any_identity() -> impl Strategy<Value = Identity> {
    any::<[u32; 4]>().prop_map(
        |[vendor_id, product_code, revision_number, serial_number]| Identity {
            vendor_id,
            product_code,
            revision_number,
            serial_number,
        },
    )
}

/// Requests that mean something more often than random bytes do.
fn any_request() -> impl Strategy<Value = [u8; 8]> {
    let specifiers = [
        0x04, 0x11, 0x13, 0x15, 0x17, 0x40, 0x41, 0x42, 0x43, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x4B,
        0x4C, 0x51, 0x5A, 0x5D, 0x5E,
    ];
    let word = prop::sample::select(vec![
        IDENTITY.vendor_id,
        IDENTITY.product_code,
        IDENTITY.revision_number,
        IDENTITY.serial_number,
        0,
        1,
    ]);
    let likely = (
        prop::sample::select(specifiers.to_vec()),
        word,
        any::<[u8; 3]>(),
    )
        .prop_map(|(specifier, word, rest)| {
            let [a, b, c, d] = word.to_le_bytes();
            let [bit_check, sub, next] = rest;
            [specifier, a, b, c, d, bit_check, sub & 3, next & 3]
        });
    prop_oneof![3 => likely, 1 => any::<[u8; 8]>()]
}

proptest! {
    #[test]
    fn l13_fastscan_finds_any_identity(identity in any_identity()) {
        let mut bus = Bus(vec![(slave(255), identity)]);
        prop_assert_eq!(bus.scan(), Some(identity.words()));
    }

    /// Of many slaves each scan finds exactly one that is there.
    #[test]
    fn l15_fastscan_finds_one_of_many(identities in vec(any_identity(), 1..6)) {
        let mut bus = Bus(identities.iter().map(|identity| (slave(255), *identity)).collect());
        let found = bus.scan().unwrap();
        prop_assert!(identities.iter().any(|identity| identity.words() == found));
    }

    #[test]
    fn l01_no_request_is_answered_in_the_wrong_state(
        number in prop::sample::select(&[4_u8, 255][..]),
        requests in vec((any_request(), 0_u64..100_000), 0..80),
    ) {
        let mut slave = slave(number);
        let mut now = Instant::from_ticks(0);
        for (request, step) in requests {
            now = Instant::from_ticks(now.ticks() + step);
            slave.poll(now);
            let is_silent = slave.is_silent(now);
            let was_configuring = !is_silent && slave.receive(&[0x5E, 0, 0, 0, 0, 0, 0, 0], &IDENTITY, now).is_some();
            let before = slave.settings();
            let answer = slave.receive(&request, &IDENTITY, now);
            prop_assert!(answer.is_none() || !is_silent);
            let is_for_configuration = matches!(request[0], 0x11 | 0x13 | 0x17 | 0x5A..=0x5E);
            let is_for_waiting = matches!(request[0], 0x43 | 0x51);
            if let Some(answer) = answer {
                prop_assert!(was_configuring || !is_for_configuration);
                prop_assert!(!was_configuring || !is_for_waiting);
                let expected = match request[0] {
                    0x43 => 0x44,
                    0x4B | 0x51 => 0x4F,
                    0x4C => 0x50,
                    other => other,
                };
                prop_assert_eq!(answer[0], expected);
            }
            prop_assert_eq!(slave.settings().node_id, before.node_id, "only a boot changes it");
            match slave.event() {
                Some(LssEvent::Boot) => {
                    prop_assert!(!before.node_id.is_configured());
                    prop_assert!(slave.reset().is_configured());
                }
                Some(LssEvent::Store(_)) => prop_assert!(slave.settings_stored(Ok(())).is_some()),
                _ => {}
            }
        }
    }
}

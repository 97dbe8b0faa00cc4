//! Block transfers on a bus that loses and doubles frames.

use std::collections::BTreeMap;

use canopen::Duration;
use master::bus::simulated::Interference;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::Bench;

/// What happens to each frame, over and over; mostly nothing.
fn interference() -> impl Strategy<Value = Vec<Interference>> {
    let one = |weight| {
        prop_oneof![
            weight => Just(Interference::None),
            1 => Just(Interference::Lose),
            1 => Just(Interference::Repeat),
            1 => Just(Interference::Destroy),
        ]
    };
    prop_oneof![
        prop::collection::vec(one(10), 1..40),
        prop::collection::vec(one(60), 50..300),
    ]
}

/// A device whose bus is disturbed once the transfer has begun or from the first frame on.
fn disturbed(pattern: Vec<Interference>, peaceful: usize, old: &[u8]) -> Bench {
    let mut bench = Bench::node(4);
    bench.device().firmware.domains = BTreeMap::from([(0x2002, old.to_vec())]);
    let mut frames = 0;
    bench.interfere(move |_| {
        frames += 1;
        if frames <= peaceful {
            Interference::None
        } else {
            pattern[(frames - peaceful - 1) % pattern.len()]
        }
    });
    bench
}

/// After the trouble the device serves as if nothing had been.
fn is_well(bench: &mut Bench) {
    bench.leave_in_peace();
    bench.drain(3_000);
    bench.send("604: 40 18 10 01");
    bench.expect("584: 43 18 10 01 44 33 22 11");
}

fn value() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        4 => prop::collection::vec(any::<u8>(), 0..40),
        2 => prop::collection::vec(any::<u8>(), 0..2_000),
        1 => prop::sample::select(vec![7_usize, 14, 882, 889, 890, 896, 1_778, 1_779]).prop_flat_map(|length| prop::collection::vec(any::<u8>(), length)),
    ]
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 96, ..ProptestConfig::default() }))]

    #[test]
    fn a_disturbed_download_is_whole_or_aborted(value in value(), pattern in interference(), peaceful in 0..6_usize) {
        let old = b"what was there before";
        let mut bench = disturbed(pattern, peaceful, old);
        let begun = bench.now();
        let result = bench.block_download(0x2002, 0, &value);
        prop_assert!(bench.now() - begun < Duration::secs(120), "a transfer ends");
        is_well(&mut bench);
        let stored = &bench.device().firmware.domains[&0x2002];
        if result.is_ok() {
            prop_assert_eq!(stored, &value);
        } else {
            // The answer to the end may be what was lost.
            prop_assert!(stored == old || *stored == value, "a mixture");
        }
        prop_assert_eq!(bench.block_download(0x2002, 0, &value), Ok(()));
        prop_assert_eq!(&bench.device().firmware.domains[&0x2002], &value);
    }

    #[test]
    fn a_disturbed_upload_is_whole_or_aborted(value in value(), block_size in 1..=127_u8, pattern in interference(), peaceful in 0..6_usize) {
        let mut bench = disturbed(pattern, peaceful, &value);
        let begun = bench.now();
        let result = bench.block_upload(0x2002, 0, block_size);
        prop_assert!(bench.now() - begun < Duration::secs(600), "a transfer ends");
        if let Ok(read) = result {
            prop_assert_eq!(&read, &value);
        }
        is_well(&mut bench);
        prop_assert_eq!(bench.block_upload(0x2002, 0, block_size), Ok(value));
    }
}

//! Any frames, settings and time on the whole drive; the fuzz target `drive` looks for those that break something.

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::any_drive::check;

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn c06_whatever_comes_the_drive_comes_to_rest(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        check(&bytes);
    }
}

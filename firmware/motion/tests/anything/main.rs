//! Orders made of any bytes, here of random ones; the fuzz targets `plan` and `axis` look for those that break something.

mod axis;
mod bytes;
mod plan;

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn no_plan_breaks_a_rule(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        plan::check(&bytes);
    }

    #[test]
    fn the_pulses_of_an_axis_add_up(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        axis::check(&bytes);
    }
}

//! From anywhere, at any speed, home is the same.

use proptest::prelude::*;

use super::results::{RESULTS, shift};
use super::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn d25_home_does_not_depend_on_start_speed_or_latency(
        which in 0usize..28,
        start in -51_000i64..=51_000,
        hysteresis in 0i32..=50,
        latency in 0usize..4,
        search in 2_000i64..60_000,
        acceleration in 200_000i64..2_000_000,
        is_direct: bool,
        returns: bool,
    ) {
        let (code, home, result) = RESULTS[which];
        let track = Track { hysteresis: hysteresis.into(), latency, ..Track::with_home(home) };
        let mut bench = Bench::new(track, start);
        bench.search_speed = search;
        bench.acceleration = acceleration;
        let found = bench.home(code, Settings { is_direct, returns, ..Settings::default() });
        prop_assert_eq!(found, Ok(result + shift(code, hysteresis)));
        if returns {
            prop_assert_eq!(bench.position, i64::from(found.unwrap()));
        }
    }

    #[test]
    fn any_halt_changes_nothing(
        which in 0usize..28,
        start in -51_000i64..=51_000,
        halts in prop::collection::vec((1u32..3_000, 1u32..200), 0..6),
    ) {
        let (code, home, result) = RESULTS[which];
        let mut bench = Bench::new(Track::with_home(home), start);
        let mut homing = bench.begin(code, Settings::default()).unwrap();
        let mut halts = halts.into_iter();
        let mut next = halts.next();
        let found = loop {
            prop_assert!(bench.ticks < 200_000);
            bench.halt = match &mut next {
                Some((0, 0)) => { next = halts.next(); false }
                Some((0, length)) => { *length -= 1; true }
                Some((wait, _)) => { *wait -= 1; false }
                None => false,
            };
            match bench.tick(&mut homing) {
                Outcome::UnderWay(_) => {}
                Outcome::Attained(home) => break home,
                Outcome::Failed(failure) => panic!("{failure}"),
            }
        };
        prop_assert_eq!(found, result);
    }
}

//! From anywhere, at any speed, home is the same.

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::results::{RESULTS, WINDOW, shift};
use super::*;

/// Where home is behind an index track, if the edge of the switch is there.
fn behind(code: i8, edge: i64, (first, distance): (i64, i64)) -> i64 {
    match code {
        // To the negative end, the other half to the positive one.
        2 | 3 | 6 | 7 | 9 | 12 | 14 => edge - distance + (first - edge).rem_euclid(distance),
        1..=14 => edge + distance - (edge - first).rem_euclid(distance),
        _ => edge,
    }
}

#[test]
fn d25_an_edge_passed_before_a_stop_is_not_taken_for_one_on_the_way_back() {
    // 20 steps to stop, and 60 until an edge is noticed: so the motor is behind a window of 70 before it knows of its far end.
    for code in [7, 8, 9, 10, 11, 12, 13, 14, 23, 24, 25, 26, 27, 28, 29, 30] {
        for start in [0, 20_000] {
            let track = Track {
                latency: 60,
                ..Track::with_home((11_000, 11_070))
            };
            let mut bench = Bench::new(track, start);
            bench.search_speed = 1_000;
            bench.zero_speed = 500;
            bench.acceleration = 25_000;
            let right = matches!(code, 9..=12 | 25..=28);
            let edge = if right { 11_070 } else { 11_000 };
            let home = behind(code, edge, (400, 3_200)) as i32;
            let found = bench.home(code, Settings::default());
            assert_eq!(found, Ok(home), "method {code} from {start}");
        }
    }
}

#[test]
fn d25_the_first_index_pulse_behind_the_edge_is_home_however_late_the_edge_is_noticed() {
    for (code, home, edge) in RESULTS.map(|(code, home, _)| {
        let edge = RESULTS.iter().find(|(other, ..)| *other == code + 16);
        (code, home, edge.map_or(0, |(_, _, edge)| i64::from(*edge)))
    }) {
        if code > 14 {
            break;
        }
        let track = Track {
            latency: 100,
            index: Some((7, 30)),
            ..Track::with_home(home)
        };
        let found = Bench::new(track, 0).home(code, Settings::default());
        assert_eq!(
            found,
            Ok(behind(code, edge, (7, 30)) as i32),
            "method {code}"
        );
    }
}

#[test]
fn d25_a_switch_touched_for_less_than_its_filter_wants_is_too_narrow() {
    let track = Track {
        latency: 50,
        ..Track::with_home((11_000, 11_099))
    };
    for code in [23, 24, 25, 26, 27, 28, 29, 30] {
        let found = Bench::new(track, 0).home(code, Settings::default());
        assert_eq!(found, Err(Failure::TooNarrow), "method {code}");
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(100)))]

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
    fn d25_a_late_filter_never_makes_home_the_wrong_edge(
        which in 0usize..28,
        start in -51_000i64..=51_000,
        hysteresis in 0i32..=50,
        latency in 0usize..=100,
        // Of the way from an edge to where the motor comes to rest behind it.
        width in 5i64..300,
        search in 2_000i64..60_000,
        zero in 500i64..5_000,
        acceleration in 50_000i64..2_000_000,
        index in 30i64..3_200,
    ) {
        let (code, home, _) = RESULTS[which];
        let zero = zero.min(search);
        let passes = |speed: i64| speed * (latency as i64 + 2) / 1_000;
        let stops = search * search / (2 * acceleration);
        let margin = 2 * i64::from(hysteresis);
        // The edges and the index pulse behind them lie before the positive limit switch: home behind that is never found.
        let width = (passes(search) + stops) * width / 100;
        let width = width.min(39_000 - 3_200 - margin).max(margin + 2);
        let is_window = home == WINDOW && code != 1 && code != 2 && code != 17 && code != 18;
        let home = if is_window { (11_000, 11_000 + width) } else { home };
        let track = Track { hysteresis: hysteresis.into(), latency, index: Some((400, index)), ..Track::with_home(home) };
        let mut bench = Bench::new(track, start);
        bench.search_speed = search;
        bench.zero_speed = zero;
        bench.acceleration = acceleration;
        let without = if code < 15 { code + 16 } else { code };
        let edge = match without {
            17 => -50_000,
            18 => 50_000,
            25..=28 => 11_000 + width,
            _ => 11_000,
        };
        let expected = behind(code, edge + i64::from(shift(without, hysteresis)), (400, index));
        match bench.home(code, Settings::default()) {
            Ok(found) => prop_assert_eq!(i64::from(found), expected),
            Err(failure) => {
                prop_assert_eq!(failure, Failure::TooNarrow);
                prop_assert!(is_window && width < margin + passes(search) + zero * zero / acceleration + 1);
            }
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

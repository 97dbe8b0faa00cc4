//! The reference results, to the increment, from every start region.

use super::axis::FAR;
use super::*;

/// A home switch in a window, from an edge to the positive end, and from the negative end to an edge.
pub(crate) const WINDOW: Range = (11_000, 15_000);
pub(crate) const POSITIVE: Range = (11_000, FAR);
pub(crate) const NEGATIVE: Range = (-FAR, 11_000);

/// Method, home switch, home position.
pub(crate) const RESULTS: [(i8, Range, i32); 28] = [
    (1, WINDOW, -47_600),
    (2, WINDOW, 48_400),
    (3, POSITIVE, 10_000),
    (4, POSITIVE, 13_200),
    (5, NEGATIVE, 13_200),
    (6, NEGATIVE, 10_000),
    (7, WINDOW, 10_000),
    (8, WINDOW, 13_200),
    (9, WINDOW, 13_200),
    (10, WINDOW, 16_400),
    (11, WINDOW, 16_400),
    (12, WINDOW, 13_200),
    (13, WINDOW, 13_200),
    (14, WINDOW, 10_000),
    (17, WINDOW, -50_000),
    (18, WINDOW, 50_000),
    (19, POSITIVE, 11_000),
    (20, POSITIVE, 11_000),
    (21, NEGATIVE, 11_000),
    (22, NEGATIVE, 11_000),
    (23, WINDOW, 11_000),
    (24, WINDOW, 11_000),
    (25, WINDOW, 15_000),
    (26, WINDOW, 15_000),
    (27, WINDOW, 15_000),
    (28, WINDOW, 15_000),
    (29, WINDOW, 11_000),
    (30, WINDOW, 11_000),
];

/// What a hysteresis adds to the home position: the last edge of methods 17 to 30, by its end and direction.
pub(crate) fn shift(code: i8, hysteresis: i32) -> i32 {
    match code {
        17 | 20 | 21 | 24 | 26 | 27 | 29 => hysteresis,
        18 | 19 | 22 | 23 | 25 | 28 | 30 => -hysteresis,
        _ => 0,
    }
}

/// Every start region, on both limit switches too.
const STARTS: [i64; 14] = [
    -51_000, -50_000, -20_000, 0, 10_999, 11_000, 11_001, 13_000, 14_999, 15_001, 16_500, 40_000,
    50_000, 51_000,
];

#[test]
fn d25_every_method_comes_out_to_the_increment_from_every_start() {
    for (code, home, result) in RESULTS {
        for start in STARTS {
            let mut bench = Bench::new(Track::with_home(home), start);
            let found = bench.home(code, Settings::default());
            assert_eq!(found, Ok(result), "method {code} from {start}");
        }
    }
}

#[test]
fn d25_hysteresis_shifts_home_by_itself_and_not_by_the_start() {
    for (code, home, result) in RESULTS {
        for start in STARTS {
            let track = Track {
                hysteresis: 50,
                ..Track::with_home(home)
            };
            let found = Bench::new(track, start).home(code, Settings::default());
            let expected = result + shift(code, 50);
            assert_eq!(found, Ok(expected), "method {code} from {start}");
        }
    }
}

#[test]
fn d25_an_edge_that_is_noticed_late_is_where_it_was_captured() {
    for (code, home, result) in RESULTS {
        for start in STARTS {
            let track = Track {
                latency: 5,
                ..Track::with_home(home)
            };
            let found = Bench::new(track, start).home(code, Settings::default());
            assert_eq!(found, Ok(result), "method {code} from {start}");
        }
    }
}

#[test]
fn m61_the_captured_edge_counts_at_any_speed() {
    // 500,000 increments a second, noticed a millisecond later.
    let settings = Settings {
        last_move_is_fast: true,
        ..Settings::default()
    };
    for (code, home, result) in RESULTS.into_iter().filter(|(code, ..)| *code >= 17) {
        let track = Track {
            latency: 1,
            ..Track::with_home(home)
        };
        let mut bench = Bench::new(track, 0);
        bench.search_speed = 500_000;
        bench.acceleration = 100_000_000;
        let found = bench.home(code, settings);
        assert_eq!(found, Ok(result), "method {code}");
    }
}

#[test]
fn d25_the_index_pulse_alone() {
    for (code, start, result) in [
        (33, 0, -2_800),
        (34, 0, 400),
        (33, 400, -2_800),
        (34, 400, 3_600),
    ] {
        let mut bench = Bench::new(Track::with_home(WINDOW), start);
        let found = bench.home(code, Settings::default());
        assert_eq!(found, Ok(result), "method {code} from {start}");
    }
}

#[test]
fn d25_home_is_here() {
    for code in [35, 37] {
        let mut bench = Bench::new(Track::with_home(WINDOW), 1_234);
        let mut homing = bench.begin(code, Settings::default()).unwrap();
        assert_eq!(bench.tick(&mut homing), Outcome::Attained(1_234));
    }
}

#[test]
fn d25_hard_stops() {
    let track = Track {
        negative_limit: None,
        positive_limit: None,
        home: None,
        stops: Some((-60_000, 70_000)),
        ..Track::with_home(WINDOW)
    };
    let settings = Settings {
        block_time: 20,
        back_off: 100,
        ..Settings::default()
    };
    for (code, result) in [(-1, 67_600), (-2, -57_200), (-3, 70_000), (-4, -60_000)] {
        let found = Bench::new(track, 5_000).home(code, settings);
        assert_eq!(found, Ok(result), "method {code}");
        // The other signs that are about.
        let other = Settings {
            other_block_signs: true,
            ..settings
        };
        let twin = if code % 2 == 0 { code + 1 } else { code - 1 };
        assert_eq!(Bench::new(track, 5_000).home(twin, other), Ok(result));
    }
    let backed_off = Settings {
        home_is_backed_off: true,
        ..settings
    };
    assert_eq!(Bench::new(track, 0).home(-3, backed_off), Ok(69_900));
}

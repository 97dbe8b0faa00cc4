//! How homing ends when it cannot succeed, and the readings that vendors differ in.

use super::results::{NEGATIVE, POSITIVE, WINDOW};
use super::*;

fn home(track: Track, start: i64, code: i8, settings: Settings) -> Result<i32, Failure> {
    Bench::new(track, start).home(code, settings)
}

#[test]
fn every_number_that_is_a_method_is_listed() {
    for code in i8::MIN..=i8::MAX {
        let method = Method::from_code(code);
        assert_eq!(method.is_some(), Method::CODES.contains(&code), "{code}");
        assert_eq!(method.map_or(code, Method::code), code);
    }
}

#[test]
fn m50_what_is_not_fitted_is_not_looked_for() {
    let track = Track {
        negative_limit: None,
        home: None,
        index: None,
        ..Track::with_home(WINDOW)
    };
    for code in [1, 17, 2, 19, 23, 33, 34, -1, -3] {
        let result = home(track, 0, code, Settings::default());
        assert_eq!(result, Err(Failure::NotFitted), "method {code}");
    }
    assert_eq!(home(track, 0, 18, Settings::default()), Ok(50_000));
}

#[test]
fn d25_a_limit_switch_that_is_not_looked_for_is_an_error() {
    // The home switch lies on the other side, or nowhere.
    let never = Track::with_home((200_000, 200_001));
    for (track, code, start) in [
        (Track::with_home(WINDOW), 19, 20_000),
        (Track::with_home(WINDOW), 20, 20_000),
        (Track::with_home(WINDOW), 21, 0),
        (Track::with_home(WINDOW), 6, 0),
        (never, 23, 0),
        (never, 14, 0),
        (never, 28, 50_000),
    ] {
        let mut bench = Bench::new(track, start);
        let result = bench.home(code, Settings::default());
        assert_eq!(result, Err(Failure::Limit), "method {code} from {start}");
        assert!((-50_600..=50_600).contains(&bench.position));
    }
}

#[test]
fn d25_methods_without_limit_switches_may_turn_round_at_one() {
    let settings = Settings {
        turns_at_limit: true,
        ..Settings::default()
    };
    let track = Track::with_home(WINDOW);
    assert_eq!(home(track, 20_000, 19, settings), Ok(11_000));
    assert_eq!(home(track, 20_000, 20, settings), Ok(11_000));
    assert_eq!(home(track, 0, 21, settings), Ok(15_000));
    assert_eq!(home(track, 0, 22, settings), Ok(15_000));
    // The limit switch that a method looks for never turns it round.
    assert_eq!(
        home(
            Track {
                negative_limit: None,
                ..track
            },
            0,
            17,
            settings
        ),
        Err(Failure::NotFitted)
    );
}

#[test]
fn m56_both_limit_switches_are_an_error_before_anything_moves() {
    let track = Track {
        negative_limit: Some((-100, 100)),
        positive_limit: Some((-100, 100)),
        ..Track::with_home(WINDOW)
    };
    for code in [1, 19, 23, 33, 35] {
        let mut bench = Bench::new(track, 0);
        assert_eq!(
            bench.home(code, Settings::default()),
            Err(Failure::BothLimits)
        );
        assert_eq!(bench.position, 0);
    }
}

#[test]
fn m55_a_start_on_the_opposite_limit_drives_away_from_it() {
    let track = Track::with_home(WINDOW);
    assert_eq!(home(track, 50_500, 17, Settings::default()), Ok(-50_000));
    assert_eq!(home(track, -50_500, 18, Settings::default()), Ok(50_000));
    let mut bench = Bench::new(track, 50_500);
    assert_eq!(bench.home(34, Settings::default()), Err(Failure::Limit));
    assert_eq!(
        bench.reached,
        (50_500, 50_500),
        "not a step into the switch"
    );
}

#[test]
fn the_way_and_the_time_are_bounded() {
    let track = Track::with_home((200_000, 200_001));
    let track = Track {
        positive_limit: None,
        ..track
    };
    let settings = Settings {
        longest_distance: 30_000,
        ..Settings::default()
    };
    let mut bench = Bench::new(track, 0);
    assert_eq!(bench.home(19, settings), Err(Failure::TooLong));
    assert!((30_000..=30_040).contains(&bench.position));

    let settings = Settings {
        longest_time: 500,
        ..Settings::default()
    };
    let mut bench = Bench::new(track, 0);
    assert_eq!(bench.home(19, settings), Err(Failure::TooLong));
    assert!((500..=502).contains(&bench.ticks));
}

#[test]
fn an_index_pulse_is_not_looked_for_for_ever() {
    let track = Track {
        index: Some((1 << 30, 1 << 31)),
        ..Track::with_home(POSITIVE)
    };
    let settings = Settings {
        longest_distance_to_index: 4_000,
        ..Settings::default()
    };
    for code in [3, 4, 33, 34] {
        let mut bench = Bench::new(track, 0);
        assert_eq!(
            bench.home(code, settings),
            Err(Failure::NoIndex),
            "method {code}"
        );
    }
    let mut bench = Bench::new(track, 0);
    assert_eq!(bench.home(33, settings), Err(Failure::NoIndex));
    assert!((-4_004..=-4_000).contains(&bench.position));
}

#[test]
fn a_narrow_switch_that_is_run_over_is_found_at_zero_speed() {
    // 500 steps to stop from search speed.
    for code in [23, 24, 25, 26, 27, 28, 29, 30] {
        let found = home(
            Track::with_home((11_000, 11_099)),
            0,
            code,
            Settings::default(),
        );
        let at = if (25..=28).contains(&code) {
            11_099
        } else {
            11_000
        };
        assert_eq!(found, Ok(at), "method {code}");
    }
}

#[test]
fn a_switch_too_narrow_for_any_speed_is_an_error() {
    let mut bench = Bench::new(Track::with_home((11_000, 11_099)), 0);
    bench.zero_speed = bench.search_speed;
    assert_eq!(bench.home(30, Settings::default()), Err(Failure::TooNarrow));
}

#[test]
fn d25_a_start_on_the_switch_is_left_and_entered_again() {
    let longest = |is_direct| {
        let mut bench = Bench::new(Track::with_home(POSITIVE), 40_000);
        let settings = Settings {
            is_direct,
            ..Settings::default()
        };
        assert_eq!(bench.home(19, settings), Ok(11_000));
        bench.ticks
    };
    // 29,000 steps at 2,000 steps/s, or at 20,000 steps/s.
    assert!(longest(true) > 14_000);
    assert!(longest(false) < 4_000);
}

#[test]
fn the_last_move_is_at_zero_speed_unless_it_is_set_otherwise() {
    for (last_move_is_fast, speeds) in [(false, 1_900..=2_000), (true, 4_000..=20_000)] {
        let settings = Settings {
            last_move_is_fast,
            ..Settings::default()
        };
        let mut bench = Bench::new(Track::with_home(NEGATIVE), 20_000);
        let mut homing = bench.begin(22, settings).unwrap();
        let mut fastest = 0;
        while bench.tick(&mut homing) != Outcome::Attained(11_000) {
            assert!(bench.ticks < 50_000);
            if homing.stage == Stage::LastMove {
                fastest = fastest.max(bench.velocity().abs());
            }
        }
        assert!(speeds.contains(&fastest), "{fastest}");
    }
}

#[test]
fn d25_an_edge_behind_a_limit_switch_is_an_error_of_the_limit_switch() {
    // At search speed the motor comes to rest far behind the edge, but it is the limit switch that it meets first: nothing is too narrow.
    for code in [9, 10, 25, 26] {
        let mut bench = Bench::new(Track::with_home((11_000, 66_947)), 0);
        bench.search_speed = 59_407;
        bench.zero_speed = 500;
        bench.acceleration = 50_000;
        let found = bench.home(code, Settings::default());
        assert_eq!(found, Err(Failure::Limit), "method {code}");
    }
}

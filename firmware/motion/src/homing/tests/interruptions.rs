//! A halt at any moment, and a start before the motor has come to rest.

use super::results::{POSITIVE, RESULTS};
use super::*;
use std::vec::Vec;

/// Method 3 in its last move, so slow to stop that a halt just before the edge ends behind it.
fn before_the_edge(distance: i64) -> (Bench, Homing) {
    let mut bench = Bench::new(Track::with_home(POSITIVE), 20_000);
    bench.acceleration = 20_000;
    let mut homing = bench.begin(3, Settings::default()).unwrap();
    while !(homing.stage == Stage::LastMove && bench.position - 11_000 < distance) {
        assert!(bench.ticks < 50_000);
        bench.tick(&mut homing);
    }
    assert_eq!(bench.velocity(), -2_000);
    (bench, homing)
}

#[test]
fn m49_a_halt_that_ends_behind_the_edge_stays_a_halt() {
    let (mut bench, mut homing) = before_the_edge(50);
    bench.halt = true;
    let mut velocity = bench.velocity();
    for _ in 0..300 {
        let outcome = bench.tick(&mut homing);
        assert!(matches!(outcome, Outcome::UnderWay(_)), "{outcome:?}");
        assert!(bench.velocity() >= velocity, "it speeds up in a halt");
        velocity = bench.velocity();
    }
    assert_eq!((velocity, homing.stage), (0, Stage::ToIndex));
    bench.halt = false;
    assert_eq!(finish(&mut bench, &mut homing), Ok(10_000));
}

#[test]
fn m49_a_halt_around_any_order_changes_no_result() {
    for (code, home, result) in RESULTS {
        let begin = || {
            let mut bench = Bench::new(Track::with_home(home), 20_000);
            let homing = bench.begin(code, Settings::default()).unwrap();
            (bench, homing)
        };
        // An order follows what is seen in its tick: an edge, an index pulse, the standstill.
        let (mut bench, mut homing) = begin();
        let mut ordered = Vec::new();
        while let Outcome::UnderWay(order) = bench.tick(&mut homing) {
            if order != Order::GoOn {
                ordered.push(bench.ticks - 1);
            }
        }
        let starts = ordered
            .iter()
            .flat_map(|tick| tick.saturating_sub(3)..=tick + 1);
        for (start, pause) in starts.flat_map(|start| [1, 100].map(|pause| (start, pause))) {
            let (mut bench, mut homing) = begin();
            while bench.ticks < start + pause {
                bench.halt = bench.ticks >= start;
                bench.tick(&mut homing);
            }
            bench.halt = false;
            let found = finish(&mut bench, &mut homing);
            assert_eq!(
                found,
                Ok(result),
                "method {code}, {pause} ticks of halt at {start}"
            );
        }
    }
}

#[test]
fn m48_a_start_before_the_motor_rests_takes_the_same_edge() {
    // The last move of method 19 leaves the switch in reverse; interrupted there, the motor leaves it on its ramp.
    let (mut bench, _) = before_the_edge(50);
    bench.obey(Order::Stop);
    let mut homing = bench.begin(19, Settings::default()).unwrap();
    assert_eq!(finish(&mut bench, &mut homing), Ok(11_000));
}

/// Goes on to the end.
fn finish(bench: &mut Bench, homing: &mut Homing) -> Result<i32, Failure> {
    for _ in 0..200_000 {
        match bench.tick(homing) {
            Outcome::UnderWay(_) => {}
            Outcome::Attained(home) => return Ok(home),
            Outcome::Failed(failure) => return Err(failure),
        }
    }
    panic!("it goes on for ever: {homing:?}");
}

//! Along straight lines of a path there is a short way to the next chord. It is the one that the long way finds.

use super::{FAST, HZ, Replay, SLOW, axis};
use crate::axis::Axis;
use crate::{Position, Ticks};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// A set-point: ticks and Q32 steps behind the one before.
type SetPoint = (u32, i64);

fn set_point() -> impl Strategy<Value = SetPoint> {
    let time = prop_oneof![4 => Just(HZ / 1000), 1 => 1..HZ / 100, 1 => 1..2_000u32];
    let way = prop_oneof![
        4 => -1_000i64 << 32..1_000 << 32,
        2 => -1i64 << 32..1 << 32,
        // Slower than positions tell from tick to tick.
        1 => -100_000i64..100_000,
        1 => Just(0),
    ];
    (time, way)
}

/// One chord of the axis, and its records into a sink that takes all. Returns whether the short way was gone.
fn compose(axis: &mut Axis, sink: &mut Replay) -> bool {
    let long = axis.clone().next_chord();
    let short = axis.clone().chord_on_line();
    if let Some(short) = &short {
        assert_eq!(
            std::format!("{short:?}"),
            std::format!("{:?}", long.as_ref().unwrap())
        );
    }
    let mut stepwise = axis.clone();
    stepwise.leg = None;
    axis.compose();
    // Whichever way was gone: the same records, and the same place.
    stepwise.compose();
    assert_eq!(axis.train.waiting(), stepwise.train.waiting());
    assert_eq!(axis.horizon, stepwise.horizon);
    assert_eq!(axis.trace.at(axis.horizon), stepwise.trace.at(axis.horizon));
    axis.hand_out(sink).unwrap();
    sink.play_out();
    short.is_some()
}

fn play(points: &[SetPoint], is_fast: bool) -> u32 {
    let (mut axis, mut sink) = axis(if is_fast { FAST } else { SLOW });
    let (mut at, mut to) = (0, 0i64);
    let mut short = 0;
    for (time, way) in points {
        at += Ticks::from(*time);
        to = to.wrapping_add(*way);
        if axis.follow(at, Position::from_bits(to)).is_err() {
            at = axis.horizon;
            continue;
        }
        // Half of a period is left when the next set-point comes.
        while axis.horizon + u64::from(time / 2) < at && !axis.is_at_rest() {
            short += u32::from(compose(&mut axis, &mut sink));
        }
    }
    while !axis.is_at_rest() {
        short += u32::from(compose(&mut axis, &mut sink));
    }
    short
}

#[test]
fn the_short_way_is_gone_in_every_period() {
    let points = [(HZ / 1000, 100 << 32); 50];
    assert!(play(&points, true) >= 50);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn the_short_way_along_a_line_finds_the_chord_of_the_long_one(
        points in prop::collection::vec(set_point(), 1..40),
        is_fast: bool,
    ) {
        play(&points, is_fast);
    }
}

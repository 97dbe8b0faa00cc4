//! What is handed out before a plan that may be dear.

use super::behaviour::{T01, command, fly, ms};
use super::{FAST, Replay, axis, run};
use crate::axis::Axis;
use crate::{PulseSink, Ramps};

const JERK: u32 = 20_000_000;

/// Plays a segment, so that the next refill is due, and tells what is left behind that and behind the preparation, in tenths of a segment.
fn before_and_behind(axis: &mut Axis, sink: &mut Replay, ramps: Ramps) -> (u64, u64) {
    let segment = u64::from(axis.stepper.segment());
    axis.advance(sink).unwrap();
    sink.play(segment);
    let before = sink.pending();
    axis.prepare(ramps, sink).unwrap();
    (before * 10 / segment, sink.pending() * 10 / segment)
}

#[test]
fn two_segments_of_a_smooth_motion_are_committed_before_it_is_planned_anew() {
    for ramps in [Ramps::SinSquared, Ramps::JerkLimited(JERK)] {
        let (mut axis, mut sink) = axis(FAST);
        axis.set_ramps(ramps);
        command(&mut axis, &mut sink, 30_000, T01);
        fly(&mut axis, &mut sink, ms(50));
        for _ in 0..200 {
            let (before, behind) = before_and_behind(&mut axis, &mut sink, ramps);
            assert!(before < 20 && (20..=30).contains(&behind), "{behind}");
        }
    }
}

/// In place of a linear motion a plan is dear with limited jerk alone. At rest there is nothing to hand out.
#[test]
fn two_segments_of_a_linear_motion_are_committed_before_limited_jerk_alone() {
    for (ramps, is_prepared) in [
        (Ramps::Linear, false),
        (Ramps::SinSquared, false),
        (Ramps::MovingAverage(JERK), false),
        (Ramps::JerkLimited(JERK), true),
    ] {
        let (mut axis, mut sink) = axis(FAST);
        axis.prepare(ramps, &mut sink).unwrap();
        assert_eq!(sink.pending(), 0);
        command(&mut axis, &mut sink, 30_000, T01);
        fly(&mut axis, &mut sink, ms(50));
        let (before, behind) = before_and_behind(&mut axis, &mut sink, ramps);
        assert!(before < 20, "{before}");
        assert_eq!(behind >= 20, is_prepared, "{ramps:?}: {behind}");
    }
}

/// Of pulses that are left, and of those alone: at rest there is nothing to hand out, and behind the last ones nothing more.
#[test]
fn it_runs_short_with_less_than_a_segment_and_a_half() {
    let (mut axis, mut sink) = axis(FAST);
    let segment = u64::from(axis.stepper.segment());
    assert!(!axis.runs_short(0));
    command(&mut axis, &mut sink, 30_000, T01);
    fly(&mut axis, &mut sink, ms(50));
    axis.advance(&mut sink).unwrap();
    assert!(!axis.runs_short(sink.pending()));
    assert!(!axis.runs_short(segment * 3 / 2));
    assert!(axis.runs_short(segment * 3 / 2 - 1));
    run(&mut axis, &mut sink);
    assert!(!axis.runs_short(0));
}

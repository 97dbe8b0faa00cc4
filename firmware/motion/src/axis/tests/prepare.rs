//! What is handed out before a plan that may be dear.

use super::behaviour::{T01, command, fly, ms};
use super::{FAST, axis, run};
use crate::axis::Axis;
use crate::{Position, PulseSink, Ramps, SignedSpeed};

/// Planning a smooth motion anew takes long: so much more is handed out before, and the demand still is what is being played. Otherwise it is as
/// of any motion: a stop is to be felt.
#[test]
fn four_segments_of_a_smooth_motion_are_committed_before_it_is_planned_anew() {
    for ramps in [Ramps::SinSquared, Ramps::JerkLimited(20_000_000)] {
        let (mut axis, mut sink) = axis(FAST);
        let segment = u64::from(axis.train.segment());
        axis.set_ramps(ramps);
        command(&mut axis, &mut sink, 30_000, T01);
        for number in 0..800 {
            let is_prepared = number % 32 == 31;
            let (least, most) = if is_prepared {
                axis.prepare(ramps, &mut sink).unwrap();
                (4, 5)
            } else {
                (2, if number % 32 < 12 { 5 } else { 3 })
            };
            axis.advance(&mut sink).unwrap();
            assert!(sink.pending() >= least * segment);
            assert!(sink.pending() <= most * segment + 100);
            let played = sink.ticks - sink.pending();
            let planned = sink.curves[0].state_at(played);
            let demand = axis.demand(sink.pending());
            assert!((demand.position - planned.position.whole_steps()).abs() <= 1);
            let velocity = planned.velocity.speed(axis.clock);
            assert!(demand.velocity.abs_diff(velocity) <= 70.into());
            sink.play(segment / 4);
        }
    }
}

/// In place of a linear motion a plan is dear with limited jerk alone. At rest there is nothing to hand out.
#[test]
fn four_segments_of_a_linear_motion_are_committed_before_limited_jerk_alone() {
    let jerk_limited = Ramps::JerkLimited(20_000_000);
    for (ramps, segments) in [
        (Ramps::Linear, 2),
        (Ramps::SinSquared, 2),
        (Ramps::MovingAverage(20_000_000), 2),
        (jerk_limited, 4),
    ] {
        let (mut axis, mut sink) = axis(FAST);
        axis.prepare(ramps, &mut sink).unwrap();
        assert_eq!(sink.pending(), 0);
        let segment = u64::from(axis.train.segment());
        command(&mut axis, &mut sink, 30_000, T01);
        fly(&mut axis, &mut sink, ms(50));
        axis.advance(&mut sink).unwrap();
        axis.prepare(ramps, &mut sink).unwrap();
        let pending = sink.pending() / segment;
        let expected = segments..=segments + 1;
        assert!(expected.contains(&pending), "{ramps:?}: {pending}");
    }
}

/// Behind the last set-point the axis would stand, with no ramp.
#[test]
fn of_set_points_no_more_is_committed_before_limited_jerk_than_have_come() {
    for (ahead, apart, segments) in [(3, 1, 3), (6, 2, 4)] {
        let (mut axis, mut sink) = axis(FAST);
        let segment = u64::from(axis.train.segment());
        let mut end = 0;
        // 40 steps in a segment.
        let go_on = |axis: &mut Axis, end: &mut u64, pending: u64| {
            let played = axis.played(pending);
            while *end < played + ahead * segment {
                *end += apart * segment;
                let steps = (*end / segment * 40).cast_signed();
                axis.follow(*end, Position::from_steps(steps)).unwrap();
            }
        };
        for _ in 0..40 {
            go_on(&mut axis, &mut end, sink.pending());
            axis.advance(&mut sink).unwrap();
            sink.play(segment);
        }
        go_on(&mut axis, &mut end, sink.pending());
        axis.advance(&mut sink).unwrap();
        axis.prepare(Ramps::JerkLimited(20_000_000), &mut sink)
            .unwrap();
        let pending = sink.pending() / segment;
        let expected = segments..=segments + 1;
        assert!(expected.contains(&pending), "{ahead} ahead: {pending}");
        assert!(axis.committed_velocity() > SignedSpeed::ZERO, "{ahead}");
    }
}

/// Of pulses that are left, and of those alone: at rest there is nothing to hand out, and behind the last ones nothing more.
#[test]
fn it_runs_short_with_less_than_a_segment_and_a_half() {
    let (mut axis, mut sink) = axis(FAST);
    let segment = u64::from(axis.train.segment());
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

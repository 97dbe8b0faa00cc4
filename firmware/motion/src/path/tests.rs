//! An axis that follows: where it is at each set-point, and in between.

use proptest::prelude::*;
use std::collections::VecDeque;
use std::vec::Vec;

use crate::{
    Axis, AxisConfig, Clock, DriverTiming, FollowError, Limits, Position, PulseSink, Record, Ticks,
    Velocity,
};

const SEGMENT: u64 = 84_000;

/// A sink that notes at which tick each step leaves.
#[derive(Default)]
struct Notes {
    records: VecDeque<Record>,
    /// The beginning of the next record to come, and of what is still to be played.
    end: Ticks,
    now: Ticks,
    steps: Vec<(Ticks, i32)>,
}

impl PulseSink for Notes {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if record.width > 0 {
            for n in 0..u64::from(record.repeat) {
                let at = self.end + n * u64::from(record.period);
                self.steps.push((at, record.direction.sign()));
            }
        }
        self.end += record.ticks();
        self.records.push_back(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.end - self.now
    }

    fn free(&self) -> usize {
        256
    }
}

impl Notes {
    /// The steps that have left before tick `t`.
    fn position_at(&self, t: Ticks) -> i64 {
        let before = self.steps.iter().filter(|(at, _)| *at < t);
        before.map(|(_, sign)| i64::from(*sign)).sum()
    }
}

fn axis() -> Axis {
    Axis::new(AxisConfig {
        clock: Clock::new(84_000_000).unwrap(),
        time_slice: SEGMENT as u32,
        timing: DriverTiming {
            pulse_high: 84,
            pulse_low: 84,
            direction_setup: 420,
            direction_hold: 420,
        },
    })
}

/// One control tick of this length.
fn tick(axis: &mut Axis, sink: &mut Notes, length: Ticks) {
    assert_eq!(axis.advance(sink), Ok(()));
    sink.now = (sink.now + length).min(sink.end);
}

proptest! {
    /// At the tick of each set-point exactly its steps have left, whatever the intervals and however late the next one comes.
    #[test]
    fn m63_at_every_set_point_the_steps_are_exact(
        intervals in prop::collection::vec((80_000_u64..400_000, -380_i64..=380), 1..60),
        cubic in any::<bool>(),
    ) {
        let mut axis = axis();
        let mut sink = Notes::default();
        let (mut end, mut target) = (3 * SEGMENT, 0);
        axis.follow(end, Position::from_steps(0)).unwrap();
        tick(&mut axis, &mut sink, SEGMENT);
        let mut knots = Vec::new();
        for (length, way) in intervals {
            end += length;
            target += way;
            let to = Position::from_steps(target);
            let taken = if cubic {
                let mean = i32::try_from(way * 84_000_000 / i64::try_from(length).unwrap()).unwrap();
                let velocity = Velocity::from_speed(Clock::new(84_000_000).unwrap(), (mean / 2).into());
                axis.follow_smoothly(end, to, velocity)
            } else {
                axis.follow(end, to)
            };
            prop_assert_eq!(taken, Ok(()));
            knots.push((end, target));
            while sink.now + 3 * SEGMENT < end {
                tick(&mut axis, &mut sink, SEGMENT);
            }
        }
        axis.follow(end + SEGMENT, Position::from_steps(target)).unwrap();
        while !axis.is_at_rest() {
            tick(&mut axis, &mut sink, SEGMENT);
        }
        for (end, target) in knots {
            // A turn of direction is waited for, and crossings lie in the middle between steps.
            let near = [end, end + 2_000].map(|t| sink.position_at(t));
            prop_assert!(near.contains(&target), "at {end}: {near:?}, not {target}");
        }
        prop_assert_eq!(sink.position_at(Ticks::MAX), target);
        prop_assert_eq!(axis.committed_position(), target);
    }
}

#[test]
fn m63_between_set_points_the_speed_is_even() {
    let mut axis = axis();
    let mut sink = Notes::default();
    axis.follow(3 * SEGMENT, Position::from_steps(0)).unwrap();
    tick(&mut axis, &mut sink, SEGMENT);
    for k in 1..=200 {
        let to = Position::from_steps(i64::try_from(k).unwrap() * 50);
        axis.follow((3 + k) * SEGMENT, to).unwrap();
        tick(&mut axis, &mut sink, SEGMENT);
    }
    let periods = sink.steps.windows(2).map(|pair| pair[1].0 - pair[0].0);
    for period in periods.skip(1) {
        assert!(period.abs_diff(SEGMENT / 50) <= 1, "{period}");
    }
}

#[test]
fn m64_a_path_that_is_not_gone_on_with_coasts_and_then_stands() {
    let mut axis = axis();
    let mut sink = Notes::default();
    axis.follow(3 * SEGMENT, Position::from_steps(0)).unwrap();
    axis.follow(4 * SEGMENT, Position::from_steps(100)).unwrap();
    for _ in 0..20 {
        tick(&mut axis, &mut sink, SEGMENT);
    }
    assert!(axis.is_at_rest());
    assert_eq!(axis.committed_position(), 300, "two segments more");
}

#[test]
fn a_stop_begins_with_the_velocity_of_the_path() {
    let mut axis = axis();
    let mut sink = Notes::default();
    axis.follow(3 * SEGMENT, Position::from_steps(0)).unwrap();
    axis.follow(23 * SEGMENT, Position::from_steps(2_000))
        .unwrap();
    for _ in 0..10 {
        tick(&mut axis, &mut sink, SEGMENT);
    }
    assert!(axis.committed_velocity().is_close_to(100_000.into()));
    let from = axis.path_end();
    assert_eq!(from.0, 23 * SEGMENT);
    let nowhere = Limits {
        velocity: 0.into(),
        acceleration: 1,
        deceleration: 1,
    };
    assert!(axis.move_to(0, nowhere).is_err());
    assert!(
        axis.committed_velocity().is_close_to(100_000.into()),
        "a refused order changes nothing"
    );
    axis.stop(1_000_000).unwrap();
    while !axis.is_at_rest() {
        tick(&mut axis, &mut sink, SEGMENT);
    }
    // v²/2a is 5,000 steps.
    let way = axis.committed_position() - 900;
    assert!((4_900..=5_100).contains(&way), "{way}");
}

#[test]
fn a_slow_velocity_that_is_given_each_millisecond_does_not_drift() {
    const MILLISECOND: u64 = 84_000;
    const PIECES: u64 = 100_000;
    let hour = crate::Speed::from_bits((1 << 32) / 3_600);
    for velocity in [hour, crate::Speed::from_bits(4_294_967)] {
        for reverse in [false, true] {
            let mut axis = axis();
            let mut sink = Notes::default();
            let asked = velocity.signed(reverse);
            for piece in 1..=PIECES {
                axis.follow_velocity((piece + 4) * MILLISECOND, asked)
                    .unwrap();
                tick(&mut axis, &mut sink, SEGMENT);
                sink.steps.clear();
                sink.records.clear();
                assert!(piece < 3 || axis.path_end_demand().velocity.is_close_to(asked));
            }
            let (end, state) = axis.path_end();
            assert_eq!(end, (PIECES + 4) * MILLISECOND);
            // But for half of the first five milliseconds, a ramp.
            let way = state.position.bits().unsigned_abs() as f64;
            let expected = velocity.bits() as f64 * (PIECES as f64 + 1.5) / 1_000.0;
            assert!((way / expected - 1.0).abs() < 1e-5, "{way} for {expected}");
        }
    }
}

#[test]
fn what_comes_too_late_or_too_early_is_refused() {
    let mut axis = axis();
    let to = Position::from_steps(1);
    assert_eq!(axis.follow(0, to), Err(FollowError::TooLate));
    assert_eq!(axis.follow(1 << 40, to), Err(FollowError::TooFarAhead));
    assert!(axis.is_at_rest());
    for n in 1..4 {
        assert_eq!(axis.follow(n * SEGMENT, to), Ok(()));
    }
    assert_eq!(
        axis.follow(9 * SEGMENT, to),
        Ok(()),
        "the empty piece at the beginning is forgotten"
    );
    assert_eq!(axis.follow(10 * SEGMENT, to), Err(FollowError::TooFarAhead));
    assert_eq!(axis.follow(9 * SEGMENT, to), Err(FollowError::TooLate));
}

#[test]
fn a_cubic_keeps_its_velocities() {
    let clock = Clock::new(84_000_000).unwrap();
    let mut axis = axis();
    let velocity = Velocity::from_speed(clock, 20_000.into());
    axis.follow_smoothly(10 * SEGMENT, Position::from_steps(100), velocity)
        .unwrap();
    axis.follow_smoothly(20 * SEGMENT, Position::from_steps(300), velocity)
        .unwrap();
    axis.follow_smoothly(30 * SEGMENT, Position::from_steps(400), Velocity::ZERO)
        .unwrap();
    let mut sink = Notes::default();
    let mut most = 0;
    while !axis.is_at_rest() {
        tick(&mut axis, &mut sink, SEGMENT);
        most = most.max(axis.committed_velocity().whole());
    }
    assert!((20_000..=20_100).contains(&most), "{most}");
    assert_eq!(axis.committed_position(), 400);
    let in_the_middle = [15, 16].map(|n| sink.position_at(n * SEGMENT));
    assert_eq!(
        in_the_middle,
        [200, 220],
        "a straight line between equal velocities"
    );
}

/// A velocity is rounded, so such a path stands a little before the middle or behind it.
#[test]
fn a_path_that_runs_out_next_to_the_middle_between_two_steps_comes_to_rest() {
    let clock = Clock::new(84_000_000).unwrap();
    for speed in (250..10_000).step_by(500) {
        for (from, speed) in [(-999, -speed), (-999, speed), (999, -speed), (999, speed)] {
            let mut axis = axis();
            axis.set_position(from);
            let velocity = Velocity::from_speed(clock, speed.into());
            axis.follow_smoothly(10 * SEGMENT, Position::from_steps(from), velocity)
                .unwrap();
            let target = axis.target();
            let mut sink = Notes::default();
            for _ in 0..20 {
                tick(&mut axis, &mut sink, SEGMENT);
            }
            let told = axis.demand(0).position;
            assert!(axis.is_at_rest(), "from {from} at {speed} steps/s");
            assert_eq!([target, told], [axis.committed_position(); 2]);
        }
    }
}

/// An axis that stands at 0 up to tick 3 · `SEGMENT`, and has begun to.
fn at_its_first_set_point() -> (Axis, Notes) {
    let (mut axis, mut sink) = (axis(), Notes::default());
    axis.follow(3 * SEGMENT, Position::from_steps(0)).unwrap();
    tick(&mut axis, &mut sink, SEGMENT);
    (axis, sink)
}

#[test]
fn m63_a_slow_line_before_a_fast_one_stays_slow() {
    for lead in 0..40 {
        let (mut axis, mut sink) = at_its_first_set_point();
        // The end of the slow line is anywhere in a segment.
        let (mut end, mut target) = (3 * SEGMENT, 0);
        let mut knots = Vec::new();
        for (length, way) in [(173_479 + lead * 1_000, 128), (311_566, 4), (179_133, 194)] {
            end += length;
            target += way;
            axis.follow(end, Position::from_steps(target)).unwrap();
            knots.push((end, target));
            while sink.now + 3 * SEGMENT < end {
                tick(&mut axis, &mut sink, SEGMENT);
            }
        }
        while !axis.is_at_rest() {
            tick(&mut axis, &mut sink, SEGMENT);
        }
        for (end, target) in knots {
            assert_eq!(sink.position_at(end), target, "{lead}, at {end}");
        }
    }
}

#[test]
fn m63_a_run_behind_single_pulses_begins_where_it_belongs() {
    let line = |from: i64, to: i64, length: Ticks, since: Ticks| {
        let way = i128::from(to - from) * i128::from(since) / i128::from(length);
        from + way as i64
    };
    for part in 0..32 {
        let (mut axis, mut sink) = at_its_first_set_point();
        // 32,000 steps/s, then a pulse in two segments, and as fast as before: from anywhere between two steps.
        let (mut end, mut target) = (3 * SEGMENT, 0);
        let mut lines = Vec::new();
        for (segments, way) in [(4, 32 << 32), (8, 4 << 32 | part << 27), (4, 32 << 32)] {
            let length = segments * SEGMENT;
            lines.push((end, length, target, target + way));
            (end, target) = (end + length, target + way);
            axis.follow(end, Position::from_bits(target)).unwrap();
            while sink.now + 3 * SEGMENT < end {
                tick(&mut axis, &mut sink, SEGMENT);
            }
        }
        while !axis.is_at_rest() {
            tick(&mut axis, &mut sink, SEGMENT);
        }
        for (begin, length, from, to) in lines {
            for since in (0..length).step_by(500) {
                let exact = line(from, to, length, since);
                let made = sink.position_at(begin + since) << 32;
                let off = exact.abs_diff(made);
                assert!(
                    off <= 5 << 29,
                    "{part}: {} thousandths of a step at {since}",
                    off / 4_294_967
                );
            }
        }
    }
}

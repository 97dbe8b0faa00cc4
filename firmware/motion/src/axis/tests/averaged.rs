//! An axis that follows the moving average of its plan.

use super::{FAST, HZ, Replay, axis, run};
use crate::average::Window;
use crate::axis::Axis;
use crate::vectors::{Smooth, smooth_moves};
use crate::{Direction, Limits, PlanError, Position, PulseSink, Ramps, Speed, Ticks};

const T01: Limits = Limits {
    velocity: Speed::per_second(100_000),
    acceleration: 500_000,
    deceleration: 250_000,
};

const JERK: u32 = 5_000_000;

fn ms(milliseconds: u64) -> Ticks {
    milliseconds * u64::from(HZ) / 1000
}

fn averaged() -> (Axis, Replay) {
    let (mut axis, sink) = axis(FAST);
    axis.set_ramps(Ramps::MovingAverage(JERK));
    (axis, sink)
}

/// Plays for so many milliseconds, and what is pending stays.
pub(super) fn fly(axis: &mut Axis, sink: &mut Replay, milliseconds: u64) {
    let quarter = u64::from(axis.stepper.time_slice() / 4);
    for _ in 0..milliseconds * 16 {
        axis.advance(sink).unwrap();
        sink.account(axis);
        sink.play(quarter);
    }
}

/// A move of the vectors, and how long it takes in seconds, with the window that is chosen for it or another one.
fn seconds(v: &Smooth, window: Option<f64>) -> f64 {
    let (mut axis, mut sink) = axis(FAST);
    axis.set_ramps(Ramps::MovingAverage(v.jerk));
    let limits = Limits {
        velocity: v.velocity.into(),
        acceleration: v.acceleration,
        deceleration: v.acceleration,
    };
    axis.move_to(v.distance, limits).unwrap();
    if let Some(seconds) = window {
        let window = Window::of((seconds * f64::from(HZ)) as u32, axis.stepper.time_slice());
        let from = axis.plan.exact_at(0);
        axis.average.begin(window, 0, from);
    }
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, v.distance);
    assert_eq!(sink.pulses, v.distance as u64);
    sink.ticks as f64 / f64::from(HZ)
}

/// `chosen` is the window of the rule, in units of a/j.
fn check(id: &str, chosen: f64) {
    let v = smooth_moves()
        .into_iter()
        .find(|v| v.name.starts_with(id))
        .unwrap();
    let window = f64::from(v.acceleration) / f64::from(v.jerk);
    let late = |taken: f64, exact: f64| {
        let late = (taken - exact) * f64::from(HZ);
        assert!((-2.0..3.0).contains(&late), "{id}: {late} ticks late");
    };
    late(seconds(&v, Some(window)), v.averaged);
    let longer = (chosen - 1.0) * window;
    late(seconds(&v, None), v.averaged + longer);
}

#[test]
fn j01_the_average_of_a_full_trapezoid_is_the_fastest_move() {
    check("J01", 1.0);
}

#[test]
fn j02_the_average_of_a_short_ramp() {
    check("J02", 1.0);
}

#[test]
fn j03_the_average_of_a_long_triangle() {
    check("J03", 2.0);
}

#[test]
fn j04_the_average_of_a_triangle() {
    check("J04", 2.0);
}

#[test]
fn j05_the_average_on_the_boundary() {
    check("J05", 1.0);
}

#[test]
fn j06_the_average_of_one_increment() {
    check("J06", 2.0);
}

#[test]
fn a_move_with_a_cruise_waits_for_the_harder_ramp_only() {
    // 200 ms up, 400 ms down, 100 ms or 150 ms of window; the cruise is 99 ms or 101 ms.
    for (distance, window) in [(39_900, 150), (40_100, 100)] {
        let (mut axis, mut sink) = averaged();
        axis.move_to(distance, T01).unwrap();
        let end = axis.plan.end().unwrap();
        sink.follow(&axis);
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, distance);
        let late = sink.ticks - end;
        assert!(
            late.abs_diff(ms(window)) <= u64::from(axis.stepper.time_slice()),
            "{late} ticks behind the plan of {distance} steps"
        );
    }
}

#[test]
fn the_window_is_chosen_at_rest_and_kept_until_then() {
    let (mut axis, mut sink) = averaged();
    axis.move_to(100_000, T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, 100);
    axis.set_ramps(Ramps::MovingAverage(JERK / 10));
    axis.move_to(90_000, T01).unwrap();
    sink.follow(&axis);
    let end = axis.plan.end().unwrap();
    run(&mut axis, &mut sink);
    assert!((sink.ticks - end).abs_diff(ms(100)) <= u64::from(axis.stepper.time_slice()));
    axis.move_to(0, T01).unwrap();
    let end = axis.plan.end().unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    assert!((sink.ticks - end).abs_diff(ms(1500)) <= ms(1500) / 512);
    assert_eq!(sink.position, 0);
}

#[test]
fn nothing_is_waited_for_where_nothing_moves() {
    let (mut axis, mut sink) = averaged();
    axis.move_to(0, T01).unwrap();
    assert!(axis.is_at_rest());
    axis.stop(1000).unwrap();
    assert!(axis.is_at_rest());
    axis.advance(&mut sink).unwrap();
    assert_eq!(sink.records, 0);
}

#[test]
fn orders_that_cannot_be_change_nothing() {
    let (mut axis, mut sink) = averaged();
    axis.set_ramps(Ramps::MovingAverage(0));
    assert_eq!(axis.move_to(10, T01), Err(PlanError::ZeroJerk));
    assert!(axis.is_at_rest());
    axis.set_ramps(Ramps::MovingAverage(JERK));
    axis.move_to(30_000, T01).unwrap();
    sink.follow(&axis);
    for _ in 0..3 {
        fly(&mut axis, &mut sink, 100);
        let none = Limits {
            velocity: Speed::ZERO,
            ..T01
        };
        assert_eq!(axis.move_to(-10, none), Err(PlanError::ZeroVelocity));
        assert_eq!(axis.stop(0), Err(PlanError::ZeroDeceleration));
        assert_eq!(axis.target(), 30_000);
    }
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 30_000);
}

#[test]
fn what_is_asked_of_the_axis_is_that_of_the_mean() {
    let (mut axis, mut sink) = averaged();
    axis.move_to(60_000, T01).unwrap();
    sink.follow(&axis);
    assert_eq!(axis.target(), 60_000);
    assert_eq!(axis.heading(), None);
    let time_slice = u64::from(axis.stepper.time_slice());
    while !axis.is_at_rest() {
        axis.advance(&mut sink).unwrap();
        if axis.is_at_rest() {
            break;
        }
        // Two time slices ahead, as linear motions are.
        assert!(sink.pending() <= 3 * time_slice + 100);
        assert_eq!(axis.target(), 60_000);
        let there = sink.curves[0].state_at(axis.horizon());
        let speed = there.velocity.speed(axis.clock);
        assert!(axis.committed_velocity().abs_diff(speed) <= Speed::from_bits(1 << 20));
        let heading = (there.velocity.bits() > 0).then_some(Direction::Forward);
        assert_eq!(axis.heading(), heading);
        assert_eq!(axis.is_ending(), axis.horizon() >= axis.plan.last_ramp());
        let played = sink.curves[0].state_at(sink.ticks - sink.pending());
        let demand = axis.demand(sink.pending());
        assert!((demand.position - played.position.whole_steps()).abs() <= 1);
        let off = demand.velocity.abs_diff(played.velocity.speed(axis.clock));
        assert!(off <= 70.into(), "{off:?}");
        sink.play(time_slice / 4);
    }
    assert_eq!(axis.target(), 60_000);
}

/// The mean of a velocity that is kept is that line, so a ramp is left at once.
#[test]
fn a_stop_in_a_cruise_is_felt_at_the_horizon() {
    let (mut axis, mut sink) = averaged();
    axis.ramp_to(80_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, 500);
    let (horizon, before) = (axis.horizon(), axis.committed_velocity());
    assert_eq!(before.whole(), 80_000);
    axis.stop(250_000).unwrap();
    sink.follow(&axis);
    let rest = axis.target();
    while axis.horizon() < horizon + ms(1) {
        axis.advance(&mut sink).unwrap();
        sink.play(u64::from(axis.stepper.time_slice() / 4));
    }
    // ½·j·t² with the jerk d / window, 0.83 steps/s in a millisecond.
    let lost = before.abs_diff(axis.committed_velocity());
    assert!(lost >= Speed::from_bits(3 << 30), "{lost:?}");
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, rest);
}

/// From an average to linear ramps position and velocity go on, and so they do back again.
#[test]
fn ramps_change_in_motion_without_a_jump() {
    let average = Ramps::MovingAverage(JERK);
    let limited = Ramps::limited(JERK);
    let others = [Ramps::Linear, Ramps::SinSquared]
        .into_iter()
        .chain(limited);
    for (first, then) in others.flat_map(|other| [(average, other), (other, average)]) {
        for milliseconds in [30, 120, 260, 400] {
            let (mut axis, mut sink) = axis(FAST);
            axis.set_ramps(first);
            axis.move_to(60_000, T01).unwrap();
            sink.follow(&axis);
            fly(&mut axis, &mut sink, milliseconds);
            let (horizon, was) = (axis.horizon(), axis.state_at(axis.horizon()));
            axis.set_ramps(then);
            axis.move_to(40_000, T01).unwrap();
            sink.follow(&axis);
            let is = axis.state_at(horizon);
            let apart = is.position.bits().abs_diff(was.position.bits());
            assert!(apart < 1 << 12, "{first:?}, {then:?}: {apart} Q32 steps");
            let apart = is.velocity.bits().abs_diff(was.velocity.bits());
            assert!(apart < 1 << 16, "{first:?}, {then:?}: {apart} Q56");
            run(&mut axis, &mut sink);
            assert_eq!(sink.position, 40_000, "{first:?}, {then:?}");
        }
    }
}

/// Stops, and is never faster on the way than it may be.
fn stop_within_velocity(axis: &mut Axis, sink: &mut Replay, deceleration: u32) {
    axis.stop(deceleration).unwrap();
    sink.follow(axis);
    while !axis.is_at_rest() {
        axis.advance(sink).unwrap();
        assert!(axis.committed_velocity().unsigned_abs() <= T01.velocity);
        sink.play(u64::from(axis.stepper.time_slice()) / 4);
    }
}

/// With a lower jerk the motor would go on to speed up for long: to more than a driver can follow.
#[test]
fn an_average_is_left_at_no_less_than_its_own_jerk() {
    let (mut axis, mut sink) = averaged();
    axis.move_to(60_000, T01).unwrap();
    fly(&mut axis, &mut sink, 60);
    axis.set_ramps(Ramps::limited(JERK / 100).unwrap_or(Ramps::SinSquared));
    stop_within_velocity(&mut axis, &mut sink, 500_000);
}

/// The window stays when the ramps become harder on the way, and the jerk does not.
#[test]
fn an_average_with_harder_ramps_is_left_at_their_jerk() {
    let (mut axis, mut sink) = averaged();
    axis.move_to(60_000, T01).unwrap();
    fly(&mut axis, &mut sink, 4);
    let hard = Limits {
        acceleration: T01.acceleration * 100,
        deceleration: T01.deceleration * 100,
        ..T01
    };
    axis.move_to(50_000, hard).unwrap();
    // In the midst of the ramp.
    while axis.committed_velocity().unsigned_abs() < Speed::per_second(90_000) {
        axis.advance(&mut sink).unwrap();
        sink.play(u64::from(axis.stepper.time_slice()) / 4);
    }
    axis.set_ramps(Ramps::limited(JERK).unwrap_or(Ramps::SinSquared));
    stop_within_velocity(&mut axis, &mut sink, hard.deceleration);
}

/// A quick stop with linear ramps begins where the mean is, and takes no window.
#[test]
fn a_linear_stop_leaves_the_average() {
    let (mut axis, mut sink) = averaged();
    axis.ramp_to(80_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, 500);
    axis.set_ramps(Ramps::Linear);
    let (horizon, there) = (axis.horizon(), axis.state_at(axis.horizon()));
    axis.stop(800_000).unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    assert!(sink.ticks - horizon <= ms(100) + u64::from(axis.stepper.time_slice()));
    // v² / 2d
    let distance = sink.position - there.position.whole_steps();
    assert!((distance - 4000).abs() <= 1, "{distance} steps");
}

#[test]
fn set_points_take_over_from_the_mean() {
    let (mut axis, mut sink) = averaged();
    axis.ramp_to(10_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, 500);
    let (from, state) = axis.path_end();
    assert_eq!(state, axis.state_at(axis.horizon()));
    let to = Position::from_steps(state.position.whole_steps() + 100);
    axis.follow(from + ms(10), to).unwrap();
    assert_eq!(axis.path_end().1.position, to);
    sink.curves.clear();
    fly(&mut axis, &mut sink, 5);
    assert!(axis.is_following());
    // And back, from where the path has come to.
    axis.move_to(0, T01).unwrap();
    assert!(!axis.is_following());
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 0);
}

#[test]
fn a_mean_that_is_cut_off_is_forgotten() {
    let (mut axis, mut sink) = averaged();
    axis.move_to(60_000, T01).unwrap();
    fly(&mut axis, &mut sink, 100);
    let stands = axis.abort();
    sink.clear();
    assert!(axis.is_at_rest());
    assert_eq!(axis.target(), stands);
    axis.set_position(7);
    axis.move_to(1000, T01).unwrap();
    sink.position = 7;
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 1000);
}

/// With a jerk for which no window is long enough the acceleration is less, and the jerk is kept.
#[test]
fn a_very_low_jerk_is_kept() {
    let (mut axis, _) = averaged();
    axis.set_ramps(Ramps::MovingAverage(1000));
    axis.move_to(100_000, T01).unwrap();
    // 2³⁰ ticks are 6.39 s, half of them for each ramp.
    let phase = axis.plan.phases().next().unwrap();
    assert_eq!(phase.acceleration(axis.clock), 3195);
}

/// So it is after another order in motion.
#[test]
fn a_very_low_jerk_is_kept_by_the_next_order() {
    let (mut axis, mut sink) = averaged();
    axis.set_ramps(Ramps::MovingAverage(1000));
    axis.move_to(1_000_000, T01).unwrap();
    fly(&mut axis, &mut sink, 1000);
    axis.move_to(900_000, T01).unwrap();
    let hardest = |axis: &Axis| {
        let phases = axis.plan.phases();
        phases
            .map(|phase| phase.acceleration(axis.clock).abs())
            .max()
    };
    assert_eq!(hardest(&axis), Some(3195));
    axis.stop(T01.deceleration).unwrap();
    assert_eq!(hardest(&axis), Some(3195));
}

/// Where the ramps become averages in motion, the window is that of the order that stays, whatever was tried before it.
#[test]
fn a_stop_that_is_tried_out_chooses_no_window() {
    let limits = Limits {
        acceleration: 5_000_000,
        deceleration: 50_000,
        ..T01
    };
    let limited = Ramps::limited(JERK * 100);
    for first in [Ramps::Linear, Ramps::SinSquared]
        .into_iter()
        .chain(limited)
    {
        let begin = |stops: u32| {
            let (mut axis, mut sink) = axis(FAST);
            axis.set_ramps(first);
            axis.move_to(60_000, limits).unwrap();
            fly(&mut axis, &mut sink, 10);
            axis.set_ramps(Ramps::MovingAverage(JERK));
            for _ in 0..stops {
                axis.stop(1000).unwrap();
            }
            axis.move_to(200_000, limits).unwrap();
            (axis, sink)
        };
        let (direct, _) = begin(0);
        let (mut axis, mut sink) = begin(3);
        assert_eq!(axis.average.window(), direct.average.window());
        assert_eq!(axis.plan.end(), direct.plan.end());
        sink.follow(&axis);
        let end = axis.plan.end().unwrap();
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, 200_000);
        assert!((sink.ticks - end).abs_diff(ms(1010)) <= ms(1010) / 512);
    }
}

/// A stop says nothing of the acceleration that comes back after it: that of the order before counts.
#[test]
fn a_stop_has_the_window_of_the_order_before_it() {
    let limits = Limits {
        acceleration: 5_000_000,
        deceleration: 50_000,
        ..T01
    };
    let (mut axis, mut sink) = axis(FAST);
    axis.move_to(60_000, limits).unwrap();
    fly(&mut axis, &mut sink, 10);
    axis.set_ramps(Ramps::MovingAverage(JERK));
    axis.stop(limits.deceleration).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, 50);
    axis.move_to(60_000, limits).unwrap();
    sink.follow(&axis);
    let window = u64::from(axis.average.window().ticks());
    assert!(window.abs_diff(ms(1010)) <= ms(1010) / 512);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position, 60_000);
}

/// Across the end of the span of positions, where they wrap, the mean wraps, too.
#[test]
fn a_velocity_goes_on_across_the_end_of_the_span() {
    let (mut axis, mut sink) = averaged();
    let begin = i64::from(i32::MAX) - 20_000;
    axis.set_position(begin);
    sink.position = begin;
    axis.ramp_to(100_000.into(), T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, 600);
    assert!(axis.committed_position() < 0);
    axis.stop(250_000).unwrap();
    sink.follow(&axis);
    run(&mut axis, &mut sink);
    assert_eq!(sink.position as i32, axis.target() as i32);
}

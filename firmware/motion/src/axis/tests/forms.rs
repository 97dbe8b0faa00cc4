//! The reference vectors and the sequences of retargeting with every form of ramp, judged by their pulses.

use super::averaged::fly;
use super::{FAST, HZ, Replay, axis, run};
use crate::axis::Axis;
use crate::vectors::{a_move, a_ramp, moves, ramps};
use crate::{Clock, Goal, Limits, Plan, Ramps, SignedSpeed, Speed, State, Ticks, Velocity};

const JERK: u32 = 5_000_000;

fn forms(jerk: u32) -> impl Iterator<Item = Ramps> {
    [Ramps::Linear, Ramps::SinSquared, Ramps::MovingAverage(jerk)]
        .into_iter()
        .chain(Ramps::limited(jerk))
}

const T01: Limits = Limits {
    velocity: Speed::per_second(100_000),
    acceleration: 500_000,
    deceleration: 500_000,
};

/// An axis on step 0 that moves at `v0`; what is planned for it has these ramps.
fn moving(v0: i32, ramps: Ramps) -> (Axis, Replay) {
    let (mut axis, mut sink) = axis(FAST);
    if v0 != 0 {
        let clock = Clock::new(HZ).unwrap();
        let velocity = Velocity::from_speed(clock, v0.into());
        let from = State {
            velocity,
            ..State::default()
        };
        let limits = Limits {
            velocity: u32::MAX.into(),
            ..T01
        };
        let goal = Goal::Velocity(v0.into());
        axis.plan = Plan::new(clock, 0, from, goal, limits, Ramps::Linear).unwrap();
    }
    axis.set_ramps(ramps);
    sink.tolerance = 1.1;
    (axis, sink)
}

fn ticks(seconds: f64) -> f64 {
    seconds * f64::from(HZ)
}

/// In steps.
fn steps(state: State) -> f64 {
    state.position.bits() as f64 / 2f64.powi(32)
}

/// Ends are rounded to ticks.
fn assert_end(form: Ramps, real: Ticks, wanted: f64) {
    let late = real as f64 - wanted;
    assert!(late.abs() <= 4.0, "{form:?}: {late} ticks late");
}

/// With the vectors that a motor makes in minutes; T09 and T10 are cruises of an hour.
fn short_moves() -> impl Iterator<Item = crate::vectors::Move> {
    let is_long = |name: &str| ["T09", "T10", "T19"].iter().any(|id| name.starts_with(id));
    moves().into_iter().filter(move |v| !is_long(&v.name))
}

#[test]
fn t_sine_ramps_make_every_move_in_the_time_of_the_linear_ones() {
    for v in short_moves() {
        let (mut axis, mut sink) = moving(v.v0, Ramps::SinSquared);
        let limits = Limits {
            velocity: v.velocity.into(),
            acceleration: v.acceleration,
            deceleration: v.deceleration,
        };
        axis.move_to(v.distance, limits).unwrap();
        sink.follow(&axis);
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, v.distance, "{}", v.name);
        let late = sink.ticks as f64 - ticks(v.duration);
        // A sin² ramp is up to two ticks longer, and rounded limits take a part in 10⁹.
        let slack = 1e-9 * ticks(v.duration);
        assert!(
            (-0.2 - slack..=4.0 + slack).contains(&late),
            "{}: {late}",
            v.name
        );
        if v.v0 == 0 {
            assert_eq!(sink.pulses, v.distance.unsigned_abs(), "{}", v.name);
        }
    }
}

#[test]
fn t_an_average_makes_every_move_and_comes_a_window_later() {
    for v in short_moves() {
        let jerk = v.acceleration.max(v.deceleration).saturating_mul(20);
        let (mut axis, mut sink) = moving(v.v0, Ramps::MovingAverage(jerk));
        let limits = Limits {
            velocity: v.velocity.into(),
            acceleration: v.acceleration,
            deceleration: v.deceleration,
        };
        axis.move_to(v.distance, limits).unwrap();
        let window = u64::from(axis.window());
        assert!((HZ / 20..=HZ / 9).contains(&axis.window()), "{}", v.name);
        let planned = axis.plan.end().unwrap();
        sink.follow(&axis);
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, v.distance, "{}", v.name);
        let form = Ramps::MovingAverage(jerk);
        assert_end(form, sink.ticks, (planned + window) as f64);
        if v.v0 == 0 {
            assert_end(form, sink.ticks, ticks(v.duration) + window as f64);
            assert_eq!(sink.pulses, v.distance.unsigned_abs(), "{}", v.name);
        }
    }
}

#[cfg(feature = "limited-jerk")]
#[test]
fn t_limited_jerk_makes_every_move() {
    for v in short_moves() {
        let jerk = v.acceleration.max(v.deceleration).saturating_mul(20);
        let (mut axis, mut sink) = moving(v.v0, Ramps::JerkLimited(jerk));
        let limits = Limits {
            velocity: v.velocity.into(),
            acceleration: v.acceleration,
            deceleration: v.deceleration,
        };
        axis.move_to(v.distance, limits).unwrap();
        let from = State {
            velocity: Velocity::from_speed(axis.clock, v.v0.into()),
            ..State::default()
        };
        let goal = Goal::Rest(v.distance);
        let planned = Plan::new(axis.clock, 0, from, goal, limits, Ramps::JerkLimited(jerk));
        let planned = planned.unwrap().end().unwrap();
        sink.follow(&axis);
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, v.distance, "{}", v.name);
        assert_eq!(sink.ticks, planned, "{}", v.name);
        // No faster than without a limit of the jerk, but for the distance that braking takes longer: then it turns, or passes the corner faster.
        if v.v0 == 0 {
            assert!(planned as f64 >= ticks(v.duration) - 1.0, "{}", v.name);
            assert_eq!(sink.pulses, v.distance.unsigned_abs(), "{}", v.name);
        }
    }
}

/// Seconds and distance of a jerk-limited ramp between two velocities of one sign.
fn smooth_ramp(from: f64, to: f64, most: f64, jerk: f64) -> (f64, f64) {
    let change = (to - from).abs();
    let time = if change >= most * most / jerk {
        change / most + most / jerk
    } else {
        2.0 * (change / jerk).sqrt()
    };
    (time, (from + to) / 2.0 * time)
}

fn check_ramp(id: &str) {
    let v = a_ramp(id);
    let (v0, v1) = (f64::from(v.v0), f64::from(v.v1));
    let (a, d) = (f64::from(v.acceleration), f64::from(v.deceleration));
    let jerk = v.acceleration.max(v.deceleration) * 20;
    for form in forms(jerk) {
        let (mut axis, mut sink) = moving(v.v0, form);
        let limits = Limits {
            velocity: u32::MAX.into(),
            acceleration: v.acceleration,
            deceleration: v.deceleration,
        };
        axis.ramp_to(v.v1.into(), limits).unwrap();
        sink.follow(&axis);
        let window = f64::from(axis.window()) / f64::from(HZ);
        // Until the velocity is there, and the distance to there.
        let (duration, distance) = match form {
            form if form.jerk().is_some() && v0 * v1 < 0.0 => {
                let slower = smooth_ramp(v0, 0.0, d, jerk.into());
                let faster = smooth_ramp(0.0, v1, a, jerk.into());
                (slower.0 + faster.0, slower.1 + faster.1)
            }
            form if form.jerk().is_some() => {
                let most = if v1.abs() > v0.abs() { a } else { d };
                smooth_ramp(v0, v1, most, jerk.into())
            }
            Ramps::MovingAverage(_) => (v.duration + window, v.distance + (v0 + v1) * window / 2.0),
            _ => (v.duration, v.distance),
        };
        let name = std::format!("{id}, {form:?}");
        let until = ticks(duration + 0.1) as Ticks;
        while axis.committed < until && !axis.is_at_rest() {
            axis.advance(&mut sink).unwrap();
            sink.play(axis.stepper.time_slice().into());
        }
        if v.v1 == 0 {
            assert_end(form, axis.committed, ticks(duration));
        }
        let seconds = axis.committed as f64 / f64::from(HZ);
        let wanted = distance + v1 * (seconds - duration);
        let off = sink.position as f64 - wanted;
        assert!(off.abs() <= 1.1, "{name}: {off} steps off");
        if v.v1 != 0 {
            let off = axis.committed_velocity().abs_diff(SignedSpeed::from(v.v1));
            // Limits are rounded down.
            assert!(off < Speed::from_bits(16), "{name}: {off:?} off");
            let before = ticks(duration * 0.98) as Ticks;
            let before = sink.curves[0].state_at(before).velocity.speed(axis.clock);
            let left = before.abs_diff(SignedSpeed::from(v.v1));
            assert!(left > Speed::from_bits(1 << 20), "{name}: there too early");
        }
    }
}

macro_rules! ramps_of_vectors {
    ($($name:ident = $id:literal),* $(,)?) => {
        $(#[test] fn $name() { check_ramp($id); })*
    };
}

ramps_of_vectors! {
    v01_train_of_each_form = "V01",
    v02_train_of_each_form = "V02",
    v03_train_of_each_form = "V03",
    v04_train_of_each_form = "V04",
    v05_train_of_each_form = "V05",
    v06_train_of_each_form = "V06",
}

#[test]
fn every_vector_is_played_with_each_form() {
    assert_eq!(short_moves().count(), 19);
    assert_eq!(ramps().len(), 6);
    assert_eq!(a_move("T19").v0, 0);
}

/// Where the next plan begins: at the commit horizon.
fn junction(axis: &Axis) -> (Ticks, f64) {
    let at = axis.horizon();
    (at, steps(axis.plan.state_at(at)))
}

/// Seconds and steps of a ramp from rest to 100,000 steps/s with T01, or back.
fn full_ramp(form: Ramps) -> (f64, f64) {
    if form.jerk().is_some() {
        (0.3, 15_000.0)
    } else {
        (0.2, 10_000.0)
    }
}

fn seconds_of_window(axis: &Axis) -> f64 {
    f64::from(axis.window()) / f64::from(HZ)
}

#[test]
fn r1_target_moved_behind_in_full_flight_with_each_form() {
    for form in forms(JERK) {
        let (mut axis, mut sink) = moving(0, form);
        axis.move_to(100_000, T01).unwrap();
        sink.follow(&axis);
        fly(&mut axis, &mut sink, 500);
        let (at, from) = junction(&axis);
        axis.move_to(20_000, T01).unwrap();
        sink.follow(&axis);
        let window = seconds_of_window(&axis);
        let mut highest = 0;
        while !axis.is_at_rest() {
            axis.advance(&mut sink).unwrap();
            sink.account(&axis);
            highest = highest.max(sink.position);
            sink.play(axis.stepper.time_slice().into());
        }
        assert_eq!(sink.position, 20_000, "{form:?}");
        let (time, distance) = full_ramp(form);
        let turn = from + distance;
        // The mean of a parabola is less than its peak.
        let rounded = 500_000.0 * window * window / 24.0;
        let off = highest as f64 - (turn - rounded);
        assert!(off.abs() <= 1.0, "{form:?}: turned {off} steps beyond");
        let back = turn - 20_000.0;
        assert!(back >= 2.0 * distance, "{form:?}: {back} steps back");
        let back = 2.0 * time + (back - 2.0 * distance) / 100_000.0;
        assert_end(form, sink.ticks, at as f64 + ticks(time + back + window));
    }
}

#[test]
fn r2_velocity_lowered_on_the_way_with_each_form() {
    for form in forms(JERK) {
        let (mut axis, mut sink) = moving(0, form);
        axis.move_to(100_000, T01).unwrap();
        sink.follow(&axis);
        fly(&mut axis, &mut sink, 450);
        let (at, from) = junction(&axis);
        let slower = Limits {
            velocity: 25_000.into(),
            ..T01
        };
        axis.move_to(100_000, slower).unwrap();
        sink.follow(&axis);
        let window = seconds_of_window(&axis);
        let (brake, stop) = if form.jerk().is_some() {
            let jerk = f64::from(JERK);
            (
                smooth_ramp(100_000.0, 25_000.0, 500_000.0, jerk),
                smooth_ramp(25_000.0, 0.0, 500_000.0, jerk),
            )
        } else {
            ((0.15, 9_375.0), (0.05, 625.0))
        };
        let cruise = (100_000.0 - from - brake.1 - stop.1) / 25_000.0;
        let slow = at + ticks(brake.0 + window) as Ticks + 2 * u64::from(axis.stepper.time_slice());
        while axis.committed < slow {
            let before = axis.committed_velocity();
            axis.advance(&mut sink).unwrap();
            let faster = axis.committed_velocity().bits() - before.bits();
            assert!(faster < 1 << 10, "{form:?}: it is {faster} faster");
            sink.play(axis.stepper.time_slice().into());
        }
        assert_eq!(axis.committed_velocity().whole(), 25_000, "{form:?}");
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, 100_000, "{form:?}");
        assert_eq!(sink.pulses, 100_000, "{form:?}");
        let seconds = brake.0 + cruise + stop.0 + window;
        assert_end(form, sink.ticks, at as f64 + ticks(seconds));
    }
}

#[test]
fn r3_halt_and_go_on_with_each_form() {
    for form in forms(JERK) {
        let (mut axis, mut sink) = moving(0, form);
        axis.ramp_to(100_000.into(), T01).unwrap();
        sink.follow(&axis);
        fly(&mut axis, &mut sink, 500);
        let (at, from) = junction(&axis);
        axis.stop(T01.deceleration).unwrap();
        sink.follow(&axis);
        let window = seconds_of_window(&axis);
        let (time, way) = full_ramp(form);
        run(&mut axis, &mut sink);
        let off = sink.position as f64 - (from + way);
        assert!(off.abs() <= 0.51, "{form:?}: {off} steps off");
        assert_end(form, sink.ticks, at as f64 + ticks(time + window));
        // And up again, from that step.
        let (begin, stands) = (axis.horizon(), sink.position);
        axis.ramp_to(100_000.into(), T01).unwrap();
        sink.follow(&axis);
        let up = time + seconds_of_window(&axis);
        fly(&mut axis, &mut sink, 500);
        let curve = sink.curves.last().unwrap();
        let early = curve.state_at(begin + ticks(up * 0.98) as Ticks);
        assert!(
            early.velocity.speed(axis.clock).whole() < 100_000,
            "{form:?}"
        );
        let there = curve.state_at(begin + ticks(up) as Ticks + 2);
        assert_eq!(
            there.velocity.speed(axis.clock).whole(),
            100_000,
            "{form:?}"
        );
        let climbed = steps(there) - stands as f64;
        assert!(
            (climbed - 50_000.0 * up).abs() <= 0.01,
            "{form:?}: {climbed}"
        );
    }
}

#[test]
fn r5_the_target_written_again_changes_nothing_with_each_form() {
    for form in forms(JERK) {
        let (mut axis, mut sink) = moving(0, form);
        axis.move_to(100_000, T01).unwrap();
        let window = u64::from(axis.window());
        let end = axis.plan.end().unwrap() + window;
        sink.follow(&axis);
        // In each phase, and more than once in some of them.
        for milliseconds in [50, 100, 1, 400, 300, 200, 50, 60] {
            fly(&mut axis, &mut sink, milliseconds);
            axis.move_to(100_000, T01).unwrap();
            sink.follow(&axis);
        }
        run(&mut axis, &mut sink);
        assert_eq!(sink.position, 100_000, "{form:?}");
        assert_eq!(sink.pulses, 100_000, "{form:?}");
        assert_end(form, sink.ticks, end as f64);
        let records = sink.records;
        for _ in 0..3 {
            axis.move_to(100_000, T01).unwrap();
            assert!(axis.is_at_rest(), "{form:?}");
            axis.advance(&mut sink).unwrap();
        }
        assert_eq!(sink.records, records, "{form:?}");
    }
}

//! The reference vectors T01 to T22 and V01 to V06 at three clocks, and the retarget sequences R1 to R3.

use super::{CLOCKS, Limits, Plan, clock, corners, per_second, state, steps};
use crate::Speed;
use crate::vectors::{Move, Ramp, a_move, a_ramp};

/// Late by at most this many ticks per corner that was rounded; never early, but for the rounding of the start velocity.
fn assert_duration(name: &str, plan_ticks: u64, ideal_ticks: f64) {
    let late = plan_ticks as f64 - ideal_ticks;
    // One part in 10⁹ is what the rounding of limits and start velocity may cost; the last digits of the vectors are rounded too.
    let slack = ideal_ticks * 1e-9 + 1e-3;
    assert!(late >= -slack, "{name}: {late} ticks early");
    assert!(
        late <= 1.0 + slack,
        "{name}: {late} ticks late of {ideal_ticks}"
    );
}

fn check_move(id: &str) {
    let v: Move = a_move(id);
    for hz in CLOCKS {
        let clock = clock(hz);
        // Only the move over the full span needs the full span.
        let origin = if v.distance > i64::from(i32::MAX) {
            i64::from(i32::MIN)
        } else {
            0
        };
        let limits = Limits {
            velocity: v.velocity.into(),
            acceleration: v.acceleration,
            deceleration: v.deceleration,
        };
        let start = 1_000_003;
        let from = state(clock, origin, v.v0);
        let plan = Plan::move_to(clock, start, from, origin + v.distance, limits).unwrap();
        let name = std::format!("{} at {hz} Hz", v.name);
        let rate = f64::from(hz);

        let end = plan.end().unwrap();
        assert_duration(&name, end - start, v.duration * rate);
        let landed = plan.state_at(end);
        assert_eq!(
            landed.position.bits(),
            (origin + v.distance) << 32,
            "{name}"
        );
        assert_eq!(landed.velocity.bits(), 0, "{name}");
        // Braking is anchored at the target, so at the start the last bits may differ.
        let begun = plan.state_at(start);
        assert!(
            (begun.position.bits() - from.position.bits()).abs() <= 2,
            "{name}"
        );
        assert!(
            (begun.velocity.bits() - from.velocity.bits()).abs() <= 2,
            "{name}"
        );

        let base = origin as f64;
        let mut peak = 0f64;
        for t in corners(&plan) {
            let now = plan.state_at(t);
            let x = steps(now) - base;
            // 2⁻³² steps is the resolution; what is left is the rounding of the start velocity.
            assert!(
                x >= v.lowest - 1e-5 && x <= v.highest + 1e-5,
                "{name}: at {x}"
            );
            peak = if per_second(clock, now).abs() > peak.abs() {
                per_second(clock, now)
            } else {
                peak
            };
        }
        let fastest = v.peak.abs().max(f64::from(v.v0).abs());
        assert!(peak.abs() <= fastest * (1.0 + 1e-8), "{name}: peak {peak}");
        // The peak of a triangle may fall between two ticks.
        let per_tick = f64::from(v.acceleration.max(v.deceleration)) / rate;
        assert!(
            peak.abs() >= fastest * (1.0 - 1e-8) - per_tick,
            "{name}: peak {peak}"
        );

        check_phases(&name, &plan, &v, hz);
    }
}

fn check_phases(name: &str, plan: &Plan, v: &Move, hz: u32) {
    let mut wanted = v.phases.clone();
    // Equal accelerations next to each other are one phase to the eye: braking, then speeding up the other way.
    let mut seconds_before = 0.0;
    let found: std::vec::Vec<_> = plan.phases().collect();
    // Roundings may leave phases of a few ticks that the ideal does not have, and limits are rounded down.
    for phase in &found {
        let at = (phase.start() - plan.start()) as f64 / f64::from(hz);
        let until = plan.next_corner(phase.start()).unwrap() - phase.start();
        let acceleration = phase.acceleration(clock(hz)) as f64;
        if (until as f64) < 1e-6 * v.duration * f64::from(hz) + 4.0 {
            continue;
        }
        let (seconds, ideal) = wanted.remove(0);
        assert!(
            (at - seconds_before).abs() <= 1e-5 * v.duration,
            "{name}: corner at {at}"
        );
        assert!(
            (acceleration - ideal).abs() <= 1.0,
            "{name}: {acceleration} for {ideal}"
        );
        seconds_before += seconds;
    }
    assert!(wanted.is_empty(), "{name}: missing {wanted:?}");
}

fn check_ramp(id: &str) {
    let v: Ramp = a_ramp(id);
    for hz in CLOCKS {
        let clock = clock(hz);
        let limits = Limits {
            velocity: u32::MAX.into(),
            acceleration: v.acceleration,
            deceleration: v.deceleration,
        };
        let start = 77;
        let from = state(clock, 5, v.v0);
        let plan = Plan::velocity(clock, start, from, v.v1.into(), limits).unwrap();
        let name = std::format!("{} at {hz} Hz", v.name);

        // The ramp is over where the cruise, or the rest, begins.
        let over = plan
            .end()
            .unwrap_or_else(|| plan.phases().last().unwrap().start());
        assert_duration(&name, over - start, v.duration * f64::from(hz));
        let there = plan.state_at(over);
        assert!(
            (per_second(clock, there) - f64::from(v.v1)).abs() < 1e-6,
            "{name}"
        );
        // Where the ramp is over falls between two ticks; at most one tick of cruise belongs to it.
        let tick = f64::from(v.v1).abs() / f64::from(hz);
        let way = steps(there) - 5.0;
        assert!(
            (way - v.distance).abs() <= tick + 1e-6,
            "{name}: {way} for {}",
            v.distance
        );
    }
}

macro_rules! vectors {
    ($check:ident: $($name:ident = $id:literal),* $(,)?) => {
        $(#[test] fn $name() { $check($id); })*
    };
}

vectors! { check_move:
    t01_long_symmetric_trapezoid = "T01",
    t02_triangle_symmetric = "T02",
    t03_trapezoid_with_half_the_deceleration = "T03",
    t04_triangle_with_four_times_the_deceleration = "T04",
    t05_cruise_of_exactly_nothing = "T05",
    t06_negative_direction_asymmetric = "T06",
    t07_one_step = "T07",
    t08_two_steps_at_the_least_acceleration = "T08",
    t09_full_i32_range = "T09",
    t10_full_span = "T10",
    t11_moving_towards_the_target = "T11",
    t12_at_the_limit_already = "T12",
    t13_moving_away_from_the_target = "T13",
    t14_target_inside_the_stopping_distance = "T14",
    t15_target_exactly_at_the_stopping_distance = "T15",
    t16_limit_lowered = "T16",
    t17_limit_lowered_with_no_cruise_left = "T17",
    t18_reversed_at_full_speed = "T18",
    t19_slow_astronomy_move = "T19",
    t20_stiff_ramp_within_a_control_period = "T20",
    t21_prime_numbers = "T21",
    t22_moving_backwards_to_a_target_behind = "T22",
}

vectors! { check_ramp:
    v01_speed_up_from_rest = "V01",
    v02_slow_down = "V02",
    v03_reverse = "V03",
    v04_halt = "V04",
    v05_quick_stop = "V05",
    v06_tiny_velocities = "V06",
}

#[test]
fn every_vector_has_its_test() {
    assert_eq!(crate::vectors::moves().len(), 22);
    assert_eq!(crate::vectors::ramps().len(), 6);
}

const HZ: u32 = 168_000_000;
const T01: Limits = Limits {
    velocity: Speed::per_second(100_000),
    acceleration: 500_000,
    deceleration: 500_000,
};

/// Ticks of so many microseconds.
fn us(microseconds: u64) -> u64 {
    microseconds * 168
}

#[test]
fn r1_target_moved_behind_in_full_flight() {
    let clock = clock(HZ);
    let first = Plan::move_to(clock, 0, state(clock, 0, 0), 100_000, T01).unwrap();
    let at = us(500_000);
    assert!((steps(first.state_at(at)) - 40_000.0).abs() < 1e-3);
    let second = first.then_move_to(clock, at, 20_000, T01).unwrap();
    assert_eq!(second.state_at(at), first.state_at(at));
    let turn = corners(&second)
        .map(|t| steps(second.state_at(t)))
        .fold(0.0, f64::max);
    assert!((turn - 50_000.0).abs() < 1e-3, "turned at {turn}");
    let end = second.end().unwrap();
    assert!(
        (end - at).abs_diff(us(700_000)) <= 2,
        "took {} ticks",
        end - at
    );
    assert_eq!(second.state_at(end), state(clock, 20_000, 0));
}

#[test]
fn r2_velocity_lowered_on_the_way() {
    let clock = clock(HZ);
    let first = Plan::move_to(clock, 0, state(clock, 0, 0), 100_000, T01).unwrap();
    let at = us(100_000);
    assert!((steps(first.state_at(at)) - 2_500.0).abs() < 1e-3);
    let slower = Limits {
        velocity: 25_000.into(),
        ..T01
    };
    let second = first.then_move_to(clock, at, 100_000, slower).unwrap();
    let cruise = second.phases().nth(1).unwrap().start();
    assert!((cruise - at).abs_diff(us(50_000)) <= 1);
    assert!((steps(second.state_at(cruise)) - 4_375.0).abs() < 1e-3);
    assert!(second.end().unwrap().abs_diff(us(4_000_000)) <= 2);
    assert_eq!(
        second.state_at(second.end().unwrap()),
        state(clock, 100_000, 0)
    );
}

#[test]
fn r3_halt_and_go_on() {
    let clock = clock(HZ);
    let up = Plan::velocity(clock, 0, state(clock, 0, 0), 100_000.into(), T01).unwrap();
    let halt_at = us(300_000);
    let halt = up.then_velocity(clock, halt_at, 0.into(), T01).unwrap();
    let stopped = halt.end().unwrap();
    assert!((stopped - halt_at).abs_diff(us(200_000)) <= 1);
    let way = steps(halt.state_at(stopped)) - steps(halt.state_at(halt_at));
    assert!((way - 10_000.0).abs() < 1e-3);
    let again = halt
        .then_velocity(clock, stopped, 100_000.into(), T01)
        .unwrap();
    let at_speed = again.phases().last().unwrap().start();
    assert!((at_speed - stopped).abs_diff(us(200_000)) <= 1);
}

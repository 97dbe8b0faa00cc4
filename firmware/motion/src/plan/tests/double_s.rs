//! The reference vectors J01 to J06: jerk-limited moves take no longer than the fastest there is.

use super::{CLOCKS, Goal, Limits, Plan, Ramps, clock, per_second, state};
use crate::vectors::smooth_moves;

fn check(id: &str) {
    let v = smooth_moves()
        .into_iter()
        .find(|v| v.name.starts_with(id))
        .unwrap();
    for hz in CLOCKS {
        let clock = clock(hz);
        let limits = Limits {
            velocity: v.velocity.into(),
            acceleration: v.acceleration,
            deceleration: v.acceleration,
        };
        let name = std::format!("{} at {hz} Hz", v.name);
        let goal = Goal::Rest(v.distance);
        let ramps = Ramps::JerkLimited(v.jerk);
        let plan = Plan::new(clock, 5, state(clock, 0, 0), goal, limits, ramps).unwrap();
        let end = plan.end().unwrap();
        let late = (end - 5) as f64 - v.duration * f64::from(hz);
        assert!((-0.1..=1.1).contains(&late), "{name}: {late} ticks late");
        assert_eq!(plan.state_at(end), state(clock, v.distance, 0), "{name}");
        let peak = plan
            .phases()
            .map(|phase| per_second(clock, plan.state_at(phase.start())));
        let peak = peak.fold(0.0, f64::max);
        let per_tick = v.peak_acceleration / f64::from(hz);
        assert!(
            (peak - v.peak).abs() <= per_tick + 1e-6 * v.peak,
            "{name}: {peak}"
        );
        let greatest = plan
            .phases()
            .map(|phase| phase.acceleration(clock))
            .max()
            .unwrap();
        assert!(
            (greatest as f64 - v.peak_acceleration).abs() <= 1.0 + 1e-5 * v.peak_acceleration,
            "{name}: {greatest}"
        );
    }
}

#[test]
fn j01_full_seven_segments() {
    check("J01");
}

#[test]
fn j02_acceleration_not_reached() {
    check("J02");
}

#[test]
fn j03_velocity_not_reached() {
    check("J03");
}

#[test]
fn j04_neither_reached() {
    check("J04");
}

#[test]
fn j05_boundary() {
    check("J05");
}

#[test]
fn j06_one_increment() {
    check("J06");
}

#[test]
fn every_vector_has_its_test() {
    assert_eq!(smooth_moves().len(), 6);
}

//! Where a set-point leads, and when it counts as reached.

use super::{HALT, IMMEDIATELY, RELATIVE};
use crate::testing::Rig;

#[test]
fn d20_relative_counts_from_the_previous_target() {
    let mut rig = Rig::enabled();
    rig.set_point(1_000, RELATIVE);
    assert_eq!(rig.rest(), 1_000);
    rig.set_point(-300, RELATIVE);
    assert_eq!(rig.rest(), 700);
    // On the way: from the target that is under way, not from where the motor happens to be.
    rig.set_point(2_000, RELATIVE);
    rig.ticks(50);
    rig.set_point(50, RELATIVE | IMMEDIATELY);
    assert_eq!(rig.rest(), 2_750);
    // One that waits: from the one before.
    rig.set_point(1_000, RELATIVE);
    rig.tick();
    rig.set_point(1_000, RELATIVE);
    rig.until("the second is done", |rig| rig.motor.position == 4_750);
    assert_eq!(rig.rest(), 4_750);
}

#[test]
fn m31_after_enabling_relative_counts_from_where_the_motor_stands() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.write(0x06);
    rig.ticks(3);
    let stopped = rig.motor.position;
    for controlword in [0x07, 0x0F] {
        rig.write(controlword);
        rig.tick();
    }
    rig.set_point(25, RELATIVE);
    assert_eq!(rig.rest(), stopped + 25);
}

#[test]
fn m32_a_relative_target_beyond_32_bits_is_cut() {
    let mut rig = Rig::enabled();
    rig.write(0x06);
    rig.tick();
    rig.motor.position = i64::from(i32::MAX) - 1_000;
    for controlword in [0x07, 0x0F] {
        rig.write(controlword);
        rig.tick();
    }
    rig.set_point(i32::MAX, RELATIVE);
    rig.tick();
    assert!(rig.limited() && rig.acknowledged());
    assert_eq!(rig.rest(), i64::from(i32::MAX));
    assert_eq!(rig.actuals().position_actual, i32::MAX);
    rig.set_point(-5, RELATIVE);
    assert_eq!(rig.rest(), i64::from(i32::MAX) - 5);
    assert!(!rig.limited());
}

#[test]
fn d21_a_target_outside_the_software_limits_is_cut() {
    let mut rig = Rig::enabled();
    rig.configuration.position_limits = (-200, 300);
    for (target, end) in [(301, 300), (i32::MIN, -200), (300, 300)] {
        rig.set_point(target, 0);
        rig.tick();
        assert_eq!(rig.limited(), i64::from(target) != end);
        assert_eq!(rig.rest(), end);
        rig.ticks(50);
        assert_eq!(
            rig.limited(),
            i64::from(target) != end,
            "as long as the set-point counts"
        );
    }
}

#[test]
fn m36_a_move_that_a_software_limit_ends_does_not_reach_its_target() {
    for window in [10, u32::MAX] {
        let mut rig = Rig::enabled();
        rig.configuration.position_limits = (-200, 300);
        rig.configuration.position_window = window;
        rig.set_point(301, 0);
        assert_eq!(rig.rest(), 300);
        rig.ticks(50);
        assert!(!rig.reached());
        rig.set_point(299, 0);
        assert_eq!(rig.rest(), 299);
        rig.ticks(50);
        assert!(rig.reached());
    }
}

#[test]
fn d21_limits_are_off_while_the_minimum_is_not_below_the_maximum() {
    for limits in [(0, 0), (10, -10)] {
        let mut rig = Rig::enabled();
        rig.configuration.position_limits = limits;
        rig.set_point(500, 0);
        assert_eq!(rig.rest(), 500);
        assert!(!rig.limited());
    }
}

#[test]
fn m34_the_window_in_all_its_values() {
    for (window, time, least) in [(0, 0, 1_000), (10, 0, 990), (u32::MAX, 5_000, 1_000)] {
        let mut rig = Rig::enabled();
        rig.configuration.position_window = window;
        rig.configuration.position_window_time = time;
        rig.set_point(1_000, 0);
        rig.tick();
        rig.until("target reached", Rig::reached);
        assert!(
            rig.seen >= least,
            "window {window}: reached at {}",
            rig.seen
        );
        rig.rest();
        assert!(rig.reached());
    }
}

#[test]
fn m33_a_target_where_the_motor_stands_is_taken_and_reached() {
    for window in [0, u32::MAX] {
        let mut rig = Rig::enabled();
        rig.configuration.position_window = window;
        rig.configuration.position_window_time = 0;
        for _ in 0..3 {
            rig.set_point(0, 0);
            rig.tick();
            assert!(rig.acknowledged() && !rig.reached());
            rig.ticks(2);
            assert!(rig.reached());
        }
    }
}

#[test]
fn m33_a_target_where_the_motor_stands_is_reached_after_the_window_time() {
    for window in [0, 10] {
        let mut rig = Rig::enabled();
        rig.configuration.position_window = window;
        rig.configuration.position_window_time = 25;
        for _ in 0..3 {
            rig.set_point(0, 0);
            rig.tick();
            assert!(rig.acknowledged());
            for millisecond in 0..25 {
                assert!(!rig.reached(), "after {millisecond} ms");
                rig.tick();
            }
            assert!(rig.reached());
            rig.ticks(50);
            assert!(rig.reached());
        }
    }
}

#[test]
fn d22_the_window_time_counts_from_the_set_point() {
    let mut rig = Rig::enabled();
    rig.configuration.position_window_time = 25;
    rig.post();
    rig.ticks(50);
    assert!(rig.reached());
    rig.set_point(0, 0);
    rig.tick();
    let ticks = rig.until("target reached", Rig::reached);
    assert!((24..=26).contains(&ticks), "{ticks} ms");
}

#[test]
fn m34_switched_off_and_on_the_window_time_starts_anew() {
    let mut rig = Rig::enabled();
    rig.configuration.position_window_time = 100;
    rig.position_tolerance = 100;
    rig.post();
    rig.ticks(110);
    assert!(rig.reached());
    rig.configuration.position_window = u32::MAX;
    rig.post();
    rig.motor.position += 50;
    rig.ticks(20);
    rig.motor.position -= 50;
    rig.configuration.position_window = 10;
    rig.post();
    rig.tick();
    let ticks = rig.until("target reached", Rig::reached);
    assert!((99..=101).contains(&ticks), "{ticks} ms");
}

#[test]
fn m34_the_window_is_looked_at_during_halt() {
    let mut rig = Rig::enabled();
    rig.configuration.position_window_time = 100;
    rig.position_tolerance = 100;
    rig.post();
    rig.ticks(110);
    assert!(rig.reached());
    rig.write(0x0F | HALT);
    rig.tick();
    rig.motor.position += 50;
    rig.ticks(20);
    rig.motor.position -= 50;
    rig.write(0x0F);
    rig.tick();
    let ticks = rig.until("target reached", Rig::reached);
    assert!((99..=101).contains(&ticks), "{ticks} ms");
}

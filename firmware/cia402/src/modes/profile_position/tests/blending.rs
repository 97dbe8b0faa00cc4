//! Set-points that are passed: bit 9, end velocity 6082h; and what relative ones count from.

use crate::controlword::{CHANGE_IMMEDIATELY, CHANGE_ON_SET_POINT, RELATIVE};
use crate::testing::Rig;
use motion::Ramps;

/// The slowest the motor gets until it has come to `position`, in steps per tick.
fn slowest_until(rig: &mut Rig, position: i64) -> i64 {
    let mut slowest = i64::MAX;
    while rig.motor.position < position {
        slowest = slowest.min(rig.speed());
    }
    slowest
}

#[test]
fn m30_with_bit_9_the_first_target_is_passed_at_speed() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(200);
    rig.commands.profile_velocity = 4_000.into();
    rig.set_point(8_000, CHANGE_ON_SET_POINT);
    rig.tick();
    assert!(rig.acknowledged());
    rig.write(0x0F | CHANGE_ON_SET_POINT);
    assert!(slowest_until(&mut rig, 4_950) >= 9, "6081h of the first");
    assert!(!rig.reached(), "passing is not reaching");
    assert!(slowest_until(&mut rig, 7_500) >= 3, "6081h of the second");
    assert!(!rig.acknowledged(), "the buffer is free");
    assert_eq!(rig.rest(), 8_000);
    rig.ticks(15);
    assert!(rig.reached());
}

#[test]
fn without_bit_9_the_motor_stops_at_the_first_target() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(200);
    rig.set_point(8_000, 0);
    rig.tick();
    rig.write(0x0F);
    assert_eq!(slowest_until(&mut rig, 7_500), 0);
    assert_eq!(rig.rest(), 8_000);
}

#[test]
fn m30_the_second_target_bounds_the_speed_at_the_first() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(200);
    // 5,000 steps/s can just be stopped in 125 steps; some of it is kept in reserve.
    rig.set_point(5_125, CHANGE_ON_SET_POINT);
    rig.tick();
    rig.until("the first target", |rig| rig.motor.position >= 4_995);
    let speed = rig.speed();
    assert!((4..=5).contains(&speed), "{speed}");
    assert_eq!(rig.rest(), 5_125);
}

#[test]
fn m30_a_way_back_is_not_blended() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(200);
    rig.set_point(1_000, CHANGE_ON_SET_POINT);
    let mut highest = 0;
    rig.until("turned round", |rig| rig.motor.position == 5_000);
    for _ in 0..100 {
        rig.tick();
        highest = highest.max(rig.motor.position);
    }
    assert_eq!(highest, 5_000);
    assert_eq!(rig.rest(), 1_000);
}

#[test]
fn m30_halt_keeps_the_blending() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(200);
    rig.set_point(9_000, CHANGE_ON_SET_POINT);
    rig.tick();
    rig.write(0x10F | CHANGE_ON_SET_POINT);
    rig.rest();
    assert!(rig.reached(), "at rest");
    rig.write(0x0F | CHANGE_ON_SET_POINT);
    rig.until("speed", |rig| rig.actuals().velocity_demand == 10_000);
    assert!(slowest_until(&mut rig, 8_000) >= 9);
    assert_eq!(rig.rest(), 9_000);
}

#[test]
fn an_end_velocity_is_kept_behind_the_target() {
    let mut rig = Rig::enabled();
    rig.commands.end_velocity = 2_000.into();
    rig.set_point(5_000, 0);
    rig.until("passed", |rig| rig.motor.position >= 4_990);
    assert!(!rig.reached());
    rig.ticks(20);
    assert!(rig.reached());
    assert_eq!(rig.actuals().velocity_demand, 2_000);
    rig.ticks(500);
    assert_eq!(rig.speed(), 2);
    rig.commands.end_velocity = 0.into();
    rig.set_point(100, 0);
    assert_eq!(rig.rest(), 100);
}

#[test]
fn an_end_velocity_ends_at_the_software_limit() {
    let mut rig = Rig::enabled();
    rig.configuration.position_limits = (-6_000, 6_000);
    rig.commands.end_velocity = 10_000.into();
    for (target, limit) in [(5_900, 6_000), (-5_900, -6_000)] {
        rig.set_point(target, 0);
        assert_eq!(rig.rest(), limit);
        assert!(rig.limited());
    }
    rig.set_point(6_000, 0);
    assert_eq!(rig.rest(), 6_000);
    rig.ticks(15);
    assert!(rig.reached() && rig.limited(), "reached, without 6082h");
}

#[test]
fn m31_relative_set_points_count_from_what_60f2h_says() {
    for option in [0, 1, 2] {
        let mut rig = Rig::enabled();
        rig.set_point(10_000, 0);
        rig.ticks(300);
        // The motor has lost seven steps.
        rig.motor.position -= 7;
        rig.tick();
        rig.commands.positioning_option = option;
        rig.set_point(5_000, CHANGE_IMMEDIATELY | RELATIVE);
        let taken = rig.tick();
        let base = match option {
            0 => 10_000,
            1 => taken.position_demand,
            _ => taken.position_actual,
        };
        assert_eq!(rig.rest() + 7, i64::from(base) + 5_000, "60F2h = {option}");
    }
}

/// A drive that is to move fast, on the mean of its plans.
fn averaged(acceleration: u32, jerk: u32) -> Rig {
    let mut rig = Rig::enabled();
    rig.configuration.profile.ramps = Ramps::MovingAverage(jerk);
    rig.commands.profile_velocity = 100_000.into();
    rig.commands.profile_acceleration = acceleration;
    rig.commands.profile_deceleration = acceleration;
    rig
}

#[test]
fn an_end_velocity_of_a_mean_ends_at_the_software_limit_without_a_harder_ramp() {
    for room in [200, 1_000, 5_000] {
        let mut rig = averaged(500_000, 5_000_000);
        rig.configuration.position_limits = (-1, 60_000 + room);
        rig.commands.end_velocity = 100_000.into();
        rig.set_point(60_000, 0);
        rig.until("passed", |rig| rig.motor.position > 60_000);
        let mut ways = std::vec::Vec::new();
        while rig.actuals().is_moving {
            let position = rig.motor.position;
            rig.ticks(10);
            ways.push(rig.motor.position - position);
        }
        assert_eq!(rig.motor.position, i64::from(60_000 + room));
        // 5,000,000 steps/s³ change a distance of 10 ms by five steps; whole steps add up to four.
        for distance in ways.windows(3) {
            let change = distance[2] - 2 * distance[1] + distance[0];
            assert!(change.abs() < 10, "{room}: {distance:?}");
        }
    }
}

#[test]
fn m30_a_mean_is_blended_with_the_window_that_it_has() {
    let mut rig = averaged(1_000_000, 10_000_000);
    rig.set_point(50_000, 0);
    rig.ticks(100);
    rig.commands.profile_acceleration = 100_000;
    rig.commands.profile_deceleration = 100_000;
    rig.set_point(60_000, CHANGE_ON_SET_POINT);
    rig.tick();
    rig.write(0x0F | CHANGE_ON_SET_POINT);
    let mut farthest = 0;
    while rig.actuals().is_moving {
        rig.tick();
        farthest = farthest.max(rig.motor.position);
    }
    assert_eq!((farthest, rig.motor.position), (60_000, 60_000));
}

//! The modes of position and velocity on a loop, changes between them and to torque, and limits of the torque in each.

use sim::plant::AXES;
use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED, SWITCHED_ON, ServoBench};

use super::{enabled, hold, torque};

#[test]
fn m45_a_move_ends_where_it_should_on_each_axis() {
    for axis in AXES {
        let mut drive = enabled(axis.name, 1);
        for target in [20_000, -3_000, 7] {
            drive.begin_move(target);
            drive.reaches_target(3_000);
            drive.run_millis(100);
            let away = drive.position() - i64::from(target);
            assert!(away.abs() <= 1, "{}: {away} from {target}", axis.name);
            let truly = drive.plant().angle() / std::f64::consts::TAU
                * f64::from(axis.plant.sensors.counts)
                - f64::from(target);
            assert!((-1.5..2.5).contains(&truly), "{}: {truly}", axis.name);
        }
    }
}

#[test]
fn m45_a_load_that_comes_as_soon_as_the_drive_is_enabled_is_held() {
    let mut drive = ServoBench::on_axis("servo_100w");
    drive.write_u8(0x6060, 0, 1);
    drive.enable();
    drive.plant().load_torque = 0.15;
    drive.run_millis(200);
    assert!(drive.position().abs() <= 1, "{}", drive.position());
    assert_eq!(drive.read_i32(0x6062, 0), 0);
}

#[test]
fn m45_what_was_given_ahead_of_a_ramp_ends_with_it() {
    let mut drive = enabled("servo_100w", 1);
    drive.write_u32(0x6083, 0, 40_000_000);
    drive.write_u32(0x6084, 0, 40_000_000);
    drive.begin_move(100);
    drive.run_millis(8);
    let mut furthest = 0;
    for _ in 0..40 {
        drive.run_millis(1);
        furthest = furthest.max((drive.position() - 100).abs());
    }
    assert!(furthest <= 5, "{furthest} counts away behind the ramp");
    assert!((drive.position() - 100).abs() <= 1);
}

#[test]
fn m45_a_velocity_is_kept_under_a_load() {
    let mut drive = enabled("servo_100w", 3);
    drive.write_i32(0x60FF, 0, 200_000);
    drive.run_millis(400);
    drive.plant().load_torque = 0.2;
    drive.run_millis(300);
    let before = drive.position();
    drive.run_millis(100);
    let way = drive.position() - before;
    assert!((way - 20_000).abs() <= 3, "{way}");
    let actual = torque(&mut drive);
    assert!((600..=700).contains(&actual), "{actual}");
}

#[test]
fn m45_homing_by_the_present_position() {
    let mut drive = enabled("servo_100w", 6);
    drive.write_i32(0x607C, 0, 500);
    drive.write_i8(0x6098, 0, 37);
    drive.command(0x1F);
    drive.run_millis(50);
    assert_eq!(drive.statusword() & 0x3400, 0x1400);
    assert_eq!(drive.read_i32(0x6064, 0), 500);
    // Home is called otherwise; the loop holds where it was.
    drive.run_millis(100);
    assert_eq!(drive.read_i32(0x6064, 0), 500);
    assert_eq!(drive.position(), 0);
}

#[test]
fn m45_modes_change_in_flight_without_a_bump() {
    let mut drive = enabled("servo_100w", 3);
    drive.write_i32(0x60FF, 0, 100_000);
    drive.run_millis(300);
    let mut most = 0;
    for (mode, velocity) in [(4, None), (3, Some(100_000)), (4, None), (3, Some(50_000))] {
        if let Some(velocity) = velocity {
            drive.write_i32(0x60FF, 0, velocity);
        }
        drive.write_u8(0x6060, 0, mode);
        for _ in 0..30 {
            drive.run_millis(1);
            most = most.max(torque(&mut drive).abs());
        }
        assert_eq!(drive.read_i8(0x6061, 0), mode as i8);
    }
    // What the ramps take, and friction; not what a jump would.
    assert!(most < 600, "{most}");
}

#[test]
fn m45_each_mode_takes_over_from_each_in_flight() {
    const MODES: [u8; 9] = [1, 2, 3, 4, 6, 7, 8, 9, 10];
    for name in ["nema17", "servo_100w"] {
        for from in MODES {
            let mut drive = enabled(name, 3);
            drive.write_u32(0x6065, 0, u32::MAX);
            drive.write_i32(0x60FF, 0, 20_000);
            drive.run_millis(200);
            let mut most = 0;
            for to in MODES {
                for mode in [from, to] {
                    drive.write_u8(0x6060, 0, mode);
                    let mut waited = 0;
                    while waited < 40 || drive.read_i8(0x6061, 0) != mode as i8 {
                        drive.run_micros(250);
                        let now = drive.axis().actuals().torque.actual;
                        most = most.max(now.abs());
                        waited += 1;
                        assert!(waited < 4_000, "{name}: mode {mode} after {from}");
                    }
                }
                drive.reaches(OPERATION_ENABLED, 1);
            }
            // What the ramps take, and friction; not what a jump would.
            assert!(most < 700, "{name}, from {from}: {most}");
        }
    }
}

#[test]
fn m45_a_limit_of_the_torque_holds_in_profile_position() {
    let mut drive = enabled("servo_100w", 1);
    hold(&mut drive);
    drive.write_u32(0x6065, 0, u32::MAX);
    drive.write_u16(0x60E0, 0, 60);
    drive.begin_move(2_000);
    drive.run_millis(100);
    assert!(torque(&mut drive) <= 61);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.reaches(OPERATION_ENABLED, 1);
    drive.plant().load_brake = 0.0;
    drive.write_u16(0x60E0, 0, 1_000);
    drive.run_millis(500);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    assert!((drive.position() - 2_000).abs() <= 1);
}

#[test]
fn m45_a_motor_without_power_has_no_torque() {
    let mut drive = enabled("servo_400w", 4);
    hold(&mut drive);
    drive.write_i16(0x6071, 0, 300);
    drive.run_millis(400);
    assert_eq!(torque(&mut drive), 300);
    drive.command(0x07);
    drive.reaches(SWITCHED_ON, 500);
    drive.run_millis(20);
    assert_eq!(torque(&mut drive), 0);
    assert!(drive.plant().current()[1].abs() < 1e-6);
}

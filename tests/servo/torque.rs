//! Profile torque.

use sim::plant::AXES;
use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED, ServoBench, TARGET_REACHED};

use super::{enable, enabled, hold, torque};

#[test]
fn m45_each_ready_axis_offers_torque_and_gives_it() {
    for axis in AXES {
        let mut drive = enabled(axis.name, 4);
        let modes = drive.read_u32(0x6502, 0);
        assert_eq!(modes & 0x208, 0x208, "{}", axis.name);
        hold(&mut drive);
        drive.write_i16(0x6071, 0, 100);
        drive.run_millis(250);
        let current = drive.plant().current()[1];
        let actual = torque(&mut drive);
        assert_eq!(actual, 100, "{}", axis.name);
        let truly = current / f64::from(axis.rated_current) * 1e3;
        assert!((99.0..101.0).contains(&truly), "{}: {truly}", axis.name);
        assert_eq!(drive.read_i16(0x6078, 0), 100);
        assert_ne!(drive.statusword() & TARGET_REACHED, 0);
        drive.write_i16(0x6071, 0, -100);
        drive.run_millis(450);
        assert_eq!(torque(&mut drive), -100, "{}", axis.name);
        drive.reaches(OPERATION_ENABLED, 1);
    }
}

#[test]
fn m45_the_demand_goes_to_the_target_by_its_slope() {
    let mut drive = enabled("servo_100w", 4);
    hold(&mut drive);
    drive.write_u32(0x6087, 0, 500);
    drive.write_i16(0x6071, 0, 400);
    drive.run_millis(100);
    let begin = drive.read_i16(0x6074, 0);
    drive.run_millis(400);
    let grown = drive.read_i16(0x6074, 0) - begin;
    assert!((198..=202).contains(&grown), "{grown}");
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.run_millis(400);
    assert_eq!(drive.read_i16(0x6074, 0), 400);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
}

#[test]
fn m45_the_least_of_the_limits_holds_in_each_direction() {
    let mut drive = enabled("servo_100w", 4);
    hold(&mut drive);
    drive.write_u32(0x6087, 0, 100_000);
    for (positive, negative, most, current) in [
        (300, 200, 1_000, 1_000),
        (900, 900, 250, 1_000),
        (900, 900, 1_000, 150),
    ] {
        drive.write_u16(0x60E0, 0, positive);
        drive.write_u16(0x60E1, 0, negative);
        drive.write_u16(0x6072, 0, most);
        drive.write_u16(0x6073, 0, current);
        for (target, limit) in [(800_i16, positive), (-800, negative)] {
            drive.write_i16(0x6071, 0, target);
            drive.run_millis(60);
            let least = limit.min(most).min(current) as i16;
            let actual = torque(&mut drive);
            assert!((actual.abs() - least).abs() <= 1, "{actual} of {least}");
            assert_eq!(actual.signum(), target.signum());
            assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
        }
        drive.write_i16(0x6071, 0, 100);
        drive.run_millis(60);
        assert_eq!(torque(&mut drive), 100);
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    }
}

#[test]
fn m45_a_torque_without_a_load_ends_at_6080h() {
    let mut drive = enabled("servo_100w", 4);
    drive.write_u32(0x6080, 0, 600);
    for sign in [1, -1] {
        drive.write_i16(0x6071, 0, 200 * sign);
        drive.run_millis(600);
        let velocity = drive.read_i32(0x606C, 0) * i32::from(sign);
        // 600 turns a minute of 10,000 counts.
        assert!((95_000..=103_000).contains(&velocity), "{velocity}");
    }
}

#[test]
fn m45_halt_stops_the_motor_and_its_end_begins_anew() {
    let mut drive = enabled("servo_100w", 4);
    drive.write_i16(0x6071, 0, 100);
    drive.run_millis(200);
    assert!(drive.read_i32(0x606C, 0) > 50_000);
    drive.command(0x10F);
    drive.run_millis(20);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.run_millis(1_500);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    let stands = drive.position();
    drive.run_millis(50);
    assert!((drive.position() - stands).abs() <= 2);
    drive.command(0x0F);
    drive.run_millis(300);
    assert!(drive.read_i32(0x606C, 0) > 50_000, "it goes on");
}

#[test]
fn m45_a_software_limit_holds_in_profile_torque() {
    let mut drive = enabled("servo_100w", 4);
    drive.write_i32(0x607D, 1, -50_000);
    drive.write_i32(0x607D, 2, 30_000);
    for (target, limit) in [(150_i16, 30_000), (-150, -50_000)] {
        drive.write_i16(0x6071, 0, target);
        let mut farthest = 0;
        for _ in 0..150 {
            drive.run_millis(10);
            farthest = farthest.max(drive.position() * i64::from(target.signum()));
        }
        let beyond = farthest - i64::from(limit * i32::from(target.signum()));
        assert!((-1..=4).contains(&beyond), "{beyond} beyond {limit}");
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    }
}

#[test]
fn m45_the_profile_of_the_slope_is_linear() {
    let mut drive = enabled("servo_100w", 4);
    drive.refused("604 [8] 2B 88 60 00 01 00 00 00", 0x0609_0030);
    drive.write_i16(0x6088, 0, 0);
}

#[test]
fn m45_a_quick_stop_and_what_leaves_operation_brake_a_held_torque_on_their_ramps() {
    // Quick stop by 605Ah, shutdown by 605Bh, disable operation by 605Ch, a fault by 605Eh: the ramps of 6085h, and of 6084h.
    for (controlword, option, ramp) in [
        (Some(0x0B), None, 2_000_000.0),
        (Some(0x06), Some(0x605B), 1_000_000.0),
        (Some(0x07), Some(0x605C), 1_000_000.0),
        (None, Some(0x605E), 1_000_000.0),
    ] {
        for mode in [4, 10] {
            let mut drive = ServoBench::on_axis("servo_100w");
            drive.write_u32(0x6084, 0, 1_000_000);
            if let Some(option) = option {
                drive.write_i16(option, 0, 1);
            }
            // A set-point that does not come is the one before.
            drive.write_u8(0x2051, 2, 2);
            let mut drive = enable(drive, mode);
            drive.write_i16(0x6071, 0, 150);
            drive.run_millis(300);
            let (velocity, begin) = (drive.read_i32(0x606C, 0), drive.position());
            assert!(velocity > 100_000, "mode {mode}: {velocity}");
            match controlword {
                Some(controlword) => drive.command(controlword),
                None => drive.set_fault(Some(0x8611)),
            }
            drive.run_millis(1_500);
            let way = (drive.position() - begin) as f64;
            let wanted = f64::from(velocity).powi(2) / 2.0 / ramp;
            // Some ticks until it begins.
            let most = wanted * 1.1 + f64::from(velocity) * 0.01;
            assert!(
                (wanted * 0.95..most).contains(&way),
                "{mode}, {option:?}: {way} of {wanted}"
            );
            assert!(!OPERATION_ENABLED.is_shown_by(drive.statusword()));
            assert_eq!(torque(&mut drive), 0);
        }
    }
}

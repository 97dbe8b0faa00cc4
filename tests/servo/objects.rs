//! What thousandths are of, what is told of the bus, and the modes that the other files do not enter.

use sim::plant::{AXES, Axis};
use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED, ServoBench};

use super::cyclic::{bytes, period};
use super::{enable, enabled, hold, torque};

#[test]
fn m45_thousandths_are_of_6075h_and_6076h() {
    // 4 A and 320 mN·m are what the axis has by itself.
    for (rated_current, rated_torque, share) in [(4_000, 320, 1.0), (4_000, 640, 2.0)] {
        let mut drive = ServoBench::on_axis("servo_100w");
        drive.write_u32(0x6075, 0, rated_current);
        drive.write_u32(0x6076, 0, rated_torque);
        let mut drive = enable(drive, 4);
        hold(&mut drive);
        drive.write_i16(0x6071, 0, 200);
        drive.run_millis(400);
        let actual = torque(&mut drive);
        assert!((199..=201).contains(&actual), "{actual}");
        let current = drive.plant().current()[1];
        assert!((current - 0.8 * share).abs() < 0.02, "{current} A");
        let told = f64::from(drive.read_i16(0x6078, 0));
        assert!((told - 200.0 * share).abs() < 3.0, "6078h is {told}");
    }
}

#[test]
fn m45_thousandths_are_of_the_motor_that_is_there_unless_a_master_says_more() {
    for axis in AXES {
        let rated = (
            (axis.rated_current * 1e3).round() as u32,
            axis.rated_torque(),
        );
        let mut drive = ServoBench::on(Axis::bare_servo(&axis));
        let told = [0x6075, 0x6076].map(|index| drive.read_u32(index, 0));
        assert_eq!(told, [rated.0, rated.1], "{}", axis.name);
        let mut drive = enable(drive, 4);
        hold(&mut drive);
        drive.write_i16(0x6071, 0, 100);
        drive.run_millis(300);
        let share = drive.plant().current()[1] / f64::from(axis.rated_current);
        assert!((share - 0.1).abs() < 0.002, "{}: {share}", axis.name);
        assert!((torque(&mut drive) - 100).abs() <= 1, "{}", axis.name);
    }
}

#[test]
fn m45_the_voltage_of_the_bus_is_told() {
    let mut drive = enabled("servo_400w", 4);
    hold(&mut drive);
    assert!((47_900..=48_100).contains(&drive.read_u32(0x6079, 0)));
    // What comes back from somewhere is there for some milliseconds.
    drive.plant().charge_bus(50.0);
    let mut most = 0;
    for _ in 0..20 {
        drive.run_millis(1);
        most = most.max(drive.read_u32(0x6079, 0));
    }
    assert!((48_200..=50_000).contains(&most), "{most} mV");
}

#[test]
fn m45_the_velocity_mode_on_a_loop() {
    for name in ["nema17", "servo_100w"] {
        let mut drive = ServoBench::on_axis(name);
        for ramp in [0x6048, 0x6049] {
            drive.write_u32(ramp, 1, 40_000);
        }
        let mut drive = enable(drive, 2);
        drive.write_i16(0x6042, 0, 8_000);
        drive.command(0x7F);
        drive.run_millis(800);
        let [demand, actual] = [0x6043, 0x6044].map(|index| drive.read_i16(index, 0));
        assert_eq!(demand, 8_000, "{name}");
        assert!((actual - 8_000).abs() <= 200, "{name}: {actual}");
        drive.write_i16(0x6042, 0, -8_000);
        drive.run_millis(1_200);
        let actual = drive.read_i16(0x6044, 0);
        assert!((actual + 8_000).abs() <= 200, "{name}: {actual}");
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
        drive.reaches(OPERATION_ENABLED, 1);
    }
}

#[test]
fn m45_interpolated_position_on_a_loop() {
    for name in ["nema17", "servo_100w"] {
        let mut drive = ServoBench::on_axis(name);
        drive.map_pdo(0x1401, &[0x60C1_0120], 1);
        drive.write_u8(0x60C2, 1, 4);
        let mut drive = enable(drive, 7);
        drive.command(0x1F);
        let mut target = 0_i32;
        for step in 0..60 {
            target += if step < 30 { step } else { 60 - step };
            period(&mut drive, Some(&bytes(&target.to_le_bytes())));
        }
        for _ in 0..40 {
            period(&mut drive, Some(&bytes(&target.to_le_bytes())));
        }
        let away = drive.position() - i64::from(target);
        assert!(away.abs() <= 1, "{name}: {away} from {target}");
        drive.reaches(OPERATION_ENABLED, 1);
    }
}

#[test]
fn m45_velocities_in_each_period_are_kept_under_a_load() {
    for name in ["nema17", "servo_100w"] {
        let mut drive = ServoBench::on_axis(name);
        drive.map_pdo(0x1401, &[0x60FF_0020], 1);
        drive.write_u8(0x60C2, 1, 4);
        let mut drive = enable(drive, 9);
        for step in 0..60 {
            period(&mut drive, Some(&bytes(&(200_i32 * step).to_le_bytes())));
        }
        drive.plant().load_torque = 0.03;
        for _ in 0..60 {
            period(&mut drive, Some(&bytes(&12_000_i32.to_le_bytes())));
        }
        let before = drive.position();
        for _ in 0..50 {
            period(&mut drive, Some(&bytes(&12_000_i32.to_le_bytes())));
        }
        let way = drive.position() - before;
        assert!((way - 2_400).abs() <= 3, "{name}: {way}");
    }
}

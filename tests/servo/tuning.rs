//! The drive measures its motor when a master says so, and goes by other gains and other data of the motor.

use sim::plant::{AXES, ServoAxisData};
use tests::drive::{OPERATION_ENABLED, SWITCHED_ON, ServoBench};

use super::{enabled, hold, torque};

/// 20C1h:1.
const WAITS: u8 = 1;
const WINDING: u8 = 2;
const FIELD: u8 = 3;
const EXCITES: u8 = 5;
const DONE: u8 = 6;
const FAILED: u8 = 7;

fn order(drive: &mut ServoBench, command: u8) {
    assert_eq!(drive.read_u8(0x20C0, 1), 0, "nothing is under way");
    drive.write_u8(0x20C0, 1, command);
    drive.run_millis(2);
}

fn state(drive: &mut ServoBench) -> u8 {
    drive.read_u8(0x20C1, 1)
}

fn failure(drive: &mut ServoBench) -> u8 {
    drive.read_u8(0x20C1, 2)
}

/// Waits for a state of the measurement.
#[track_caller]
fn comes_to(drive: &mut ServoBench, wanted: u8, milliseconds: u64) {
    for _ in 0..milliseconds / 10 {
        if state(drive) == wanted {
            return;
        }
        drive.run_millis(10);
    }
    panic!("state {}, failure {}", state(drive), failure(drive));
}

/// By how many hundredths a number is away from another.
fn percent(found: u32, known: f32, unit: f32) -> f32 {
    100.0 * (found as f32 * unit / known - 1.0)
}

#[test]
fn m45_the_drive_measures_its_motor_on_each_axis() {
    for axis in AXES {
        let mut drive = enabled(axis.name, 1);
        order(&mut drive, 1);
        comes_to(&mut drive, DONE, 8_000);
        let motor = axis.motor();
        let winding = [3, 4, 5, 6].map(|sub| drive.read_u32(0x20C1, sub));
        for (found, known, unit, bound) in [
            (winding[0], motor.resistance, 1e-6, 3.0),
            (winding[1], motor.inductance_d, 1e-9, 10.0),
            (winding[2], motor.inductance_q, 1e-9, 10.0),
            (winding[3], motor.flux, 1e-9, 4.0),
            (drive.read_u32(0x20C1, 10), motor.inertia, 1e-9, 20.0),
        ] {
            let away = percent(found, known, unit);
            assert!(away.abs() < bound, "{}: {found}, {away} % away", axis.name);
        }
        assert_eq!(drive.read_u16(0x20C1, 7), motor.pole_pairs);
        assert_eq!(drive.read_i8(0x20C1, 8), 1);
        let angle = drive.read_i16(0x20C1, 9);
        assert!(angle.unsigned_abs() < 1_820, "{}: {angle}", axis.name);
        assert_eq!(drive.read_u16(0x20C1, 12), 600);
        // It holds where it is, and goes where it is told to.
        assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
        drive.run_millis(50);
        let before = drive.position();
        drive.run_millis(50);
        assert!((drive.position() - before).abs() <= 1, "{}", axis.name);
        assert!((drive.read_i32(0x6062, 0) - drive.read_i32(0x6064, 0)).abs() <= 2);
        drive.begin_move(2_000);
        drive.reaches_target(2_000);
        drive.run_millis(50);
        assert!((drive.position() - 2_000).abs() <= 1, "{}", axis.name);
    }
}

#[test]
fn m45_a_demand_takes_the_motor_back_from_a_measurement() {
    let mut drive = enabled("servo_100w", 1);
    order(&mut drive, 1);
    comes_to(&mut drive, FIELD, 2_000);
    drive.begin_move(-4_000);
    drive.reaches_target(2_000);
    drive.run_millis(50);
    assert_eq!((state(&mut drive), failure(&mut drive)), (FAILED, 7));
    assert!((drive.position() + 4_000).abs() <= 1);
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
}

#[test]
fn m45_a_measurement_waits_for_a_standstill_and_ends_with_the_power() {
    let mut drive = enabled("servo_100w", 3);
    order(&mut drive, 1);
    comes_to(&mut drive, WINDING, 100);
    drive.command(0x06);
    drive.run_millis(50);
    assert_eq!((state(&mut drive), failure(&mut drive)), (FAILED, 1));
    let currents = drive.plant().phase_currents();
    assert!(currents.iter().all(|current| current.abs() < 0.01));

    order(&mut drive, 1);
    assert_eq!((state(&mut drive), failure(&mut drive)), (FAILED, 8));
    drive.enable();
    drive.write_i32(0x60FF, 0, 50_000);
    drive.run_millis(300);
    order(&mut drive, 1);
    drive.run_millis(100);
    assert_eq!(state(&mut drive), WAITS);
    drive.write_i32(0x60FF, 0, 0);
    comes_to(&mut drive, WINDING, 1_000);
    // A master that does not want it any more.
    drive.write_u8(0x20C0, 1, 0);
    drive.run_millis(20);
    assert_eq!((state(&mut drive), failure(&mut drive)), (FAILED, 7));
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
    // A last count, as the rotor comes to rest, is seen in 606Ch for 8 ms.
    drive.run_millis(20);
    assert_eq!(drive.read_i32(0x606C, 0), 0);
}

#[test]
fn m45_a_measurement_that_cannot_be_is_told_and_keeps_the_current() {
    let mut drive = enabled("servo_100w", 1);
    hold(&mut drive);
    order(&mut drive, 1);
    let mut most = 0_f64;
    for _ in 0..3_000 {
        drive.run_millis(1);
        let currents = drive.plant().phase_currents();
        most = currents.iter().fold(most, |most, one| most.max(one.abs()));
    }
    assert_eq!((state(&mut drive), failure(&mut drive)), (FAILED, 3));
    // 20C0h:2, 800 thousandths of 4 A.
    assert!((2.5..4.0).contains(&most), "{most} A");
    assert!(drive.position().abs() < 5);

    let mut drive = enabled("nema17", 1);
    order(&mut drive, 1);
    drive.set_supply(false);
    drive.run_millis(200);
    assert_eq!((state(&mut drive), failure(&mut drive)), (FAILED, 1));
    assert_eq!(drive.read_u16(0x603F, 0), 0x3220);
}

#[test]
fn m45_a_sine_is_added_to_the_torque() {
    let mut drive = enabled("servo_100w", 1);
    order(&mut drive, 2);
    comes_to(&mut drive, EXCITES, 50);
    let (mut least, mut most, mut way) = (0, 0, 0);
    for _ in 0..1_900 {
        drive.run_millis(1);
        let demand = drive.read_i16(0x6074, 0);
        (least, most) = (demand.min(least), demand.max(most));
        way = way.max(drive.position().abs());
    }
    assert!(
        (-700..-450).contains(&least) && (450..700).contains(&most),
        "{least} to {most}"
    );
    assert!((100..5_000).contains(&way), "{way} counts");
    comes_to(&mut drive, DONE, 500);
    drive.run_millis(20);
    let stands = drive.position();
    drive.run_millis(50);
    assert!((drive.position() - stands).abs() <= 1);
    assert!((drive.read_i32(0x60F4, 0)).abs() <= 2);
    // Within the limits of the torque as all else.
    drive.write_u16(0x6072, 0, 100);
    order(&mut drive, 2);
    for _ in 0..500 {
        drive.run_millis(1);
        let demand = drive.read_i16(0x6074, 0);
        assert!(demand.abs() <= 100, "{demand}");
    }
}

#[test]
fn m45_a_sine_that_moves_the_rotor_too_far_ends() {
    let mut drive = enabled("servo_100w", 1);
    drive.write_u16(0x20C0, 3, 20);
    order(&mut drive, 2);
    comes_to(&mut drive, FAILED, 500);
    assert_eq!(failure(&mut drive), 6);
    drive.run_millis(100);
    assert!(drive.position().abs() < 1_000, "{}", drive.position());
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
}

/// How far a torque at once moves the rotor, in counts.
fn given_way(drive: &mut ServoBench) -> i64 {
    drive.plant().load_torque = 0.15;
    let mut most = 0;
    for _ in 0..100 {
        drive.run_millis(1);
        most = most.max(drive.position().abs());
    }
    drive.plant().load_torque = 0.0;
    drive.run_millis(200);
    most
}

#[test]
fn m45_gains_take_effect_at_once_and_without_a_bump() {
    let mut drive = enabled("servo_100w", 1);
    let stiff = given_way(&mut drive);
    drive.write_u16(0x60F9, 1, 200);
    drive.write_u16(0x60F9, 2, 70);
    drive.write_u16(0x60FB, 1, 70);
    drive.run_millis(20);
    let stood = drive.position();
    assert!(stood.abs() <= 1, "{stood}");
    let soft = given_way(&mut drive);
    assert!(soft > 4 * stiff, "{stiff} and {soft} counts");
    // Under a load, in motion.
    drive.plant().load_torque = 0.1;
    drive.run_millis(300);
    let before = torque(&mut drive);
    for sub_gains in [(800, 267, 267), (300, 100, 100), (0, 0, 0)] {
        let (velocity, integral, position) = sub_gains;
        drive.write_u16(0x60F9, 1, velocity);
        drive.write_u16(0x60F9, 2, integral);
        drive.write_u16(0x60FB, 1, position);
        drive.run_millis(10);
        let after = torque(&mut drive);
        assert!((after - before).abs() < 40, "{before} and {after}");
    }
    for (index, sub) in [(0x60F9, 1), (0x60F9, 2), (0x60FB, 1)] {
        let too_much = drive.try_write(index, sub, &10_001_u16.to_le_bytes());
        assert_eq!(too_much, Err(0x0609_0031));
    }
    let too_much = drive.try_write(0x60F6, 1, &1_001_u16.to_le_bytes());
    assert_eq!(too_much, Err(0x0609_0031));
}

#[test]
fn m45_the_loops_go_by_the_data_that_a_master_has_written() {
    let data = ServoAxisData::named("servo_100w").unwrap();
    let flux = (data.motor().flux * 1e9).round() as u32;
    let mut drive = enabled("servo_100w", 4);
    hold(&mut drive);
    drive.write_u32(0x6087, 0, 100_000);
    let current = |drive: &mut ServoBench| {
        drive.write_i16(0x6071, 0, 200);
        drive.run_millis(50);
        let actual = torque(drive);
        assert!(
            (actual - 200).abs() <= 2,
            "{actual}, error {:04X}h",
            drive.read_u16(0x603F, 0)
        );
        drive.read_i16(0x6078, 0)
    };
    let true_current = current(&mut drive);
    assert!((true_current - 200).abs() <= 3, "{true_current}");
    // Nothing of the motor changes while it has power.
    drive.write_u32(0x20C2, 4, flux * 2);
    drive.run_millis(20);
    assert!((drive.read_i16(0x6078, 0) - 200).abs() <= 3);
    drive.write_i16(0x6071, 0, 0);
    drive.command(0x06);
    drive.run_millis(20);
    drive.enable();
    drive.reaches(OPERATION_ENABLED, 50);
    drive.write_u32(0x6065, 0, u32::MAX);
    let by_double = current(&mut drive);
    assert!((by_double - 100).abs() <= 3, "{by_double}");
    assert!(!SWITCHED_ON.is_shown_by(drive.statusword()));
}

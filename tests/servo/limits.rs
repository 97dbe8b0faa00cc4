//! Limits of the torque in each mode, and changes of the mode that make no step of it.

use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED, ServoBench};

use super::cyclic::{bytes, period};
use super::{enable, enabled, hold, torque};

/// The modes that the drive has.
const MODES: [u8; 9] = [1, 2, 3, 4, 6, 7, 8, 9, 10];

/// A motion one way or the other, as each mode is told of it.
fn set_off(drive: &mut ServoBench, mode: u8, sign: i32) {
    match mode {
        1 => drive.begin_move(20_000 * sign),
        2 => {
            drive.write_i16(0x6042, 0, (20_000 * sign) as i16);
            drive.command(0x7F);
        }
        3 => drive.write_i32(0x60FF, 0, 50_000 * sign),
        4 => drive.write_i16(0x6071, 0, (1_000 * sign) as i16),
        6 => {
            // To a limit switch that is far away.
            drive.write_i8(0x6098, 0, if sign > 0 { 18 } else { 17 });
            drive.write_u32(0x6099, 1, 50_000);
            drive.write_u32(0x609A, 0, 500_000);
            drive.command(0x1F);
        }
        7 => drive.command(0x1F),
        _ => {}
    }
}

/// The set-point that goes on at each SYNC, in RPDO 2.
fn mapped(mode: u8) -> Option<u32> {
    match mode {
        7 => Some(0x60C1_0120),
        8 => Some(0x607A_0020),
        9 => Some(0x60FF_0020),
        10 => Some(0x6071_0010),
        _ => None,
    }
}

/// What is given at a SYNC.
fn set_point(mode: u8, sign: i32, step: i32) -> Option<String> {
    match mode {
        7 | 8 => Some(bytes(&(sign * 40 * step).to_le_bytes())),
        9 => Some(bytes(&(sign * 50_000).to_le_bytes())),
        10 => Some(bytes(&((1_000 * sign) as i16).to_le_bytes())),
        _ => None,
    }
}

#[test]
fn m45_each_limit_of_the_torque_holds_in_each_mode() {
    const LEAST: u16 = 80;
    for mode in MODES {
        for (limit, directions) in [
            (0x6072, [true, true]),
            (0x6073, [true, true]),
            (0x60E0, [true, false]),
            (0x60E1, [false, true]),
        ] {
            for (sign, is_limited) in [1, -1].into_iter().zip(directions) {
                let mut drive = ServoBench::on_axis("servo_100w");
                if let Some(object) = mapped(mode) {
                    drive.map_pdo(0x1401, &[object], 1);
                    drive.write_u8(0x60C2, 1, 4);
                }
                drive.write_u16(limit, 0, LEAST);
                drive.write_u32(0x6065, 0, u32::MAX);
                drive.write_u32(0x6087, 0, 100_000);
                let mut drive = enable(drive, mode);
                hold(&mut drive);
                set_off(&mut drive, mode, sign);
                let what = format!("mode {mode}, {limit:04X}h, {sign}");
                let mut most = 0;
                for step in 0..30 {
                    period(&mut drive, set_point(mode, sign, step).as_deref());
                    most = most.max(torque(&mut drive) * sign as i16);
                }
                if is_limited {
                    let least = LEAST as i16;
                    assert!((least - 2..=least + 2).contains(&most), "{what}: {most}");
                    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0, "{what}");
                } else {
                    assert!(most > 3 * LEAST as i16, "{what}: {most}");
                }
                drive.reaches(OPERATION_ENABLED, 1);
            }
        }
    }
}

/// Under a load and in motion, with ramps that take no torque: what holds the motor goes on with the torque that it finds. In thousandths of the rated one.
#[test]
fn m45_no_change_of_the_mode_makes_a_step_of_the_torque() {
    for (name, way, load, speed, most) in [
        ("servo_100w", 0, 0.1, 100_000, 15),
        ("nema17", 0, 0.05, 10_000, 40),
        // A rotor swings in its field.
        ("nema17", 2, 0.05, 10_000, 300),
        ("nema17", 3, 0.05, 10_000, 300),
    ] {
        for from in MODES {
            let mut drive = ServoBench::on_changed(name, |data| data.plant.motor.detent = 0.0);
            for index in [0x6083, 0x6084, 0x6085, 0x609A, 0x60C5, 0x60C6] {
                drive.write_u32(index, 0, 10_000);
            }
            for index in [0x6048, 0x6049] {
                drive.write_u32(index, 1, 10_000);
            }
            drive.write_u32(0x6065, 0, u32::MAX);
            drive.write_u8(0x20C4, 1, way);
            let mut drive = enable(drive, 3);
            drive.write_u32(0x6083, 0, 1_000_000);
            drive.write_i32(0x60FF, 0, speed);
            drive.run_millis(250);
            drive.plant().load_torque = load;
            drive.run_millis(250);
            let held = torque(&mut drive);
            assert!(held > 150, "{name}: {held}");
            for to in MODES {
                for mode in [from, to] {
                    let now = torque(&mut drive);
                    drive.write_i16(0x6071, 0, now);
                    let before = drive.axis().actuals().torque.actual;
                    drive.write_u8(0x6060, 0, mode);
                    for _ in 0..40 {
                        drive.run_micros(250);
                        let after = drive.axis().actuals().torque.actual;
                        let step = (after - before).abs();
                        assert!(step <= most, "{name}, way {way}, {from} and {to}: {step}");
                    }
                }
                drive.reaches(OPERATION_ENABLED, 1);
            }
        }
    }
}

#[test]
fn m45_the_fastest_holds_in_both_torque_modes() {
    // 6080h in 1/min, and 607Fh in counts/s.
    for mode in [4, 10] {
        for (limit, value) in [(0x6080, 600), (0x607F, 100_000)] {
            for sign in [1, -1] {
                let mut drive = ServoBench::on_axis("servo_100w");
                drive.map_pdo(0x1401, &[0x6071_0010], 1);
                drive.write_u8(0x60C2, 1, 4);
                drive.write_u32(limit, 0, value);
                drive.write_u32(0x6087, 0, 100_000);
                let mut drive = enable(drive, mode);
                for _ in 0..150 {
                    period(&mut drive, Some(&bytes(&(200 * sign as i16).to_le_bytes())));
                }
                let velocity = drive.read_i32(0x606C, 0) * sign;
                let what = format!("mode {mode}, {limit:04X}h");
                assert!((95_000..=100_500).contains(&velocity), "{what}: {velocity}");
            }
        }
    }
}

#[test]
fn m45_each_mode_that_6502h_names_is_taken_and_no_other() {
    let mut drive = enabled("servo_100w", 1);
    let modes = drive.read_u32(0x6502, 0);
    assert_eq!(modes, 0x3EF);
    for mode in i8::MIN..=i8::MAX {
        let is_named = mode == 0 || (1..=32).contains(&mode) && modes >> (mode - 1) & 1 == 1;
        let taken = drive.try_write(0x6060, 0, &mode.to_le_bytes());
        assert_eq!(taken.is_ok(), is_named, "mode {mode}");
        if is_named {
            drive.run_millis(20);
            assert_eq!(drive.read_i8(0x6061, 0), mode);
        }
    }
}

/// A torque that is held brakes before its fastest speed no harder than 60E1h allows, whatever drives the motor.
#[test]
fn m45_what_keeps_the_fastest_of_a_torque_stays_within_the_limit_of_its_direction() {
    for sign in [1, -1] {
        let mut drive = ServoBench::on_axis("servo_100w");
        drive.write_u32(0x6080, 0, 600);
        drive.write_u16(if sign > 0 { 0x60E1 } else { 0x60E0 }, 0, 50);
        let mut drive = enable(drive, 4);
        drive.plant().load_torque = -0.1 * f64::from(sign);
        let mut most = 0;
        for _ in 0..30 {
            drive.run_millis(1);
            most = most.max(-torque(&mut drive) * sign);
        }
        assert!(drive.read_i32(0x606C, 0) * i32::from(sign) > 100_000);
        assert!(most <= 52, "{most} of 50");
    }
}

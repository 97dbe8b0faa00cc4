//! What the power takes along, and what an absolute encoder knows as it comes back: 6064h is the angle within the turn, and home may be known.

use sim::plant::{Axis, ServoAxisData};
use std::f64::consts::TAU;
use tests::drive::{SWITCH_ON_DISABLED, ServoBench};

const ABSOLUTE: &str = "servo_100w_absolute";
/// Positions in a turn.
const TURN: i32 = 10_000;
/// 2030h:1 bit 9: home is the zero of the encoder.
const ENCODER_ZERO: u16 = 1 << 9;
/// Statusword bit 12 in homing.
const ATTAINED: u16 = 1 << 12;

/// With the rotor at so many turns.
fn standing_at(turns: f64) -> ServoBench {
    ServoBench::on_changed(ABSOLUTE, |data| data.start = turns * TAU)
}

/// What is set is stored, the power goes and comes back.
fn cycle(drive: &mut ServoBench) {
    drive.write(0x1010, 1, b"save");
    drive.axis().power_cycle();
    drive.drain_until("704 [1] 00", 100);
    drive.start();
    drive.reaches(SWITCH_ON_DISABLED, 20);
}

fn position(drive: &mut ServoBench) -> i32 {
    drive.read_i32(0x6064, 0)
}

/// A count is left to how an angle is rounded.
#[track_caller]
fn is_at(drive: &mut ServoBench, expected: i32) {
    let position = position(drive);
    assert!(
        (position - expected).abs() <= 1,
        "{position}, not {expected}"
    );
}

/// The position of the rotor within its turn.
fn within_turn(drive: &mut ServoBench) -> i32 {
    let turns = drive.plant().angle() / TAU;
    (turns.rem_euclid(1.0) * f64::from(TURN)) as i32
}

/// By so many positions, in profile position; then the power of the motor is off.
fn move_by(drive: &mut ServoBench, way: i32) {
    drive.write_u8(0x6060, 0, 1);
    drive.enable();
    let target = position(drive) + way;
    drive.begin_move(target);
    drive.reaches_target(3_000);
    is_at(drive, target);
    drive.command(0);
    drive.run_millis(50);
}

/// Method 35, with the rotor where it is.
fn home_here(drive: &mut ServoBench) {
    drive.write_u8(0x6060, 0, 6);
    drive.write_u8(0x6098, 0, 35);
    drive.enable();
    drive.command(0x1F);
    drive.run_millis(20);
    assert_ne!(drive.statusword() & ATTAINED, 0);
    drive.command(0);
    drive.run_millis(50);
}

fn is_home_known(drive: &mut ServoBench) -> bool {
    let known = drive.read_u8(0x2034, 1) == 1;
    drive.write_u8(0x6060, 0, 6);
    drive.run_millis(5);
    assert_eq!(
        drive.statusword() & ATTAINED != 0,
        known,
        "bit 12 in homing"
    );
    known
}

#[test]
fn m74_an_absolute_encoder_has_the_angle_within_the_turn_as_the_power_comes() {
    for turns in [0.0, 0.1, 0.5, 0.93, -0.25, 3.4] {
        let mut drive = standing_at(turns);
        let expected = (turns.rem_euclid(1.0) * f64::from(TURN)) as i32;
        is_at(&mut drive, expected);
        assert!(!is_home_known(&mut drive), "nothing tells which turn it is");
        // Positions go on over the turn; the next power-up knows the angle alone.
        for way in [4_000, -13_000] {
            let before = position(&mut drive);
            move_by(&mut drive, way);
            is_at(&mut drive, before + way);
            cycle(&mut drive);
            let expected = within_turn(&mut drive);
            is_at(&mut drive, expected);
        }
    }
}

#[test]
fn m74_any_other_encoder_begins_at_0_as_the_power_comes() {
    for name in ["servo_100w", "servo_100w_hall"] {
        let mut drive = ServoBench::on_changed(name, |data| data.start = 1.0);
        drive.write_u16(0x2030, 1, ENCODER_ZERO);
        drive.write_i32(0x607C, 0, 700);
        assert_eq!(position(&mut drive), 0);
        move_by(&mut drive, 1_700);
        cycle(&mut drive);
        assert_eq!(position(&mut drive), 0, "{name}");
        assert!(!is_home_known(&mut drive), "{name}");
        // And moves as before.
        move_by(&mut drive, -900);
    }
}

#[test]
fn m74_the_angle_counts_in_the_direction_of_the_axis() {
    for (polarity, reversed, sign) in [(0x80, 0, -1), (0, 1, -1), (0xC0, 1, 1)] {
        let mut drive = standing_at(0.3);
        drive.write_u8(0x607E, 0, polarity);
        drive.write_u8(0x2072, 0, reversed);
        cycle(&mut drive);
        is_at(&mut drive, sign * 3_000);
        // Each angle has its position, whichever was there before.
        move_by(&mut drive, sign * 2_500);
        cycle(&mut drive);
        is_at(&mut drive, sign * 5_500);
    }
}

#[test]
fn m74_the_angle_is_in_the_units_of_the_axis() {
    let mut drive = standing_at(0.75);
    // In hundredths of a degree.
    drive.write_u32(0x6092, 1, 36_000);
    cycle(&mut drive);
    assert!((position(&mut drive) - 27_000).abs() <= 4);
    let position = position(&mut drive);
    move_by(&mut drive, -9_000);
    let moved = (drive.plant().angle() / TAU - 0.5) * 36_000.0;
    assert!(moved.abs() <= 6.0 && position != 0, "{moved}");
}

#[test]
fn m74_a_homing_holds_until_the_power_goes() {
    let mut drive = standing_at(0.3);
    drive.write_i32(0x607C, 0, 500);
    home_here(&mut drive);
    is_at(&mut drive, 500);
    assert!(is_home_known(&mut drive));
    cycle(&mut drive);
    is_at(&mut drive, 3_000);
    assert!(!is_home_known(&mut drive));
}

#[test]
fn m74_home_at_the_zero_of_an_absolute_encoder_is_known_from_power_up() {
    for (options, name) in [(0, 1_234), (1, -1_234)] {
        let mut drive = standing_at(0.3);
        drive.write_u16(0x2030, 1, ENCODER_ZERO | options);
        drive.write_i32(0x607C, 0, 1_234);
        is_at(&mut drive, 3_000);
        cycle(&mut drive);
        is_at(&mut drive, 3_000 + name);
        assert!(is_home_known(&mut drive));
        // No homing: an absolute set-point goes to the angle that it names.
        drive.write_u8(0x6060, 0, 1);
        drive.enable();
        drive.begin_move(name + 6_000);
        drive.reaches_target(3_000);
        let stands = within_turn(&mut drive);
        assert!((stands - 6_000).abs() <= 1, "{stands}");
        drive.command(0);
        drive.run_millis(50);
        // Homing gives another until the power goes.
        home_here(&mut drive);
        is_at(&mut drive, name);
        cycle(&mut drive);
        is_at(&mut drive, 6_000 + name);
        assert!(is_home_known(&mut drive));
    }
}

#[test]
fn m74_of_the_turns_it_is_the_one_of_the_software_limits() {
    // Limits from home on; where the rotor stands in the turn; 6064h.
    for (low, high, turns, expected) in [
        (-4_000, 4_000, 0.9, -1_000),
        (-4_000, 4_000, 0.1, 1_000),
        (9_500, 12_500, 0.1, 11_000),
        (9_500, 12_500, 0.97, 9_700),
        (-25_000, -15_500, 0.2, -18_000),
        // A turn as a whole, more than one, and one limit alone.
        (0, 10_000, 0.9, 9_000),
        (-6_000, 6_000, 0.9, 9_000),
        (i32::MIN, 4_000, 0.9, 9_000),
    ] {
        for (polarity, sign) in [(0, 1), (0x80, -1)] {
            let mut drive = standing_at(f64::from(sign) * turns);
            drive.write_u16(0x2030, 1, ENCODER_ZERO);
            drive.write_i32(0x607D, 1, low);
            drive.write_i32(0x607D, 2, high);
            drive.write_i32(0x607C, 0, 300);
            drive.write_u8(0x607E, 0, polarity);
            cycle(&mut drive);
            // A turn of the encoder begins at its zero, so backwards its angles are below.
            let is_chosen = (low, high) != (-6_000, 6_000) && low != i32::MIN;
            let expected = match (is_chosen, sign) {
                (false, -1) => expected - TURN,
                _ => expected,
            };
            is_at(&mut drive, expected + 300);
            assert!(is_home_known(&mut drive));
        }
    }
}

#[test]
fn m74_the_software_limits_hold_at_once_where_home_is_known() {
    let mut drive = standing_at(0.9);
    drive.write_u16(0x2030, 1, ENCODER_ZERO);
    drive.write_i32(0x607D, 1, -4_000);
    drive.write_i32(0x607D, 2, 4_000);
    // They need a known home position.
    drive.write_u8(0x20E0, 0, 1);
    cycle(&mut drive);
    is_at(&mut drive, -1_000);
    drive.enable();
    drive.write_i32(0x607A, 0, 8_000);
    drive.command(0x1F);
    drive.run_millis(2_000);
    is_at(&mut drive, 4_000);
}

#[test]
fn m74_an_absolute_encoder_that_answers_later_has_its_place_then() {
    let mut drive = standing_at(0.3);
    drive.write_u16(0x2030, 1, ENCODER_ZERO);
    drive.write_i32(0x607C, 0, 500);
    drive.plant().sensor_faults.line_is_broken = true;
    cycle(&mut drive);
    assert_eq!(position(&mut drive), 0);
    assert!(!is_home_known(&mut drive));
    drive.plant().sensor_faults.line_is_broken = false;
    drive.run_millis(5);
    is_at(&mut drive, 3_500);
    assert!(is_home_known(&mut drive));
}

#[test]
fn m74_an_axis_that_begins_somewhere_has_the_angle_of_that_place() {
    let data = ServoAxisData::named(ABSOLUTE).expect("a ready axis");
    for start in [2_500_i64, -1_000, 37_000] {
        let mut drive = ServoBench::on(Axis {
            start,
            ..Axis::servo(&data)
        });
        is_at(&mut drive, start.rem_euclid(i64::from(TURN)) as i32);
    }
}

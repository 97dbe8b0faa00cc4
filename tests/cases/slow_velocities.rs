//! Velocities of less than a step in a second, in units of 6096h: one step in an hour is a velocity like any other.

use canopen::Frame;
use tests::DriveBench;
use tests::drive::{INTERNAL_LIMIT, TARGET_REACHED};

use crate::cyclic_master::{FOLLOWS, Master, expedited};

/// Statusword bit 12 in profile velocity: speed is 0.
const SPEED_ZERO: u16 = 1 << 12;
/// A step in a second, in units.
const SECOND: i32 = 3_600;

/// A drive whose unit of velocity is one step in an hour; ramps of 6083h and the like are in steps/s².
fn hourly(mode: u8) -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_u32(0x6096, 1, 3_600);
    drive.write_u32(0x6097, 2, 3_600);
    drive.write_u32(0x607F, 0, u32::MAX);
    // As exact as the numbers are.
    drive.write_u16(0x606F, 0, 0);
    drive.write_u32(0x6067, 0, u32::MAX);
    drive.write_u8(0x6060, 0, mode);
    drive
}

#[test]
fn m73_a_velocity_of_a_step_in_an_hour_is_kept_shown_and_halted() {
    let mut drive = hourly(3);
    drive.enable();
    drive.write_i32(0x60FF, 0, 1);
    drive.run_millis(200);
    assert_eq!(drive.read_i32(0x606B, 0), 1);
    assert_eq!(drive.read_i32(0x606C, 0), 1);
    assert_eq!(drive.statusword() & (SPEED_ZERO | INTERNAL_LIMIT), 0);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    // The motor is in the middle of the gap of an hour when it is halted.
    drive.command(0x10F);
    let mut waited = 0;
    while drive.axis().actuals().is_moving {
        drive.run_micros(250);
        waited += 250;
    }
    // A control tick takes the command, and the silence that was committed is over at the one after the next.
    assert!(waited <= 4_000, "{waited} µs");
    drive.run_millis(20);
    assert_eq!(drive.read_i32(0x606C, 0), 0);
    assert_ne!(drive.statusword() & SPEED_ZERO, 0);
    assert_eq!(drive.position(), 0);
    // Straight to 10,000 steps/s, and back.
    drive.command(0x0F);
    drive.write_i32(0x60FF, 0, -10_000 * SECOND);
    drive.run_millis(400);
    assert_eq!(drive.read_i32(0x606B, 0), -10_000 * SECOND);
    let begin = drive.position();
    drive.run_millis(100);
    let distance = drive.position() - begin;
    assert!((-1_010..=-990).contains(&distance), "{distance}");
    drive.write_i32(0x60FF, 0, -1);
    drive.run_millis(300);
    assert_eq!(drive.read_i32(0x606B, 0), -1);
    let begin = drive.position();
    drive.run_millis(1_000);
    assert!(drive.position() - begin >= -1);
}

#[test]
fn m73_pulses_come_at_the_rate_of_a_fraction() {
    for sign in [1_i32, -1] {
        let mut drive = hourly(3);
        drive.enable();
        // 0.1 step/s: steps after 5 s, 15 s and 25 s.
        drive.write_i32(0x60FF, 0, sign * SECOND / 10);
        drive.run_millis(4_950);
        assert_eq!(drive.position(), 0);
        drive.run_millis(100);
        assert_eq!(drive.position(), i64::from(sign));
        drive.run_millis(9_900);
        assert_eq!(drive.position(), i64::from(sign));
        drive.run_millis(100);
        assert_eq!(drive.position(), i64::from(2 * sign));
        assert_eq!(drive.read_i32(0x606C, 0), sign * SECOND / 10);
    }
}

#[test]
fn m73_a_move_takes_as_long_as_its_velocity_wants() {
    let mut drive = hourly(1);
    drive.enable();
    // A quarter of a step in a second, for two steps.
    drive.write_u32(0x6081, 0, 900);
    drive.begin_move(-2);
    drive.run_millis(7_900);
    assert_eq!(drive.read_i32(0x606B, 0), -900);
    assert_eq!(drive.statusword() & (TARGET_REACHED | INTERNAL_LIMIT), 0);
    drive.run_millis(200);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    assert_eq!(drive.position(), -2);
    // The limits have the same unit, and bit 11 tells of them.
    drive.write_u32(0x607F, 0, 450);
    drive.begin_move(-1);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.run_millis(1_000);
    assert_eq!(drive.read_i32(0x606B, 0), 450);
    drive.reaches_target(8_000);
}

#[test]
fn m46_a_unit_of_the_velocity_mode_may_be_a_thousandth_of_a_step() {
    let mut drive = DriveBench::started(4);
    drive.write_i32(0x604C, 1, 1);
    drive.write_i32(0x604C, 2, 1_000);
    drive.write_u8(0x6060, 0, 2);
    drive.enable();
    drive.command(0x7F);
    drive.write_i16(0x6042, 0, -200);
    drive.run_millis(2_400);
    assert_eq!(drive.read_i16(0x6043, 0), -200);
    assert_eq!(drive.read_i16(0x6044, 0), -200);
    assert_eq!(drive.position(), 0);
    drive.run_millis(200);
    assert_eq!(drive.position(), -1);
    drive.run_millis(5_000);
    assert_eq!(drive.position(), -2);
}

#[test]
fn m69_cyclic_velocities_may_be_fractions_of_a_step() {
    let mut master = Master::of(hourly(9), 9, 1_000);
    for _ in 0..100 {
        master.sync(0);
    }
    let command = |master: &mut Master, velocity: i32, cycles: u32| {
        for _ in 0..cycles {
            let frame = Frame::data_frame(0x604, &expedited(0x60FF, velocity));
            master.drive.send_frame(frame);
            master.sync(0);
        }
    };
    let begin = master.drive.position();
    // 2.2 steps/s.
    let velocity = SECOND * 11 / 5;
    command(&mut master, velocity, 2_000);
    assert!(master.has(FOLLOWS));
    let shown = master.drive.axis().actuals().velocity_demand;
    assert_eq!(shown, velocity);
    assert_eq!(master.drive.position() - begin, 4);
    command(&mut master, velocity, 2_000);
    assert_eq!(master.drive.position() - begin, 9);
    command(&mut master, 1, 100);
    assert_eq!(master.drive.axis().actuals().velocity_demand, 1);
    assert_eq!(master.drive.position() - begin, 9);
}

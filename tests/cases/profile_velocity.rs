//! Profile velocity over the bus.

use embedded_can::Frame as _;
use tests::DriveBench;
use tests::drive::{INTERNAL_LIMIT, QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED, TARGET_REACHED};

/// Statusword bit 12: speed is 0.
const SPEED_ZERO: u16 = 1 << 12;

/// Statusword bit 13: slippage.
const SLIPPAGE: u16 = 1 << 13;

/// A drive in operation enabled, profile velocity. Ramps of 100,000 steps/s²: 100 ms to 10,000 steps/s.
fn enabled() -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 3);
    drive.enable();
    drive.run_millis(20);
    assert_eq!(drive.read_i8(0x6061, 0), 3);
    drive
}

#[test]
fn d27_velocity_halt_and_their_bits() {
    let mut drive = enabled();
    assert_ne!(drive.statusword() & SPEED_ZERO, 0);
    drive.write_i32(0x60FF, 0, 10_000);
    drive.run_millis(50);
    assert_eq!(drive.statusword() & (TARGET_REACHED | SPEED_ZERO), 0);
    drive.run_millis(100);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    assert_eq!(drive.read_i32(0x606B, 0), 10_000);
    assert_eq!(drive.read_i32(0x606C, 0), 10_000);
    let begin = drive.position();
    drive.run_millis(100);
    assert_eq!(drive.position() - begin, 1_000);

    drive.command(0x10F);
    drive.run_millis(50);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.run_millis(150);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0, "halted");
    assert_ne!(drive.statusword() & SPEED_ZERO, 0);
    let halted = drive.position();
    drive.run_millis(100);
    assert_eq!(drive.position(), halted);
    drive.command(0x0F);
    drive.run_millis(200);
    assert_eq!(drive.read_i32(0x606C, 0), 10_000);
}

#[test]
fn m41_new_velocities_in_the_ramp_and_across_zero_make_no_jump() {
    let mut drive = enabled();
    drive.record_motion();
    for velocity in [10_000, 2_000, -8_000, 8_000, 0] {
        drive.write_i32(0x60FF, 0, velocity);
        drive.run_millis(60);
    }
    drive.run_millis(200);
    assert!(
        drive.greatest_acceleration() <= 110_000,
        "{}",
        drive.greatest_acceleration()
    );
    let stopped = drive.position();
    drive.run_millis(100);
    assert_eq!(drive.position(), stopped);
}

#[test]
fn m42_the_windows_and_their_times_are_obeyed() {
    let mut drive = enabled();
    drive.write_u16(0x606D, 0, 500);
    drive.write_u16(0x606E, 0, 100);
    drive.write_u16(0x606F, 0, 5_000);
    drive.write_u16(0x6070, 0, 20);
    drive.write_i32(0x60FF, 0, 10_000);
    // 5,000 steps/s after 50 ms, and 20 ms more.
    drive.run_millis(65);
    assert_ne!(drive.statusword() & SPEED_ZERO, 0);
    drive.run_millis(15);
    assert_eq!(drive.statusword() & SPEED_ZERO, 0);
    // 9,500 steps/s after 95 ms, and 100 ms more.
    drive.run_millis(105);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.run_millis(25);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
}

#[test]
fn m42_slippage_shows_while_the_motor_is_behind_by_more_than_60f8h() {
    for (limit, slips) in [(2_000, true), (8_000, false)] {
        let mut drive = enabled();
        drive.write_i32(0x60F8, 0, limit);
        drive.write_i32(0x60FF, 0, 10_000);
        drive.run_millis(200);
        assert_eq!(drive.statusword() & SLIPPAGE, 0);
        // 5,000 steps/s are missing.
        for _ in 0..30 {
            drive.axis().plant_mut().displace(-5);
            drive.run_millis(1);
        }
        assert_eq!(
            drive.axis().actuals().statusword & SLIPPAGE != 0,
            slips,
            "{limit}"
        );
        drive.run_millis(50);
        assert_eq!(drive.statusword() & SLIPPAGE, 0);
    }
}

#[test]
fn m43_a_velocity_is_carried_out_in_operation_enabled_only() {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 3);
    drive.write_i32(0x60FF, 0, 10_000);
    drive.command(0x06);
    drive.run_millis(5);
    drive.command(0x07);
    drive.run_millis(100);
    assert_eq!(drive.position(), 0);
    drive.command(0x10F);
    drive.run_millis(100);
    assert_eq!(drive.position(), 0, "halt");
    drive.command(0x0F);
    drive.run_millis(100);
    assert!(drive.position() > 300);
    drive.command(0x07);
    drive.run_millis(200);
    let stopped = drive.position();
    drive.run_millis(100);
    assert_eq!(drive.position(), stopped);
}

#[test]
fn m44_and_d31_the_software_limits_stop_the_motor_in_time() {
    let mut drive = enabled();
    drive.write_i32(0x607D, 1, -2_000);
    drive.write_i32(0x607D, 2, 3_000);
    drive.record_motion();
    drive.write_i32(0x60FF, 0, 10_000);
    drive.run_millis(1_000);
    assert_eq!(drive.position(), 3_000);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.write_i32(0x60FF, 0, -10_000);
    drive.run_millis(100);
    assert_eq!(
        drive.statusword() & INTERNAL_LIMIT,
        0,
        "the way back is free"
    );
    drive.run_millis(1_000);
    assert_eq!(drive.position(), -2_000);
    assert!(drive.greatest_acceleration() <= 110_000);
}

#[test]
fn m39_a_velocity_and_ramps_above_their_maximum_are_cut() {
    let mut drive = enabled();
    // 6080h counts revolutions of 3200 steps in a minute.
    for (index, maximum, velocity) in [(0x607F, 4_000, 4_000), (0x6080, 30, 1_600)] {
        drive.write_u32(index, 0, maximum);
        drive.write_i32(0x60FF, 0, -10_000);
        drive.run_millis(150);
        assert_eq!(drive.read_i32(0x606C, 0), -velocity);
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    }
    drive.refused("604: 23 C5 60 00 00 00 00 00", 0x0609_0032);
    drive.refused("604: 23 C6 60 00 00 00 00 00", 0x0609_0032);
}

#[test]
fn m08_quick_stop_in_motion_ends_as_605ah_says() {
    let mut drive = enabled();
    drive.write_i32(0x60FF, 0, 10_000);
    drive.run_millis(150);
    drive.command(0x02);
    drive.reaches(QUICK_STOP_ACTIVE, 5);
    drive.reaches(SWITCH_ON_DISABLED, 50);
}

#[test]
fn m19_between_profile_position_and_profile_velocity_in_motion() {
    let mut drive = DriveBench::enabled(4);
    drive.write_i32(0x60FF, 0, 4_000);
    drive.record_motion();
    drive.begin_move(100_000);
    drive.run_millis(300);
    drive.write_u8(0x6060, 0, 3);
    drive.run_millis(10);
    assert_eq!(drive.read_i8(0x6061, 0), 3, "at once");
    drive.run_millis(100);
    assert_eq!(drive.read_i32(0x606B, 0), 4_000);
    drive.write_u8(0x6060, 0, 1);
    drive.run_millis(10);
    assert_eq!(drive.read_i8(0x6061, 0), 3, "it slows down first");
    drive.run_millis(100);
    assert_eq!(drive.read_i8(0x6061, 0), 1);
    let stopped = drive.position();
    drive.run_millis(200);
    assert_eq!(drive.position(), stopped);
    assert!(drive.greatest_acceleration() <= 110_000);
}

/// The count wraps from 2³¹ − 1 to −2³¹ and back: the motor does not notice, and neither does who reads the velocity.
#[test]
fn m41_a_velocity_goes_on_across_the_end_of_the_count() {
    for direction in [1_i64, -1] {
        let mut drive = DriveBench::started(4);
        let begin = if direction > 0 {
            i64::from(i32::MAX) - 2_000
        } else {
            i64::from(i32::MIN) + 2_000
        };
        // Turned there by hand.
        drive.axis().plant_mut().displace(begin);
        drive.run_millis(5);
        assert_eq!(i64::from(drive.read_i32(0x6064, 0)), begin);
        drive.map_pdo(0x1801, &[0x6064_0020, 0x606C_0020], 1);
        drive.start();
        drive.write_u8(0x6060, 0, 3);
        drive.enable();
        drive.write_i32(0x60FF, 0, 10_000 * direction as i32);
        // 500 steps of ramp, and a thousand at 10,000 steps/s: the other thousand and as many behind the end follow.
        drive.run_millis(200);
        drive.drain(5);
        let mut last: Option<i32> = None;
        let mut wrapped = 0;
        for _ in 0..250 {
            drive.send("080 [0]");
            let frame = drive.drain_until("284: xx xx xx xx xx xx xx xx", 5);
            let number = |bytes: &[u8]| i32::from_le_bytes(bytes.try_into().unwrap());
            let (position, velocity) = (number(&frame.data()[..4]), number(&frame.data()[4..]));
            assert_eq!(velocity, 10_000 * direction as i32, "at {position}");
            // The answer takes most of a millisecond.
            let read = drive.read_i32(0x6064, 0);
            let ahead = (drive.position() as i32).wrapping_sub(read);
            assert!(
                (0..=20).contains(&(i64::from(ahead) * direction)),
                "{ahead}"
            );
            if let Some(last) = last {
                let distance = i64::from(position.wrapping_sub(last)) * direction;
                assert!((0..=60).contains(&distance), "{distance} steps from {last}");
                wrapped += u32::from(position.signum() != last.signum());
            }
            last = Some(position);
            drive.run_millis(1);
        }
        assert_eq!(wrapped, 1);
        drive.write_i32(0x60FF, 0, 0);
        drive.run_millis(200);
        assert_ne!(drive.statusword() & SPEED_ZERO, 0);
        let distance = (drive.position() - begin) * direction;
        assert!(distance > 4_000, "{distance}");
        for index in [0x6062, 0x6063, 0x6064] {
            assert_eq!(
                drive.read_i32(index, 0),
                drive.position() as i32,
                "{index:04X}h"
            );
        }
    }
}

//! The velocity mode ("vl") over the bus.

use tests::DriveBench;
use tests::drive::INTERNAL_LIMIT;

/// Controlword: operation enabled with bits 4 to 6, as in normal operation.
const RUN: u16 = 0x7F;

/// A drive in operation enabled, velocity mode.
fn enabled() -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 2);
    drive.enable();
    drive.command(RUN);
    drive.run_millis(5);
    assert_eq!(drive.read_i8(0x6061, 0), 2);
    drive
}

fn set_ramp(drive: &mut DriveBench, index: u16, speed: u32, seconds: u16) {
    drive.write_u32(index, 1, speed);
    drive.write_u16(index, 2, seconds);
}

#[test]
fn m46_ramps_are_pairs_of_speed_and_time() {
    let mut drive = enabled();
    set_ramp(&mut drive, 0x6048, 40_000, 2);
    set_ramp(&mut drive, 0x6049, 50_000, 1);
    set_ramp(&mut drive, 0x604A, 1_000_000, 10);
    drive.write_i16(0x6042, 0, 10_000);
    drive.run_millis(250);
    let demand = drive.read_i16(0x6043, 0);
    assert!((4_900..=5_100).contains(&demand), "{demand} after 250 ms");
    drive.run_millis(300);
    assert_eq!(drive.read_i16(0x6043, 0), 10_000);
    assert_eq!(drive.read_i16(0x6044, 0), 10_000);
    drive.write_i16(0x6042, 0, 0);
    drive.run_millis(100);
    let demand = drive.read_i16(0x6043, 0);
    assert!((4_800..=5_300).contains(&demand), "{demand} after 100 ms");
    drive.run_millis(150);
    drive.write_i16(0x6042, 0, -10_000);
    drive.run_millis(600);
    let begin = drive.position();
    drive.command(0x02);
    drive.run_millis(200);
    let distance = begin - drive.position();
    // 10,000 steps/s on 100,000 steps/s².
    assert!((500..540).contains(&distance), "{distance}");
    for index in [0x6048, 0x6049, 0x604A] {
        for sub in [1, 2] {
            let size = if sub == 1 { 4 } else { 2 };
            let refused = drive.try_write(index, sub, &[0; 4][..size]);
            assert!(refused.is_err(), "{index:04X}h:{sub} = 0");
        }
    }
}

#[test]
fn m46_bits_4_to_6_gate_the_ramp() {
    let mut drive = enabled();
    drive.write_i16(0x6042, 0, 5_000);
    drive.run_millis(200);
    let speed = |drive: &mut DriveBench| {
        let begin = drive.position();
        drive.run_millis(100);
        (drive.position() - begin) * 10
    };
    assert_eq!(speed(&mut drive), 5_000);
    for (controlword, expected) in [
        (RUN & !0x10, 0),
        (RUN, 5_000),
        (RUN & !0x40, 0),
        (RUN, 5_000),
    ] {
        drive.command(controlword);
        drive.run_millis(100);
        assert_eq!(speed(&mut drive), expected, "{controlword:04X}h");
    }
    drive.command(RUN & !0x20);
    drive.run_millis(5);
    drive.write_i16(0x6042, 0, -5_000);
    drive.run_millis(100);
    assert_eq!(speed(&mut drive), 5_000, "locked");
    drive.command(RUN);
    drive.run_millis(150);
    assert_eq!(speed(&mut drive), -5_000);
    drive.command(RUN | 0x100);
    drive.run_millis(100);
    assert_eq!(speed(&mut drive), 0, "halt");
}

#[test]
fn m46_minimum_and_maximum_amount_show_in_bit_11() {
    let mut drive = enabled();
    drive.write_u32(0x6046, 1, 500);
    drive.write_u32(0x6046, 2, 2_000);
    for (asked, shown, is_limited) in [
        (100, 500, true),
        (1_000, 1_000, false),
        (-3_000, -2_000, true),
    ] {
        drive.write_i16(0x6042, 0, asked);
        drive.run_millis(100);
        assert_eq!(drive.read_i16(0x6043, 0), shown);
        assert_eq!(drive.statusword() & INTERNAL_LIMIT != 0, is_limited);
    }
}

#[test]
fn m46_604ch_turns_units_of_the_mode_into_steps() {
    let mut drive = enabled();
    drive.write_i32(0x604C, 1, 200);
    drive.write_i32(0x604C, 2, 60);
    // Revolutions a minute of a motor with 200 steps.
    drive.write_i16(0x6042, 0, 300);
    drive.run_millis(100);
    let begin = drive.position();
    drive.run_millis(1_000);
    assert_eq!(drive.position() - begin, 1_000);
    assert_eq!(drive.read_i16(0x6043, 0), 300);
    assert_eq!(drive.read_i32(0x606B, 0), 1_000);
}

//! Units of the user over the bus: the factor group, polarity, the range of positions.

use canopen::Frame;
use tests::DriveBench;
use tests::drive::{INTERNAL_LIMIT, State, TARGET_REACHED};

/// What a master writes of the factor group, in the order of a start-up list.
const FACTORS: [(u16, u8, u32); 8] = [
    (0x608F, 1, 3_200),
    (0x608F, 2, 1),
    (0x6091, 1, 1),
    (0x6091, 2, 1),
    (0x6092, 1, 960),
    (0x6092, 2, 1),
    (0x6096, 1, 1),
    (0x6097, 2, 1),
];

/// A drive whose master counts three units where the motor makes ten steps.
fn thirds() -> DriveBench {
    let mut drive = DriveBench::started(4);
    for (index, sub, number) in FACTORS {
        drive.write_u32(index, sub, number);
    }
    drive
}

#[track_caller]
fn refuses(drive: &mut DriveBench, index: u16, sub: u8, value: &[u8], code: u32) {
    assert_eq!(
        drive.try_write(index, sub, value),
        Err(code),
        "{index:04X}h:{sub}"
    );
}

#[test]
fn m73_a_move_in_units_and_6063h_in_increments() {
    let mut drive = thirds();
    drive.enable();
    drive.begin_move(-10_000);
    drive.reaches_target(10_000);
    assert_eq!(drive.position(), -33_333);
    assert_eq!(drive.read_i32(0x6063, 0), -33_333);
    assert_eq!(drive.read_i32(0x6064, 0), -10_000);
    assert_eq!(drive.read_i32(0x6062, 0), -10_000);
    assert_eq!(drive.read_i32(0x60F4, 0), 0);
}

#[test]
fn m73_a_ramp_is_a_whole_number_of_steps_at_least_one() {
    // In thousandths of a step/s²; 50 steps take twice the root of 50 by the ramp: 14.1 s, 10 s or 8.2 s, the last step a little less.
    for (ramp, milliseconds) in [
        (1, 13_000..14_300),
        (400, 13_000..14_300),
        (1_499, 13_000..14_300),
        (1_500, 9_200..10_200),
        (2_499, 9_200..10_200),
        (2_500, 7_400..8_400),
    ] {
        let mut drive = DriveBench::started(4);
        drive.write_u32(0x6097, 1, 1_000);
        drive.write_u32(0x60C5, 0, u32::MAX);
        drive.write_u32(0x60C6, 0, u32::MAX);
        drive.write_u32(0x6083, 0, ramp);
        drive.write_u32(0x6084, 0, ramp);
        drive.enable();
        drive.begin_move(50);
        let mut time = 8;
        while drive.position() < 50 && time < 20_000 {
            drive.run_millis(10);
            time += 10;
        }
        assert!(milliseconds.contains(&time), "{ramp}: {time} ms");
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
        assert_eq!(
            drive.read_u32(0x6083, 0),
            ramp,
            "it is kept as it was written"
        );
    }
    // 0 is none.
    let mut drive = DriveBench::started(4);
    for index in [0x6083, 0x6084, 0x6085] {
        refuses(&mut drive, index, 0, &[0; 4], 0x0609_0032);
    }
}

#[test]
fn m73_velocities_and_ramps_are_in_units() {
    let mut drive = thirds();
    drive.write_u32(0x6096, 1, 60);
    drive.write_u32(0x6097, 2, 60);
    drive.write_u8(0x6060, 0, 3);
    // 3,000 units/s, given in a minute.
    drive.write_i32(0x60FF, 0, 180_000);
    drive.write_u32(0x6083, 0, 30_000);
    drive.enable();
    drive.record_motion();
    drive.run_millis(500);
    assert_eq!(drive.read_i32(0x606B, 0), 180_000);
    assert_eq!(drive.read_i32(0x606C, 0), 180_000);
    let begin = drive.position();
    drive.run_millis(100);
    let distance = drive.position() - begin;
    assert!((985..=1_015).contains(&distance), "{distance}");
    let greatest = drive.greatest_acceleration();
    assert!((95_000..=110_000).contains(&greatest), "{greatest}");
}

#[test]
fn m39_6080h_is_in_revolutions_per_minute() {
    let mut drive = DriveBench::enabled(4);
    // 3200 steps are a revolution: 75 in a minute are 4,000 steps/s.
    drive.write_u32(0x6080, 0, 75);
    drive.begin_move(4_000);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.run_millis(500);
    assert_eq!(drive.read_i32(0x606B, 0), 4_000);
}

#[test]
fn m73_no_factor_changes_while_the_power_stage_is_on() {
    let mut drive = DriveBench::enabled(4);
    for (index, sub, number) in FACTORS {
        refuses(&mut drive, index, sub, &number.to_le_bytes(), 0x0800_0022);
    }
    for (index, sub) in [
        (0x6090, 1),
        (0x60A8, 0),
        (0x60A9, 0),
        (0x60AA, 0),
        (0x60AB, 0),
    ] {
        refuses(&mut drive, index, sub, &[0; 4], 0x0800_0022);
    }
    refuses(&mut drive, 0x607E, 0, &[0x80], 0x0800_0022);
    refuses(&mut drive, 0x607B, 1, &[0; 4], 0x0800_0022);
    drive.command(0x06);
    drive.run_millis(20);
    drive.write_u32(0x6091, 1, 5);
}

#[test]
fn m73_factors_that_are_0_or_make_no_ratio_are_refused() {
    let mut drive = DriveBench::started(4);
    for (index, sub, _) in FACTORS {
        refuses(&mut drive, index, sub, &[0; 4], 0x0609_0030);
    }
    // Each alone can be represented, all together cannot.
    drive.write_u32(0x608F, 1, 4_294_967_291);
    drive.write_u32(0x6091, 1, 4_294_967_279);
    refuses(
        &mut drive,
        0x6092,
        2,
        &4_294_967_231_u32.to_le_bytes(),
        0x0604_0043,
    );
    assert_eq!(drive.read_u32(0x6092, 2), 1);
    refuses(&mut drive, 0x607E, 0, &[0x20], 0x0609_0030);
    refuses(
        &mut drive,
        0x60A8,
        0,
        &0x0002_0000_u32.to_le_bytes(),
        0x0609_0030,
    );
    drive.write_u32(0x60A8, 0, 0xFD01_0000);
    drive.write_u32(0x60A9, 0, 0xFD01_0300);
    drive.write_u32(0x60AA, 0, 0xFD01_5700);
    drive.write_u32(0x60AB, 0, 0xFD01_A000);
    refuses(
        &mut drive,
        0x60A9,
        0,
        &0xFD01_5700_u32.to_le_bytes(),
        0x0609_0030,
    );
}

#[test]
fn m58_polarity_turns_positions_in_profile_position() {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x607E, 0, 0x80);
    drive.write_i32(0x607D, 1, -1_000);
    drive.write_i32(0x607D, 2, 4_000);
    drive.enable();
    drive.begin_move(3_000);
    drive.reaches_target(3_000);
    assert_eq!(drive.position(), -3_000);
    assert_eq!(drive.read_i32(0x6064, 0), 3_000);
    assert_eq!(drive.read_i32(0x6063, 0), -3_000);
    drive.begin_move(9_000);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.run_millis(1_000);
    assert_eq!(drive.position(), -4_000);
    drive.begin_move(-9_000);
    drive.run_millis(2_000);
    assert_eq!(drive.position(), 1_000);
}

/// Enters cyclic synchronous position at 2 ms and follows these set-points, then holds the last one.
fn follow(drive: &mut DriveBench, targets: impl Iterator<Item = i32>) {
    drive.write_u8(0x6060, 0, 8);
    drive.write_u8(0x60C2, 1, 2);
    drive.write_u8(0x60C2, 2, (-3_i8).cast_unsigned());
    drive.write_u8(0x1402, 2, 1);
    drive.enable();
    let mut last = 0;
    for target in [0; 20].into_iter().chain(targets) {
        cycle(drive, target);
        last = target;
    }
    for _ in 0..20 {
        cycle(drive, last);
    }
}

/// A set-point by RPDO 3, then SYNC.
fn cycle(drive: &mut DriveBench, target: i32) {
    let [a, b, c, d] = target.to_le_bytes();
    drive.send_frame(Frame::data_frame(0x404, &[0x0F, 0, a, b, c, d]));
    drive.run_micros(500);
    drive.send("080 [0]");
    drive.run_micros(1_500);
}

#[test]
fn m58_polarity_and_units_hold_for_set_points_at_sync() {
    let mut drive = thirds();
    drive.write_u8(0x607E, 0, 0x80);
    follow(&mut drive, (1..=100).map(|cycle| cycle * 3));
    assert_eq!(drive.position(), -1_000);
    assert_eq!(drive.read_i32(0x6064, 0), 300);
    assert_eq!(drive.read_i32(0x6062, 0), 300);
    cycle(&mut drive, 301);
    for _ in 0..10 {
        cycle(&mut drive, 301);
    }
    assert_eq!(drive.position(), -1_003);
    assert_eq!(drive.read_i32(0x6064, 0), 301);
}

#[test]
fn m59_set_points_at_sync_go_over_the_end_of_a_turn() {
    let mut drive = DriveBench::started(4);
    drive.write_u32(0x6092, 1, 360);
    drive.write_i32(0x607B, 1, 0);
    drive.write_i32(0x607B, 2, 359);
    follow(&mut drive, (1..=400).map(|cycle| cycle % 360));
    assert_eq!(drive.position(), 3_556, "400 degrees");
    assert_eq!(drive.read_i32(0x6064, 0), 40);
}

#[test]
fn m73_a_set_point_very_far_away_leads_in_its_direction() {
    for (target, sign) in [(1_000_000_000, 1), (-1_000_000_000, -1)] {
        let mut drive = DriveBench::started(4);
        // A unit is 153,600 steps: the target is more than 2^47 of them away.
        drive.write_u32(0x608F, 1, 51_200);
        drive.write_u32(0x6091, 1, 3);
        drive.write_u32(0x6092, 1, 1);
        follow(&mut drive, [target; 50].into_iter());
        let position = drive.position() * sign;
        assert!(position > 0, "{position}");
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    }
}

#[test]
fn m59_from_350_to_10_degrees() {
    for (code, steps) in [(0_u16, 89), (1, 89), (2, 3_289), (3, 3_289)] {
        let mut drive = DriveBench::started(4);
        drive.write_u32(0x6092, 1, 360);
        drive.write_i32(0x607B, 1, 0);
        drive.write_i32(0x607B, 2, 359);
        drive.write_u32(0x6081, 0, 1_000);
        drive.enable();
        drive.begin_move(350);
        drive.reaches_target(3_000);
        drive.write_u16(0x60F2, 0, code << 6);
        drive.begin_move(10);
        drive.reaches_target(3_000);
        assert_eq!(drive.position(), steps, "code {code}");
        assert_eq!(drive.read_i32(0x6064, 0), 10);
    }
}

#[test]
fn m57_limits_count_from_home_unless_20e0h_says_otherwise() {
    for (options, end) in [(0, 1_500), (2, 500)] {
        let mut drive = DriveBench::started(4);
        drive.write_u8(0x20E0, 0, options);
        drive.write_i32(0x607D, 1, -500);
        drive.write_i32(0x607D, 2, 500);
        drive.write_i32(0x607C, 0, 1_000);
        drive.write_u8(0x6098, 0, 37);
        drive.write_u8(0x6060, 0, 6);
        drive.enable();
        drive.command(0x1F);
        drive.run_millis(10);
        assert_eq!(drive.read_i32(0x6064, 0), 1_000);
        drive.command(0x0F);
        drive.write_u8(0x6060, 0, 1);
        drive.run_millis(10);
        // By 20E0h = 2 it stands beyond the limits: from within them it goes up to the limit.
        drive.begin_move(0);
        drive.run_millis(2_000);
        drive.begin_move(9_000);
        drive.run_millis(2_000);
        assert_eq!(drive.read_i32(0x6064, 0), end);
    }
    let mut drive = DriveBench::started(4);
    refuses(&mut drive, 0x20E0, 0, &[4], 0x0609_0030);
}

/// Homing where the motor stands (method 37), then profile position again.
fn home_here(drive: &mut DriveBench) {
    drive.write_u8(0x6060, 0, 6);
    drive.run_millis(10);
    drive.command(0x1F);
    drive.run_millis(10);
    drive.command(0x0F);
    drive.write_u8(0x6060, 0, 1);
    drive.run_millis(10);
}

/// A table of a range around zero, homed at 170; its limits 150 to 190 reach over the end of the range. It stands at 185.
fn limits_over_the_end() -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_i32(0x607B, 1, -180);
    drive.write_i32(0x607B, 2, 179);
    drive.write_i32(0x607D, 1, -20);
    drive.write_i32(0x607D, 2, 20);
    drive.write_i32(0x607C, 0, 170);
    drive.write_u8(0x6098, 0, 37);
    drive.enable();
    home_here(&mut drive);
    drive.write_u16(0x60F2, 0, 3 << 6);
    drive.begin_move(-175);
    drive.reaches_target(2_000);
    assert_eq!(drive.position(), 15, "steps from home");
    drive
}

#[test]
fn m57_limits_on_a_rotary_axis_stay_whatever_else_is_written() {
    let mut drive = limits_over_the_end();
    drive.write_u32(0x6067, 0, 10);
    drive.write_u16(0x60F2, 0, 0);
    drive.begin_move(160);
    drive.run_millis(1_000);
    assert_eq!(
        drive.position(),
        20,
        "160 degrees of the next turn are too far"
    );
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.write_u16(0x60F2, 0, 3 << 6);
    drive.begin_move(160);
    drive.reaches_target(2_000);
    assert_eq!(drive.position(), -10);
}

#[test]
fn m57_limits_on_a_rotary_axis_come_along_when_it_is_homed_again() {
    let mut drive = limits_over_the_end();
    drive.write_u32(0x6067, 0, 10);
    home_here(&mut drive);
    assert_eq!(drive.read_i32(0x6064, 0), 170);
    drive.begin_move(160);
    drive.reaches_target(2_000);
    assert_eq!(drive.position(), 5, "ten steps back");
}

#[test]
fn m57_limits_stay_at_home_when_the_units_change() {
    for polarity in [0, 0x80] {
        let mut drive = DriveBench::started(4);
        drive.write_i32(0x607C, 0, 10_000);
        drive.write_u8(0x6098, 0, 37);
        drive.enable();
        home_here(&mut drive);
        drive.command(0x00);
        drive.run_millis(20);
        // Ten of the 3200 steps of a turn are a unit.
        drive.write_u32(0x6092, 1, 320);
        drive.write_u8(0x607E, 0, polarity);
        drive.write_i32(0x607D, 1, -100);
        drive.write_i32(0x607D, 2, 100);
        drive.enable();
        assert_eq!(drive.read_i32(0x6063, 0), 10_000);
        let home = if polarity == 0 { 1_000 } else { -1_000 };
        assert_eq!(drive.read_i32(0x6064, 0), home);
        drive.begin_move(home);
        drive.reaches_target(2_000);
        assert_eq!(drive.read_i32(0x6063, 0), 10_000, "home itself");
        let up = if polarity == 0 { 5_000 } else { -5_000 };
        drive.begin_move(up);
        drive.run_millis(2_000);
        assert_eq!(drive.read_i32(0x6063, 0), 11_000);
        drive.begin_move(-up);
        drive.run_millis(2_000);
        assert_eq!(drive.read_i32(0x6063, 0), 9_000);
    }
}

#[test]
fn m73_whatever_the_factors_extremes_do_no_harm() {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed
    };
    for round in 0..12 {
        let mut drive = DriveBench::started(4);
        for (index, sub, _) in FACTORS {
            let number = (random() as u32) >> (random() % 31);
            // Some make no ratio, and are refused.
            let _ = drive.try_write(index, sub, &number.max(1).to_le_bytes());
        }
        drive.write_u8(0x607E, 0, random() as u8 & 0xC0);
        drive.write_u8(0x6060, 0, [1, 3][round % 2]);
        drive.write_u32(0x6065, 0, u32::MAX);
        drive.enable();
        for target in [i32::MAX, i32::MIN, 0, random() as i32] {
            drive.write_i32(0x60FF, 0, target);
            drive.write_i32(0x607A, 0, target);
            drive.command(0x3F);
            drive.run_millis(10);
            drive.command(0x2F);
            drive.run_millis(10);
        }
        let enabled: State = tests::drive::OPERATION_ENABLED;
        assert!(enabled.is_shown_by(drive.statusword()));
        drive.command(0x02);
        drive.run_millis(2_000);
        let stopped = drive.position();
        drive.run_millis(100);
        assert_eq!(drive.position(), stopped);
    }
}

#[test]
fn m74_units_limits_and_homing_outlive_the_power_and_the_home_position_does_not() {
    let mut drive = thirds();
    drive.write_u8(0x607E, 0, 0x80);
    drive.write_i32(0x607B, 2, 35_999);
    drive.write_i32(0x607B, 1, 0);
    drive.write_i32(0x607D, 1, -20_000);
    drive.write_i32(0x607D, 2, 20_000);
    drive.write_i32(0x607C, 0, 300);
    drive.write_u8(0x6098, 0, 37);
    drive.write_u32(0x6099, 1, 4_000);
    drive.write_u8(0x20E0, 0, 3);
    drive.write_u32(0x60A8, 0, 0xFD01_0000);
    drive.write_u8(0x6060, 0, 6);
    drive.enable();
    drive.command(0x1F);
    drive.run_millis(10);
    assert_eq!(drive.try_read(0x2034, 1), Ok(vec![1]));
    drive.command(0x00);
    drive.run_millis(20);
    drive.queue("604: 23 10 10 01 73 61 76 65");
    drive.drain_until("584: 60 10 10 01 00 00 00 00", 1_000);
    drive.axis().power_cycle();
    drive.drain_until("704 [1] 00", 100);
    for (index, sub, number) in FACTORS {
        assert_eq!(drive.read_u32(index, sub), number, "{index:04X}h:{sub}");
    }
    assert_eq!(drive.try_read(0x607E, 0), Ok(vec![0x80]));
    assert_eq!(drive.read_i32(0x607B, 2), 35_999);
    assert_eq!(drive.read_i32(0x607D, 1), -20_000);
    assert_eq!(drive.read_i32(0x607C, 0), 300);
    assert_eq!(drive.read_u32(0x6099, 1), 4_000);
    assert_eq!(drive.try_read(0x6098, 0), Ok(vec![37]));
    assert_eq!(drive.try_read(0x20E0, 0), Ok(vec![3]));
    assert_eq!(drive.read_u32(0x60A8, 0), 0xFD01_0000);
    assert_eq!(drive.try_read(0x2034, 1), Ok(vec![0]), "not homed");
    drive.start();
    drive.reaches(tests::drive::SWITCH_ON_DISABLED, 20);
    drive.write_u8(0x6060, 0, 6);
    drive.enable();
    drive.run_millis(10);
    assert_eq!(drive.statusword() & (1 << 12), 0, "not homed");
    drive.write_u8(0x6060, 0, 1);
    drive.run_millis(10);
    drive.begin_move(3_000);
    drive.run_millis(1_500);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    assert_eq!(drive.read_i32(0x6064, 0), 3_000);
    assert_eq!(drive.read_i32(0x6063, 0), -10_000);
}

//! Set-points in a row, relative ones, and the limits of their profiles, over the bus.

use tests::DriveBench;
use tests::drive::{ACKNOWLEDGE, INTERNAL_LIMIT, TARGET_REACHED};

/// Hands over a set-point with these bits of the controlword (4, 5, 6 and 9).
fn hand_over(drive: &mut DriveBench, target: i32, bits: u16) {
    drive.write_i32(0x607A, 0, target);
    drive.command(0x0F | bits);
    drive.run_millis(4);
    drive.command(0x0F | bits & !0x10);
    drive.run_millis(4);
}

/// Steps in ten milliseconds.
fn speed(drive: &mut DriveBench) -> i64 {
    let begin = drive.position();
    drive.run_millis(10);
    drive.position() - begin
}

#[test]
fn m30_with_bit_9_a_row_of_targets_is_passed_without_a_stop() {
    let mut drive = DriveBench::enabled(4);
    drive.record_motion();
    hand_over(&mut drive, 4_000, 0x10);
    drive.run_millis(200);
    hand_over(&mut drive, 6_000, 0x210);
    assert_ne!(drive.statusword() & ACKNOWLEDGE, 0, "it waits");
    while drive.position() < 5_500 {
        assert!(speed(&mut drive) >= 99);
        assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    }
    assert_eq!(drive.statusword() & ACKNOWLEDGE, 0, "room again");
    drive.reaches_target(500);
    assert_eq!(drive.position(), 6_000);
    assert!(drive.greatest_acceleration() <= 110_000);
}

#[test]
fn m30_the_end_velocity_6082h_is_kept_until_the_next_set_point() {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6082, 0, 3_000);
    hand_over(&mut drive, 4_000, 0x10);
    drive.run_millis(1_500);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    assert_eq!(drive.read_i32(0x606B, 0), 3_000);
    assert!(drive.position() > 5_000);
    drive.write_u32(0x6082, 0, 0);
    hand_over(&mut drive, -500, 0x10);
    drive.run_millis(100);
    drive.reaches_target(3_000);
    assert_eq!(drive.position(), -500);
}

#[test]
fn m31_60f2h_says_what_relative_set_points_count_from() {
    for option in [0_u16, 1, 2] {
        let mut drive = DriveBench::enabled(4);
        drive.write_u16(0x60F2, 0, option);
        hand_over(&mut drive, 10_000, 0x10);
        drive.run_millis(300);
        let begin = drive.position();
        hand_over(&mut drive, 2_000, 0x70);
        drive.run_millis(1_500);
        let distance = drive.position();
        match option {
            0 => assert_eq!(distance, 12_000),
            _ => assert!(
                (2_000..2_150).contains(&(distance - begin)),
                "{distance}, {begin}"
            ),
        }
    }
    let mut drive = DriveBench::started(4);
    for option in [3_u16, 4, 0x20, 0x100] {
        assert!(drive.try_write(0x60F2, 0, &option.to_le_bytes()).is_err());
    }
}

#[test]
fn m31_the_demand_and_the_actual_position_differ_by_the_following_error() {
    let ends = [1_u16, 2].map(|option| {
        let mut drive = DriveBench::enabled(4);
        drive.write_u32(0x6065, 0, u32::MAX);
        drive.write_u16(0x60F2, 0, option);
        hand_over(&mut drive, 10_000, 0x10);
        drive.run_millis(300);
        drive.axis().plant_mut().displace(-100);
        hand_over(&mut drive, 2_000, 0x70);
        // Before it rests, where it would be a fault.
        drive.axis().plant_mut().displace(100);
        drive.run_millis(1_500);
        drive.position()
    });
    assert_eq!(ends[0] - ends[1], 100, "{ends:?}");
}

#[test]
fn m39_the_maxima_cap_the_profile_and_show_in_bit_11() {
    for (index, maximum) in [
        (0x607F, 4_000),
        (0x6080, 75),
        (0x60C5, 20_000),
        (0x60C6, 20_000),
    ] {
        let mut drive = DriveBench::enabled(4);
        drive.write_u32(index, 0, maximum);
        drive.record_motion();
        hand_over(&mut drive, 10_000, 0x10);
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0, "{index:04X}h");
        let mut fastest = 0;
        while drive.statusword() & TARGET_REACHED == 0 {
            fastest = fastest.max(speed(&mut drive));
        }
        drive.run_millis(50);
        assert_eq!(drive.position(), 10_000);
        let is_slow = fastest <= 41;
        assert_eq!(is_slow, matches!(index, 0x607F | 0x6080), "{index:04X}h");
    }
}

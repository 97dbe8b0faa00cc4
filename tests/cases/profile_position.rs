//! Profile position over the bus: set-points, their acknowledgement, and where the motor ends.

use tests::DriveBench;
use tests::drive::{
    ACKNOWLEDGE, INTERNAL_LIMIT, OPERATION_ENABLED, SWITCH_ON_DISABLED, TARGET_REACHED,
};

#[test]
fn d16_enabling_with_an_old_target_moves_nothing() {
    let mut drive = DriveBench::started(4);
    drive.write_i32(0x607A, 0, 5_000);
    drive.enable();
    drive.run_millis(500);
    assert_eq!(drive.position(), 0);
    assert_eq!(drive.statusword() & ACKNOWLEDGE, 0);
    drive.begin_move(5_000);
    drive.run_millis(500);
    assert_ne!(drive.position(), 0, "with a set-point it does");
}

#[test]
fn d17_the_handshake_of_a_set_point() {
    let mut drive = DriveBench::enabled(4);
    drive.write_i32(0x607A, 0, 5_000);
    drive.command(0x1F);
    drive.run_millis(5);
    assert_eq!(
        drive.statusword() & (ACKNOWLEDGE | TARGET_REACHED),
        ACKNOWLEDGE
    );
    drive.command(0x0F);
    drive.run_millis(5);
    assert_eq!(drive.statusword() & (ACKNOWLEDGE | TARGET_REACHED), 0);
    drive.reaches_target(3_000);
    assert_eq!(drive.position(), 5_000);
}

#[test]
fn d18_one_more_set_point_waits_and_a_third_is_not_taken() {
    let mut drive = DriveBench::enabled(4);
    for target in [10_000, 12_000, 99_000] {
        drive.write_i32(0x607A, 0, target);
        drive.command(0x1F);
        drive.run_millis(5);
        drive.command(0x0F);
        drive.run_millis(5);
    }
    while drive.statusword() & ACKNOWLEDGE != 0 {
        assert!(drive.position() <= 10_000, "the first comes first");
        drive.run_millis(1);
    }
    assert!((9_980..=10_000).contains(&drive.position()));
    drive.run_millis(100);
    drive.reaches_target(5_000);
    assert_eq!(drive.position(), 12_000);
    assert_eq!(drive.statusword() & ACKNOWLEDGE, 0);
}

#[test]
fn d19_change_immediately_turns_round_smoothly() {
    let mut drive = DriveBench::enabled(4);
    drive.record_motion();
    drive.begin_move(50_000);
    drive.run_millis(500);
    drive.write_i32(0x607A, 0, -3_000);
    drive.command(0x3F);
    drive.run_millis(5);
    drive.command(0x2F);
    drive.reaches_target(10_000);
    assert_eq!(drive.position(), -3_000);
    // 100,000 steps/s² on both ramps, and three positions that are rounded to whole steps.
    assert!(
        drive.greatest_acceleration() <= 110_000,
        "{}",
        drive.greatest_acceleration()
    );
}

#[test]
fn r5_a_target_written_again_is_a_set_point_of_its_own() {
    let mut drive = DriveBench::enabled(4);
    for target in [5_000, 5_000, 5_000, 0, 0] {
        for bits in [0x00, 0x20] {
            drive.begin_move(target);
            drive.reaches_target(3_000);
            assert_eq!(drive.position(), i64::from(target));
            // The same once more: nothing to drive, and still the whole handshake.
            drive.write_i32(0x607A, 0, target);
            assert_ne!(drive.statusword() & TARGET_REACHED, 0);
            drive.command(0x1F | bits);
            drive.run_millis(3);
            assert_eq!(
                drive.statusword() & (ACKNOWLEDGE | TARGET_REACHED),
                ACKNOWLEDGE,
                "bit 10 drops with the acknowledgement"
            );
            drive.command(0x0F);
            drive.reaches_target(100);
            assert_eq!(drive.statusword() & ACKNOWLEDGE, 0);
            assert_eq!(drive.position(), i64::from(target));
        }
    }
}

#[test]
fn d20_relative_set_points_add_up() {
    let mut drive = DriveBench::enabled(4);
    for _ in 0..3 {
        drive.write_i32(0x607A, 0, -700);
        drive.command(0x5F);
        drive.run_millis(5);
        drive.command(0x4F);
        drive.reaches_target(3_000);
    }
    assert_eq!(drive.position(), -2_100);
}

#[test]
fn d21_a_software_limit_written_on_the_way_or_in_halt_ends_the_move() {
    for halts in [false, true] {
        let mut drive = DriveBench::enabled(4);
        drive.begin_move(100_000);
        while drive.position() < 20_000 {
            drive.run_millis(10);
        }
        if halts {
            drive.command(0x11F);
            drive.run_millis(300);
            assert_ne!(drive.statusword() & TARGET_REACHED, 0, "halted");
        }
        drive.write_i32(0x607D, 1, -1_000);
        drive.write_i32(0x607D, 2, 50_000);
        drive.command(0x1F);
        drive.run_millis(5);
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
        drive.run_millis(4_000);
        assert_eq!(drive.position(), 50_000);
        assert_eq!(drive.statusword() & TARGET_REACHED, 0);
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    }
}

#[test]
fn d21_a_target_outside_the_software_limits_ends_at_the_limit() {
    let mut drive = DriveBench::enabled(4);
    drive.write_i32(0x607D, 1, -1_000);
    drive.write_i32(0x607D, 2, 2_000);
    drive.begin_move(5_000);
    drive.run_millis(2_000);
    assert_eq!(drive.position(), 2_000);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
}

#[test]
fn d22_target_reached_comes_after_the_window_time() {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6067, 0, 5);
    drive.write_u16(0x6068, 0, 200);
    drive.begin_move(1_000);
    for _ in 0..1_000 {
        if drive.position() == 1_000 {
            break;
        }
        drive.run_millis(1);
    }
    assert_eq!(drive.position(), 1_000);
    drive.run_millis(100);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.run_millis(110);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
}

#[test]
fn m21_mode_0_holds_the_axis() {
    let mut drive = DriveBench::enabled(4);
    drive.write_u8(0x6060, 0, 0);
    drive.run_millis(10);
    assert_eq!(drive.read_i8(0x6061, 0), 0);
    drive.write_i32(0x607A, 0, 1_000);
    drive.command(0x1F);
    drive.run_millis(4);
    assert_eq!(drive.statusword() & 0x3C00, 0, "no bit of a mode");
    drive.reaches(OPERATION_ENABLED, 1);
    drive.command(0x0F);
    drive.run_millis(500);
    assert_eq!(drive.position(), 0);
    drive.write_u8(0x6060, 0, 1);
    drive.run_millis(10);
    drive.begin_move(1_000);
    drive.run_millis(500);
    assert_ne!(drive.position(), 0, "in a mode it does");
}

#[test]
fn m25_a_set_point_bit_that_stays_high_is_taken_once() {
    let mut drive = DriveBench::enabled(4);
    drive.write_i32(0x607A, 0, 1_000);
    for _ in 0..2 {
        drive.command(0x5F);
        drive.run_millis(2_000);
        assert_eq!(drive.position(), 1_000);
        assert_ne!(drive.statusword() & ACKNOWLEDGE, 0, "until bit 4 falls");
    }
    drive.command(0x4F);
    drive.command(0x5F);
    drive.run_millis(2_000);
    assert_eq!(drive.position(), 2_000, "an edge is another one");
}

#[test]
fn m35_halt_ends_in_target_reached_and_release_goes_on() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(20_000);
    drive.run_millis(500);
    drive.command(0x10F);
    drive.run_millis(500);
    let halted = drive.position();
    assert!(halted > 0 && halted < 20_000);
    drive.run_millis(200);
    assert_eq!(drive.position(), halted);
    assert_ne!(drive.statusword() & TARGET_REACHED, 0);
    drive.command(0x0F);
    drive.run_millis(5);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.reaches_target(5_000);
    assert_eq!(drive.position(), 20_000);
}

#[test]
fn m27_target_and_controlword_in_one_rpdo_use_the_new_target() {
    let mut drive = DriveBench::enabled(4);
    // RPDO 3 maps 6040h and 607Ah.
    drive.send("404 [6] 1F 00 E8 03 00 00");
    drive.run_millis(5);
    drive.send("404 [6] 0F 00 E8 03 00 00");
    drive.reaches_target(3_000);
    assert_eq!(drive.position(), 1_000);
}

#[test]
fn m32_a_relative_target_beyond_the_range_is_clipped_not_wrapped() {
    let mut drive = DriveBench::enabled(4);
    drive.write_i32(0x607D, 1, -1_000_000);
    drive.write_i32(0x607D, 2, 3_000);
    drive.begin_move(1_000);
    drive.reaches_target(3_000);
    drive.write_i32(0x607A, 0, i32::MAX);
    drive.command(0x5F);
    drive.run_millis(5);
    drive.command(0x4F);
    drive.run_millis(2_000);
    assert_eq!(drive.position(), 3_000);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
}

#[test]
fn m33_a_target_that_is_already_reached_is_acknowledged() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(500);
    drive.reaches_target(1_000);
    drive.write_i32(0x607A, 0, 500);
    drive.drain(20);
    drive.command(0x1F);
    // Acknowledge and the fall of target reached show in one statusword; then it returns.
    drive.drain_until("184 [2] 37 12", 20);
    drive.command(0x0F);
    drive.reaches_target(100);
    assert_eq!(drive.statusword() & ACKNOWLEDGE, 0);
    assert_eq!(drive.position(), 500);
}

#[test]
fn m37_velocity_0_moves_nothing_and_reaches_nothing() {
    let mut drive = DriveBench::enabled(4);
    let velocity = drive.read_u32(0x6081, 0);
    drive.write_u32(0x6081, 0, 0);
    drive.begin_move(1_000);
    drive.run_millis(1_000);
    assert_eq!(drive.position(), 0);
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    // The control: the same order with a velocity moves the motor and is reached.
    drive.write_u32(0x6081, 0, velocity);
    drive.begin_move(1_000);
    drive.reaches_target(1_000);
    assert_eq!(drive.position(), 1_000);
}

#[test]
fn m38_disabling_forgets_the_target() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(50_000);
    drive.run_millis(500);
    drive.command(0x07);
    drive.run_millis(500);
    let stopped = drive.position();
    assert!(stopped > 0 && stopped < 50_000, "{stopped}");
    drive.command(0x0F);
    drive.reaches(OPERATION_ENABLED, 10);
    drive.run_millis(500);
    assert_eq!(drive.position(), stopped);
    assert_eq!(drive.statusword() & ACKNOWLEDGE, 0);
}

#[test]
fn m39_ramps_of_0_are_refused() {
    let mut drive = DriveBench::started(4);
    drive.refused("604: 23 83 60 00 00 00 00 00", 0x0609_0032);
    drive.refused("604: 23 84 60 00 00 00 00 00", 0x0609_0032);
}

#[test]
fn m07_quick_stop_stops_on_its_own_ramp_and_switches_off() {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6085, 0, 20_000);
    drive.begin_move(100_000);
    drive.run_millis(500);
    let began = drive.position();
    drive.command(0x02);
    drive.reaches(SWITCH_ON_DISABLED, 2_000);
    let distance = drive.position() - began;
    // 10,000 steps/s on 20,000 steps/s²: 2,500 steps, and what is on its way for two milliseconds.
    assert!((2_500..=2_560).contains(&distance), "{distance}");
}

#[test]
fn positions_beyond_32_bits_wrap_alike_in_all_three_objects() {
    let mut drive = DriveBench::started(4);
    // Turned by hand, five steps beyond the end.
    drive.axis().plant_mut().displace(i64::from(i32::MAX) + 5);
    drive.run_millis(5);
    for index in [0x6062, 0x6063, 0x6064] {
        assert_eq!(drive.read_i32(index, 0), i32::MIN + 4, "{index:04X}h");
    }
}

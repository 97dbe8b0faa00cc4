//! The motion profile type 6086h over the bus: trapezoid, sin², moving average. Each lands exactly, in the time that the formulas say. Limited jerk (3) is not
//! built in: it is the moving average.

use tests::DriveBench;
use tests::drive::TARGET_REACHED;

const VELOCITY: u32 = 20_000;
const RAMP: u32 = 100_000;
const JERK: u32 = 400_000;

/// A drive in operation enabled with this profile.
fn enabled(profile: i16) -> DriveBench {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6081, 0, VELOCITY);
    for ramp in [0x6083, 0x6084, 0x6085] {
        drive.write_u32(ramp, 0, RAMP);
    }
    drive.write_u32(0x60A4, 1, JERK);
    drive.write_i16(0x6086, 0, profile);
    drive
}

/// Milliseconds until the motor is at `target`, from now on.
fn time_to(drive: &mut DriveBench, target: i64) -> u64 {
    (0..10_000)
        .find(|_| {
            drive.run_millis(1);
            drive.position() == target
        })
        .unwrap()
}

/// Milliseconds that a move to `target` takes.
fn time_of_move(drive: &mut DriveBench, target: i32) -> u64 {
    drive.begin_move(target);
    // The handshake of the set-point takes 8 ms.
    8 + time_to(drive, target.into())
}

/// Runs at full speed, does `stop`, and returns how far the motor goes from there to rest.
fn way_of_stop(drive: &mut DriveBench, stop: impl FnOnce(&mut DriveBench)) -> i64 {
    drive.begin_move(1_000_000);
    drive.run_millis(1_000);
    let begin = drive.position();
    stop(drive);
    drive.run_millis(1_500);
    let end = drive.position();
    drive.run_millis(100);
    assert_eq!(drive.position(), end, "the motor stands");
    end - begin
}

fn assert_near(value: i64, wanted: i64, slack: i64) {
    assert!((value - wanted).abs() <= slack, "{value}, not {wanted}");
}

#[test]
fn m40_a_profile_type_that_is_not_supported_is_refused() {
    let mut drive = DriveBench::started(4);
    for profile in [-1_i16, 4, 255, i16::MIN, i16::MAX] {
        let refused = drive.try_write(0x6086, 0, &profile.to_le_bytes());
        assert_eq!(refused, Err(0x0609_0030), "{profile}");
        assert_eq!(drive.read_i16(0x6086, 0), 0);
    }
    for profile in [1, 2, 3, 0] {
        drive.write_i16(0x6086, 0, profile);
        assert_eq!(drive.read_i16(0x6086, 0), profile);
    }
}

#[test]
fn m39_a_jerk_of_0_is_refused() {
    let mut drive = DriveBench::started(4);
    assert!(drive.try_write(0x60A4, 1, &[0; 4]).is_err());
    assert_eq!(drive.read_u32(0x60A4, 1), 1_000_000);
    assert!(drive.try_write(0x20A0, 0, &[2]).is_err());
}

#[test]
fn m40_a_profile_counts_from_the_next_set_point() {
    let mut drive = enabled(0);
    drive.begin_move(20_000);
    drive.run_millis(50);
    drive.write_i16(0x6086, 0, 3);
    // A trapezoid takes 0.2 s + 1 s; its mean 0.25 s more.
    let rest = time_to(&mut drive, 20_000) as i64;
    assert_near(rest, 1_200 - 58, 12);
    drive.run_millis(20);
    // The last step comes half a step, or 20 ms, before the end.
    assert_near(time_of_move(&mut drive, 0) as i64, 1_430, 12);
    drive.write_i16(0x6086, 0, 0);
    drive.run_millis(20);
    assert_near(time_of_move(&mut drive, 20_000) as i64, 1_200, 12);
}

#[test]
fn m40_every_profile_lands_in_its_time() {
    for (profile, milliseconds) in [(0, 1_200), (1, 1_195), (2, 1_430), (3, 1_430)] {
        let mut drive = enabled(profile);
        drive.record_motion();
        let time = time_of_move(&mut drive, -20_000) as i64;
        assert_near(time, milliseconds, 12);
        drive.reaches_target(100);
        assert_eq!(drive.position(), -20_000);
        assert_eq!(drive.read_i32(0x6064, 0), -20_000);
        // That of sin² is π/2 times the ramp.
        let most = if profile == 1 { 157_080 } else { 100_000 };
        let greatest = drive.greatest_acceleration();
        assert!(greatest <= most + 15_000, "profile {profile}: {greatest}");
        assert!(profile != 1 || greatest > 130_000, "{greatest}");
    }
}

#[test]
fn m29_a_target_changed_on_the_way_is_reached_with_every_profile() {
    for profile in [1, 2, 3] {
        let mut drive = enabled(profile);
        for after in [40, 150, 400, 1_150, 1_300] {
            drive.begin_move(20_000);
            drive.run_millis(after);
            drive.write_i32(0x607A, 0, 3_000);
            drive.command(0x3F);
            drive.run_millis(5);
            drive.command(0x2F);
            drive.run_millis(5);
            drive.reaches_target(5_000);
            assert_eq!(drive.position(), 3_000, "profile {profile}, {after} ms");
            drive.command(0x0F);
            drive.begin_move(0);
            drive.reaches_target(5_000);
        }
    }
}

/// A sin² ramp that is left on its way first brings its acceleration to zero: that takes at most 1/π of it.
#[test]
fn m29_a_motor_that_turns_round_in_a_ramp_is_back_in_time() {
    // No later than a jerk-limited stop would let it be.
    let latest = [225, 289, 475, 728, 850];
    let times = [1, 20, 60, 150, 400].map(|after| {
        let mut drive = enabled(1);
        drive.begin_move(20_000);
        drive.run_millis(after);
        drive.write_i32(0x607A, 0, -1_000);
        drive.command(0x3F);
        let time = time_to(&mut drive, -1_000);
        drive.reaches_target(100);
        assert_eq!(drive.position(), -1_000);
        time
    });
    let is_late = times
        .iter()
        .zip(latest)
        .any(|(time, latest)| *time > latest);
    assert!(!is_late, "{times:?}");
}

#[test]
fn m35_a_halt_has_the_profile_unless_it_is_on_the_quick_stop_ramp() {
    // At 605Dh = 1 v/2·(v/d + d/j), at 2 v²/2d; and what goes by until the command counts.
    for (profile, option, distance) in [(2, 1, 4_500), (2, 2, 2_000), (3, 1, 4_500), (3, 2, 2_000)]
    {
        let mut drive = enabled(profile);
        drive.write_i16(0x605D, 0, option);
        let real = way_of_stop(&mut drive, |drive| drive.command(0x010F));
        assert_near(real, distance + 60, 80);
        assert_ne!(drive.statusword() & TARGET_REACHED, 0);
        drive.command(0x0F);
        drive.run_millis(1_000);
        assert!(drive.position() > 15_000 + real, "the halt is over");
    }
}

#[test]
fn a_quick_stop_is_linear_unless_it_is_to_be_smooth() {
    for (option, smooth, distance) in [
        (2, 0, 2_000),
        (6, 0, 2_000),
        (2, 1, 4_500),
        (6, 1, 4_500),
        (5, 0, 4_500),
    ] {
        for profile in [2, 3] {
            let mut drive = enabled(profile);
            drive.write_i16(0x605A, 0, option);
            drive.write_u8(0x20A0, 0, smooth);
            let real = way_of_stop(&mut drive, |drive| drive.command(0x02));
            assert_near(real, distance + 60, 80);
        }
    }
}

#[test]
fn the_velocity_modes_have_the_profile() {
    // Up to 20,000 steps/s: the linear ramp takes 0.2 s, and the moving average 0.5 s more; in either case the
    // mean velocity is half.
    for (profile, milliseconds) in [(0, 200), (1, 200), (2, 700), (3, 700)] {
        let mut drive = enabled(profile);
        drive.write_u8(0x6060, 0, 3);
        drive.run_millis(10);
        drive.write_i32(0x60FF, 0, 20_000);
        drive.run_millis(800);
        assert_near(drive.position(), 16_000 - 10 * milliseconds, 150);
        assert_eq!(drive.read_i32(0x606B, 0), 20_000);
        drive.run_millis(100);
        // A change of sign goes through standstill, and a new profile counts from the next velocity on.
        drive.write_i16(0x6086, 0, 0);
        drive.run_millis(10);
        assert_eq!(drive.read_i32(0x606B, 0), 20_000);
        drive.write_i32(0x60FF, 0, -20_000);
        drive.run_millis(406);
        assert_eq!(drive.read_i32(0x606B, 0), -20_000);
    }
}

#[test]
fn m44_a_software_limit_is_kept_with_every_profile() {
    for profile in [1, 2, 3] {
        let mut drive = enabled(profile);
        drive.write_i32(0x607D, 1, -5_000);
        drive.write_i32(0x607D, 2, 12_345);
        drive.write_u8(0x6060, 0, 3);
        drive.run_millis(10);
        drive.write_i32(0x60FF, 0, 20_000);
        drive.run_millis(3_000);
        assert_eq!(drive.position(), 12_345, "profile {profile}");
        drive.write_i32(0x60FF, 0, -20_000);
        for _ in 0..300 {
            drive.run_millis(10);
            assert!((-5_000..=12_345).contains(&drive.position()));
        }
        assert_eq!(drive.position(), -5_000, "profile {profile}");
    }
}

#[test]
fn m30_blending_never_passes_the_last_target() {
    for profile in [1, 2, 3] {
        let mut drive = enabled(profile);
        drive.begin_move(10_000);
        drive.write_i32(0x607A, 0, 12_000);
        drive.command(0x021F);
        drive.run_millis(5);
        drive.command(0x020F);
        for _ in 0..300 {
            drive.run_millis(10);
            assert!(drive.position() <= 12_000, "profile {profile}");
        }
        assert_eq!(drive.position(), 12_000, "profile {profile}");
    }
}

#[test]
fn m40_a_moving_average_is_a_window_late_and_never_jerks() {
    // As near as the ramps come to each other, 10,000 steps from rest to rest take 0.63 s and a window of 0.5 s.
    for (profile, milliseconds) in [(0, 632), (2, 1_132)] {
        let mut drive = enabled(profile);
        drive.write_u32(0x6081, 0, 100_000);
        assert_near(
            time_of_move(&mut drive, 10_000) as i64,
            milliseconds - 15,
            25,
        );
    }
    // Per 10 ms a trapezoid changes its 1,000 steps/s at once. At 60A4h that is 40 more with each 10 ms, and 80 where one ramp follows
    // the other at once; and an answer comes a millisecond or two late.
    assert!(greatest_change(0) >= 900);
    assert!(greatest_change(2) <= 250);
}

/// By how much the acceleration changes at most within 10 ms, in steps/s per 10 ms: in a move with a halt in the ramp, and another velocity
/// on its way.
fn greatest_change(profile: i16) -> i32 {
    let mut drive = enabled(profile);
    drive.begin_move(20_000);
    let (mut last, mut rate, mut greatest) = (drive.read_i32(0x606B, 0), 0, 0);
    for moment in 0..300 {
        match moment {
            20 => drive.command(0x010F),
            60 => drive.command(0x000F),
            90 => {
                drive.write_u32(0x6081, 0, VELOCITY / 2);
                drive.command(0x003F);
            }
            _ => {}
        }
        drive.run_millis(10);
        let velocity = drive.read_i32(0x606B, 0);
        greatest = greatest.max((velocity - last - rate).abs());
        (last, rate) = (velocity, velocity - last);
    }
    drive.reaches_target(1_000);
    assert_eq!(drive.position(), 20_000);
    greatest
}

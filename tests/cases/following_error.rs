//! The following error over the bus: what it shows, and when it is a fault.

use sim::plant::{Axis, Track};
use tests::DriveBench;
use tests::drive::{FAULT, OPERATION_ENABLED, SWITCH_ON_DISABLED};

use crate::cyclic_master::Master;

/// Statusword bit 13 in profile position: following error.
const FOLLOWING_ERROR: u16 = 1 << 13;

/// A drive on its way whose motor is held back by ten steps.
fn displaced(window: u32, time_out: u16) -> DriveBench {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6065, 0, window);
    drive.write_u16(0x6066, 0, time_out);
    drive.begin_move(100_000);
    drive.run_millis(200);
    let error = drive.read_i32(0x60F4, 0);
    assert_eq!(error, 0, "while it follows");
    drive.axis().plant_mut().displace(-10);
    drive.run_millis(2);
    let error = drive.read_i32(0x60F4, 0);
    assert!((9..=11).contains(&error), "{error}");
    drive
}

#[test]
fn m60_and_d21_a_following_error_that_stays_is_a_fault() {
    let mut drive = displaced(5, 50);
    drive.drain(1);
    drive.stays_in(OPERATION_ENABLED, 40);
    drive.drain_until("084: 11 86 ..", 20);
    drive.reaches(FAULT, 200);
    assert_ne!(drive.statusword() & FOLLOWING_ERROR, 0);
    assert_eq!(drive.read_u16(0x603F, 0), 0x8611);
    drive.command(0x00);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
    assert_eq!(drive.statusword() & FOLLOWING_ERROR, 0);
    assert_eq!(drive.read_i32(0x60F4, 0), 0);
    drive.enable();
    drive.stays_in(OPERATION_ENABLED, 100);
}

#[test]
fn m60_without_an_encoder_no_window_is_too_small_for_a_healthy_motor() {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6065, 0, 0);
    drive.write_u16(0x6066, 0, 0);
    drive.write_u32(0x6081, 0, 37_777);
    for target in [20_000, -3_000, 100] {
        drive.command(0x0F);
        drive.begin_move(target);
        for _ in 0..1_500 {
            drive.run_millis(1);
            assert_eq!(drive.axis().actuals().following_error, 0);
        }
        assert_eq!(drive.position(), i64::from(target));
    }
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
}

#[test]
fn m60_a_following_error_within_the_window_or_its_time_is_none() {
    let mut drive = displaced(20, 0);
    drive.stays_in(OPERATION_ENABLED, 500);

    let mut drive = displaced(5, 100);
    drive.run_millis(50);
    drive.axis().plant_mut().displace(10);
    drive.stays_in(OPERATION_ENABLED, 500);
    assert_eq!(drive.statusword() & FOLLOWING_ERROR, 0);
}

#[test]
fn m60_with_6065h_at_its_end_nothing_is_monitored_on_the_way() {
    let mut drive = displaced(u32::MAX, 0);
    drive.stays_in(OPERATION_ENABLED, 500);
}

/// In step with SYNC a control tick is 833 us long at 2.5 ms, and 1 ms at 4 ms.
#[test]
fn m42_606ch_of_a_motor_that_is_stuck_is_0_whatever_the_period_of_sync() {
    for cycle in [1_000, 2_500, 4_000] {
        let axis = Axis {
            encoder: true,
            track: Track {
                stops: Some(-10..=1_000),
                ..Track::default()
            },
            ..Axis::default()
        };
        let mut drive = DriveBench::on(axis);
        drive.write_u32(0x6065, 0, u32::MAX);
        let mut master = Master::of(drive, 8, cycle);
        master.steps([0; 100]);
        let distance = i32::try_from(cycle / 100).unwrap();
        for k in 1..=200 {
            master.steps([k * distance]);
            let actuals = master.drive.axis().actuals();
            if master.drive.position() == 1_000 && actuals.following_error > 16 * distance {
                assert_eq!(actuals.velocity_demand, 10_000);
                let shown = actuals.velocity_actual;
                assert!(shown.abs() <= 100, "{cycle} us: {shown}");
            }
        }
        assert!(
            master.drive.read_i32(0x60F4, 0) > 100 * distance / 2,
            "{cycle} us"
        );
    }
}

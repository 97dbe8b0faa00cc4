//! A motor with a mass: when it loses steps, who sees it, and how it finds home again.

use std::path::Path;

use sim::plant::{Axis, Load, MotorData, SupplyData, Track};
use tests::DriveBench;
use tests::drive::{FAULT, OPERATION_ENABLED, SWITCH_ON_DISABLED, TARGET_REACHED};

/// An electrical turn of the motor: four full steps of 16 steps. Lost steps come in whole ones.
const TURN: i64 = 64;

/// What a motor that is held may be off by friction.
const PLAY: i64 = 3;

/// A motor that drives twice its own inertia with some friction.
fn axis(encoder: bool) -> Axis {
    Axis {
        encoder,
        motor: Some(MotorData {
            load: Load {
                inertia: 600,
                friction: 40,
                drag: 30,
                ..Load::default()
            },
            ..MotorData::default()
        }),
        supply: Some(SupplyData {
            voltage: 48_000,
            ..SupplyData::default()
        }),
        ..Axis::default()
    }
}

/// A drive on an axis that is enabled, and faults once its motor is 100 steps off for 10 ms.
fn enabled(axis: Axis) -> DriveBench {
    let mut drive = DriveBench::on(axis);
    drive.write_u32(0x6065, 0, 100);
    drive.write_u16(0x6066, 0, 10);
    drive.enable();
    drive
}

/// Drives 40,000 steps forward at 50,000 steps/s with this acceleration in steps/s².
fn begin(drive: &mut DriveBench, acceleration: u32) {
    drive.write_u32(0x6081, 0, 50_000);
    drive.write_u32(0x6083, 0, acceleration);
    drive.write_u32(0x6084, 0, acceleration);
    drive.begin_move(40_000);
}

/// How many steps the motor has lost.
fn lost(drive: &mut DriveBench) -> i64 {
    let plant = drive.axis().plant();
    plant.pulses().position() - plant.rotor()
}

/// A ramp that the motor can follow, and one that it cannot.
const GENTLE: u32 = 300_000;
const HARD: u32 = 20_000_000;

#[test]
fn a_motor_that_can_follow_loses_nothing() {
    for encoder in [false, true] {
        let mut drive = enabled(axis(encoder));
        begin(&mut drive, GENTLE);
        drive.reaches_target(3_000);
        drive.stays_in(OPERATION_ENABLED, 200);
        assert!(lost(&mut drive).abs() <= PLAY);
        assert!((drive.read_i32(0x6064, 0) - 40_000).abs() <= 3);
    }
}

#[test]
fn m60_an_encoder_sees_lost_steps_as_a_following_error() {
    let mut drive = enabled(axis(true));
    begin(&mut drive, HARD);
    drive.drain_until("084: 11 86 ..", 500);
    drive.reaches(FAULT, 1_000);
    assert_eq!(drive.read_u16(0x603F, 0), 0x8611);
    assert!(lost(&mut drive) >= TURN);
    // It knows where it is, and goes on from where the field has caught the rotor, which is up to half an electrical turn away.
    drive.write_u32(0x6067, 0, 40);
    drive.command(0x00);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
    drive.enable();
    drive.write_u32(0x6083, 0, GENTLE);
    drive.write_u32(0x6084, 0, GENTLE);
    drive.begin_move(40_000);
    drive.reaches_target(3_000);
    drive.stays_in(OPERATION_ENABLED, 200);
    let off = drive.axis().plant().rotor() - 40_000;
    assert!(off.abs() <= PLAY, "{off}");
}

#[test]
fn without_an_encoder_nobody_sees_lost_steps() {
    let mut drive = enabled(axis(false));
    begin(&mut drive, HARD);
    drive.reaches_target(3_000);
    drive.stays_in(OPERATION_ENABLED, 200);
    assert_eq!(drive.read_i32(0x6064, 0), 40_000);
    assert_eq!(drive.read_i32(0x60F4, 0), 0);
    let lost = lost(&mut drive);
    assert!(lost >= TURN, "{lost}");
    let beside = (lost + TURN / 2).rem_euclid(TURN) - TURN / 2;
    assert!(beside.abs() <= PLAY, "{lost} is no multiple of {TURN}");
}

#[test]
fn steps_that_are_lost_at_rest_are_a_fault_without_any_window() {
    let mut drive = enabled(axis(true));
    drive.write_u32(0x6065, 0, u32::MAX);
    drive.run_millis(10);
    drive.axis().plant_mut().displace(20);
    drive.stays_in(OPERATION_ENABLED, 100);
    assert!(lost(&mut drive).abs() <= PLAY, "its field draws it back");
    drive.axis().plant_mut().displace(TURN);
    drive.reaches(FAULT, 100);
    assert_eq!(drive.read_u16(0x603F, 0), 0x8611);
}

#[test]
fn the_same_run_is_the_same_again() {
    let run = || {
        let mut drive = enabled(axis(true));
        drive.record_motion();
        begin(&mut drive, HARD);
        drive.run_millis(300);
        drive.axis().motion_samples().to_vec()
    };
    let first = run();
    assert!(first.len() > 250);
    assert!(first == run());
}

#[test]
fn m74_without_power_the_motor_runs_down_and_the_encoder_sees_where() {
    let mut drive = enabled(axis(true));
    begin(&mut drive, GENTLE);
    drive.run_millis(400);
    drive.command(0x00);
    drive.reaches(SWITCH_ON_DISABLED, 10);
    let switched_off = drive.axis().plant().rotor();
    drive.run_millis(1_000);
    let rest = drive.axis().plant().rotor();
    assert!(rest > switched_off + 100, "{switched_off} {rest}");
    drive.run_millis(500);
    assert_eq!(
        drive.axis().plant().rotor(),
        rest,
        "friction has stopped it"
    );
    let shown = drive.read_i32(0x6064, 0);
    assert!((i64::from(shown) - rest).abs() <= 1, "{shown} {rest}");
}

/// Enables a drive in homing mode, homes it, and returns where along the axis its position 0 is.
#[track_caller]
fn home(drive: &mut DriveBench, method: i8, speeds: (u32, u32)) -> i64 {
    drive.write_u8(0x6060, 0, 6);
    drive.write_u8(0x6098, 0, method.cast_unsigned());
    drive.write_u32(0x6099, 1, speeds.0);
    drive.write_u32(0x6099, 2, speeds.1);
    drive.write_u32(0x609A, 0, 200_000);
    drive.enable();
    drive.run_millis(5);
    drive.command(0x1F);
    drive.run_millis(4);
    for _ in 0..60_000 {
        if drive.statusword() & TARGET_REACHED != 0 {
            break;
        }
        drive.run_millis(1);
    }
    let bits = drive.statusword() & 0x3400;
    let (failure, place) = (drive.read_u8(0x2034, 2), drive.axis().plant().rotor());
    assert_eq!(bits, 0x1400, "failure {failure} at {place}");
    drive.run_millis(50);
    let shown = drive.read_i32(0x6064, 0);
    drive.axis().plant().rotor() - i64::from(shown)
}

#[test]
fn d25_a_hard_stop_is_felt_by_the_load_angle() {
    for (method, stop) in [(-3, 7_000), (-4, -6_000)] {
        let mut axis = axis(false);
        axis.track = Track {
            stops: Some(-6_000..=7_000),
            ..Track::default()
        };
        if let Some(motor) = &mut axis.motor {
            motor.senses_stall = true;
            motor.load.compliance = 8;
        }
        let mut drive = DriveBench::on(axis);
        let zero = home(&mut drive, method, (4_000, 1_000));
        // Nobody has counted what was lost at the stop: one electrical turn to either side.
        assert!((zero - stop).abs() <= TURN, "method {method}: {zero}");
    }
}

#[test]
fn d25_the_ready_axes_with_a_motor_find_home() {
    let axis = |name: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sim/plants/with_motor");
        Axis::read(&folder.join(name)).unwrap()
    };
    let mut belt = DriveBench::on(axis("belt.toml"));
    let zero = home(&mut belt, 24, (20_000, 1_000));
    assert!((zero - 2_408).abs() <= PLAY, "belt: {zero}");

    let mut lead_screw = DriveBench::on(axis("lead_screw.toml"));
    let zero = home(&mut lead_screw, 1, (20_000, 1_000));
    assert!((zero - 1_100).abs() <= PLAY, "lead screw: {zero}");

    let mut rotary_table = DriveBench::on(axis("rotary_table.toml"));
    let zero = home(&mut rotary_table, 33, (10_000, 1_000));
    let beside = (zero - 640).rem_euclid(3_200);
    assert!(
        (8 - PLAY..=8 + PLAY).contains(&beside),
        "rotary table: {zero}"
    );
}

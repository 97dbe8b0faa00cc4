//! The holding brake of an upright axis: it takes its time, and a drive that does not wait for it lets the load fall or stalls.

use std::path::Path;

use canopen::Duration;
use sim::plant::Axis;
use tests::DriveBench;
use tests::drive::{OPERATION_ENABLED, SWITCHED_ON, TARGET_REACHED};

/// The motor yields so far under its load, in steps.
const PLAY: i64 = 16;

/// The ready axis `name`.
fn ready(name: &str) -> Axis {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sim/plants");
    Axis::read(&folder.join(name)).unwrap()
}

/// A drive on the upright lead screw with these brake times, enabled. It opens in 60 ms and closes in 30 ms.
fn upright(encoder: bool, release: u16, engage: u16) -> DriveBench {
    let mut axis = ready("with_motor/lead_screw.toml");
    if !encoder {
        axis.encoder = false;
        axis.motor.as_mut().unwrap().encoder_counts = None;
    }
    let mut drive = DriveBench::on(axis);
    // The axis brings the right ones along.
    assert_eq!(drive.read_u16(0x2040, 1), 70);
    assert_eq!(drive.read_u16(0x2040, 2), 40);
    drive.write_u16(0x2040, 1, release);
    drive.write_u16(0x2040, 2, engage);
    drive.enable();
    drive
}

/// How far the load falls while operation is disabled on the ramp (605Ch = 1).
fn fall(engage: u16) -> i64 {
    let mut drive = upright(true, 70, engage);
    drive.run_millis(200);
    let before = drive.axis().plant().rotor();
    drive.command(0x07);
    drive.reaches(SWITCHED_ON, 100);
    drive.run_millis(500);
    before - drive.axis().plant().rotor()
}

#[test]
fn m05_power_that_goes_before_the_brake_holds_lets_the_load_fall() {
    assert!(fall(40).abs() <= PLAY, "{}", fall(40));
    let fallen: Vec<i64> = [20, 10, 0].into_iter().map(fall).collect();
    assert!(fallen[0] > PLAY, "{fallen:?}");
    assert!(fallen.is_sorted() && fallen[2] > 200, "{fallen:?}");
    assert_eq!(fall(0), fallen[2], "the same again");
}

#[test]
fn m05_where_the_power_goes_at_once_the_load_falls_until_the_brake_holds() {
    let mut drive = upright(true, 70, 40);
    drive.run_millis(200);
    let before = drive.axis().plant().rotor();
    drive.command(0x00);
    drive.run_millis(25);
    assert!(before - drive.axis().plant().rotor() > PLAY, "it falls");
    drive.run_millis(25);
    let fallen = drive.axis().plant().rotor();
    drive.run_millis(500);
    assert_eq!(drive.axis().plant().rotor(), fallen, "the brake holds");
}

/// A move upwards as soon as the drive is enabled: how many steps it has lost.
fn lost(release: u16) -> i64 {
    let mut drive = upright(false, release, 40);
    drive.write_u32(0x6081, 0, 20_000);
    drive.write_u32(0x6083, 0, 200_000);
    drive.write_u32(0x6084, 0, 200_000);
    let start = drive.axis().plant().rotor();
    drive.begin_move(20_000);
    drive.reaches_target(5_000);
    drive.run_millis(200);
    assert_eq!(drive.position(), 20_000);
    start + 20_000 - drive.axis().plant().rotor()
}

#[test]
fn m05_a_motor_that_sets_off_against_the_closed_brake_loses_steps() {
    assert!(lost(70).abs() <= PLAY, "{}", lost(70));
    assert!(lost(0) >= 64, "{}", lost(0));
}

#[test]
fn m05_an_encoder_tells_of_a_motor_that_set_off_against_the_closed_brake() {
    for (release, is_good) in [(210, true), (0, false)] {
        // With an encoder the drive waits 50 ms for its rotor in any case: a slow brake.
        let mut axis = ready("with_motor/lead_screw.toml");
        axis.motor.as_mut().unwrap().load.brake_release = Duration::millis(200);
        let mut drive = DriveBench::on(axis);
        drive.write_u16(0x2040, 1, release);
        drive.enable();
        drive.write_u32(0x6081, 0, 20_000);
        drive.write_u32(0x6083, 0, 200_000);
        drive.write_u32(0x6084, 0, 200_000);
        drive.begin_move(20_000);
        drive.run_millis(3_000);
        let bits = drive.statusword();
        assert_eq!(OPERATION_ENABLED.is_shown_by(bits), is_good, "{bits:04X}h");
        assert_eq!(bits & TARGET_REACHED != 0, is_good);
        let code = drive.read_u16(0x603F, 0);
        assert_eq!(code, if is_good { 0 } else { 0x8611 });
    }
}

#[test]
fn every_ready_axis_works_as_it_is() {
    for name in [
        "belt.toml",
        "lead_screw.toml",
        "rotary_table.toml",
        "with_motor/belt.toml",
        "with_motor/lead_screw.toml",
        "with_motor/rotary_table.toml",
    ] {
        let mut drive = DriveBench::on(ready(name));
        let start = drive.axis().plant().rotor();
        drive.enable();
        drive.begin_move(2_000);
        drive.reaches_target(5_000);
        drive.run_millis(100);
        let distance = drive.axis().plant().rotor() - start;
        assert!((distance - 2_000).abs() <= PLAY, "{name}: {distance}");
        drive.reaches(OPERATION_ENABLED, 1);
        assert_eq!(drive.read_u16(0x603F, 0), 0, "{name}");
    }
}

#[test]
fn settings_of_an_axis_are_what_restore_leads_back_to() {
    let mut drive = DriveBench::on(ready("belt.toml"));
    assert_eq!(drive.read_u8(0x2032, 0), 0b11);
    drive.write_u8(0x2032, 0, 0b111);
    let save = u32::from_le_bytes(*b"save");
    let load = u32::from_le_bytes(*b"load");
    drive.write_u32(0x1010, 1, save);
    drive.axis().power_cycle();
    drive.run_millis(100);
    assert_eq!(drive.read_u8(0x2032, 0), 0b111, "what was stored counts");
    drive.write_u32(0x1011, 1, load);
    for _ in 0..2 {
        drive.axis().power_cycle();
        drive.run_millis(100);
        assert_eq!(drive.read_u8(0x2032, 0), 0b11);
    }
    // Another reset of the node.
    drive.write_u8(0x2032, 0, 0);
    drive.send("000 [2] 81 04");
    drive.run_millis(100);
    assert_eq!(drive.read_u8(0x2032, 0), 0b11);
}

//! What ends operation of a drive whose motor is moved by its current, and the error codes.

use tests::drive::{FAULT, OPERATION_ENABLED, ServoBench};

use super::{enabled, hold};

/// The drive is in fault within so many milliseconds, with one of these codes, and the motor has no current.
#[track_caller]
fn fails(drive: &mut ServoBench, milliseconds: u64, codes: &[u16]) {
    drive.reaches(FAULT, milliseconds);
    let code = drive.read_u16(0x603F, 0);
    assert!(codes.contains(&code), "{code:04X}h");
    drive.run_millis(50);
    let current = drive.plant().phase_currents();
    let speed = drive.plant().velocity();
    assert!(
        current.iter().all(|current| current.abs() < 0.05),
        "{current:?} A at {speed} rad/s"
    );
}

/// Turning in profile velocity.
fn turning(name: &str) -> ServoBench {
    let mut drive = enabled(name, 3);
    let counts = drive.read_u32(0x608F, 1) as i32;
    drive.write_i32(0x60FF, 0, 10 * counts);
    drive.run_millis(300);
    assert!(drive.read_i32(0x606C, 0) > 8 * counts);
    drive
}

#[test]
fn m45_a_rotor_that_is_held_is_a_fault() {
    for name in ["nema23", "servo_100w"] {
        let mut drive = turning(name);
        hold(&mut drive);
        drive.write_u32(0x6065, 0, u32::MAX);
        fails(&mut drive, 2_000, &[0x7121]);
        drive.plant().load_brake = 0.0;
        drive.command(0x80);
        drive.run_millis(20);
        drive.write_i32(0x60FF, 0, 0);
        drive.enable();
        drive.reaches(OPERATION_ENABLED, 5);
    }
}

#[test]
fn m45_an_encoder_that_is_cut_is_a_fault() {
    for name in ["nema17", "servo_100w", "servo_400w"] {
        let mut drive = turning(name);
        drive.plant().sensor_faults.encoder_is_cut = true;
        fails(&mut drive, 1_500, &[0x7305, 0x7121, 0x8611]);
    }
}

#[test]
fn m45_a_phase_that_is_cut_is_a_fault() {
    for name in ["nema17", "servo_400w"] {
        let mut drive = turning(name);
        drive.plant().load_brake = 0.05;
        drive.plant().cut_phase = Some(1);
        fails(&mut drive, 1_500, &[0x7122, 0x7305, 0x7121, 0x8611]);
    }
}

#[test]
fn m45_a_supply_that_goes_is_a_fault() {
    let mut drive = turning("servo_400w");
    drive.set_supply(false);
    fails(&mut drive, 100, &[0x3220]);
}

#[test]
fn m45_a_following_error_is_a_fault() {
    let mut drive = turning("servo_100w");
    drive.write_u32(0x6065, 0, 500);
    drive.write_u16(0x6066, 0, 10);
    hold(&mut drive);
    fails(&mut drive, 1_500, &[0x8611]);
}

#[test]
fn m45_heat_of_the_stage_is_a_fault() {
    let mut drive = turning("servo_100w");
    drive.axis().plant_mut().temperature = 1_050;
    fails(&mut drive, 500, &[0x4310, 0x4210]);
}

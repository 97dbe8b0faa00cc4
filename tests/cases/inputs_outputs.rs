//! Outputs, analogue input, supply, temperature and motor parameters over the bus.

use canopen::Frame;
use tests::DriveBench;
use tests::drive::{FAULT, OPERATION_ENABLED, SWITCH_ON_DISABLED};

/// Statusword bit 4.
const VOLTAGE: u16 = 1 << 4;
/// Statusword bit 7.
const WARNING: u16 = 1 << 7;

fn outputs(drive: &mut DriveBench) -> u8 {
    drive.run_millis(3);
    drive.axis().plant().outputs()
}

fn nmt(drive: &mut DriveBench, command: u8) {
    drive.send_frame(Frame::data_frame(0, &[command, 4]));
}

fn supply(drive: &mut DriveBench, millivolts: u32) {
    drive.axis().plant_mut().supply_voltage = millivolts;
    drive.run_millis(3);
}

fn temperature(drive: &mut DriveBench, tenths: i16) {
    drive.axis().plant_mut().temperature = tenths;
    drive.run_millis(3);
}

#[test]
fn m71_only_masked_outputs_change() {
    let mut drive = DriveBench::started(4);
    drive.write_u32(0x60FE, 1, 0xFFFF_FFFF);
    assert_eq!(outputs(&mut drive), 0, "the mask is 0");
    drive.write_u32(0x60FE, 2, 0x0005_0000);
    assert_eq!(outputs(&mut drive), 0b0101);
    drive.write_u32(0x60FE, 1, 0);
    assert_eq!(outputs(&mut drive), 0);
    drive.write_u32(0x60FE, 1, 0x000A_0000);
    assert_eq!(outputs(&mut drive), 0);
    assert_eq!(drive.read_u32(0x60FE, 1), 0x000A_0000, "reads as written");
}

#[test]
fn m71_the_brake_is_the_state_machines_unless_2063h_lets_60feh_move_it() {
    let mut drive = DriveBench::enabled(4);
    let is_open = |drive: &mut DriveBench| {
        drive.run_millis(3);
        drive.axis().plant().is_brake_open()
    };
    assert!(is_open(&mut drive));
    drive.write_u32(0x60FE, 2, 1);
    drive.write_u32(0x60FE, 1, 1);
    assert!(is_open(&mut drive), "it is not the master's");
    drive.write_u8(0x2063, 0, 1);
    assert!(!is_open(&mut drive));
    drive.write_i32(0x607A, 0, 5_000);
    drive.command(0x1F);
    drive.run_millis(100);
    assert_eq!(drive.position(), 0, "the set-point waits for the brake");
    drive.write_u32(0x60FE, 1, 0);
    drive.run_millis(500);
    assert!(drive.position() > 0);
    drive.command(0x00);
    drive.reaches(SWITCH_ON_DISABLED, 1_000);
    assert!(is_open(&mut drive), "an axis may be moved by hand");
    drive.write_u8(0x2063, 0, 0);
    assert!(!is_open(&mut drive));
}

#[test]
fn m71_outputs_are_at_rest_without_the_network_and_until_they_are_written_again() {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x2062, 0, 0b0010);
    drive.write_u32(0x60FE, 2, 0x000F_0000);
    drive.write_u32(0x60FE, 1, 0x0003_0000);
    assert_eq!(outputs(&mut drive), 0b0011);
    nmt(&mut drive, 0x02);
    assert_eq!(outputs(&mut drive), 0b0010, "stopped; 2062h keeps output 2");
    nmt(&mut drive, 0x01);
    assert_eq!(outputs(&mut drive), 0b0010);
    drive.write_u32(0x60FE, 1, 0x0003_0000);
    assert_eq!(outputs(&mut drive), 0b0011);
    nmt(&mut drive, 0x81);
    drive.run_millis(20);
    assert_eq!(outputs(&mut drive), 0, "a reset forgets 2062h as well");
}

#[test]
fn outputs_show_functions_of_the_drive() {
    let mut drive = DriveBench::started(4);
    // Fault, operation enabled, moving, brake.
    for (sub, function) in [(1, 1), (2, 3), (3, 6), (4, 8)] {
        drive.write_u8(0x2060, sub, function);
    }
    assert_eq!(outputs(&mut drive), 0);
    drive.enable();
    assert_eq!(outputs(&mut drive), 0b1010);
    drive.begin_move(20_000);
    assert_eq!(outputs(&mut drive), 0b1110);
    drive.set_fault(Some(0x5400));
    drive.reaches(FAULT, 100);
    assert_eq!(outputs(&mut drive), 0b0001);
    drive.write_u8(0x2061, 0, 0b0011);
    assert_eq!(outputs(&mut drive), 0b0010, "inverted");
    let refused = drive.try_write(0x2060, 1, &[9]);
    assert_eq!(refused, Err(0x0609_0031));
}

#[test]
fn m13_the_supply_is_there_above_its_threshold_in_every_state() {
    let mut drive = DriveBench::started(4);
    drive.run_millis(20);
    assert_eq!(drive.read_u32(0x6079, 0), 24_000);
    assert_ne!(drive.statusword() & VOLTAGE, 0);
    supply(&mut drive, 8_999);
    assert_eq!(drive.statusword() & VOLTAGE, 0);
    assert!(SWITCH_ON_DISABLED.is_shown_by(drive.statusword()));
    supply(&mut drive, 9_499);
    assert_eq!(drive.statusword() & VOLTAGE, 0, "the hysteresis");
    supply(&mut drive, 9_500);
    assert_ne!(drive.statusword() & VOLTAGE, 0);
    supply(&mut drive, 24_000);
    drive.enable();
    drive.drain(1);
    supply(&mut drive, 8_000);
    drive.drain_until("084: 20 32 ..", 10);
    drive.reaches(FAULT, 10);
    assert_eq!(drive.read_u16(0x603F, 0), 0x3220);
    drive.write_u32(0x2073, 1, 5_000);
    drive.run_millis(5);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
}

#[test]
fn m13_too_much_supply_is_a_fault_that_stands_while_it_lasts() {
    let mut drive = DriveBench::enabled(4);
    drive.drain(1);
    supply(&mut drive, 60_000);
    drive.drain_until("084: 10 32 ..", 10);
    drive.reaches(FAULT, 10);
    assert!(!drive.axis().plant().is_energised());
    supply(&mut drive, 59_500);
    drive.command(0x80);
    drive.run_millis(5);
    assert!(
        FAULT.is_shown_by(drive.statusword()),
        "within the hysteresis"
    );
    supply(&mut drive, 24_000);
    drive.command(0x00);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
}

#[test]
fn m14_supply_and_temperature_warn_and_change_no_state() {
    let mut drive = DriveBench::enabled(4);
    drive.drain(1);
    supply(&mut drive, 9_999);
    drive.drain_until("084: 20 31 ..", 10);
    assert_ne!(drive.statusword() & WARNING, 0);
    supply(&mut drive, 56_000);
    drive.drain_until("084: 10 31 ..", 10);
    temperature(&mut drive, 800);
    drive.drain_until("084: 10 43 ..", 10);
    supply(&mut drive, 24_000);
    drive.stays_in(OPERATION_ENABLED, 20);
    assert_ne!(drive.statusword() & WARNING, 0);
    temperature(&mut drive, 751);
    drive.run_millis(20);
    assert_ne!(drive.statusword() & WARNING, 0, "the hysteresis");
    assert_eq!(drive.read_i16(0x2074, 1), 751);
    temperature(&mut drive, 749);
    assert_eq!(drive.statusword() & WARNING, 0);
    assert_eq!(drive.read_u16(0x603F, 0), 0, "warnings are no faults");
    assert_eq!(drive.read_u8(0x1001, 0), 0);
}

#[test]
fn m14_too_hot_the_motor_stops_as_605eh_says() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(1_000_000);
    drive.run_millis(200);
    temperature(&mut drive, 900);
    drive.reaches(FAULT, 2_000);
    assert_eq!(drive.read_u16(0x603F, 0), 0x4210);
    drive.command(0x80);
    drive.run_millis(5);
    assert!(FAULT.is_shown_by(drive.statusword()), "still hot");
    temperature(&mut drive, 500);
    drive.command(0x00);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
}

#[test]
fn the_current_follows_the_motion() {
    let mut drive = DriveBench::started(4);
    drive.write_u16(0x2070, 1, 2_000);
    drive.write_u16(0x2070, 2, 700);
    drive.write_u16(0x2070, 3, 2_500);
    drive.write_u16(0x2070, 4, 300);
    let current = |drive: &mut DriveBench| drive.axis().plant().current();
    assert_eq!(current(&mut drive), 0, "no power");
    drive.enable();
    drive.run_millis(5);
    assert_eq!(current(&mut drive), 2_000);
    drive.run_millis(300);
    assert_eq!(current(&mut drive), 700);
    drive.write_u32(0x6083, 0, 100_000);
    drive.write_u32(0x6081, 0, 20_000);
    drive.begin_move(20_000);
    drive.run_millis(50);
    assert_eq!(current(&mut drive), 2_500, "it accelerates");
    drive.run_millis(400);
    assert_eq!(current(&mut drive), 2_000, "it cruises");
    drive.reaches_target(10_000);
    assert_eq!(current(&mut drive), 2_000, "it has just come");
    drive.run_millis(300);
    assert_eq!(current(&mut drive), 700);
    drive.command(0x00);
    drive.run_millis(5);
    assert_eq!(current(&mut drive), 0);
}

#[test]
fn the_motor_turns_the_other_way_by_2072h() {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x2072, 0, 1);
    drive.enable();
    drive.begin_move(5_000);
    drive.reaches_target(10_000);
    assert_eq!(drive.axis().plant().rotor(), -5_000);
    assert_eq!(drive.read_i32(0x6064, 0), 5_000);
    let refused = drive.try_write(0x2072, 0, &[0]);
    assert_eq!(refused, Err(0x0800_0022), "not while there is power");
    drive.command(0x00);
    drive.reaches(SWITCH_ON_DISABLED, 1_000);
    drive.write_u8(0x2072, 0, 0);
    drive.run_millis(5);
    assert_eq!(drive.read_i32(0x6064, 0), 5_000, "the motor has not moved");
    drive.enable();
    drive.begin_move(6_000);
    drive.reaches_target(10_000);
    assert_eq!(drive.axis().plant().rotor(), -4_000);
}

#[test]
fn the_microstep_reaches_the_motor_driver() {
    let mut drive = DriveBench::started(4);
    assert_eq!(drive.axis().plant().microsteps(), 16);
    drive.write_u16(0x2071, 0, 64);
    drive.run_millis(3);
    assert_eq!(drive.axis().plant().microsteps(), 64);
    let refused = drive.try_write(0x2071, 0, &48_u16.to_le_bytes());
    assert_eq!(refused, Err(0x0609_0030), "not a power of two");
}

#[test]
fn the_analogue_input_shows_as_it_is_in_volts_and_smoothed() {
    let mut drive = DriveBench::started(4);
    drive.write_u16(0x2064, 6, 100);
    drive.axis().plant_mut().analogue = 4095;
    drive.run_millis(100);
    assert_eq!(drive.read_u16(0x2064, 1), 4095);
    assert_eq!(drive.read_i32(0x2064, 2), 10_000);
    let smooth = drive.read_i32(0x2064, 3);
    assert!((5_500..7_500).contains(&smooth), "{smooth}");
    drive.run_millis(2_000);
    assert_eq!(drive.read_i32(0x2064, 3), 10_000);
    drive.write_i32(0x2064, 4, 20_000);
    drive.write_i32(0x2064, 5, -10_000);
    drive.axis().plant_mut().analogue = 0;
    drive.run_millis(2_000);
    assert_eq!(drive.read_i32(0x2064, 3), -10_000);
}

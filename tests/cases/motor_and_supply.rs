//! What the drive parameters mean to a motor with a mass: its currents, its microsteps, its supply and its temperature.

use canopen::Duration;
use sim::drive::Setup;
use sim::plant::{Axis, Heat, Load, MotorData, SupplyChange, SupplyData};
use tests::DriveBench;
use tests::drive::{FAULT, OPERATION_ENABLED, SWITCH_ON_DISABLED};

/// Statusword bit 4, voltage enabled, and bit 7, warning.
const VOLTAGE: u16 = 1 << 4;
const WARNING: u16 = 1 << 7;

/// Motor currents: run, hold, boost.
const CURRENTS: u16 = 0x2070;

fn motor() -> MotorData {
    MotorData {
        load: Load {
            inertia: 600,
            friction: 40,
            drag: 30,
            ..Load::default()
        },
        ..MotorData::default()
    }
}

/// A drive in operation enabled with these currents in milliamperes, on this axis.
fn enabled(axis: Axis, currents: [u16; 3]) -> DriveBench {
    let mut drive = DriveBench::on(axis);
    for (sub, current) in (1..).zip(currents) {
        drive.write_u16(CURRENTS, sub, current);
    }
    drive.enable();
    drive
}

fn on_motor(motor: MotorData) -> Axis {
    Axis {
        motor: Some(motor),
        supply: Some(SupplyData {
            voltage: 48_000,
            ..SupplyData::default()
        }),
        ..Axis::default()
    }
}

/// How many steps the motor is behind its pulses after a move with this acceleration in steps/s².
fn lost(drive: &mut DriveBench, acceleration: u32) -> i64 {
    drive.write_u32(0x6081, 0, 30_000);
    drive.write_u32(0x6083, 0, acceleration);
    drive.write_u32(0x6084, 0, acceleration);
    drive.begin_move(30_000);
    drive.reaches_target(5_000);
    drive.run_millis(200);
    let plant = drive.axis().plant();
    plant.pulses().position() - plant.rotor()
}

/// An acceleration for 2 A but not for 0.6 A, in steps/s².
const QUICK: u32 = 2_000_000;

#[test]
fn the_run_current_decides_how_hard_a_motor_can_be_accelerated() {
    let lost = |currents, acceleration| {
        lost(&mut enabled(on_motor(motor()), currents), acceleration).abs() >= 64
    };
    assert!(!lost([2_000, 500, 0], QUICK));
    assert!(lost([600, 500, 0], QUICK));
    assert!(!lost([600, 500, 0], QUICK / 10));
    assert!(
        !lost([600, 500, 2_000], QUICK),
        "the boost current bears the ramps"
    );
}

#[test]
fn the_hold_current_holds_a_weight_or_does_not() {
    let held = |hold| {
        let mut motor = motor();
        motor.load.torque = -300;
        let mut drive = enabled(on_motor(motor), [2_000, hold, 0]);
        drive.stays_in(OPERATION_ENABLED, 400);
        assert!(
            drive.axis().plant().rotor() > -16,
            "the run current before the hold delay"
        );
        drive.stays_in(OPERATION_ENABLED, 1_000);
        drive.axis().plant().rotor() > -16
    };
    assert!(held(1_000));
    assert!(!held(300));
}

#[test]
fn finer_microsteps_go_a_shorter_way() {
    for (microsteps, distance) in [(8, 2_000), (16, 1_000), (32, 500)] {
        let setup = Setup {
            axis: Some(on_motor(motor())),
            ..Setup::with_node_id(1, 4)
        };
        let mut drive = DriveBench::with(setup, 4);
        drive.start();
        drive.reaches(SWITCH_ON_DISABLED, 20);
        drive.write_u16(0x2071, 0, microsteps);
        drive.run_millis(5);
        drive.enable();
        drive.begin_move(1_000);
        drive.reaches_target(2_000);
        drive.run_millis(100);
        assert_eq!(drive.read_i32(0x6064, 0), 1_000);
        let rotor = drive.axis().plant().rotor();
        assert!((rotor - distance).abs() <= 2, "{microsteps}: {rotor}");
    }
}

/// A supply of 24 V that has another voltage from 1 s on for 200 ms.
fn changing(voltage: u32) -> Axis {
    Axis {
        supply: Some(SupplyData {
            changes: vec![SupplyChange {
                at: Duration::from_ticks(1_000_000),
                duration: Duration::from_ticks(200_000),
                voltage,
            }],
            ..SupplyData::default()
        }),
        ..Axis::default()
    }
}

#[test]
fn m13_a_dip_and_a_surge_of_the_supply_are_faults() {
    for (voltage, code, emergency, is_voltage_enabled) in [
        (7_000, 0x3220, "084: 20 32 ..", false),
        (65_000, 0x3210, "084: 10 32 ..", true),
    ] {
        let mut drive = enabled(changing(voltage), [1_000, 500, 0]);
        drive.drain_until(emergency, 1_100);
        drive.reaches(FAULT, 20);
        assert_eq!(drive.read_u16(0x603F, 0), code);
        let shown = drive.statusword() & VOLTAGE != 0;
        assert_eq!(shown, is_voltage_enabled, "{code:04X}h");
        assert!(!drive.axis().plant().is_energised());
        // While it lasts it cannot be reset.
        drive.command(0x80);
        drive.stays_in(FAULT, 100);
        drive.run_millis(150);
        drive.command(0x00);
        drive.command(0x80);
        drive.reaches(SWITCH_ON_DISABLED, 20);
        drive.enable();
        drive.stays_in(OPERATION_ENABLED, 100);
    }
}

#[test]
fn a_weak_supply_sags_under_a_working_motor() {
    let mut axis = on_motor(motor());
    axis.supply = Some(SupplyData {
        voltage: 24_000,
        resistance: 4_000,
        changes: Vec::new(),
    });
    let mut drive = enabled(axis, [2_800, 2_800, 0]);
    drive.write_u32(0x6083, 0, 100_000);
    drive.write_u32(0x6081, 0, 15_000);
    drive.begin_move(1_000_000);
    drive.run_millis(1_000);
    let loaded = drive.axis().plant().supply_voltage;
    assert!((15_000..23_000).contains(&loaded), "{loaded} mV");
}

#[test]
fn m14_a_motor_that_gets_hot_is_a_warning_and_then_a_fault() {
    let hot = MotorData {
        heat: Heat {
            ambient: 25,
            rise: 100,
            time_constant: Duration::from_ticks(5_000_000),
        },
        ..motor()
    };
    let mut drive = enabled(on_motor(hot), [2_800, 2_800, 0]);
    drive.run_millis(2_000);
    assert_eq!(drive.statusword() & WARNING, 0);
    drive.drain_until("084: 10 43 ..", 3_000);
    assert_ne!(drive.statusword() & WARNING, 0);
    drive.stays_in(OPERATION_ENABLED, 200);
    drive.drain_until("084: 10 42 ..", 3_000);
    drive.reaches(FAULT, 100);
    assert_eq!(drive.read_u16(0x603F, 0), 0x4210);
    // Without current it cools down.
    drive.run_millis(5_000);
    drive.command(0x00);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 20);
    assert_eq!(drive.statusword() & WARNING, 0);
}

//! The CiA 402 state machine over the bus: controlword in, statusword out.

use tests::DriveBench;
use tests::drive::{
    FAULT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON, SWITCH_ON_DISABLED,
    SWITCHED_ON,
};

#[test]
fn d01_power_on_ends_in_switch_on_disabled_by_itself() {
    let mut drive = DriveBench::started(4);
    drive.reaches(SWITCH_ON_DISABLED, 10);
    drive.stays_in(SWITCH_ON_DISABLED, 500);
}

#[test]
fn d02_shutdown_switch_on_enable_operation() {
    let mut drive = DriveBench::started(4);
    for (controlword, state) in [
        (0x06, READY_TO_SWITCH_ON),
        (0x07, SWITCHED_ON),
        (0x0F, OPERATION_ENABLED),
    ] {
        drive.command(controlword);
        drive.reaches(state, 10);
    }
}

#[test]
fn d03_enable_operation_does_nothing_in_switch_on_disabled() {
    let mut drive = DriveBench::started(4);
    for controlword in [0x0F, 0x07] {
        drive.command(controlword);
        drive.stays_in(SWITCH_ON_DISABLED, 100);
    }
    // Not before "shutdown".
    drive.command(0x06);
    drive.reaches(READY_TO_SWITCH_ON, 10);
}

#[test]
fn d04_enable_operation_passes_switched_on() {
    let mut drive = DriveBench::started(4);
    drive.command(0x06);
    drive.reaches(READY_TO_SWITCH_ON, 10);
    drive.command(0x0F);
    drive.reaches(OPERATION_ENABLED, 10);
}

#[test]
fn d05_every_way_down_from_operation_enabled() {
    for (controlword, state) in [
        (0x07, SWITCHED_ON),
        (0x06, READY_TO_SWITCH_ON),
        (0x00, SWITCH_ON_DISABLED),
    ] {
        let mut drive = DriveBench::enabled(4);
        drive.command(controlword);
        drive.reaches(state, 10);
        drive.stays_in(state, 100);
    }
    let mut drive = DriveBench::enabled(4);
    drive.write_i16(0x605A, 0, 6);
    drive.command(0x02);
    drive.reaches(QUICK_STOP_ACTIVE, 10);
    drive.stays_in(QUICK_STOP_ACTIVE, 100);
}

#[test]
fn d06_quick_stop_and_disable_voltage_below_operation_enabled() {
    for controlword in [0x02, 0x00] {
        let mut drive = DriveBench::started(4);
        drive.command(0x06);
        drive.reaches(READY_TO_SWITCH_ON, 10);
        drive.command(controlword);
        drive.reaches(SWITCH_ON_DISABLED, 10);

        let mut drive = DriveBench::started(4);
        drive.command(0x06);
        drive.reaches(READY_TO_SWITCH_ON, 10);
        drive.command(0x07);
        drive.reaches(SWITCHED_ON, 10);
        drive.command(controlword);
        drive.reaches(SWITCH_ON_DISABLED, 10);
    }
}

#[test]
fn d09_and_m10_a_fault_while_moving_stops_the_motor_and_is_reported_once() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(100_000);
    drive.run_millis(200);
    drive.drain(1);
    drive.set_fault(Some(0x4210));
    let emergency = drive.drain_until("084: xx ..", 10);
    assert_eq!(emergency.payload()[..2], [0x10, 0x42]);
    drive.reaches(FAULT, 1_000);
    assert_eq!(drive.read_u16(0x603F, 0), 0x4210);
    let stopped = drive.position();
    drive.run_millis(200);
    assert_eq!(drive.position(), stopped);
    assert!(stopped > 0);
}

#[test]
fn d10_fault_reset_takes_a_rising_edge_after_the_cause_is_gone() {
    let mut drive = DriveBench::enabled(4);
    drive.command(0x8F);
    drive.set_fault(Some(0x4210));
    drive.reaches(FAULT, 100);
    drive.set_fault(None);
    drive.stays_in(FAULT, 100);
    drive.command(0x8F);
    drive.stays_in(FAULT, 100);
    drive.command(0x00);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
}

#[test]
fn d11_an_edge_between_two_control_ticks_is_not_missed() {
    let mut drive = DriveBench::enabled(4);
    drive.set_fault(Some(0x4210));
    drive.reaches(FAULT, 100);
    drive.set_fault(None);
    drive.command(0x00);
    drive.run_millis(5);
    drive.queue("204 [2] 80 00");
    drive.queue("204 [2] 00 00");
    drive.reaches(SWITCH_ON_DISABLED, 10);
}

#[test]
fn d12_a_fault_that_persists_returns_with_a_new_emergency() {
    let mut drive = DriveBench::enabled(4);
    drive.set_fault(Some(0x4210));
    drive.reaches(FAULT, 100);
    drive.drain(10);
    drive.command(0x80);
    drive.drain_until("084: 10 42 ..", 10);
    drive.reaches(FAULT, 10);
    drive.stays_in(FAULT, 100);
}

#[test]
fn d13_a_mode_that_is_not_there_is_refused() {
    let mut drive = DriveBench::started(4);
    for mode in [0x05, 0x04, 0xFF, 0x80] {
        drive.refused(&format!("604: 2F 60 60 00 {mode:02X}"), 0x0609_0030);
        assert_eq!(drive.read_i8(0x6061, 0), 1);
    }
}

#[test]
fn d30_nmt_stop_while_moving_stops_the_motor_and_nothing_jumps_at_return() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(100_000);
    drive.run_millis(300);
    drive.send("000 [2] 02 04");
    drive.run_millis(1_000);
    let stopped = drive.position();
    assert!(stopped > 0 && stopped < 100_000, "{stopped}");
    drive.send("000 [2] 01 04");
    drive.run_millis(500);
    assert_eq!(drive.position(), stopped);
    drive.reaches(SWITCH_ON_DISABLED, 10);
}

#[test]
fn n18_reset_node_while_moving_stops_first_then_boots() {
    let mut drive = DriveBench::enabled(4);
    drive.begin_move(100_000);
    drive.run_millis(300);
    drive.drain(1);
    let moving = drive.position();
    drive.send("000 [2] 81 04");
    drive.drain_until("704 [1] 00", 2_000);
    let stopped = drive.position();
    assert!(stopped > moving, "a ramp, not a cut");
    drive.run_millis(500);
    assert_eq!(drive.position(), stopped);
    drive.send("000 [2] 01 04");
    drive.reaches(SWITCH_ON_DISABLED, 50);
}

#[test]
fn d32_the_supported_modes_are_those_that_are_accepted() {
    let mut drive = DriveBench::started(4);
    let supported = drive.read_u32(0x6502, 0);
    for mode in i8::MIN..=i8::MAX {
        let accepted = drive.try_write(0x6060, 0, &mode.to_le_bytes()).is_ok();
        let expected = match mode {
            0 => true,
            1..=32 => supported >> (mode - 1) & 1 == 1,
            _ => false,
        };
        assert_eq!(accepted, expected, "mode {mode}");
    }
}

#[test]
fn m13_voltage_enabled_follows_the_supply() {
    let mut drive = DriveBench::started(4);
    drive.run_millis(10);
    assert_ne!(drive.statusword() & 0x10, 0);
    drive.set_supply(false);
    drive.run_millis(10);
    assert_eq!(drive.statusword() & 0x10, 0);
}

#[test]
fn m14_a_warning_shows_in_bit_7_and_by_an_emergency_and_changes_no_state() {
    let mut drive = DriveBench::enabled(4);
    drive.drain(1);
    drive.axis().plant_mut().warning = Some(0x4210);
    drive.drain_until("084: 10 42 ..", 10);
    assert_ne!(drive.statusword() & 0x80, 0);
    drive.stays_in(OPERATION_ENABLED, 50);
    drive.axis().plant_mut().warning = None;
    drive.drain_until("084: 00 00 ..", 10);
    assert_eq!(drive.statusword() & 0x80, 0);
    assert_eq!(drive.read_u16(0x603F, 0), 0);
}

#[test]
fn m17_reserved_bits_of_the_controlword_read_back() {
    let mut drive = DriveBench::started(4);
    drive.write_u16(0x6040, 0, 0xF806);
    assert_eq!(drive.read_u16(0x6040, 0), 0xF806);
    drive.reaches(READY_TO_SWITCH_ON, 10);
}

#[test]
fn commands_faster_than_the_control_tick_still_lead_up() {
    let mut drive = DriveBench::started(4);
    for command in ["204 [2] 06 00", "204 [2] 07 00", "204 [2] 0F 00"] {
        drive.queue(command);
    }
    drive.reaches(OPERATION_ENABLED, 10);

    drive.set_fault(Some(0x4210));
    drive.reaches(FAULT, 100);
    drive.set_fault(None);
    drive.run_millis(5);
    for command in [
        "204 [2] 00 00",
        "204 [2] 80 00",
        "204 [2] 06 00",
        "204 [2] 0F 00",
    ] {
        drive.queue(command);
    }
    drive.reaches(OPERATION_ENABLED, 10);
}

#[test]
fn a_stop_between_fast_commands_is_not_passed_over() {
    for stop in ["204 [2] 00 00", "204 [2] 02 00"] {
        let mut drive = DriveBench::started(4);
        for command in ["204 [2] 06 00", stop, "204 [2] 0F 00"] {
            drive.queue(command);
        }
        drive.run_millis(10);
        drive.stays_in(SWITCH_ON_DISABLED, 50);
    }
}

#[test]
fn fast_commands_do_not_outlive_the_network() {
    let mut drive = DriveBench::started(4);
    for frame in ["204 [2] 06 00", "204 [2] 0F 00"] {
        drive.send(frame);
    }
    drive.send("000 [2] 02 04");
    drive.run_millis(500);
    drive.send("000 [2] 01 04");
    drive.run_millis(10);
    drive.stays_in(SWITCH_ON_DISABLED, 100);
}

#[test]
fn fast_commands_in_fault_do_not_wait_for_a_reset() {
    let mut drive = DriveBench::enabled(4);
    drive.set_fault(Some(0x4210));
    drive.reaches(FAULT, 100);
    drive.queue("204 [2] 06 00");
    drive.queue("204 [2] 0F 00");
    drive.run_millis(1_000);
    drive.set_fault(None);
    drive.run_millis(10);
    drive.queue("204 [2] 80 00");
    drive.queue("204 [2] 0F 00");
    drive.run_millis(10);
    drive.stays_in(SWITCH_ON_DISABLED, 100);
}

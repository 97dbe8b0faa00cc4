//! The option codes over the bus: how the motor comes to rest on each occasion, and in which state the drive ends.

use canopen::ControllerState;
use master::bus::Station;
use tests::DriveBench;
use tests::drive::{
    FAULT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON, SWITCH_ON_DISABLED,
    SWITCHED_ON, State,
};

/// A drive that cruises at 10,000 steps/s. Slowing down takes 1000 steps, a quick stop 250.
fn cruising() -> DriveBench {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6084, 0, 50_000);
    drive.write_u32(0x6085, 0, 200_000);
    drive.begin_move(100_000);
    drive.run_millis(300);
    drive
}

const AT_ONCE: i64 = 0;
const SLOW_DOWN: i64 = 1_000;
const QUICK_STOP: i64 = 250;

/// The motor comes to rest as far away as the ramp takes it, with a few milliseconds on top, and ends in a state.
#[track_caller]
fn comes_to_rest(drive: &mut DriveBench, begin: i64, ramp: i64, end: State) {
    drive.reaches(end, 300);
    let distance = drive.position() - begin;
    assert!((ramp..ramp + 60).contains(&distance), "{distance} steps");
    drive.run_millis(50);
    assert_eq!(drive.position() - begin, distance);
}

#[test]
fn d05_and_m05_operation_ends_as_605bh_and_605ch_say() {
    for (index, command, end) in [
        (0x605B, 0x06, READY_TO_SWITCH_ON),
        (0x605C, 0x07, SWITCHED_ON),
    ] {
        for (code, ramp) in [(0, AT_ONCE), (1, SLOW_DOWN)] {
            let mut drive = cruising();
            drive.write_i16(index, 0, code);
            let begin = drive.position();
            drive.command(command);
            comes_to_rest(&mut drive, begin, ramp, end);
            assert!(!drive.axis().plant().is_energised());
        }
    }
}

/// Wherever between two control ticks the frame comes, the drive has obeyed when it is over. The regular ticks keep their time.
#[test]
fn m07_a_command_to_stop_does_not_wait_for_the_control_tick() {
    for (command, state) in [
        (0x0B, QUICK_STOP_ACTIVE),
        (0x06, READY_TO_SWITCH_ON),
        (0x00, SWITCH_ON_DISABLED),
    ] {
        for behind in [0, 100, 200, 300, 400, 500, 600, 700] {
            let mut drive = cruising();
            drive.run_micros(behind);
            let tick = drive.axis().actuals().at.ticks();
            drive.command(command);
            drive.run_micros(100);
            assert!(state.is_shown_by(drive.statusword()), "{behind} us");
            drive.run_millis(2);
            let next = drive.axis().actuals().at.ticks();
            assert_eq!((next - tick) % 1_000, 0, "{behind} us");
        }
    }
}

/// Nor does one that no frame brings: a heartbeat that stays away, a controller that goes bus-off. What comes later finds nothing to hurry for.
#[test]
fn d29_a_network_that_is_lost_stops_the_motor_before_the_control_tick() {
    for by_heartbeat in [true, false] {
        let mut drive = cruising();
        drive.write_u32(0x1016, 1, 0x007F_0064);
        let tick = drive.axis().actuals().at.ticks();
        let rest = (drive.now().ticks() - tick) % 1_000;
        drive.run_micros(1_400 - rest);
        drive.send("77F [1] 05");
        let off_time = |drive: &mut DriveBench| (drive.axis().actuals().at.ticks() - tick) % 1_000;
        assert_eq!(off_time(&mut drive), 0);
        let is_enabled = |drive: &mut DriveBench| {
            OPERATION_ENABLED.is_shown_by(drive.axis().actuals().statusword)
        };
        if by_heartbeat {
            drive.run_millis(95);
            while is_enabled(&mut drive) {
                drive.run_micros(50);
            }
        } else {
            let now = drive.now();
            drive
                .axis()
                .controller_changed(ControllerState::BusOff, now);
        }
        assert!(!is_enabled(&mut drive));
        let behind = off_time(&mut drive);
        assert!((300..700).contains(&behind), "{behind} us behind a tick");
        drive.run_micros(1_000);
        for _ in 0..3 {
            drive.send("77F [1] 05");
            assert_eq!(off_time(&mut drive), 0);
            drive.run_micros(1_000);
        }
    }
}

#[test]
fn m07_every_quick_stop_option_has_its_ramp_and_its_end() {
    for (code, ramp, end) in [
        (0, AT_ONCE, SWITCH_ON_DISABLED),
        (1, SLOW_DOWN, SWITCH_ON_DISABLED),
        (2, QUICK_STOP, SWITCH_ON_DISABLED),
        (3, QUICK_STOP, SWITCH_ON_DISABLED),
        (4, QUICK_STOP, SWITCH_ON_DISABLED),
    ] {
        let mut drive = cruising();
        drive.write_i16(0x605A, 0, code);
        let begin = drive.position();
        drive.command(0x02);
        comes_to_rest(&mut drive, begin, ramp, end);
    }
    for (code, ramp) in [
        (5, SLOW_DOWN),
        (6, QUICK_STOP),
        (7, QUICK_STOP),
        (8, QUICK_STOP),
    ] {
        let mut drive = cruising();
        drive.write_i16(0x605A, 0, code);
        let begin = drive.position();
        drive.command(0x02);
        drive.run_millis(400);
        comes_to_rest(&mut drive, begin, ramp, QUICK_STOP_ACTIVE);
        drive.command(0x0F);
        drive.reaches(OPERATION_ENABLED, 10);
    }
}

#[test]
fn m10_a_fault_stops_the_motor_as_605eh_says() {
    for (code, ramp) in [
        (0, AT_ONCE),
        (1, SLOW_DOWN),
        (2, QUICK_STOP),
        (3, QUICK_STOP),
        (4, QUICK_STOP),
    ] {
        let mut drive = cruising();
        drive.write_i16(0x605E, 0, code);
        let begin = drive.position();
        drive.set_fault(Some(0x4310));
        comes_to_rest(&mut drive, begin, ramp, FAULT);
    }
}

/// The network is lost: by NMT, or because a node that is watched falls silent.
fn lose_the_network(drive: &mut DriveBench, by_nmt: bool) {
    if by_nmt {
        drive.send("000 [2] 02 04");
    } else {
        drive.send("77F [1] 05");
        drive.run_millis(100);
    }
}

#[test]
fn d29_d30_and_m16_the_loss_of_the_network_is_answered_as_6007h_says() {
    for by_nmt in [true, false] {
        for (code, ramp, end) in [
            (1, SLOW_DOWN, FAULT),
            (2, AT_ONCE, SWITCH_ON_DISABLED),
            (3, QUICK_STOP, SWITCH_ON_DISABLED),
        ] {
            let mut drive = cruising();
            drive.write_i16(0x6007, 0, code);
            drive.write_i16(0x605E, 0, 1);
            if !by_nmt {
                // Node 127 within 100 ms.
                drive.write_u32(0x1016, 1, 0x007F_0064);
            }
            lose_the_network(&mut drive, by_nmt);
            let begin = drive.position();
            comes_to_rest(&mut drive, begin, ramp, end);
            drive.send("000 [2] 01 04");
            drive.run_millis(100);
            drive.stays_in(end, 50);
            if end == FAULT {
                let code = if by_nmt { 0x8100 } else { 0x8130 };
                assert_eq!(drive.read_u16(0x603F, 0), code);
                drive.command(0x00);
                drive.command(0x80);
                drive.reaches(SWITCH_ON_DISABLED, 10);
            }
        }
    }
}

#[test]
fn d29_and_m16_with_6007h_0_the_loss_of_the_network_stops_nothing() {
    for by_nmt in [true, false] {
        let mut drive = cruising();
        drive.write_i16(0x6007, 0, 0);
        drive.write_u32(0x1016, 1, 0x007F_0064);
        lose_the_network(&mut drive, by_nmt);
        drive.stays_in(OPERATION_ENABLED, 200);
        assert_eq!(drive.statusword() & 0x200 == 0, by_nmt, "remote");
        drive.run_millis(12_000);
        assert_eq!(drive.position(), 100_000);
    }
}

#[test]
fn m05_a_holding_brake_opens_under_current_and_closes_before_it_goes() {
    let mut drive = DriveBench::started(4);
    drive.write_u16(0x2040, 1, 40);
    drive.write_u16(0x2040, 2, 60);
    drive.enable();
    assert!(drive.axis().plant().is_brake_open());
    drive.begin_move(1_000);
    drive.run_millis(10);
    assert_eq!(drive.position(), 0, "it is not open yet");
    drive.reaches_target(1_000);
    assert_eq!(drive.position(), 1_000);
    drive.command(0x07);
    drive.run_millis(5);
    assert!(!drive.axis().plant().is_brake_open());
    drive.stays_in(OPERATION_ENABLED, 45);
    assert!(drive.axis().plant().is_energised());
    drive.reaches(SWITCHED_ON, 20);
    assert!(!drive.axis().plant().is_energised());
}

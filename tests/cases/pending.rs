//! What waits, and what comes in between: transitions that wait for the motor, states that wait for a PDO, stops that other orders make no
//! gentler; over the bus.

use canopen::Duration;
use tests::DriveBench;
use tests::drive::{
    FAULT, FAULT_REACTION_ACTIVE, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON,
    SWITCH_ON_DISABLED, SWITCHED_ON, State,
};

/// A drive that turns at 10,000 steps/s in a mode. Slowing down takes 1000 steps, a quick stop 250.
fn turning(mode: u8) -> DriveBench {
    let mut drive = DriveBench::enabled(4);
    drive.write_u32(0x6084, 0, 50_000);
    drive.write_u32(0x6085, 0, 200_000);
    if mode == 1 {
        drive.begin_move(100_000);
    } else {
        drive.write_u8(0x6060, 0, mode);
        drive.write_i32(0x60FF, 0, 10_000);
    }
    drive.run_millis(300);
    drive
}

/// How far the motor still goes.
fn distance(drive: &mut DriveBench) -> i64 {
    let begin = drive.position();
    drive.run_millis(400);
    drive.position() - begin
}

#[test]
fn m05_bit_7_takes_no_command_back_that_waits_for_the_motor() {
    for mode in [1, 3] {
        for (command, end) in [(0x07, SWITCHED_ON), (0x06, READY_TO_SWITCH_ON)] {
            // Between two control ticks, and while the motor slows down.
            for wait in [0, 30] {
                let mut drive = turning(mode);
                drive.write_i16(0x605B, 0, 1);
                let begin = drive.position();
                drive.queue(&format!("204 [2] {command:02X} 00"));
                drive.run_millis(wait);
                drive.queue(&format!("204 [2] {:02X} 00", command | 0x80));
                drive.run_millis(2);
                assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
                drive.run_millis(400);
                let distance = drive.position() - begin;
                assert!(
                    (1_000..1_100).contains(&distance),
                    "{command:X}h: {distance}"
                );
                assert!(end.is_shown_by(drive.statusword()), "{command:X}h");
            }
        }
    }
}

#[test]
fn d15_a_mode_change_makes_no_stop_gentler() {
    // Halt on the quick stop ramp, with the change of the mode, before it and behind it.
    for order in 0..3 {
        let mut drive = turning(3);
        drive.write_i16(0x605D, 0, 2);
        let halt = "204 [2] 0F 01";
        let mode = "604: 2F 60 60 00 01";
        let begin = drive.position();
        for frame in if order == 0 {
            [mode, halt]
        } else {
            [halt, mode]
        } {
            drive.queue(frame);
            if order == 2 {
                drive.run_millis(2);
            }
        }
        drive.run_millis(400);
        let distance = drive.position() - begin;
        assert!((250..330).contains(&distance), "{order}: {distance} steps");
        drive.drain(0);
        assert_eq!(drive.read_i8(0x6061, 0), 1);
    }
    // Nor a quick stop that stays, or a fault reaction.
    for is_fault in [false, true] {
        let mut drive = turning(3);
        drive.write_i16(0x605A, 0, 6);
        if is_fault {
            drive.set_fault(Some(0x4310));
        } else {
            drive.command(0x02);
        }
        drive.run_millis(5);
        drive.queue("604: 2F 60 60 00 08");
        let distance = distance(&mut drive);
        assert!(
            (180..260).contains(&distance),
            "{is_fault}: {distance} steps"
        );
        drive.drain(0);
        assert_eq!(drive.read_i8(0x6061, 0), 8);
    }
}

/// Every statusword of TPDO 1 that has come by now.
fn shown(drive: &mut DriveBench) -> Vec<u16> {
    std::iter::from_fn(|| drive.next(Duration::micros(0)))
        .filter(|frame| frame.standard_id() == Some(0x184))
        .map(|frame| u16::from_le_bytes([frame.payload()[0], frame.payload()[1]]))
        .collect()
}

/// Makes the drive leave operation enabled: by quick stop or by a fault. Returns the state in between, and that behind it.
fn leave(drive: &mut DriveBench, is_fault: bool) -> (State, State) {
    if is_fault {
        drive.set_fault(Some(0x4310));
        (FAULT_REACTION_ACTIVE, FAULT)
    } else {
        drive.command(0x02);
        (QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED)
    }
}

#[test]
fn m08_and_m10_a_state_without_a_ramp_lasts_until_a_pdo_has_shown_it() {
    for is_fault in [false, true] {
        // The bus is somebody else's for so many milliseconds.
        for busy in [5, 20, 45] {
            let mut drive = DriveBench::enabled(4);
            drive.drain(20);
            let (between, end) = leave(&mut drive, is_fault);
            drive.jam(Duration::millis(busy));
            drive.run_millis(2);
            drive.stays_in(between, busy - 3);
            assert!(shown(&mut drive).is_empty());
            drive.run_millis(10);
            let shown = shown(&mut drive);
            assert!(between.is_shown_by(shown[0]), "{shown:X?}");
            assert!(end.is_shown_by(*shown.last().unwrap()), "{shown:X?}");
        }
        // The inhibit time of the PDO runs, and no other PDO has the statusword.
        let mut drive = DriveBench::enabled(4);
        drive.write_u32(0x1802, 1, 0xC000_0384);
        drive.write_u32(0x1800, 1, 0xC000_0184);
        drive.write_u16(0x1800, 3, 300);
        drive.write_u32(0x1800, 1, 0x4000_0184);
        drive.command(0x10F);
        drive.drain(10);
        let (between, end) = leave(&mut drive, is_fault);
        drive.run_millis(3);
        drive.stays_in(between, 10);
        drive.run_millis(60);
        let shown = shown(&mut drive);
        assert!(between.is_shown_by(shown[0]), "{shown:X?}");
        assert!(end.is_shown_by(*shown.last().unwrap()), "{shown:X?}");
    }
}

#[test]
fn m08_and_m10_no_state_waits_longer_than_50_ms_for_a_bus_that_stays_busy() {
    for is_fault in [false, true] {
        let mut drive = DriveBench::enabled(4);
        drive.drain(20);
        let (between, end) = leave(&mut drive, is_fault);
        drive.jam(Duration::millis(200));
        drive.run_millis(2);
        drive.stays_in(between, 46);
        drive.reaches(end, 5);
        assert!(!drive.axis().plant().is_energised());
    }
}

#[test]
fn d10_and_m11_a_master_in_a_hurry_resets_a_fault_whose_reaction_is_only_being_shown() {
    let mut drive = DriveBench::enabled(4);
    // The only PDO with the statusword waits for its inhibit time.
    drive.write_u32(0x1802, 1, 0xC000_0384);
    drive.write_u32(0x1800, 1, 0xC000_0184);
    drive.write_u16(0x1800, 3, 400);
    drive.write_u32(0x1800, 1, 0x4000_0184);
    drive.command(0x10F);
    drive.drain(5);
    drive.set_fault(Some(0x4310));
    drive.run_millis(5);
    drive.set_fault(None);
    drive.stays_in(FAULT_REACTION_ACTIVE, 5);
    for command in ["204 [2] 80 00", "204 [2] 06 00", "204 [2] 0F 00"] {
        drive.queue(command);
    }
    drive.reaches(OPERATION_ENABLED, 60);
}

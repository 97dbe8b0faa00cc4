//! Modes of operation over the bus: which there are, when they change, and what a change does to the statusword.

use tests::DriveBench;
use tests::drive::{
    FAULT, INTERNAL_LIMIT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, READY_TO_SWITCH_ON,
    SWITCH_ON_DISABLED, SWITCHED_ON, State, TARGET_REACHED,
};

/// Statusword bits 10 to 13: those that belong to a mode, and the limit.
const MODE_BITS: u16 = 0x3C00;

/// Every mode of the drive.
fn modes(drive: &mut DriveBench) -> Vec<i8> {
    let supported = drive.read_u32(0x6502, 0);
    (1..=32_i8)
        .filter(|mode| supported >> (mode - 1) & 1 == 1)
        .collect()
}

#[test]
fn m22_6502h_has_a_bit_for_each_mode_that_6060h_accepts_and_6061h_shows() {
    let mut drive = DriveBench::started(4);
    let supported = modes(&mut drive);
    assert!([1, 2, 3].iter().all(|mode| supported.contains(mode)));
    // A step axis has no torque.
    assert!(![4, 10].iter().any(|mode| supported.contains(mode)));
    for mode in i8::MIN..=i8::MAX {
        let before = drive.read_i8(0x6061, 0);
        let is_there = mode == 0 || supported.contains(&mode);
        let result = drive.try_write(0x6060, 0, &mode.to_le_bytes());
        assert_eq!(result, if is_there { Ok(()) } else { Err(0x0609_0030) });
        drive.run_millis(5);
        let shown = if is_there { mode } else { before };
        assert_eq!(drive.read_i8(0x6061, 0), shown);
    }
}

/// A drive in a state, halted or with bit 4 held if that is asked for.
fn drive_in(state: State, bits: u16) -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_i16(0x605A, 0, 6);
    // What a mode could start with.
    drive.write_i32(0x607A, 0, 1_000);
    for (controlword, reached) in [
        (0x06, READY_TO_SWITCH_ON),
        (0x07, SWITCHED_ON),
        (0x0F, OPERATION_ENABLED),
        (0x02, QUICK_STOP_ACTIVE),
    ] {
        if state == SWITCH_ON_DISABLED {
            break;
        }
        drive.command(controlword | bits);
        drive.reaches(reached, 10);
        if reached == state {
            break;
        }
    }
    if state == FAULT {
        drive.set_fault(Some(0x4310));
    }
    drive.reaches(state, 50);
    drive
}

#[test]
fn m20_and_d15_a_mode_changes_in_every_state_and_nothing_moves() {
    for bits in [0, 0x100, 0x10] {
        for state in [
            SWITCH_ON_DISABLED,
            READY_TO_SWITCH_ON,
            SWITCHED_ON,
            OPERATION_ENABLED,
            QUICK_STOP_ACTIVE,
            FAULT,
        ] {
            let mut drive = drive_in(state, bits);
            let modes = modes(&mut drive);
            for mode in modes.into_iter().chain([0, 1]) {
                drive.write_u8(0x6060, 0, mode.cast_unsigned());
                drive.run_millis(10);
                assert_eq!(drive.read_i8(0x6061, 0), mode, "within 10 ms");
                drive.stays_in(state, 20);
                assert_eq!(drive.position(), 0, "mode {mode}, bits {bits:04X}h");
            }
        }
    }
}

#[test]
fn m23_the_bits_of_a_mode_change_with_6061h() {
    let mut drive = DriveBench::enabled(4);
    // Bits 10 and 11 are 1: stopped by a software limit, then halted.
    drive.write_i32(0x607D, 2, 500);
    drive.begin_move(1_000);
    drive.run_millis(1_000);
    assert_eq!(drive.statusword() & MODE_BITS, INTERNAL_LIMIT);
    for (mode, bits) in [
        // At rest and asked for 0: the velocity is reached after its window time, and the speed is 0.
        (3, 0x1000),
        (2, TARGET_REACHED),
        (0, 0),
        (1, 0),
    ] {
        drive.write_u8(0x6060, 0, mode);
        for _ in 0..40 {
            drive.run_micros(250);
            let actuals = drive.axis().actuals();
            if actuals.mode_display == mode.cast_signed() {
                assert_eq!(actuals.statusword & MODE_BITS, bits, "mode {mode}");
                break;
            }
        }
        assert_eq!(drive.read_i8(0x6061, 0), mode.cast_signed());
        drive.run_millis(50);
    }
}

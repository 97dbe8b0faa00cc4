//! Pulses that come too late: the motor stops between two steps, and may stand anywhere behind that.

use tests::DriveBench;
use tests::drive::{FAULT, OPERATION_ENABLED, SWITCH_ON_DISABLED};

/// 2034h:1, whether home is known.
fn is_referenced(drive: &mut DriveBench) -> bool {
    drive.read_u8(0x2034, 1) == 1
}

/// A drive with a known home position that moves at 10,000 steps/s.
fn moving() -> DriveBench {
    let mut drive = DriveBench::enabled(4);
    drive.write_i8(0x6098, 0, 37);
    drive.write_u8(0x6060, 0, 6);
    drive.run_millis(5);
    drive.command(0x1F);
    drive.run_millis(20);
    drive.command(0x0F);
    assert!(is_referenced(&mut drive));
    drive.write_u8(0x6060, 0, 1);
    drive.run_millis(5);
    drive.begin_move(100_000);
    drive.run_millis(300);
    drive.drain(1);
    drive
}

/// Nobody commits pulses for a while, and the motor plays all that it has.
fn starve(drive: &mut DriveBench) {
    drive
        .axis()
        .plant_mut()
        .pulses_mut()
        .play(10_000_000, |_| {});
}

#[test]
fn pulses_that_come_late_are_a_fault_and_home_is_unknown() {
    let mut drive = moving();
    starve(&mut drive);
    drive.drain_until("084: 00 61 01", 5);
    drive.reaches(FAULT, 300);
    drive.drain(1);
    assert_eq!(drive.read_u16(0x603F, 0), 0x6100);
    assert!(!is_referenced(&mut drive));
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 5);
    drive.enable();
}

#[test]
fn pulses_that_come_late_are_only_told_where_20a2h_is_0() {
    let mut drive = moving();
    drive.write_u8(0x20A2, 0, 0);
    drive.drain(1);
    starve(&mut drive);
    drive.drain_until("084: 00 61 01", 5);
    assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
    drive.run_millis(10_000);
    assert_eq!(drive.position(), 100_000, "none is lost");
    drive.drain(1);
    assert!(is_referenced(&mut drive));
    assert_eq!(drive.try_write(0x20A2, 0, &[2]), Err(0x0609_0031));
}

//! The compact drive (`eds/compact.eds`): what it has works as in the generic one, and what it has not is refused.

use canopen::Frame;
use master::bus::Station;
use sim::drive::{Setup, VirtualDrive};
use sim::plant::{Axis, Switch, Track};
use tests::drive::{
    CompactBench, DriveBench, OPERATION_ENABLED, SWITCH_ON_DISABLED, ServoBench, TARGET_REACHED,
};
use tests::line::Line;

/// Statusword bit 12: homing attained.
const ATTAINED: u16 = 1 << 12;

/// A master chooses the data sheet of a device by its product code, and shows a person its name.
#[test]
fn each_drive_says_what_it_is() {
    let generic = DriveBench::booted(4);
    let servo = ServoBench::booted(4);
    let compact = CompactBench::booted(4);
    says(generic, "Axis402 CiA 402 drive", 0x402);
    says(servo, "Axis402 servo drive", 0x403);
    says(compact, "Axis402 compact", 0x404);
}

#[track_caller]
fn says<S: Station>(mut drive: Line<S>, name: &str, product_code: u32) {
    assert_eq!(drive.try_read(0x1008, 0).as_deref(), Ok(name.as_bytes()));
    assert_eq!(drive.read_u32(0x1018, 2), product_code);
}

#[test]
fn the_compact_drive_is_numbered_by_lss() {
    let device = VirtualDrive::new(Setup::unconfigured(7));
    let mut drive = CompactBench::new(device, 4);
    drive.silence(100);
    drive.send("7E5: 04 01");
    drive.send("7E5: 11 04");
    drive.expect("7E4: 11 00");
    drive.send("7E5: 04 00");
    drive.expect("704 [1] 00");
    assert_eq!(drive.read_u32(0x1018, 2), 0x404);
    assert_eq!(drive.read_u32(0x1018, 4), 7);
}

#[test]
fn the_compact_drive_goes_to_set_points_with_both_forms_of_ramps() {
    for form in [0, 2] {
        let mut drive = CompactBench::started(4);
        drive.write_i16(0x6086, 0, form);
        drive.enable();
        drive.begin_move(5_000);
        drive.reaches_target(5_000);
        assert_eq!(drive.position(), 5_000, "6086h = {form}");
        assert_eq!(drive.read_i32(0x6064, 0), 5_000);
    }
}

#[test]
fn the_compact_drive_keeps_a_velocity_and_stops() {
    let mut drive = CompactBench::started(4);
    drive.write_u8(0x6060, 0, 3);
    drive.enable();
    drive.write_i32(0x60FF, 0, 5_000);
    drive.run_millis(2_000);
    let from = drive.position();
    drive.run_millis(1_000);
    assert!((drive.position() - from - 5_000).abs() <= 1);
    drive.command(0x02);
    drive.reaches(SWITCH_ON_DISABLED, 2_000);
    let at = drive.position();
    drive.run_millis(100);
    assert_eq!(drive.position(), at);
}

#[test]
fn the_compact_drive_finds_home() {
    let mut drive = CompactBench::on(Axis {
        track: Track {
            home: Some(Switch::from(1_000)),
            ..Track::default()
        },
        ..Axis::default()
    });
    drive.write_u8(0x6060, 0, 6);
    drive.write_u8(0x6098, 0, 19);
    drive.write_u32(0x6099, 1, 10_000);
    drive.write_u32(0x6099, 2, 1_000);
    drive.write_u32(0x609A, 0, 100_000);
    drive.enable();
    drive.command(0x1F);
    drive.run_millis(3_000);
    let bits = drive.statusword() & (ATTAINED | TARGET_REACHED);
    assert_eq!(bits, ATTAINED | TARGET_REACHED);
    let shown = i64::from(drive.read_i32(0x6064, 0));
    assert_eq!(drive.axis().plant().rotor() - shown, 1_000);
}

#[test]
fn the_compact_drive_follows_a_position_at_each_sync() {
    let mut drive = CompactBench::started(4);
    drive.map_pdo(0x1402, &[0x607A_0020], 1);
    drive.write_u8(0x6060, 0, 8);
    drive.write_u8(0x60C2, 1, 2);
    drive.enable();
    for cycle in 0..500 {
        let target: i32 = (cycle - 100).clamp(0, 300) * 10;
        drive.send_frame(Frame::data_frame(0x404, &target.to_le_bytes()));
        drive.send_frame(Frame::data_frame(0x80, &[]));
        drive.run_millis(2);
    }
    drive.reaches(OPERATION_ENABLED, 1);
    assert_eq!(drive.read_i8(0x6061, 0), 8);
    assert_eq!(drive.position(), 3_000);
}

#[test]
fn the_compact_drive_refuses_what_it_has_not() {
    let mut drive = CompactBench::booted(4);
    assert_eq!(drive.read_u32(0x6502, 0), 0b1010_0101);
    for mode in [2, 4, 7, 9] {
        drive.refused(&format!("604: 2F 60 60 00 {mode:02X}"), 0x0609_0030);
    }
    for mode in [1, 3, 6, 8, 0] {
        drive.write_u8(0x6060, 0, mode);
    }
    // The velocity mode, probes, outputs, the analogue input, factors, the scope, the node-ID by SDO.
    for index in [
        0x6042, 0x60B8, 0x60FE, 0x2064, 0x608F, 0x6091, 0x20D0, 0x5FF0,
    ] {
        let [low, high] = u16::to_le_bytes(index);
        drive.refused(&format!("604: 40 {low:02X} {high:02X} 00"), 0x0602_0000);
    }
}

#[test]
fn a_mode_that_is_not_there_changes_nothing_by_pdo() {
    let mut drive = CompactBench::started(4);
    drive.map_pdo(0x1401, &[0x6060_0008], 255);
    drive.enable();
    drive.send_frame(Frame::data_frame(0x304, &[9]));
    drive.run_millis(10);
    assert_eq!(drive.read_i8(0x6061, 0), 1);
    drive.begin_move(1_000);
    drive.reaches_target(3_000);
    assert_eq!(drive.position(), 1_000);
}

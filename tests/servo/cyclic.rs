//! The cyclic modes on a loop: set-points by SYNC.

use tests::drive::{INTERNAL_LIMIT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, ServoBench};

use super::{enable, hold, torque};

/// Statusword bit 12: the drive follows the command value.
const FOLLOWS: u16 = 1 << 12;

/// In a cyclic mode with this object in RPDO 2, taken over at SYNC.
fn cyclic(mode: u8, object: u32) -> ServoBench {
    set_up(ServoBench::on_axis("servo_100w"), mode, object)
}

/// The same of a drive that is there.
fn set_up(mut drive: ServoBench, mode: u8, object: u32) -> ServoBench {
    drive.map_pdo(0x1401, &[object], 1);
    drive.write_u8(0x60C2, 1, 4);
    enable(drive, mode)
}

/// A period of 4 ms: a set-point, if there is one, and SYNC.
pub(super) fn period(drive: &mut ServoBench, set_point: Option<&str>) {
    let begin = drive.now();
    if let Some(bytes) = set_point {
        let length = bytes.split(' ').count();
        drive.send(&format!("304 [{length}] {bytes}"));
    }
    drive.send("080 [0]");
    let passed = drive.now().ticks() - begin.ticks();
    drive.run_micros(4_000 - passed);
}

pub(super) fn bytes(value: &[u8]) -> String {
    let bytes: Vec<String> = value.iter().map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

#[test]
fn m45_a_torque_in_each_period_is_held_with_its_offset() {
    let mut drive = cyclic(10, 0x6071_0010);
    hold(&mut drive);
    drive.write_i16(0x60B2, 0, 20);
    for target in 0..40_i16 {
        let target = (5 * target).min(100);
        period(&mut drive, Some(&bytes(&target.to_le_bytes())));
    }
    assert_eq!(torque(&mut drive), 120);
    assert_ne!(drive.statusword() & FOLLOWS, 0);
    drive.write_u16(0x60E0, 0, 90);
    for _ in 0..4 {
        period(&mut drive, Some(&bytes(&100_i16.to_le_bytes())));
    }
    assert_eq!(torque(&mut drive), 90);
    assert_eq!(
        drive.statusword() & (FOLLOWS | INTERNAL_LIMIT),
        INTERNAL_LIMIT
    );
}

#[test]
fn m45_torques_that_do_not_come_stop_the_motor() {
    let mut drive = cyclic(10, 0x6071_0010);
    for _ in 0..40 {
        period(&mut drive, Some(&bytes(&60_i16.to_le_bytes())));
    }
    assert!(drive.read_i32(0x606C, 0) > 20_000);
    for _ in 0..100 {
        period(&mut drive, None);
    }
    assert!(
        !OPERATION_ENABLED.is_shown_by(drive.statusword()) || drive.statusword() & FOLLOWS == 0
    );
    assert!(!QUICK_STOP_ACTIVE.is_shown_by(drive.statusword()));
    let stands = drive.position();
    drive.run_millis(50);
    assert!((drive.position() - stands).abs() <= 2);
}

#[test]
fn m45_positions_in_each_period_are_followed_by_the_loop() {
    let mut drive = cyclic(8, 0x607A_0020);
    let mut target = 0_i32;
    let mut worst = 0;
    for step in 0..150 {
        // Up to 37,500 counts/s and down again, evenly, with 125,000 counts/s².
        let speed = if step < 75 { step } else { 150 - step };
        target += speed * 2;
        period(&mut drive, Some(&bytes(&target.to_le_bytes())));
        if step > 10 {
            worst = worst.max(drive.axis().actuals().following_error.abs());
        }
    }
    assert!(worst <= 6, "{worst}");
    for _ in 0..30 {
        period(&mut drive, Some(&bytes(&target.to_le_bytes())));
    }
    let away = drive.position() - i64::from(target);
    assert!(away.abs() <= 1, "{away}");
}

#[test]
fn m45_an_offset_of_the_torque_is_given_ahead() {
    for (mode, object) in [(8, 0x607A_0020), (9, 0x60FF_0020)] {
        let mut drive = cyclic(mode, object);
        // A load whose torque is known: with it ahead, the loop has nothing left to do.
        let mut sags = [0; 2];
        for (sag, offset) in sags.iter_mut().zip([0_i16, 300]) {
            drive.plant().load_torque = 0.0;
            drive.write_i16(0x60B2, 0, 0);
            for _ in 0..60 {
                period(&mut drive, Some(&bytes(&0_i32.to_le_bytes())));
            }
            drive.plant().load_torque = 0.3 * 0.319_92;
            drive.write_i16(0x60B2, 0, offset);
            for _ in 0..5 {
                period(&mut drive, Some(&bytes(&0_i32.to_le_bytes())));
                *sag = (*sag).max(drive.position().abs());
            }
        }
        assert!(sags[1] * 2 < sags[0], "mode {mode}: {sags:?}");
    }
}

/// 6064h after set-points of 0 for a fifth of a second.
fn at_zero(drive: &mut ServoBench) -> i32 {
    for _ in 0..50 {
        period(drive, Some(&bytes(&0_i32.to_le_bytes())));
    }
    drive.read_i32(0x6064, 0)
}

#[test]
fn m45_an_offset_of_the_velocity_is_given_ahead() {
    for polarity in [0, 0xC0] {
        let mut drive = ServoBench::on_axis("servo_100w");
        drive.write_u8(0x607E, 0, polarity);
        let mut drive = set_up(drive, 8, 0x607A_0020);
        assert_eq!(at_zero(&mut drive), 0);
        // The position loop takes it back: 5,000 counts/s by its gain in 1/s are the counts that it is away then.
        for (gain, offset, away) in [(100, 5_000, 50), (100, -5_000, -50), (200, 5_000, 25)] {
            drive.write_u16(0x60FB, 1, gain);
            drive.write_i32(0x60B1, 0, offset);
            let stands = at_zero(&mut drive);
            assert!((stands - away).abs() <= 1, "{stands}, not {away}");
            let error = drive.read_i32(0x60F4, 0);
            assert!((error + away).abs() <= 1, "{error}");
        }
        drive.write_i32(0x60B1, 0, 0);
        let stands = at_zero(&mut drive);
        assert!(stands.abs() <= 1, "{stands}");
    }
}

#[test]
fn m45_offsets_are_of_no_account_in_profile_modes() {
    let mut drive = enable(ServoBench::on_axis("servo_100w"), 1);
    drive.write_i32(0x60B1, 0, 5_000);
    drive.write_i16(0x60B2, 0, 300);
    for _ in 0..50 {
        drive.run_millis(1);
        assert!(drive.position().abs() <= 1);
        assert!(drive.read_i16(0x6074, 0).abs() < 50);
    }
}

#[test]
fn m45_an_offset_of_the_velocity_is_part_of_the_set_point() {
    let mut drive = cyclic(9, 0x60FF_0020);
    for offset in [20_000, -20_000, 0] {
        drive.write_i32(0x60B1, 0, offset);
        for _ in 0..60 {
            period(&mut drive, Some(&bytes(&60_000_i32.to_le_bytes())));
        }
        let velocity = drive.read_i32(0x606C, 0);
        assert!((velocity - 60_000 - offset).abs() <= 300, "{velocity}");
    }
}

//! Cyclic synchronous velocity (mode 9): ramps, limits, and how it begins in motion; in virtual time.

use canopen::Frame;
use tests::DriveBench;
use tests::drive::{FAULT, INTERNAL_LIMIT, SWITCH_ON_DISABLED};

use crate::cyclic_master::{FOLLOWS, Master, expedited, hardest};

/// A master of mode 9 and a cycle of 1 ms, that need not repeat a velocity.
fn master() -> Master {
    let mut master = Master::new(9, 1_000);
    master.drive.write_u8(0x2051, 2, 2);
    for _ in 0..100 {
        master.sync(0);
    }
    master
}

/// From now on this velocity, in increments/s.
fn command(master: &mut Master, velocity: i32) {
    let frame = Frame::data_frame(0x604, &expedited(0x60FF, velocity));
    master.drive.send_frame(frame);
}

fn cycles(master: &mut Master, count: u32) {
    for _ in 0..count {
        master.sync(0);
    }
}

#[test]
fn m69_cyclic_velocity_has_an_offset_and_so_has_cyclic_position() {
    let mut master = Master::new(9, 2_000);
    master.drive.write_i32(0x60FF, 0, 0);
    for _ in 0..100 {
        master.sync(0);
    }
    master.drive.write_i32(0x60B1, 0, 500);
    for k in 0..500 {
        let velocity = (k * 10_i32).min(2_000);
        master
            .drive
            .send_frame(Frame::data_frame(0x604, &expedited(0x60FF, velocity)));
        master.sync(0);
    }
    assert!(master.has(FOLLOWS));
    let shown = master.drive.axis().actuals().velocity_demand;
    assert!((2_495..=2_505).contains(&shown), "{shown}");
    // With the offset of a position the motor is somewhere else.
    let mut master = Master::new(8, 2_000);
    master.drive.write_i32(0x60B0, 0, 100);
    master.steps([0; 300]);
    assert_eq!(master.drive.position(), 100);
}

#[test]
fn m44_cyclic_velocity_stops_before_a_software_limit_whatever_its_ramp() {
    // Ramps that are no whole velocity in a period, in increments/s².
    for (ramp, sign) in [(1_999, 1), (900, -1)] {
        let mut master = master();
        master.drive.write_i32(0x607D, 1, -3_000);
        master.drive.write_i32(0x607D, 2, 3_000);
        master.drive.write_u32(0x60C6, 0, ramp);
        command(&mut master, 2_000 * sign);
        cycles(&mut master, 4_000);
        let position = master.drive.position() * i64::from(sign);
        assert!((2_990..=3_000).contains(&position), "{ramp}: {position}");
        assert!(master.has(INTERNAL_LIMIT));
    }
}

#[test]
fn m69_a_ramp_below_one_increment_per_second_in_a_period_is_kept() {
    for ramp in [100, 1_999] {
        let mut master = master();
        master.drive.write_u32(0x60C5, 0, ramp);
        command(&mut master, 100_000);
        cycles(&mut master, 1_000);
        let velocity = master.drive.axis().actuals().velocity_demand;
        let off = velocity.abs_diff(ramp.cast_signed());
        assert!(off <= ramp / 50 + 1, "{ramp}: {velocity}");
    }
}

#[test]
fn m19_cyclic_velocity_in_motion_awaits_its_set_points_as_the_mode_before() {
    let mut master = Master::new(8, 1_000);
    master.steps([0; 100]);
    master.steps((1..=200).map(|k| k * 20));
    // No 60FFh comes: the motor is stopped, and on a ramp. 1,000,000 increments/s² change the distance of 1 ms by 1.
    let mode = Frame::data_frame(0x604, &[0x2F, 0x60, 0x60, 0, 9, 0, 0, 0]);
    master.shown.clear();
    master.drive.send_frame(mode);
    cycles(&mut master, 100);
    let change = hardest(&master.shown);
    assert!(change <= 3, "6085h: {change}");
    assert!(FAULT.is_shown_by(master.drive.statusword()));
    assert_eq!(master.drive.read_u16(0x603F, 0), 0x8250);
    // It comes with the mode: the motor goes on.
    let mut master = Master::new(8, 1_000);
    master.drive.write_u8(0x2051, 2, 2);
    master.steps([0; 100]);
    master.steps((1..=200).map(|k| k * 20));
    master.shown.clear();
    master.drive.send_frame(mode);
    cycles(&mut master, 5);
    command(&mut master, 20_000);
    cycles(&mut master, 100);
    assert!(hardest(&master.shown) <= 3);
    assert!(master.has(FOLLOWS));
    let velocity = master.drive.axis().actuals().velocity_demand;
    assert!((19_990..=20_010).contains(&velocity), "{velocity}");
}

#[test]
fn m19_cyclic_velocity_takes_a_motor_over_that_turns_and_waits_for_its_first_set_point() {
    // Profile velocity and profile position at 10,000 increments/s.
    for mode in [1_u8, 3] {
        let mut drive = DriveBench::started(4);
        drive.write_u8(0x60C2, 1, 2);
        drive.enable();
        if mode == 3 {
            drive.write_u8(0x6060, 0, 3);
            drive.write_i32(0x60FF, 0, 10_000);
        } else {
            drive.begin_move(1_000_000);
        }
        drive.write_u32(0x60C5, 0, 100_000);
        drive.write_u32(0x60C6, 0, 100_000);
        drive.write_u8(0x2051, 2, 2);
        drive.run_millis(300);
        drive.record_motion();
        let mut master = Master::on(drive, 2_000);
        cycles(&mut master, 50);
        // 60FFh of before is no set-point of this mode.
        master.drive.queue("604: 2F 60 60 00 09");
        cycles(&mut master, 50);
        let velocity = master.drive.axis().actuals().velocity_demand;
        assert!((9_990..=10_010).contains(&velocity), "{mode}: {velocity}");
        command(&mut master, 5_000);
        cycles(&mut master, 100);
        assert!(master.has(FOLLOWS) && !master.has(INTERNAL_LIMIT));
        let velocity = master.drive.axis().actuals().velocity_demand;
        assert!((4_995..=5_005).contains(&velocity), "{mode}: {velocity}");
        // From the one to the other on 60C6h.
        let hardest = master.drive.greatest_acceleration();
        assert!(hardest <= 110_000, "{mode}: {hardest}");
        assert_eq!(master.drive.read_i8(0x6061, 0), 9);
    }
}

#[test]
fn m43_cyclic_velocity_entered_at_rest_stands_until_sync_brings_a_set_point() {
    let mut drive = DriveBench::enabled(4);
    drive.write_u8(0x2051, 2, 2);
    drive.write_i32(0x60FF, 0, 10_000);
    drive.run_millis(20);
    let mut master = Master::on(drive, 1_000);
    cycles(&mut master, 50);
    master.drive.queue("604: 2F 60 60 00 09");
    cycles(&mut master, 100);
    assert_eq!(master.drive.position(), 0, "60FFh was written before");
    assert!(!master.has(FOLLOWS));
    command(&mut master, 1_000);
    cycles(&mut master, 1_000);
    assert!(master.has(FOLLOWS));
    let distance = master.drive.position();
    assert!((950..=1_000).contains(&distance), "{distance}");
}

/// Writes of 607Ah and 60FFh without SYNC are sync events of the modes that go by them, and of no other: a master that changes a target now and
/// then does not lock the drive to that, nor does what such a mode has begun outlive it.
#[test]
fn m65_writes_without_sync_are_sync_events_in_the_cyclic_modes_alone() {
    /// The period of sync events (2050h:2), 0 for none, behind 40 writes 4 ms apart.
    fn period_of_writes(drive: &mut DriveBench, index: u16) -> u32 {
        for _ in 0..40 {
            drive.send_frame(Frame::data_frame(0x604, &expedited(index, 0)));
            drive.run_millis(4);
        }
        drive.drain(0);
        drive.read_u32(0x2050, 2)
    }
    for (mode, index, cyclic) in [
        (1, 0x607A, 8),
        (3, 0x60FF, 9),
        (2, 0x607A, 8),
        (6, 0x60FF, 9),
    ] {
        let mut drive = DriveBench::started(4);
        drive.write_u8(0x60C2, 1, 4);
        for (mode, is_event) in [(mode, false), (cyclic, true), (mode, false)] {
            drive.write_u8(0x6060, 0, mode);
            drive.enable();
            let period = period_of_writes(&mut drive, index);
            let case = format!("{index:X}h in mode {mode}: {period} ns");
            if is_event {
                assert!(period.abs_diff(4_000_000) < 200_000, "{case}");
            } else {
                assert_eq!(period, 0, "{case}");
            }
            let tick = drive.axis().actuals().at;
            drive.run_millis(1);
            let since = (drive.axis().actuals().at - tick).ticks();
            assert!(
                is_event || since == 1_000,
                "the tick of mode {mode}: {since}"
            );
            drive.command(0x00);
            drive.reaches(SWITCH_ON_DISABLED, 100);
        }
    }
}

//! Interpolated position (mode 7): what becomes of the records that wait, and how they are followed without SYNC; in virtual time.

use canopen::{Duration, Frame};
use tests::DriveBench;
use tests::drive::{FAULT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED};

use crate::cyclic_master::{FOLLOWS, Master, expedited, hardest};

/// Writes a record by SDO, without waiting for the answer.
fn record(drive: &mut DriveBench, position: i32) {
    let mut data = expedited(0x60C1, position);
    data[3] = 1;
    drive.send_frame(Frame::data_frame(0x604, &data));
}

/// A drive on its way through records 10 ms apart, of which about 25 wait.
fn ahead() -> Master {
    let mut master = Master::new(7, 10_000);
    for k in 0..30 {
        record(&mut master.drive, k * 20);
        master.drive.run_millis(1);
    }
    master.drive.command(0x1F);
    for _ in 0..5 {
        master.sync(0);
    }
    assert!(master.has(FOLLOWS));
    assert!(master.drive.read_u16(0x60C4, 4) > 20);
    master
}

/// Whatever comes now, no old record is followed and a new one is.
#[track_caller]
fn begins_afresh(mut master: Master) {
    assert_eq!(master.drive.read_u16(0x60C4, 4), 0, "60C4h:4");
    let rest = master.drive.position();
    master.drive.enable();
    master.drive.command(0x1F);
    // SYNC has kept its period meanwhile.
    master.next_in(master.cycle_time());
    for _ in 0..20 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), rest, "an old record was followed");
    record(&mut master.drive, i32::try_from(rest).unwrap() + 7);
    for _ in 0..20 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), rest + 7);
}

#[test]
fn m68_leaving_operation_enabled_clears_the_buffer() {
    for command in [0x02, 0x06, 0x07, 0x00] {
        let mut master = ahead();
        master.drive.command(command);
        master.drive.run_millis(200);
        master.drive.command(0x00);
        master.drive.reaches(SWITCH_ON_DISABLED, 10);
        begins_afresh(master);
    }
}

#[test]
fn m68_a_fault_clears_the_buffer_and_so_does_the_loss_of_the_network() {
    let mut master = ahead();
    master.drive.set_fault(Some(0x4310));
    master.drive.run_millis(200);
    master.drive.set_fault(None);
    assert!(FAULT.is_shown_by(master.drive.statusword()));
    // A master that has not noticed goes on writing.
    for k in 0..10 {
        record(&mut master.drive, 1_000 + k);
        master.drive.run_millis(1);
        while master.drive.next(Duration::micros(0)).is_some() {}
    }
    master.drive.command(0x00);
    master.drive.command(0x80);
    master.drive.reaches(SWITCH_ON_DISABLED, 10);
    begins_afresh(master);

    let mut master = ahead();
    master.drive.send("000 [2] 02 04");
    master.drive.run_millis(200);
    master.drive.send("000 [2] 01 04");
    master.drive.run_millis(2);
    begins_afresh(master);
}

#[test]
fn m68_a_quick_stop_that_stays_clears_the_buffer() {
    let mut master = ahead();
    master.drive.write_i16(0x605A, 0, 6);
    master.drive.command(0x02);
    master.drive.run_millis(100);
    assert!(QUICK_STOP_ACTIVE.is_shown_by(master.drive.statusword()));
    master.drive.command(0x0F);
    master.drive.reaches(OPERATION_ENABLED, 10);
    let rest = master.drive.position();
    master.drive.command(0x1F);
    for _ in 0..20 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), rest);
}

#[test]
fn m68_a_command_to_leave_that_is_taken_back_leaves_no_record() {
    let mut master = ahead();
    master.drive.write_u32(0x6084, 0, 10_000);
    master.drive.command(0x17);
    master.drive.run_millis(5);
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
    master.drive.command(0x1F);
    master.drive.run_millis(5);
    assert_eq!(master.drive.read_u16(0x60C4, 4), 0);
    let position = master.drive.position();
    for _ in 0..50 {
        master.sync(0);
    }
    let distance = master.drive.position() - position;
    assert!((0..250).contains(&distance), "it stops: {distance}");
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
}

/// As ros2_canopen does: its RPDO is synchronous, so it repeats the last record with each SYNC while it has none to give.
#[test]
fn m68_records_under_halt_without_bit_4_are_not_kept() {
    let mut master = Master::new(7, 10_000);
    for (controlword, kept) in [(0x10F, 0), (0x0F, 5), (0x10F, 5), (0x11F, 10)] {
        master.drive.command(controlword);
        for _ in 0..5 {
            record(&mut master.drive, 0);
            master.sync(0);
        }
        let waits = master.drive.read_u16(0x60C4, 4);
        assert_eq!(waits, kept, "controlword {controlword:03X}h");
    }
}

/// The same, with an end: the last record comes three times more.
fn ahead_with_an_end() -> Master {
    let mut master = ahead();
    for _ in 0..3 {
        record(&mut master.drive, 29 * 20);
        master.drive.drain(1);
    }
    master
}

#[test]
fn m68_bit_4_stops_in_motion_on_the_ramp_of_605dh_and_enabled_again_the_records_go_on() {
    // 6084h and 6085h, in increments/s²: 2,000 increments/s are left in 100 ms or in 10 ms.
    for (option, distances) in [(1, 80..=125), (2, 5..=35)] {
        for halt in [false, true] {
            let mut master = ahead_with_an_end();
            master.drive.write_u32(0x6084, 0, 20_000);
            master.drive.write_u32(0x6085, 0, 200_000);
            master.drive.write_i16(0x605D, 0, option);
            let waiting = master.drive.read_u16(0x60C4, 4);
            let begin = master.drive.position();
            master.drive.command(if halt { 0x11F } else { 0x0F });
            for _ in 0..15 {
                master.sync(0);
            }
            let stands = master.drive.position();
            let distance = stands - begin;
            assert!(
                distances.contains(&distance),
                "605Dh = {option}: {distance}"
            );
            assert!(!master.has(FOLLOWS));
            assert_eq!(master.has(1 << 10), halt, "bit 10");
            let left = master.drive.read_u16(0x60C4, 4);
            assert!(left >= waiting - 1, "records stay: {left} of {waiting}");
            // SYNC goes on, and no record is used up.
            for _ in 0..10 {
                master.sync(0);
            }
            assert_eq!(master.drive.position(), stands);
            assert_eq!(master.drive.read_u16(0x60C4, 4), left);
            // Enabled again: on the ramp to the next record, and through all of them to the last one.
            master.shown.clear();
            master.drive.command(0x1F);
            for _ in 0..5 {
                master.sync(0);
            }
            assert!(master.drive.read_u16(0x60C4, 4) < left);
            for _ in 0..60 {
                master.sync(0);
            }
            assert!(master.has(FOLLOWS));
            assert_eq!(master.drive.position(), 29 * 20);
            // 100,000 increments/s² change the distance of 10 ms by 10, and pulses are whole. The records themselves end all at once.
            let change = hardest(&master.shown[..15]);
            assert!(change <= 12, "6083h: {change}");
            assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
        }
    }
}

#[test]
fn m68_bit_4_that_falls_and_rises_between_two_records_loses_none() {
    let mut master = ahead_with_an_end();
    for _ in 0..5 {
        master.drive.command(0x0F);
        master.drive.run_millis(3);
        master.drive.command(0x1F);
        master.next_in(10_000);
        for _ in 0..3 {
            master.sync(0);
        }
    }
    for _ in 0..60 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), 29 * 20);
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
}

/// A drive in mode 7 with 60C2h = 10 ms and bit 4, which has never heard of SYNC.
fn without_sync() -> DriveBench {
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x6060, 0, 7);
    drive.write_u8(0x60C2, 1, 10);
    drive.write_u8(0x60C2, 2, i8::cast_unsigned(-3));
    drive.enable();
    drive.command(0x1F);
    drive.run_millis(20);
    drive.record_motion();
    drive
}

/// The distance in each 10 ms from when the motor begins to when it has made its last step.
fn distances(drive: &mut DriveBench) -> Vec<i64> {
    let samples: Vec<i64> = drive
        .axis()
        .motion_samples()
        .iter()
        .map(|sample| sample.position)
        .collect();
    let last = samples.last().copied().unwrap_or(0);
    let moving: Vec<i64> = samples
        .windows(2)
        .filter(|pair| pair[0] != samples[0] || pair[1] != samples[0])
        .take_while(|pair| pair[0] != last)
        .map(|pair| pair[0])
        .collect();
    moving
        .windows(11)
        .map(|distance| distance[10] - distance[0])
        .collect()
}

#[test]
fn m68_without_sync_records_leave_one_a_period_however_they_are_written() {
    // In bursts of five, one every 10 ms with delays, and one every 10.02 ms.
    for kind in 0..3 {
        let mut drive = without_sync();
        let mut random = 7_u64;
        let due = drive.now().ticks();
        for k in 0..200_u64 {
            random = random.wrapping_mul(6_364_136_223_846_793_005) + 1;
            // The last record is repeated, as the motion ends there.
            let position = i32::try_from(k.min(190)).unwrap() * 20;
            let late = match kind {
                0 => k % 5 * 1_000,
                1 => k * 10_000 + (random >> 33) % 3_000,
                _ => k * 10_020,
            };
            let at = if kind == 0 {
                due + k / 5 * 50_000 + late
            } else {
                due + late
            };
            drive.run_micros(at.saturating_sub(drive.now().ticks()));
            record(&mut drive, position);
        }
        drive.run_millis(200);
        assert_eq!(drive.position(), 190 * 20, "kind {kind}");
        assert!(OPERATION_ENABLED.is_shown_by(drive.statusword()));
        let distances = distances(&mut drive);
        assert!(distances.len() > 1_800, "kind {kind}: {}", distances.len());
        let steady = &distances[100..distances.len() - 30];
        let (least, most) = (steady.iter().min().unwrap(), steady.iter().max().unwrap());
        assert!(
            *least >= 19 && *most <= 21,
            "kind {kind}: {least} to {most}"
        );
    }
}

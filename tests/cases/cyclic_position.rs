//! Cyclic synchronous position (mode 8): set-points at SYNC, in virtual time, with jitter and with frames that are lost.

use canopen::Frame;
use tests::DriveBench;
use tests::drive::{FAULT, INTERNAL_LIMIT, OPERATION_ENABLED};

use crate::cyclic_master::{FOLLOWS, Master, expedited_sub, hardest, latency};

/// A motion to and fro: `most` increments in a cycle at its fastest.
fn to_and_fro(most: i32) -> impl Iterator<Item = i32> {
    (0..400).scan(0, move |target, k| {
        let distance = match k % 200 {
            up @ 0..50 => most * up / 50,
            50..100 => most,
            down => most - most * (down - 100) / 50,
        };
        *target += distance;
        Some(*target)
    })
}

#[test]
fn m63_at_each_sync_the_motor_is_at_a_set_point_exactly() {
    for cycle in [1_000, 2_000, 4_000, 10_000] {
        let mut master = Master::new(8, cycle);
        for _ in 0..100 {
            let off = master.jitter();
            master.cycle(0, off);
        }
        // A step takes longer than the control tick is off its moment.
        for target in to_and_fro(i32::try_from(cycle / 50).unwrap()) {
            let off = master.jitter();
            master.cycle(target, off);
        }
        master.is_exact(100);
        assert!(master.has(FOLLOWS));
        assert!(!master.has(INTERNAL_LIMIT));
    }
}

/// With a cubic it is a period later, as the set-point behind the next one has to be known.
#[test]
fn m63_with_a_cubic_the_motor_is_at_a_set_point_exactly_too() {
    for cycle in [1_000, 2_000, 4_000, 10_000] {
        let mut master = Master::new(8, cycle);
        master.drive.write_i16(0x60C0, 0, -1);
        for _ in 0..100 {
            let off = master.jitter();
            master.cycle(0, off);
        }
        for target in to_and_fro(i32::try_from(cycle / 50).unwrap()) {
            let off = master.jitter();
            master.cycle(target, off);
        }
        master.is_exact_after(100, latency(cycle) + 1);
        assert!(master.has(FOLLOWS));
        assert!(!master.has(INTERNAL_LIMIT));
    }
}

#[test]
fn m68_60c0h_is_0_or_minus_1_in_every_mode_and_nothing_else() {
    let mut drive = DriveBench::enabled(4);
    for mode in [1_i8, 2, 3, 6, 7, 8, 9] {
        drive.write_u8(0x6060, 0, mode.cast_unsigned());
        drive.run_millis(5);
        assert_eq!(drive.read_i8(0x6061, 0), mode);
        for sub_mode in [-1_i16, 0] {
            drive.write_i16(0x60C0, 0, sub_mode);
            for refused in [1_i16, 2, -2, i16::MIN, i16::MAX] {
                let answer = drive.try_write(0x60C0, 0, &refused.to_le_bytes());
                assert!(answer.is_err(), "{refused} in mode {mode}");
            }
            assert_eq!(drive.read_i16(0x60C0, 0), sub_mode);
        }
    }
}

/// How uneven the pulses at the motor are in a cruise. A SYNC 120 us off its moment is up to 140 us from where the loop expects it, and moves a
/// set-point by 1/32 of that.
#[test]
fn m63_the_speed_of_the_pulses_ripples_by_less_than_half_a_percent_while_sync_jitters() {
    /// Pulses in a millisecond.
    const SPEED: i64 = 150;
    for cycle in [1_000, 2_000, 4_000] {
        let mut master = Master::new(8, cycle);
        let distance = i32::try_from(cycle / 1_000).unwrap() * SPEED as i32;
        // It sets out at full speed.
        master.drive.write_u32(0x60C5, 0, u32::MAX);
        master.drive.write_u32(0x60C6, 0, u32::MAX);
        for _ in 0..200 {
            let off = master.jitter();
            master.cycle(0, off);
        }
        master.drive.record_motion();
        for k in 1..=600 {
            let off = master.jitter();
            master.cycle(k * distance, off);
        }
        let samples = master.drive.axis().motion_samples();
        // Set-points that move apart by 4.5 us; and a pulse is there or not, at each end.
        let cruise = &samples[100..samples.len() - 20];
        for pair in cruise.windows(2) {
            let time = (pair[1].at - pair[0].at).ticks().cast_signed();
            let distance = (pair[1].position - pair[0].position) * 1_000;
            let even = SPEED * time;
            let most = 1_000 + even * 45 / (10 * cycle.cast_signed());
            let off = (distance - even).abs();
            assert!(off <= most, "{cycle} us: {distance} in place of {even}");
        }
    }
}

#[test]
fn m63_without_jitter_it_is_exact_at_any_speed() {
    let mut master = Master::new(8, 1_000);
    // The motion ends all at once.
    master.drive.write_u32(0x60C6, 0, 200_000_000);
    master.steps([0; 300]);
    master.steps(to_and_fro(150));
    master.is_exact(300);
}

#[test]
fn y10_set_points_are_followed_without_overshoot_while_sync_jitters() {
    let mut master = Master::new(8, 2_000);
    for _ in 0..100 {
        let off = master.jitter() * 100 / 120;
        master.cycle(0, off);
    }
    for k in 1..=100 {
        let off = master.jitter() * 100 / 120;
        master.cycle(k * 20, off);
    }
    for _ in 0..50 {
        master.cycle(2_000, 0);
    }
    assert!(master.shown.is_sorted());
    assert_eq!(master.shown.last(), Some(&2_000));
    assert_eq!(master.drive.position(), 2_000);
}

#[test]
fn m62_the_demand_begins_where_the_motor_stands_and_a_far_target_is_caught_up_with() {
    let mut master = Master::new(8, 1_000);
    master.drive.write_u32(0x607F, 0, 20_000);
    assert!(!master.has(FOLLOWS), "nothing has been commanded");
    master.steps([0; 100]);
    assert!(master.has(FOLLOWS));
    master.drive.record_motion();
    master.steps([50_000; 200]);
    assert!(master.has(INTERNAL_LIMIT));
    assert!(!master.has(FOLLOWS));
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
    master.steps([50_000; 4_000]);
    assert_eq!(master.drive.position(), 50_000);
    assert!(master.has(FOLLOWS) && !master.has(INTERNAL_LIMIT));
    let fastest = master.shown.windows(2).map(|pair| pair[1] - pair[0]).max();
    assert!(fastest <= Some(20), "607Fh: {fastest:?}");
}

#[test]
fn m62_a_first_target_that_607fh_would_allow_in_one_period_is_caught_up_with_on_the_ramp() {
    let mut master = Master::new(8, 10_000);
    // It stands somewhere else than the first target.
    master.steps([900; 100]);
    assert_eq!(master.drive.position(), 900);
    assert!(master.has(FOLLOWS) && !master.has(INTERNAL_LIMIT));
    // 100,000 increments/s² change the distance of 10 ms by 10, and pulses are whole.
    let change = hardest(&master.shown);
    assert!(change <= 12, "6083h: {change}");
}

#[test]
fn m35_released_halt_begins_on_the_ramp_too() {
    let mut master = Master::new(8, 10_000);
    master.steps([0; 100]);
    master.controlword = 0x10F;
    master.steps([0; 5]);
    master.controlword = 0x0F;
    master.shown.clear();
    master.steps([900; 100]);
    assert_eq!(master.drive.position(), 900);
    let change = hardest(&master.shown);
    assert!(change <= 12, "6083h: {change}");
}

#[test]
fn m64_set_points_that_are_lost_while_the_motor_catches_up_are_missing_as_well() {
    let mut master = Master::new(8, 1_000);
    master.drive.write_u32(0x607F, 0, 20_000);
    master.steps([0; 100]);
    master.steps([50_000; 400]);
    assert!(!master.has(FOLLOWS));
    let so_far = master.drive.position();
    // The master is gone, and SYNC with it.
    master.drive.run_millis(200);
    assert!(FAULT.is_shown_by(master.drive.statusword()));
    assert_eq!(master.drive.read_u16(0x603F, 0), 0x8250);
    let went = master.drive.position() - so_far;
    // Until it is noticed, some 10 ms at 20 in each, and 200 on 6085h.
    assert!(went < 600, "{went}");
}

#[test]
fn m64_a_single_set_point_far_away_is_gone_to() {
    let mut master = Master::new(8, 1_000);
    master.steps([0; 100]);
    for _ in 0..20 {
        master.sync(0);
    }
    master.cycle(2_000, 0);
    for _ in 0..1_000 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), 2_000);
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
}

#[test]
fn m64_one_lost_set_point_is_bridged_and_d28_one_that_is_late_too() {
    let mut master = Master::new(8, 2_000);
    master.steps([0; 100]);
    master.steps((1..=50).map(|k| k * 20));
    // Nothing comes for this SYNC, and then the next but one.
    master.sync(0);
    master.commanded.push(51 * 20);
    assert!(master.has(FOLLOWS), "D28: bridged");
    master.steps((52..=100).map(|k| k * 20));
    master.steps([2_000; 150]);
    master.is_exact(100);
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
}

#[test]
fn m64_more_lost_set_points_than_are_bridged_stop_the_motor() {
    let mut master = Master::new(8, 2_000);
    master.drive.write_u8(0x2051, 1, 3);
    master.steps([0; 100]);
    master.steps((1..=50).map(|k| k * 20));
    for _ in 0..20 {
        master.sync(0);
    }
    assert!(FAULT.is_shown_by(master.drive.statusword()));
    assert_eq!(master.drive.read_u16(0x603F, 0), 0x8250);
    assert_eq!(master.drive.read_u32(0x2050, 6), 1);
    // Recovery: a fault reset, and it begins where the motor stands.
    let stands = i32::try_from(master.drive.position()).unwrap();
    assert!(stands >= 53 * 20, "three are bridged: {stands}");
    master.drive.command(0x80);
    master.drive.run_millis(5);
    master.drive.enable();
    master.next = master.drive.now().ticks() + 2_000;
    master.steps(std::iter::repeat_n(stands, 50));
    master.steps((1..=20).map(|k| stands + k));
    master.steps(std::iter::repeat_n(stands + 20, 20));
    assert_eq!(master.drive.position(), i64::from(stands) + 20);
}

#[test]
fn d28_the_reaction_to_lost_set_points_is_configured() {
    // 0: it stops, and follows again when set-points come.
    let mut master = Master::new(8, 2_000);
    master.drive.write_u8(0x2051, 2, 0);
    master.steps([0; 100]);
    master.steps((1..=50).map(|k| k * 20));
    for _ in 0..20 {
        master.sync(0);
    }
    assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
    assert!(!master.has(FOLLOWS));
    master.steps([1_000; 400]);
    assert!(master.has(FOLLOWS));
    assert_eq!(master.drive.position(), 1_000);
    // 2: who does not send means the last one.
    let mut master = Master::new(8, 2_000);
    master.drive.write_u8(0x2051, 2, 2);
    master.steps([0; 100]);
    master.steps((1..=50).map(|k| k * 20));
    for _ in 0..20 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), 1_000);
    assert!(master.has(FOLLOWS));
}

#[test]
fn m65_of_two_set_points_the_last_counts_and_behind_sync_the_next_sync() {
    let mut master = Master::new(8, 2_000);
    master.steps([0; 100]);
    for k in 1..=100 {
        master.set_point(k * 20 + 7);
        master.cycle(k * 20, 0);
        // Behind the SYNC: it would count at the next one.
        master.set_point(k * 20 + 3);
    }
    master.steps([2_000; 150]);
    master.is_exact(100);
}

#[test]
fn m66_60c2h_is_any_mantissa_and_exponent_and_changes_at_rest_only() {
    let mut drive = DriveBench::started(4);
    for (value, power) in [(10, -3_i8), (1, -2), (250, -5), (1, -3)] {
        drive.write_u8(0x60C2, 1, value);
        drive.write_u8(0x60C2, 2, i8::cast_unsigned(power));
        assert_eq!(drive.read_u8(0x60C2, 1), value);
    }
    for cycle in [2_500, 10_000] {
        let mut master = Master::new(8, cycle);
        master.steps([0; 100]);
        master.steps((1..=150).map(|k| k * 10));
        assert_eq!(
            master.drive.try_write(0x60C2, 1, &[2]),
            Err(0x0800_0022),
            "in motion"
        );
    }
}

#[test]
fn m67_a_sync_with_another_period_than_is_set_up_is_a_warning_and_right() {
    const WARNING: u16 = 1 << 7;
    let mut master = Master::new(8, 4_000);
    master.drive.write_u8(0x60C2, 1, 10);
    master.drive.write_u32(0x1006, 0, 10_000);
    master.steps([0; 150]);
    assert!(master.has(WARNING | FOLLOWS));
    master.steps(to_and_fro(80));
    master.is_exact(150);
}

/// As masters do that know SYNC, or 1006h, and never write 60C2h: 1 ms as it is by default is nobody's word.
#[test]
fn m67_where_60c2h_was_never_written_set_points_come_with_each_sync_whatever_its_period() {
    const WARNING: u16 = 1 << 7;
    for cycle in [1_000, 2_500, 4_000, 10_000, 20_000] {
        for is_told in [false, true] {
            let mut drive = DriveBench::started(4);
            drive.write_u8(0x6060, 0, 8);
            if is_told {
                drive.write_u32(0x1006, 0, u32::try_from(cycle).unwrap());
            }
            drive.write_u8(0x1402, 2, 1);
            drive.write_u8(0x1803, 2, 1);
            drive.enable();
            let mut master = Master::on(drive, cycle);
            for _ in 0..100 {
                let off = master.jitter();
                master.cycle(0, off);
            }
            master.steps(to_and_fro(i32::try_from(cycle / 50).unwrap()));
            master.is_exact(150);
            assert!(master.has(FOLLOWS) && !master.has(WARNING), "{cycle} us");
            assert_eq!(master.drive.read_u8(0x2050, 1), 2, "locked");
            let measured = master.drive.read_u32(0x2050, 2);
            let off = u64::from(measured).abs_diff(1_000 * cycle);
            assert!(off < cycle * 2, "2050h:2 is {measured} ns");
        }
    }
}

#[test]
fn m67_60c2h_that_was_written_is_a_warning_where_sync_comes_otherwise_though_it_is_the_default() {
    const WARNING: u16 = 1 << 7;
    let mut master = Master::new(8, 4_000);
    master.drive.write_u8(0x60C2, 1, 1);
    master.drive.write_u8(0x60C2, 2, i8::cast_unsigned(-3));
    master.steps([0; 100]);
    assert!(master.has(WARNING | FOLLOWS));
}

#[test]
fn m19_cyclic_position_holds_the_demand_until_the_first_set_point() {
    let mut master = Master::new(1, 1_000);
    master.drive.begin_move(100_000);
    master.drive.run_millis(500);
    master.drive.write_u8(0x6060, 0, 8);
    master.drive.run_millis(2_000);
    assert_eq!(master.drive.read_i8(0x6061, 0), 8);
    let stands = master.drive.position();
    assert!(stands > 0 && stands < 100_000);
    master.next = master.drive.now().ticks() + 1_000;
    for _ in 0..50 {
        master.sync(0);
    }
    assert_eq!(master.drive.position(), stands, "607Ah is that of the move");
    let target = i32::try_from(stands).unwrap() + 10;
    master.steps([target; 200]);
    assert_eq!(master.drive.position(), i64::from(target));
}

#[test]
fn m44_a_software_limit_stops_before_it() {
    let mut master = Master::new(8, 1_000);
    master.drive.write_i32(0x607D, 1, -1_000);
    master.drive.write_i32(0x607D, 2, 1_000);
    master.steps([0; 100]);
    master.steps((1..=100).map(|k| k * 20));
    assert!(master.has(INTERNAL_LIMIT));
    master.steps([2_000; 500]);
    assert!(
        master.drive.position() <= 1_000,
        "{}",
        master.drive.position()
    );
    assert!(master.drive.position() >= 995);
    assert!(master.has(INTERNAL_LIMIT));
    assert!(!master.has(FOLLOWS), "it stands, and not at its set-point");
    assert!(master.shown.iter().all(|shown| *shown <= 1_000));
    master.shown.clear();
    master.steps([900; 500]);
    assert_eq!(master.drive.position(), 900, "the way back is free");
    assert!(hardest(&master.shown) <= 3, "on the ramp of 6083h");
    assert!(master.has(FOLLOWS) && !master.has(INTERNAL_LIMIT));
}

#[test]
fn m35_halt_stops_and_release_catches_up() {
    let mut master = Master::new(8, 2_000);
    master.steps([0; 100]);
    master.steps((1..=100).map(|k| k * 20));
    master.controlword = 0x10F;
    master.steps((101..=300).map(|k| k * 20));
    assert!(!master.has(FOLLOWS));
    assert!(master.has(1 << 10), "the motor stands");
    master.controlword = 0x0F;
    master.steps((301..=400).map(|k| k * 20));
    master.steps([8_000; 500]);
    assert_eq!(master.drive.position(), 8_000);
    assert!(master.has(FOLLOWS) && !master.has(INTERNAL_LIMIT));
}

#[test]
fn m68_interpolated_position_goes_through_its_records_while_bit_4_is_set() {
    for sub_mode in [0, -1_i16] {
        let mut master = Master::new(7, 4_000);
        master.drive.write_i16(0x60C0, 0, sub_mode);
        for _ in 0..100 {
            master.sync(0);
        }
        for record in [0, 100, 200] {
            master.drive.write_i32(0x60C1, 1, record);
        }
        master.drive.run_millis(2);
        assert_eq!(master.drive.read_u16(0x60C4, 4), 3);
        master.next = master.drive.now().ticks() + 4_000;
        for _ in 0..20 {
            master.sync(0);
        }
        assert_eq!(master.drive.position(), 0, "bit 4 gates");
        master.drive.command(0x1F);
        for record in [300, 350, 375, 375] {
            let record = expedited_sub(0x60C1, 1, record);
            master.drive.send_frame(Frame::data_frame(0x604, &record));
            master.sync(0);
        }
        assert!(master.has(FOLLOWS));
        for _ in 0..40 {
            master.sync(0);
        }
        assert_eq!(master.drive.position(), 375);
        assert!(master.has(1 << 10), "the last record is reached");
        assert!(OPERATION_ENABLED.is_shown_by(master.drive.statusword()));
        // Cleared records are gone.
        master.drive.command(0x0F);
        master.drive.write_i32(0x60C1, 1, 5_000);
        master.drive.write_u8(0x60C4, 6, 0);
        master.drive.write_u8(0x60C4, 6, 1);
        master.drive.run_millis(5);
        assert_eq!(master.drive.read_u16(0x60C4, 4), 0);
    }
}

#[test]
fn m68_records_that_run_out_in_motion_are_lost_set_points() {
    let mut master = Master::new(7, 4_000);
    master.drive.command(0x1F);
    for k in 0..150_i32 {
        let record = expedited_sub(0x60C1, 1, (k - 100).max(0) * 20);
        master.drive.send_frame(Frame::data_frame(0x604, &record));
        master.sync(0);
    }
    for _ in 0..20 {
        master.sync(0);
    }
    assert!(FAULT.is_shown_by(master.drive.statusword()));
    assert_eq!(master.drive.read_u16(0x603F, 0), 0x8250);
}

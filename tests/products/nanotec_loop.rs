//! The closed loop of the Nanotec: when it is on, torque, currents, encoders, test runs.

use std::f64::consts::TAU;

use canopen::Frame;

use crate::bench::Bench;
use crate::steer::{
    NODE, begin, command, current, hold, number, on_servo, plant, position, statusword,
};

/// Counts of a turn.
const TURN: f64 = 2_000.0;

/// What a percent of 2004h is, in A.
pub const PERCENT: f64 = 0.075;

pub const ABSOLUTE: u8 = 3;

/// On a stepper, with an encoder of this type and this way of closing the loop, and half of the current.
pub fn nanotec(encoder: u8, closes: u8) -> Bench {
    let mut bench = on_servo("nanotec", "nema23");
    bench.write(NODE, 0x2011, 0, &[encoder]);
    bench.write(NODE, 0x2001, 0, &[closes]);
    bench.write(NODE, 0x2004, 1, &[50]);
    bench.write(NODE, 0x2004, 2, &[50]);
    number(&mut bench, 0x6082, 0, 1);
    bench
}

pub fn enabled(mut bench: Bench, mode: u8) -> Bench {
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench
}

fn is_closed(bench: &mut Bench) -> bool {
    bench.read(NODE, 0x200A, 0) == 1
}

pub fn torque(bench: &mut Bench, target: i16) {
    bench.write(NODE, 0x6071, 0, &target.to_le_bytes());
}

/// Where the rotor truly is, in counts.
pub fn rotor(bench: &mut Bench) -> f64 {
    plant(bench).angle() / TAU * TURN
}

pub fn load_angles(bench: &mut Bench, angles: [u16; 7]) {
    for (sub, angle) in (1..).zip(angles) {
        bench.write(NODE, 0x200C, sub, &angle.to_le_bytes());
    }
}

#[test]
fn the_nanotec_gives_a_torque_of_its_current() {
    for (percent, target) in [(20_u8, 500_i16), (40, 500), (40, -250)] {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x2004, 1, &[percent]);
        load_angles(&mut bench, [16_384; 7]);
        let mut bench = enabled(bench, 4);
        hold(&mut bench);
        command(&mut bench, 0x10F);
        torque(&mut bench, target);
        bench.run(100);
        assert!(current(&mut bench).abs() < 0.05, "bit 8 stops");
        assert_ne!(statusword(&mut bench) & 1 << 10, 0, "idle");
        command(&mut bench, 0x0F);
        bench.run(100);
        let wanted = f64::from(target) / 1e3 * f64::from(percent) * PERCENT;
        let flows = current(&mut bench);
        assert!((flows - wanted).abs() < 0.02, "{flows} A, not {wanted}");
        assert_ne!(statusword(&mut bench) & 1 << 10, 0, "torque reached");
    }
}

#[test]
fn the_torque_of_a_nanotec_ends_at_607fh() {
    for limit in [120_u32, 300] {
        let mut bench = nanotec(ABSOLUTE, 1);
        number(&mut bench, 0x607F, 0, limit);
        let mut bench = enabled(bench, 4);
        for target in [300, -300] {
            torque(&mut bench, target);
            bench.run(800);
            let from = rotor(&mut bench);
            bench.run(500);
            let speed = (rotor(&mut bench) - from) / TURN * 120.0 * f64::from(target.signum());
            let off = speed / f64::from(limit) - 1.0;
            assert!(off.abs() < 0.06, "{speed} of {limit}");
        }
    }
}

#[test]
fn the_loop_of_the_nanotec_closes_as_2001h_says() {
    // Behind the travel in which the index was found, or as soon as it is.
    for closes in [1, 2] {
        let mut bench = enabled(nanotec(1, closes), 1);
        bench.run(100);
        assert!(!is_closed(&mut bench), "no index yet");
        let rests = current(&mut bench).abs();
        assert!(rests > 2.0, "as a stepper: {rests} A");
        begin(&mut bench, 3_000, 2_000, 20_000);
        bench.run(1_300);
        assert_eq!(is_closed(&mut bench), closes == 2, "on the way");
        bench.run(800);
        assert!(is_closed(&mut bench));
        bench.run(200);
        let rests = current(&mut bench).abs();
        assert!(rests < 0.5, "it takes what the load takes: {rests} A");
        assert!((rotor(&mut bench) - 3_000.0).abs() < 3.0);
        bench.write(NODE, 0x2001, 0, &[0]);
        bench.run(200);
        assert!(!is_closed(&mut bench), "at once");
        let rests = current(&mut bench).abs();
        assert!(rests > 2.0, "as a stepper: {rests} A");
    }
    let mut bench = enabled(nanotec(2, 3), 1);
    bench.run(100);
    assert!(!is_closed(&mut bench), "it waits for a test run");
    bench.write(NODE, 0x6060, 0, &[0xFE]);
    bench.run(6_000);
    assert!(is_closed(&mut bench));
}

#[test]
fn the_encoder_of_a_nanotec_is_of_its_type_and_counts_its_way() {
    // None, without an index, and one that is absolute.
    for (encoder, is_on) in [(0, false), (2, false), (ABSOLUTE, true)] {
        let mut bench = enabled(nanotec(encoder, 1), 1);
        begin(&mut bench, 3_000, 4_000, 50_000);
        bench.run(2_000);
        assert_eq!(is_closed(&mut bench), is_on, "type {encoder}");
    }
    for (turned, sign) in [(0_u8, 1.0), (1, -1.0)] {
        let mut bench = nanotec(ABSOLUTE, 0);
        bench.write(NODE, 0x200D, 0, &[turned]);
        bench.run(20);
        let from = (position(&mut bench), rotor(&mut bench));
        plant(&mut bench).load_torque = 0.3;
        bench.run(30);
        plant(&mut bench).load_brake = 5.0;
        bench.run(50);
        let shown = f64::from(position(&mut bench) - from.0);
        let way = rotor(&mut bench) - from.1;
        assert!(way.abs() > 50.0, "it is turned from outside");
        assert!((shown - sign * way).abs() < 3.0, "{shown}, not {way}");
    }
}

#[test]
fn the_offset_of_the_encoder_turns_the_current() {
    for (offset, share) in [(0_u16, 1.0), (10_923, 0.5), (54_613, 0.5)] {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x200B, 0, &offset.to_le_bytes());
        load_angles(&mut bench, [16_384; 7]);
        bench.run(5);
        let mut bench = enabled(bench, 4);
        hold(&mut bench);
        torque(&mut bench, 500);
        bench.run(200);
        let [_, q] = plant(&mut bench).current();
        let truly = q / (25.0 * PERCENT);
        assert!((truly - share).abs() < 0.04, "{offset}: {truly}");
    }
}

#[test]
fn the_test_run_of_the_nanotec_finds_the_magnet() {
    for (run, learns) in [(-1_i8, true), (-2, false)] {
        let mut bench = nanotec(ABSOLUTE, 1);
        // A little wrong: 20 electrical degrees.
        bench.write(NODE, 0x200B, 0, &3_641_u16.to_le_bytes());
        bench.run(5);
        bench.write(NODE, 0x6060, 0, &[0]);
        bench.enable(NODE);
        let from = rotor(&mut bench);
        bench.write(NODE, 0x6060, 0, &run.to_le_bytes());
        bench.run(200);
        assert_eq!(bench.read(NODE, 0x6061, 0) as u8 as i8, run);
        let mut moved = 0.0_f64;
        for _ in 0..700 {
            bench.run(10);
            moved = moved.max((rotor(&mut bench) - from).abs());
        }
        assert!(moved > 20.0, "the rotor was moved by {moved}");
        let offset = (bench.read(NODE, 0x200B, 0) as u16).cast_signed();
        assert!(offset.abs() < 1_800, "{offset}");
        let learned = bench.read(NODE, 0x200C, 3) as u16 == 16_384;
        assert_eq!(learned, learns, "{run}: the load angles");
    }
}

#[test]
fn the_nanotec_goes_by_interpolated_positions_in_closed_loop() {
    let mut bench = nanotec(ABSOLUTE, 1);
    bench.write(NODE, 0x60C2, 1, &[10]);
    bench.write(NODE, 0x60C2, 2, &[0xFD]);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    let mut bench = enabled(bench, 7);
    let cycle = |bench: &mut Bench, target: i32| {
        bench.write(NODE, 0x60C1, 1, &target.to_le_bytes());
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.run(10);
    };
    for _ in 0..50 {
        cycle(&mut bench, 0);
    }
    command(&mut bench, 0x1F);
    for _ in 0..10 {
        cycle(&mut bench, 0);
    }
    assert!(is_closed(&mut bench));
    for target in 1..=100 {
        cycle(&mut bench, target * 10);
    }
    for _ in 0..20 {
        cycle(&mut bench, 1_000);
    }
    let stands = rotor(&mut bench);
    assert!((stands - 1_000.0).abs() < 3.0, "{stands}");
}

#[test]
fn a_nanotec_turns_a_motor_without_brushes() {
    let mut bench = on_servo("nanotec", "servo_100w");
    bench.write(NODE, 0x2004, 7, &[1]);
    bench.write(NODE, 0x2004, 1, &[20]);
    number(&mut bench, 0x2004, 13, 60);
    number(&mut bench, 0x2004, 14, 200);
    bench.run(5);
    assert!(is_closed(&mut bench), "it has no other way");
    let mut bench = enabled(bench, 1);
    begin(&mut bench, 4_000, 10_000, 100_000);
    bench.run(1_500);
    assert!((rotor(&mut bench) - 4_000.0).abs() < 4.0);
    // Its peak current, and the one that it bears.
    hold(&mut bench);
    begin(&mut bench, 8_000, 10_000, 100_000);
    bench.run(150);
    let peak = current(&mut bench);
    assert!((peak - 60.0 * PERCENT).abs() < 0.1, "{peak} A");
    bench.run(200);
    let bears = current(&mut bench);
    assert!((bears - 20.0 * PERCENT).abs() < 0.1, "{bears} A");
}

#[test]
fn a_nanotec_turns_a_motor_by_its_hall_sensors() {
    let mut bench = on_servo("nanotec", "servo_100w_hall");
    bench.write(NODE, 0x2004, 7, &[1]);
    bench.write(NODE, 0x2004, 1, &[40]);
    bench.run(5);
    let mut bench = enabled(bench, 4);
    bench.run(100);
    assert!(rotor(&mut bench).abs() < 0.5, "nothing is looked for");
    for target in [300, -300] {
        let before = rotor(&mut bench);
        torque(&mut bench, target);
        bench.run(30);
        let turned = rotor(&mut bench) - before;
        assert!(turned * f64::from(target) > 0.0, "{turned} by {target}");
        torque(&mut bench, 0);
        plant(&mut bench).load_brake = 0.2;
        bench.run(300);
        plant(&mut bench).load_brake = 0.0;
    }
    torque(&mut bench, 300);
    bench.run(30);
    assert_eq!(statusword(&mut bench) & 1 << 3, 0);
    plant(&mut bench).sensor_faults.cut_hall = 0b111;
    bench.run(10);
    assert_ne!(statusword(&mut bench) & 1 << 3, 0, "a fault");
    bench.run(10);
    assert!(current(&mut bench).abs() < 0.05);
}

/// 2004h:12: a motor whose signals come in another order turns by that order, and by no other.
#[test]
fn the_order_of_the_hall_signals_is_that_of_the_nanotec() {
    const DB57: u32 = 0x24_3015;
    const DB42: u32 = 0x51_0342;
    for (is_other, order, turns) in [
        (false, DB57, true),
        (true, DB42, true),
        (true, DB57, false),
        (false, DB42, false),
    ] {
        let mut bench = on_servo("nanotec", "servo_100w_hall");
        plant(&mut bench).sensor_faults.other_hall = is_other;
        bench.write(NODE, 0x2004, 7, &[1]);
        bench.write(NODE, 0x2004, 1, &[40]);
        number(&mut bench, 0x2004, 12, order);
        bench.run(5);
        let mut bench = enabled(bench, 4);
        let before = rotor(&mut bench);
        torque(&mut bench, 300);
        bench.run(30);
        let turned = rotor(&mut bench) - before;
        let has_failed = statusword(&mut bench) & 1 << 3 != 0;
        assert_eq!(turned > 50.0, turns, "{turned} by {order:X}h");
        assert_eq!(has_failed, !turns, "{turned} by {order:X}h");
    }
    // A sector that is not there, one twice, and a seventh digit.
    let mut bench = on_servo("nanotec", "servo_100w_hall");
    for order in [0x24_3016_u32, 0x24_3014, 0x124_3015] {
        let mut request = [0x23, 0x04, 0x20, 12, 0, 0, 0, 0];
        request[4..].copy_from_slice(&order.to_le_bytes());
        let answer = bench.sdo(NODE, request);
        assert_eq!(answer[4..], 0x0609_0030_u32.to_le_bytes(), "{order:X}h");
    }
}

#[test]
fn the_pole_pairs_of_a_nanotec_count_with_the_next_power() {
    let mut bench = enabled(nanotec(ABSOLUTE, 1), 1);
    bench.write(NODE, 0x2006, 0, &100_u16.to_le_bytes());
    begin(&mut bench, 1_000, 4_000, 50_000);
    bench.run(800);
    assert!((rotor(&mut bench) - 1_000.0).abs() < 3.0, "not yet");
    command(&mut bench, 0);
    bench.run(100);
    bench.write(NODE, 0x1010, 1, b"save");
    bench.drive.power_cycle();
    bench.run(50);
    bench.enable(NODE);
    bench.write(NODE, 0x6060, 0, &[1]);
    let from = rotor(&mut bench);
    begin(&mut bench, 1_000, 4_000, 50_000);
    bench.run(800);
    let way = (rotor(&mut bench) - from).abs();
    assert!((way - 1_000.0).abs() > 100.0, "no motor has so many: {way}");
}

#[test]
fn a_block_run_of_the_nanotec_has_its_own_current() {
    for closes in [0, 1] {
        let mut bench = nanotec(ABSOLUTE, closes);
        bench.write(NODE, 0x2004, 4, &[20]);
        number(&mut bench, 0x6099, 1, 1_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &[0xFE]);
        let mut bench = enabled(bench, 6);
        command(&mut bench, 0x1F);
        bench.run(300);
        hold(&mut bench);
        let mut most = 0.0_f64;
        for _ in 0..100 {
            bench.run(1);
            most = most.max(current(&mut bench).abs());
        }
        assert!((most - 20.0 * PERCENT).abs() < 0.12, "{closes}: {most} A");
    }
}

#[test]
fn a_correction_travel_of_the_nanotec_brings_back_what_was_lost() {
    for (tolerance, comes_back) in [(u32::MAX, false), (20, true)] {
        let mut bench = nanotec(2, 0);
        number(&mut bench, 0x2004, 6, tolerance);
        let mut bench = enabled(bench, 1);
        begin(&mut bench, 4_000, 4_000, 50_000);
        bench.run(300);
        plant(&mut bench).load_brake = 1.5;
        bench.run(300);
        plant(&mut bench).load_brake = 0.0;
        bench.run(3_000);
        let away = rotor(&mut bench) - 4_000.0;
        assert_eq!(away.abs() < 5.0, comes_back, "{away} counts");
    }
}

#[test]
fn a_block_run_of_the_nanotec_waits_until_it_has_swung_out() {
    for time in [50_u16, 600] {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x2004, 4, &[20]);
        bench.write(NODE, 0x2004, 5, &time.to_le_bytes());
        number(&mut bench, 0x6099, 1, 1_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &[0xFE]);
        let mut bench = enabled(bench, 6);
        command(&mut bench, 0x1F);
        // A stop from 500 counts on.
        let (mut stood, mut last, mut most) = (0, None, 0.0_f64);
        for _ in 0..8_000 {
            let at = rotor(&mut bench);
            plant(&mut bench).load_torque = if at > 500.0 { (at - 500.0) * 0.05 } else { 0.0 };
            bench.run(1);
            most = most.max(current(&mut bench).abs());
            let demand = bench.drive.object(0x6062, 0);
            stood = if demand == last { stood + 1 } else { 0 };
            last = demand;
            let word = bench.drive.object(0x6041, 0).unwrap();
            if word[1] & 0x10 != 0 {
                break;
            }
        }
        assert_eq!(statusword(&mut bench) & 0x3000, 0x1000);
        assert!(
            (most - 20.0 * PERCENT).abs() < 0.15,
            "its own current: {most}"
        );
        let time = i32::from(time);
        assert!(
            (time - 60..time + 300).contains(&stood),
            "{stood} of {time}"
        );
    }
}

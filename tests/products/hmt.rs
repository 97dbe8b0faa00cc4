//! The closed loop of the LMD: hMT, its bounds, currents and make-up, the torque mode, locked rotors, the encoder.

use std::f64::consts::TAU;

use crate::bench::Bench;
use crate::steer::{
    NODE, begin, command, current, hold, number, on_servo, plant, position, statusword,
};

/// Microsteps of a turn and of a full step.
const TURN: f64 = 51_200.0;
const FULL_STEP: f64 = 256.0;

/// The torque of a full step of lead, in N·m, and its current, in A.
const HOLDING: f64 = 0.89;
const RATED: f64 = 4.2;

/// With the whole current, and hMT if it is to be.
fn lmd(hmt: bool) -> Bench {
    let mut bench = on_servo("lmd", "nema23");
    bench.write(NODE, 0x2204, 0, &[100]);
    bench.write(NODE, 0x2205, 0, &[40]);
    bench.write(NODE, 0x2701, 0, &[if hmt { 0x80 } else { 0 }]);
    bench.write(NODE, 0x2031, 0, &[8]);
    number(&mut bench, 0x6065, 0, u32::MAX);
    bench
}

fn enabled(mut bench: Bench, mode: u8) -> Bench {
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench
}

/// A load of so many times the holding torque, in either direction.
fn load(bench: &mut Bench, times: f64) {
    plant(bench).load_brake = times * HOLDING;
}

/// Where the rotor truly is, in microsteps.
fn rotor(bench: &mut Bench) -> f64 {
    plant(bench).angle() / TAU * TURN
}

fn byte(bench: &mut Bench, index: u16) -> u8 {
    bench.read(NODE, index, 0) as u8
}

/// The lead of the field, in hundredths of a full step.
fn lead(bench: &mut Bench) -> u16 {
    bench.drive.plant_mut().servo().unwrap().loops().lead()
}

#[test]
fn the_lmd_makes_up_what_a_load_holds_back() {
    for (configuration, speed) in [(0x22, None), (0x23, Some(1_000.0)), (0x23, Some(400.0))] {
        let mut bench = lmd(true);
        bench.write(NODE, 0x2702, 0, &[configuration]);
        if let Some(speed) = speed {
            // One step of 50 ns less two.
            number(&mut bench, 0x2703, 0, (20e6 / FULL_STEP / speed) as u32 - 2);
        }
        let mut bench = enabled(bench, 1);
        load(&mut bench, 1.4);
        begin(&mut bench, 100_000, 100_000, 1_000_000);
        bench.run(1_200);
        let behind = 100_000.0 - rotor(&mut bench);
        assert!(behind > 300.0 * FULL_STEP, "{behind}");
        assert_eq!(byte(&mut bench, 0x2742), 0x90, "it intervenes");
        assert_eq!(byte(&mut bench, 0x2741), 0x80, "which the filter hides");
        bench.write(NODE, 0x2743, 0, &[0xFF]);
        bench.run(5);
        assert_eq!(byte(&mut bench, 0x2741), 0x90);
        load(&mut bench, 0.0);
        bench.run(50);
        let from = rotor(&mut bench);
        bench.run(100);
        let made_up = (rotor(&mut bench) - from) / FULL_STEP * 10.0;
        match speed {
            Some(speed) => assert!((made_up / speed - 1.0).abs() < 0.04, "{made_up}"),
            None => assert!(made_up > 1_500.0, "{made_up}"),
        }
        bench.run(1_500);
        let away = (rotor(&mut bench) - 100_000.0) / FULL_STEP;
        assert!(away.abs() < 0.1, "{away} full steps");
        assert_eq!(byte(&mut bench, 0x2742), 0x80);
    }
}

#[test]
fn without_make_up_the_lmd_stays_behind() {
    let mut bench = lmd(true);
    bench.write(NODE, 0x2702, 0, &[0x20]);
    let mut bench = enabled(bench, 1);
    load(&mut bench, 1.4);
    begin(&mut bench, 50_000, 100_000, 1_000_000);
    bench.run(800);
    load(&mut bench, 0.0);
    bench.run(1_000);
    let behind = 50_000.0 - rotor(&mut bench);
    assert!(behind > 100.0 * FULL_STEP, "{behind}");
    assert_eq!(byte(&mut bench, 0x2742), 0x80);
}

#[test]
fn the_bound_of_the_lmd_is_the_one_of_its_configuration() {
    for (code, bound) in [(0, 110), (1, 130), (2, 150), (3, 170)] {
        let mut bench = lmd(true);
        bench.write(NODE, 0x2702, 0, &[0x02 | code << 5]);
        let mut bench = enabled(bench, 1);
        hold(&mut bench);
        begin(&mut bench, 20_000, 50_000, 1_000_000);
        bench.run(100);
        let mut most = 0;
        for _ in 0..50 {
            bench.run(1);
            most = most.max(lead(&mut bench));
        }
        assert_eq!(most, bound);
    }
}

#[test]
fn the_current_of_the_lmd_is_fixed_or_goes_with_the_load() {
    let mut bench = lmd(true);
    bench.write(NODE, 0x2702, 0, &[0x22]);
    bench.write(NODE, 0x2036, 0, &300_u16.to_le_bytes());
    let mut bench = enabled(bench, 1);
    begin(&mut bench, 3_000, 50_000, 1_000_000);
    bench.run(200);
    let runs = current(&mut bench).abs() / RATED;
    assert!((runs - 1.0).abs() < 0.03, "the run current: {runs}");
    bench.run(500);
    let rests = current(&mut bench).abs() / RATED;
    assert!((rests - 0.4).abs() < 0.03, "the hold current: {rests}");
    // Variable: by the load, also while it stands.
    bench.write(NODE, 0x2702, 0, &[0xA2]);
    bench.run(300);
    let rests = current(&mut bench).abs() / RATED;
    assert!((rests - 0.4).abs() < 0.05, "without a load: {rests}");
    plant(&mut bench).load_torque = 0.7 * HOLDING;
    bench.run(300);
    let holds = current(&mut bench).abs() / RATED;
    assert!(holds > 0.65, "with one: {holds}");
}

#[test]
fn the_lmd_gives_the_torque_that_it_is_asked_for() {
    let mut bench = enabled(lmd(true), 4);
    hold(&mut bench);
    number(&mut bench, 0x6087, 0, 1_000);
    bench.write(NODE, 0x6071, 0, &300_i16.to_le_bytes());
    bench.run(150);
    let grows = current(&mut bench) / RATED * 1e3;
    assert!((120.0..180.0).contains(&grows), "by its slope: {grows}");
    assert_eq!(statusword(&mut bench) & 1 << 10, 0);
    bench.run(300);
    for target in [300_i16, -200] {
        bench.write(NODE, 0x6071, 0, &target.to_le_bytes());
        bench.run(700);
        let truly = current(&mut bench) / RATED * 1e3;
        assert!((truly - f64::from(target)).abs() < 3.0, "{truly}");
        let told = bench.read(NODE, 0x6077, 0) as i16;
        assert!((told - target).abs() <= 1, "{told}");
        assert_ne!(statusword(&mut bench) & 1 << 10, 0);
    }
    // Halt holds the rotor where it is.
    plant(&mut bench).load_brake = 0.0;
    bench.run(300);
    command(&mut bench, 0x10F);
    bench.run(2_000);
    let stands = rotor(&mut bench);
    bench.run(100);
    assert!((rotor(&mut bench) - stands).abs() < 10.0);
}

#[test]
fn thousandths_of_the_lmd_are_of_the_motor_that_is_there() {
    for (axis, rated) in [("nema17", 1.7), ("nema23", 4.2)] {
        let mut bench = enabled(on_servo("lmd", axis), 4);
        hold(&mut bench);
        bench.write(NODE, 0x6071, 0, &200_i16.to_le_bytes());
        bench.run(500);
        let truly = current(&mut bench) / rated * 1e3;
        assert!((truly - 200.0).abs() < 2.0, "{axis}: {truly}");
        let told = bench.read(NODE, 0x6077, 0) as i16;
        assert!((told - 200).abs() <= 1, "{axis}: {told}");
    }
}

#[test]
fn a_rotor_of_the_lmd_that_is_held_has_the_whole_torque_whatever_its_velocity_may_be() {
    for (axis, rated, velocity) in [
        ("nema17", 1.7, 98_u8),
        ("nema23", 4.2, 98),
        ("nema23", 4.2, 255),
    ] {
        let mut bench = on_servo("lmd", axis);
        bench.write(NODE, 0x2704, 0, &[velocity]);
        let mut bench = enabled(bench, 4);
        hold(&mut bench);
        for target in [1_000_i16, -1_000] {
            bench.write(NODE, 0x6071, 0, &target.to_le_bytes());
            bench.run(2_500);
            let truly = current(&mut bench) / rated * 1e3;
            assert!((truly - f64::from(target)).abs() < 10.0, "{axis}: {truly}");
        }
    }
}

#[test]
fn the_torque_of_the_lmd_ends_at_its_velocity() {
    for limit in [98_u8, 198] {
        let mut bench = lmd(true);
        bench.write(NODE, 0x2704, 0, &[limit]);
        bench.write(NODE, 0x2708, 0, &[8]);
        let mut bench = enabled(bench, 4);
        bench.write(NODE, 0x6071, 0, &300_i16.to_le_bytes());
        bench.run(1_000);
        let from = rotor(&mut bench);
        bench.run(500);
        let velocity = (rotor(&mut bench) - from) * 2.0;
        let most = 12e6 / (f64::from(limit) + 2.0);
        assert!((velocity / most - 1.0).abs() < 0.05, "{velocity} of {most}");
    }
}

#[test]
fn a_locked_rotor_of_the_lmd_is_told_and_ends_the_current() {
    for (reaction, keeps) in [(1, true), (2, false)] {
        let mut bench = lmd(true);
        bench.write(NODE, 0x2710, 0, &300_u16.to_le_bytes());
        bench.write(NODE, 0x2711, 0, &[reaction]);
        let mut bench = enabled(bench, 1);
        hold(&mut bench);
        begin(&mut bench, 20_000, 50_000, 1_000_000);
        bench.run(250);
        assert_eq!(byte(&mut bench, 0x2742) & 0x08, 0, "not yet");
        bench.run(250);
        assert_eq!(byte(&mut bench, 0x2742) & 0x08, 0x08);
        assert_eq!(byte(&mut bench, 0x2741) & 0x08, 0x08);
        bench.run(100);
        let flows = current(&mut bench).abs() > 1.0;
        assert_eq!(flows, keeps, "reaction {reaction}");
        plant(&mut bench).load_brake = 0.0;
        bench.run(1_000);
        assert_eq!(byte(&mut bench, 0x2742) & 0x08, 0x08, "until it is cleared");
        bench.write(NODE, 0x2740, 0, &[4]);
        bench.run(5);
        assert_eq!(byte(&mut bench, 0x2742), 0x80);
    }
    let mut bench = lmd(true);
    bench.write(NODE, 0x2710, 0, &0_u16.to_le_bytes());
    let mut bench = enabled(bench, 1);
    hold(&mut bench);
    begin(&mut bench, 20_000, 50_000, 1_000_000);
    bench.run(7_000);
    assert_eq!(byte(&mut bench, 0x2742) & 0x08, 0, "0 is never");
}

#[test]
fn the_encoder_of_the_lmd_counts_once_it_is_enabled() {
    let mut bench = lmd(false);
    bench.write(NODE, 0x2031, 0, &[0]);
    bench.write(NODE, 0x2037, 0, &200_u16.to_le_bytes());
    let mut bench = enabled(bench, 1);
    begin(&mut bench, 10_000, 50_000, 1_000_000);
    bench.run(1_000);
    // Less than a full step of lead: nothing is lost.
    plant(&mut bench).load_torque = 0.2 * HOLDING;
    bench.run(300);
    let truly = rotor(&mut bench);
    assert!((truly - 10_000.0).abs() > 50.0, "{truly}");
    assert_eq!(position(&mut bench), 10_000, "what was commanded");
    bench.write(NODE, 0x2031, 0, &[8]);
    bench.run(150);
    assert_eq!(position(&mut bench), 10_000, "it settles");
    bench.run(100);
    let shown = f64::from(position(&mut bench));
    assert!((shown - truly).abs() < 5.0, "{shown}, not {truly}");
}

#[test]
fn a_correction_move_of_the_lmd_brings_back_what_was_lost() {
    for (reaction, comes_back) in [(0, false), (1, true), (2, true)] {
        let mut bench = lmd(false);
        bench.write(NODE, 0x2221, 1, &[reaction]);
        let mut bench = enabled(bench, 1);
        load(&mut bench, 1.4);
        begin(&mut bench, 50_000, 100_000, 1_000_000);
        bench.run(700);
        load(&mut bench, 0.0);
        bench.run(3_000);
        let away = (rotor(&mut bench) - 50_000.0) / FULL_STEP;
        assert_eq!(
            away.abs() < 0.1,
            comes_back,
            "{reaction}: {away} full steps"
        );
    }
}

#[test]
fn the_velocity_of_the_lmd_is_filtered() {
    for (filter, time) in [(0_u8, 1.0), (1, 64.0), (3, 196.0), (4, 256.0), (10, 32.0)] {
        let mut bench = lmd(true);
        bench.write(NODE, 0x2708, 0, &[filter]);
        let mut bench = enabled(bench, 3);
        number(&mut bench, 0x6083, 0, 100_000_000);
        bench.write(NODE, 0x60FF, 0, &50_000_i32.to_le_bytes());
        bench.run(20 + time as u32);
        let shown = f64::from(bench.read(NODE, 0x606C, 0) as i32) / 50_000.0;
        match filter {
            0 => assert!((shown - 1.0).abs() < 0.1, "{shown}"),
            _ => assert!((0.5..0.85).contains(&shown), "{filter}: {shown}"),
        }
    }
}

/// Where the motor is moved by pulses there is no torque to be had.
#[test]
fn a_motor_that_is_moved_by_pulses_has_no_torque_mode() {
    for (name, mode) in [("lmd", 4), ("nanotec", 4), ("s200", 4), ("s200", 0x82)] {
        for (mut bench, is_there) in [
            (Bench::node(name, NODE), false),
            (on_servo(name, "nema23"), true),
        ] {
            let answer = bench.sdo(NODE, [0x2F, 0x60, 0x60, 0, mode, 0, 0, 0]);
            assert_eq!(answer[0] == 0x60, is_there, "{name}: {answer:02X?}");
        }
    }
}

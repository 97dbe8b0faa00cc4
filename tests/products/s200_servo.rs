//! The motor of the S200: torque and current modes, limits, motor data, monitors.

use std::f64::consts::TAU;

use crate::bench::Bench;
use crate::prompt::line;
use crate::steer::{NODE, begin, current, hold, number, on_servo, plant, statusword};

/// Counts of a turn.
const TURN: f64 = 65_536.0;

/// The rated current of the motor, in A.
pub const RATED: f64 = 4.0;

pub fn s200() -> Bench {
    let mut bench = on_servo("s200", "servo_100w");
    number(&mut bench, 0x6080, 0, 2_500);
    number(&mut bench, 0x35C7, 1, i32::MAX as u32);
    bench
}

pub fn enabled(mut bench: Bench, mode: u8) -> Bench {
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench
}

/// A parameter of its text interface.
pub fn set(bench: &mut Bench, index: u16, value: i32) {
    bench.write(NODE, index, 1, &value.to_le_bytes());
}

pub fn get(bench: &mut Bench, index: u16) -> i32 {
    bench.read(NODE, index, 1) as i32
}

pub fn torque(bench: &mut Bench, target: i16) {
    bench.write(NODE, 0x6071, 0, &target.to_le_bytes());
}

/// Where the rotor truly is, in counts.
pub fn rotor(bench: &mut Bench) -> f64 {
    plant(bench).angle() / TAU * TURN
}

/// The mean of the current in d and q, in A.
fn mean(bench: &mut Bench) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for _ in 0..40 {
        bench.run(1);
        let [d, q] = plant(bench).current();
        sum = [sum[0] + d / 40.0, sum[1] + q / 40.0];
    }
    sum
}

/// In profile torque with a rotor that is held, and a part of the rated torque.
pub fn held(mut bench: Bench, target: i16) -> Bench {
    bench.run(5);
    let mut bench = enabled(bench, 4);
    hold(&mut bench);
    torque(&mut bench, target);
    bench.run(100);
    bench
}

#[test]
fn the_s200_gives_the_torque_that_it_is_asked_for() {
    for target in [100_i16, 400, -300] {
        let mut bench = held(s200(), target);
        let truly = current(&mut bench) / RATED * 1e3;
        assert!((truly - f64::from(target)).abs() < 3.0, "{truly}");
        let told = bench.read(NODE, 0x6077, 0) as i16;
        assert!((told - target).abs() <= 2, "{told}");
        assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 4);
        assert_ne!(statusword(&mut bench) & 1 << 10, 0);
    }
}

#[test]
fn the_s200_has_a_digital_current_mode() {
    let mut bench = s200();
    bench.write(NODE, 0x6060, 0, &[0x82]);
    assert_eq!(get(&mut bench, 0x35B4), 2, "OPMODE");
    let mut bench = enabled(bench, 0x82);
    hold(&mut bench);
    for milliamperes in [1_200, -700, 0] {
        set(&mut bench, 0x360E, milliamperes);
        bench.run(50);
        let flows = current(&mut bench) * 1e3;
        assert!((flows - f64::from(milliamperes)).abs() < 20.0, "{flows}");
    }
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 0x82);
}

#[test]
fn the_s200_has_an_analogue_current_mode() {
    let mut bench = s200();
    set(&mut bench, 0x3571, 2_000);
    set(&mut bench, 0x35B4, 3);
    assert_eq!(bench.read(NODE, 0x6060, 0) as u8, 0x83);
    let mut bench = enabled(bench, 0x83);
    hold(&mut bench);
    for reading in [1_300, 3_900] {
        bench.drive.plant_mut().analogue = reading;
        bench.run(300);
        let shown = f64::from(get(&mut bench, 0x3509));
        let flows = current(&mut bench) * 1e3;
        assert!((flows - shown / 5.0).abs() < 20.0, "{flows} at {shown}");
        assert!(flows > 300.0);
    }
}

/// ISCALE1 and VSCALE1: what 10 V mean as a current and as a velocity.
#[test]
fn the_analogue_input_of_the_s200_has_its_scales() {
    let mut bench = s200();
    bench.drive.plant_mut().analogue = 2_000;
    let mut bench = enabled(bench, 0x83);
    hold(&mut bench);
    for scale in [1_000, 3_000, -2_000] {
        set(&mut bench, 0x3571, scale);
        bench.run(300);
        let wanted = f64::from(get(&mut bench, 0x3509) * scale) / 1e4;
        let flows = current(&mut bench) * 1e3;
        assert!((flows - wanted).abs() < 20.0, "{flows}, not {wanted}");
        assert!(wanted.abs() > 300.0);
    }
    let mut bench = s200();
    bench.drive.plant_mut().analogue = 2_000;
    let mut bench = enabled(bench, 0x81);
    for scale in [300, 1_200, -600] {
        set(&mut bench, 0x3629, scale);
        bench.run(1_500);
        let wanted = f64::from(get(&mut bench, 0x3509) * scale) / 1e4;
        let runs = speed(&mut bench);
        assert!((runs / wanted - 1.0).abs() < 0.02, "{runs}, not {wanted}");
    }
}

/// In 1/min.
fn speed(bench: &mut Bench) -> f64 {
    let from = rotor(bench);
    bench.run(500);
    (rotor(bench) - from) / TURN * 120.0
}

/// ICMDVLIM, by a line of text: the limit of the speed in the modes of torque and current, and in no other.
#[test]
fn the_torque_of_the_s200_ends_at_the_speed_of_icmdvlim() {
    for mode in [4_u8, 0x82] {
        let mut bench = enabled(s200(), mode);
        assert_eq!(line(&mut bench, "ICMDVLIM"), "0\r\n", "none");
        for limit in [600, 300] {
            assert_eq!(line(&mut bench, &format!("ICMDVLIM {limit}")), "OK\r\n");
            for direction in [1_i16, -1] {
                torque(&mut bench, 200 * direction);
                set(&mut bench, 0x360E, 800 * i32::from(direction));
                bench.run(1_500);
                let runs = speed(&mut bench) * f64::from(direction);
                let most = f64::from(limit);
                assert!((runs / most - 1.0).abs() < 0.05, "{mode:02X}h: {runs}");
            }
        }
        line(&mut bench, "ICMDVLIM 0");
        bench.run(1_500);
        let runs = speed(&mut bench);
        assert!((runs / -2_500.0 - 1.0).abs() < 0.05, "6080h: {runs}");
    }
    let mut bench = enabled(s200(), 0x80);
    line(&mut bench, "ICMDVLIM 300");
    number(&mut bench, 0x60FF, 0, 655_360);
    bench.run(1_500);
    let runs = speed(&mut bench);
    assert!((runs / 600.0 - 1.0).abs() < 0.02, "{runs}");
}

#[test]
fn the_current_of_the_s200_has_its_limits() {
    let mut bench = s200();
    bench.write(NODE, 0x6073, 0, &250_u16.to_le_bytes());
    let mut bench = held(bench, 600);
    let flows = current(&mut bench);
    assert!((flows - 1.0).abs() < 0.02, "6073h: {flows}");
    bench.write(NODE, 0x6073, 0, &1_000_u16.to_le_bytes());
    // IPEAK in both directions, ILmtPlus and ILmtMinus in one.
    for (peak, plus, minus, most) in [
        (1_600, 0, 0, [1.6, -1.6]),
        (1_600, 800, 0, [0.8, -1.6]),
        (0, 2_000, 1_200, [2.0, -1.2]),
        (0, 0, 0, [2.4, -2.4]),
    ] {
        set(&mut bench, 0x356E, peak);
        set(&mut bench, 0x38F3, plus);
        set(&mut bench, 0x38F4, minus);
        // DILIM: that of the dual-port RAM counts too.
        set(&mut bench, 0x3658, 1_000);
        set(&mut bench, 0x362C, 1);
        torque(&mut bench, 600);
        bench.run(60);
        let flows = current(&mut bench);
        let least = if plus == 800 { 0.8 } else { 1.0 };
        assert!((flows - least).abs() < 0.03, "DPRILIMIT: {flows}");
        set(&mut bench, 0x362C, 0);
        for (target, most) in [600_i16, -600].into_iter().zip(most) {
            torque(&mut bench, target);
            bench.run(60);
            let flows = current(&mut bench);
            assert!((flows - most).abs() < 0.03, "{flows}, not {most}");
        }
    }
}

#[test]
fn the_monitors_of_the_s200_show_the_current() {
    let mut bench = s200();
    // Not all of it is across the magnet.
    set(&mut bench, 0x359C, 30);
    let mut bench = held(bench, -400);
    let [d, q] = plant(&mut bench).current();
    let size = d.hypot(q) * 1e3;
    bench.run(2);
    // The drive takes the magnet for where MPHASE says: there is no current along it.
    for (index, wanted) in [
        (0x3558, -size),
        (0x3570, -size),
        (0x3B89, -size),
        (0x355D, 0.0),
        (0x3B8A, 0.0),
    ] {
        let shown = f64::from(get(&mut bench, index));
        assert!(
            (shown - wanted).abs() < 40.0,
            "{index:04X}h: {shown}, not {wanted}"
        );
    }
}

#[test]
fn the_phase_of_the_motor_turns_the_current_of_the_s200() {
    for (index, degrees) in [(0x359C_u16, 0), (0x359C, 60), (0x38FD, -60), (0x38FD, 90)] {
        let mut bench = s200();
        set(&mut bench, index, degrees);
        let mut bench = held(bench, 400);
        let [d, q] = mean(&mut bench);
        let turned = d.atan2(q).to_degrees().abs();
        let wanted = f64::from(degrees).abs();
        assert!((turned - wanted).abs() < 2.0, "{index:04X}h: {turned}");
    }
}

#[test]
fn the_current_of_the_s200_leads_by_current_and_by_speed() {
    // MTANGLP at MIPEAK.
    let mut bench = s200();
    set(&mut bench, 0x358F, 4_000);
    set(&mut bench, 0x35A5, 40);
    let mut bench = held(bench, 500);
    let [d, q] = mean(&mut bench);
    let leads = (-d).atan2(q).to_degrees();
    assert!((leads - 20.0).abs() < 2.5, "at half of the peak: {leads}");
    // MVANGLF at MSPEED, from MVANGLB on.
    let mut angles = Vec::new();
    for limit in [0, 30] {
        let mut bench = s200();
        set(&mut bench, 0x35A3, 2_000);
        set(&mut bench, 0x35A7, 500);
        set(&mut bench, 0x35A8, limit);
        let mut bench = enabled(bench, 3);
        plant(&mut bench).load_brake = 0.1;
        number(&mut bench, 0x6083, 0, 6_553_600);
        for speed in [400, 1_250] {
            let velocity: i32 = speed * 65_536 / 60;
            bench.write(NODE, 0x60FF, 0, &velocity.to_le_bytes());
            bench.run(700);
            let [d, q] = mean(&mut bench);
            angles.push((-d).atan2(q).to_degrees());
        }
    }
    let more = [angles[2] - angles[0], angles[3] - angles[1]];
    assert!(more[0].abs() < 2.0, "below its start: {more:?}");
    assert!((more[1] - 15.0).abs() < 2.5, "half of the way: {more:?}");
}

#[test]
fn the_torque_constant_of_the_s200_makes_its_current() {
    // 80 mN·m/A is what the motor has, and 320 mN·m are rated.
    for (constant, milliamperes) in [(0, 2_000.0), (80, 2_000.0), (100, 1_600.0)] {
        let mut bench = s200();
        set(&mut bench, 0x3593, constant);
        let mut bench = held(bench, 500);
        let flows = current(&mut bench) * 1e3;
        assert!((flows - milliamperes).abs() < 20.0, "{constant}: {flows}");
    }
}

#[test]
fn the_poles_of_the_motor_are_those_of_the_s200() {
    for (poles, turns) in [(0, true), (8, true), (20, false)] {
        let mut bench = s200();
        set(&mut bench, 0x38F9, poles);
        bench.run(5);
        let mut bench = enabled(bench, 1);
        begin(&mut bench, 30_000, 65_536, 655_360);
        bench.run(1_200);
        let away = (rotor(&mut bench) - 30_000.0).abs();
        assert_eq!(away < 60.0, turns, "{poles}: {away} counts");
    }
}

#[test]
fn the_s200_warns_of_its_heat() {
    let mut times = Vec::new();
    for percent in [40, 80] {
        let mut bench = s200();
        set(&mut bench, 0x355A, percent);
        bench.write(NODE, 0x6073, 0, &3_000_u16.to_le_bytes());
        let mut bench = held(bench, 2_500);
        assert_eq!(bench.read(NODE, 0x2000, 0) & 1, 0, "not yet");
        let mut time = 0;
        while bench.read(NODE, 0x2000, 0) & 1 == 0 {
            bench.run(10);
            time += 10;
            assert!(
                time < 5_000 && current(&mut bench) > 9.0,
                "{percent}: {time}"
            );
        }
        times.push(time);
        let display = bench.read(NODE, 0x5104, 0).to_le_bytes();
        assert_eq!(&display, b"n01 ");
        torque(&mut bench, 0);
        bench.run(6_000);
        assert_eq!(bench.read(NODE, 0x2000, 0) & 1, 0, "it has cooled");
    }
    assert!(times[1] * 2 > times[0] * 3, "{times:?}");
}

#[test]
fn a_motor_that_runs_against_its_current_is_f25() {
    for (bound, faults) in [(0, false), (60, true)] {
        let mut bench = s200();
        set(&mut bench, 0x365A, bound);
        // The magnet is half a turn away from where it is.
        set(&mut bench, 0x359C, 180);
        bench.run(5);
        let mut bench = enabled(bench, 4);
        // So slowly that the encoder is not found to be wrong before.
        plant(&mut bench).load_brake = 0.022;
        torque(&mut bench, 100);
        bench.run(600);
        let display = bench.read(NODE, 0x5104, 0).to_le_bytes();
        let code = bench.read(NODE, 0x1003, 1);
        assert_eq!(&display == b"F25 ", faults, "{display:?} {code:X}");
        if faults {
            assert_ne!(statusword(&mut bench) & 8, 0);
            assert!(current(&mut bench).abs() < 0.1);
        }
    }
    // One that brakes is none.
    let mut bench = s200();
    set(&mut bench, 0x365A, 300);
    let mut bench = enabled(bench, 3);
    number(&mut bench, 0x6083, 0, 6_553_600);
    number(&mut bench, 0x6084, 0, 6_553_600);
    for velocity in [1_500_000_i32, -1_500_000, 0] {
        bench.write(NODE, 0x60FF, 0, &velocity.to_le_bytes());
        bench.run(700);
        assert_eq!(statusword(&mut bench) & 8, 0);
    }
}

#[test]
fn the_s200_shows_the_states_of_its_hall_signals() {
    let mut bench = s200();
    let mut seen = Vec::new();
    plant(&mut bench).load_torque = -0.015;
    for _ in 0..100 {
        bench.run(1);
        let state = bench.drive.object(0x38FC, 1).unwrap();
        let state = i32::from(state[0]);
        if seen.last() != Some(&state) {
            seen.push(state);
        }
        if seen.len() > 8 {
            break;
        }
    }
    let order = [1, 3, 2, 6, 4, 5];
    for pair in seen.windows(2) {
        let place = order.iter().position(|state| *state == pair[0]).unwrap();
        assert_eq!(order[(place + 1) % 6], pair[1], "{seen:?}");
    }
    assert!(seen.len() > 6, "{seen:?}");
}

#[test]
fn the_s200_knows_a_motor_by_its_number() {
    let mut bench = s200();
    // Data of another one, and none that is said to be right: no current.
    set(&mut bench, 0x38F9, 20);
    set(&mut bench, 0x3593, 300);
    set(&mut bench, 0x3900, 0);
    let mut bench = held(bench, 500);
    assert!(current(&mut bench).abs() < 0.02, "not configured");
    bench.write(NODE, 0x6040, 0, &[0, 0]);
    bench.run(50);
    set(&mut bench, 0x3599, 1);
    bench.run(5);
    assert_eq!(bench.read(NODE, 0x38F0, 1).to_le_bytes(), *b"M100");
    for (index, value) in [
        (0x3900, 1),
        (0x35A6, 1),
        (0x38F9, 8),
        (0x3593, 80),
        (0x3577, 800),
        (0x358E, 4_000),
        (0x358F, 12_000),
        (0x35A3, 3_000),
    ] {
        assert_eq!(get(&mut bench, index), value, "{index:04X}h");
    }
    let mut bench = held(bench, 500);
    let flows = current(&mut bench);
    assert!((flows - 2.0).abs() < 0.03, "{flows}");
    let answer = bench.sdo(NODE, [0x23, 0x99, 0x35, 1, 7, 0, 0, 0]);
    assert_eq!(answer[0], 0x80, "it knows no such motor");
}

/// What MNUMBER writes into 6080h counts at once, and not from the next write of something else on.
#[test]
fn the_number_of_a_motor_gives_the_s200_its_greatest_speed() {
    let mut bench = enabled(s200(), 3);
    number(&mut bench, 0x6083, 0, 6_553_600);
    number(&mut bench, 0x60FF, 0, 655_360);
    number(&mut bench, 0x6080, 0, 300);
    bench.run(500);
    let runs = speed(&mut bench);
    assert!((runs / 300.0 - 1.0).abs() < 0.02, "{runs}");
    set(&mut bench, 0x3599, 1);
    bench.run(500);
    assert_eq!(bench.read(NODE, 0x6080, 0), 3_000);
    let runs = speed(&mut bench);
    assert!((runs / 600.0 - 1.0).abs() < 0.02, "{runs}");
}

#[test]
fn the_s200_turns_no_faster_than_its_feedback_can_tell() {
    let mut bench = s200();
    number(&mut bench, 0x6080, 0, 6_000);
    bench.run(5);
    let most = get(&mut bench, 0x3675);
    assert_eq!(most, 3_000);
    let mut bench = enabled(bench, 3);
    number(&mut bench, 0x6083, 0, 6_553_600);
    let velocity = 5_000 * 65_536 / 60;
    number(&mut bench, 0x60FF, 0, velocity);
    bench.run(1_500);
    let from = rotor(&mut bench);
    bench.run(200);
    let speed = (rotor(&mut bench) - from) / TURN * 300.0;
    assert!((speed - 3_000.0).abs() < 30.0, "{speed}");
}

#[test]
fn spent_heat_limits_the_current_or_is_f15() {
    for (mode, faults) in [(0, false), (1, true)] {
        let mut bench = s200();
        set(&mut bench, 0x3B7F, mode);
        bench.write(NODE, 0x6073, 0, &3_000_u16.to_le_bytes());
        let mut bench = held(bench, 2_500);
        bench.run(6_000);
        let display = bench.read(NODE, 0x5104, 0).to_le_bytes();
        assert_eq!(&display == b"F15 ", faults, "{display:?}");
        let flows = current(&mut bench);
        let most = if faults { 0.0 } else { RATED };
        assert!((flows - most).abs() < 0.2, "{flows}");
    }
}

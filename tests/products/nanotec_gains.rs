//! Gains and load angles of the closed loop of the Nanotec.

use std::f64::consts::TAU;

use crate::bench::Bench;
use crate::nanotec_loop::{ABSOLUTE, PERCENT, enabled, load_angles, nanotec, rotor, torque};
use crate::steer::{NODE, current, hold, number, plant};

/// The load angle of the current, in 65536ths of an electrical turn, as 200Ch has it.
fn load_angle(bench: &mut Bench) -> f64 {
    let [d, q] = plant(bench).current();
    q.atan2(d) / TAU * 65_536.0 - if q < 0.0 { -65_536.0 } else { 0.0 }
}

/// The mean of it over whole electrical turns at 250, 500 and 750 rpm: a turn has its ripple.
fn mean_load_angle(bench: &mut Bench) -> f64 {
    let mut sum = 0.0;
    for _ in 0..48 {
        bench.run(1);
        let angle = load_angle(bench);
        // A torque the other way is its mirror.
        sum += if angle > 32_768.0 {
            65_536.0 - angle
        } else {
            angle
        };
    }
    sum / 48.0
}

/// How much more the current leads by the curve than by a quarter of a turn at the same speed.
fn leads_more(bench: &mut Bench) -> f64 {
    let angles: [u16; 7] = std::array::from_fn(|n| bench.read(NODE, 0x200C, n as u8 + 1) as u16);
    let leads = mean_load_angle(bench);
    load_angles(bench, [16_384; 7]);
    bench.run(30);
    let flat = mean_load_angle(bench);
    load_angles(bench, angles);
    bench.run(30);
    leads - flat
}

/// In velocity mode at so many turns a minute.
fn turns(bench: &mut Bench, per_minute: i16) {
    for (index, sub) in [(0x6048, 1), (0x6049, 1)] {
        number(bench, index, sub, 200_000);
    }
    let target = i32::from(per_minute) * 2_000 / 60;
    bench.write(NODE, 0x6046, 2, &25_000_u32.to_le_bytes());
    bench.write(NODE, 0x6042, 0, &(target as i16).to_le_bytes());
    bench.run(1_500);
}

#[test]
fn the_load_angle_of_the_nanotec_goes_by_the_speed() {
    let mut bench = nanotec(ABSOLUTE, 1);
    load_angles(
        &mut bench,
        [16_384, 16_384, 20_384, 20_384, 20_384, 20_384, 20_384],
    );
    bench.write(NODE, 0x2004, 8, &3_072_u16.to_le_bytes());
    let mut bench = enabled(bench, 2);
    plant(&mut bench).load_brake = 0.2;
    for (speed, more) in [(300, 0.0), (562, 2_000.0), (740, 4_000.0)] {
        turns(&mut bench, speed);
        let leads = leads_more(&mut bench);
        assert!((leads - more).abs() < 500.0, "at {speed}: {leads}");
    }
    // The same curve over half of the speed.
    bench.write(NODE, 0x2004, 8, &1_536_u16.to_le_bytes());
    turns(&mut bench, 380);
    let leads = leads_more(&mut bench);
    assert!((leads - 4_000.0).abs() < 500.0, "{leads}");
}

/// The tables of its appendix: motors and their load angles.
const PRESETS: [(&str, [u16; 7]); 26] = [
    (
        "stepper",
        [16_384, 18_384, 20_384, 22_384, 24_384, 26_384, 28_384],
    ),
    (
        "BLDC",
        [16_384, 16_500, 17_000, 17_500, 18_000, 18_500, 19_000],
    ),
    (
        "ST",
        [16_384, 16_500, 17_000, 17_500, 18_000, 18_500, 19_000],
    ),
    (
        "DB22L01",
        [16_000, 16_500, 17_000, 17_500, 18_000, 18_500, 19_000],
    ),
    (
        "DB22M01",
        [16_000, 16_500, 17_000, 17_500, 18_000, 18_500, 18_500],
    ),
    (
        "DB28M01",
        [16_000, 17_000, 17_000, 17_000, 18_000, 18_000, 18_000],
    ),
    (
        "DB28S01",
        [16_000, 16_500, 17_000, 17_500, 18_000, 18_500, 18_500],
    ),
    (
        "DB33S01",
        [16_000, 16_000, 16_500, 16_500, 17_000, 17_000, 17_000],
    ),
    (
        "DB42C01",
        [16_000, 18_000, 20_000, 20_000, 20_000, 21_000, 20_000],
    ),
    (
        "DB42C02",
        [16_000, 18_000, 20_000, 20_000, 20_000, 21_000, 22_000],
    ),
    (
        "DB42C03",
        [16_000, 16_500, 16_800, 17_100, 17_400, 17_700, 17_800],
    ),
    (
        "DB42L01",
        [16_000, 17_000, 17_500, 17_500, 17_700, 18_300, 18_400],
    ),
    (
        "DB42M01",
        [16_000, 16_500, 17_000, 17_500, 18_500, 18_750, 19_000],
    ),
    (
        "DB42M02",
        [16_000, 18_000, 20_000, 20_000, 20_000, 21_000, 22_000],
    ),
    (
        "DB42M03",
        [16_000, 17_000, 17_000, 17_000, 18_000, 19_000, 19_000],
    ),
    (
        "DB42S01",
        [16_000, 16_500, 17_000, 17_500, 18_000, 18_000, 18_500],
    ),
    (
        "DB42S02",
        [16_000, 18_000, 18_000, 18_000, 18_500, 19_000, 19_000],
    ),
    (
        "DB42S03",
        [16_000, 18_000, 20_000, 20_000, 20_000, 21_000, 22_000],
    ),
    (
        "DB57C01",
        [16_000, 16_500, 16_500, 16_500, 17_000, 17_000, 17_000],
    ),
    (
        "DB57L01",
        [16_000, 17_000, 17_000, 17_000, 17_000, 17_000, 17_000],
    ),
    (
        "DB57S01",
        [16_500, 17_000, 17_000, 17_000, 17_000, 17_500, 17_500],
    ),
    (
        "DB87L01-S",
        [16_384, 17_000, 17_000, 17_000, 17_000, 17_000, 17_000],
    ),
    (
        "DB87M01-S",
        [16_384, 18_384, 20_384, 22_384, 24_384, 26_384, 28_384],
    ),
    (
        "DB87S01-S",
        [16_000, 16_500, 17_000, 17_250, 17_500, 17_500, 18_000],
    ),
    (
        "default of 200Ch",
        [16_384, 17_000, 17_500, 17_750, 18_000, 18_000, 18_000],
    ),
    ("none", [16_384; 7]),
];

/// Each is taken by a motor that turns as fast as its second and third point.
#[test]
fn the_load_angles_of_each_motor_are_taken() {
    let mut bench = nanotec(ABSOLUTE, 1);
    bench.write(NODE, 0x2004, 8, &2_048_u16.to_le_bytes());
    let mut bench = enabled(bench, 2);
    plant(&mut bench).load_brake = 0.25;
    for (speed, point) in [(250, 1), (500, 2), (750, 3)] {
        turns(&mut bench, speed);
        load_angles(&mut bench, [16_384; 7]);
        bench.run(300);
        let flat = mean_load_angle(&mut bench) - 16_384.0;
        for (motor, angles) in PRESETS {
            load_angles(&mut bench, angles);
            bench.run(30);
            let leads = mean_load_angle(&mut bench) - flat;
            let wanted = f64::from(angles[point]);
            // At the last point the bus has not the whole voltage.
            let away = if point == 3 { 800.0 } else { 150.0 };
            assert!(
                (leads - wanted).abs() < away,
                "{motor} at {speed}: {leads}, not {wanted}"
            );
        }
    }
}

/// How far a load turns a rotor that stands, at most, in counts.
fn yields(bench: &mut Bench) -> f64 {
    let stands = rotor(bench);
    plant(bench).load_torque = 0.25;
    let mut most = 0.0_f64;
    for _ in 0..200 {
        bench.run(1);
        most = most.max((rotor(bench) - stands).abs());
    }
    most
}

#[test]
fn the_controllers_of_the_nanotec_have_their_gains() {
    let with = |mode: u8, sub: u8, value: u16| {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x2002, sub, &value.to_le_bytes());
        let mut bench = enabled(bench, mode);
        bench.run(300);
        yields(&mut bench)
    };
    // Velocity mode has the speed controller.
    let stiff = with(2, 1, 2);
    let soft = with(2, 1, 1);
    assert!(soft > 1.5 * stiff, "half of P: {soft}, {stiff}");
    let softer = with(2, 2, 2);
    assert!(
        softer > 1.5 * soft,
        "a quarter, as a power of two: {softer}"
    );
    let soft = with(2, 4, 8);
    assert!(soft > 1.5 * stiff, "a quarter of I: {soft}");
    // The others have the position controller.
    let stiff = with(1, 7, 100);
    let soft = with(1, 7, 10);
    assert!(soft > 1.2 * stiff, "a tenth of P: {soft}, {stiff}");
    let soft = with(1, 11, 100);
    assert!(soft > 1.5 * stiff, "a third of D: {soft}, {stiff}");
    let soft = with(1, 12, 2);
    assert!(soft > 1.5 * stiff, "a quarter of D: {soft}, {stiff}");
}

#[test]
fn the_integral_of_the_nanotec_takes_a_load() {
    let with = |power: u16| {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x2002, 10, &power.to_le_bytes());
        let mut bench = enabled(bench, 1);
        bench.run(300);
        let stands = rotor(&mut bench);
        plant(&mut bench).load_torque = 0.25;
        bench.run(150);
        (rotor(&mut bench) - stands).abs()
    };
    let (quick, slow) = (with(0), with(8));
    assert!(slow > 2.0 + 2.0 * quick, "{slow} counts are left, {quick}");
}

#[test]
fn the_cascade_of_the_nanotec_comes_with_the_speed() {
    let ripple = |first: u16| {
        let mut bench = nanotec(ABSOLUTE, 1);
        // On above 200/min, off below 100/min.
        number(&mut bench, 0x2004, 9, 8_192 / 5);
        number(&mut bench, 0x2004, 10, 819);
        bench.write(NODE, 0x2002, 13, &first.to_le_bytes());
        let mut bench = enabled(bench, 2);
        for (speed, is_on) in [(150, 0), (250, 1), (150, 1), (80, 0), (300, 1)] {
            turns(&mut bench, speed);
            assert_eq!(bench.read(NODE, 0x2004, 11) as u8, is_on, "{speed}");
        }
        let from = rotor(&mut bench);
        plant(&mut bench).load_torque = 0.25;
        bench.run(10);
        (rotor(&mut bench) - from) / 10.0
    };
    // Counts in a millisecond, of ten without a load: a softer one yields more.
    let (stiff, soft) = (ripple(50), ripple(10));
    assert!(
        (stiff - 10.0).abs() < 0.6 * (soft - 10.0).abs(),
        "{stiff}, {soft}"
    );
}

#[test]
fn the_velocity_of_a_nanotec_is_controlled_by_speed_or_by_position() {
    for (by_position, catches_up) in [(0_u8, false), (1, true)] {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x200F, 0, &[by_position]);
        number(&mut bench, 0x6065, 0, u32::MAX);
        let mut bench = enabled(bench, 2);
        turns(&mut bench, 150);
        let (before, demanded) = (rotor(&mut bench), bench.read(NODE, 0x6062, 0) as i32);
        hold(&mut bench);
        bench.run(30);
        plant(&mut bench).load_brake = 0.0;
        bench.run(1_000);
        let way = rotor(&mut bench) - before;
        let wanted = f64::from(bench.read(NODE, 0x6062, 0) as i32 - demanded);
        assert_eq!((wanted - way).abs() < 20.0, catches_up, "{way} of {wanted}");
    }
}

/// The share of a step of the current that has come a tenth of a millisecond behind its begin, with this KP and its scale, at rest or at 500/min.
fn rises(gain: u16, scale: u16, turns: bool) -> f64 {
    let mut bench = nanotec(ABSOLUTE, 1);
    bench.write(NODE, 0x200E, 2, &gain.to_le_bytes());
    bench.write(NODE, 0x200E, 3, &scale.to_le_bytes());
    load_angles(&mut bench, [16_384; 7]);
    number(&mut bench, 0x607F, 0, 500);
    let mut bench = enabled(bench, 4);
    if turns {
        torque(&mut bench, 400);
        bench.run(1_500);
    } else {
        hold(&mut bench);
        bench.run(50);
    }
    let before = plant(&mut bench).current()[1];
    torque(&mut bench, -400);
    for _ in 0..40 {
        bench.tick();
        if plant(&mut bench).current()[1] - before < -0.1 {
            break;
        }
    }
    bench.tick();
    let rises = plant(&mut bench).current()[1] - before;
    rises / (-0.4 * 50.0 * PERCENT - before)
}

#[test]
fn the_current_controller_of_the_nanotec_has_its_gains() {
    let (own, slow) = (rises(10, 0, false), rises(2, 0, false));
    assert!(slow < 0.7 * own, "KP: {slow}, {own}");
    // Its scale counts with the speed.
    let scaled = rises(2, 58, false);
    assert!((scaled - slow).abs() < 0.05, "at rest: {scaled}, {slow}");
    let (slow, scaled) = (rises(2, 0, true), rises(2, 200, true));
    assert!(scaled > 1.3 * slow, "at 500/min: {scaled}, {slow}");
    // A magnet that is not where it is thought to be drives a voltage that is not known: KI takes it up.
    let flows = |gain: u16, scale: u16| {
        let mut bench = nanotec(ABSOLUTE, 1);
        bench.write(NODE, 0x200E, 5, &gain.to_le_bytes());
        bench.write(NODE, 0x200E, 6, &scale.to_le_bytes());
        bench.write(NODE, 0x200B, 0, &7_000_u16.to_le_bytes());
        load_angles(&mut bench, [16_384; 7]);
        let mut bench = enabled(bench, 4);
        plant(&mut bench).load_torque = -0.05;
        let mut sum = 0.0;
        let mut ticks = 0.0;
        for _ in 0..2_000 {
            bench.tick();
            let speed = plant(&mut bench).velocity() * 60.0 / TAU;
            if speed > 50.0 {
                sum += current(&mut bench).abs();
                ticks += 1.0;
            }
            if speed > 80.0 {
                break;
            }
        }
        assert!(ticks > 0.0);
        sum / ticks
    };
    let (own, none, scaled) = (flows(10, 0), flows(0, 0), flows(0, 1_200));
    assert!(none > 0.01 + 1.5 * own, "KI: {none}, {own}");
    assert!(scaled < 0.8 * none, "by its scale: {scaled}, {none}");
}

//! The S200's commands among its parameters, its command engine, its own modes, jog and limits of speed.

use canopen::Frame;

use crate::bench::Bench;
use crate::steer::{NODE, command, enabled, number, position, statusword, way};

/// Counts/s of a turn per minute.
fn per_minute(turns: i32) -> i32 {
    turns * 65_536 / 60
}

fn is_near(value: i32, expected: i32) -> bool {
    value.abs_diff(expected) <= expected.unsigned_abs() / 50 + 2
}

fn refusal(bench: &mut Bench, index: u16, sub: u8, value: u8) -> u32 {
    let [low, high] = index.to_le_bytes();
    let answer = bench.sdo(NODE, [0x2F, low, high, sub, value, 0, 0, 0]);
    assert_eq!(answer[0], 0x80, "{index:04X}h:{sub} takes {value}");
    u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])
}

/// The number of a parameter that is stored and loaded: DECDIS, which nothing here reads.
const PARAMETER: u16 = 0x3523;

/// 4000h:5 stores, :6 loads what is stored, :4 forgets it, :7 starts the drive anew; meanwhile the engine is busy.
#[test]
fn the_command_engine_stores_and_restores() {
    let mut bench = Bench::node("s200", NODE);
    assert_eq!(bench.read(NODE, 0x4000, 1) as u8, 0);
    number(&mut bench, PARAMETER, 1, 77);
    bench.write(NODE, 0x4000, 5, &[1]);
    assert_eq!(refusal(&mut bench, 0x4000, 5, 1), 0xFF04_0000, "busy");
    assert_eq!(bench.read(NODE, 0x4000, 1) as u8, 1, "busy");
    bench.run(1_000);
    assert_eq!(bench.read(NODE, 0x4000, 1) as u8, 0);
    number(&mut bench, PARAMETER, 1, 5);
    bench.write(NODE, 0x4000, 6, &[1]);
    bench.run(500);
    assert_eq!(bench.read(NODE, PARAMETER, 1), 77, "restored");
    number(&mut bench, PARAMETER, 1, 5);
    bench.sent.clear();
    bench.write(NODE, 0x4000, 7, &[1]);
    assert!(bench.next(0x704, 500).is_some(), "it boots");
    bench.run(200);
    assert_eq!(bench.read(NODE, PARAMETER, 1), 77);
    bench.write(NODE, 0x4000, 4, &[1]);
    bench.run(500);
    bench.drive.power_cycle();
    bench.run(200);
    assert_eq!(bench.read(NODE, PARAMETER, 1), 0, "the default");
}

/// S stops the motor and takes its power until a controlword is written.
#[test]
fn s_stops_the_motor_and_disables_it() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x60FF, 0, 50_000);
    bench.run(500);
    number(&mut bench, 0x35EA, 1, 1);
    bench.run(500);
    assert_eq!(statusword(&mut bench) & 0x4F, 0x40);
    assert_eq!(way(&mut bench, 200), 0);
    assert!(!bench.drive.plant_mut().is_energised());
    number(&mut bench, 0x60FF, 0, 0);
    bench.enable(NODE);
}

/// CLRFAULT resets a fault as bit 7 does; bit 11 resets those of category 2 alone.
#[test]
fn clrfault_and_bit_11_reset_faults() {
    for (code, by_bit_11) in [(0x8053_u16, false), (0xFF06, true)] {
        let mut bench = enabled("s200", 1);
        let fail = |bench: &mut Bench| {
            bench.drive.plant_mut().fault = Some(code);
            bench.run(500);
            bench.drive.plant_mut().fault = None;
            bench.run(20);
            assert_eq!(statusword(bench) & 0x4F, 0x08);
        };
        fail(&mut bench);
        command(&mut bench, 0x800);
        bench.run(20);
        assert_eq!(statusword(&mut bench) & 0x08 == 0, by_bit_11, "{code:04X}h");
        if by_bit_11 {
            command(&mut bench, 0);
            fail(&mut bench);
        }
        number(&mut bench, 0x3518, 1, 1);
        bench.run(20);
        assert_eq!(statusword(&mut bench) & 0x08, 0, "CLRFAULT");
    }
}

/// MH homes whatever the mode is, and the mode is the master's again behind it; SETREF takes the position as it is.
#[test]
fn mh_and_setref_find_a_reference() {
    let mut bench = enabled("s200", 1);
    number(&mut bench, 0x6081, 0, 50_000);
    number(&mut bench, 0x607A, 0, 3_000);
    command(&mut bench, 0x1F);
    bench.run(500);
    bench.write(NODE, 0x6098, 0, &[24]);
    number(&mut bench, 0x35F0, 1, 1);
    bench.run(100);
    assert_eq!(position(&mut bench), 0);
    assert_eq!(bench.read(NODE, 0x6098, 0) as u8, 24);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 1);
    number(&mut bench, 0x607A, 0, 500);
    command(&mut bench, 0x0F);
    command(&mut bench, 0x1F);
    bench.run(500);
    bench.write(NODE, 0x6098, 0, &[35]);
    number(&mut bench, 0x358D, 1, 1);
    bench.run(100);
    assert_eq!(position(&mut bench), 0, "MH");
    command(&mut bench, 0);
    bench.run(50);
    for index in [0x358D_u16, 0x35F0, 0x3591, 0x3642] {
        let [low, high] = index.to_le_bytes();
        let answer = bench.sdo(NODE, [0x23, low, high, 1, 1, 0, 0, 0]);
        assert_eq!(
            answer[4..],
            [0x22, 0, 0, 8],
            "{index:04X}h needs a motor that is on"
        );
    }
}

/// NREF and DREF are another way to say 6098h.
#[test]
fn nref_and_dref_choose_the_method() {
    let mut bench = Bench::node("s200", NODE);
    for (kind, direction, method) in [(2, 1, 2), (1, 0, 12), (4, 0, 17), (3, 1, 24), (7, 0, -3)] {
        number(&mut bench, 0x35AD, 1, kind);
        number(&mut bench, 0x352C, 1, direction);
        assert_eq!(bench.read(NODE, 0x6098, 0) as i8, method);
    }
    for (method, kind, direction) in [(8_i8, 1, 1), (28, 3, 0), (35, 0, 0), (-2, 6, 0)] {
        bench.write(NODE, 0x6098, 0, &[method as u8]);
        assert_eq!(bench.read(NODE, 0x35AD, 1), kind);
        assert_eq!(bench.read(NODE, 0x352C, 1), direction);
    }
}

/// MJOG runs at VJOG with ACCR and DECR until STOP; bit 17 of 1002h tells.
#[test]
fn mjog_runs_until_it_is_stopped() {
    let mut bench = enabled("s200", 1);
    number(&mut bench, 0x3621, 1, -30_000_i32 as u32);
    number(&mut bench, 0x3502, 1, 60_000);
    number(&mut bench, 0x3524, 1, 30_000);
    number(&mut bench, 0x3591, 1, 1);
    let first = way(&mut bench, 500);
    assert!((-8_000..=-7_000).contains(&first), "ACCR: {first}");
    assert!(is_near(way(&mut bench, 1_000), -30_000));
    assert_eq!(bench.read(NODE, 0x1002, 0) >> 17 & 1, 1);
    number(&mut bench, 0x35FE, 1, 1);
    let last = way(&mut bench, 1_500);
    assert!((-15_500..=-14_500).contains(&last), "DECR: {last}");
    assert_eq!(way(&mut bench, 200), 0);
    assert_eq!(bench.read(NODE, 0x1002, 0) >> 17 & 1, 0);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 1);
}

/// Mode 80h runs at 60FFh, mode 81h by the analogue input with VSCALE1, VMUL and a dead band.
#[test]
fn digital_and_analogue_velocity_run_the_motor() {
    let mut bench = enabled("s200", 0x80);
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 0x80);
    number(&mut bench, 0x60FF, 0, 20_000);
    bench.run(500);
    assert!(is_near(way(&mut bench, 500), 10_000));
    number(&mut bench, 0x60FF, 0, 0);
    bench.run(500);
    command(&mut bench, 0);
    number(&mut bench, 0x35B4, 1, 1);
    assert_eq!(bench.read(NODE, 0x6060, 0) as u8, 0x81, "OPMODE");
    number(&mut bench, 0x3629, 1, 60);
    number(&mut bench, 0x3508, 1, 500);
    bench.enable(NODE);
    for (level, factor) in [(0_u16, 1), (2_000, 1), (2_000, 2)] {
        bench.drive.plant_mut().analogue = level;
        number(&mut bench, 0x3626, 1, factor);
        bench.run(1_000);
        let voltage = bench.read(NODE, 0x3509, 1) as i32;
        assert_eq!(voltage > 500, level > 0, "{voltage} mV");
        let turns = if voltage > 500 {
            voltage * 60 * factor as i32 / 10_000
        } else {
            0
        };
        let moved = way(&mut bench, 1_000);
        assert!(is_near(moved, per_minute(turns)), "{voltage} mV: {moved}");
    }
    number(&mut bench, 0x3508, 1, 10_000);
    bench.run(1_000);
    assert_eq!(way(&mut bench, 500), 0, "a dead band");
}

/// PVMAX, PVMAXP and PVMAXN under position control; VLIM, VLIMP and VLIMN in 1/min in a velocity mode.
#[test]
fn the_s200_keeps_its_limits_of_speed() {
    let mut bench = enabled("s200", 1);
    number(&mut bench, 0x6081, 0, 200_000);
    number(&mut bench, 0x35D8, 1, 20_000);
    number(&mut bench, 0x35D9, 1, 5_000);
    for (target, speed) in [(90_000_i32, 20_000), (0, -5_000)] {
        number(&mut bench, 0x607A, 0, target as u32);
        command(&mut bench, 0x3F);
        bench.run(500);
        let moved = way(&mut bench, 1_000);
        assert!(is_near(moved, speed), "{moved}");
        bench.run(20_000);
        command(&mut bench, 0x0F);
    }
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x358C, 1, 20);
    number(&mut bench, 0x3622, 1, 10);
    for (velocity, turns) in [(90_000_i32, 10), (-90_000, -20), (-1_000, 0)] {
        number(&mut bench, 0x60FF, 0, velocity as u32);
        bench.run(1_000);
        let moved = way(&mut bench, 1_000);
        let expected = if turns == 0 {
            -1_000
        } else {
            per_minute(turns)
        };
        assert!(is_near(moved, expected), "{moved}");
    }
}

/// VOSPD is the fault F08.
#[test]
fn over_speed_is_a_fault() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x3627, 1, 30);
    number(&mut bench, 0x60FF, 0, 20_000);
    bench.run(1_000);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27);
    bench.sent.clear();
    number(&mut bench, 0x60FF, 0, 60_000);
    let message = bench.next(0x84, 1_000).expect("an emergency message");
    assert_eq!(message.payload()[..4], [0x80, 0x84, 0x21, 1]);
}

/// A position mode among what is stored comes up as homing mode.
#[test]
fn a_stored_position_mode_comes_up_as_homing() {
    for (mode, up) in [(1_u8, 6), (0x88, 6), (3, 3)] {
        let mut bench = Bench::node("s200", NODE);
        bench.write(NODE, 0x6060, 0, &[mode]);
        bench.write(NODE, 0x1010, 1, b"save");
        bench.send(&Frame::data_frame(0, &[129, NODE]));
        bench.run(200);
        assert_eq!(bench.read(NODE, 0x6060, 0) as u8, up);
    }
}

/// ACTFAULT: a fault switches off at once, or brakes first; STOPMODE says the same of a drive that is disabled.
#[test]
fn actfault_and_stopmode_say_whether_the_motor_brakes() {
    for (parameter, is_fault) in [(0x3503, true), (0x35FF, false)] {
        for brakes in [0, 1] {
            let mut bench = enabled("s200", 3);
            number(&mut bench, parameter, 1, brakes);
            number(&mut bench, 0x6084, 0, 100_000);
            number(&mut bench, 0x6085, 0, 100_000);
            number(&mut bench, 0x60FF, 0, 50_000);
            bench.run(1_000);
            if is_fault {
                // A task the firmware misses: it brakes, as far as it is asked to.
                bench.drive.plant_mut().fault = Some(0x8053);
            } else {
                command(&mut bench, 0x06);
            }
            bench.run(100);
            assert_eq!(
                bench.drive.plant_mut().is_energised(),
                brakes == 1,
                "{parameter:04X}h"
            );
            bench.run(1_000);
            assert!(!bench.drive.plant_mut().is_energised());
        }
    }
}

//! Homing over the bus: every method on switches with hysteresis and bounce, and what masters look at meanwhile.

use canopen::Duration;
use sim::drive::Setup;
use sim::plant::{Axis, Index, Switch, Track};
use tests::DriveBench;
use tests::drive::{FAULT, INTERNAL_LIMIT, OPERATION_ENABLED, SWITCH_ON_DISABLED, TARGET_REACHED};

/// Statusword bit 12 in homing.
const ATTAINED: u16 = 1 << 12;
/// Statusword bit 13 in homing.
const ERROR: u16 = 1 << 13;

const HYSTERESIS: u32 = 50;

/// The axis for which the reference results are known, the motor at `start`.
fn axis(home: Switch, start: i64) -> Axis {
    let fit = |switch: Switch| {
        switch
            .with_hysteresis(HYSTERESIS)
            .bouncing(Duration::from_ticks(2_000))
    };
    Axis {
        track: Track {
            negative_limit: Some(fit(Switch::up_to(-50_000))),
            positive_limit: Some(fit(Switch::from(50_000))),
            home: Some(fit(home)),
            index: Some(Index::new(400, 3_200)),
            ..Track::default()
        },
        start,
        seed: 402,
        ..Axis::default()
    }
}

fn window() -> Switch {
    Switch::within(11_000..=15_000)
}

/// A drive on this axis, in operation enabled and homing mode.
fn homing(axis: Axis, method: i8) -> DriveBench {
    let mut drive = DriveBench::with(
        Setup {
            axis: Some(axis),
            ..Setup::with_node_id(1, 4)
        },
        4,
    );
    drive.start();
    drive.reaches(SWITCH_ON_DISABLED, 20);
    drive.write_u8(0x6060, 0, 6);
    drive.write_u8(0x6098, 0, method.cast_unsigned());
    drive.write_u32(0x6099, 1, 40_000);
    drive.write_u32(0x6099, 2, 2_000);
    drive.write_u32(0x609A, 0, 1_000_000);
    drive.enable();
    drive.run_millis(5);
    assert_eq!(drive.read_i8(0x6061, 0), 6);
    drive
}

/// Starts and waits for the end: bits 10, 12 and 13.
#[track_caller]
fn run(drive: &mut DriveBench) -> u16 {
    drive.command(0x1F);
    drive.run_millis(4);
    for _ in 0..60_000 {
        let bits = drive.statusword() & (ERROR | ATTAINED | TARGET_REACHED);
        if bits & TARGET_REACHED != 0 {
            return bits;
        }
        drive.run_millis(1);
    }
    panic!("homing goes on for ever, at {}", drive.position());
}

/// Where along the axis the drive's position 0 is.
fn zero(drive: &mut DriveBench) -> i64 {
    let shown = drive.read_i32(0x6064, 0);
    drive.axis().plant().rotor() - i64::from(shown)
}

#[test]
fn d25_every_method_finds_the_same_home_from_every_start() {
    let positive = Switch::from(11_000);
    let negative = Switch::up_to(11_000);
    // Without an index pulse home is where the edge is in the last direction: the hysteresis is in it.
    let results = [
        (1, window(), -47_600),
        (2, window(), 48_400),
        (3, positive.clone(), 10_000),
        (4, positive.clone(), 13_200),
        (5, negative.clone(), 13_200),
        (6, negative.clone(), 10_000),
        (7, window(), 10_000),
        (8, window(), 13_200),
        (9, window(), 13_200),
        (10, window(), 16_400),
        (11, window(), 16_400),
        (12, window(), 13_200),
        (13, window(), 13_200),
        (14, window(), 10_000),
        (17, window(), -49_950),
        (18, window(), 49_950),
        (19, positive.clone(), 10_950),
        (20, positive, 11_050),
        (21, negative.clone(), 11_050),
        (22, negative, 10_950),
        (23, window(), 10_950),
        (24, window(), 11_050),
        (25, window(), 14_950),
        (26, window(), 15_050),
        (27, window(), 15_050),
        (28, window(), 14_950),
        (29, window(), 11_050),
        (30, window(), 10_950),
    ];
    let starts = [
        -20_000, 0, 10_999, 11_000, 13_000, 15_001, 40_000, -50_020, 50_020,
    ];
    for (method, home, result) in results {
        for start in starts {
            let mut drive = homing(axis(home.clone(), start), method);
            let bits = run(&mut drive);
            assert_eq!(bits, ATTAINED | TARGET_REACHED, "{method} from {start}");
            assert_eq!(zero(&mut drive), result, "{method} from {start}");
        }
    }
}

#[test]
fn d25_the_index_pulse_alone_and_home_here() {
    for (method, result) in [(33, -2_800), (34, 400), (35, 0), (37, 0)] {
        let mut drive = homing(axis(window(), 0), method);
        assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
        assert_eq!(zero(&mut drive), result, "method {method}");
    }
}

#[test]
fn d25_a_hard_stop_is_felt_by_an_encoder() {
    for (method, result) in [(-3, 7_000), (-4, -6_000), (-1, 6_800), (-2, -2_800)] {
        let mut drive = homing(
            Axis {
                track: Track {
                    stops: Some(-6_000..=7_000),
                    index: Some(Index::new(400, 3_200)),
                    ..Track::default()
                },
                encoder: true,
                ..Axis::default()
            },
            method,
        );
        drive.write_u32(0x2030, 6, 40);
        drive.write_u32(0x6099, 1, 4_000);
        assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
        assert_eq!(zero(&mut drive), result, "method {method}");
        drive.run_millis(100);
        drive.reaches(OPERATION_ENABLED, 1);
        // The motor has backed off: it can go on from there.
        drive.write_u8(0x6060, 0, 1);
        drive.run_millis(5);
        drive.command(0x0F);
        drive.begin_move(0);
        drive.reaches_target(5_000);
        assert_eq!(drive.axis().plant().rotor(), result);
    }
}

#[test]
fn d23_the_bits_that_masters_wait_for() {
    let mut drive = homing(axis(window(), 0), 24);
    drive.drain(20);
    // Idle: bit 10. In the statusword of the start: none of them. Attained: bits 12 and 10.
    assert_eq!(drive.statusword() & 0x3400, 0x0400);
    drive.command(0x1F);
    drive.expect_within("184 [2] 37 02", 5);
    drive.drain_until("184 [2] 37 16", 20_000);
    // The start bit that is left high, and taken back, changes nothing.
    for controlword in [0x1F, 0x0F] {
        drive.command(controlword);
        for _ in 0..200 {
            drive.run_millis(1);
            assert_eq!(drive.statusword() & 0x3400, 0x1400);
        }
    }
}

#[test]
fn m47_a_statusword_that_is_read_right_behind_the_start_shows_it() {
    for pause in [0, 130, 333, 999] {
        let mut drive = homing(axis(window(), 0), 37);
        for again in [false, true] {
            drive.drain(20);
            drive.run_micros(pause);
            drive.queue("204 [2] 1F 00");
            drive.queue("604: 40 41 60 00 00 00 00 00");
            // The TPDO goes first, so that a master that keeps its last value has it too.
            drive.expect("184 [2] 37 02");
            let first = drive.drain_until("584: 4B 41 60 00 37 xx 00 00", 5);
            assert_eq!(first.bytes()[5] & 0x34, 0, "again: {again}, pause: {pause}");
            drive.run_millis(5);
            drive.command(0x0F);
            drive.run_millis(10);
            assert_eq!(drive.statusword() & 0x3400, 0x1400);
        }
    }
}

#[test]
fn d24_taking_the_start_bit_back_interrupts() {
    let mut drive = homing(axis(window(), 0), 24);
    drive.command(0x1F);
    drive.run_millis(100);
    drive.command(0x0F);
    drive.run_millis(200);
    assert_eq!(drive.statusword() & 0x3400, 0x0400);
    let stopped = drive.position();
    drive.run_millis(200);
    assert_eq!(drive.position(), stopped);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    assert_eq!(zero(&mut drive), 11_050);
}

#[test]
fn d25_an_error_shows_bit_13_and_the_motor_stays_off_the_limit() {
    // The home switch is behind the motor, and method 20 does not turn round.
    let mut drive = homing(axis(Switch::within(-10_000..=-9_000), 0), 20);
    assert_eq!(run(&mut drive), ERROR | TARGET_REACHED);
    // 40,000 steps/s on 1,000,000 steps/s² are 800 steps.
    let rotor = drive.axis().plant().rotor();
    assert!((50_000..51_200).contains(&rotor), "{rotor}");
    assert_eq!(drive.read_u8(0x2034, 2), 2);
    drive.reaches(OPERATION_ENABLED, 1);
    // Turning round at a limit switch is an option.
    drive.command(0x0F);
    drive.write_u16(0x2030, 1, 0b10);
    drive.run_millis(4);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    assert_eq!(drive.read_u8(0x2034, 2), 0);
}

#[test]
fn d26_homing_begins_in_operation_enabled_only() {
    let mut drive = homing(axis(window(), 0), 24);
    drive.command(0x07);
    drive.run_millis(10);
    drive.command(0x17);
    drive.run_millis(500);
    assert_eq!(drive.position(), 0);
    drive.command(0x1F);
    drive.run_millis(500);
    assert_eq!(drive.position(), 0, "the edge is older than the mode");
}

#[test]
fn m52_home_offset_and_target_agree_after_homing() {
    let mut drive = homing(axis(window(), 0), 24);
    drive.write_i32(0x607C, 0, -1_500);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    assert_eq!(zero(&mut drive), 11_050 + 1_500);
    for (index, name) in [(0x6062, "demand"), (0x6063, "internal")] {
        assert_eq!(
            drive.read_i32(index, 0),
            drive.read_i32(0x6064, 0),
            "{name}"
        );
    }
    drive.write_u8(0x6060, 0, 1);
    drive.command(0x0F);
    drive.run_millis(5);
    drive.begin_move(-1_500);
    drive.reaches_target(5_000);
    assert_eq!(drive.axis().plant().rotor(), 11_050);
}

#[test]
fn m50_unsupported_methods_are_refused_and_none_is_an_error() {
    let mut drive = homing(axis(window(), 0), 0);
    for method in [15u8, 16, 31, 32, 36, 38, 0x80] {
        drive.refused(
            &format!("604: 2F 98 60 00 {method:02X} 00 00 00"),
            0x0609_0030,
        );
    }
    assert_eq!(run(&mut drive), ERROR | TARGET_REACHED);
    assert_eq!(drive.position(), 0);
}

#[test]
fn m22_60e3_lists_exactly_the_methods_that_6098_takes() {
    let mut drive = DriveBench::started(4);
    let count = drive.read_u8(0x60E3, 0);
    let listed: Vec<i8> = (1..=count).map(|sub| drive.read_i8(0x60E3, sub)).collect();
    for method in i8::MIN..=i8::MAX {
        let bits = method.cast_unsigned();
        if listed.contains(&method) || method == 0 {
            drive.write_u8(0x6098, 0, bits);
        } else {
            drive.refused(
                &format!("604: 2F 98 60 00 {bits:02X} 00 00 00"),
                0x0609_0030,
            );
        }
    }
    assert_ne!(drive.read_u32(0x6502, 0) & 1 << 5, 0);
}

#[test]
fn d31_a_limit_switch_stops_a_move_and_lets_it_turn_back() {
    let mut drive = homing(axis(window(), 40_000), 37);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    drive.write_u8(0x6060, 0, 1);
    drive.command(0x0F);
    drive.run_millis(5);
    drive.begin_move(100_000);
    drive.run_millis(3_000);
    // 10,000 steps/s on 1,000,000 steps/s² are 50 steps; the switch is debounced for 3 ms.
    let rotor = drive.axis().plant().rotor();
    assert!((50_050..50_250).contains(&rotor), "{rotor}");
    let statusword = drive.statusword();
    assert_eq!(
        statusword & (INTERNAL_LIMIT | TARGET_REACHED),
        INTERNAL_LIMIT
    );
    assert_eq!(drive.read_u32(0x60FD, 0) & 0b111, 0b010);
    drive.begin_move(110_000);
    drive.run_millis(500);
    assert_eq!(drive.axis().plant().rotor(), rotor);
    drive.begin_move(0);
    drive.reaches_target(8_000);
    assert_eq!(drive.axis().plant().rotor(), 40_000);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
}

#[test]
fn m55_a_drive_that_is_switched_on_upon_a_limit_switch_may_drive_away() {
    let mut drive = homing(axis(window(), 60_000), 37);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.write_u8(0x6060, 0, 1);
    drive.command(0x0F);
    drive.run_millis(5);
    drive.begin_move(1_000);
    drive.run_millis(500);
    assert_eq!(drive.axis().plant().rotor(), 60_000, "into the switch");
    assert_eq!(drive.statusword() & TARGET_REACHED, 0);
    drive.begin_move(-30_000);
    drive.reaches_target(8_000);
    assert_eq!(drive.axis().plant().rotor(), 30_000);
    assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
    drive.reaches(OPERATION_ENABLED, 1);
}

#[test]
fn m56_both_limit_switches_are_a_fault_with_an_emergency_message() {
    let mut drive = homing(axis(window(), 0), 37);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    drive.write_u8(0x6060, 0, 1);
    drive.command(0x0F);
    drive.run_millis(5);
    drive.begin_move(20_000);
    drive.run_millis(200);
    drive.drain(1);
    let both = Axis {
        track: Track {
            negative_limit: Some(Switch::up_to(100_000)),
            positive_limit: Some(Switch::from(-100_000)),
            ..Track::default()
        },
        ..Axis::default()
    };
    drive.axis().plant_mut().mount(&both);
    drive.drain_until("084: 12 86 21 ..", 20);
    drive.reaches(FAULT, 200);
    assert_eq!(drive.read_u16(0x603F, 0), 0x8612);
    let rotor = drive.axis().plant().rotor();
    // The cause stands: the fault comes again, and no direction is free.
    drive.command(0x00);
    drive.command(0x80);
    drive.drain_until("084: 12 86 21 ..", 20);
    drive.command(0x0F);
    drive.stays_in(FAULT, 100);
    assert_eq!(drive.axis().plant().rotor(), rotor);
    drive.axis().plant_mut().mount(&axis(window(), 0));
    drive.run_millis(20);
    drive.command(0x80);
    drive.reaches(SWITCH_ON_DISABLED, 10);
    drive.drain_until("084: 00 00 ..", 20);
}

#[test]
fn m53_the_sequence_of_ros2_canopen() {
    let mut drive = homing(axis(window(), 0), 24);
    drive.command(0x07);
    drive.run_millis(10);
    // It holds the axis by halt while it has no target, changes the mode so, and needs bit 10 within a second.
    drive.command(0x10F);
    drive.run_millis(50);
    assert_eq!(drive.statusword() & 0x3400, 0x0400);
    for again in [false, true] {
        // Then bit 4 without halt; bits 10, 12 and 13 must change within a second.
        drive.command(0x1F);
        drive.run_millis(4);
        assert_eq!(
            drive.statusword() & 0x3400,
            0,
            "seen to begin, again: {again}"
        );
        for _ in 0..20_000 {
            if drive.statusword() & ATTAINED != 0 {
                break;
            }
            drive.run_millis(1);
        }
        assert_eq!(drive.statusword() & 0x3400, 0x1400);
        // It drops the bit and goes to no mode, halted.
        drive.command(0x0F);
        drive.write_u8(0x6060, 0, 0);
        drive.command(0x10F);
        drive.run_millis(10);
        assert_eq!(drive.read_i8(0x6061, 0), 0);
        assert_eq!(zero(&mut drive), 11_050);
        // The next time it begins with bit 12 cleared only if that is set so.
        drive.write_u16(0x2030, 1, 1 << 7);
        drive.write_u8(0x6060, 0, 6);
        drive.run_millis(10);
        assert_eq!(drive.statusword() & 0x3400, 0x0400);
    }
}

#[test]
fn m74_what_is_known_of_home_does_not_outlive_the_power() {
    let mut drive = homing(axis(window(), 0), 37);
    assert_eq!(run(&mut drive), ATTAINED | TARGET_REACHED);
    assert_eq!(drive.read_u8(0x2034, 1), 1);
    drive.axis().power_cycle();
    drive.drain(100);
    assert_eq!(drive.read_u8(0x2034, 1), 0);
}

#[test]
fn m54_a_limit_switch_stops_the_velocity_modes_too() {
    for mode in [2, 3] {
        let mut drive = homing(axis(window(), 40_000), 0);
        let set = |drive: &mut DriveBench, velocity: i32| match mode {
            2 => drive.write_u16(0x6042, 0, (velocity as i16).cast_unsigned()),
            _ => drive.write_i32(0x60FF, 0, velocity),
        };
        drive.write_u8(0x6060, 0, mode);
        // Bits 4, 5 and 6 of the controlword let the ramp generator of mode 2 go.
        drive.command(0x7F);
        set(&mut drive, 10_000);
        drive.run_millis(3_000);
        let rotor = drive.axis().plant().rotor();
        assert!((50_050..50_400).contains(&rotor), "mode {mode}: {rotor}");
        assert_ne!(drive.statusword() & INTERNAL_LIMIT, 0);
        // Faster into the switch: no. Away from it: at once.
        set(&mut drive, 12_000);
        drive.run_millis(500);
        assert_eq!(drive.axis().plant().rotor(), rotor, "mode {mode}");
        set(&mut drive, -10_000);
        drive.run_millis(1_000);
        let left = drive.axis().plant().rotor();
        assert!((40_000..42_000).contains(&left), "mode {mode}: {left}");
        assert_eq!(drive.statusword() & INTERNAL_LIMIT, 0);
        drive.reaches(OPERATION_ENABLED, 1);
    }
}

//! What the S200 shows of itself: warnings and the faults they become, words of status, display, latches, units; and its channels.

use sim::plant::{Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, enabled_on, number, on, position, statusword};

/// The text on the display.
fn display(bench: &mut Bench) -> String {
    let bytes = bench.read(NODE, 0x5104, 0).to_le_bytes();
    String::from_utf8_lossy(&bytes).trim_end().to_owned()
}

/// WMASK makes a fault of a warning, F24, and LASTWMASK keeps which.
#[test]
fn wmask_makes_faults_of_warnings() {
    for masked in [false, true] {
        let limit = Track {
            positive_limit: Some(Switch::from(1_000)),
            ..Track::default()
        };
        let mut bench = on("s200", limit);
        number(&mut bench, 0x3565, 1, 2);
        number(&mut bench, 0x363E, 1, if masked { 1 << 9 } else { 0 });
        bench.write(NODE, 0x6060, 0, &[3]);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, 5_000);
        let message = bench.next(0x84, 1_000);
        assert_eq!(message.is_some(), masked);
        if let Some(message) = message {
            assert_eq!(message.payload()[..4], [0x06, 0xFF, 0x81, 2]);
        }
        assert_eq!(bench.read(NODE, 0x2000, 0) >> 9 & 1, 1, "n10");
        assert_eq!(statusword(&mut bench) & 0x08 != 0, masked);
        assert_eq!(bench.read(NODE, 0x36CE, 1), if masked { 1 << 9 } else { 0 });
        assert_eq!(bench.read(NODE, 0x38F7, 1), 10, "WarningCode");
        assert_eq!(
            bench.read(NODE, 0x352D, 1),
            bench.read(NODE, 0x2000, 0),
            "DRVSTAT"
        );
        assert_eq!(display(&mut bench), if masked { "F24" } else { "n10" });
    }
}

/// The display: D without power, E with it, F and a number with a fault.
#[test]
fn the_display_shows_state_and_fault() {
    let mut bench = Bench::node("s200", NODE);
    assert_eq!(display(&mut bench), "D");
    bench.enable(NODE);
    assert_eq!(display(&mut bench), "E");
    for (code, shown) in [(0x4210, "F01"), (0x4310, "F06"), (0x8331, "F15")] {
        bench.drive.plant_mut().fault = Some(code);
        bench.run(100);
        assert_eq!(display(&mut bench), shown);
        bench.drive.plant_mut().fault = None;
        bench.run(10);
        command(&mut bench, 0x80);
        bench.run(10);
        command(&mut bench, 0);
        bench.run(10);
    }
}

/// Bit 5 of STAT tells that the drive has started anew, until CLRHR; TRJSTAT is 1002h, STATUS the statusword.
#[test]
fn status_words_of_the_s200_follow_the_drive() {
    let mut bench = Bench::node("s200", NODE);
    assert_eq!(bench.read(NODE, 0x35FB, 1) & 0x20, 0x20);
    number(&mut bench, 0x3519, 1, 1);
    bench.run(2);
    assert_eq!(bench.read(NODE, 0x35FB, 1) & 0x20, 0);
    bench.enable(NODE);
    for (word, own) in [(0x3613, 0x1002), (0x35FD, 0x6041)] {
        let (shown, told) = (bench.read(NODE, word, 1), bench.read(NODE, own, 0));
        let mask = if own == 0x6041 { 0xFFFF } else { u32::MAX };
        assert_eq!(shown, told & mask, "{word:04X}h");
    }
    assert_eq!(bench.read(NODE, 0x3613, 1) >> 14 & 1, 1, "power");
}

/// EXTWD: a master that is silent for longer stops the motor, n04.
#[test]
fn a_silent_master_stops_the_s200() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x353A, 1, 300);
    number(&mut bench, 0x60FF, 0, 20_000);
    for _ in 0..5 {
        bench.run(200);
        number(&mut bench, 0x60FF, 0, 20_000);
    }
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27);
    bench.sent.clear();
    let message = bench.next(0x84, 1_000).expect("an emergency message");
    assert_eq!(message.payload()[..4], [0x30, 0x81, 0x81, 2]);
    bench.run(500);
    let stood = position(&mut bench);
    bench.run(200);
    assert_eq!(position(&mut bench), stood);
}

/// Both latches keep where the motor was at an edge, in 32 and 16 bits, and 1002h tells of each.
#[test]
fn the_latches_of_the_s200_keep_positions() {
    let wires = Track {
        negative_limit: Some(Switch::from(70_000)),
        positive_limit: Some(Switch::from(80_000)),
        ..Track::default()
    };
    let mut bench = enabled_on("s200", 1, wires);
    number(&mut bench, 0x3562, 1, 26);
    number(&mut bench, 0x3565, 1, 26);
    bench.run(20);
    let events = |bench: &mut Bench| {
        let word = bench.read(NODE, 0x1002, 0);
        [20, 21, 4, 18].map(|bit| word >> bit & 1)
    };
    assert_eq!(events(&mut bench), [0; 4]);
    begin(&mut bench, 90_000, 100_000, 1_000_000);
    bench.run(2_000);
    assert_eq!(events(&mut bench), [1, 0, 1, 0]);
    begin(&mut bench, 60_000, 100_000, 1_000_000);
    bench.run(2_000);
    assert_eq!(events(&mut bench), [1; 4]);
    for (long, short, edge) in [
        (0x357C, 0x367F, 70_000_i32),
        (0x357D, 0x3680, 70_000),
        (0x357A, 0x3578, 80_000),
        (0x357B, 0x3579, 80_000),
    ] {
        let latched = bench.read(NODE, long, 1) as i32;
        assert!(latched.abs_diff(edge) <= 200, "{long:04X}h: {latched}");
        assert_eq!(bench.read(NODE, short, 1) as i32, i32::from(latched as i16));
    }
}

/// PUNIT, VUNIT and ACCUNIT name the units in 6089h to 608Eh.
#[test]
fn punit_vunit_and_accunit_name_the_units() {
    let mut bench = Bench::node("s200", NODE);
    let names = |bench: &mut Bench, index: u16| {
        let notation = bench.read(NODE, index, 0) as i8;
        (notation, bench.read(NODE, index + 1, 0) as u8)
    };
    for (parameter, value, index, named) in [
        (0x3660, 0, 0x6089, (0, 0)),
        (0x3660, 6, 0x6089, (-6, 1)),
        (0x365F, 1, 0x608B, (0, 0xA4)),
        (0x365F, 8, 0x608B, (-3, 0xA7)),
        (0x3659, 1, 0x608D, (0, 0xAE)),
        (0x3659, 4, 0x608D, (-3, 0x55)),
    ] {
        number(&mut bench, parameter, 1, value);
        assert_eq!(
            names(&mut bench, index),
            named,
            "{parameter:04X}h = {value}"
        );
    }
}

/// VUNIT and ACCUNIT are what velocities and accelerations count in; 6094h and 6097h are their factors, V is in 1/min all the same.
#[test]
fn vunit_and_accunit_scale_velocities_and_accelerations() {
    // A turn is 20,000 units of a micrometre. 30 turns a minute, half a turn a second.
    for (vunit, accunit, velocity, acceleration) in [
        (0, 3, 10_000, 20_000),
        (1, 3, 30, 20_000),
        (7, 4, 10, 20),
        (8, 4, 600, 20),
        (1, 1, 30, 6),
        (0, 1, 10_000, 6),
    ] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x35CA, 1, 20_000);
        number(&mut bench, 0x3660, 1, 6);
        number(&mut bench, 0x365F, 1, vunit);
        number(&mut bench, 0x3659, 1, accunit);
        bench.write(NODE, 0x6060, 0, &[3]);
        number(&mut bench, 0x6083, 0, acceleration);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, velocity);
        let name = format!("VUNIT {vunit}, ACCUNIT {accunit}");
        // The speed is there after half a second, an eighth of a turn.
        bench.run(500);
        let gone = position(&mut bench);
        assert!(gone.abs_diff(2_500) <= 150, "{name}: {gone}");
        bench.run(500);
        let from = position(&mut bench);
        bench.run(1_000);
        let way = position(&mut bench) - from;
        assert!(way.abs_diff(10_000) <= 50, "{name}: {way}");
        let shown = bench.read(NODE, 0x606C, 0);
        assert!(
            shown.abs_diff(velocity) <= velocity / 100 + 1,
            "{name}: {shown}"
        );
        assert!(bench.read(NODE, 0x3618, 1).abs_diff(30) <= 1, "{name}: V");
        let refused = bench.sdo(NODE, [0x23, 0x5F, 0x36, 1, 0, 0, 0, 0]);
        assert_eq!(refused[4..], [0x22, 0, 0, 8], "not with power");
    }
}

/// PGEARI units in PGEARO turns; 6063h has 2^PRBASE increments a turn, PRD twenty bits of one.
#[test]
fn pgeari_pgearo_and_prbase_are_the_resolution() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x35CA, 1, 1_000);
    number(&mut bench, 0x35CB, 1, 2);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    // 500 units are a turn; three quarters of one.
    begin(&mut bench, 375, 1_000, 10_000);
    bench.run(2_000);
    assert_eq!(position(&mut bench), 375);
    assert_eq!(bench.drive.plant_mut().position(), 49_152);
    assert_eq!(bench.read(NODE, 0x6063, 0), 3 << 18, "PRBASE is 20");
    assert_eq!(bench.read(NODE, 0x35D2, 1), 3 << 18, "PRD");
    number(&mut bench, 0x35D1, 1, 12);
    bench.run(2);
    assert_eq!(bench.read(NODE, 0x6063, 0), 3 << 10);
}

/// O1MODE and O2MODE with O1TRIG and O2TRIG: slower, faster, beyond a position.
#[test]
fn outputs_of_the_s200_compare_with_their_auxiliary_values() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x35AF, 1, 2);
    number(&mut bench, 0x35B0, 1, 20);
    number(&mut bench, 0x35B2, 1, 6);
    number(&mut bench, 0x35B3, 1, 40_000);
    let outputs = |bench: &mut Bench| {
        bench.run(20);
        bench.drive.plant_mut().outputs() & 0b11
    };
    assert_eq!(outputs(&mut bench), 0);
    number(&mut bench, 0x60FF, 0, 30_000);
    bench.run(600);
    assert_eq!(outputs(&mut bench), 0b01, "faster than 20 turns a minute");
    bench.run(1_500);
    assert_eq!(outputs(&mut bench), 0b11, "beyond 40,000");
    number(&mut bench, 0x60FF, 0, 0);
    bench.run(1_000);
    assert_eq!(outputs(&mut bench), 0b10);
    number(&mut bench, 0x35AF, 1, 1);
    assert_eq!(outputs(&mut bench), 0b11, "slower");
}

/// Category 1 is reset by bit 7, category 2 by bit 11, category 4 (F32) by neither: only power ends it.
#[test]
fn each_category_of_the_s200_is_cleared_in_its_way() {
    for (code, by_bit_11, by_bit_7) in [
        (0x4310_u16, false, true),
        (0xFF06, true, true),
        (0x6100, false, false),
    ] {
        for (bit, clears) in [(0x800_u16, by_bit_11), (0x80, by_bit_7)] {
            let mut bench = Bench::node("s200", NODE);
            bench.drive.plant_mut().fault = Some(code);
            bench.run(20);
            bench.drive.plant_mut().fault = None;
            bench.run(20);
            assert_eq!(statusword(&mut bench) & 0x08, 0x08, "{code:04X}h");
            command(&mut bench, bit);
            bench.run(50);
            assert_eq!(
                statusword(&mut bench) & 0x08 == 0,
                clears,
                "{code:04X}h, {bit:04X}h"
            );
            bench.drive.power_cycle();
            bench.run(200);
            assert_eq!(statusword(&mut bench) & 0x08, 0, "{code:04X}h");
        }
    }
}

/// Homing that ends at a limit switch, as it has found no reference switch, is F26.
#[test]
fn homing_onto_a_limit_switch_is_f26() {
    let limits = Track {
        negative_limit: Some(Switch::up_to(-5_000)),
        positive_limit: Some(Switch::from(5_000)),
        ..Track::default()
    };
    let mut bench = on("s200", limits);
    number(&mut bench, 0x3562, 1, 3);
    number(&mut bench, 0x3565, 1, 2);
    number(&mut bench, 0x3568, 1, 12);
    bench.write(NODE, 0x6098, 0, &[24]);
    number(&mut bench, 0x6099, 1, 20_000);
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.enable(NODE);
    bench.run(20);
    bench.sent.clear();
    bench.send(&canopen::Frame::full(
        0x604,
        [0x2B, 0x40, 0x60, 0, 0x1F, 0, 0, 0],
    ));
    let message = bench.next(0x84, 10_000).expect("an emergency message");
    assert_eq!(message.payload()[..4], [0x07, 0xFF, 0x81, 2]);
    assert_eq!(display(&mut bench), "F26");
}

/// POSCNFG, SRND and ERND: positions of a modulo axis go on at its start.
#[test]
fn a_modulo_axis_of_the_s200_wraps() {
    for (configuration, expected) in [(0, 15_000), (1, 5_000)] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x3637, 1, 0);
        number(&mut bench, 0x3638, 1, 10_000);
        number(&mut bench, 0x35CF, 1, configuration);
        bench.write(NODE, 0x6060, 0, &[3]);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, 10_000);
        while bench.drive.plant_mut().position() < 15_000 {
            bench.run(1);
        }
        let shown = position(&mut bench);
        assert!(
            shown.abs_diff(expected) <= 30,
            "POSCNFG {configuration}: {shown}"
        );
    }
}

/// DECDIS is the ramp of a drive that is disabled, with STOPMODE 1.
#[test]
fn decdis_is_the_ramp_of_a_drive_that_is_disabled() {
    for (ramp, way) in [(50_000_u32, 25_000_i32), (100_000, 12_500)] {
        let mut bench = enabled("s200", 3);
        number(&mut bench, 0x35FF, 1, 1);
        number(&mut bench, 0x3523, 1, ramp);
        number(&mut bench, 0x60FF, 0, 50_000);
        bench.run(1_000);
        let from = position(&mut bench);
        command(&mut bench, 0x06);
        bench.run(2_000);
        let stands = position(&mut bench) - from;
        assert!(stands.abs_diff(way) <= 300, "{ramp}: {stands}");
    }
}

/// Versions, models and stages agree with what the standard's objects tell.
#[test]
fn the_s200_tells_its_versions_and_its_stage() {
    let mut bench = Bench::node("s200", NODE);
    let text = |bench: &mut Bench, index| {
        String::from_utf8(bench.drive.object(index, 0).unwrap_or_default())
    };
    let device = text(&mut bench, 0x1008).unwrap();
    for index in [0x38EC, 0x3B4B, 0x352E] {
        assert_eq!(format!("S{}", bench.read(NODE, index, 1)), device);
    }
    let version = text(&mut bench, 0x100A).unwrap();
    for index in [0x38E8, 0x3B63] {
        let number = bench.read(NODE, index, 1);
        assert_eq!(format!("{}.{:02}", number / 100, number % 100), version);
    }
    assert_eq!(
        bench.read(NODE, 0x3682, 1) * 1_000,
        bench.read(NODE, 0x3527, 1)
    );
    assert_eq!(
        [0x38E9, 0x38ED].map(|index| bench.read(NODE, index, 1)),
        [1, 1]
    );
}

/// 1002h tells of an emergency stop and of homing that has found its reference.
#[test]
fn the_status_register_tells_of_stops_and_homing() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x6085, 0, 50_000);
    let bit = |bench: &mut Bench, bit: u32| bench.read(NODE, 0x1002, 0) >> bit & 1;
    number(&mut bench, 0x60FF, 0, 50_000);
    bench.run(500);
    assert_eq!((bit(&mut bench, 19), bit(&mut bench, 23)), (0, 0));
    command(&mut bench, 0x0B);
    bench.run(20);
    assert_eq!(bit(&mut bench, 19), 1, "emergency stop");
    bench.run(1_000);
    let mut bench = enabled("s200", 6);
    bench.write(NODE, 0x6098, 0, &[35]);
    assert_eq!(bit(&mut bench, 23), 0);
    command(&mut bench, 0x1F);
    bench.run(50);
    assert_eq!(bit(&mut bench, 23), 1, "homing has finished");
}

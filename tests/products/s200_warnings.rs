//! Warnings of the S200 and how they end, its faults told apart, and those that only a cold start ends.

use sim::plant::{Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, command, enabled_on, number, on, position, statusword};

/// CLRWARN 1 keeps a warning until CLRFAULT; with 0 it goes with its cause.
#[test]
fn clrwarn_keeps_warnings_until_they_are_cleared() {
    for mode in [0, 1] {
        let limit = Track {
            positive_limit: Some(Switch::from(1_000)),
            ..Track::default()
        };
        let mut bench = enabled_on("s200", 3, limit);
        number(&mut bench, 0x3565, 1, 2);
        number(&mut bench, 0x351B, 1, mode);
        let warned = |bench: &mut Bench, velocity: i32| {
            number(bench, 0x60FF, 0, velocity as u32);
            bench.run(1_000);
            bench.read(NODE, 0x2000, 0) >> 9 & 1
        };
        assert_eq!(warned(&mut bench, 5_000), 1);
        assert_eq!(warned(&mut bench, -5_000), mode);
        number(&mut bench, 0x3518, 1, 1);
        bench.run(5);
        assert_eq!(warned(&mut bench, 0), 0);
    }
}

/// Bit 24 of 1002h: the reset of this error starts the drive anew, and it does.
#[test]
fn some_errors_end_with_a_cold_start() {
    for (code, is_cold) in [(0x5530, true), (0x5380, true), (0x4310, false)] {
        let mut bench = Bench::node("s200", NODE);
        bench.drive.plant_mut().fault = Some(code);
        bench.run(20);
        bench.drive.plant_mut().fault = None;
        bench.run(20);
        let told = bench.read(NODE, 0x1002, 0) >> 24 & 1;
        assert_eq!(told, u32::from(is_cold), "{code:04X}h");
        bench.sent.clear();
        command(&mut bench, 0x80);
        let boots = bench.next(0x704, 500).is_some();
        assert_eq!(boots, is_cold, "{code:04X}h");
        bench.run(200);
        assert_eq!(statusword(&mut bench) & 0x08, 0, "{code:04X}h");
    }
}

/// buErrcode has a fault of the power stage, ocErrcode any other one; both are 0 without.
#[test]
fn faults_of_the_base_unit_and_of_the_card_are_told_apart() {
    for (code, expected) in [(0x4310, [0x4310, 0]), (0x8480, [0, 0x8480])] {
        let mut bench = Bench::node("s200", NODE);
        let codes = |bench: &mut Bench| [0x38F5, 0x38F6].map(|index| bench.read(NODE, index, 1));
        assert_eq!(codes(&mut bench), [0, 0]);
        bench.drive.plant_mut().fault = Some(code);
        bench.run(20);
        assert_eq!(codes(&mut bench), expected);
        bench.drive.plant_mut().fault = None;
        bench.run(20);
        command(&mut bench, 0x80);
        bench.run(20);
        assert_eq!(codes(&mut bench), [0, 0]);
    }
}

/// FltDiag: an output flashes the number of the fault.
#[test]
fn fltdiag_flashes_the_number_of_the_fault() {
    for (code, number_of_fault) in [(0x3210, 2), (0x7303, 4)] {
        let mut bench = Bench::node("s200", NODE);
        number(&mut bench, 0x3B52, 1, 2);
        let flashes = |bench: &mut Bench, milliseconds: u32| {
            let (mut count, mut before) = (0, false);
            for _ in 0..milliseconds / 10 {
                bench.run(10);
                let is_on = bench.drive.plant_mut().outputs() & 0b10 != 0;
                count += u32::from(is_on && !before);
                before = is_on;
            }
            count
        };
        assert_eq!(flashes(&mut bench, 1_000), 0);
        bench.drive.plant_mut().fault = Some(code);
        // On and off for 200 ms each, then two seconds of darkness: two rounds.
        let round = number_of_fault * 400 + 2_000;
        assert_eq!(flashes(&mut bench, 2 * round - 500), 2 * number_of_fault);
    }
}

/// n06, n07, n10 and n11 stop the motor, and bit 7 of the statusword tells of them; so do n03 and n04.
#[test]
fn warnings_of_the_s200_stop_the_motor() {
    for (bit, velocity) in [(5, -20_000), (6, 20_000), (9, 20_000), (10, -20_000)] {
        let wires = Track {
            negative_limit: Some(Switch::up_to(-30_000)),
            positive_limit: Some(Switch::from(30_000)),
            ..Track::default()
        };
        let mut bench = on("s200", wires);
        let is_software = bit < 9;
        if is_software {
            number(&mut bench, 0x3604, 1, -10_000_i32 as u32);
            number(&mut bench, 0x3606, 1, 10_000);
        } else {
            number(&mut bench, 0x3562, 1, 3);
            number(&mut bench, 0x3565, 1, 2);
        }
        bench.write(NODE, 0x6060, 0, &[3]);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, velocity as u32);
        bench.run(300);
        assert_eq!(bench.read(NODE, 0x2000, 0), 0, "bit {bit}");
        assert_ne!(position(&mut bench), 0);
        bench.run(3_000);
        assert_eq!(bench.read(NODE, 0x2000, 0), 1 << bit);
        assert_eq!(statusword(&mut bench) & 0x80, 0x80, "warning");
        let stood = position(&mut bench);
        let end = if is_software { 10_000 } else { 30_000 };
        assert!(stood.unsigned_abs().abs_diff(end) <= 500, "{bit}: {stood}");
        bench.run(300);
        assert_eq!(position(&mut bench), stood);
    }
    errors_that_are_warnings_stop_the_motor();
}

/// n03, a following error, and n04, a master that guards no longer, stop the motor with the emergency ramp.
fn errors_that_are_warnings_stop_the_motor() {
    for bit in [2, 3] {
        let mut bench = Bench::node("s200", NODE);
        bench.drive.plant_mut().encoder = true;
        bench.write(NODE, 0x6060, 0, &[3]);
        number(&mut bench, 0x6065, 0, 5_000);
        number(&mut bench, 0x6085, 0, 100_000);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, 50_000);
        bench.run(1_000);
        assert_eq!(bench.read(NODE, 0x2000, 0), 0);
        if bit == 2 {
            bench.drive.plant_mut().displace(-20_000);
        } else {
            bench.write(NODE, 0x100C, 0, &[50, 0]);
            bench.write(NODE, 0x100D, 0, &[2]);
            bench.send(&canopen::Frame::remote_frame(0x704, 0));
            bench.run(110);
        }
        // Half a second from 50,000 counts/s, 12,500 counts.
        let from = bench.drive.plant_mut().position();
        bench.run(1_000);
        let way = bench.drive.plant_mut().position() - from;
        assert!(way.abs_diff(12_500) < 1_500, "bit {bit}: {way}");
        assert_eq!(bench.read(NODE, 0x2000, 0) >> bit & 1, 1, "bit {bit}");
        let stood = position(&mut bench);
        bench.run(300);
        assert_eq!(position(&mut bench), stood);
    }
}

/// A PDO carries the word of warnings, and tells of several at once.
#[test]
fn the_warnings_of_the_s200_travel_in_a_pdo() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x1800, 1, 0xC000_0184);
    bench.write(NODE, 0x1A00, 0, &[0]);
    number(&mut bench, 0x1A00, 1, 0x2000_0020);
    bench.write(NODE, 0x1A00, 0, &[1]);
    number(&mut bench, 0x1800, 1, 0x4000_0184);
    number(&mut bench, 0x35CD, 1, 1);
    number(&mut bench, 0x3604, 1, 500);
    number(&mut bench, 0x3606, 1, 600);
    bench.send(&canopen::Frame::data_frame(0, &[1, NODE]));
    bench.sent.clear();
    bench.drive.plant_mut().warning = Some(0x3130);
    let frame = bench.next(0x184, 100).expect("a PDO");
    assert_eq!(frame.payload(), [0x30, 0, 0, 0], "n05 and n06");
    bench.drive.plant_mut().warning = None;
    let frame = bench.next(0x184, 100).expect("a PDO");
    assert_eq!(frame.payload(), [0x20, 0, 0, 0], "n06");
}

//! How the LMD tells of errors, and what it makes of them: plausibility, classes, limits, supplies.

use sim::plant::{Switch, Track};

use crate::bench::Bench;
use crate::steer::{
    NODE, begin, command, enabled, enabled_on, number, on, position, statusword, way,
};

/// The first emergency message with this code: what it says in byte 6.
fn told(bench: &mut Bench, code: u16, within: u32) -> Option<u8> {
    while let Some(frame) = bench.next(0x84, within) {
        let bytes = *frame.full_payload().unwrap();
        if u16::from_le_bytes([bytes[0], bytes[1]]) == code {
            return Some(bytes[6]);
        }
    }
    None
}

/// A drive with an encoder whose motor goes no further than this.
fn ending_at(stop: i64) -> Bench {
    let track = Track {
        stops: Some(-100_000..=stop),
        ..Track::default()
    };
    let mut bench = enabled_on("lmd", 1, track);
    bench.drive.plant_mut().encoder = true;
    bench.run(200);
    bench.sent.clear();
    bench
}

/// FF01h: idle in a move, moving while it should be idle, short of its target; and nothing while it does what it should.
#[test]
fn the_lmd_tells_of_a_motor_that_does_not_what_it_should() {
    let mut bench = ending_at(10_000);
    begin(&mut bench, 50_000, 20_000, 1_000_000);
    assert_eq!(told(&mut bench, 0xFF01, 3_000), Some(0x01));
    let mut bench = ending_at(100_000);
    bench.run(500);
    bench.drive.plant_mut().displace(2_000);
    assert_eq!(told(&mut bench, 0xFF01, 500), Some(0x02));
    let mut bench = ending_at(100_000);
    begin(&mut bench, 30_000, 20_000, 1_000_000);
    bench.run(1_000);
    assert_eq!(told(&mut bench, 0xFF01, 1), None);
    bench.drive.plant_mut().displace(-1_500);
    assert_eq!(told(&mut bench, 0xFF01, 2_000), Some(0x09));
    let mut bench = ending_at(100_000);
    for target in [30_000, 0] {
        begin(&mut bench, target, 20_000, 1_000_000);
        bench.run(3_000);
    }
    assert_eq!(told(&mut bench, 0xFF01, 100), None);
}

/// A warning changes nothing; an idle motor is stopped with its power; temperature is a fault with a ramp, the inhibit input one without; what the
/// hardware finds is over with the power.
#[test]
fn errors_of_the_lmd_have_five_classes() {
    let running = |bench: &mut Bench| {
        number(bench, 0x6085, 0, 20_000);
        bench.write(NODE, 0x60FF, 0, &20_000_i32.to_le_bytes());
        bench.run(1_500);
        assert_ne!(way(bench, 50), 0);
    };
    // 0: the board is warm.
    let mut bench = enabled("lmd", 3);
    running(&mut bench);
    bench.drive.plant_mut().temperature = 820;
    bench.run(500);
    assert_eq!(statusword(&mut bench) & 0xEF, 0xA7);
    assert_ne!(way(&mut bench, 50), 0);
    // 1: the motor is idle. Operation goes on when it is enabled anew.
    let mut bench = ending_at(10_000);
    begin(&mut bench, 50_000, 20_000, 1_000_000);
    bench.run(2_000);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x07, "quick stop active");
    assert!(bench.drive.plant_mut().is_energised());
    command(&mut bench, 0x0F);
    bench.run(50);
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27);
    assert_eq!(bench.read(NODE, 0x605A, 0) as u16, 2);
    // 2: a ramp of a second, then no power; a reset ends it.
    let mut bench = enabled("lmd", 3);
    running(&mut bench);
    bench.drive.plant_mut().temperature = 900;
    bench.run(300);
    assert!(bench.drive.plant_mut().is_energised());
    assert_ne!(way(&mut bench, 50), 0);
    bench.run(1_500);
    assert!(!bench.drive.plant_mut().is_energised());
    bench.drive.plant_mut().temperature = 250;
    bench.run(100);
    command(&mut bench, 0x80);
    bench.run(50);
    assert_eq!(statusword(&mut bench) & 0x4F, 0x40);
    // 3: no power at once; a reset ends it.
    let mut bench = enabled("lmd", 3);
    running(&mut bench);
    bench.drive.plant_mut().fault = Some(0x2310);
    bench.run(10);
    assert!(!bench.drive.plant_mut().is_energised());
    assert_eq!(statusword(&mut bench) & 0x4F, 0x08);
    bench.drive.plant_mut().fault = None;
    bench.run(50);
    command(&mut bench, 0x80);
    bench.run(50);
    assert_eq!(statusword(&mut bench) & 0x4F, 0x40);
    // 4: no reset ends it, neither of the fault nor of the node.
    let mut bench = enabled("lmd", 3);
    running(&mut bench);
    bench.drive.plant_mut().fault = Some(0x5200);
    bench.run(10);
    assert!(!bench.drive.plant_mut().is_energised());
    bench.drive.plant_mut().fault = None;
    for reset in [false, true] {
        if reset {
            bench.send(&canopen::Frame::data_frame(0, &[0x81, NODE]));
        }
        bench.run(200);
        command(&mut bench, 0x80);
        bench.run(50);
        assert_eq!(statusword(&mut bench) & 0x4F, 0x08);
        command(&mut bench, 0);
    }
    bench.drive.power_cycle();
    bench.run(200);
    assert_eq!(statusword(&mut bench) & 0x4F, 0x40);
}

/// 2020h:1 shows all four limits and bit 11 one of them, and the drive acts on those in 2020h:2 alone.
#[test]
fn the_lmd_acts_on_the_limits_in_its_mask() {
    for (mask, rests) in [
        (0x0F_u8, [2_000, -3_000]),
        (0x03, [6_000, -3_000]),
        (0, [12_000, -12_000]),
    ] {
        for (target, rest, flags) in [
            (12_000, rests[0], [0x08, 0x0A]),
            (-12_000, rests[1], [0x01, 0x05]),
        ] {
            let track = Track {
                positive_limit: Some(Switch::from(6_000)),
                negative_limit: Some(Switch::up_to(-3_000)),
                ..Track::default()
            };
            let mut bench = on("lmd", track);
            bench.write(NODE, 0x2002, 2, &[0b10]);
            bench.write(NODE, 0x2002, 3, &[0b01]);
            bench.write(NODE, 0x2022, 1, &(-8_000_i32).to_le_bytes());
            bench.write(NODE, 0x2022, 2, &2_000_i32.to_le_bytes());
            bench.write(NODE, 0x2020, 2, &[mask]);
            number(&mut bench, 0x6085, 0, 10_000_000);
            bench.write(NODE, 0x6060, 0, &[1]);
            bench.enable(NODE);
            assert_eq!(bench.read(NODE, 0x2020, 1) as u8, 0);
            assert_eq!(statusword(&mut bench) >> 11 & 1, 0);
            bench.write(NODE, 0x6082, 0, &[0; 4]);
            begin(&mut bench, target, 20_000, 1_000_000);
            bench.run(3_000);
            let stands = position(&mut bench);
            assert!(stands.abs_diff(rest) <= 60, "{mask}: {stands}, {rest}");
            let reached = bench.read(NODE, 0x2020, 1) as u8;
            let is_far = stands.abs() > 8_000 || stands > 5_900;
            assert_eq!(reached, flags[usize::from(is_far)], "{mask}: {stands}");
            assert_eq!(statusword(&mut bench) >> 11 & 1, 1);
            let switches = bench.read(NODE, 0x60FD, 0) as u8 & 0b11;
            assert_eq!(switches, reached & 0b11);
        }
    }
}

/// 2014h, in tenths of a volt, and 2016h, in millivolts: a voltage outside of its range is a warning, and the drive goes on.
#[test]
fn the_lmd_warns_of_its_other_supplies() {
    let warns = |bench: &mut Bench| {
        bench.run(50);
        statusword(bench) >> 7 & 1 == 1
    };
    let mut bench = enabled("lmd", 3);
    assert_eq!(bench.read(NODE, 0x2014, 1) as u16, 240);
    assert_eq!(bench.read(NODE, 0x2016, 1) as u16, 3_600);
    assert_eq!(bench.read(NODE, 0x2017, 0) as u16, 3_600);
    assert!(!warns(&mut bench));
    for (low, high, voltage, expected) in [
        (180_u16, 260_u16, 17_900_u32, true),
        (180, 260, 18_000, false),
        (180, 260, 26_100, true),
        (0, 280, 100, false),
        (0, 280, 28_200, true),
    ] {
        bench.write(NODE, 0x2014, 2, &low.to_le_bytes());
        bench.write(NODE, 0x2014, 3, &high.to_le_bytes());
        bench.drive.plant_mut().auxiliary_voltage = voltage;
        assert_eq!(warns(&mut bench), expected, "{voltage}");
    }
    bench.drive.plant_mut().auxiliary_voltage = 24_000;
    for (low, high, voltage, expected) in [
        (3_000_u16, 4_000_u16, 2_999_u32, true),
        (3_000, 4_000, 3_000, false),
        (3_000, 4_000, 4_001, true),
        (0, 4_000, 0, false),
        (0, 0, 6_000, false),
    ] {
        bench.write(NODE, 0x2016, 2, &low.to_le_bytes());
        bench.write(NODE, 0x2016, 3, &high.to_le_bytes());
        bench.drive.plant_mut().battery_voltage = voltage;
        assert_eq!(warns(&mut bench), expected, "{voltage}");
        assert_eq!(bench.read(NODE, 0x2017, 0), voltage);
    }
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27);
}

//! Electronic gearing of the S200, mode 84h: the motor follows the external encoder.

use crate::bench::Bench;
use crate::steer::{NODE, command, number, position, statusword, way};

const TURN: i32 = 65_536;

/// Turns the external encoder with so many counts/s.
fn turn(bench: &mut Bench, speed: i64) {
    let plant = bench.drive.plant_mut();
    let now = plant.now();
    plant.second.turn(speed, now);
}

/// A drive in gearing mode that is not enabled: 1,000 counts are a turn, ramps of a turn/s².
fn geared() -> Bench {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x2040, 1, 1_000);
    number(&mut bench, 0x609A, 0, TURN as u32);
    bench.write(NODE, 0x6060, 0, &[0x84]);
    bench
}

fn is_synchronised(bench: &mut Bench) -> bool {
    statusword(bench) >> 10 & 1 == 1
}

/// How far the motor goes in a second, in thousandths of a turn.
fn speed(bench: &mut Bench) -> i32 {
    way(bench, 1_000) * 125 / (TURN / 8)
}

/// The motor follows the encoder exactly, forwards and backwards, and 6061h shows the mode.
#[test]
fn the_s200_follows_its_external_encoder() {
    let mut bench = geared();
    bench.enable(NODE);
    bench.run(50);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 0x84);
    assert_eq!(bench.read(NODE, 0x35B4, 1), 4, "OPMODE");
    assert!(is_synchronised(&mut bench));
    let from = position(&mut bench);
    for (counts, milliseconds) in [(500, 4_000), (-700, 2_000), (13, 1_000)] {
        turn(&mut bench, counts);
        bench.run(milliseconds);
    }
    turn(&mut bench, 0);
    bench.run(2_000);
    let gone = i64::from(position(&mut bench) - from);
    let counts = i64::from(bench.read(NODE, 0x35C9, 1) as i32);
    assert!(counts.abs_diff(613) <= 3, "{counts}");
    assert!(
        gone.abs_diff(counts * i64::from(TURN) / 1_000) <= 2,
        "{gone}"
    );
}

/// GEARI and GEARO are 2040h:1 and :2, which an RPDO may write while the motor follows.
#[test]
fn the_ratio_of_the_s200_is_both_parts_of_2040h() {
    let mut bench = geared();
    number(&mut bench, 0x3540, 1, 3);
    number(&mut bench, 0x353E, 1, 2_000);
    assert_eq!(bench.read(NODE, 0x2040, 1), 2_000);
    assert_eq!(bench.read(NODE, 0x2040, 2), 3);
    turn(&mut bench, 200);
    bench.enable(NODE);
    bench.run(2_000);
    assert!(speed(&mut bench).abs_diff(300) <= 2);
    number(&mut bench, 0x1400, 1, 0x8000_0204);
    bench.write(NODE, 0x1600, 0, &[0]);
    number(&mut bench, 0x1600, 1, 0x2040_0120);
    number(&mut bench, 0x1600, 2, 0x2040_0220);
    bench.write(NODE, 0x1600, 0, &[2]);
    number(&mut bench, 0x1400, 1, 0x204);
    bench.send(&canopen::Frame::data_frame(0, &[1, NODE]));
    bench.send(&canopen::Frame::full(0x204, [0xE8, 3, 0, 0, 1, 0, 0, 0]));
    bench.run(2_000);
    assert_eq!(bench.read(NODE, 0x353E, 1), 1_000);
    assert!(speed(&mut bench).abs_diff(200) <= 2);
}

/// EXTPOS chooses the external encoder or nothing, GEARMODE what it is, EXTMUL multiplies its counts; PFB0 shows them.
#[test]
fn extpos_gearmode_and_extmul_choose_the_master_of_the_s200() {
    let mut bench = geared();
    let refused = bench.sdo(NODE, [0x23, 0x3F, 0x35, 1, 2, 0, 0, 0]);
    assert_eq!(refused[4..], [0x30, 0, 9, 6], "GEARMODE 2 is none");
    number(&mut bench, 0x353F, 1, 3);
    number(&mut bench, 0x3539, 1, 0);
    turn(&mut bench, 100);
    bench.enable(NODE);
    assert_eq!(speed(&mut bench), 0, "no external position");
    number(&mut bench, 0x3539, 1, 1);
    bench.run(1_000);
    assert!(speed(&mut bench).abs_diff(100) <= 2);
    number(&mut bench, 0x3538, 1, 4);
    bench.run(1_000);
    assert!(speed(&mut bench).abs_diff(400) <= 4);
    let before = bench.read(NODE, 0x35C9, 1);
    bench.run(1_000);
    let passed = bench.read(NODE, 0x35C9, 1) - before;
    assert!(passed.abs_diff(400) <= 8, "{passed}");
}

/// ACCR couples, DECR decouples; bit 10 tells that the motor is synchronised, bit 13 of the controlword ends it, as IN20 does.
#[test]
fn the_s200_couples_and_decouples_on_its_ramps() {
    let mut bench = geared();
    number(&mut bench, 0x3723, 1, 42);
    number(&mut bench, 0x3524, 1, TURN as u32 / 2);
    turn(&mut bench, 1_000);
    bench.run(100);
    bench.enable(NODE);
    let from = position(&mut bench);
    assert!(!is_synchronised(&mut bench));
    let mut passed = 0;
    while !is_synchronised(&mut bench) {
        bench.run(10);
        passed += 10;
        assert!(passed < 2_000);
    }
    // A turn/s with a turn/s²: half a turn in a second.
    assert!((900..1_100).contains(&passed), "{passed}");
    let gone = position(&mut bench) - from;
    assert!(gone.abs_diff(TURN / 2) < 2_000, "{gone}");
    for (how, back) in [(0, 0), (1, 0), (0, 1)] {
        let from = position(&mut bench);
        match (how, back) {
            (0, 0) => command(&mut bench, 0x200F),
            (1, 0) => number(&mut bench, 0x3722, 1, 0),
            _ => command(&mut bench, 0x010F),
        }
        bench.run(100);
        assert!(!is_synchronised(&mut bench));
        bench.run(2_500);
        let gone = position(&mut bench) - from;
        if back == 0 {
            assert!(gone.abs_diff(TURN) < 2_500, "DECR: {gone}");
        }
        assert_eq!(way(&mut bench, 300), 0);
        number(&mut bench, 0x3722, 1, 1);
        command(&mut bench, 0x0F);
        bench.run(1_500);
        assert!(is_synchronised(&mut bench));
    }
}

/// IN20MODE 43: what the encoder has gone since the beginning is made up for, and IN20TRIG, which 20B0h is too, added.
#[test]
fn the_s200_catches_up_with_its_master() {
    for (offset, expected) in [(0, 0), (10_000, 10_000)] {
        let mut bench = geared();
        number(&mut bench, 0x3723, 1, 43);
        number(&mut bench, 0x20B0, 0, offset);
        assert_eq!(bench.read(NODE, 0x3724, 1), offset);
        bench.enable(NODE);
        command(&mut bench, 0x200F);
        turn(&mut bench, 500);
        bench.run(500);
        let (from, counts) = (position(&mut bench), bench.read(NODE, 0x35C9, 1));
        command(&mut bench, 0x0F);
        bench.run(4_000);
        assert!(is_synchronised(&mut bench));
        turn(&mut bench, 0);
        bench.run(1_000);
        let counts = (bench.read(NODE, 0x35C9, 1) - counts) as i32;
        let late = position(&mut bench) - from - counts * 8_192 / 125;
        // The counts of the two frames between reading and coupling.
        assert!(late.abs_diff(expected) < 200, "{late}");
    }
}

/// IN20MODE 51: while the encoder goes IN20TRIG counts the motor gets its speed, and goes half of the way.
#[test]
fn the_s200_is_coupled_over_a_travel() {
    let mut bench = geared();
    number(&mut bench, 0x3723, 1, 51);
    number(&mut bench, 0x3724, 1, 2_000);
    bench.enable(NODE);
    command(&mut bench, 0x200F);
    turn(&mut bench, 1_000);
    bench.run(500);
    let from = position(&mut bench);
    command(&mut bench, 0x0F);
    bench.run(1_000);
    let half = way(&mut bench, 10) * 100;
    assert!(half.abs_diff(TURN / 2) < 3_000, "{half}");
    assert!(!is_synchronised(&mut bench));
    bench.run(1_000);
    assert!(is_synchronised(&mut bench));
    let gone = position(&mut bench) - from;
    assert!(gone.abs_diff(TURN) < 3_000, "{gone}");
}

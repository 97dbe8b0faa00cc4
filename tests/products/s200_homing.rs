//! What the parameters of the S200 make of its homing methods.

use sim::plant::{Index, Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled_on, number, position};

/// An axis with zero pulses at each turn, a negative and a positive limit switch, in homing mode.
fn axis(first: i64) -> Bench {
    let track = Track {
        index: Some(Index::new(first, 65_536)),
        negative_limit: Some(Switch::up_to(-30_000)),
        positive_limit: Some(Switch::from(120_000)),
        home: Some(Switch::from(90_000)),
        ..Track::default()
    };
    let mut bench = enabled_on("s200", 1, track);
    for (index, value) in [(0x3562, 3), (0x3565, 2), (0x3568, 12)] {
        number(&mut bench, index, 1, value);
    }
    bench.run(20);
    bench
}

/// Homes by this method; where the motor stands then, and how many milliseconds it took.
fn home(bench: &mut Bench, method: i8) -> (i64, u32) {
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.write(NODE, 0x6098, 0, &method.to_le_bytes());
    bench.run(50);
    command(bench, 0x0F);
    command(bench, 0x1F);
    bench.run(20);
    let mut took = 20;
    while bench.read(NODE, 0x6041, 0) & 0x3400 != 0x1400 {
        bench.run(5);
        took += 5;
        assert!(took < 60_000, "homing has no end");
    }
    bench.run(50);
    assert_eq!(bench.read(NODE, 0x6098, 0) as i8, method);
    (bench.drive.plant_mut().position(), took)
}

/// Method -1 takes the nearer way to the zero of the turn; NREF 5 with DREF 2 is the same.
#[test]
fn homing_within_a_turn_takes_the_nearer_way() {
    for (from, expected) in [(20_000, 0), (45_000, 65_536)] {
        let mut bench = axis(0);
        number(&mut bench, 0x35AD, 1, 5);
        number(&mut bench, 0x352C, 1, 2);
        assert_eq!(bench.read(NODE, 0x6098, 0) as i8, -1);
        begin(&mut bench, from, 100_000, 1_000_000);
        bench.run(1_500);
        let (stands, _) = home(&mut bench, -1);
        assert!(stands.abs_diff(expected) <= 200, "{from}: {stands}");
        assert!(position(&mut bench).abs_diff(0) <= 200);
    }
}

/// REFMODE 1 takes the edge of the switch in place of the zero pulse.
fn refmode_chooses_the_zero_pulse() {
    for (mode, expected) in [(0, -15_000), (1, -30_000)] {
        let mut bench = axis(-15_000);
        number(&mut bench, 0x363C, 1, mode);
        let (stands, _) = home(&mut bench, 1);
        assert!(stands.abs_diff(expected) <= 200, "REFMODE {mode}: {stands}");
    }
}

/// ENCZERO shifts the zero against the pulse; VREF0 says how much slower than VREF it is looked for.
#[test]
fn refmode_enczero_and_vref0_shape_homing() {
    refmode_chooses_the_zero_pulse();
    let mut shown = Vec::new();
    let mut times = Vec::new();
    for (shift, factor) in [(0, 4), (1_000, 4), (0, 16)] {
        let mut bench = axis(-15_000);
        number(&mut bench, 0x3537, 1, shift);
        number(&mut bench, 0x3698, 1, factor);
        number(&mut bench, 0x3628, 1, 40_000);
        let (_, took) = home(&mut bench, 1);
        shown.push(position(&mut bench));
        times.push(took);
        assert_eq!(bench.read(NODE, 0x607C, 0), 0, "the offset is as before");
    }
    assert!((shown[1] - shown[0]).abs_diff(1_000) <= 20, "{shown:?}");
    // 15,000 counts with 2,500 in place of 10,000 counts/s.
    let longer = times[2] - times[0];
    assert!((3_500..=5_500).contains(&longer), "{times:?}");
    assert!(times[1].abs_diff(times[0]) <= 50, "{times:?}");
}

/// ROFFSABS is added to the offset where the position is taken as it is.
#[test]
fn roffsabs_is_the_offset_of_a_position_that_is_taken() {
    let mut bench = axis(0);
    number(&mut bench, 0x35E7, 1, 500);
    number(&mut bench, 0x3656, 1, 7_000);
    home(&mut bench, 35);
    assert_eq!(position(&mut bench).abs(), 7_500);
    assert_eq!(bench.read(NODE, 0x35E7, 1), 500, "ROFFS is as before");
    home(&mut bench, -2);
    assert_eq!(position(&mut bench).abs(), 7_500);
    // By text, whose write is another one's at the same time.
    bench.write(NODE, 0x6098, 0, &[35]);
    command(&mut bench, 0x0F);
    for byte in *b"MH\r" {
        bench.write(NODE, 0x1026, 1, &[byte]);
    }
    bench.run(300);
    assert_eq!(bench.read(NODE, 0x1026, 2) as u8, b'O', "OK");
    assert_eq!(position(&mut bench).abs(), 7_500);
    assert_eq!(bench.read(NODE, 0x35E7, 1), 500);
}

/// AUTOHOME homes when the motor is enabled without a reference; REFLS takes the limit switch for the reference switch.
#[test]
fn autohome_homes_by_itself_and_refls_at_the_limit_switch() {
    for (at_limit, expected) in [(0, 90_000), (1, 120_000)] {
        let mut bench = axis(0);
        command(&mut bench, 0);
        bench.run(20);
        bench.write(NODE, 0x6098, 0, &[24]);
        number(&mut bench, 0x365D, 1, at_limit);
        number(&mut bench, 0x36D7, 1, 1);
        assert_eq!(bench.read(NODE, 0x1002, 0) & 2, 0, "no reference");
        bench.enable(NODE);
        bench.run(10_000);
        assert_eq!(bench.read(NODE, 0x1002, 0) & 2, 2, "it has one");
        let stands = bench.drive.plant_mut().position();
        assert!(
            stands.abs_diff(expected) <= 200,
            "REFLS {at_limit}: {stands}"
        );
        assert!(position(&mut bench).abs_diff(0) <= 200);
    }
}

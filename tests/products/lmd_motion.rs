//! How the LMD follows an encoder, and where its positions begin.

use sim::plant::{Index, Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, enabled_on, number, position, statusword, way};

/// The encoder turns with so many counts/s from now on.
fn turn(bench: &mut Bench, speed: i64) {
    let plant = bench.drive.plant_mut();
    let now = plant.now();
    plant.second.turn(speed, now);
}

/// A drive that follows, with a sample period of so many milliseconds.
fn following(direction: u8, period: u16) -> Bench {
    let mut bench = enabled("lmd", 1);
    for index in [0x6083, 0x6084] {
        number(&mut bench, index, 0, 100_000_000);
    }
    bench.write(NODE, 0x2231, 2, &period.to_le_bytes());
    bench.write(NODE, 0x2231, 1, &[direction]);
    bench.run(50);
    bench
}

/// 2231h:1 to :3: the motor follows the encoder one way or the other, in each sample period, and has reached its target some time behind its last move.
#[test]
fn the_lmd_follows_an_encoder() {
    for (direction, sign) in [(0x01_u8, 1), (0x81, -1), (0x00, 0)] {
        let mut bench = following(direction, 10);
        // 10 counts in each period, and each is 256.
        for (speed, expected) in [(1_000, 160_000), (-1_000, -160_000)] {
            bench.write(NODE, 0x2231, 6, &10_000_u16.to_le_bytes());
            bench.write(NODE, 0x2231, 7, &160_u16.to_le_bytes());
            turn(&mut bench, speed);
            bench.run(100);
            let way = way(&mut bench, 1_000) * sign;
            let wanted = if sign == 0 { 0 } else { expected };
            assert!(way.abs_diff(wanted) <= 3_500, "{direction}: {way}");
        }
    }
    // Nothing moves between samples that are far apart.
    let mut bench = following(1, 500);
    turn(&mut bench, 100);
    let mut rests = 0;
    for _ in 0..40 {
        rests += u32::from(way(&mut bench, 50) == 0);
    }
    assert!((30..=37).contains(&rests), "{rests}");
    // 2231h:3.
    for delay in [100_u16, 800] {
        let mut bench = following(1, 10);
        bench.write(NODE, 0x2231, 3, &delay.to_le_bytes());
        turn(&mut bench, 1_000);
        bench.run(500);
        assert_eq!(statusword(&mut bench) >> 10 & 1, 0);
        turn(&mut bench, 0);
        let mut time = 0;
        while statusword(&mut bench) >> 10 & 1 == 0 {
            bench.run(5);
            time += 5;
            assert!(time < 3_000);
        }
        assert!((delay..delay + 40).contains(&time), "{delay}: {time}");
    }
}

/// 2231h:4 to :8: four microsteps a count up to the threshold, then the gain once, twice and three times; no move is smaller or larger than it may.
#[test]
fn the_gain_of_the_lmd_grows_with_its_thresholds() {
    for (counts, least, most, expected) in [
        (4, 0_u16, 10_000_u16, 16),
        (4, 128, 10_000, 128),
        (50, 0, 10_000, 50 * 8),
        (150, 0, 10_000, 150 * 16),
        (250, 0, 10_000, 250 * 24),
        (400, 0, 30_000, 400 * 24),
        (250, 0, 1_600, 1_600),
        (0, 128, 1_600, 0),
    ] {
        let mut bench = following(1, 20);
        for (sub, value) in [(4, 4), (5, least), (6, most), (7, 8), (8, 100)] {
            bench.write(NODE, 0x2231, sub, &value.to_le_bytes());
        }
        turn(&mut bench, counts * 50);
        bench.run(200);
        let way = way(&mut bench, 2_000);
        assert!(
            way.abs_diff(expected * 100) <= expected.unsigned_abs() * 2,
            "{counts}: {way}"
        );
    }
}

/// 2098h = 0: homing makes home known, and the position goes on counting; method 35 sets it in any case.
#[test]
fn the_lmd_may_count_on_behind_homing() {
    for (configuration, method, expected) in [
        (1_u8, 19_u8, -700),
        (0, 19, 3_000),
        (1, 35, -700),
        (0, 35, -700),
    ] {
        let track = Track {
            home: Some(Switch::from(3_000)),
            ..Track::default()
        };
        let mut bench = enabled_on("lmd", 6, track);
        bench.write(NODE, 0x2002, 1, &[0b100]);
        bench.write(NODE, 0x2098, 0, &[configuration]);
        number(&mut bench, 0x607C, 0, 700);
        number(&mut bench, 0x6099, 1, 5_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &[method]);
        bench.run(20);
        command(&mut bench, 0x1F);
        bench.wait_for_status(NODE, 0x3400, 0x1400, 8_000);
        let stands = bench.drive.plant_mut().position() as i32;
        let home = if method == 35 { 0 } else { 3_000 };
        let at_home = position(&mut bench) - (stands - home);
        assert!(
            at_home.abs_diff(expected) <= 1,
            "{configuration} {method}: {at_home}"
        );
    }
}

/// 2099h: home is so far from the index pulse.
#[test]
fn the_index_pulse_of_the_lmd_counts_elsewhere() {
    for (method, offset) in [(34_u8, 1_i32), (34, 12_000), (34, -25_600), (33, 500)] {
        let track = Track {
            index: Some(Index::new(5_000, 51_200)),
            ..Track::default()
        };
        let mut bench = enabled_on("lmd", 6, track);
        bench.write(NODE, 0x2099, 0, &offset.to_le_bytes());
        number(&mut bench, 0x6099, 1, 50_000);
        number(&mut bench, 0x6099, 2, 20_000);
        bench.write(NODE, 0x6098, 0, &[method]);
        bench.run(20);
        command(&mut bench, 0x1F);
        bench.wait_for_status(NODE, 0x3400, 0x1400, 8_000);
        let stands = bench.drive.plant_mut().position() as i32;
        let index = if method == 34 { 5_000 } else { 5_000 - 51_200 };
        let at_index = position(&mut bench) - (stands - index);
        assert!(
            at_index.abs_diff(-offset) <= 1,
            "{method}, {offset}: {at_index}"
        );
    }
}

/// 2033h:3: a pulse at the capture input that is shorter than its filter is passed over, wherever it lies between two control ticks.
#[test]
fn the_capture_input_of_the_lmd_is_filtered() {
    let filters = [50, 150, 200, 300, 500, 900, 1_700, 3_300, 6_500, 12_900_u32];
    for (filter, time) in (0_u8..).zip(filters) {
        for (width, place) in [(1, 50_000), (2, 50_433), (5, 50_867), (1, 51_300)] {
            let probe = Track {
                probes: [Some(Switch::within(place..=place + width - 1)), None],
                ..Track::default()
            };
            let mut bench = enabled_on("lmd", 1, probe);
            bench.write(NODE, 0x2033, 3, &[filter]);
            bench.write(NODE, 0x2033, 1, &[1]);
            // 2 us for a step.
            begin(&mut bench, 150_000, 500_000, 10_000_000);
            bench.run(600);
            let is_longer = width as u32 * 2_000 >= time;
            assert_eq!(
                bench.read(NODE, 0x2033, 2) == 1,
                is_longer,
                "{filter}: {width} at {place}"
            );
            if is_longer {
                assert_eq!(i64::from(bench.read(NODE, 0x2033, 4)), place);
            }
        }
    }
}

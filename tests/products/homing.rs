//! What the manuals promise of homing: by switches, index pulses and stops, and where it stands.

use sim::plant::{Index, Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, enabled_on, number, position, statusword, way};

/// Two speeds: fast to the switch, slowly to its edge; and the acceleration between them.
fn homes_with_two_speeds(name: &str) {
    let home = Some(Switch::from(3_000));
    // The home switch of a Nanotec is input 6, as that of touch probe 2 is in the plant.
    let track = match name {
        "nanotec" => Track {
            probes: [None, home],
            ..Track::default()
        },
        _ => Track {
            home,
            ..Track::default()
        },
    };
    let mut bench = enabled_on(name, 6, track);
    let method: i8 = match name {
        "lmd" => {
            bench.write(NODE, 0x2002, 1, &[0b100]);
            number(&mut bench, 0x6083, 0, 100_000);
            19
        }
        "s200" => {
            number(&mut bench, 0x3568, 1, 12);
            24
        }
        _ => 20,
    };
    if name != "lmd" {
        number(&mut bench, 0x609A, 0, 100_000);
    }
    number(&mut bench, 0x6099, 1, 2_000);
    number(&mut bench, 0x6099, 2, 200);
    bench.write(NODE, 0x6098, 0, &method.to_le_bytes());
    bench.run(20);
    command(&mut bench, 0x1F);
    bench.run(200);
    let fast = way(&mut bench, 500);
    assert!((980..=1_020).contains(&fast), "{name}: {fast}");
    while position(&mut bench) < 2_990 {
        bench.run(10);
    }
    bench.run(60);
    let slow = way(&mut bench, 40);
    assert!((6..=10).contains(&slow.abs()), "{name}: {slow}");
    bench.wait_for_status(NODE, 0x3400, 0x1400, 5_000);
    // Home is the edge, and the motor stands as far behind it as the input is debounced.
    let stands = bench.drive.plant_mut().position();
    assert!((2_990..=3_000).contains(&stands), "{name}: {stands}");
    let shown = i64::from(position(&mut bench));
    assert!(shown.abs_diff(stands - 3_000) <= 1, "{name}: {shown}");
}

/// Methods 33 and 34 end at the index pulse below or above.
fn homes_at_its_index(name: &str) {
    for (method, index) in [(33_i8, -300), (34, 700)] {
        let track = Track {
            index: Some(Index::new(700, 1_000)),
            ..Track::default()
        };
        let mut bench = enabled_on(name, 6, track);
        number(&mut bench, 0x6099, 1, 2_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &method.to_le_bytes());
        bench.run(20);
        command(&mut bench, 0x1F);
        bench.wait_for_status(NODE, 0x3400, 0x1400, 5_000);
        let found = bench.drive.plant_mut().position();
        // It comes to rest a little behind, and knows how far.
        let behind = (found - index).abs();
        assert!(behind <= 20, "{name} {method}: {found}");
        let shown = i64::from(position(&mut bench)).abs();
        assert!(shown.abs_diff(behind) <= 1, "{name} {method}: {shown}");
    }
}

/// A run to a stop, felt by the encoder, ends there: home is the stop, or the index pulse next to it.
#[test]
fn a_stop_is_home() {
    // -2 of a Nanotec is clockwise, -3 the other way; -3 of an S200 goes on to the zero pulse.
    for (name, method, stop, home) in [
        ("nanotec", 0xFE, 2_000, 2_000),
        ("nanotec", 0xFD, -1_500, -1_500),
        ("s200", 0xFD, -1_500, -1_300),
    ] {
        let track = Track {
            stops: Some(-1_500..=2_000),
            index: Some(Index::new(-1_300, 100_000)),
            ..Track::default()
        };
        let mut bench = enabled_on(name, 6, track);
        bench.drive.plant_mut().encoder = true;
        number(&mut bench, 0x6099, 1, 2_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &[method]);
        bench.run(20);
        command(&mut bench, 0x1F);
        bench.wait_for_status(NODE, 0x3400, 0x1400, 8_000);
        let stands = bench.drive.plant_mut().rotor();
        assert!(
            stands.abs_diff(home) <= 20,
            "{name} {method:02X}h: {stands}, {stop}"
        );
    }
}

/// Methods that a Nanotec has not are refused.
#[test]
fn the_nanotec_has_no_homing_by_limit_switches() {
    let mut bench = Bench::node("nanotec", NODE);
    for method in (1..=18).chain(23..=30).chain([37]) {
        let answer = bench.sdo(NODE, [0x2F, 0x98, 0x60, 0, method, 0, 0, 0]);
        assert_eq!(answer[0], 0x80, "{method}");
    }
    for method in [19, 20, 21, 22, 33, 34, 35, 0xFE, 0xFD] {
        bench.write(NODE, 0x6098, 0, &[method]);
        assert_eq!(bench.read(NODE, 0x6098, 0) as u8, method);
    }
}

/// Methods 19 and 21 are those of a switch that opens: home is the same as with one that closes there.
#[test]
fn the_nanotec_homes_to_a_switch_that_opens() {
    for (method, opens) in [(20_u8, false), (19, true)] {
        let switch = if opens {
            Switch::up_to(3_000)
        } else {
            Switch::from(3_000)
        };
        let track = Track {
            probes: [None, Some(switch)],
            ..Track::default()
        };
        let mut bench = enabled_on("nanotec", 6, track);
        number(&mut bench, 0x6099, 1, 2_000);
        number(&mut bench, 0x6099, 2, 200);
        bench.write(NODE, 0x6098, 0, &[method]);
        bench.run(20);
        command(&mut bench, 0x1F);
        bench.wait_for_status(NODE, 0x3400, 0x1400, 10_000);
        let home = bench.drive.plant_mut().position();
        assert!(home.abs_diff(3_000) <= 10, "{method}: {home}");
    }
}

/// A block is where the motor is behind by 6065h for 6066h.
#[test]
fn the_nanotec_finds_a_block_by_its_following_error() {
    let times = [(100_u32, 20_u16), (1_000, 20), (100, 500)].map(|(window, time)| {
        let track = Track {
            stops: Some(-1_500..=2_000),
            ..Track::default()
        };
        let mut bench = enabled_on("nanotec", 6, track);
        bench.drive.plant_mut().encoder = true;
        number(&mut bench, 0x6065, 0, window);
        bench.write(NODE, 0x6066, 0, &time.to_le_bytes());
        number(&mut bench, 0x6099, 1, 2_000);
        number(&mut bench, 0x6099, 2, 500);
        bench.write(NODE, 0x6098, 0, &[0xFE]);
        bench.run(20);
        command(&mut bench, 0x1F);
        let mut passed = 0;
        while statusword(&mut bench) & 0x3400 != 0x1400 {
            bench.run(10);
            passed += 10;
            assert!(passed < 20_000, "{window} for {time} ms");
        }
        passed
    });
    // 900 further at 2000 a second; 480 ms longer.
    assert!(times[1] > times[0] + 400, "{times:?}");
    assert!(times[2] > times[0] + 400, "{times:?}");
}

/// Method 22 looks for a switch that closes in the other direction, and ends where it opens again.
#[test]
fn the_nanotec_homes_to_a_switch_below_it() {
    let track = Track {
        probes: [None, Some(Switch::up_to(-1_000))],
        ..Track::default()
    };
    let mut bench = enabled_on("nanotec", 6, track);
    bench.write(NODE, 0x6098, 0, &[22]);
    bench.run(20);
    command(&mut bench, 0x1F);
    bench.wait_for_status(NODE, 0x3400, 0x1400, 8_000);
    let stands = bench.drive.plant_mut().position();
    assert!((-1_000..=-985).contains(&stands), "{stands}");
}

/// -2 takes the position as it is, and methods that the S200 has not are refused.
#[test]
fn the_s200_sets_its_reference_where_it_stands() {
    let mut bench = enabled("s200", 1);
    begin(&mut bench, 3_000, 20_000, 100_000);
    bench.run(1_000);
    // ROFFS.
    number(&mut bench, 0x35E7, 1, 500);
    assert_eq!(bench.read(NODE, 0x607C, 0), 500);
    bench.write(NODE, 0x6098, 0, &[0xFE]);
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.run(20);
    command(&mut bench, 0x1F);
    bench.wait_for_status(NODE, 0x3400, 0x1400, 1_000);
    assert_eq!(position(&mut bench), 500);
    assert_eq!(bench.drive.plant_mut().position(), 3_000, "nothing moved");
    for method in [3, 7, 19, 23, 30, 37, 0xFC] {
        let answer = bench.sdo(NODE, [0x2F, 0x98, 0x60, 0, method, 0, 0, 0]);
        assert_eq!(answer[0], 0x80, "{method}");
    }
}

mod each {
    promises! {
        homes_with_two_speeds: lmd nanotec s200;
        homes_at_its_index: lmd nanotec s200;
    }
}

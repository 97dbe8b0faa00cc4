//! What the manuals promise of speeds, ramps, windows and units: start speeds, velocity mode, limits of the acceleration, two speeds of
//! homing.

use canopen::Frame;
use sim::plant::{Axis, Index, Switch, Track};

use crate::bench::Bench;

const NODE: u8 = 4;

fn position(bench: &mut Bench) -> i32 {
    bench.read(NODE, 0x6064, 0) as i32
}

fn statusword(bench: &mut Bench) -> u16 {
    bench.read(NODE, 0x6041, 0) as u16
}

fn command(bench: &mut Bench, controlword: u16) {
    bench.write(NODE, 0x6040, 0, &controlword.to_le_bytes());
}

/// How far the motor goes in so many milliseconds.
fn way(bench: &mut Bench, milliseconds: u32) -> i32 {
    let from = position(bench);
    bench.run(milliseconds);
    position(bench) - from
}

fn number(bench: &mut Bench, index: u16, sub: u8, value: u32) {
    bench.write(NODE, index, sub, &value.to_le_bytes());
}

/// A product whose motor is on, in this mode, on this axis.
fn enabled_on(name: &str, mode: u8, track: Track) -> Bench {
    let mut bench = Bench::node(name, NODE);
    let axis = Axis {
        track,
        ..Axis::default()
    };
    bench.drive.plant_mut().mount(&axis);
    bench.write(NODE, 0x6060, 0, &[mode]);
    bench.enable(NODE);
    bench
}

fn enabled(name: &str, mode: u8) -> Bench {
    enabled_on(name, mode, Track::default())
}

/// Begins a move with this velocity and acceleration.
fn begin(bench: &mut Bench, target: i32, velocity: u32, acceleration: u32) {
    number(bench, 0x6081, 0, velocity);
    number(bench, 0x6083, 0, acceleration);
    number(bench, 0x6084, 0, acceleration);
    bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
    command(bench, 0x1F);
    command(bench, 0x0F);
}

/// 6082h is the speed with which a move begins and ends: with 10,000 at 10,000 a second² a fifth of a second is 2200 steps far, and
/// 200 without.
fn begins_with_its_start_speed(name: &str) {
    for (start, ways) in [(10_000, 2_100..=2_300), (0, 180..=260)] {
        let mut bench = enabled(name, 1);
        number(&mut bench, 0x6082, 0, start);
        begin(&mut bench, -20_000, 20_000, 10_000);
        bench.run(200);
        let way = -position(&mut bench);
        assert!(ways.contains(&way), "{name}: {way} from {start}");
        // Three seconds of ramps without it, and one with it.
        bench.run(if start == 0 { 3_500 } else { 1_500 });
        assert_eq!(position(&mut bench), -20_000, "{name}");
        assert_eq!(bench.drive.plant_mut().position(), -20_000, "{name}");
        assert_eq!(statusword(&mut bench) >> 10 & 1, 1, "{name}");
    }
}

/// No harder than 60C5h: half a second at 1000 a second² is 125 far.
fn keeps_below_its_maximum_acceleration(name: &str) {
    let mut bench = enabled(name, 1);
    number(&mut bench, 0x60C5, 0, 1_000);
    begin(&mut bench, 50_000, 10_000, 100_000);
    let way = way(&mut bench, 500);
    assert!((115..=145).contains(&way), "{name}: {way}");
    assert_eq!(statusword(&mut bench) >> 11 & 1, 1, "{name}");
    if name != "nanotec" {
        return;
    }
    // Nor does it brake harder than 60C6h: a second up and two down are 3000 far.
    let mut bench = enabled(name, 1);
    number(&mut bench, 0x60C5, 0, 2_000);
    number(&mut bench, 0x60C6, 0, 1_000);
    begin(&mut bench, 3_000, 10_000, 100_000);
    bench.run(2_800);
    assert!((2_960..3_000).contains(&position(&mut bench)), "{name}");
    bench.run(300);
    assert_eq!(position(&mut bench), 3_000, "{name}");
}

/// Bit 10 comes when the motor has been in the window for its time: 6067h and 6068h, or what stands for them.
fn reaches_its_target_by_a_window(name: &str) {
    let mut bench = enabled(name, 1);
    match name {
        "s200" => {
            number(&mut bench, 0x35C6, 1, 100);
            number(&mut bench, 0x3630, 1, 300);
        }
        _ => {
            number(&mut bench, 0x6067, 0, 100);
            bench.write(NODE, 0x6068, 0, &300_u16.to_le_bytes());
        }
    }
    begin(&mut bench, 2_000, 2_000, 100_000);
    while position(&mut bench) != 2_000 {
        bench.run(5);
    }
    bench.run(100);
    assert_eq!(statusword(&mut bench) >> 10 & 1, 0, "{name}: too early");
    bench.run(250);
    assert_eq!(statusword(&mut bench) >> 10 & 1, 1, "{name}");
}

/// Where the motor should be, where it is, and that in increments; on the way, and at its end.
fn shows_where_it_is(name: &str) {
    let mut bench = Bench::node(name, NODE);
    let scale = if name == "nanotec" {
        number(&mut bench, 0x6092, 1, 1_000);
        2
    } else {
        1
    };
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    begin(&mut bench, 3_000, 2_000, 100_000);
    bench.run(500);
    let shown = [0x6063, 0x6064].map(|index| bench.read(NODE, index, 0) as i32);
    assert!(
        shown[0].abs_diff(shown[1] * scale) < 20,
        "{name}: {shown:?}"
    );
    assert!((500..2_900).contains(&shown[1]), "{name}: {shown:?}");
    bench.run(2_000);
    let shown = [0x6063, 0x6064].map(|index| bench.read(NODE, index, 0) as i32);
    assert_eq!(shown, [3_000 * scale, 3_000], "{name}");
    if name == "nanotec" {
        assert_eq!(bench.read(NODE, 0x6062, 0), 3_000);
    }
}

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

/// Set-points of interpolated position come with SYNC; the motor is where they are, once bit 4 is set, and bit 12 tells so.
fn follows_a_set_point_of_each_sync(name: &str) {
    let mut bench = Bench::node(name, NODE);
    bench.write(NODE, 0x60C2, 1, &[10]);
    let millis = (-3_i16).to_le_bytes();
    let size = if name == "s200" { 2 } else { 1 };
    bench.write(NODE, 0x60C2, 2, &millis[..size]);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.write(NODE, 0x6060, 0, &[7]);
    bench.enable(NODE);
    let cycle = |bench: &mut Bench, target: i32| {
        bench.write(NODE, 0x60C1, 1, &target.to_le_bytes());
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.run(10);
    };
    for _ in 0..50 {
        cycle(&mut bench, 0);
    }
    assert_eq!(statusword(&mut bench) >> 12 & 1, 0, "{name}: not yet");
    command(&mut bench, 0x1F);
    for _ in 0..10 {
        cycle(&mut bench, 0);
    }
    assert_eq!(statusword(&mut bench) >> 12 & 1, 1, "{name}");
    for target in 1..=100 {
        cycle(&mut bench, target * 10);
        if target == 80 {
            let away = position(&mut bench) - 800;
            assert!((-40..=10).contains(&away), "{name}: {away}");
        }
    }
    for _ in 0..10 {
        cycle(&mut bench, 1_000);
    }
    assert_eq!(position(&mut bench), 1_000, "{name}");
}

/// A quick stop ramp brings the motor to rest before an error takes its power.
#[test]
fn the_s200_stops_on_its_ramp_before_an_error_takes_the_power() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x6085, 0, 20_000);
    number(&mut bench, 0x6083, 0, 100_000);
    number(&mut bench, 0x60FF, 0, 20_000);
    bench.run(1_000);
    assert_eq!(bench.read(NODE, 0x606C, 0), 20_000, "the actual velocity");
    bench.drive.plant_mut().encoder = true;
    bench.run(50);
    bench.drive.plant_mut().displace(-30_000);
    let from = bench.drive.plant_mut().position();
    bench.wait_for_status(NODE, 0x4F, 0x0F, 400);
    assert!(bench.drive.plant_mut().is_energised(), "it brakes");
    bench.wait_for_status(NODE, 0x4F, 0x08, 2_000);
    let way = bench.drive.plant_mut().position() - from;
    // A second at 20,000 a second² is 10,000 far.
    assert!((9_900..=11_000).contains(&way), "{way}");
    bench.run(20);
    assert!(!bench.drive.plant_mut().is_energised());
}

/// 604Ch makes 1/min of the units of velocity mode; by default they are steps/s.
#[test]
fn the_velocity_of_a_nanotec_is_in_turns_a_minute() {
    for (dimension, target, expected) in [((60_u32, 2_000_u32), 500_i16, 500), ((1, 1), 30, 1_000)]
    {
        let mut bench = Bench::node("nanotec", NODE);
        number(&mut bench, 0x604C, 1, dimension.0);
        number(&mut bench, 0x604C, 2, dimension.1);
        bench.write(NODE, 0x6060, 0, &[2]);
        bench.enable(NODE);
        bench.write(NODE, 0x6042, 0, &target.to_le_bytes());
        bench.run(3_000);
        assert_eq!(bench.read(NODE, 0x6043, 0) as i16, target);
        let way = way(&mut bench, 1_000);
        assert!((way - expected).abs() <= 10, "{dimension:?}: {way}");
    }
}

/// 6048h and 6049h are a speed and the seconds for it.
#[test]
fn the_ramps_of_velocity_mode_are_a_speed_and_its_time() {
    let mut bench = enabled("nanotec", 2);
    for (index, speed, time) in [
        (0x6048, 2_000, 2_u16),
        (0x6049, 2_000, 1),
        (0x604A, 4_000, 1),
    ] {
        number(&mut bench, index, 1, speed);
        bench.write(NODE, index, 2, &time.to_le_bytes());
    }
    bench.write(NODE, 0x6042, 0, &1_000_i16.to_le_bytes());
    let up = way(&mut bench, 500);
    assert!((115..=140).contains(&up), "{up}");
    bench.run(1_000);
    bench.write(NODE, 0x6042, 0, &0_i16.to_le_bytes());
    let down = way(&mut bench, 1_000);
    assert!((240..=260).contains(&down), "{down}");
    bench.write(NODE, 0x6042, 0, &1_000_i16.to_le_bytes());
    bench.run(1_500);
    command(&mut bench, 0x0B);
    let quick = way(&mut bench, 1_000);
    assert!((115..=140).contains(&quick), "{quick}");
}

/// Bit 6 of 607Eh turns velocity mode around, and bit 7 positions, each alone.
#[test]
fn the_nanotec_turns_velocity_and_position_around_each_by_a_bit() {
    for (polarity, velocity, target) in [(0x00, 1, 1), (0x40, -1, 1), (0x80, 1, -1), (0xC0, -1, -1)]
    {
        let set = |mode: u8| {
            let mut bench = Bench::node("nanotec", NODE);
            bench.write(NODE, 0x607E, 0, &[polarity]);
            bench.write(NODE, 0x6060, 0, &[mode]);
            bench.enable(NODE);
            bench
        };
        let mut bench = set(2);
        bench.write(NODE, 0x6042, 0, &500_i16.to_le_bytes());
        bench.run(1_000);
        assert_eq!(bench.read(NODE, 0x6043, 0) as i16, 500, "{polarity:02X}h");
        let moved = bench.drive.plant_mut().position();
        assert_eq!(moved.signum(), velocity, "{polarity:02X}h: {moved}");
        let mut bench = set(1);
        begin(&mut bench, 500, 1_000, 10_000);
        bench.run(1_000);
        let moved = bench.drive.plant_mut().position();
        assert_eq!(moved, 500 * target, "{polarity:02X}h");
    }
}

/// 4800 turns a minute are 160,000 steps a second of a motor with 2000 in a turn.
#[test]
fn the_nanotec_turns_4800_times_a_minute() {
    let mut bench = enabled("nanotec", 1);
    begin(&mut bench, 600_000, 160_000, 100_000);
    bench.run(2_000);
    let way = way(&mut bench, 1_000);
    assert!((159_000..=161_500).contains(&way), "{way}");
    bench.run(5_000);
    assert_eq!(position(&mut bench), 600_000);
}

/// 2000h, the step mode, changes nothing of where the motor goes, and 608Fh says what a turn is.
#[test]
fn units_of_the_nanotec_are_those_of_its_encoder_and_not_of_the_step_mode() {
    for (step_mode, increments, steps) in [
        (1_u8, 2_000_u32, 1_000),
        (8, 2_000, 1_000),
        (1, 4_000, 2_000),
    ] {
        let mut bench = Bench::node("nanotec", NODE);
        bench.write(NODE, 0x2000, 0, &[step_mode]);
        number(&mut bench, 0x608F, 1, increments);
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        begin(&mut bench, 1_000, 2_000, 10_000);
        bench.run(2_000);
        assert_eq!(position(&mut bench), 1_000);
        assert_eq!(
            bench.drive.plant_mut().position(),
            steps,
            "{step_mode} {increments}"
        );
    }
}

/// Bit 8 of a Nanotec tells that its clock is locked to SYNC.
#[test]
fn the_nanotec_tells_that_it_is_locked_to_sync() {
    let mut bench = Bench::node("nanotec", NODE);
    // It listens from operational on.
    for (command, is_locked) in [(128, 0), (1, 1)] {
        bench.send(&Frame::data_frame(0, &[command, NODE]));
        bench.run(20);
        for _ in 0..400 {
            bench.send(&Frame::data_frame(0x080, &[]));
            bench.run(5);
        }
        let word = bench.drive.object(0x6041, 0).unwrap();
        assert_eq!(word[1] & 1, is_locked, "{command}");
    }
    bench.run(500);
    assert_eq!(statusword(&mut bench) >> 8 & 1, 0, "SYNC has ended");
}

/// Methods that a Nanotec has not are refused, and so are those of a switch that opens, which it has.
#[test]
fn the_nanotec_has_no_homing_by_limit_switches() {
    let mut bench = Bench::node("nanotec", NODE);
    for method in (1..=18).chain(23..=30).chain([37]) {
        let answer = bench.sdo(NODE, [0x2F, 0x98, 0x60, 0, method, 0, 0, 0]);
        assert_eq!(answer[0], 0x80, "{method}");
    }
    for method in [20, 22, 33, 34, 35, 0xFE, 0xFD] {
        bench.write(NODE, 0x6098, 0, &[method]);
        assert_eq!(bench.read(NODE, 0x6098, 0) as u8, method);
    }
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

/// Bit 12 of cyclic synchronous position tells that the target is followed, bit 13 of a following error.
#[test]
fn the_lmd_tells_how_it_follows_cyclic_targets() {
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x60C2, 1, &[10]);
    bench.write(NODE, 0x60C2, 2, &(-3_i8).to_le_bytes());
    number(&mut bench, 0x6065, 0, 500);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.write(NODE, 0x6060, 0, &[8]);
    bench.enable(NODE);
    let cycle = |bench: &mut Bench, target: i32| {
        bench.write(NODE, 0x607A, 0, &target.to_le_bytes());
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.run(10);
        statusword(bench) >> 12 & 3
    };
    for target in 0..100 {
        cycle(&mut bench, target * 20);
    }
    assert_eq!(cycle(&mut bench, 2_000), 0b01, "it follows");
    bench.drive.plant_mut().encoder = true;
    cycle(&mut bench, 2_020);
    bench.drive.plant_mut().displace(-2_000);
    for target in 102..110 {
        cycle(&mut bench, target * 20);
    }
    assert_eq!(cycle(&mut bench, 2_200) >> 1, 1, "it is too far away");
    // Without targets nothing is followed.
    let mut bench = Bench::node("lmd", NODE);
    bench.write(NODE, 0x6060, 0, &[8]);
    bench.enable(NODE);
    bench.write(NODE, 0x6040, 0, &[0x0F, 1]);
    bench.run(200);
    assert_eq!(statusword(&mut bench) >> 12 & 1, 0, "halt");
}

/// A master that begins with the position that it reads moves nothing; its set-points come by a PDO with SYNC.
#[test]
fn the_nanotec_is_led_by_pdos_from_where_it_stands() {
    let mut bench = Bench::node("nanotec", NODE);
    // RPDO 2 carries controlword and set-point, TPDO 2 statusword and position.
    for (index, cob_id, mapping) in [
        (0x1401, 0x0000_0304_u32, [0x6040_0010_u32, 0x60C1_0120]),
        (0x1801, 0x4000_0284, [0x6041_0010, 0x6064_0020]),
    ] {
        number(&mut bench, index, 1, cob_id | 0x8000_0000);
        bench.write(NODE, index + 0x200, 0, &[0]);
        for (sub, entry) in (1..).zip(mapping) {
            number(&mut bench, index + 0x200, sub, entry);
        }
        bench.write(NODE, index + 0x200, 0, &[2]);
        bench.write(NODE, index, 2, &[1]);
        number(&mut bench, index, 1, cob_id);
    }
    // The period is that of SYNC, whatever this is.
    bench.write(NODE, 0x60C2, 1, &[77]);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    begin(&mut bench, 700, 2_000, 50_000);
    bench.run(1_000);
    bench.write(NODE, 0x6060, 0, &[7]);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    bench.run(20);
    let cycle = |bench: &mut Bench, controlword: u16, target: i32| {
        let mut data = controlword.to_le_bytes().to_vec();
        data.extend(target.to_le_bytes());
        bench.send(&Frame::data_frame(0x304, &data));
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.run(10);
        let own = |frame: &&Frame| frame.standard_id() == Some(0x284);
        let frame = *bench.sent.iter().find(own).expect("TPDO 2");
        let [_, _, a, b, c, d] = frame.payload() else {
            panic!("{frame:?}")
        };
        i32::from_le_bytes([*a, *b, *c, *d])
    };
    let here = cycle(&mut bench, 0x0F, 0);
    assert_eq!(here, 700);
    for _ in 0..50 {
        assert_eq!(cycle(&mut bench, 0x1F, here), 700, "it stays");
    }
    let mut last = here;
    for step in 1..=60 {
        let shown = cycle(&mut bench, 0x1F, here + step.min(50) * 10);
        // No faster than the set-points are apart, and a step more or less.
        assert!((0..=12).contains(&(shown - last)), "{shown} behind {last}");
        last = shown;
    }
    assert_eq!(last, 1_200);
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

/// A window of 0 watches no following error; another one is a fault.
#[test]
fn the_s200_watches_no_following_error_with_a_window_of_0() {
    for (window, state) in [(0, 0x27), (500, 0x08)] {
        let mut bench = enabled("s200", 1);
        number(&mut bench, 0x6065, 0, window);
        bench.drive.plant_mut().encoder = true;
        begin(&mut bench, 50_000, 2_000, 20_000);
        bench.run(500);
        bench.drive.plant_mut().displace(-5_000);
        bench.run(500);
        assert_eq!(statusword(&mut bench) & 0x6F, state, "{window}");
    }
}

/// V, PV, VCMD and those of the base unit are in 1/min.
#[test]
fn the_s200_shows_its_speed_in_turns_a_minute() {
    let mut bench = enabled("s200", 3);
    number(&mut bench, 0x6083, 0, 655_360);
    number(&mut bench, 0x60FF, 0, 65_536);
    bench.run(1_000);
    for index in [0x3618, 0x35D7, 0x361E, 0x3B62, 0x3B8B] {
        let shown = bench.read(NODE, index, 1) as i32;
        assert!((59..=61).contains(&shown), "{index:04X}h: {shown}");
    }
}

/// READY and ACTIVE tell of software and power, and INPOS that the target is reached.
#[test]
fn the_s200_tells_of_its_enable_and_its_position() {
    let mut bench = Bench::node("s200", NODE);
    bench.run(20);
    let facts =
        |bench: &mut Bench| [0x35E4, 0x35DD, 0x3504].map(|index| bench.read(NODE, index, 1));
    assert_eq!(facts(&mut bench), [1, 0, 0]);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.run(20);
    assert_eq!(facts(&mut bench), [1, 1, 1]);
    begin(&mut bench, 20_000, 20_000, 200_000);
    bench.run(100);
    assert_eq!(bench.read(NODE, 0x356D, 1), 0);
    bench.run(3_000);
    assert_eq!(bench.read(NODE, 0x356D, 1), 1);
}

/// Motion task 0 of the S200 is a set-point by its own objects, O_P and O_V.
#[test]
fn the_direct_task_of_the_s200_is_a_set_point() {
    let mut bench = enabled("s200", 1);
    number(&mut bench, 0x35BF, 1, 20_000);
    number(&mut bench, 0x35BE, 1, 5_000);
    assert_eq!(bench.read(NODE, 0x6081, 0), 20_000);
    command(&mut bench, 0x1F);
    command(&mut bench, 0x0F);
    bench.run(1_000);
    assert_eq!(position(&mut bench), 5_000);
    // PFB shows it too.
    assert_eq!(bench.read(NODE, 0x35C8, 1), 5_000);
}

macro_rules! promises {
    ($($what:ident: $($product:ident)*;)*) => {$(
        #[test]
        fn $what() {
            $(super::$what(stringify!($product));)*
        }
    )*};
}

mod each {
    promises! {
        begins_with_its_start_speed: lmd nanotec;
        keeps_below_its_maximum_acceleration: nanotec s200;
        reaches_its_target_by_a_window: nanotec s200;
        shows_where_it_is: nanotec s200;
        homes_with_two_speeds: lmd nanotec s200;
        homes_at_its_index: lmd nanotec s200;
        follows_a_set_point_of_each_sync: nanotec s200;
    }
}

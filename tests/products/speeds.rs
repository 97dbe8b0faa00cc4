//! What the manuals promise of speeds, ramps, windows and units: start speeds, velocity mode, limits of the acceleration.

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, number, position, statusword, way};

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
    } else if name == "s200" {
        // PRBASE: twenty bits a turn, of which positions have sixteen.
        16
    } else {
        1
    };
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    begin(&mut bench, 3_000, 2_000, 100_000);
    bench.run(500);
    let shown = [0x6063, 0x6064].map(|index| bench.read(NODE, index, 0) as i32);
    assert!(
        shown[0].abs_diff(shown[1] * scale) < 20 * scale as u32,
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

/// 2000h, the step mode, is kept and changes nothing: each pulse is a microstep in all of them.
#[test]
fn the_nanotec_makes_microsteps_in_each_step_mode() {
    let mut paths = Vec::new();
    for mode in [1, 2, 4, 5, 8, 10, 16, 32, 64, 255] {
        let mut bench = enabled("nanotec", 1);
        bench.write(NODE, 0x2000, 0, &[mode]);
        assert_eq!(bench.read(NODE, 0x2000, 0) as u8, mode);
        number(&mut bench, 0x6082, 0, 0);
        begin(&mut bench, 1_000, 1_000, 10_000);
        let mut path = Vec::new();
        for _ in 0..60 {
            bench.run(20);
            path.push(bench.drive.plant_mut().position());
        }
        assert_eq!(path.last(), Some(&1_000), "{mode}");
        // Twenty milliseconds at 1000 a second are 20 of them, and at the start they are fewer.
        assert!(
            path.windows(2)
                .all(|two| (0..=22).contains(&(two[1] - two[0])))
        );
        paths.push(path);
    }
    assert!(paths.windows(2).all(|two| two[0] == two[1]));
}

/// A quick stop has the ramp of its mode: 6085h, and 604Ah in velocity mode. Half a second at 20,000 a second² is 2500 far.
#[test]
fn the_quick_stop_of_a_nanotec_has_the_ramp_of_its_mode() {
    for mode in [1, 2, 6] {
        let mut bench = enabled("nanotec", mode);
        match mode {
            1 => {
                number(&mut bench, 0x6085, 0, 20_000);
                number(&mut bench, 0x6082, 0, 0);
                begin(&mut bench, 1_000_000, 10_000, 100_000);
            }
            2 => {
                number(&mut bench, 0x6085, 0, 60_000);
                number(&mut bench, 0x604A, 1, 20_000);
                bench.write(NODE, 0x604A, 2, &[1, 0]);
                number(&mut bench, 0x6048, 1, 100_000);
                bench.write(NODE, 0x6048, 2, &[1, 0]);
                bench.write(NODE, 0x6042, 0, &10_000_i16.to_le_bytes());
            }
            _ => {
                number(&mut bench, 0x6085, 0, 20_000);
                number(&mut bench, 0x609A, 0, 100_000);
                number(&mut bench, 0x6099, 1, 10_000);
                bench.write(NODE, 0x6098, 0, &[20]);
                command(&mut bench, 0x1F);
            }
        }
        bench.run(1_000);
        assert!((495..=505).contains(&way(&mut bench, 50)), "{mode}");
        command(&mut bench, 0x0B);
        let braked = way(&mut bench, 1_000);
        assert!((2_450..=2_600).contains(&braked), "{mode}: {braked}");
        assert_eq!(way(&mut bench, 100), 0, "{mode}");
    }
}

mod each {
    promises! {
        begins_with_its_start_speed: lmd nanotec;
        keeps_below_its_maximum_acceleration: nanotec s200;
        reaches_its_target_by_a_window: nanotec s200;
        shows_where_it_is: nanotec s200;
    }
}

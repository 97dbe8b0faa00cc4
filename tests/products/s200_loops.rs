//! The gains of the loops of the S200, what goes ahead of them, and CTUNE.

use sim::drive::Setup;
use sim::plant::{Axis, ServoAxisData};

use crate::bench::Bench;
use crate::s200_servo::{RATED, enabled, get, held, rotor, s200, set, torque};
use crate::steer::{NODE, begin, current, number, on_servo, plant, position};

/// How far a load turns a rotor that stands, at most, and after 150 ms, in counts.
fn yields(bench: &mut Bench) -> (f64, f64) {
    let stands = rotor(bench);
    plant(bench).load_torque = 0.15;
    let mut most = 0.0_f64;
    for _ in 0..150 {
        bench.run(1);
        most = most.max((rotor(bench) - stands).abs());
    }
    (most, (rotor(bench) - stands).abs())
}

fn with(index: u16, value: i32) -> (f64, f64) {
    let mut bench = s200();
    set(&mut bench, index, value);
    let mut bench = enabled(bench, 1);
    bench.run(200);
    yields(&mut bench)
}

#[test]
fn the_gain_of_the_velocity_of_the_s200_makes_it_stiff() {
    let (own, soft) = (with(0x38F1, 0).0, with(0x38F1, 400).0);
    assert!((with(0x38F1, 800).0 / own - 1.0).abs() < 0.05, "it has 800");
    assert!(soft > 1.7 * own, "{soft}, {own}");
}

#[test]
fn the_break_frequency_of_the_s200_takes_a_load() {
    let (quick, slow) = (with(0x38F2, 42), with(0x38F2, 1));
    assert!(slow.1 > 5.0 * quick.1.max(2.0), "{slow:?}, {quick:?}");
}

#[test]
fn the_gain_of_the_position_of_the_s200_brings_it_back() {
    let (own, soft) = (with(0x3901, 0), with(0x3901, 50));
    assert!(soft.0 > 1.3 * own.0, "{soft:?}, {own:?}");
}

/// The greatest following error of a move at so many counts/s and counts/s², while it is as fast as it gets and while it becomes so.
fn errors(ahead: (i32, i32)) -> (f64, f64) {
    let mut bench = s200();
    set(&mut bench, 0x3902, ahead.0);
    set(&mut bench, 0x3903, ahead.1);
    let mut bench = enabled(bench, 1);
    begin(&mut bench, 600_000, 655_360, 65_536_000);
    let mut speeds = 0;
    for _ in 0..40 {
        bench.run(1);
        speeds = speeds.max(get(&mut bench, 0x35C5).abs());
    }
    bench.run(250);
    let turns = get(&mut bench, 0x35C5).abs();
    // It is that of the rotor.
    let (truly, shown) = (rotor(&mut bench), f64::from(position(&mut bench)));
    assert!((truly - shown).abs() < 7_000.0);
    (speeds.into(), turns.into())
}

#[test]
fn the_s200_gives_its_velocity_ahead() {
    let (all, none) = (errors((1_000, 1_000)).1, errors((0, 1_000)).1);
    let half = errors((500, 1_000)).1;
    assert!(all < 60.0, "{all}");
    // v / KPP, of a third of 800/s.
    assert!((none / 2_457.0 - 1.0).abs() < 0.1, "{none}");
    assert!((half / none - 0.5).abs() < 0.05, "{half}");
}

#[test]
fn the_s200_gives_its_torque_ahead() {
    let (all, none) = (errors((1_000, 1_000)).0, errors((1_000, 0)).0);
    assert!(none > 20.0 + 2.0 * all, "{none}, {all}");
}

#[test]
fn the_s200_tells_that_nothing_goes_ahead() {
    let mut bench = s200();
    bench.run(5);
    assert_eq!(bench.read(NODE, 0x1002, 0) >> 22 & 1, 0);
    set(&mut bench, 0x3902, 0);
    set(&mut bench, 0x3903, 0);
    bench.run(5);
    assert_eq!(bench.read(NODE, 0x1002, 0) >> 22 & 1, 1);
    let mut bench = enabled(bench, 1);
    begin(&mut bench, 600_000, 655_360, 3_276_800);
    bench.run(350);
    assert!(get(&mut bench, 0x35C5).abs() > 2_000, "it lags");
    assert_eq!(bench.read(NODE, 0x1002, 0) >> 22 & 1, 1);
}

/// EncIn1Lines: an encoder with other lines than the axis has is none, until the drive knows of them.
#[test]
fn the_lines_of_the_encoder_are_those_of_the_s200() {
    let mut data = ServoAxisData::named("servo_100w").unwrap();
    data.other_counts = Some(10_000);
    for (lines, is_right) in [(2_500, true), (0, false), (3_000, false)] {
        let setup = Setup {
            axis: Some(Axis::bare_servo(&data)),
            ..Setup::with_node_id(1, NODE)
        };
        let mut bench = Bench::new("s200", setup);
        number(&mut bench, 0x6080, 0, 2_500);
        set(&mut bench, 0x38FA, lines);
        bench.run(20);
        let mut bench = enabled(bench, 1);
        begin(&mut bench, 3 * 65_536, 655_360, 6_553_600);
        bench.run(1_000);
        let turns = rotor(&mut bench) / 65_536.0;
        // A count of the encoder are 6.6 positions.
        assert_eq!((turns - 3.0).abs() < 3e-4, is_right, "{lines}: {turns}");
        if is_right {
            assert!((position(&mut bench) - 3 * 65_536).abs() <= 14);
        }
    }
}

/// As the power comes 6064h is the angle in its own counts, whatever lines an encoder in place of this one would have.
#[test]
fn an_absolute_encoder_begins_in_the_counts_of_the_s200() {
    for turns in [0.1_f64, 0.7] {
        let mut data = ServoAxisData::named("servo_100w_absolute").unwrap();
        data.start = turns * std::f64::consts::TAU;
        let setup = Setup {
            axis: Some(Axis::bare_servo(&data)),
            ..Setup::with_node_id(1, NODE)
        };
        let mut bench = Bench::new("s200", setup);
        set(&mut bench, 0x38FA, 2_500);
        bench.run(20);
        let expected = (turns * 65_536.0) as i32;
        assert!((position(&mut bench) - expected).abs() <= 1, "{turns}");
        number(&mut bench, 0x6080, 0, 2_500);
        let mut bench = enabled(bench, 1);
        begin(&mut bench, expected + 20_000, 655_360, 6_553_600);
        bench.run(1_000);
        let stands = plant(&mut bench).angle() / std::f64::consts::TAU;
        let way = (stands - turns) * 65_536.0;
        assert!((way - 20_000.0).abs() <= 14.0, "{way}");
    }
}

/// CommMode: by the Hall sensors nothing moves before the torque; by the encoder alone the magnet is looked for, and a Hall sensor may say anything.
#[test]
fn the_commutation_of_the_s200_has_its_source() {
    for (mode, is_searched) in [(0, false), (1, true)] {
        let mut bench = on_servo("s200", "servo_100w_hall");
        number(&mut bench, 0x6080, 0, 2_500);
        set(&mut bench, 0x38F8, mode);
        bench.run(5);
        bench.write(NODE, 0x6060, 0, &[4]);
        let from = rotor(&mut bench);
        for controlword in [0x06_u8, 0x07, 0x0F] {
            bench.write(NODE, 0x6040, 0, &[controlword, 0]);
            bench.run(5);
        }
        let mut moved = 0.0_f64;
        for _ in 0..1_000 {
            bench.run(1);
            moved = moved.max((rotor(&mut bench) - from).abs());
        }
        // A turn of the magnet is a quarter of one of the shaft.
        let least = if is_searched { 1_000.0 } else { 0.0 };
        let most = if is_searched { 16_384.0 } else { 50.0 };
        assert!((least..=most).contains(&moved), "{mode}: {moved}");
        for target in [200_i16, -200] {
            let before = rotor(&mut bench);
            torque(&mut bench, target);
            bench.run(100);
            let turned = (rotor(&mut bench) - before) * f64::from(target.signum());
            assert!(turned > 500.0, "{mode}: {turned} by {target}");
            torque(&mut bench, 0);
            plant(&mut bench).load_brake = 0.2;
            bench.run(500);
            plant(&mut bench).load_brake = 0.0;
        }
        plant(&mut bench).sensor_faults.cut_hall = 0b111;
        bench.run(20);
        let word = bench.read(NODE, 0x6041, 0);
        assert_eq!(word & 8 == 0, is_searched, "{mode}: {word:04X}h");
    }
    let mut bench = on_servo("s200", "servo_100w_hall");
    let answer = bench.sdo(NODE, [0x23, 0xF8, 0x38, 1, 2, 0, 0, 0]);
    assert_eq!(answer[0], 0x80, "it has no other source");
}

#[test]
fn ctune_finds_the_winding_of_the_motor() {
    let mut bench = s200();
    set(&mut bench, 0x3577, 1_200);
    bench.run(5);
    let mut bench = enabled(bench, 3);
    let from = rotor(&mut bench);
    set(&mut bench, 0x351E, 1);
    let mut moved = 0.0_f64;
    for _ in 0..600 {
        bench.run(10);
        moved = moved.max((rotor(&mut bench) - from).abs());
    }
    assert!(moved > 1_000.0, "it moves the rotor: {moved}");
    let inductance = get(&mut bench, 0x3577);
    assert!((720..=880).contains(&inductance), "{inductance} of 800 µH");
    let constant = get(&mut bench, 0x3593);
    assert!((76..=84).contains(&constant), "{constant} of 80 mNm/A");
}

/// The current 0.4 ms behind an order of another one, as a share of it.
fn rises(inductance: i32, gain: i32) -> f64 {
    let mut bench = s200();
    set(&mut bench, 0x3577, inductance);
    set(&mut bench, 0x3598, gain);
    let mut bench = held(bench, 0);
    torque(&mut bench, 900);
    for _ in 0..40 {
        // Until it begins, in steps of 0.1 ms.
        bench.tick();
        if current(&mut bench) > 0.02 {
            break;
        }
    }
    bench.tick();
    current(&mut bench) / (0.9 * RATED)
}

#[test]
fn the_inductance_of_the_s200_makes_its_voltage() {
    let (own, none) = (rises(800, 1_000), rises(100, 1_000));
    assert!((rises(0, 1_000) - own).abs() < 0.05);
    assert!(none < 0.7 * own, "{none}, {own}");
}

/// The share of a step of the current that has come a tenth of a millisecond behind its begin: across the magnet from and to these thousandths, or along it.
fn adapts(index: u16, step: Option<(i16, i16)>) -> f64 {
    let (from, to) = step.unwrap_or((1_000, 1_000));
    let n = usize::from(step.is_some());
    let mut bench = s200();
    set(&mut bench, index, 250);
    let mut bench = held(bench, from);
    let before = plant(&mut bench).current();
    if step.is_some() {
        torque(&mut bench, to);
    } else {
        set(&mut bench, 0x358F, 12_000);
        set(&mut bench, 0x35A5, 60);
    }
    for _ in 0..40 {
        bench.tick();
        if (plant(&mut bench).current()[n] - before[n]).abs() > 0.02 {
            break;
        }
    }
    bench.tick();
    let rises = plant(&mut bench).current()[n] - before[n];
    bench.run(50);
    rises / (plant(&mut bench).current()[n] - before[n])
}

#[test]
fn the_current_loop_of_the_s200_adapts_to_the_current() {
    // MLGQ at once.
    let (own, slow) = (rises(0, 1_000), rises(0, 300));
    assert!(slow < 0.8 * own, "{slow}, {own}");
    // DECDIS has nothing to do with it.
    const OTHER: u16 = 0x3523;
    // MLGC at the rated current, MLGP at the peak.
    for (index, step) in [(0x3595, (1_000, 1_300)), (0x3597, (2_600, 2_900))] {
        let (own, slow) = (adapts(OTHER, Some(step)), adapts(index, Some(step)));
        assert!(slow < 0.8 * own, "{index:04X}h: {slow}, {own}");
        let none = adapts(index, Some((0, 300)));
        let own = adapts(OTHER, Some((0, 300)));
        assert!(
            (none - own).abs() < 0.1,
            "{index:04X}h without a current: {none}, {own}"
        );
    }
    // MLGD along the magnet.
    let (own, slow) = (adapts(OTHER, None), adapts(0x3596, None));
    assert!(slow < 0.8 * own, "along: {slow}, {own}");
}

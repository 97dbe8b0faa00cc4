//! What the LMD does by its module: the inhibit input, filters, capture or trip, targets of set-points, reactions to faults of the motor.

use sim::plant::{Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, number, on, position, statusword, way};

/// A drive whose motor turns, with an input that is active from here on, and that is the inhibit input with this reaction.
fn inhibited(edge: i32, reaction: u8) -> Bench {
    let track = Track {
        negative_limit: Some(Switch::from(edge.into())),
        ..Track::default()
    };
    let mut bench = on("lmd", track);
    bench.write(NODE, 0x2002, 4, &[1]);
    bench.write(NODE, 0x2007, 1, &[reaction]);
    bench.write(NODE, 0x6060, 0, &[3]);
    number(&mut bench, 0x6084, 0, 1_000_000);
    number(&mut bench, 0x6085, 0, 1_000_000);
    bench.enable(NODE);
    number(&mut bench, 0x60FF, 0, 50_000);
    bench
}

/// Each reaction of 2007h stops the motor in its own state; 0 does nothing.
#[test]
fn the_inhibit_input_commands_the_lmd() {
    for (reaction, state) in [
        (0_u8, 0x27),
        (1, 0x08),
        (2, 0x08),
        (3, 0x40),
        (4, 0x40),
        (5, 0x40),
        (6, 0x40),
        (7, 0x21),
        (8, 0x21),
        (9, 0x23),
        (10, 0x23),
        (11, 0x27),
        (12, 0x27),
    ] {
        let mut bench = inhibited(20_000, reaction);
        bench.run(300);
        assert_eq!(statusword(&mut bench) & 0x6F, 0x27, "{reaction}");
        bench.run(2_000);
        let mask = if state & 0x20 == 0 { 0x4F } else { 0x6F };
        assert_eq!(statusword(&mut bench) & mask, state, "{reaction}");
        assert_eq!(way(&mut bench, 200) == 0, reaction != 0, "{reaction}");
    }
}

/// "Override" (even codes) counts while the input is active, "overwrite" stays in the controlword.
#[test]
fn overwrite_stays_and_override_does_not() {
    for (reaction, goes_on) in [(11_u8, false), (12, true)] {
        let mut bench = inhibited(20_000, reaction);
        bench.run(2_000);
        assert_eq!(way(&mut bench, 100), 0);
        let word = bench.read(NODE, 0x6040, 0) as u16;
        assert_eq!(word, if goes_on { 0x0F } else { 0x10F }, "{reaction}");
        // The input is taken away.
        bench.write(NODE, 0x2002, 4, &[0]);
        bench.run(500);
        assert_eq!(way(&mut bench, 100) != 0, goes_on, "{reaction}");
    }
}

/// The inhibit input and the switches wait for the longest filter of their groups, in ms.
#[test]
fn filters_of_the_lmd_hold_inputs_back() {
    let mut travelled = [0, 100].map(|time| {
        let mut bench = inhibited(20_000, 12);
        bench.write(NODE, 0x2004, 2, &[0b11]);
        bench.write(NODE, 0x2006, 2, &[time]);
        bench.run(3_000);
        position(&mut bench)
    });
    let late = travelled[1] - travelled[0];
    assert!(
        (4_500..=5_500).contains(&late),
        "100 ms at 50,000/s: {late}"
    );
    travelled = [0, 100].map(|time| {
        let limit = Track {
            positive_limit: Some(Switch::from(20_000)),
            ..Track::default()
        };
        let mut bench = on("lmd", limit);
        bench.write(NODE, 0x2002, 2, &[0b10]);
        bench.write(NODE, 0x2006, 2, &[time]);
        bench.write(NODE, 0x6060, 0, &[3]);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, 50_000);
        bench.run(3_000);
        position(&mut bench)
    });
    let late = travelled[1] - travelled[0];
    assert!((4_500..=5_500).contains(&late), "a limit switch: {late}");
}

/// 2034h: the motor waits so long after its bridge is on, and 2035h:2 longer still.
#[test]
fn the_lmd_waits_for_its_bridge() {
    for (settle, brake, waits) in [(0_u16, 0_u16, 0), (300, 0, 300), (200, 200, 400)] {
        let mut bench = Bench::node("lmd", NODE);
        bench.write(NODE, 0x2034, 1, &settle.to_le_bytes());
        bench.write(NODE, 0x2035, 2, &brake.to_le_bytes());
        bench.write(NODE, 0x6060, 0, &[3]);
        number(&mut bench, 0x60FF, 0, 50_000);
        command(&mut bench, 6);
        command(&mut bench, 0x0F);
        let mut time = 0;
        while position(&mut bench) == 0 && time < 1_000 {
            bench.run(10);
            time += 10;
        }
        assert!(
            (waits..waits + 90).contains(&(time + 50)),
            "{settle} and {brake}: {time}"
        );
    }
}

/// 2211h is the target that is carried out, 2212h that of the set-point behind it.
#[test]
fn the_lmd_shows_both_targets() {
    let mut bench = enabled("lmd", 1);
    let targets = |bench: &mut Bench| [0x2211, 0x2212].map(|index| bench.read(NODE, index, 0));
    begin(&mut bench, 20_000, 50_000, 1_000_000);
    bench.run(10);
    assert_eq!(targets(&mut bench), [20_000, 20_000]);
    number(&mut bench, 0x607A, 0, 5_000);
    command(&mut bench, 0x5F);
    bench.run(10);
    assert_eq!(targets(&mut bench), [20_000, 25_000], "it waits");
    command(&mut bench, 0x0F);
    bench.run(2_000);
    assert_eq!(targets(&mut bench), [25_000, 25_000]);
    assert_eq!(position(&mut bench), 25_000);
}

/// 2033h:2 tells that a position was captured, until it is cleared; a PDO carries the position.
#[test]
fn the_lmd_flags_a_captured_position() {
    let probe = Track {
        probes: [Some(Switch::from(7_000)), None],
        ..Track::default()
    };
    let mut bench = on("lmd", probe);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.write(NODE, 0x2033, 1, &[1]);
    // Bit 2 of 2031h makes it the trip output: nothing is captured.
    for (options, captures) in [(4_u8, 0), (0, 1)] {
        bench.write(NODE, 0x2031, 0, &[options]);
        begin(&mut bench, 10_000, 50_000, 1_000_000);
        bench.run(1_000);
        assert_eq!(bench.read(NODE, 0x2033, 2) as u8, captures, "{options}");
        begin(&mut bench, 0, 50_000, 1_000_000);
        bench.run(1_000);
    }
    let captured = bench.read(NODE, 0x2033, 4) as i32;
    assert!(captured.abs_diff(7_000) <= 60, "{captured}");
    number(&mut bench, 0x1803, 1, 0xC000_0484);
    bench.write(NODE, 0x1A03, 0, &[0]);
    number(&mut bench, 0x1A03, 1, 0x2033_0420);
    bench.write(NODE, 0x1A03, 0, &[1]);
    bench.write(NODE, 0x1803, 2, &[1]);
    number(&mut bench, 0x1803, 1, 0x4000_0484);
    bench.send(&canopen::Frame::data_frame(0, &[1, NODE]));
    bench.sent.clear();
    bench.send(&canopen::Frame::data_frame(0x080, &[]));
    let frame = bench.next(0x484, 20).expect("TPDO 4");
    assert_eq!(frame.payload(), captured.to_le_bytes());
    bench.write(NODE, 0x2033, 2, &[1]);
    assert_eq!(bench.read(NODE, 0x2033, 2) as u8, 0);
}

/// The trip output pulses at its first point and then at each spacing, as often as it is to: with the very pulse of the motor that comes there.
#[test]
fn the_trip_output_pulses_at_its_points() {
    for (control, first, spacing, points) in [
        (
            0x8003_u16,
            10_000_i32,
            5_000_i32,
            vec![10_000, 15_000, 20_000],
        ),
        (0x8000, 20_000, 10_000, vec![20_000, 30_000, 40_000]),
        (0x8001, 7_000, 0, vec![7_000]),
        (0x0003, 10_000, 5_000, vec![]),
    ] {
        let mut bench = enabled("lmd", 1);
        bench.write(NODE, 0x2031, 0, &[4]);
        bench.write(NODE, 0x2038, 2, &first.to_le_bytes());
        bench.write(NODE, 0x2038, 3, &spacing.to_le_bytes());
        bench.write(NODE, 0x2038, 1, &control.to_le_bytes());
        bench.drive.plant_mut().pulses_mut().record();
        begin(&mut bench, 45_000, 20_000, 1_000_000);
        let (mut pulses, mut was_high, mut high) = (0, false, 0);
        for _ in 0..30_000 {
            bench.tick();
            let is_high = bench.drive.plant_mut().outputs() & 0b100 != 0;
            pulses += usize::from(is_high && !was_high);
            high += usize::from(is_high);
            was_high = is_high;
        }
        assert_eq!(pulses, points.len(), "{control:04X}h");
        assert_eq!(high, pulses * 10, "a millisecond each");
        let plant = bench.drive.plant_mut();
        let times: Vec<_> = (points.iter())
            .map(|point| (*point, plant.pulses().recorded()[*point as usize - 1]))
            .collect();
        assert_eq!(plant.pulses().compared(), times, "{control:04X}h");
    }
}

/// The points count as positions do: from home, and the other way round with the motor.
#[test]
fn the_trip_output_counts_from_home() {
    for (polarity, sign) in [(0_u8, 1_i64), (0x80, -1)] {
        let mut bench = Bench::node("lmd", NODE);
        bench.write(NODE, 0x2030, 0, &[polarity]);
        number(&mut bench, 0x607C, 0, 700);
        bench.write(NODE, 0x6098, 0, &[35]);
        bench.write(NODE, 0x6060, 0, &[6]);
        bench.enable(NODE);
        command(&mut bench, 0x1F);
        bench.wait_for_status(NODE, 0x3400, 0x1400, 1_000);
        assert_eq!(position(&mut bench), -700);
        bench.write(NODE, 0x6060, 0, &[1]);
        command(&mut bench, 0x0F);
        bench.run(20);
        bench.write(NODE, 0x2031, 0, &[4]);
        number(&mut bench, 0x2038, 2, 4_000);
        number(&mut bench, 0x2038, 3, 1_000);
        bench.write(NODE, 0x2038, 1, &0x8002_u16.to_le_bytes());
        begin(&mut bench, 10_000, 50_000, 1_000_000);
        bench.run(1_000);
        let plant = bench.drive.plant_mut();
        assert_eq!(plant.position(), 10_700 * sign);
        let found: Vec<_> = (plant.pulses().compared().iter())
            .map(|(position, _)| i64::from(*position))
            .collect();
        assert_eq!(found, [4_700 * sign, 5_700 * sign]);
    }
}

/// Board and bridge have one sensor: a warning at 2018h:2, a fault at 2018h:3, and at 85 degrees whatever it says.
#[test]
fn the_board_of_the_lmd_is_watched() {
    for (warning, fault, temperature, is_fault) in [
        (60_u8, 120_u8, 650, false),
        (120, 60, 650, true),
        (120, 120, 840, false),
        (120, 120, 850, true),
    ] {
        let mut bench = enabled("lmd", 3);
        for (index, sub, value) in [
            (0x2018, 2, warning),
            (0x2018, 3, fault),
            (0x2019, 2, 120),
            (0x2019, 3, 120),
        ] {
            bench.write(NODE, index, sub, &[value]);
        }
        bench.sent.clear();
        bench.drive.plant_mut().temperature = temperature;
        let message = bench.next(0x84, 2_000);
        assert_eq!(
            message.is_some(),
            is_fault || warning == 60,
            "{temperature}"
        );
        if let Some(message) = message {
            let bytes = message.payload();
            assert_eq!(bytes[..2], [0x10, 0x42]);
            assert_eq!(bytes[6], if is_fault { 0x08 } else { 0x16 }, "{bytes:02X?}");
        }
        assert_eq!(bench.read(NODE, 0x2018, 1) as u8, (temperature / 10) as u8);
        assert_eq!(
            statusword(&mut bench) & 0x08 != 0,
            is_fault,
            "{temperature}"
        );
    }
}

/// 2712h: a following error is told by bit 13, disables the bridge, sends an emergency message, or is an error.
#[test]
fn following_errors_of_the_lmd_lead_to_what_is_chosen() {
    for (code, has_power, is_told, is_error) in [
        (0_u8, true, false, false),
        (2, false, false, false),
        (4, false, true, false),
        (5, false, true, true),
    ] {
        let mut bench = Bench::node("lmd", NODE);
        bench.drive.plant_mut().encoder = true;
        bench.write(NODE, 0x2712, 0, &[code]);
        number(&mut bench, 0x6065, 0, 1_000);
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        begin(&mut bench, 100_000, 20_000, 1_000_000);
        bench.run(500);
        bench.sent.clear();
        bench.drive.plant_mut().displace(-3_000);
        let message = bench.next(0x84, 500);
        assert_eq!(message.is_some(), is_told, "{code}");
        if let Some(message) = message {
            assert_eq!(message.payload()[..2], [0x01, 0xFF]);
        }
        bench.run(1_000);
        assert_eq!(bench.drive.plant_mut().is_energised(), has_power, "{code}");
        assert_eq!(statusword(&mut bench) & 0x08 != 0, is_error, "{code}");
    }
}

/// 2010h:3 filters the reading of the analogue input.
#[test]
fn the_analogue_filter_of_the_lmd_smooths_its_reading() {
    let after = [0_u8, 0x31].map(|level| {
        let mut bench = Bench::node("lmd", NODE);
        bench.write(NODE, 0x2010, 3, &[level]);
        bench.run(500);
        bench.drive.plant_mut().analogue = 4_000;
        bench.run(10);
        let soon = bench.read(NODE, 0x2010, 1) as u16;
        bench.run(1_000);
        [soon, bench.read(NODE, 0x2010, 1) as u16]
    });
    assert!(after[0][0] >= 3_990, "{after:?}");
    assert!(after[1][0] < 2_000, "{after:?}");
    assert!(after[0][1].abs_diff(after[1][1]) <= 3, "{after:?}");
}

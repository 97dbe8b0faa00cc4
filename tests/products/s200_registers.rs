//! Position registers, virtual inputs and outputs, latches at the zero pulse, the table of speeds, and the lock of the parameters of the S200.

use sim::plant::{Index, Switch, Track};

use crate::bench::Bench;
use crate::steer::{NODE, begin, command, enabled, enabled_on, number, on, position, way};

/// Counts in a second of so many turns a minute.
fn per_minute(turns: i32) -> i32 {
    turns * 65_536 / 60
}

fn is_near(value: i32, expected: i32) -> bool {
    value.abs_diff(expected) <= expected.unsigned_abs() / 50 + 2
}

/// Position registers turn on at their positions, before them with WPOSP, and stay on with WPOSX; 1002h shows the first six.
#[test]
fn position_registers_tell_where_the_motor_is() {
    let mut bench = enabled("s200", 1);
    for (register, place) in [(1, 10_000), (2, 20_000), (3, 20_000), (6, 30_000)] {
        number(&mut bench, 0x5108, register, place);
    }
    bench.write(NODE, 0x5109, 0, &0b10_0111_u16.to_le_bytes());
    number(&mut bench, 0x3640, 1, 0b100);
    number(&mut bench, 0x3641, 1, 0b10);
    bench.run(5);
    assert_eq!(bench.read(NODE, 0x363F, 1), 0b10_0111, "WPOSE");
    assert_eq!(bench.read(NODE, 0x3636, 1), 0b10_0111, "WPOS");
    for (target, state) in [
        (0, 0b00_0100),
        (15_000, 0b00_0101),
        (25_000, 0b00_0011),
        (35_000, 0b10_0011),
        (0, 0b00_0110),
    ] {
        begin(&mut bench, target, 100_000, 1_000_000);
        bench.run(1_500);
        assert_eq!(bench.read(NODE, 0x3643, 1), state, "POSRSTAT at {target}");
        let word = bench.read(NODE, 0x1002, 0);
        let shown = word >> 5 & 0x1F | (word >> 11 & 1) << 5;
        assert_eq!(shown, state, "1002h at {target}");
    }
    number(&mut bench, 0x3643, 1, 0);
    bench.run(5);
    assert_eq!(
        bench.read(NODE, 0x3643, 1),
        0b100,
        "the second is off again"
    );
}

/// IN5 starts a motion task, IN6 stops it; O3 compares as O1 does, O4 is a master's.
#[test]
fn virtual_inputs_and_outputs_do_what_their_modes_say() {
    let mut bench = enabled("s200", 1);
    for (index, value) in [(0x35BE, 60_000), (0x35BF, 30_000), (0x35B9, 1)] {
        number(&mut bench, index, 1, value);
    }
    number(&mut bench, 0x2082, 0, 250 << 16);
    for (index, value) in [
        (0x36F6, 16),
        (0x36F7, 250),
        (0x36F9, 22),
        (0x3726, 6),
        (0x3727, 10_000),
    ] {
        number(&mut bench, index, 1, value);
    }
    let output = |bench: &mut Bench, index| bench.read(NODE, index, 1);
    assert_eq!(output(&mut bench, 0x3725), 0);
    number(&mut bench, 0x36F5, 1, 1);
    bench.run(1_000);
    assert_eq!(bench.read(NODE, 0x2081, 0) as u16, 250);
    assert!(is_near(way(&mut bench, 500), 15_000));
    assert_eq!(output(&mut bench, 0x3725), 1, "O3");
    number(&mut bench, 0x36F8, 1, 1);
    bench.run(500);
    assert_eq!(way(&mut bench, 200), 0, "IN6 has stopped it");
    // Level alone starts nothing.
    number(&mut bench, 0x36F5, 1, 1);
    assert_eq!(way(&mut bench, 200), 0);
    number(&mut bench, 0x36F5, 1, 0);
    number(&mut bench, 0x36F5, 1, 1);
    assert!(way(&mut bench, 500) > 5_000);
    number(&mut bench, 0x3728, 1, 1);
    bench.run(20);
    assert_eq!(output(&mut bench, 0x3728), 1, "O4");
}

/// INxMODE 35: inputs choose a speed of the table; an entry without one is n15.
#[test]
fn inputs_choose_a_speed_of_a_table() {
    for (entry, expected) in [(20, 20), (0, 0)] {
        let wires = Track {
            negative_limit: Some(Switch::from(30_000)),
            ..Track::default()
        };
        let mut bench = on("s200", wires);
        number(&mut bench, 0x3562, 1, 35);
        number(&mut bench, 0x510A, 1, entry);
        number(&mut bench, 0x35B4, 1, 0);
        bench.enable(NODE);
        number(&mut bench, 0x60FF, 0, per_minute(60) as u32);
        bench.run(300);
        assert_eq!(bench.read(NODE, 0x2000, 0) >> 14 & 1, 0);
        assert!(is_near(way(&mut bench, 100), per_minute(60) / 10));
        bench.run(1_500);
        assert!(is_near(way(&mut bench, 1_000), per_minute(expected)));
        let warned = bench.read(NODE, 0x2000, 0) >> 14 & 1;
        assert_eq!(warned, u32::from(entry == 0), "n15");
    }
}

/// CmdSrc 1: the analogue input gives the velocity of mode 80h.
#[test]
fn cmdsrc_gives_the_velocity_to_the_analogue_input() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x35B4, 1, 0);
    number(&mut bench, 0x3629, 1, 100);
    bench.drive.plant_mut().analogue = 2_048;
    bench.enable(NODE);
    number(&mut bench, 0x60FF, 0, per_minute(20) as u32);
    for (source, turns) in [(0, 20), (1, 50), (0, 20)] {
        number(&mut bench, 0x3B43, 1, source);
        bench.run(1_500);
        assert!(is_near(way(&mut bench, 1_000), per_minute(turns)));
    }
}

/// EXTLATCH 1: the latches keep where the zero pulse was, and with 0 where their inputs changed.
#[test]
fn extlatch_chooses_what_the_latches_keep() {
    for (source, latched) in [(0, 30_000), (1, 45_000)] {
        let wires = Track {
            negative_limit: Some(Switch::from(30_000)),
            index: Some(Index::new(45_000, 1_000_000)),
            ..Track::default()
        };
        let mut bench = enabled_on("s200", 1, wires);
        number(&mut bench, 0x3562, 1, 26);
        number(&mut bench, 0x3681, 1, source);
        command(&mut bench, 0x0F);
        bench.run(20);
        begin(&mut bench, 60_000, 50_000, 1_000_000);
        bench.run(2_500);
        let kept = bench.read(NODE, 0x357C, 1) as i32;
        assert!(kept.abs_diff(latched) <= 200, "EXTLATCH {source}: {kept}");
    }
}

/// Writes DECDIS; 0, or the abort code.
fn decdis(bench: &mut Bench, value: u8) -> u32 {
    let answer = bench.sdo(NODE, [0x23, 0x23, 0x35, 1, value, 0, 0, 0]);
    match answer[0] {
        0x60 => 0,
        _ => u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]),
    }
}

/// PASSCNFG locks the parameters, beyond power-off too, until the same number is written again.
#[test]
fn passcnfg_locks_the_parameters() {
    let mut bench = Bench::node("s200", NODE);
    assert_eq!(decdis(&mut bench, 1), 0);
    number(&mut bench, 0x36D8, 1, 4_711);
    assert!(![0, 4_711].contains(&bench.read(NODE, 0x36D8, 1)));
    assert_eq!(decdis(&mut bench, 2), 0x0800_0022);
    number(&mut bench, 0x1010, 1, 0x6576_6173);
    bench.drive.power_cycle();
    bench.run(300);
    assert_eq!(decdis(&mut bench, 2), 0x0800_0022);
    assert_eq!(bench.read(NODE, 0x3523, 1), 1);
    let refused = bench.sdo(NODE, [0x23, 0xD8, 0x36, 1, 0x68, 0x12, 0, 0]);
    assert_eq!(refused[4..], [0x30, 0, 9, 6], "another number");
    number(&mut bench, 0x35EA, 1, 1); // a command
    number(&mut bench, 0x36D8, 1, 4_711);
    assert_eq!(decdis(&mut bench, 2), 0);
}

/// DRVCNFG2 bit 0: the option AS is fitted, and bit 13 of 1002h tells of its safety relay.
#[test]
fn drvcnfg2_fits_the_safety_relay() {
    let mut bench = Bench::node("s200", NODE);
    for bit in [0, 1, 0] {
        number(&mut bench, 0x36E4, 1, bit);
        bench.run(5);
        assert_eq!(bench.read(NODE, 0x1002, 0) >> 13 & 1, bit);
    }
}

/// SWCNFG says which of SWE1 and SWE2 count; 607Dh is the same two numbers.
#[test]
fn swcnfg_chooses_the_software_limits_that_count() {
    for (which, low, high) in [
        (3, -9_000, 9_000),
        (1, -9_000, 20_000),
        (2, -20_000, 9_000),
        (0, -20_000, 20_000),
    ] {
        let mut bench = enabled("s200", 1);
        number(&mut bench, 0x3604, 1, -9_000_i32 as u32);
        number(&mut bench, 0x607D, 2, 9_000);
        assert_eq!(bench.read(NODE, 0x607D, 1) as i32, -9_000);
        assert_eq!(bench.read(NODE, 0x3606, 1), 9_000);
        number(&mut bench, 0x3600, 1, which);
        for (target, end, warning) in [(20_000, high, 1 << 6), (-20_000, low, 1 << 5)] {
            begin(&mut bench, target, 100_000, 1_000_000);
            bench.run(1_500);
            assert_eq!(position(&mut bench), end, "SWCNFG {which}");
            let is_at_limit = end != target;
            let expected = if is_at_limit { warning } else { 0 };
            assert_eq!(bench.read(NODE, 0x2000, 0), expected, "SWCNFG {which}");
        }
    }
}

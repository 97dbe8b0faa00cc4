//! Touch probes over the bus: every latched position is the one at which its edge came, at any speed and in any motion.

use proptest::prelude::RngExt as _;
use sim::drive::Setup;
use sim::plant::{Axis, Index, Switch, Track};
use tests::DriveBench;

use crate::seeded::generator;

/// 60B8h for probe 1: on, both edges, the first of each.
const BOTH: u16 = 0x31;
/// Each edge, not only the first.
const CONTINUOUS: u16 = 0x02;

/// A drive on this track, in operation enabled.
fn enabled(track: Track) -> DriveBench {
    let axis = Axis {
        track,
        ..Axis::default()
    };
    let mut drive = DriveBench::with(
        Setup {
            axis: Some(axis),
            ..Setup::with_node_id(1, 4)
        },
        4,
    );
    drive.start();
    drive.run_millis(20);
    drive.write_u32(0x6083, 0, 5_000_000);
    drive.write_u32(0x6084, 0, 5_000_000);
    drive.enable();
    drive
}

fn probes(first: Switch, second: Switch) -> Track {
    Track {
        probes: [Some(first), Some(second)],
        ..Track::default()
    }
}

fn go(drive: &mut DriveBench, target: i32, speed: u32) {
    drive.write_u32(0x6081, 0, speed);
    drive.begin_move(target);
    drive.reaches_target(60_000);
}

/// 60BAh to 60BDh.
fn positions(drive: &mut DriveBench) -> [i32; 4] {
    [0x60BA, 0x60BB, 0x60BC, 0x60BD].map(|index| drive.read_i32(index, 0))
}

/// 60D5h to 60D8h.
fn counters(drive: &mut DriveBench) -> [u16; 4] {
    [0x60D5, 0x60D6, 0x60D7, 0x60D8].map(|index| drive.read_u16(index, 0))
}

#[test]
fn m70_positions_are_exact_at_500_000_increments_per_second() {
    let mut drive = enabled(probes(
        Switch::within(123_457..=130_001),
        Switch::from(200_003),
    ));
    drive.write_u16(0x60B8, 0, BOTH | BOTH << 8);
    drive.run_millis(5);
    assert_eq!(drive.read_u16(0x60B9, 0), 0x0101);
    go(&mut drive, 400_000, 500_000);
    assert_eq!(drive.read_u16(0x60B9, 0), 0x0307);
    assert_eq!(positions(&mut drive), [123_457, 130_002, 200_003, 0]);
    assert_eq!(counters(&mut drive), [1, 1, 1, 0]);
    // 2 microseconds a step.
    let times = [0x60D1, 0x60D2, 0x60D3].map(|index| drive.read_u32(index, 0));
    let steps = (times[1] - times[0], times[2] - times[0]);
    assert!(
        steps.0.abs_diff((130_002 - 123_457) * 2_000) <= 100,
        "{steps:?}"
    );
    assert!(
        steps.1.abs_diff((200_003 - 123_457) * 2_000) <= 100,
        "{steps:?}"
    );
}

#[test]
fn m70_the_way_back_has_the_other_edges() {
    let mut drive = enabled(probes(
        Switch::within(1_000..=2_000),
        Switch::within(1_500..=3_000),
    ));
    drive.write_u16(0x60B8, 0, (BOTH | CONTINUOUS) << 8 | BOTH);
    go(&mut drive, 5_000, 50_000);
    assert_eq!(positions(&mut drive), [1_000, 2_001, 1_500, 3_001]);
    go(&mut drive, 0, 50_000);
    assert_eq!(
        positions(&mut drive),
        [1_000, 2_001, 3_000, 1_499],
        "probe 1 keeps the first, probe 2 the last"
    );
    assert_eq!(counters(&mut drive), [2, 2, 2, 2]);
    // Switched off and on it takes the next.
    drive.write_u16(0x60B8, 0, 0);
    drive.write_u16(0x60B8, 0, BOTH);
    drive.run_millis(5);
    assert_eq!(drive.read_u16(0x60B9, 0), 0x0001);
    go(&mut drive, 1_800, 50_000);
    go(&mut drive, 0, 50_000);
    assert_eq!(drive.read_u16(0x60B9, 0), 0x0007);
    assert_eq!(positions(&mut drive)[..2], [1_000, 999]);
}

#[test]
fn m70_the_source_may_be_the_index_pulse_or_any_input() {
    let track = Track {
        home: Some(Switch::within(700..=800)),
        index: Some(Index {
            first: 400,
            distance: 3_200,
            width: 1,
        }),
        ..probes(Switch::from(100_000), Switch::from(100_000))
    };
    let mut drive = enabled(track);
    // Index pulses are on input 4.
    drive.write_u8(0x2031, 4, 4);
    drive.write_u16(0x60B8, 0, BOTH | 0b01 << 2);
    drive.run_millis(5);
    go(&mut drive, 1_000, 50_000);
    assert_eq!(positions(&mut drive)[..2], [400, 401]);
    // 60D0h: the home switch, input 3.
    drive.write_i16(0x60D0, 1, -3);
    drive.write_u16(0x60B8, 0, BOTH | 0b10 << 2);
    drive.run_millis(5);
    assert_eq!(
        drive.read_u16(0x60B9, 0),
        0x0001,
        "another source begins anew"
    );
    go(&mut drive, 0, 50_000);
    assert_eq!(positions(&mut drive)[..2], [800, 699]);
}

#[test]
fn m70_a_probe_works_while_homing_uses_its_own_capture() {
    let track = Track {
        negative_limit: Some(Switch::up_to(-20_000)),
        ..probes(Switch::within(-12_345..=-10_000), Switch::up_to(-20_000))
    };
    let mut drive = enabled(track);
    drive.write_u8(0x6060, 0, 6);
    drive.write_u8(0x6098, 0, 17);
    drive.write_u32(0x6099, 1, 100_000);
    drive.write_u32(0x6099, 2, 1_000);
    drive.write_u32(0x609A, 0, 1_000_000);
    drive.write_i32(0x607C, 0, 77);
    drive.write_u16(0x60B8, 0, BOTH | BOTH << 8);
    drive.run_millis(5);
    drive.command(0x1F);
    for _ in 0..30_000 {
        drive.run_millis(1);
        if drive.statusword() & 0x1400 == 0x1400 {
            break;
        }
    }
    assert_eq!(drive.statusword() & 0x3400, 0x1400, "homing attained");
    let shown = drive.read_i32(0x6064, 0);
    let rotor = drive.axis().plant().rotor();
    assert_eq!(i64::from(shown) - rotor, 20_000 + 77, "home is the edge");
    // As they counted when the edges came; the last one is the edge that homing found.
    assert_eq!(positions(&mut drive)[..3], [-10_000, -12_346, -20_000]);
}

#[test]
fn m70_positions_are_in_units_of_the_user() {
    let mut drive = DriveBench::with(
        Setup {
            axis: Some(Axis {
                track: probes(Switch::from(10_000), Switch::from(20_000)),
                ..Axis::default()
            }),
            ..Setup::with_node_id(1, 4)
        },
        4,
    );
    drive.start();
    drive.run_millis(20);
    // 4 units an increment.
    let increments = drive.read_u32(0x608F, 1);
    drive.write_u32(0x6092, 1, 4 * increments);
    drive.write_u16(0x60B8, 0, BOTH);
    drive.enable();
    go(&mut drive, 60_000, 50_000);
    assert_eq!(positions(&mut drive)[0], 40_000);
}

#[test]
fn m70_what_is_stored_is_shown_in_the_units_of_now() {
    let mut drive = enabled(probes(Switch::from(12_340), Switch::from(90_000)));
    drive.write_u16(0x60B8, 0, BOTH);
    go(&mut drive, 20_000, 50_000);
    assert_eq!(positions(&mut drive), [12_340, 0, 0, 0]);
    drive.command(0x00);
    drive.run_millis(20);
    // Ten of the 3200 steps of a turn are a unit.
    drive.write_u32(0x6092, 1, 320);
    drive.run_millis(5);
    assert_eq!(drive.read_i32(0x6064, 0), 2_000);
    assert_eq!(positions(&mut drive), [1_234, 0, 0, 0]);
    drive.write_u8(0x607E, 0, 0x80);
    drive.run_millis(5);
    assert_eq!(positions(&mut drive), [-1_234, 0, 0, 0]);
    drive.write_i32(0x607B, 1, 0);
    drive.write_i32(0x607B, 2, 999);
    drive.run_millis(5);
    assert_eq!(positions(&mut drive), [766, 0, 0, 0]);
}

#[test]
fn m70_every_latched_position_is_true_in_random_motion() {
    let mut random = generator(70);
    for _ in 0..6 {
        let edge = random.random_range(-30_000..30_000_i64);
        let width = random.random_range(1..8_000_i64);
        let other = random.random_range(-40_000..40_000_i64);
        let mut drive = enabled(probes(
            Switch::within(edge..=edge + width),
            Switch::from(other),
        ));
        drive.write_u16(0x60B8, 0, BOTH | CONTINUOUS | (BOTH | CONTINUOUS) << 8);
        drive.run_millis(5);
        let (mut from, mut expected, mut count) = (0_i64, [0; 4], [0_u16; 4]);
        // Where the motor starts, the switches may be active already.
        for _ in 0..6 {
            let to = random.random_range(-50_000..50_000_i64);
            let speed = random.random_range(1_000..500_000_u32).max(20_000);
            go(&mut drive, i32::try_from(to).unwrap(), speed);
            let way = to > from;
            // Passing this boundary upwards is an edge at it, downwards at the step below.
            let mut note = |boundary: i64, rises_upwards: bool, probe: usize| {
                let crosses = if way {
                    from < boundary && boundary <= to
                } else {
                    to < boundary && boundary <= from
                };
                if crosses {
                    let kind = probe * 2 + usize::from(rises_upwards != way);
                    expected[kind] = if way { boundary } else { boundary - 1 } as i32;
                    count[kind] += 1;
                }
            };
            note(edge, true, 0);
            note(edge + width + 1, false, 0);
            note(other, true, 1);
            assert_eq!(positions(&mut drive), expected, "{from} to {to} at {speed}");
            assert_eq!(counters(&mut drive), count, "{from} to {to} at {speed}");
            from = to;
        }
    }
}

#[test]
fn a_reserved_source_is_refused() {
    let mut drive = DriveBench::started(4);
    for function in [0x000C_u16, 0x0C00, 0x0D31] {
        let refused = drive.try_write(0x60B8, 0, &function.to_le_bytes());
        assert_eq!(refused, Err(0x0609_0030), "{function:04X}h");
    }
    drive.write_u16(0x60B8, 0, 0xC0C0);
    assert_eq!(drive.read_u16(0x60B8, 0), 0xC0C0, "the user's bits");
    for source in [0_i16, 3, 4] {
        let refused = drive.try_write(0x60D0, 1, &source.to_le_bytes());
        assert_eq!(refused, Err(0x0609_0030), "{source}");
    }
    assert_eq!(
        drive.try_write(0x60D0, 2, &6_i16.to_le_bytes()),
        Err(0x0609_0031)
    );
}

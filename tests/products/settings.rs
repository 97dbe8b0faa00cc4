//! What the manuals promise of node-ID, bit rate and serial number: by LSS, by objects, by switches.

use canopen::settings::{Field, Switches};
use canopen::{BitRate, BitTiming, Configuration, Frame, NodeId};
use sim::drive::Setup;

use crate::bench::Bench;
use crate::promises::booted;
use crate::steer::NODE;

/// The answer of LSS; `None` if there is none.
fn lss(bench: &mut Bench, request: [u8; 8]) -> Option<[u8; 8]> {
    bench.sent.clear();
    bench.send(&Frame::full(0x7E5, request));
    let answer = bench.next(0x7E4, 50)?;
    answer.full_payload().copied()
}

/// A number in an object, with as many bytes as this.
fn set(bench: &mut Bench, (index, sub): (u16, u8), value: &[u8]) -> u32 {
    let [low, high] = index.to_le_bytes();
    let mut request = [
        0x23 | (4 - value.len() as u8) << 2,
        low,
        high,
        sub,
        0,
        0,
        0,
        0,
    ];
    request[4..4 + value.len()].copy_from_slice(value);
    match bench.sdo(NODE, request) {
        [0x60, ..] => 0,
        [_, _, _, _, a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
    }
}

/// What LSS has stored is in force when the power comes back.
fn keeps_what_lss_has_stored(name: &str) {
    let mut bench = booted(name);
    lss(&mut bench, [0x04, 1, 0, 0, 0, 0, 0, 0]);
    for request in [
        [0x11, 9, 0, 0, 0, 0, 0, 0],
        [0x13, 0, 2, 0, 0, 0, 0, 0],
        [0x17, 0, 0, 0, 0, 0, 0, 0],
    ] {
        let answer = lss(&mut bench, request).expect("an answer");
        assert_eq!(answer[..2], [request[0], 0], "{name}");
    }
    bench.drive.power_cycle();
    bench.run(50);
    assert_eq!(bench.drive.node_id().get(), 9, "{name}");
    let rate = bench.drive.bit_rate().map(BitRate::kbit_per_second);
    assert_eq!(rate, Some(500), "{name}");
}

/// The four numbers of 1018h, and the node-ID.
fn tells_lss_who_it_is(name: &str) {
    let mut bench = booted(name);
    let numbers: Vec<u32> = (1..=4).map(|sub| bench.read(NODE, 0x1018, sub)).collect();
    lss(&mut bench, [0x04, 1, 0, 0, 0, 0, 0, 0]);
    for (command, number) in (0x5A..).zip(numbers) {
        let [_, a, b, c, d, ..] = lss(&mut bench, [command, 0, 0, 0, 0, 0, 0, 0]).unwrap();
        assert_eq!(u32::from_le_bytes([a, b, c, d]), number, "{name}");
    }
    let answer = lss(&mut bench, [0x5E, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    assert_eq!(answer[1], NODE, "{name}");
}

/// Index 5 of LSS, 100 kbit/s, is in force at once, and when the power comes back; another maker's drive refuses it.
#[test]
fn the_lmd_runs_at_100_kbit() {
    for (name, refused) in [("lmd", 0), ("tc1", 1)] {
        let mut bench = booted(name);
        lss(&mut bench, [0x04, 1, 0, 0, 0, 0, 0, 0]);
        let answer = lss(&mut bench, [0x13, 0, 5, 0, 0, 0, 0, 0]).expect("an answer");
        assert_eq!(answer[..2], [0x13, refused], "{name}");
    }
    let mut bench = booted("lmd");
    let rate = |bench: &Bench| bench.drive.bit_rate().map(BitRate::kbit_per_second);
    lss(&mut bench, [0x04, 1, 0, 0, 0, 0, 0, 0]);
    lss(&mut bench, [0x13, 0, 5, 0, 0, 0, 0, 0]);
    let stored = lss(&mut bench, [0x17, 0, 0, 0, 0, 0, 0, 0]).expect("an answer");
    assert_eq!(stored[..2], [0x17, 0]);
    bench.send(&Frame::full(0x7E5, [0x15, 1, 0, 0, 0, 0, 0, 0]));
    bench.run(50);
    assert_eq!(rate(&bench), Some(100));
    bench.drive.power_cycle();
    bench.run(50);
    assert_eq!(rate(&bench), Some(100));
}

/// Node-ID and bit rate are objects: they show what is stored, a write is stored at once, and restored defaults leave them alone.
#[test]
fn node_id_and_bit_rate_are_objects_of_their_makers() {
    for (name, node, (at_1000, rate, kbit), refused) in [
        (
            "nanotec",
            Some(((0x2009_u16, 0_u8), 1_usize)),
            (135_u32, 134_u32, 500),
            0,
        ),
        ("lmd", Some(((0x2510, 1), 4)), (0, 5, 100), 9),
        ("s200", None, (1_000, 250, 250), 300),
    ] {
        let (object, size) = match name {
            "nanotec" => ((0x2005, 0), 1_usize),
            "lmd" => ((0x2510, 2), 4),
            _ => ((0x3A49, 1), 4),
        };
        let mut bench = booted(name);
        let bytes = |number: u32| number.to_le_bytes()[..size].to_vec();
        assert_eq!(bench.read(NODE, object.0, object.1), at_1000, "{name}");
        assert_ne!(set(&mut bench, object, &bytes(refused)), 0, "{name}");
        // What is stored of the parameters changes nothing of the settings, and they are not touched while the motor has power.
        bench.write(NODE, 0x1010, 1, b"save");
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        let powered = set(&mut bench, object, &bytes(rate));
        assert_eq!(powered, 0x0800_0022, "{name}");
        bench.write(NODE, 0x6040, 0, &[0, 0]);
        bench.run(100);
        assert_eq!(set(&mut bench, object, &bytes(rate)), 0, "{name}");
        if let Some(((index, sub), size)) = node {
            assert_eq!(bench.read(NODE, index, sub), u32::from(NODE), "{name}");
            let value = &33_u32.to_le_bytes()[..size];
            assert_eq!(set(&mut bench, (index, sub), value), 0, "{name}");
        }
        if name == "lmd" {
            bench.write(NODE, 0x1011, 1, b"load");
        }
        bench.drive.power_cycle();
        bench.run(100);
        let own = if node.is_some() { 33 } else { NODE };
        assert_eq!(bench.drive.node_id().get(), own, "{name}");
        let in_force = bench.drive.bit_rate().map(BitRate::kbit_per_second);
        assert_eq!(in_force, Some(kbit), "{name}");
        assert_eq!(bench.read(own, object.0, object.1), rate, "{name}");
    }
}

/// The serial number of an LMD, at which LSS selects it, is in 5002h too.
#[test]
fn the_lmd_has_its_serial_number_twice() {
    let mut bench = Bench::new("lmd", Setup::with_node_id(0x0123_4567, NODE));
    for index in [(0x1018, 4), (0x5002, 1)] {
        assert_eq!(bench.read(NODE, index.0, index.1), 0x0123_4567);
    }
    for (command, sub) in (0x40..=0x43).zip(1..=4) {
        let [a, b, c, d] = bench.read(NODE, 0x1018, sub).to_le_bytes();
        bench.send(&Frame::full(0x7E5, [command, a, b, c, d, 0, 0, 0]));
    }
    assert_eq!(
        bench.next(0x7E4, 50).map(|frame| frame.payload()[0]),
        Some(0x44)
    );
}

/// Each bit rate of the S200 is the one in force if it is the one that is set.
#[test]
fn the_s200_runs_at_each_of_its_bit_rates() {
    for bit_rate in [
        BitRate::Kbit125,
        BitRate::Kbit250,
        BitRate::Kbit500,
        BitRate::Kbit1000,
    ] {
        let mut setup = Setup::with_node_id(1, NODE);
        setup.settings = setup.settings.map(|settings| Configuration {
            bit_timing: BitTiming::Fixed(bit_rate),
            ..settings
        });
        let mut bench = Bench::new("s200", setup);
        assert_eq!(bench.drive.bit_rate(), Some(bit_rate));
        assert!(bench.next(0x704, 50).is_some());
    }
}

/// Two switches of the S200 are its node-ID; where they stand at none, it is 1.
#[test]
fn the_switches_of_the_s200_are_its_node_id() {
    const SWITCHES: Switches = Switches::new(7, &[Field::Stored]);
    for (position, node) in [(1, 1), (77, 77), (127, 127), (0, 1), (0x80, 1)] {
        let mut setup = Setup::unconfigured(1);
        setup.switches = SWITCHES.wish(position);
        let bench = Bench::new("s200", setup);
        assert_eq!(Some(bench.drive.node_id()), NodeId::new(node), "{position}");
        assert_eq!(bench.drive.bit_rate(), Some(BitRate::Kbit500));
    }
}

/// The one switch of a PD4-N: 1 to 7 are node-IDs at 1 Mbit/s, from 8 on the bit rate is the stored one.
#[test]
fn the_single_switch_of_a_nanotec_is_its_node_id() {
    for (position, node, kbit) in [(1, 1, 1_000), (7, 7, 1_000), (0x9, 1, 250), (0xF, 7, 250)] {
        let mut setup = Setup::with_node_id(1, 33);
        setup.settings = setup.settings.map(|settings| Configuration {
            bit_timing: BitTiming::Fixed(BitRate::Kbit250),
            ..settings
        });
        setup.switches = Switches::SINGLE_ROTARY_REVERSED.wish(position);
        let bench = Bench::new("nanotec", setup);
        assert_eq!(bench.drive.node_id().get(), node, "{position:X}h");
        let rate = bench.drive.bit_rate().map(BitRate::kbit_per_second);
        assert_eq!(rate, Some(kbit), "{position:X}h");
    }
}

mod each {
    promises! {
        keeps_what_lss_has_stored: lmd tc1;
        tells_lss_who_it_is: lmd tc1;
    }
}

/// 1013h of the TC1 counts microseconds, and goes on from what a master writes.
#[test]
fn the_time_stamp_of_the_tc1_counts_microseconds() {
    let mut bench = Bench::node("tc1", NODE);
    let before = bench.read(NODE, 0x1013, 0);
    bench.run(1_000);
    let passed = bench.read(NODE, 0x1013, 0) - before;
    assert!((1_000_000..1_010_000).contains(&passed), "{passed}");
    bench.write(NODE, 0x1013, 0, &500_u32.to_le_bytes());
    bench.run(10);
    let passed = bench.read(NODE, 0x1013, 0) - 500;
    assert!((10_000..20_000).contains(&passed), "{passed}");
}

//! What the manuals promise of the bus beyond services: node-ID and bit rate, identifiers, SYNC, boot-up, texts.

use canopen::settings::{Field, Switches};
use canopen::{BitRate, BitTiming, Configuration, Frame, NodeId};
use embedded_can::ExtendedId;
use sim::drive::Setup;

use crate::bench::Bench;
use crate::promises::{
    booted, count, emergencies, nmt, operational, refusal, with_type, write_byte,
};

const NODE: u8 = 4;

/// The answer of LSS; `None` if there is none.
fn lss(bench: &mut Bench, request: [u8; 8]) -> Option<[u8; 8]> {
    bench.sent.clear();
    bench.send(&Frame::full(0x7E5, request));
    let answer = bench.next(0x7E4, 50)?;
    answer.full_payload().copied()
}

fn controlword(bench: &mut Bench) -> u16 {
    bench.read(NODE, 0x6040, 0) as u16
}

fn sync(bench: &mut Bench) {
    bench.send(&Frame::data_frame(0x080, &[]));
    bench.run(5);
}

/// A text, in one frame or in segments.
fn text(bench: &mut Bench, index: u16) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let answer = bench.sdo(NODE, [0x40, low, high, 0, 0, 0, 0, 0]);
    if answer[0] & 2 != 0 {
        let unused = usize::from(answer[0] >> 2 & 3);
        return answer[4..8 - unused].to_vec();
    }
    assert_eq!(answer[0] & 0xE0, 0x40, "{index:04X}h: {answer:02X?}");
    let mut text = Vec::new();
    let mut toggle = 0;
    loop {
        let [command, bytes @ ..] = bench.sdo(NODE, [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        text.extend(&bytes[..7 - usize::from(command >> 1 & 7)]);
        if command & 1 != 0 {
            return text;
        }
        toggle ^= 0x10;
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
        assert_eq!(set(&mut bench, object, &bytes(rate)), 0, "{name}");
        if let Some(((index, sub), size)) = node {
            assert_eq!(bench.read(NODE, index, sub), u32::from(NODE), "{name}");
            let value = &33_u32.to_le_bytes()[..size];
            assert_eq!(set(&mut bench, (index, sub), value), 0, "{name}");
        }
        bench.write(NODE, 0x1011, 1, b"load");
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

/// Identifiers of PDOs can be others, and stay so once they are stored.
fn keeps_its_identifiers(name: &str) {
    let mut bench = booted(name);
    for cob_id in [0x8000_0211_u32, 0x0000_0211] {
        bench.write(NODE, 0x1400, 1, &cob_id.to_le_bytes());
    }
    for cob_id in [0xC000_0191_u32, 0x4000_0191] {
        bench.write(NODE, 0x1800, 1, &cob_id.to_le_bytes());
    }
    bench.write(NODE, 0x1010, 1, b"save");
    nmt(&mut bench, 129);
    bench.run(200);
    assert_eq!(bench.read(NODE, 0x1400, 1) & 0x7FF, 0x211, "{name}");
    bench.sent.clear();
    nmt(&mut bench, 1);
    assert!(bench.next(0x191, 200).is_some(), "{name}");
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    bench.run(20);
    assert_eq!(controlword(&mut bench), 0, "{name}: the old one");
    bench.send(&Frame::data_frame(0x211, &[6, 0]));
    bench.run(20);
    assert_eq!(controlword(&mut bench), 6, "{name}");
}

/// Identifiers of 29 bits are somebody else's.
fn hears_base_frames_only(name: &str) {
    let mut bench = booted(name);
    let request = [0x40, 0x00, 0x10, 0, 0, 0, 0, 0];
    let id = ExtendedId::new(0x604).unwrap();
    let extended = <Frame as embedded_can::Frame>::new(id, &request).unwrap();
    bench.sent.clear();
    bench.send(&extended);
    assert_eq!(count(&mut bench, 0x584, 50), 0, "{name}");
    bench.send(&Frame::full(0x604, request));
    assert!(bench.next(0x584, 50).is_some(), "{name}");
}

/// Nothing leaves before the boot-up message, whatever is asked meanwhile.
fn is_silent_until_it_has_booted(name: &str) {
    let mut bench = operational(name);
    bench.sent.clear();
    bench.send(&Frame::data_frame(0, &[129, NODE]));
    bench.send(&Frame::full(0x604, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
    bench.run(100);
    let first = bench.sent.front().expect("a frame");
    assert_eq!(first.standard_id(), Some(0x704), "{name}");
    assert_eq!(first.payload(), [0], "{name}");
    // So is it after a cold start.
    bench.sent.clear();
    bench.drive.power_cycle();
    bench.run(100);
    let first = bench.sent.front().expect("a frame");
    assert_eq!(
        (first.standard_id(), first.payload()),
        (Some(0x704), &[0][..])
    );
}

/// The first heartbeat comes one period behind the boot-up message.
fn counts_its_boot_up_as_a_heartbeat(name: &str) {
    let mut bench = booted(name);
    bench.write(NODE, 0x1017, 0, &[200, 0]);
    bench.write(NODE, 0x1010, 1, b"save");
    bench.sent.clear();
    bench.send(&Frame::data_frame(0, &[129, NODE]));
    let boot_up = bench.next(0x704, 500).expect("a boot-up message");
    assert_eq!(boot_up.payload(), [0], "{name}");
    assert_eq!(count(&mut bench, 0x704, 190), 0, "{name}");
    let heartbeat = bench.next(0x704, 20).expect("a heartbeat");
    assert_eq!(heartbeat.payload(), [127], "{name}");
}

/// Neither multiplexed PDOs, nor a deadline of receive PDOs, nor a first SYNC.
fn has_plain_pdos(name: &str) {
    let mut bench = booted(name);
    bench.write(NODE, 0x1400, 1, &0x8000_0204_u32.to_le_bytes());
    for number in [254, 255] {
        assert_ne!(write_byte(&mut bench, 0x1600, 0, number), 0, "{name}");
    }
    assert_eq!(write_byte(&mut bench, 0x1600, 0, 0), 0, "{name}");
    for (index, sub) in [(0x1400, 3), (0x1400, 5), (0x1800, 6)] {
        assert_eq!(refusal(&mut bench, index, sub), Some(0x0609_0011), "{name}");
    }
}

/// The counters of the SYNCs that the drive sends in so many milliseconds; 0 is one without.
fn counters(bench: &mut Bench, milliseconds: u32) -> Vec<u8> {
    bench.sent.clear();
    bench.run(milliseconds);
    let own = |frame: &Frame| {
        (frame.standard_id() == Some(0x080))
            .then(|| frame.payload().first().copied().unwrap_or_default())
    };
    bench
        .sent
        .drain(..)
        .filter_map(|frame| own(&frame))
        .collect()
}

/// SYNC comes with the period 1006h, and a counter up to 1019h; behind Stopped it begins anew. A period of 0 is none.
fn makes_sync(name: &str) {
    let mut bench = booted(name);
    for number in [1, 241] {
        assert_ne!(
            write_byte(&mut bench, 0x1019, 0, number),
            0,
            "{name}: {number}"
        );
    }
    for number in [2, 240, 0, 5] {
        assert_eq!(
            write_byte(&mut bench, 0x1019, 0, number),
            0,
            "{name}: {number}"
        );
    }
    // The longest that it takes.
    bench.write(NODE, 0x1006, 0, &240_u32.to_le_bytes());
    bench.write(NODE, 0x1005, 0, &0x4000_0080_u32.to_le_bytes());
    let first = counters(&mut bench, 24);
    assert!((98..=102).contains(&first.len()), "{name}: {first:?}");
    for pair in first.windows(2) {
        assert_eq!(pair[1], pair[0] % 5 + 1, "{name}: {first:?}");
    }
    bench.run(20);
    nmt(&mut bench, 2);
    assert_eq!(counters(&mut bench, 100), [0_u8; 0], "{name}: stopped");
    bench.sent.clear();
    bench.send(&Frame::data_frame(0, &[128, NODE]));
    let sync = bench.next(0x080, 50).expect("a SYNC");
    assert_eq!(sync.payload(), [1], "{name}");
    bench.write(NODE, 0x1006, 0, &0_u32.to_le_bytes());
    assert_eq!(counters(&mut bench, 100), [0_u8; 0], "{name}: no period");
}

/// What has gone wrong in Stopped is told when the drive leaves it.
fn tells_behind_stopped(name: &str) {
    let mut bench = booted(name);
    bench.write(NODE, 0x1016, 1, &0x0005_0032_u32.to_le_bytes());
    bench.send(&Frame::data_frame(0x705, &[5]));
    nmt(&mut bench, 2);
    bench.sent.clear();
    bench.run(200);
    assert_eq!(emergencies(&mut bench), [], "{name}: stopped");
    nmt(&mut bench, 128);
    bench.run(50);
    let told = emergencies(&mut bench);
    assert_eq!(told.first().map(|(code, _)| *code), Some(0x8130), "{name}");
}

/// The name is a printable text, and so are the versions that a manual tells.
fn has_texts(name: &str) {
    let mut bench = booted(name);
    let last = if name == "tc1" { 0x1008 } else { 0x100A };
    for index in 0x1008..=last {
        let text = text(&mut bench, index);
        assert!(!text.is_empty(), "{name}: {index:04X}h");
        let is_fine = |letter: &u8| (0x20..=0x7E).contains(letter);
        assert!(text.iter().all(is_fine), "{name}: {text:02X?}");
    }
}

/// Emergency messages have the identifier 1014h.
fn tells_with_another_identifier(name: &str) {
    let mut bench = booted(name);
    for cob_id in [0x8000_0084_u32, 0x0000_01F0] {
        bench.write(NODE, 0x1014, 0, &cob_id.to_le_bytes());
    }
    bench.sent.clear();
    bench.drive.plant_mut().fault = Some(0x4210);
    assert!(bench.next(0x1F0, 100).is_some(), "{name}");
    assert_eq!(count(&mut bench, 0x084, 100), 0, "{name}");
}

/// A PDO of type 0 comes with the first SYNC behind an event, once.
fn sends_once_behind_an_event(name: &str) {
    let mut bench = with_type(name, 0);
    let came = |bench: &mut Bench| {
        bench.sent.clear();
        sync(bench);
        let own = |frame: &&Frame| frame.standard_id() == Some(0x184);
        bench.sent.iter().filter(own).count()
    };
    came(&mut bench);
    bench.run(20);
    assert_eq!(came(&mut bench), 0, "{name}: nothing has changed");
    bench.write(NODE, 0x6040, 0, &[6, 0]);
    bench.sent.clear();
    bench.run(50);
    let own = |frame: &&Frame| frame.standard_id() == Some(0x184);
    let early = bench.sent.iter().filter(own).count();
    assert_eq!(early, 0, "{name}: not without SYNC");
    assert_eq!(came(&mut bench), 1, "{name}");
    assert_eq!(came(&mut bench), 0, "{name}");
}

/// A receive PDO of type N counts at the Nth SYNC of an S200, and at the next one of a TC1.
#[test]
fn the_s200_takes_a_receive_pdo_with_the_third_sync() {
    for (name, expected) in [("s200", [0, 0, 6]), ("tc1", [6, 6, 6])] {
        let mut bench = booted(name);
        bench.write(NODE, 0x1400, 1, &0x8000_0204_u32.to_le_bytes());
        bench.write(NODE, 0x1400, 2, &[3]);
        bench.write(NODE, 0x1400, 1, &0x0000_0204_u32.to_le_bytes());
        nmt(&mut bench, 1);
        bench.send(&Frame::data_frame(0x204, &[6, 0]));
        let seen = expected.map(|_| {
            sync(&mut bench);
            controlword(&mut bench)
        });
        assert_eq!(seen, expected, "{name}");
    }
}

/// A Nanotec tells each new state as a heartbeat does; a TC1 without a heartbeat is silent.
#[test]
fn the_nanotec_tells_its_state_behind_a_command() {
    for (name, expected) in [("nanotec", vec![5, 4, 127]), ("tc1", vec![])] {
        let mut bench = booted(name);
        bench.sent.clear();
        for command in [1, 2, 128] {
            bench.send(&Frame::data_frame(0, &[command, NODE]));
            bench.run(20);
        }
        let own = |frame: &Frame| frame.standard_id() == Some(0x704);
        let states: Vec<u8> = bench
            .sent
            .drain(..)
            .filter(own)
            .map(|frame| frame.payload()[0])
            .collect();
        assert_eq!(states, expected, "{name}");
    }
}

/// A Nanotec makes no SYNC, and its emergencies keep their identifier.
#[test]
fn the_nanotec_makes_no_sync_and_keeps_the_identifier_of_its_errors() {
    let mut bench = booted("nanotec");
    let [a, b, c, d] = 0x4000_0080_u32.to_le_bytes();
    bench.sdo(NODE, [0x23, 0x05, 0x10, 0, a, b, c, d]);
    nmt(&mut bench, 1);
    assert_eq!(count(&mut bench, 0x080, 100), 0);
    let [a, b, c, d] = 0x0000_01F0_u32.to_le_bytes();
    let answer = bench.sdo(NODE, [0x23, 0x14, 0x10, 0, a, b, c, d]);
    assert_eq!(answer, [0x80, 0x14, 0x10, 0, 0x02, 0x00, 0x01, 0x06]);
}

/// Without bit 30 a remote frame asks for a PDO; 29 bits are refused.
#[test]
fn a_pdo_of_the_nanotec_answers_a_remote_frame() {
    let mut bench = booted("nanotec");
    bench.write(NODE, 0x1800, 1, &0x8000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 2, &[253]);
    bench.write(NODE, 0x1800, 1, &0x0000_0184_u32.to_le_bytes());
    nmt(&mut bench, 1);
    bench.run(50);
    assert_eq!(count(&mut bench, 0x184, 100), 0);
    bench.send(&Frame::remote_frame(0x184, 2));
    let answer = bench.next(0x184, 20).expect("an answer");
    assert_eq!(answer.length(), 2);
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
        keeps_what_lss_has_stored: lmd tc1;
        tells_lss_who_it_is: lmd tc1;
        keeps_its_identifiers: s200 tc1;
        hears_base_frames_only: s200 tc1;
        is_silent_until_it_has_booted: tc1;
        counts_its_boot_up_as_a_heartbeat: tc1;
        has_plain_pdos: tc1;
        makes_sync: tc1;
        tells_behind_stopped: tc1;
        has_texts: lmd tc1;
        tells_with_another_identifier: s200;
        sends_once_behind_an_event: nanotec s200;
    }
}

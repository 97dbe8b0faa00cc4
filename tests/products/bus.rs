//! What the manuals promise of the bus beyond services: identifiers, SYNC, boot-up, texts.

use canopen::Frame;
use embedded_can::ExtendedId;

use crate::bench::Bench;
use crate::pdos::with_type;
use crate::promises::{
    booted, count, emergencies, nmt, operational, refusal, segments, write_byte,
};
use crate::steer::NODE;

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
    segments(bench)
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

/// The name is a printable text, and so are the versions.
fn has_texts(name: &str) {
    let mut bench = booted(name);
    for index in 0x1008..=0x100A {
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
    // Bit 30 forbids remote frames; bit 29 would be a frame of 29 bits, which it does not know.
    bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 1, &0x4000_0184_u32.to_le_bytes());
    bench.run(50);
    bench.sent.clear();
    bench.send(&Frame::remote_frame(0x184, 2));
    assert_eq!(count(&mut bench, 0x184, 20), 0);
    let [a, b, c, d] = 0x2000_0184_u32.to_le_bytes();
    let answer = bench.sdo(NODE, [0x23, 0x00, 0x18, 1, a, b, c, d]);
    assert_eq!(answer, [0x80, 0x00, 0x18, 1, 0x30, 0x00, 0x09, 0x06]);
}

/// NMT, SYNC and TIME are for all: the TC1 follows the first two, and the third, which has no 1012h there, moves nothing.
#[test]
fn the_tc1_hears_what_is_for_all() {
    let mut bench = booted("tc1");
    bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 2, &[1]);
    bench.write(NODE, 0x1800, 1, &0x4000_0184_u32.to_le_bytes());
    let answers = |bench: &mut Bench, frame: Frame| -> Vec<u16> {
        bench.sent.clear();
        bench.send(&frame);
        bench.run(20);
        let own = bench.sent.iter().filter_map(Frame::standard_id);
        own.collect()
    };
    let sync = Frame::data_frame(0x080, &[]);
    assert!(answers(&mut bench, sync).is_empty());
    bench.send(&Frame::data_frame(0x000, &[1, 0]));
    bench.run(300);
    assert_eq!(answers(&mut bench, sync), [0x184]);
    let time = Frame::data_frame(0x100, &[4, 3, 2, 1, 6, 5]);
    assert!(answers(&mut bench, time).is_empty());
    assert_eq!(answers(&mut bench, sync), [0x184]);
    bench.send(&Frame::data_frame(0x000, &[128, 0]));
    assert!(answers(&mut bench, sync).is_empty());
}

mod each {
    promises! {
        keeps_its_identifiers: s200 tc1;
        hears_base_frames_only: s200 tc1;
        is_silent_until_it_has_booted: tc1;
        counts_its_boot_up_as_a_heartbeat: tc1;
        has_plain_pdos: tc1;
        makes_sync: tc1;
        tells_behind_stopped: tc1;
        has_texts: lmd s200 tc1;
        tells_with_another_identifier: s200;
        sends_once_behind_an_event: nanotec s200;
    }
}

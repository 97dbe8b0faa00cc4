//! What the manuals promise of communication, tried on each product that promises it: states, PDOs, errors, SDO, storage.

mod lss;

use canopen::Frame;
use lss::{has_no_lss, is_selected_by_lss, runs_at_each_bit_rate};

use crate::bench::Bench;

const NODE: u8 = 4;
const ID: u16 = NODE as u16;

/// A product in pre-operational that has said so.
pub fn booted(name: &str) -> Bench {
    let mut bench = Bench::node(name, NODE);
    let boot_up = bench.next(0x700 + ID, 100).expect("a boot-up message");
    assert_eq!(boot_up.payload(), [0], "{name}");
    bench
}

pub fn nmt(bench: &mut Bench, command: u8) {
    bench.send(&Frame::data_frame(0, &[command, NODE]));
    bench.run(20);
}

pub fn operational(name: &str) -> Bench {
    let mut bench = booted(name);
    nmt(&mut bench, 1);
    bench
}

/// The abort code of an upload; `None` if it is answered.
pub fn refusal(bench: &mut Bench, index: u16, sub: u8) -> Option<u32> {
    let [low, high] = index.to_le_bytes();
    let answer = bench.sdo(NODE, [0x40, low, high, sub, 0, 0, 0, 0]);
    (answer[0] == 0x80).then(|| u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]))
}

/// The abort code of a download of one byte; 0 if it is taken.
pub fn write_byte(bench: &mut Bench, index: u16, sub: u8, value: u8) -> u32 {
    let [low, high] = index.to_le_bytes();
    match bench.sdo(NODE, [0x2F, low, high, sub, value, 0, 0, 0]) {
        [0x60, ..] => 0,
        [_, _, _, _, a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
    }
}

/// How many frames with this identifier come in so many milliseconds.
pub fn count(bench: &mut Bench, cob_id: u16, milliseconds: u32) -> usize {
    bench.sent.clear();
    bench.run(milliseconds);
    let own = |frame: &&Frame| frame.standard_id() == Some(cob_id);
    bench.sent.iter().filter(own).count()
}

/// The emergencies that wait, each with its code and its bytes behind it.
pub fn emergencies(bench: &mut Bench) -> Vec<(u16, [u8; 6])> {
    let own = |frame: &Frame| {
        let bytes = *frame.full_payload()?;
        let [low, high, rest @ ..] = bytes;
        (frame.standard_id() == Some(0x080 + ID)).then(|| (u16::from_le_bytes([low, high]), rest))
    };
    bench
        .sent
        .drain(..)
        .filter_map(|frame| own(&frame))
        .collect()
}

/// It is pre-operational by itself, and follows the five commands; each state shows in its heartbeat.
fn follows_nmt(name: &str) {
    let mut bench = booted(name);
    bench.write(NODE, 0x1017, 0, &[10, 0]);
    let state = |bench: &mut Bench, command| {
        nmt(bench, command);
        bench.sent.clear();
        let heartbeat = bench.next(0x700 + ID, 50).expect("a heartbeat");
        heartbeat.payload().to_vec()
    };
    assert_eq!(state(&mut bench, 1), [5]);
    assert_eq!(state(&mut bench, 128), [127]);
    assert_eq!(state(&mut bench, 2), [4]);
    // Stopped, it answers no SDO.
    bench.send(&Frame::full(0x600 + ID, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
    assert_eq!(count(&mut bench, 0x580 + ID, 50), 0);
    // A command for another node is none, one for all is.
    bench.send(&Frame::data_frame(0, &[1, NODE + 1]));
    bench.run(20);
    assert_eq!(state(&mut bench, 2), [4]);
    bench.send(&Frame::data_frame(0, &[1, 0]));
    bench.run(20);
    assert_eq!(state(&mut bench, 1), [5]);
}

/// Both resets boot the device anew, with what is stored.
fn boots_anew(name: &str) {
    for command in [129, 130] {
        let mut bench = operational(name);
        bench.write(NODE, 0x1017, 0, &[100, 0]);
        bench.sent.clear();
        bench.send(&Frame::data_frame(0, &[command, NODE]));
        let boot_up = bench.next(0x700 + ID, 1_000).expect("a boot-up message");
        assert_eq!(boot_up.payload(), [0], "{name}");
        bench.run(20);
        assert_eq!(bench.read(NODE, 0x1017, 0), 0, "it was not stored");
    }
}

/// An error has a code, shows in register, history and 603Fh, and ends; the history is cleared by 0, and by nothing else.
fn tells_of_errors(name: &str) {
    let mut bench = operational(name);
    bench.sent.clear();
    bench.drive.plant_mut().fault = Some(0x4210);
    bench.run(300);
    let told = emergencies(&mut bench);
    let (code, rest) = told[0];
    assert_ne!(code, 0, "{name}");
    assert_eq!(rest[0] & 1, 1, "the generic bit");
    assert_eq!(
        told.iter().filter(|(code, _)| *code != 0).count(),
        1,
        "once"
    );
    assert_eq!(bench.read(NODE, 0x1001, 0) as u8, rest[0]);
    // The S200 has no 603Fh.
    if name != "s200" {
        assert_eq!(bench.read(NODE, 0x603F, 0) as u16, code);
    }
    assert_eq!(bench.read(NODE, 0x1003, 0) as u8, 1);
    assert_eq!(bench.read(NODE, 0x1003, 1) as u16, code);
    assert_eq!(bench.read(NODE, 0x6041, 0) & 0x4F, 0x08, "fault");
    bench.drive.plant_mut().fault = None;
    bench.run(20);
    bench.sent.clear();
    bench.write(NODE, 0x6040, 0, &[0x80, 0]);
    bench.run(50);
    assert_eq!(emergencies(&mut bench).last(), Some(&(0, [0; 6])));
    assert_eq!(bench.read(NODE, 0x1001, 0) as u8, 0);
    assert_eq!(
        bench.read(NODE, 0x6041, 0) & 0x4F,
        0x40,
        "switch on disabled"
    );
}

/// Two errors: the newest is first, the end of one tells of the other, and an empty history has no entries.
fn keeps_a_history(name: &str) {
    let mut bench = operational(name);
    for fault in [0x4210, 0x2310, 0x5200] {
        bench.drive.plant_mut().fault = Some(fault);
        bench.run(20);
    }
    assert_eq!(bench.read(NODE, 0x1003, 0) as u8, 3);
    assert_eq!(bench.read(NODE, 0x1003, 2) as u16, 0x2310);
    assert_ne!(write_byte(&mut bench, 0x1003, 0, 1), 0);
    assert_eq!(write_byte(&mut bench, 0x1003, 0, 0), 0);
    assert_eq!(bench.read(NODE, 0x1003, 0) as u8, 0);
    assert_eq!(refusal(&mut bench, 0x1003, 1), Some(0x0800_0024));
}

/// 1015h, in 100 µs, keeps messages apart.
fn keeps_emergencies_apart(name: &str) {
    let mut bench = operational(name);
    bench.write(NODE, 0x1015, 0, &1_000_u16.to_le_bytes());
    bench.sent.clear();
    for fault in [0x4210, 0x2310] {
        bench.drive.plant_mut().fault = Some(fault);
        bench.run(10);
    }
    assert_eq!(emergencies(&mut bench).len(), 1);
    bench.run(70);
    assert_eq!(emergencies(&mut bench).len(), 0);
    bench.run(30);
    assert_eq!(emergencies(&mut bench).len(), 1);
}

/// The loss of a heartbeat is told; only one that has come can be lost.
fn watches_heartbeats(name: &str) {
    let mut bench = operational(name);
    bench.write(NODE, 0x1016, 1, &0x0005_0032_u32.to_le_bytes());
    bench.sent.clear();
    bench.run(200);
    assert_eq!(emergencies(&mut bench), []);
    bench.send(&Frame::data_frame(0x705, &[5]));
    bench.run(40);
    assert_eq!(emergencies(&mut bench), []);
    bench.run(40);
    assert_eq!(emergencies(&mut bench)[0].0, 0x8130);
    // A time of 0, and no node, watch nothing.
    for none in [0x0005_0000_u32, 0x0000_0032] {
        bench.write(NODE, 0x1016, 1, &none.to_le_bytes());
    }
}

/// Guarding answers with the state and a toggle; without requests for the life time it is told.
fn watches_its_life(name: &str) {
    let mut bench = operational(name);
    bench.write(NODE, 0x100C, 0, &[50, 0]);
    bench.write(NODE, 0x100D, 0, &[2]);
    bench.sent.clear();
    bench.run(300);
    assert_eq!(
        emergencies(&mut bench),
        [],
        "it begins with the first request"
    );
    for state in [0x05, 0x85, 0x05] {
        bench.send(&Frame::remote_frame(0x700 + ID, 0));
        let answer = bench.next(0x700 + ID, 20).expect("an answer");
        assert_eq!(answer.payload(), [state]);
        bench.run(50);
    }
    bench.sent.clear();
    bench.run(100);
    assert_eq!(emergencies(&mut bench)[0].0, 0x8130);
}

/// Four PDOs each way with the identifiers of the pre-defined connection set.
fn has_its_pdos(name: &str) {
    let mut bench = booted(name);
    for (number, first) in [(0_u16, 0x180_u32), (1, 0x280), (2, 0x380), (3, 0x480)] {
        let identifier =
            |bench: &mut Bench, index: u16| bench.read(NODE, index + number, 1) & 0x7FF;
        assert_eq!(identifier(&mut bench, 0x1800), first + 4, "{name}");
        assert_eq!(identifier(&mut bench, 0x1400), first + 0x80 + 4, "{name}");
    }
    // The controlword is that of RPDO 1, and counts in operational only; the statusword that of TPDO 1, on each change.
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6040, 0) as u16, 0);
    bench.sent.clear();
    nmt(&mut bench, 1);
    assert!(bench.next(0x184, 200).is_some(), "on start");
    bench.run(300);
    bench.sent.clear();
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    let word = loop {
        let frame = bench.next(0x184, 300).expect("a statusword");
        if frame.payload()[0] & 0x6F == 0x21 {
            break frame;
        }
    };
    assert_eq!(word.length(), 2, "{name}");
    nmt(&mut bench, 128);
    assert_eq!(
        count(&mut bench, 0x184, 300),
        0,
        "no PDO in pre-operational"
    );
}

/// The types of CiA 301, and no others.
fn has_transmission_types(name: &str) {
    let mut bench = booted(name);
    for kind in [0, 1, 240, 254, 255] {
        assert_eq!(write_byte(&mut bench, 0x1800, 2, kind), 0, "{name}: {kind}");
        assert_eq!(bench.read(NODE, 0x1800, 2) as u8, kind);
        assert_eq!(write_byte(&mut bench, 0x1400, 2, kind), 0, "{name}: {kind}");
    }
    for kind in [241, 251] {
        assert_eq!(write_byte(&mut bench, 0x1800, 2, kind), 0x0609_0030);
        assert_eq!(write_byte(&mut bench, 0x1400, 2, kind), 0x0609_0030);
    }
}

/// TPDO 1 with this transmission type and no inhibit time.
pub fn with_type(name: &str, kind: u8) -> Bench {
    let mut bench = booted(name);
    bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 2, &[kind]);
    bench.write(NODE, 0x1800, 3, &[0, 0]);
    bench.write(NODE, 0x1800, 5, &[0, 0]);
    bench.write(NODE, 0x1800, 1, &0x4000_0184_u32.to_le_bytes());
    nmt(&mut bench, 1);
    bench
}

/// A PDO at every second SYNC; the identifier of SYNC can be another one.
fn sends_with_sync(name: &str) {
    let mut bench = with_type(name, 2);
    bench.write(NODE, 0x1005, 0, &0x0000_0081_u32.to_le_bytes());
    bench.sent.clear();
    for _ in 0..6 {
        bench.send(&Frame::data_frame(0x080, &[]));
        bench.send(&Frame::data_frame(0x081, &[]));
        bench.run(5);
    }
    let own = |frame: &&Frame| frame.standard_id() == Some(0x184);
    assert_eq!(bench.sent.iter().filter(own).count(), 3, "{name}");
}

/// A synchronous receive PDO counts at the SYNC, an event-driven one at once.
fn receives_with_sync(name: &str) {
    let mut bench = booted(name);
    bench.write(NODE, 0x1400, 2, &[1]);
    nmt(&mut bench, 1);
    bench.send(&Frame::data_frame(0x204, &[6, 0]));
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6040, 0) as u16, 0, "{name}");
    bench.send(&Frame::data_frame(0x080, &[]));
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6040, 0) as u16, 6, "{name}");
}

/// The event timer, in milliseconds and with an S200 in 100 µs, is the longest pause; the inhibit time, in 100 µs, the shortest.
fn keeps_its_times(name: &str) {
    let mut bench = with_type(name, 255);
    let timer: u16 = if name == "s200" { 200 } else { 20 };
    bench.write(NODE, 0x1800, 5, &timer.to_le_bytes());
    bench.run(50);
    let came = count(&mut bench, 0x184, 1_000);
    assert!((49..=51).contains(&came), "{name}: {came}");
    bench.write(NODE, 0x1800, 5, &[0, 0]);
    bench.write(NODE, 0x1800, 1, &0xC000_0184_u32.to_le_bytes());
    bench.write(NODE, 0x1800, 3, &1_000_u16.to_le_bytes());
    bench.write(NODE, 0x1800, 1, &0x4000_0184_u32.to_le_bytes());
    bench.run(150);
    bench.sent.clear();
    for controlword in [6, 0, 6, 0, 6, 0] {
        bench.send(&Frame::data_frame(0x204, &[controlword, 0]));
        bench.run(15);
    }
    let own = |frame: &&Frame| frame.standard_id() == Some(0x184);
    assert_eq!(bench.sent.iter().filter(own).count(), 1, "{name}");
}

/// TPDO 4 is mapped anew, in pre-operational and in operational, and carries what is mapped.
fn is_mapped_anew(name: &str) {
    for command in [128, 1] {
        let mut bench = booted(name);
        nmt(&mut bench, command);
        bench.write(NODE, 0x1803, 1, &0xC000_0484_u32.to_le_bytes());
        bench.write(NODE, 0x1A03, 0, &[0]);
        bench.write(NODE, 0x1A03, 1, &0x6041_0010_u32.to_le_bytes());
        bench.write(NODE, 0x1A03, 2, &0x6061_0008_u32.to_le_bytes());
        bench.write(NODE, 0x1A03, 0, &[2]);
        bench.write(NODE, 0x1803, 2, &[1]);
        bench.write(NODE, 0x1803, 1, &0x4000_0484_u32.to_le_bytes());
        nmt(&mut bench, 1);
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        let frame = bench.next(0x484, 100).expect("TPDO 4");
        assert_eq!(frame.length(), 3, "{name}");
        // Switched off it is silent.
        bench.write(NODE, 0x1803, 1, &0xC000_0484_u32.to_le_bytes());
        bench.sent.clear();
        bench.send(&Frame::data_frame(0x080, &[]));
        assert!(bench.next(0x484, 50).is_none());
    }
}

/// What a master asks for that is not there, or that cannot be, has its abort code.
fn refuses_as_told(name: &str) {
    let mut bench = booted(name);
    assert_eq!(refusal(&mut bench, 0x5FFE, 0), Some(0x0602_0000));
    assert_eq!(refusal(&mut bench, 0x1018, 9), Some(0x0609_0011));
    assert_eq!(write_byte(&mut bench, 0x6041, 0, 1), 0x0601_0002);
    let refused = write_byte(&mut bench, 0x6060, 0, 42);
    assert!(
        matches!(refused, 0x0609_0030 | 0x0609_0031),
        "{refused:08X}"
    );
    let unknown = bench.sdo(NODE, [0xE0, 0x00, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(unknown, [0x80, 0x00, 0x10, 0, 0x01, 0x00, 0x04, 0x05]);
    // A 29-bit identifier, and one that is another service's.
    for cob_id in [0xA000_0184_u32, 0x0000_0001] {
        let [a, b, c, d] = cob_id.to_le_bytes();
        let answer = bench.sdo(NODE, [0x23, 0x00, 0x18, 1, a, b, c, d]);
        assert_eq!(answer[0], 0x80, "{cob_id:08X}");
    }
}

/// What comes in segments behind the first answer.
pub fn segments(bench: &mut Bench) -> Vec<u8> {
    let mut text = Vec::new();
    let mut toggle = 0;
    loop {
        let [command, bytes @ ..] = bench.sdo(NODE, [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(command & 0x10, toggle);
        text.extend(&bytes[..7 - usize::from(command >> 1 & 7)]);
        if command & 1 != 0 {
            return text;
        }
        toggle ^= 0x10;
    }
}

/// Strings longer than four bytes come in segments.
fn has_long_strings(name: &str) {
    let mut bench = booted(name);
    let answer = bench.sdo(NODE, [0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(answer[0], 0x41, "{name}");
    let length = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]) as usize;
    let text = segments(&mut bench);
    assert_eq!(text.len(), length);
    assert!(text.iter().all(u8::is_ascii_graphic) || text.contains(&b' '));
}

/// Who it is: 1000h, and 1018h with the serial number of the board.
fn tells_who_it_is(name: &str) {
    let mut bench = booted(name);
    let profile = match name {
        "nanotec" => 8,
        "s200" => 0x2192,
        _ => 402,
    };
    assert_eq!(bench.read(NODE, 0x1000, 0) as u16, profile, "{name}");
    assert_eq!(bench.read(NODE, 0x1018, 4), 1, "the serial number");
}

/// Values that are stored outlast a reset, and defaults come back with one.
fn stores_and_restores(name: &str) {
    let mut bench = booted(name);
    assert_eq!(bench.read(NODE, 0x1010, 1) & 1, 1, "on command");
    assert_eq!(bench.read(NODE, 0x1011, 1) & 1, 1);
    let before = bench.read(NODE, 0x6065, 0);
    bench.write(NODE, 0x6065, 0, &1_234_u32.to_le_bytes());
    bench.write(NODE, 0x1010, 1, b"save");
    nmt(&mut bench, 129);
    bench.run(200);
    assert_eq!(bench.read(NODE, 0x6065, 0), 1_234, "{name}");
    bench.write(NODE, 0x1011, 1, b"load");
    assert_eq!(bench.read(NODE, 0x6065, 0), 1_234, "until the reset");
    nmt(&mut bench, 129);
    bench.run(200);
    assert_eq!(bench.read(NODE, 0x6065, 0), before);
}

mod each {
    promises! {
        follows_nmt: lmd nanotec s200 tc1;
        boots_anew: lmd nanotec s200 tc1;
        tells_of_errors: lmd nanotec s200 tc1;
        keeps_a_history: lmd s200 tc1;
        keeps_emergencies_apart: lmd tc1;
        watches_heartbeats: lmd s200 tc1;
        watches_its_life: lmd nanotec s200;
        has_its_pdos: lmd nanotec s200 tc1;
        has_transmission_types: lmd nanotec s200 tc1;
        sends_with_sync: lmd nanotec s200 tc1;
        receives_with_sync: lmd nanotec s200 tc1;
        keeps_its_times: lmd nanotec s200 tc1;
        is_mapped_anew: lmd nanotec s200 tc1;
        refuses_as_told: lmd nanotec s200 tc1;
        has_long_strings: lmd tc1;
        tells_who_it_is: lmd nanotec s200 tc1;
        stores_and_restores: lmd nanotec s200 tc1;
        is_selected_by_lss: lmd tc1;
        runs_at_each_bit_rate: lmd tc1;
        has_no_lss: nanotec s200;
    }
}

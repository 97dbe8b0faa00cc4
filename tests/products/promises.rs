//! What the manuals promise of communication, tried on each product that promises it: states, errors, SDO, storage, LSS.

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
        refuses_as_told: lmd nanotec s200 tc1;
        has_long_strings: lmd tc1;
        tells_who_it_is: lmd nanotec s200 tc1;
        stores_and_restores: lmd nanotec s200 tc1;
        is_selected_by_lss: lmd tc1;
        runs_at_each_bit_rate: lmd tc1;
        has_no_lss: nanotec s200;
    }
}

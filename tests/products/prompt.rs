//! The text interface of the S200, 1026h.

use crate::bench::Bench;
use crate::steer::{NODE, number, position, statusword};

/// Writes one character; returns the abort code if it is refused.
fn character(bench: &mut Bench, character: u8) -> Result<(), u32> {
    let answer = bench.sdo(NODE, [0x2F, 0x26, 0x10, 1, character, 0, 0, 0]);
    let code = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]);
    if answer[0] == 0x60 { Ok(()) } else { Err(code) }
}

/// Gives a line, and reads its answer.
pub fn line(bench: &mut Bench, text: &str) -> String {
    for byte in text.bytes().chain([b'\r']) {
        character(bench, byte).unwrap();
    }
    let mut answer = String::new();
    loop {
        match bench.read(NODE, 0x1026, 2) as u8 {
            0 => return answer,
            byte => answer.push(byte.into()),
        }
    }
}

/// Lines read and write parameters by their names, by the rules of an SDO, and give commands.
#[test]
fn the_text_interface_reads_and_writes_parameters() {
    let mut bench = Bench::node("s200", NODE);
    assert_eq!(bench.read(NODE, 0x1026, 2) as u8, 0);
    assert_eq!(line(&mut bench, "DECDIS 4711"), "OK\r\n");
    assert_eq!(bench.read(NODE, 0x3523, 1), 4711);
    assert_eq!(line(&mut bench, "decdis"), "4711\r\n");
    assert_eq!(line(&mut bench, "PTARGET=-12"), "OK\r\n");
    assert_eq!(line(&mut bench, "PTARGET"), "-12\r\n");
    assert_eq!(line(&mut bench, "READY 1"), "ERR 06010002\r\n");
    assert_eq!(line(&mut bench, "NREF 9"), "ERR 06090031\r\n");
    assert_eq!(line(&mut bench, "NREF x"), "ERR 06090030\r\n");
    assert_eq!(line(&mut bench, "TEA"), "ERR 06020000\r\n");
    assert_eq!(line(&mut bench, "MJOG"), "ERR 08000022\r\n", "no power");
    bench.write(NODE, 0x6060, 0, &[3]);
    bench.enable(NODE);
    line(&mut bench, "VJOG 20000");
    assert_eq!(line(&mut bench, "MJOG"), "OK\r\n");
    bench.run(500);
    assert!(position(&mut bench) > 5_000);
    assert_eq!(line(&mut bench, "S"), "OK\r\n");
    bench.run(1_000);
    assert_ne!(statusword(&mut bench) & 0x6F, 0x27);
}

/// SAVE keeps what a line has written, COLDSTART starts the drive anew.
#[test]
fn save_and_coldstart_by_text() {
    let mut bench = Bench::node("s200", NODE);
    line(&mut bench, "DECDIS 4711");
    assert_eq!(line(&mut bench, "SAVE"), "OK\r\n");
    bench.run(1_000);
    number(&mut bench, 0x3523, 1, 5);
    bench.sent.clear();
    assert_eq!(line(&mut bench, "COLDSTART"), "OK\r\n");
    assert!(bench.next(0x704, 500).is_some(), "it boots");
    bench.run(200);
    assert_eq!(line(&mut bench, "DECDIS"), "4711\r\n");
}

/// A line has 32 characters; the next one is FF030000h, and a carriage return goes on.
#[test]
fn a_full_line_of_text_is_refused() {
    let mut bench = Bench::node("s200", NODE);
    for _ in 0..32 {
        character(&mut bench, b'A').unwrap();
    }
    for _ in 0..2 {
        assert_eq!(character(&mut bench, b'A'), Err(0xFF03_0000));
    }
    assert_eq!(line(&mut bench, ""), "ERR 06020000\r\n");
    assert_eq!(line(&mut bench, "OPMODE"), "0\r\n");
}

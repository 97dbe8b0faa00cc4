//! What the manuals promise of SDO transfers of more than one frame.

use crate::promises::{booted, refusal, segments};
use crate::steer::{NODE, number};

/// The code of an abort, whatever object it names.
fn aborted(answer: [u8; 8]) -> u32 {
    let [0x80, _, _, _, a, b, c, d] = answer else {
        panic!("{answer:02X?}");
    };
    u32::from_le_bytes([a, b, c, d])
}

/// A number comes in a segment as well, its length told or not.
fn takes_a_number_in_a_segment(name: &str) {
    let mut bench = booted(name);
    for (command, length, value) in [(0x21, 4, 12_345_u32), (0x20, 0, 23_456)] {
        let answer = bench.sdo(NODE, [command, 0x85, 0x60, 0, length, 0, 0, 0]);
        assert_eq!(answer, [0x60, 0x85, 0x60, 0, 0, 0, 0, 0], "{name}");
        let [a, b, c, d] = value.to_le_bytes();
        let answer = bench.sdo(NODE, [0x07, a, b, c, d, 0, 0, 0]);
        assert_eq!(answer, [0x20, 0, 0, 0, 0, 0, 0, 0], "{name}");
        assert_eq!(bench.read(NODE, 0x6085, 0), value, "{name}");
    }
    // A toggle bit that is wrong ends it.
    bench.sdo(NODE, [0x21, 0x85, 0x60, 0, 4, 0, 0, 0]);
    let answer = bench.sdo(NODE, [0x17, 1, 2, 3, 4, 0, 0, 0]);
    assert_eq!(aborted(answer), 0x0503_0000, "{name}");
    assert_eq!(bench.read(NODE, 0x6085, 0), 23_456, "{name}");
}

/// 1021h of the TC1 is its data sheet, as a text that tells the same of each object as the file.
#[test]
fn the_tc1_gives_its_data_sheet() {
    let mut bench = booted("tc1");
    assert_eq!(bench.read(NODE, 0x1022, 0) as u8, 0, "a text");
    let begin = bench.sdo(NODE, [0x40, 0x21, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(begin[..4], [0x41, 0x21, 0x10, 0]);
    let size = u32::from_le_bytes([begin[4], begin[5], begin[6], begin[7]]);
    let (mut text, mut toggle) = (Vec::new(), 0);
    loop {
        let segment = bench.sdo(NODE, [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(segment[0] & 0xF0, toggle);
        let unused = usize::from(segment[0] >> 1 & 7);
        text.extend_from_slice(&segment[1..8 - unused]);
        if segment[0] & 1 == 1 {
            break;
        }
        toggle ^= 0x10;
    }
    assert_eq!(text.len(), size as usize);
    let text = String::from_utf8(text).unwrap();
    let file = products::ALL
        .iter()
        .find(|product| product.name == "tc1")
        .unwrap();
    let read = |text: &str| od_gen::parse("tc1.eds", text).unwrap();
    let (told, own) = (read(&text), read(file.data_sheet));
    assert_eq!(told.device, own.device);
    assert_eq!(told.objects.len(), own.objects.len());
    for (told, own) in told.objects.iter().zip(&own.objects) {
        assert_eq!((told.index, &told.name), (own.index, &own.name));
        let values = |entries: &[od_gen::model::Entry]| -> Vec<_> {
            let values = entries.iter();
            values
                .map(|entry| format!("{} {:?} {:?}", entry.name, entry.data_type, entry.default))
                .collect()
        };
        assert_eq!(
            values(&told.entries),
            values(&own.entries),
            "{:04X}h",
            own.index
        );
    }
}

/// Whole groups of motion tasks of the S200, 128 bytes, go both ways in segments.
#[test]
fn the_s200_moves_long_values_in_segments() {
    let mut bench = booted("s200");
    let tasks: Vec<u8> = (1..=128).collect();
    let begin = bench.sdo(NODE, [0x21, 0x00, 0x51, 2, 128, 0, 0, 0]);
    assert_eq!(begin, [0x60, 0x00, 0x51, 2, 0, 0, 0, 0]);
    for (number, part) in tasks.chunks(7).enumerate() {
        let toggle = (number as u8 & 1) << 4;
        let is_last = number == 128 / 7;
        let mut request = [0; 8];
        request[0] = toggle | (7 - part.len() as u8) << 1 | u8::from(is_last);
        request[1..=part.len()].copy_from_slice(part);
        assert_eq!(bench.sdo(NODE, request)[0], 0x20 | toggle);
    }
    let begin = bench.sdo(NODE, [0x40, 0x00, 0x51, 2, 0, 0, 0, 0]);
    assert_eq!(begin, [0x41, 0x00, 0x51, 2, 128, 0, 0, 0]);
    assert_eq!(segments(&mut bench), tasks);
}

/// The Nanotec, whose manual has their abort codes and no more, knows blocks as well.
#[test]
fn the_nanotec_has_blocks() {
    let mut bench = booted("nanotec");
    number(&mut bench, 0x6085, 0, 12_345);
    let answer = bench.sdo(NODE, [0xA0, 0x85, 0x60, 0, 127, 0, 0, 0]);
    assert_eq!(answer[0] & !0x04, 0xC2, "four bytes: {answer:02X?}");
    assert_eq!(answer[4..], [4, 0, 0, 0]);
    let block = bench.sdo(NODE, [0xA3, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(block[..5], [0x81, 0x39, 0x30, 0x00, 0x00], "the last one");
    let end = bench.sdo(NODE, [0xA2, 1, 127, 0, 0, 0, 0, 0]);
    assert_eq!(end[0], 0xCD, "three bytes of it are none");
    bench.send(&canopen::Frame::full(0x604, [0xA1, 0, 0, 0, 0, 0, 0, 0]));
    for size in [0, 128] {
        let answer = bench.sdo(NODE, [0xA0, 0x85, 0x60, 0, size, 0, 0, 0]);
        assert_eq!(aborted(answer), 0x0504_0002, "{size}");
    }
}

/// A request that begins a transfer drops the one that is open, and after it nobody asks for a segment.
#[test]
fn the_tc1_has_one_transfer_at_a_time() {
    let mut bench = booted("tc1");
    let name = [0x40, 0x08, 0x10, 0, 0, 0, 0, 0];
    let segment = [0x60, 0, 0, 0, 0, 0, 0, 0];
    assert_eq!(bench.sdo(NODE, name)[0], 0x41);
    assert_eq!(bench.sdo(NODE, segment)[..2], [0x00, b'T']);
    assert_eq!(bench.read(NODE, 0x1017, 0), 0);
    assert_eq!(aborted(bench.sdo(NODE, segment)), 0x0504_0001);
    // Begun anew it begins at the first letter.
    assert_eq!(bench.sdo(NODE, name)[0], 0x41);
    assert_eq!(bench.sdo(NODE, segment)[..2], [0x00, b'T']);
    assert_eq!(aborted(bench.sdo(NODE, segment)), 0x0503_0000);
    assert_eq!(aborted(bench.sdo(NODE, segment)), 0x0504_0001);
}

/// The first channel of the S200 tells how many there are: a master finds the last one, whatever the firmware has.
#[test]
fn the_s200_tells_how_far_its_channels_reach() {
    let mut bench = booted("s200");
    let last = 0x3500 + bench.read(NODE, 0x3500, 1) as u16;
    assert_eq!(last, 0x3CCF);
    assert_eq!(refusal(&mut bench, last, 0), None);
    assert_eq!(refusal(&mut bench, last + 1, 0), Some(0x0602_0000));
}

mod each {
    promises! {
        takes_a_number_in_a_segment: lmd nanotec s200 tc1;
    }
}

//! Frames to lines.

use canopen::Frame;
use embedded_can::Id;
use heapless::Vec;

use crate::LINE_LENGTH;

/// The line of a frame, its CR included.
pub type Line = Vec<u8, { LINE_LENGTH + 1 }>;

/// The line of a frame: `t`, `T`, `r` or `R`, identifier, length, data, CR; digits in capitals.
pub fn encode(frame: &Frame) -> Line {
    let mut line = Line::new();
    match frame.id() {
        Id::Standard(id) => {
            put(&mut line, if frame.is_remote() { b'r' } else { b't' });
            put_digits(&mut line, id.as_raw().into(), 3);
        }
        Id::Extended(id) => {
            put(&mut line, if frame.is_remote() { b'R' } else { b'T' });
            put_digits(&mut line, id.as_raw(), 8);
        }
    }
    put_digits(&mut line, frame.length().into(), 1);
    for byte in frame.payload() {
        put_digits(&mut line, (*byte).into(), 2);
    }
    put(&mut line, b'\r');
    line
}

fn put(line: &mut Line, byte: u8) {
    // There is room: the longest line is what the type was made for.
    let _ = line.push(byte);
}

fn put_digits(line: &mut Line, value: u32, digits: u32) {
    for place in (0..digits).rev() {
        let digit = (value >> (4 * place) & 0xF) as u8;
        put(
            line,
            if digit < 10 {
                b'0' + digit
            } else {
                b'A' + (digit - 10)
            },
        );
    }
}

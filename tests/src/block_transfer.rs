//! An SDO client for block transfers that copes with lost and doubled frames: what it cannot mend ends with an abort.

use canopen::{Duration, Frame};
use master::bus::Station;

use crate::crc::crc;
use crate::line::Line;

/// Segments of a sub-block at most.
const LARGEST_BLOCK: u8 = 127;

/// How long the client waits for the server, longer than the server's own time-out; in milliseconds.
const PATIENCE: u64 = 1_500;

/// How long after the last segment the client takes the rest of a sub-block for lost, in milliseconds.
const SEGMENT_PATIENCE: u64 = 20;

/// How often a client sends a sub-block again without getting further.
const MOST_ATTEMPTS: usize = 8;

/// What ends a transfer where the client loses patience.
const TIMED_OUT: u32 = 0x0504_0000;

impl<S: Station> Line<S> {
    /// Writes an object by a block transfer with CRC, or the abort code.
    pub fn block_download(&mut self, index: u16, sub: u8, value: &[u8]) -> Result<(), u32> {
        let [a, b, c, d] = (value.len() as u32).to_le_bytes();
        let [low, high] = index.to_le_bytes();
        self.request([0xC6, low, high, sub, a, b, c, d]);
        let mut block_size = match self.answer(PATIENCE)? {
            [0xA4, l, h, s, size, ..] if [l, h, s] == [low, high, sub] => size,
            other => return Err(self.give_up(index, sub, other)),
        };
        let mut rest = value;
        let mut attempts = 0;
        loop {
            let mut segments = rest.chunks(7).take(block_size.into()).peekable();
            if rest.is_empty() {
                self.request([0x81, 0, 0, 0, 0, 0, 0, 0]);
            }
            let mut sent = 0;
            let mut number = 0;
            while let Some(segment) = segments.next() {
                number += 1;
                sent += segment.len();
                let is_last = segments.peek().is_none() && sent == rest.len();
                let mut request = [number | u8::from(is_last) << 7, 0, 0, 0, 0, 0, 0, 0];
                request[1..=segment.len()].copy_from_slice(segment);
                self.request(request);
            }
            match self.answer(PATIENCE)? {
                // An acknowledge that was doubled, of the sub-block before.
                [0xA2, received, ..] if usize::from(received) > rest.len().div_ceil(7).max(1) => {
                    return Err(self.give_up(index, sub, [0; 8]));
                }
                [0xA2, received, size, ..] => {
                    block_size = size;
                    let taken = usize::from(received) * 7;
                    if taken >= rest.len() && received > 0 {
                        break;
                    }
                    attempts = if received > 0 { 0 } else { attempts + 1 };
                    rest = &rest[taken..];
                }
                other => return Err(self.give_up(index, sub, other)),
            }
            if attempts > MOST_ATTEMPTS {
                return Err(self.give_up(index, sub, [0; 8]));
            }
        }
        let unused = (7 - value.len() % 7) % 7 + if value.is_empty() { 7 } else { 0 };
        let [low_crc, high_crc] = crc(value).to_le_bytes();
        self.request([0xC1 | (unused as u8) << 2, low_crc, high_crc, 0, 0, 0, 0, 0]);
        loop {
            match self.answer(PATIENCE)? {
                [0xA1, ..] => return Ok(()),
                [0xA2, ..] => {}
                other => return Err(self.give_up(index, sub, other)),
            }
        }
    }

    /// Reads an object by a block transfer with CRC and this block size, or the abort code.
    pub fn block_upload(&mut self, index: u16, sub: u8, block_size: u8) -> Result<Vec<u8>, u32> {
        let [low, high] = index.to_le_bytes();
        self.request([0xA4, low, high, sub, block_size, 0, 0, 0]);
        let first = self.answer(PATIENCE)?;
        let size = match first {
            [0xC6, l, h, s, a, b, c, d] if [l, h, s] == [low, high, sub] => {
                Some(u32::from_le_bytes([a, b, c, d]) as usize)
            }
            [0xC4, l, h, s, ..] if [l, h, s] == [low, high, sub] => None,
            other => return Err(self.give_up(index, sub, other)),
        };
        self.request([0xA3, 0, 0, 0, 0, 0, 0, 0]);
        let mut value = Vec::new();
        let mut attempts = 0;
        loop {
            let mut received = 0;
            let mut is_last = false;
            let mut patience = PATIENCE;
            while received < block_size && !is_last {
                match self.answer(patience) {
                    Err(TIMED_OUT) => break,
                    Err(code) => return Err(code),
                    Ok(segment) if segment[0] & 0x7F == received + 1 => {
                        received += 1;
                        is_last = segment[0] & 0x80 != 0;
                        value.extend_from_slice(&segment[1..]);
                    }
                    Ok(_) => {}
                }
                patience = SEGMENT_PATIENCE;
            }
            attempts = if received > 0 { 0 } else { attempts + 1 };
            if attempts > MOST_ATTEMPTS {
                return Err(self.give_up(index, sub, [0; 8]));
            }
            self.request([0xA2, received, block_size.min(LARGEST_BLOCK), 0, 0, 0, 0, 0]);
            if is_last {
                break;
            }
        }
        loop {
            match self.answer(PATIENCE)? {
                [command, low_crc, high_crc, ..] if command & 0xE3 == 0xC1 => {
                    let unused = usize::from(command >> 2 & 7);
                    value.truncate(value.len().saturating_sub(unused));
                    let is_whole = size.is_none_or(|size| size == value.len());
                    if !is_whole || crc(&value) != u16::from_le_bytes([low_crc, high_crc]) {
                        return Err(self.give_up(index, sub, [0; 8]));
                    }
                    self.request([0xA1, 0, 0, 0, 0, 0, 0, 0]);
                    return Ok(value);
                }
                // The last segments, doubled.
                segment if segment[0] != 0x80 => {}
                other => return Err(self.give_up(index, sub, other)),
            }
        }
    }

    fn request(&mut self, request: [u8; 8]) {
        self.queue_frame(Frame::data_frame(0x600 + u16::from(self.node_id), &request));
    }

    /// The next frame of the server; its abort code, or [`TIMED_OUT`] if there is none for so many milliseconds.
    fn answer(&mut self, milliseconds: u64) -> Result<[u8; 8], u32> {
        let end = self.now() + Duration::millis(milliseconds);
        while let Some(left) = end.checked_duration_since(self.now()) {
            let Some(frame) = self.next(left) else { break };
            if frame.standard_id() == Some(0x580 + u16::from(self.node_id)) {
                return match *frame.bytes() {
                    [0x80, _, _, _, a, b, c, d] => Err(u32::from_le_bytes([a, b, c, d])),
                    bytes => Ok(bytes),
                };
            }
        }
        Err(TIMED_OUT)
    }

    /// Ends a transfer that cannot be mended.
    fn give_up(&mut self, index: u16, sub: u8, _answer: [u8; 8]) -> u32 {
        let [low, high] = index.to_le_bytes();
        self.request([0x80, low, high, sub, 0, 0, 0, 8]);
        0x0800_0000
    }
}

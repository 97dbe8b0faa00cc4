//! The SDO client: block upload with CRC (CiA 301, 7.2.4.3.12 to 7.2.4.3.15).
//!
//! What is lost is asked for again: a gap ends what counts of a sub-block, and its acknowledgement names the last segment that came in
//! order. What cannot be mended (a doubled sub-block, a wrong checksum) ends the transfer; the caller may begin anew.

use canopen::Duration;

use crate::sdo::{ABORT, Object};
use crate::{Failure, Line, Master};

/// Segments of a sub-block.
const BLOCK_SIZE: u8 = 127;

/// Segments that may come of a sub-block, with those that were doubled on the way.
const MOST: usize = 2 * BLOCK_SIZE as usize;

/// How long after a segment the rest of its sub-block is taken for lost, at most.
const SEGMENT_TIME: Duration = Duration::from_ticks(200_000);

/// How often nothing may come of a sub-block before the node is taken for gone.
const ATTEMPTS: u32 = 8;

/// Abort codes of a client (CiA 301, table 22).
const TIMED_OUT: u32 = 0x0504_0000;
const INVALID_COMMAND: u32 = 0x0504_0001;
const WRONG_CRC: u32 = 0x0504_0004;

impl<L: Line> Master<L> {
    /// Reads an object by block upload, or in segments from a device that has no block transfer.
    ///
    /// # Errors
    /// As [`Master::read`]; [`Failure::WrongValue`] if length or checksum are not what the device has told.
    pub fn read_by_blocks(&mut self, node: u8, index: u16, sub: u8) -> Result<Vec<u8>, Failure> {
        let object = Object::new(index, sub);
        let request = object.request(0xA4, [BLOCK_SIZE, 0, 0, 0]);
        let first = self.exchange(node, request, |answer| {
            object.is_refused_by(answer) || answer[0] & 0xF9 == 0xC0 && object.is_named_by(answer)
        });
        if let Err(Failure::Unexpected { .. }) = first {
            self.give_up(node, object, INVALID_COMMAND);
        }
        let [command, _, _, _, size @ ..] = match object.unless_aborted(first?) {
            Err(Failure::Abort { code, .. }) if code == INVALID_COMMAND => {
                return self.read(node, index, sub);
            }
            other => other?,
        };
        let size = (command & 0x02 != 0).then(|| u32::from_le_bytes(size));
        let has_crc = command & 0x04 != 0;
        let result = self.receive_blocks(node, object, size, has_crc);
        if let Err(failure) = &result {
            let code = match failure {
                Failure::Abort { .. } | Failure::LineDown(_) | Failure::Endless { .. } => {
                    return result;
                }
                Failure::WrongValue { .. } => WRONG_CRC,
                Failure::Unexpected { .. } => INVALID_COMMAND,
                _ => TIMED_OUT,
            };
            self.give_up(node, object, code);
        }
        result
    }

    fn receive_blocks(
        &mut self,
        node: u8,
        object: Object,
        size: Option<u32>,
        has_crc: bool,
    ) -> Result<Vec<u8>, Failure> {
        self.send_sdo(node, [0xA3, 0, 0, 0, 0, 0, 0, 0]);
        let mut bytes = Vec::new();
        let mut attempts = 0;
        loop {
            let (received, is_last) = self.receive_sub_block(node, object, &mut bytes)?;
            // The last segment may be filled up, that of an empty object with seven bytes.
            let length = bytes.len().saturating_sub(7);
            self.unless_endless(node, object, length, size)?;
            attempts = if received > 0 { 0 } else { attempts + 1 };
            if attempts > ATTEMPTS {
                return Err(Failure::Timeout {
                    expected: format!("segments of {object}"),
                    within: self.segment_time(),
                    at: self.now(),
                });
            }
            self.send_sdo(node, [0xA2, received, BLOCK_SIZE, 0, 0, 0, 0, 0]);
            if is_last {
                break;
            }
        }
        let mut doubled = 0;
        loop {
            let [command, low, high, ..] = match self.next_sdo(node, self.answer_time())? {
                // Segments that were doubled on the way.
                [command, ..]
                    if !matches!(command & 0xE3, 0xC1) && command != ABORT && doubled < MOST =>
                {
                    doubled += 1;
                    continue;
                }
                end => self.unless_aborted(node, object, end)?,
            };
            let unused = usize::from(command >> 2 & 0x07);
            bytes.truncate(bytes.len().saturating_sub(unused));
            check(
                &bytes,
                size,
                has_crc.then(|| u16::from_le_bytes([low, high])),
            )?;
            self.send_sdo(node, [0xA1, 0, 0, 0, 0, 0, 0, 0]);
            return Ok(bytes);
        }
    }

    /// The segments of a sub-block that come in order, and whether the last of them is the last of all.
    fn receive_sub_block(
        &mut self,
        node: u8,
        object: Object,
        bytes: &mut Vec<u8>,
    ) -> Result<(u8, bool), Failure> {
        let mut received = 0;
        let mut patience = self.answer_time();
        // More than these are no sub-block, whatever their numbers are.
        for _ in 0..MOST {
            let segment = match self.next_sdo(node, patience) {
                Ok(segment) => segment,
                Err(Failure::Timeout { .. }) => return Ok((received, false)),
                Err(failure) => return Err(failure),
            };
            patience = self.segment_time();
            let [command, data @ ..] = segment;
            let number = command & 0x7F;
            self.unless_aborted(node, object, segment)?;
            let is_next = number == received + 1;
            if is_next {
                received = number;
                bytes.extend_from_slice(&data);
            }
            let ends = command & 0x80 != 0;
            if ends || number == BLOCK_SIZE {
                return Ok((received, is_next && ends));
            }
        }
        Ok((received, false))
    }

    /// How long the rest of a sub-block may take.
    fn segment_time(&self) -> Duration {
        self.answer_time().min(SEGMENT_TIME)
    }

    fn send_sdo(&mut self, node: u8, request: [u8; 8]) {
        self.send_data(self.channel(node).request, &request);
    }

    /// The next frame of the node's SDO server.
    fn next_sdo(&mut self, node: u8, within: Duration) -> Result<[u8; 8], Failure> {
        let answer_id = self.channel(node).answer;
        self.wait_for(&format!("an SDO answer {answer_id:03X}"), within, |frame| {
            (frame.standard_id() == Some(answer_id))
                .then(|| frame.full_payload().copied())
                .flatten()
        })
    }

    /// An abort ends this transfer, even if it refuses one of another client: the server had to drop this one for that.
    fn unless_aborted(
        &self,
        node: u8,
        object: Object,
        answer: [u8; 8],
    ) -> Result<[u8; 8], Failure> {
        if answer[0] == ABORT && !object.is_refused_by(&answer) {
            return Err(self.unexpected(node, answer));
        }
        object.unless_aborted(answer)
    }

    fn give_up(&mut self, node: u8, object: Object, code: u32) {
        self.send_sdo(node, object.request(ABORT, code.to_le_bytes()));
    }
}

/// Whether what came is what was announced.
fn check(bytes: &[u8], size: Option<u32>, crc: Option<u16>) -> Result<(), Failure> {
    if let Some(size) = size.filter(|size| *size as usize != bytes.len()) {
        return Err(Failure::WrongValue {
            expected: format!("{size} bytes"),
            got: format!("{} bytes", bytes.len()),
        });
    }
    let own = checksum(bytes);
    match crc {
        Some(told) if told != own => Err(Failure::WrongValue {
            expected: format!("the checksum {told:04X}h"),
            got: format!("{own:04X}h"),
        }),
        _ => Ok(()),
    }
}

/// The CRC of block transfers (CiA 301, 7.2.4.3.16).
fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
            let carry = crc & 0x8000 != 0;
            crc << 1 ^ if carry { 0x1021 } else { 0 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::checksum;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!(checksum(b"123456789"), 0x31C3);
        assert_eq!(checksum(&[]), 0);
    }
}

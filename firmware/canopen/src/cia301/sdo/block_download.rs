//! Block download: the client writes an object in sub-blocks of 127 segments.
//!
//! ```text
//!   client                                server
//!   C6 object, size          ------->
//!                            <-------     A4 object, 127 segments a sub-block
//!   01, 02 ... 7F            ------->
//!                            <-------     A2 the last segment before the first gap
//!   01, 02 ... 80 + last     ------->
//!                            <-------     A2
//!   C1 unused bytes, CRC     ------->
//!                            <-------     A1
//! ```
//!
//! A segment in its place is handed on at once; only the last one waits for the end frame, which tells how many of its bytes
//! count. After a gap nothing is taken until the sub-block is over; the client then goes on behind what is confirmed,
//! numbering from 1 again. Should the end of a sub-block be lost, the server confirms by itself after half of its
//! patience, once.
//!
//! While segments are expected every frame is one, whatever it looks like. So when the server aborts in the middle of
//! a sub-block, the rest of it, which is under way already, is followed by its numbers and ignored: it must not be taken
//! for requests.

use super::objects::{Objects, Streams};
use super::server::{Server, Step};
use super::{AbortCode, crc};
use crate::time::{Duration, Instant};
use crate::wire::sdo::{
    ABORT_COMMAND, BlockRequest, BlockResponse, BlockSegment, MOST_SEGMENTS, Multiplexer,
};

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// Gets ready for the first sub-block.
    pub(super) fn initiate_block_download<O: Objects>(
        &mut self,
        object: Multiplexer,
        has_crc: bool,
        size: Option<u32>,
        now: Instant,
        objects: &mut O,
    ) {
        self.drop_transfer(objects);
        self.object = object;
        let result = objects
            .writable(object)
            .and_then(|entry| self.open_download(entry, size, objects));
        if let Err(code) = result {
            return self.abort(object, code, objects);
        }
        self.step = Step::BlockDownload;
        self.block.has_crc = has_crc;
        self.block.crc = 0;
        self.block.seqno = 0;
        self.block.ahead = 0;
        self.block.closing = 0;
        self.wait_for_segment(now);
        let answer = BlockResponse::InitiateDownload {
            object,
            crc: true,
            block_size: MOST_SEGMENTS,
        };
        self.answers.push(answer.emit());
    }

    /// Takes a frame in the middle of the sub-blocks.
    #[inline]
    pub(super) fn take_block_segment<O: Objects>(
        &mut self,
        frame: &[u8; 8],
        now: Instant,
        objects: &mut O,
    ) {
        let [command, data @ ..] = frame;
        let expected = self.block.seqno.wrapping_add(1);
        if command & !BlockSegment::LAST != expected || self.is_too_late(now) {
            return self.take_unexpected(frame, now, objects);
        }
        self.block.seqno = expected;
        if command & BlockSegment::LAST != 0 {
            self.block.held = *data;
            self.step = Step::BlockDownloadEnd;
            self.wait(now);
            return self.confirm(*command);
        }
        if let Err(code) = self.append(data, objects) {
            return self.abort_in_sub_block(code, now, objects);
        }
        if self.block.has_crc {
            self.block.crc = crc::add_segment(self.block.crc, frame);
        }
        self.wait_for_segment(now);
        if expected == MOST_SEGMENTS {
            self.confirm(*command);
        }
    }

    /// Takes a frame that is not the next segment: an abort, a repetition, what follows a gap, or nonsense.
    #[cold]
    #[inline(never)]
    fn take_unexpected<O: Objects>(&mut self, frame: &[u8; 8], now: Instant, objects: &mut O) {
        let [command, ..] = *frame;
        if command == ABORT_COMMAND {
            return self.drop_transfer(objects);
        }
        if self.is_too_late(now) {
            return self.abort_in_sub_block(AbortCode::TimedOut, now, objects);
        }
        let segment = BlockSegment::parse(frame);
        if segment.seqno == 0 {
            return self.abort(self.object, AbortCode::InvalidSequenceNumber, objects);
        }
        if self.block.is_reminded && self.block.is_cut {
            self.block.ahead = segment.seqno;
            return self.abort_in_sub_block(AbortCode::InvalidSequenceNumber, now, objects);
        }
        let is_repetition = segment.seqno <= self.block.seqno
            || (self.block.seqno == 0 && command == self.block.closing);
        if is_repetition {
            return self.wait_for_segment(now);
        }
        if let Some((empty, crc)) = self.early_end(frame, segment.seqno) {
            return self.end_block_download(empty, crc, now, objects);
        }
        self.block.ahead = segment.seqno;
        self.wait_for_segment(now);
        if segment.last || segment.seqno == MOST_SEGMENTS {
            self.confirm(command);
        }
    }

    /// The content of a frame that ends the transfer before its last segment has come. It looks like a last segment behind a
    /// gap; it is none if the rest of it is empty and the size that was announced does not end there.
    fn early_end(&self, frame: &[u8; 8], seqno: u8) -> Option<(u8, u16)> {
        let (empty, crc) = BlockRequest::end_download(frame)?;
        let [_, _, _, 0, 0, 0, 0, 0] = *frame else {
            return None;
        };
        let ahead = u32::from(seqno.saturating_sub(self.block.seqno)).saturating_mul(7);
        let end = self.position.saturating_add(ahead);
        let ends_there = self
            .size
            .is_some_and(|size| size <= end && end.saturating_sub(size) < 7);
        (!ends_there).then_some((empty, crc))
    }

    /// Confirms what has come of a sub-block; the next one begins.
    fn confirm(&mut self, closing: u8) {
        let seqno = self.block.seqno;
        self.block.seqno = 0;
        self.block.ahead = 0;
        self.block.closing = closing;
        let answer = BlockResponse::Acknowledge {
            seqno,
            block_size: MOST_SEGMENTS,
        };
        self.answers.push(answer.emit());
    }

    /// The client has been silent for half of the server's patience. Perhaps the end of its sub-block was lost, and it waits:
    /// confirms what has come. If nothing has come since the last answer, that may have been lost itself, or the client is just
    /// slow. It would take a number for the answer to what it sends next, so it gets none.
    ///
    /// The next sub-block begins with segment 1. A client that goes on with another number has not heard of this: what it took for
    /// unconfirmed later it would send twice, so the transfer ends.
    pub(super) fn remind(&mut self) {
        self.deadline += self.half_time_out();
        self.block.is_reminded = true;
        let has_come = self.block.seqno != 0 || self.block.ahead != 0;
        self.block.is_cut = has_come;
        if has_come {
            self.confirm(0);
        }
    }

    /// When the client of a block download has been silent for too long.
    pub(super) fn end_of_patience(&self) -> Instant {
        if self.block.is_reminded {
            self.deadline
        } else {
            self.deadline + self.half_time_out()
        }
    }

    #[inline]
    const fn half_time_out(&self) -> Duration {
        Duration::from_ticks(self.time_out.ticks() / 2)
    }

    #[inline]
    pub(super) fn wait_for_segment(&mut self, now: Instant) {
        self.block.is_reminded = false;
        self.deadline = now + self.half_time_out();
    }

    /// Ends the transfer with this code; the rest of the sub-block is to be ignored.
    #[cold]
    #[inline(never)]
    pub(super) fn abort_in_sub_block<S: Streams>(
        &mut self,
        code: AbortCode,
        now: Instant,
        streams: &mut S,
    ) {
        self.abort(self.object, code, streams);
        self.block.seqno = self.block.seqno.max(self.block.ahead);
        if self.block.seqno < MOST_SEGMENTS {
            self.step = Step::Ignoring;
            self.wait(now);
        }
    }

    /// Whether a frame belongs to sub-blocks that are over: the last segment once more, or the next one of a sub-block that
    /// is ignored.
    #[cold]
    #[inline(never)]
    pub(super) fn is_rest_of_block(&mut self, frame: &[u8; 8], now: Instant) -> bool {
        let [command, ..] = *frame;
        let segment = BlockSegment::parse(frame);
        if self.step == Step::BlockDownloadEnd {
            let is_equal = command == self.block.closing && segment.data == self.block.held;
            // The last segment may look like the end frame that follows it, to the last byte if all data is zero.
            return is_equal && !self.is_end(frame);
        }
        let is_next = matches!(segment.seqno.wrapping_sub(self.block.seqno), 0 | 1);
        if segment.seqno == 0 || !is_next || self.is_too_late(now) {
            self.idle();
            return false;
        }
        self.block.seqno = segment.seqno;
        if segment.last || segment.seqno == MOST_SEGMENTS {
            self.idle();
        }
        true
    }

    /// Checks what the client says about the data, and writes the object.
    pub(super) fn end_block_download<O: Objects>(
        &mut self,
        empty: u8,
        crc: u16,
        now: Instant,
        objects: &mut O,
    ) {
        let result = match self.step {
            _ if self.is_too_late(now) => Err(AbortCode::TimedOut),
            Step::BlockDownloadEnd => self.take_last_segment(empty, crc, objects),
            // No data at all needs no segment.
            Step::BlockDownload if self.size == Some(0) && self.position == 0 => Ok(()),
            _ => Err(self.stray()),
        };
        match result {
            Ok(()) => self.finish(BlockResponse::EndDownload.emit(), objects),
            Err(code) => self.abort(self.object, code, objects),
        }
    }

    /// Whether this is the end frame that belongs to the data.
    fn is_end(&self, frame: &[u8; 8]) -> bool {
        BlockRequest::end_download(frame)
            .is_some_and(|(empty, crc)| self.check_end(empty, crc).is_ok())
    }

    /// The bytes of the last segment that count, if size and checksum are right with them.
    fn check_end(&self, empty: u8, crc: u16) -> Result<&[u8], AbortCode> {
        let held = &self.block.held;
        let length = held.len().saturating_sub(empty.into());
        let data = held.get(..length).unwrap_or(held);
        let total = self.position.saturating_add(length as u32);
        if self.size.is_some_and(|size| size != total) {
            return Err(AbortCode::LengthMismatch);
        }
        if self.block.has_crc && crc::add(self.block.crc, data) != crc {
            return Err(AbortCode::CrcError);
        }
        Ok(data)
    }

    fn take_last_segment<O: Objects>(
        &mut self,
        empty: u8,
        crc: u16,
        objects: &mut O,
    ) -> Result<(), AbortCode> {
        let length = self.check_end(empty, crc)?.len();
        if length == 0 {
            return Ok(());
        }
        let held = self.block.held;
        self.append(held.get(..length).unwrap_or(&held), objects)
    }
}

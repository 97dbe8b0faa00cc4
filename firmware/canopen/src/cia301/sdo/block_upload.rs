//! Block upload: the client reads an object in sub-blocks, whose size it sets anew for each.
//!
//! ```text
//!   client                                server
//!   A4 object, segments      ------->
//!                            <-------     C6 object, size
//!   A3                       ------->
//!                            <-------     01, 02 ...
//!   A2 arrived, segments     ------->
//!                            <-------     01, 02 ... 80 + last
//!   A2 arrived, segments     ------->
//!                            <-------     C1 unused bytes, CRC
//!   A1                       ------->
//! ```
//!
//! Segments are made when the bus can take them, one by one, so frames that are more urgent go between. What the client
//! has missed is read again, at its position: nothing is kept for that. An object of few bytes, at most as many as the client
//! says, is sent without blocks (protocol switch).

use super::objects::{Objects, Streams};
use super::server::{Server, Step, abort_message};
use super::upload::with_command;
use super::{AbortCode, crc};
use crate::time::Instant;
use crate::wire::sdo::{BlockResponse, BlockSegment, MOST_SEGMENTS, Multiplexer};

const fn is_block_size(segments: u8) -> bool {
    matches!(segments, 1..=MOST_SEGMENTS)
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// Tells the size, or sends a short value without blocks.
    pub(super) fn initiate_block_upload<O: Objects>(
        &mut self,
        object: Multiplexer,
        has_crc: bool,
        block_size: u8,
        threshold: u8,
        now: Instant,
        objects: &mut O,
    ) {
        self.drop_transfer(objects);
        self.object = object;
        let result = if is_block_size(block_size) {
            objects
                .readable(object)
                .and_then(|entry| objects.open(entry))
                .and_then(|value| self.open_upload(value))
        } else {
            Err(AbortCode::InvalidBlockSize)
        };
        if let Err(code) = result {
            return self.abort(object, code, objects);
        }
        let is_short = self.size.is_some_and(|size| size <= threshold.into());
        if threshold != 0 && is_short {
            return self.begin_upload(now, objects);
        }
        self.step = Step::BlockUploadStart;
        self.block.has_crc = has_crc;
        self.block.crc = 0;
        self.block.checked = 0;
        self.block.base = 0;
        self.block.size = block_size;
        self.wait(now);
        let answer = BlockResponse::InitiateUpload {
            object,
            crc: true,
            size: self.size,
        };
        self.answers.push(answer.emit());
    }

    /// The client is ready: the first sub-block.
    pub(super) fn start_block_upload<S: Streams>(&mut self, now: Instant, streams: &mut S) {
        let is_first = self.block.base == 0 && self.block.seqno == 0;
        if self.step == Step::BlockUpload && is_first {
            // Once more; nothing has been sent yet.
            return;
        }
        let code = if self.step != Step::BlockUploadStart {
            self.stray()
        } else if self.is_too_late(now) {
            AbortCode::TimedOut
        } else {
            return self.begin_sub_block(now);
        };
        self.abort(self.object, code, streams);
    }

    /// The segments from [`Block::base`](super::block::Block::base) on leave next.
    fn begin_sub_block(&mut self, now: Instant) {
        self.position = self.block.base;
        self.block.seqno = 0;
        self.block.last = None;
        self.step = Step::BlockUpload;
        self.wait(now);
    }

    /// The next segment of the sub-block, or an abort if the application cannot go on.
    #[inline(always)] // In the one place of each application where segments leave.
    pub(super) fn send_block_segment<S: Streams>(&mut self, streams: &mut S) -> [u8; 8] {
        let mut frame = [0; 8];
        let piece = match self.next_piece(streams, &mut frame) {
            Ok(piece) => piece,
            Err(code) => {
                self.drop_transfer(streams);
                return abort_message(self.object, code);
            }
        };
        let seqno = self.block.seqno.wrapping_add(1);
        self.block.seqno = seqno;
        if self.block.has_crc && self.position == self.block.checked {
            self.block.crc = if piece.empty == 0 {
                crc::add_segment(self.block.crc, &frame)
            } else {
                let [_, data @ ..] = &frame;
                let length = 7_usize.saturating_sub(piece.empty.into());
                crc::add(self.block.crc, data.get(..length).unwrap_or(data))
            };
            self.block.checked = self.position.saturating_add(7);
        }
        self.position = self.position.saturating_add(7);
        if piece.is_last {
            self.block.last = Some(piece.empty);
            self.end_sub_block();
            return with_command(frame, seqno | BlockSegment::LAST);
        }
        if seqno == self.block.size {
            self.end_sub_block();
        }
        with_command(frame, seqno)
    }

    /// The client's time begins with the next call that brings the time.
    fn end_sub_block(&mut self) {
        self.step = Step::BlockUploadSent;
        self.deadline = Instant::from_ticks(0);
    }

    /// The client tells what has arrived: goes on behind that, or to the end. It may tell so before all is sent, when it
    /// has waited for too long.
    pub(super) fn acknowledge_block_upload<S: Streams>(
        &mut self,
        seqno: u8,
        block_size: u8,
        now: Instant,
        streams: &mut S,
    ) {
        if self.step == Step::BlockUpload && self.block.seqno == 0 {
            // About the sub-block before, once more.
            return;
        }
        if let Err(code) = self.take_acknowledgement(seqno, block_size, now) {
            self.abort(self.object, code, streams);
        }
    }

    fn take_acknowledgement(
        &mut self,
        seqno: u8,
        block_size: u8,
        now: Instant,
    ) -> Result<(), AbortCode> {
        if !matches!(
            self.step,
            Step::BlockUpload | Step::BlockUploadSent | Step::BlockUploadAcknowledge
        ) {
            return Err(self.stray());
        }
        if self.is_too_late(now) {
            return Err(AbortCode::TimedOut);
        }
        if seqno > self.block.seqno {
            return Err(AbortCode::InvalidSequenceNumber);
        }
        if let Some(empty) = self.block.last
            && seqno == self.block.seqno
        {
            self.step = Step::BlockUploadEnd;
            self.wait(now);
            let crc = if self.block.has_crc {
                self.block.crc
            } else {
                0
            };
            self.answers
                .push(BlockResponse::EndUpload { empty, crc }.emit());
            return Ok(());
        }
        if !is_block_size(block_size) {
            return Err(AbortCode::InvalidBlockSize);
        }
        let arrived = u32::from(seqno).saturating_mul(7);
        self.block.base = self.block.base.saturating_add(arrived);
        self.block.size = block_size;
        self.begin_sub_block(now);
        Ok(())
    }

    /// The client has all data. It gets no answer; neither does one that says so again.
    pub(super) fn end_block_upload<S: Streams>(&mut self, now: Instant, streams: &mut S) {
        let code = match self.step {
            Step::Idle => return,
            Step::BlockUploadEnd if self.is_too_late(now) => AbortCode::TimedOut,
            Step::BlockUploadEnd => return self.idle(),
            _ => self.stray(),
        };
        self.abort(self.object, code, streams);
    }
}

//! Segments in the middle of a transfer, by the shortest way.
//!
//! Nearly every frame of a long transfer is the next full segment, or the question for it, in time and with the right toggle bit or
//! number. It needs nothing of the dictionary, and ends nothing. Whatever is otherwise, and so every error, is for
//! [`Server::receive`].

use super::crc;
use super::objects::Streams;
use super::server::{Place, Server, Step};
use super::upload::{Piece, segment_of, with_command};
use crate::time::{Instant, has_come};
use crate::wire::sdo::{MOST_SEGMENTS, Request, Response};

/// Data bytes of a segment.
const SEGMENT: u32 = 7;

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// Whether the next frame may be for [`Server::pass`].
    #[inline]
    pub(super) fn is_in_segments(&self) -> bool {
        cfg!(feature = "fast")
            && matches!(
                self.step,
                Step::Upload | Step::Download | Step::BlockDownload
            )
    }

    /// Takes the next segment of the open transfer, or the question for it. Returns whether the frame was that; if it was not,
    /// nothing has changed. There must be room for an answer.
    #[inline(always)] // With its three ways, in the one place of each application that asks.
    pub(super) fn pass<S: Streams>(
        &mut self,
        frame: &[u8; 8],
        now: Instant,
        streams: &mut S,
    ) -> bool {
        if has_come(self.deadline, now) {
            return false;
        }
        match self.step {
            Step::Upload => self.pass_upload(frame, now),
            Step::Download => self.pass_download(frame, now),
            Step::BlockDownload if S::HAVE_BLOCK_TRANSFER => {
                self.pass_block_download(frame, now, streams)
            }
            _ => false,
        }
    }

    /// The client asks for seven bytes, or for what is left.
    #[inline(always)]
    fn pass_upload(&mut self, request: &[u8; 8], now: Instant) -> bool {
        let value = match self.place {
            Place::Snapshot => {
                let end = self.size.unwrap_or(0) as usize;
                self.buffer.as_ref().get(..end).unwrap_or(&[])
            }
            Place::Constant(value) => value,
            _ => return false,
        };
        let rest = value.get(self.position as usize..).unwrap_or(&[]);
        if !Request::is_upload_segment(request, self.toggle) {
            return false;
        }
        let command = u8::from(self.toggle) << 4;
        // One byte more than a segment has: it is not the last one.
        if let Some(eight) = rest.first_chunk::<8>() {
            self.answers.push(with_command(segment_of(eight), command));
            self.go_on(now);
        } else {
            let mut frame = [0; 8];
            let last = Piece::last(rest, &mut frame);
            self.idle();
            self.answers
                .push(with_command(frame, command | last.command()));
        }
        true
    }

    /// The client sends seven bytes, and more will follow.
    #[inline(always)]
    fn pass_download(&mut self, request: &[u8; 8], now: Instant) -> bool {
        let [_, data @ ..] = request;
        let begin = self.position as usize;
        let end = self.position.saturating_add(SEGMENT);
        let is_buffered = matches!(self.place, Place::Buffer(_));
        if !is_buffered || end > self.most || !Request::is_full_segment(request, self.toggle) {
            return false;
        }
        let room = self.buffer.as_mut().get_mut(begin..);
        let Some(room) = room.and_then(<[u8]>::first_chunk_mut) else {
            return false;
        };
        *room = *data;
        let toggle = self.toggle;
        self.answers
            .push(Response::DownloadSegment { toggle }.emit());
        self.go_on(now);
        true
    }

    /// The segment in its place, neither the last of all nor the last of its sub-block.
    #[inline]
    fn pass_block_download<S: Streams>(
        &mut self,
        frame: &[u8; 8],
        now: Instant,
        streams: &mut S,
    ) -> bool {
        let [seqno, data @ ..] = frame;
        let expected = self.block.seqno.wrapping_add(1);
        if *seqno != expected || expected >= MOST_SEGMENTS {
            return false;
        }
        self.block.seqno = expected;
        if let Err(code) = self.append(data, streams) {
            self.abort_in_sub_block(code, now, streams);
            return true;
        }
        if self.block.has_crc {
            self.block.crc = crc::add_segment(self.block.crc, frame);
        }
        self.wait_for_segment(now);
        true
    }

    /// Seven bytes have passed.
    #[inline]
    fn go_on(&mut self, now: Instant) {
        self.position = self.position.saturating_add(SEGMENT);
        self.toggle = !self.toggle;
        self.wait(now);
    }
}

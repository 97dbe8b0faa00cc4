//! Upload: the client reads an object, expedited or in segments.

use super::AbortCode;
use super::objects::{Objects, Streams, Value};
use super::server::{Place, Server, Step};
use crate::copy::{copy, copy_few};
use crate::od::Entry;
use crate::time::{Instant, has_come};
use crate::wire::sdo::{Multiplexer, Payload, Response};

/// Data bytes of one segment.
const SEGMENT: u32 = 7;

/// What the buffer holds of a value that the application gives. It is asked for many bytes at once: a segment alone is too few
/// for a call.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    /// The position of the first byte.
    start: u32,
    /// How many bytes.
    length: u16,
    /// The value ends behind them.
    is_end: bool,
}

impl Ahead {
    /// Nothing.
    pub(super) const NOTHING: Self = Self {
        start: 0,
        length: 0,
        is_end: false,
    };
}

/// The next bytes of a value, but for the bytes themselves: those are in the frame that they travel in, behind byte 0.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    /// Bytes at the end that hold nothing, 0 to 7.
    pub(super) empty: u8,
    /// The value ends here.
    pub(super) is_last: bool,
}

impl Piece {
    /// Up to seven bytes from the start of what is left.
    #[inline]
    fn of(rest: &[u8], frame: &mut [u8; 8]) -> Self {
        if let Some(eight) = rest.first_chunk::<8>() {
            *frame = segment_of(eight);
            return Self {
                empty: 0,
                is_last: false,
            };
        }
        Self::last(rest, frame)
    }

    /// All of what is left, which is no more than a segment has.
    #[inline]
    pub(super) fn last(rest: &[u8], frame: &mut [u8; 8]) -> Self {
        let [_, data @ ..] = frame;
        copy_few(data, rest, rest.len());
        Self {
            empty: 7_u8.saturating_sub(rest.len() as u8),
            is_last: true,
        }
    }

    /// Its bits of the command in byte 0.
    #[inline]
    pub(super) const fn command(self) -> u8 {
        self.empty << 1 | self.is_last as u8
    }
}

/// The first seven of eight bytes as they lie in a frame, behind byte 0, which is 0.
#[inline]
pub(super) fn segment_of(eight: &[u8; 8]) -> [u8; 8] {
    (u64::from_le_bytes(*eight) << 8).to_le_bytes()
}

/// The frame with its command, which goes where a 0 is.
#[inline]
pub(super) fn with_command(frame: [u8; 8], command: u8) -> [u8; 8] {
    (u64::from_le_bytes(frame) | u64::from(command)).to_le_bytes()
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// Sends a number of one, two or four bytes at once, as most are.
    #[inline]
    pub(super) fn initiate_upload<O: Objects>(
        &mut self,
        object: Multiplexer,
        now: Instant,
        objects: &mut O,
    ) {
        self.begin(objects);
        match objects.readable(object) {
            Ok(entry) => match objects.number(entry) {
                Some(number) => {
                    let answer = Response::number(object, number, entry.size());
                    self.answers.push(answer);
                }
                None => self.upload_value(object, entry, now, objects),
            },
            Err(code) => self.abort(object, code, objects),
        }
    }

    /// Sends a short value at once; gets ready to send a long one, and an empty one, whose length 0 only the segmented
    /// form can tell.
    #[inline(never)]
    fn upload_value<O: Objects>(
        &mut self,
        object: Multiplexer,
        entry: &'static Entry,
        now: Instant,
        objects: &mut O,
    ) {
        let value = match objects.open(entry) {
            Ok(value) => value,
            Err(code) => return self.abort(object, code, objects),
        };
        if let Value::Variable(bytes) | Value::Constant(bytes) = value
            && matches!(bytes.len(), 1..=4)
        {
            let payload = Payload::Expedited(bytes);
            return self
                .answers
                .push(Response::InitiateUpload { object, payload }.emit());
        }
        self.object = object;
        match self.open_upload(value) {
            Ok(()) => self.begin_upload(now, objects),
            Err(code) => self.abort(object, code, objects),
        }
    }

    /// Makes the value the one that is sent from position 0 on.
    pub(super) fn open_upload(&mut self, value: Value<'_>) -> Result<(), AbortCode> {
        self.position = 0;
        (self.place, self.size) = match value {
            Value::Variable(bytes) => {
                let room = self
                    .buffer
                    .as_mut()
                    .get_mut(..bytes.len())
                    .ok_or(AbortCode::OutOfMemory)?;
                copy(room, bytes);
                (Place::Snapshot, Some(bytes.len() as u32))
            }
            Value::Constant(bytes) => (Place::Constant(bytes), Some(bytes.len() as u32)),
            Value::Streamed(entry, size) => {
                self.ahead = Ahead::NOTHING;
                if self.buffer.as_ref().len() <= SEGMENT as usize {
                    return Err(AbortCode::OutOfMemory);
                }
                (Place::Source(entry), size)
            }
        };
        Ok(())
    }

    /// The answer that begins an upload without blocks of the value that is open.
    pub(super) fn begin_upload<S: Streams>(&mut self, now: Instant, streams: &mut S) {
        let object = self.object;
        // Only what the application serves can turn out to be short here; of the other values the length was known.
        if self.size.is_none_or(|size| size <= 4) {
            let mut frame = [0; 8];
            match self.next_piece(streams, &mut frame) {
                Ok(piece) if piece.is_last && matches!(piece.empty, 3..=6) => {
                    self.idle();
                    let [_, a, b, c, d, ..] = frame;
                    let bytes = [a, b, c, d];
                    let length = usize::from(7_u8.saturating_sub(piece.empty));
                    let payload = Payload::Expedited(bytes.get(..length).unwrap_or(&bytes));
                    return self
                        .answers
                        .push(Response::InitiateUpload { object, payload }.emit());
                }
                Ok(_) => {}
                Err(code) => return self.abort(object, code, streams),
            }
        }
        self.step = Step::Upload;
        self.toggle = false;
        self.wait(now);
        let payload = Payload::Segmented(self.size);
        self.answers
            .push(Response::InitiateUpload { object, payload }.emit());
    }

    /// Sends the next seven bytes.
    pub(super) fn upload_segment<S: Streams>(
        &mut self,
        toggle: bool,
        now: Instant,
        streams: &mut S,
    ) {
        let mut frame = [0; 8];
        let piece = match self.take_upload_request(toggle, now, streams, &mut frame) {
            Ok(piece) => piece,
            Err(code) => return self.abort(self.object, code, streams),
        };
        let command = u8::from(toggle) << 4 | piece.command();
        if piece.is_last {
            self.idle();
        } else {
            self.position = self.position.saturating_add(SEGMENT);
            self.toggle = !toggle;
            self.wait(now);
        }
        self.answers.push(with_command(frame, command));
    }

    #[inline]
    fn take_upload_request<S: Streams>(
        &mut self,
        toggle: bool,
        now: Instant,
        streams: &mut S,
        frame: &mut [u8; 8],
    ) -> Result<Piece, AbortCode> {
        if self.step != Step::Upload {
            return Err(self.stray());
        }
        if has_come(self.deadline, now) {
            return Err(AbortCode::TimedOut);
        }
        if toggle != self.toggle {
            return Err(AbortCode::ToggleNotAlternated);
        }
        self.next_piece(streams, frame)
    }

    /// The bytes at the present position, which stays.
    ///
    /// # Errors
    /// The application cannot give them.
    #[inline]
    pub(super) fn next_piece<S: Streams>(
        &mut self,
        streams: &mut S,
        frame: &mut [u8; 8],
    ) -> Result<Piece, AbortCode> {
        let value = match self.place {
            Place::Snapshot => {
                let end = self.size.unwrap_or(0) as usize;
                self.buffer.as_ref().get(..end).unwrap_or(&[])
            }
            Place::Constant(value) => value,
            Place::Source(entry) if S::ARE_THERE => {
                if !self.has_ahead() {
                    self.read_ahead(entry, streams)?;
                }
                let offset = self.position.wrapping_sub(self.ahead.start) as usize;
                let length = usize::from(self.ahead.length);
                let rest = self.buffer.as_ref().get(offset..length);
                return Ok(Piece::of(rest.unwrap_or(&[]), frame));
            }
            _ => &[],
        };
        let rest = value.get(self.position as usize..).unwrap_or(&[]);
        Ok(Piece::of(rest, frame))
    }

    /// Whether the buffer has the next segment of what the application gives, and tells whether it is the last one.
    #[inline]
    fn has_ahead(&self) -> bool {
        let offset = self.position.wrapping_sub(self.ahead.start);
        let left = u32::from(self.ahead.length).checked_sub(offset);
        left.is_some_and(|left| self.ahead.is_end || left > SEGMENT)
    }

    /// Fills the buffer with the next bytes from the application.
    #[inline(never)]
    fn read_ahead<S: Streams>(
        &mut self,
        entry: &'static Entry,
        streams: &mut S,
    ) -> Result<(), AbortCode> {
        let position = self.position;
        let left = self.size.map(|size| size.saturating_sub(position) as usize);
        let buffer = self.buffer.as_mut();
        let most = buffer.len().min(usize::from(u16::MAX));
        let wanted = left.map_or(most, |left| left.min(most));
        let room = buffer.get_mut(..wanted).unwrap_or(&mut []);
        let got = streams.read_at(entry, position, room)?.min(wanted);
        if left.is_some() && got < wanted {
            // The application has announced more.
            return Err(AbortCode::NotTransferable);
        }
        self.ahead = Ahead {
            start: position,
            length: got as u16,
            is_end: got < wanted || left == Some(got),
        };
        Ok(())
    }
}

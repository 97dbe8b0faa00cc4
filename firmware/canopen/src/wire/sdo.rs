//! The eight bytes of an SDO frame (CiA 301, 7.2.4.3): requests of a client, responses of a server.
//!
//! The highest three bits of byte 0 are the command specifier; the others and the rest of the frame depend on it. A view
//! borrows its data from the frame. Parsing cannot fail on a request: what has no meaning is [`Request::Unknown`]. Reserved
//! bits are not looked at, and are zero in what is emitted.

mod abort;
mod block;

pub use abort::AbortCode;
pub use block::{ABORT_COMMAND, BlockRequest, BlockResponse, BlockSegment, MOST_SEGMENTS};

/// The object that a transfer is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Multiplexer {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

impl Multiplexer {
    /// That of an initiate frame: index and sub-index in bytes 1 to 3.
    #[inline]
    pub(crate) const fn of(frame: &[u8; 8]) -> Self {
        // One load: the first word of the frame.
        let [command, low, high, sub, ..] = *frame;
        let word = u32::from_le_bytes([command, low, high, sub]);
        Self {
            index: (word >> 8) as u16,
            sub: (word >> 24) as u8,
        }
    }
}

/// The data part of an initiate frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Payload<'a> {
    /// e = 1, s = 1: the whole value, 1 to 4 bytes.
    Expedited(&'a [u8]),
    /// e = 1, s = 0: the whole value, but its length is for the other side to know.
    ExpeditedUnsized(&'a [u8; 4]),
    /// e = 0: segments follow; s = 1: this many bytes in total.
    Segmented(Option<u32>),
}

/// What a client asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request<'a> {
    /// ccs = 1: write an object.
    InitiateDownload {
        /// Which object.
        object: Multiplexer,
        /// The value, or its size.
        payload: Payload<'a>,
    },
    /// ccs = 0: the next part of the value.
    DownloadSegment {
        /// Alternates, first 0.
        toggle: bool,
        /// 0 to 7 bytes.
        data: &'a [u8],
        /// No more segments.
        last: bool,
    },
    /// ccs = 2: read an object.
    InitiateUpload(
        /// Which object.
        Multiplexer,
    ),
    /// ccs = 3: ask for the next part of the value.
    UploadSegment {
        /// Alternates, first 0.
        toggle: bool,
    },
    /// cs = 4: end of the transfer.
    Abort {
        /// Which object.
        object: Multiplexer,
        /// SDO abort code.
        code: u32,
    },
    /// ccs = 5 and 6: block transfer.
    Block(BlockRequest),
    /// Any other command specifier; the object if it is one of the initiate frames.
    Unknown(Multiplexer),
}

/// What a server answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response<'a> {
    /// scs = 3: written, or ready for segments.
    InitiateDownload(
        /// Which object.
        Multiplexer,
    ),
    /// scs = 1: segment taken.
    DownloadSegment {
        /// As in the request.
        toggle: bool,
    },
    /// scs = 2: the value, or its size.
    InitiateUpload {
        /// Which object.
        object: Multiplexer,
        /// The value, or its size.
        payload: Payload<'a>,
    },
    /// scs = 0: the next part of the value.
    UploadSegment {
        /// As in the request.
        toggle: bool,
        /// 0 to 7 bytes.
        data: &'a [u8],
        /// No more segments.
        last: bool,
    },
    /// cs = 4: refused, or end of the transfer.
    Abort {
        /// Which object.
        object: Multiplexer,
        /// SDO abort code.
        code: u32,
    },
    /// scs = 5 and 6: block transfer.
    Block(BlockResponse),
}

/// Bit 4 of a segment: the toggle bit.
const TOGGLE: u8 = 1 << 4;
/// Bit 0 of a segment: no more segments.
const LAST: u8 = 1 << 0;
/// Bit 1 of an initiate frame (e): the value is in the frame.
const EXPEDITED: u8 = 1 << 1;
/// Bit 0 of an initiate frame (s): the size is indicated.
const SIZED: u8 = 1 << 0;

/// Command specifiers of requests (ccs), in place.
mod client {
    pub const DOWNLOAD_SEGMENT: u8 = 0 << 5;
    pub const INITIATE_DOWNLOAD: u8 = 1 << 5;
    pub const INITIATE_UPLOAD: u8 = 2 << 5;
    pub const UPLOAD_SEGMENT: u8 = 3 << 5;
}

/// Command specifiers of responses (scs), in place.
mod server {
    pub const UPLOAD_SEGMENT: u8 = 0 << 5;
    pub const DOWNLOAD_SEGMENT: u8 = 1 << 5;
    pub const INITIATE_UPLOAD: u8 = 2 << 5;
    pub const INITIATE_DOWNLOAD: u8 = 3 << 5;
}

/// The command specifier of an abort, both ways.
const ABORT: u8 = 4 << 5;

/// The bits of the command specifier in byte 0.
const SPECIFIER: u8 = 7 << 5;

/// The command specifier in byte 0.
const fn specifier(command: u8) -> u8 {
    command & SPECIFIER
}

impl<'a> Request<'a> {
    /// Whether a frame is an abort.
    #[inline]
    pub(crate) const fn is_abort(frame: &[u8; 8]) -> bool {
        let [command, ..] = *frame;
        specifier(command) == ABORT
    }

    /// Whether a frame asks for the next part of a value, with this toggle bit.
    #[inline]
    pub(crate) const fn is_upload_segment(frame: &[u8; 8], toggle: bool) -> bool {
        let [command, ..] = *frame;
        command & (SPECIFIER | TOGGLE) == client::UPLOAD_SEGMENT | toggle_bit(toggle)
    }

    /// Whether a frame is seven bytes of a value that is not over, with this toggle bit.
    #[inline]
    pub(crate) const fn is_full_segment(frame: &[u8; 8], toggle: bool) -> bool {
        let [command, ..] = *frame;
        command == client::DOWNLOAD_SEGMENT | toggle_bit(toggle)
    }

    /// Reads a request.
    #[inline(always)] // The server, which takes it apart at once, is the only hot caller.
    pub fn parse(frame: &'a [u8; 8]) -> Self {
        let [command, ..] = *frame;
        let toggle = command & TOGGLE != 0;
        match specifier(command) {
            client::DOWNLOAD_SEGMENT => Self::DownloadSegment {
                toggle,
                data: segment(frame),
                last: command & LAST != 0,
            },
            client::INITIATE_DOWNLOAD => Self::InitiateDownload {
                object: Multiplexer::of(frame),
                payload: Payload::parse(frame),
            },
            client::INITIATE_UPLOAD => Self::InitiateUpload(Multiplexer::of(frame)),
            client::UPLOAD_SEGMENT => Self::UploadSegment { toggle },
            ABORT => Self::Abort {
                object: Multiplexer::of(frame),
                code: long(frame),
            },
            block::specifier::UPLOAD_REQUEST | block::specifier::DOWNLOAD_REQUEST => {
                Self::Block(BlockRequest::parse(frame))
            }
            _ => Self::Unknown(Multiplexer::of(frame)),
        }
    }

    /// The eight bytes; [`Request::Unknown`] becomes the reserved command specifier 7.
    pub fn emit(&self) -> [u8; 8] {
        match *self {
            Self::InitiateDownload { object, payload } => {
                payload.emit(client::INITIATE_DOWNLOAD, object)
            }
            Self::DownloadSegment { toggle, data, last } => {
                emit_segment(client::DOWNLOAD_SEGMENT, toggle, data, last)
            }
            Self::InitiateUpload(object) => emit_long(client::INITIATE_UPLOAD, object, 0),
            Self::UploadSegment { toggle } => emit_toggle(client::UPLOAD_SEGMENT, toggle),
            Self::Abort { object, code } => emit_long(ABORT, object, code),
            Self::Block(request) => request.emit(),
            Self::Unknown(object) => emit_long(7 << 5, object, 0),
        }
    }
}

impl<'a> Response<'a> {
    /// Reads a response; `None` for command specifiers that are not in [`Response`].
    pub fn parse(frame: &'a [u8; 8]) -> Option<Self> {
        let [command, ..] = *frame;
        let toggle = command & TOGGLE != 0;
        let object = Multiplexer::of(frame);
        Some(match specifier(command) {
            server::UPLOAD_SEGMENT => Self::UploadSegment {
                toggle,
                data: segment(frame),
                last: command & LAST != 0,
            },
            server::DOWNLOAD_SEGMENT => Self::DownloadSegment { toggle },
            server::INITIATE_UPLOAD => Self::InitiateUpload {
                object,
                payload: Payload::parse(frame),
            },
            server::INITIATE_DOWNLOAD => Self::InitiateDownload(object),
            ABORT => Self::Abort {
                object,
                code: long(frame),
            },
            block::specifier::UPLOAD_RESPONSE | block::specifier::DOWNLOAD_RESPONSE => {
                Self::Block(BlockResponse::parse(frame)?)
            }
            _ => return None,
        })
    }

    /// The answer to [`Request::InitiateUpload`] with a number of one to four bytes.
    #[inline]
    pub(crate) fn number(object: Multiplexer, number: u32, size: u16) -> [u8; 8] {
        let empty = 4_u8.wrapping_sub(size as u8) & 3;
        let command = server::INITIATE_UPLOAD | empty << 2 | EXPEDITED | SIZED;
        emit_long(command, object, number)
    }

    /// The eight bytes.
    #[inline(always)] // Where it is called the variant is known: one of the arms remains.
    pub fn emit(&self) -> [u8; 8] {
        match *self {
            Self::InitiateDownload(object) => emit_long(server::INITIATE_DOWNLOAD, object, 0),
            Self::DownloadSegment { toggle } => emit_toggle(server::DOWNLOAD_SEGMENT, toggle),
            Self::InitiateUpload { object, payload } => {
                payload.emit(server::INITIATE_UPLOAD, object)
            }
            Self::UploadSegment { toggle, data, last } => {
                emit_segment(server::UPLOAD_SEGMENT, toggle, data, last)
            }
            Self::Abort { object, code } => emit_long(ABORT, object, code),
            Self::Block(response) => response.emit(),
        }
    }
}

impl<'a> Payload<'a> {
    #[inline]
    fn parse(frame: &'a [u8; 8]) -> Self {
        let [command, _, _, _, data @ ..] = frame;
        let is_sized = command & SIZED != 0;
        if command & EXPEDITED == 0 {
            return Self::Segmented(is_sized.then(|| long(frame)));
        }
        if !is_sized {
            return Self::ExpeditedUnsized(data);
        }
        // n, the number of bytes that hold nothing: 0 to 3.
        let empty = usize::from((command >> 2) & 3);
        Self::Expedited(data.get(..4_usize.saturating_sub(empty)).unwrap_or(data))
    }

    #[inline]
    fn emit(self, specifier: u8, object: Multiplexer) -> [u8; 8] {
        match self {
            Self::Expedited(data) => {
                // As one number: for so few a call of memcpy would cost more than the rest of the answer.
                let (number, empty) = match *data {
                    [a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]), 0),
                    [a, b, c] => (u32::from_le_bytes([a, b, c, 0]), 1),
                    [a, b] => (u16::from_le_bytes([a, b]).into(), 2),
                    [a] => (a.into(), 3),
                    [] => (0, 3),
                };
                let command = specifier | empty << 2 | EXPEDITED | SIZED;
                emit_long(command, object, number)
            }
            Self::ExpeditedUnsized(data) => {
                emit_long(specifier | EXPEDITED, object, u32::from_le_bytes(*data))
            }
            Self::Segmented(Some(size)) => emit_long(specifier | SIZED, object, size),
            Self::Segmented(None) => emit_long(specifier, object, 0),
        }
    }
}

/// The number in bytes 4 to 7.
#[inline]
fn long(frame: &[u8; 8]) -> u32 {
    let [.., a, b, c, d] = *frame;
    u32::from_le_bytes([a, b, c, d])
}

/// The data of a segment: bytes 1 to 7 less the number in bits 1 to 3 of byte 0.
#[inline]
fn segment(frame: &[u8; 8]) -> &[u8] {
    let [command, data @ ..] = frame;
    let empty = usize::from((command >> 1) & 7);
    data.get(..7_usize.saturating_sub(empty)).unwrap_or(data)
}

#[inline]
fn emit_long(command: u8, object: Multiplexer, number: u32) -> [u8; 8] {
    // Two words: put together byte by byte, the compiler would keep the frame in memory.
    let first = u32::from(command) | u32::from(object.index) << 8 | u32::from(object.sub) << 24;
    (u64::from(first) | u64::from(number) << 32).to_le_bytes()
}

#[inline]
fn emit_segment(specifier: u8, toggle: bool, data: &[u8], last: bool) -> [u8; 8] {
    let command = specifier | toggle_bit(toggle) | u8::from(last);
    // All segments but the last one are full.
    if let [a, b, c, d, e, f, g, ..] = *data {
        return [command, a, b, c, d, e, f, g];
    }
    let mut frame = [0; 8];
    let [first, room @ ..] = &mut frame;
    let mut empty = 7_u8;
    for (to, from) in room.iter_mut().zip(data) {
        *to = *from;
        empty = empty.wrapping_sub(1);
    }
    *first = command | (empty & 7) << 1;
    frame
}

#[inline]
fn emit_toggle(specifier: u8, toggle: bool) -> [u8; 8] {
    [specifier | toggle_bit(toggle), 0, 0, 0, 0, 0, 0, 0]
}

const fn toggle_bit(toggle: bool) -> u8 {
    if toggle { TOGGLE } else { 0 }
}

#[cfg(test)]
mod tests;

//! The frames of SDO block transfer (CiA 301, 7.2.4.3.8 to 7.2.4.3.15).
//!
//! Data travels in sub-blocks of up to 127 segments with seven bytes each; only the last segment of a sub-block is
//! confirmed. A segment has no command specifier: byte 0 is its number within the sub-block, 1 to 127, and a bit for the end
//! of all data. So its meaning depends on the transfer, and [`BlockSegment`] is apart from requests and responses.

use super::{ABORT, Multiplexer, emit_long, long};

/// Most segments of a sub-block.
pub const MOST_SEGMENTS: u8 = 127;

/// Byte 0 of an abort, which is no number of a segment.
pub const ABORT_COMMAND: u8 = ABORT;

/// What a client asks in a block transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockRequest {
    /// ccs = 6, cs = 0: write an object.
    InitiateDownload {
        /// Which object.
        object: Multiplexer,
        /// cc: the client makes a checksum.
        crc: bool,
        /// Bytes in total, if indicated (s = 1).
        size: Option<u32>,
    },
    /// ccs = 6, cs = 1: all data is sent.
    EndDownload {
        /// n: bytes of the last segment that hold nothing, 0 to 7.
        empty: u8,
        /// Checksum of all data.
        crc: u16,
    },
    /// ccs = 5, cs = 0: read an object.
    InitiateUpload {
        /// Which object.
        object: Multiplexer,
        /// cc: the client checks the checksum.
        crc: bool,
        /// Segments of a sub-block that the client can take.
        block_size: u8,
        /// pst: up to so many bytes a transfer without blocks will do; 0 for never.
        threshold: u8,
    },
    /// ccs = 5, cs = 1: all data has arrived.
    EndUpload,
    /// ccs = 5, cs = 2: what of a sub-block has arrived.
    Acknowledge {
        /// The last segment before the first gap.
        seqno: u8,
        /// Segments of the next sub-block.
        block_size: u8,
    },
    /// ccs = 5, cs = 3: send the first sub-block.
    StartUpload,
}

/// What a server answers in a block transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockResponse {
    /// scs = 5, ss = 0: ready for the first sub-block.
    InitiateDownload {
        /// Which object.
        object: Multiplexer,
        /// sc: the server checks the checksum.
        crc: bool,
        /// Segments of the first sub-block.
        block_size: u8,
    },
    /// scs = 5, ss = 2: what of a sub-block has arrived.
    Acknowledge {
        /// The last segment before the first gap.
        seqno: u8,
        /// Segments of the next sub-block.
        block_size: u8,
    },
    /// scs = 5, ss = 1: written.
    EndDownload,
    /// scs = 6, ss = 0: the size of the value.
    InitiateUpload {
        /// Which object.
        object: Multiplexer,
        /// sc: the server makes a checksum.
        crc: bool,
        /// Bytes in total, if indicated (s = 1).
        size: Option<u32>,
    },
    /// scs = 6, ss = 1: all data is sent.
    EndUpload {
        /// n: bytes of the last segment that hold nothing, 0 to 7.
        empty: u8,
        /// Checksum of all data.
        crc: u16,
    },
}

/// Command specifiers in place; a client's download and a server's upload have one number, and the other way round.
pub(super) mod specifier {
    pub const DOWNLOAD_REQUEST: u8 = 6 << 5;
    pub const UPLOAD_REQUEST: u8 = 5 << 5;
    pub const DOWNLOAD_RESPONSE: u8 = 5 << 5;
    pub const UPLOAD_RESPONSE: u8 = 6 << 5;
}

/// Bit 2 of an initiate frame (cc, sc): checksum supported.
const CRC: u8 = 1 << 2;
/// Bit 1 of an initiate frame (s): the size is indicated.
const SIZED: u8 = 1 << 1;
/// Bits 0 and 1 (cs, ss): which frame of the transfer.
const SUBCOMMAND: u8 = 3;
const INITIATE: u8 = 0;
const END: u8 = 1;
const ACKNOWLEDGE: u8 = 2;
const START: u8 = 3;

impl BlockRequest {
    /// The unused bytes and the checksum of a frame that ends a download; `None` for any other frame.
    pub(crate) fn end_download(frame: &[u8; 8]) -> Option<(u8, u16)> {
        let [command, low, high, ..] = *frame;
        let is_end = command & (0xE0 | END) == specifier::DOWNLOAD_REQUEST | END;
        is_end.then(|| (command >> 2 & 7, u16::from_le_bytes([low, high])))
    }

    /// Reads a request whose command specifier is one of block transfer.
    pub(super) fn parse(frame: &[u8; 8]) -> Self {
        let [command, first, second, _, data @ ..] = *frame;
        let object = Multiplexer::of(frame);
        let crc = command & CRC != 0;
        if command & 0xE0 == specifier::DOWNLOAD_REQUEST {
            // Here the subcommand has one bit.
            return if command & END == INITIATE {
                Self::InitiateDownload {
                    object,
                    crc,
                    size: (command & SIZED != 0).then(|| long(frame)),
                }
            } else {
                Self::EndDownload {
                    empty: command >> 2 & 7,
                    crc: u16::from_le_bytes([first, second]),
                }
            };
        }
        match command & SUBCOMMAND {
            INITIATE => {
                let [block_size, threshold, _, _] = data;
                Self::InitiateUpload {
                    object,
                    crc,
                    block_size,
                    threshold,
                }
            }
            END => Self::EndUpload,
            ACKNOWLEDGE => Self::Acknowledge {
                seqno: first,
                block_size: second,
            },
            _ => Self::StartUpload,
        }
    }

    /// The eight bytes.
    pub fn emit(&self) -> [u8; 8] {
        match *self {
            Self::InitiateDownload { object, crc, size } => {
                initiate(specifier::DOWNLOAD_REQUEST, object, crc, size)
            }
            Self::EndDownload { empty, crc } => end(specifier::DOWNLOAD_REQUEST, empty, crc),
            Self::InitiateUpload {
                object,
                crc,
                block_size,
                threshold,
            } => {
                let command = specifier::UPLOAD_REQUEST | if crc { CRC } else { 0 };
                let options = u32::from_le_bytes([block_size, threshold, 0, 0]);
                emit_long(command, object, options)
            }
            Self::EndUpload => short(specifier::UPLOAD_REQUEST | END, 0, 0),
            Self::Acknowledge { seqno, block_size } => {
                short(specifier::UPLOAD_REQUEST | ACKNOWLEDGE, seqno, block_size)
            }
            Self::StartUpload => short(specifier::UPLOAD_REQUEST | START, 0, 0),
        }
    }
}

impl BlockResponse {
    /// Reads a response whose command specifier is one of block transfer; `None` if the rest of byte 0 means nothing.
    pub(super) fn parse(frame: &[u8; 8]) -> Option<Self> {
        let [command, first, second, _, data @ ..] = *frame;
        let object = Multiplexer::of(frame);
        let crc = command & CRC != 0;
        if command & 0xE0 == specifier::UPLOAD_RESPONSE {
            return Some(if command & END == INITIATE {
                Self::InitiateUpload {
                    object,
                    crc,
                    size: (command & SIZED != 0).then(|| long(frame)),
                }
            } else {
                Self::EndUpload {
                    empty: command >> 2 & 7,
                    crc: u16::from_le_bytes([first, second]),
                }
            });
        }
        match command & SUBCOMMAND {
            INITIATE => {
                let [block_size, ..] = data;
                Some(Self::InitiateDownload {
                    object,
                    crc,
                    block_size,
                })
            }
            END => Some(Self::EndDownload),
            ACKNOWLEDGE => Some(Self::Acknowledge {
                seqno: first,
                block_size: second,
            }),
            _ => None,
        }
    }

    /// The eight bytes.
    pub fn emit(&self) -> [u8; 8] {
        match *self {
            Self::InitiateDownload {
                object,
                crc,
                block_size,
            } => {
                let command = specifier::DOWNLOAD_RESPONSE | if crc { CRC } else { 0 };
                emit_long(command, object, block_size.into())
            }
            Self::Acknowledge { seqno, block_size } => short(
                specifier::DOWNLOAD_RESPONSE | ACKNOWLEDGE,
                seqno,
                block_size,
            ),
            Self::EndDownload => short(specifier::DOWNLOAD_RESPONSE | END, 0, 0),
            Self::InitiateUpload { object, crc, size } => {
                initiate(specifier::UPLOAD_RESPONSE, object, crc, size)
            }
            Self::EndUpload { empty, crc } => end(specifier::UPLOAD_RESPONSE, empty, crc),
        }
    }
}

/// A segment of a sub-block, either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockSegment {
    /// Its number in the sub-block, 1 to 127.
    pub seqno: u8,
    /// c: no more segments.
    pub last: bool,
    /// Seven bytes; how many of the last segment count is told at the end of the transfer.
    pub data: [u8; 7],
}

impl BlockSegment {
    /// Bit 7 of byte 0 (c).
    pub(crate) const LAST: u8 = 1 << 7;

    /// Reads a segment. Number 0 is no segment: without data to follow it is an abort.
    #[inline]
    pub fn parse(frame: &[u8; 8]) -> Self {
        let [command, data @ ..] = *frame;
        Self {
            seqno: command & !Self::LAST,
            last: command & Self::LAST != 0,
            data,
        }
    }

    /// The eight bytes.
    pub fn emit(&self) -> [u8; 8] {
        let [a, b, c, d, e, f, g] = self.data;
        let last = if self.last { Self::LAST } else { 0 };
        [self.seqno | last, a, b, c, d, e, f, g]
    }
}

fn initiate(specifier: u8, object: Multiplexer, crc: bool, size: Option<u32>) -> [u8; 8] {
    let crc = if crc { CRC } else { 0 };
    let sized = if size.is_some() { SIZED } else { 0 };
    emit_long(specifier | crc | sized, object, size.unwrap_or(0))
}

fn end(specifier: u8, empty: u8, crc: u16) -> [u8; 8] {
    let [low, high] = crc.to_le_bytes();
    short(specifier | END | (empty & 7) << 2, low, high)
}

fn short(command: u8, first: u8, second: u8) -> [u8; 8] {
    [command, first, second, 0, 0, 0, 0, 0]
}

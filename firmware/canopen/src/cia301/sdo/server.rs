//! The SDO server: which transfer is open, and what the next request means to it.

use super::{AbortCode, SDO_BUFFER, TIME_OUT};
use crate::od::{Entry, Unused};
use crate::time::{Instant, NEVER, has_come};
use crate::wire::sdo::{Multiplexer, Request, Response};

/// What a server reads and writes: the object dictionary with every rule that stands before it.
pub trait Objects {
    /// The present value of an object.
    ///
    /// # Errors
    /// It does not exist, cannot be read, or has no value now.
    fn read(&mut self, object: Multiplexer) -> Result<&[u8], AbortCode>;

    /// The descriptor of an object that may be written.
    ///
    /// # Errors
    /// It does not exist or cannot be written.
    fn writable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode>;

    /// Writes a value, after checking its length, its range and the state of the device.
    ///
    /// # Errors
    /// It is refused; nothing has changed.
    fn write(&mut self, entry: &'static Entry, value: &[u8]) -> Result<Completion, AbortCode>;
}

/// When a write that was not refused is complete, and the client gets its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Completion {
    /// At once.
    Now,
    /// When the owner of the object says so ([`crate::Node::complete_write`]): saving parameters takes a while. The server waits
    /// without a time-out; an abort or a new request of the client drops the answer, not the work. An owner that is asked
    /// for the same again before it is done refuses with [`AbortCode::DeviceState`].
    Later,
}

/// The transfer that is open.
#[derive(Clone, Copy, Debug)]
pub(super) enum Transfer {
    /// None.
    Idle,
    /// The client reads the buffer.
    Upload {
        /// Bytes sent.
        position: usize,
    },
    /// The client fills the buffer.
    Download {
        /// What will be written.
        entry: &'static Entry,
        /// The size in bytes that the client has announced.
        announced: Option<usize>,
    },
    /// The value is handed over, and its owner has not finished with it.
    Writing {
        /// The answer that the client gets then.
        answer: [u8; 8],
    },
}

/// An SDO server with one transfer at a time.
#[derive(Debug)]
pub struct Server {
    pub(super) transfer: Transfer,
    /// The object of the open transfer.
    pub(super) object: Multiplexer,
    /// The toggle bit of the next segment.
    pub(super) toggle: bool,
    pub(super) buffer: [u8; SDO_BUFFER],
    /// Bytes of the buffer that are in use.
    pub(super) length: usize,
    deadline: Instant,
}

impl Server {
    /// A server with no transfer open.
    pub const fn new() -> Self {
        Self {
            transfer: Transfer::Idle,
            object: Multiplexer { index: 0, sub: 0 },
            toggle: false,
            buffer: [0; SDO_BUFFER],
            length: 0,
            deadline: NEVER,
        }
    }

    /// Drops the open transfer without a word: the node is stopped or reset.
    pub fn reset(&mut self) {
        self.transfer = Transfer::Idle;
        self.deadline = NEVER;
    }

    /// Takes a request and returns the answer; an abort has none.
    pub fn receive<O: Objects>(
        &mut self,
        request: &[u8; 8],
        now: Instant,
        objects: &mut O,
    ) -> Option<[u8; 8]> {
        let answer = match Request::parse(request) {
            Request::InitiateUpload(object) => self.initiate_upload(object, now, objects),
            Request::InitiateDownload { object, payload } => {
                return self.initiate_download(object, payload, now, objects);
            }
            Request::UploadSegment { toggle } => self.upload_segment(toggle, now),
            Request::DownloadSegment { toggle, data, last } => {
                return self.download_segment(toggle, data, last, now, objects);
            }
            Request::Unknown(object) => self.abort(object, AbortCode::InvalidCommand),
            Request::Abort { .. } => {
                self.reset();
                return None;
            }
        };
        Some(answer)
    }

    /// Takes a request that can have no answer now: an abort ends the open transfer. Returns whether it was one; anything
    /// else does nothing.
    pub fn receive_abort(&mut self, request: &[u8; 8]) -> bool {
        let is_abort = matches!(Request::parse(request), Request::Abort { .. });
        if is_abort {
            self.reset();
        }
        is_abort
    }

    /// The owner of an object has finished a write that it has said [`Completion::Later`] to: the answer, if the client still
    /// waits for it.
    pub fn complete(
        &mut self,
        object: Multiplexer,
        result: Result<(), AbortCode>,
    ) -> Option<[u8; 8]> {
        let Transfer::Writing { answer } = self.transfer else {
            return None;
        };
        if object != self.object {
            return None;
        }
        Some(match result {
            Ok(()) => {
                self.reset();
                answer
            }
            Err(code) => self.abort(object, code),
        })
    }

    /// The answer to a write that was handed over, now or later.
    pub(super) fn written(&mut self, completion: Completion, answer: [u8; 8]) -> Option<[u8; 8]> {
        self.reset();
        match completion {
            Completion::Now => Some(answer),
            Completion::Later => {
                self.transfer = Transfer::Writing { answer };
                None
            }
        }
    }

    /// When [`Server::poll`] has something to do; [`NEVER`] while idle.
    pub fn deadline(&self) -> Instant {
        self.deadline
    }

    /// Aborts a transfer whose client has been silent for too long.
    pub fn poll(&mut self, now: Instant) -> Option<[u8; 8]> {
        has_come(self.deadline, now).then(|| self.abort(self.object, AbortCode::TimedOut))
    }

    /// Whether the time of the open transfer was over when a segment came, though nobody has called [`Server::poll`]
    /// since.
    #[inline]
    pub(super) fn is_too_late(&self, now: Instant) -> bool {
        has_come(self.deadline, now)
    }

    /// The client has answered in time: the next frame may take as long again.
    pub(super) fn wait(&mut self, now: Instant) {
        self.deadline = now + TIME_OUT;
    }

    /// Ends the transfer with this code.
    pub(super) fn abort(&mut self, object: Multiplexer, code: AbortCode) -> [u8; 8] {
        self.reset();
        Response::Abort {
            object,
            code: code.get(),
        }
        .emit()
    }

    /// A segment belongs to no open transfer of its kind. There is no object to name when nothing is open.
    pub(super) fn abort_stray_segment(&mut self) -> [u8; 8] {
        let object = match self.transfer {
            Transfer::Idle => Multiplexer::default(),
            _ => self.object,
        };
        self.abort(object, AbortCode::InvalidCommand)
    }
}

impl Unused for Server {
    const UNUSED: Self = Self::new();
}

impl Default for Server {
    fn default() -> Self {
        Self::new()
    }
}

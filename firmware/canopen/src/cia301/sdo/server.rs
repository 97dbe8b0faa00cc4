//! The SDO server: which transfer is open, and what the next request means to it.

use super::answers::Answers;
use super::block::Block;
use super::objects::{Objects, Streams};
use super::parameters::CobIds;
use super::upload::Ahead;
use super::{AbortCode, Completion, TIME_OUT};
use crate::agenda::Object;
use crate::od::{Entry, Unused};
use crate::time::{Duration, Instant, NEVER, has_come};
use crate::wire::sdo::{BlockRequest, Multiplexer, Request, Response};

/// What the server waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// A new transfer.
    Idle,
    /// The owner of an object that is written, for as long as it takes.
    Writing,
    /// The next request for a segment.
    Upload,
    /// The next segment.
    Download,
    /// The next segment of a sub-block.
    BlockDownload,
    /// The end of a block download, all data being there.
    BlockDownloadEnd,
    /// The client's word to begin with the sub-blocks.
    BlockUploadStart,
    /// The bus: segments of a sub-block leave one by one.
    BlockUpload,
    /// The confirmation of a sub-block; its time-out has not begun yet, as the last segment has just been fetched.
    BlockUploadSent,
    /// The confirmation of a sub-block.
    BlockUploadAcknowledge,
    /// The client's word that it has all data.
    BlockUploadEnd,
    /// The rest of a sub-block that was under way when its transfer was aborted. Its segments are no requests, though they
    /// may look like them.
    Ignoring,
    /// A call with the application at hand, to tell it that its object will not be written further.
    Abandoned,
}

/// Where the bytes of the open transfer are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Nowhere,
    /// Upload: a snapshot in the buffer.
    Snapshot,
    /// Upload: in flash.
    Constant(&'static [u8]),
    /// Upload: with the application.
    Source(&'static Entry),
    /// Download: in the buffer until they are all there.
    Buffer(&'static Entry),
    /// Download: handed to the application, which must learn of the end.
    Sink(&'static Entry),
}

/// An SDO server with one transfer at a time. Values in RAM pass through its buffer `B`.
#[derive(Debug)]
pub struct Server<B> {
    pub(super) step: Step,
    pub(super) place: Place,
    /// The object of the open transfer.
    pub(super) object: Multiplexer,
    /// The toggle bit of the next segment.
    pub(super) toggle: bool,
    /// Bytes in total, if known (upload) or announced (download).
    pub(super) size: Option<u32>,
    /// Most bytes that the object of a download takes.
    pub(super) most: u32,
    /// Bytes sent or taken.
    pub(super) position: u32,
    /// Upload: what the buffer holds of a value that the application gives.
    pub(super) ahead: Ahead,
    pub(super) block: Block,
    pub(super) buffer: B,
    /// The answer for when the owner of an object is done with it.
    confirmation: [u8; 8],
    pub(super) answers: Answers,
    /// The identifier of requests; [`super::NO_COB_ID`] while there are none.
    pub(super) request: u16,
    /// The identifier of answers.
    pub(super) response: u16,
    /// Its bit in the agenda says whether something is to be sent.
    pub(super) sender: Object,
    pub(super) deadline: Instant,
    /// How long the client may be silent.
    pub(super) time_out: Duration,
}

/// All zero; `Server::reset` goes before everything else.
impl<B: Unused> Unused for Server<B> {
    const UNUSED: Self = Self {
        step: Step::Idle,
        place: Place::Nowhere,
        object: Multiplexer { index: 0, sub: 0 },
        toggle: false,
        size: None,
        most: 0,
        position: 0,
        ahead: Ahead::NOTHING,
        block: Block::new(),
        buffer: B::UNUSED,
        confirmation: [0; 8],
        answers: Answers::new(),
        request: 0,
        response: 0,
        sender: Object::BOOT_UP,
        deadline: Instant::from_ticks(0),
        time_out: Duration::from_ticks(0),
    };
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// Whether an answer has room. A request is not to be executed without.
    #[inline]
    pub(crate) fn has_room(&self) -> bool {
        !self.answers.is_full()
    }

    /// Takes a request. Its answer, if it has one now, waits for the bus; there must be room for it.
    #[inline]
    pub(crate) fn receive<O: Objects>(&mut self, request: &[u8; 8], now: Instant, objects: &mut O) {
        let step = self.step;
        if O::HAVE_BLOCK_TRANSFER && self.is_open() {
            match step {
                Step::BlockDownload => return self.take_block_segment(request, now, objects),
                Step::BlockDownloadEnd | Step::Ignoring if self.is_rest_of_block(request, now) => {
                    return;
                }
                _ => {}
            }
        }
        match Request::parse(request) {
            Request::InitiateUpload(object) => self.initiate_upload(object, now, objects),
            Request::InitiateDownload { object, payload } => {
                self.initiate_download(object, payload, now, objects);
            }
            Request::UploadSegment { toggle } => self.upload_segment(toggle, now, objects),
            Request::DownloadSegment { toggle, data, last } => {
                self.download_segment(toggle, data, last, now, objects);
            }
            Request::Block(request) if O::HAVE_BLOCK_TRANSFER => {
                self.receive_block(request, now, objects);
            }
            Request::Block(_) => {
                self.abort(Multiplexer::of(request), AbortCode::InvalidCommand, objects);
            }
            Request::Unknown(object) => self.abort(object, AbortCode::InvalidCommand, objects),
            Request::Abort { .. } => self.drop_transfer(objects),
        }
    }

    #[inline(never)]
    fn receive_block<O: Objects>(&mut self, request: BlockRequest, now: Instant, objects: &mut O) {
        match request {
            BlockRequest::InitiateDownload { object, crc, size } => {
                self.initiate_block_download(object, crc, size, now, objects);
            }
            BlockRequest::EndDownload { empty, crc } => {
                self.end_block_download(empty, crc, now, objects);
            }
            BlockRequest::InitiateUpload {
                object,
                crc,
                block_size,
                threshold,
            } => self.initiate_block_upload(object, crc, block_size, threshold, now, objects),
            BlockRequest::StartUpload => self.start_block_upload(now, objects),
            BlockRequest::Acknowledge { seqno, block_size } => {
                self.acknowledge_block_upload(seqno, block_size, now, objects);
            }
            BlockRequest::EndUpload => self.end_block_upload(now, objects),
        }
    }

    /// Takes a request that can have no answer now: an abort ends the open transfer. Returns whether it was one; anything
    /// else does nothing.
    pub(crate) fn receive_abort<S: Streams>(&mut self, request: &[u8; 8], streams: &mut S) -> bool {
        let is_abort = Request::is_abort(request);
        if is_abort {
            self.drop_transfer(streams);
        }
        is_abort
    }

    /// The next segment of a block upload.
    #[inline]
    pub(super) fn segment<S: Streams>(&mut self, streams: &mut S) -> Option<[u8; 8]> {
        let is_next = S::HAVE_BLOCK_TRANSFER && self.step == Step::BlockUpload;
        is_next.then(|| self.send_block_segment(streams))
    }

    /// Whether something is to be sent.
    #[inline]
    pub(super) fn is_pending(&self) -> bool {
        !self.answers.is_empty() || self.step == Step::BlockUpload
    }

    /// Whether the time-out for the confirmation of a sub-block is to begin.
    #[inline]
    pub(super) fn has_sent_sub_block(&self) -> bool {
        self.step == Step::BlockUploadSent
    }

    /// The owner of an object has finished a write that it has said [`Completion::Later`] to: the client gets its answer, if it
    /// still waits for it.
    pub(super) fn complete(&mut self, object: Multiplexer, result: Result<(), AbortCode>) {
        if self.step != Step::Writing || object != self.object {
            return;
        }
        self.idle();
        self.answers.push(match result {
            Ok(()) => self.confirmation,
            Err(code) => abort_message(object, code),
        });
    }

    /// Whether a transfer is open.
    #[inline]
    pub(super) fn is_open(&self) -> bool {
        self.step != Step::Idle
    }

    /// When [`Server::poll`] has something to do; [`NEVER`] while idle.
    #[inline]
    pub(super) fn deadline(&self) -> Instant {
        self.deadline
    }

    /// Lets time pass: a client that has been silent for too long is told that its transfer is over.
    pub(super) fn poll<S: Streams>(&mut self, now: Instant, streams: &mut S) {
        if !has_come(self.deadline, now) {
            return;
        }
        match self.step {
            Step::Idle | Step::Writing | Step::Ignoring | Step::Abandoned => {
                self.drop_transfer(streams);
            }
            // The client's time begins when it has been told.
            Step::BlockUpload if S::HAVE_BLOCK_TRANSFER => self.wait(now),
            Step::BlockUploadSent if S::HAVE_BLOCK_TRANSFER => {
                self.step = Step::BlockUploadAcknowledge;
                self.wait(now);
            }
            _ if !self.answers.is_empty() => self.wait(now),
            Step::BlockDownload
                if S::HAVE_BLOCK_TRANSFER && !has_come(self.end_of_patience(), now) =>
            {
                self.remind();
            }
            // After so long a silence nothing of a sub-block is under way: what comes next is a request.
            _ => self.abort(self.object, AbortCode::TimedOut, streams),
        }
    }

    /// Drops the open transfer without a word, and what waits for the bus: the NMT state has no SDO any more.
    pub(super) fn reset(&mut self) {
        self.answers.clear();
        self.request = super::NO_COB_ID;
        if self.time_out.ticks() == 0 {
            self.time_out = TIME_OUT;
        }
        self.close();
    }

    /// Drops the open transfer; the application learns of it later.
    fn close(&mut self) {
        if matches!(self.place, Place::Sink(_)) {
            self.step = Step::Abandoned;
            self.deadline = Instant::from_ticks(0);
        } else {
            self.idle();
        }
    }

    /// Listens to other identifiers, or to none. Nothing happens if they are the present ones.
    pub(super) fn configure(&mut self, cob_ids: Option<CobIds>) {
        let request = cob_ids.map_or(super::NO_COB_ID, |cob_ids| cob_ids.request);
        let response = cob_ids.map_or(self.response, |cob_ids| cob_ids.response);
        if request != self.request || response != self.response {
            self.request = request;
            self.response = response;
            self.close();
        }
    }

    /// Whether a client writes this object here, piece by piece.
    pub(super) fn is_writing(&self, entry: &Entry) -> bool {
        matches!(self.place, Place::Sink(sink) if sink.key() == entry.key())
    }

    /// Whether a client reads this object here, piece by piece.
    pub(super) fn is_reading(&self, entry: &Entry) -> bool {
        matches!(self.place, Place::Source(source) if source.key() == entry.key())
    }

    /// Whether the time of the open transfer was over when a frame came, though nobody has called [`Server::poll`] since.
    #[inline]
    pub(super) fn is_too_late(&self, now: Instant) -> bool {
        has_come(self.deadline, now) && self.has_timed_out(now)
    }

    /// The deadline has come; it is not always the end.
    #[cold]
    #[inline(never)]
    fn has_timed_out(&self, now: Instant) -> bool {
        match self.step {
            Step::BlockUpload | Step::BlockUploadSent => false,
            Step::BlockDownload => has_come(self.end_of_patience(), now),
            _ => true,
        }
    }

    /// The client has answered in time: the next frame may take as long again.
    #[inline]
    pub(super) fn wait(&mut self, now: Instant) {
        self.deadline = now + self.time_out;
    }

    /// Nothing is open any more.
    #[inline]
    pub(super) fn idle(&mut self) {
        self.step = Step::Idle;
        self.place = Place::Nowhere;
        self.deadline = NEVER;
    }

    /// A new transfer begins: one that is open ends without a word to the client.
    #[inline]
    pub(super) fn begin<S: Streams>(&mut self, streams: &mut S) {
        if self.is_open() {
            self.drop_transfer(streams);
        }
    }

    /// Ends the open transfer without a word to the client.
    #[inline]
    pub(super) fn drop_transfer<S: Streams>(&mut self, streams: &mut S) {
        if let Place::Sink(entry) = self.place
            && S::ARE_THERE
        {
            streams.abandon_write(entry);
        }
        self.idle();
    }

    /// The answer to a write that was handed over, now or later.
    #[inline]
    pub(super) fn written(&mut self, completion: Completion, answer: [u8; 8]) {
        self.idle();
        match completion {
            Completion::Now => self.answers.push(answer),
            Completion::Later => {
                self.step = Step::Writing;
                self.confirmation = answer;
            }
        }
    }

    /// Ends the open transfer with this code.
    #[cold]
    #[inline(never)]
    pub(super) fn abort<S: Streams>(
        &mut self,
        object: Multiplexer,
        code: AbortCode,
        streams: &mut S,
    ) {
        self.drop_transfer(streams);
        self.answers.push(abort_message(object, code));
    }

    /// A frame belongs to no open transfer of its kind. There is no object to name when nothing is open.
    #[cold]
    #[inline(never)]
    pub(super) fn stray(&mut self) -> AbortCode {
        if matches!(self.step, Step::Idle | Step::Ignoring) {
            self.object = Multiplexer::default();
        }
        AbortCode::InvalidCommand
    }
}

pub(super) fn abort_message(object: Multiplexer, code: AbortCode) -> [u8; 8] {
    Response::Abort {
        object,
        code: code.get(),
    }
    .emit()
}

//! A client of all four long transfers, as it has to be on a bus that loses frames: it goes on where the protocol lets it, and
//! gives up where not. Times in milliseconds.

use std::collections::VecDeque;
use std::vec::Vec;

use crate::cia301::sdo::crc;
use crate::wire::sdo::{
    BlockRequest, BlockResponse, BlockSegment, Multiplexer, Payload, Request, Response,
};

/// Silence after which a client confirms a sub-block that has not come to its end.
const PATIENCE: u64 = 300;
/// Silence after which it gives up.
const TIME_OUT: u64 = 2500;

/// How a transfer ended: with these bytes (uploaded, or those downloaded), or with an abort.
pub(super) type Outcome = Result<Vec<u8>, ()>;

/// What is to be done.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) object: Multiplexer,
    pub(super) is_block: bool,
    pub(super) has_crc: bool,
    pub(super) tells_size: bool,
    /// Sizes of the sub-blocks to ask for, in turn.
    pub(super) block_sizes: Vec<u8>,
    /// To write; `None` to read.
    pub(super) value: Option<Vec<u8>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Initiated,
    /// Sending segments of a sub-block up to this one.
    Sending(u8),
    /// The server's confirmation, or the next segment.
    Waiting,
    Ending,
}

#[derive(Debug)]
pub(super) struct Client {
    task: Task,
    step: Step,
    data: Vec<u8>,
    size: Option<u32>,
    toggle: bool,
    /// Bytes that the server has for sure.
    base: usize,
    seqno: u8,
    block_size: u8,
    sub_blocks: usize,
    closing: u8,
    was_last: bool,
    is_reminded: bool,
    heard: u64,
    outbox: VecDeque<[u8; 8]>,
    outcome: Option<Outcome>,
}

impl Client {
    pub(super) fn new(task: Task, now: u64) -> Self {
        let mut client = Self {
            step: Step::Initiated,
            data: task.value.clone().unwrap_or_default(),
            size: None,
            toggle: false,
            base: 0,
            seqno: 0,
            block_size: 0,
            sub_blocks: 0,
            closing: 0,
            was_last: false,
            is_reminded: false,
            heard: now,
            outbox: VecDeque::new(),
            outcome: None,
            task,
        };
        let object = client.task.object;
        let crc = client.task.has_crc;
        let size = client.task.tells_size.then_some(client.data.len() as u32);
        let request = match (client.task.value.is_some(), client.task.is_block) {
            (true, true) => Request::Block(BlockRequest::InitiateDownload { object, crc, size }),
            (true, false) => Request::InitiateDownload {
                object,
                payload: Payload::Segmented(size),
            },
            (false, true) => Request::Block(BlockRequest::InitiateUpload {
                object,
                crc,
                block_size: client.next_block_size(),
                threshold: 0,
            }),
            (false, false) => Request::InitiateUpload(object),
        };
        client.outbox.push_back(request.emit());
        client
    }

    pub(super) fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// Gives up.
    pub(super) fn abort(&mut self) {
        let object = self.task.object;
        self.outbox.clear();
        self.outbox
            .push_back(Request::Abort { object, code: 0 }.emit());
        self.outcome = Some(Err(()));
    }

    /// The next frame to send.
    pub(super) fn transmit(&mut self) -> Option<[u8; 8]> {
        if let Some(frame) = self.outbox.pop_front() {
            return Some(frame);
        }
        let Step::Sending(last) = self.step else {
            return None;
        };
        if self.outcome.is_some() {
            return None;
        }
        self.seqno += 1;
        let start = self.base + 7 * usize::from(self.seqno - 1);
        let rest = self.data.get(start..).unwrap_or(&[]);
        let mut data = [0; 7];
        for (to, from) in data.iter_mut().zip(rest) {
            *to = *from;
        }
        self.was_last = rest.len() <= 7;
        let frame = BlockSegment {
            seqno: self.seqno,
            last: self.was_last,
            data,
        };
        if self.was_last || self.seqno == last {
            self.step = Step::Waiting;
        }
        Some(frame.emit())
    }

    pub(super) fn poll(&mut self, now: u64) {
        if self.outcome.is_some() {
            return;
        }
        let silence = now - self.heard;
        let is_block_upload = self.task.is_block && self.task.value.is_none();
        if silence >= TIME_OUT {
            self.abort();
        } else if silence >= PATIENCE
            && is_block_upload
            && self.step == Step::Waiting
            && !self.is_reminded
        {
            self.is_reminded = true;
            self.confirm(0);
        }
    }

    pub(super) fn receive(&mut self, frame: &[u8; 8], now: u64) {
        if self.outcome.is_some() {
            return;
        }
        self.heard = now;
        if self.task.is_block && self.task.value.is_none() && self.step == Step::Waiting {
            self.take_block_segment(frame);
            return;
        }
        match (self.step, Response::parse(frame)) {
            (_, Some(Response::Abort { .. })) => self.outcome = Some(Err(())),
            (Step::Initiated, Some(Response::InitiateUpload { payload, .. })) => match payload {
                Payload::Expedited(data) => self.outcome = Some(Ok(data.to_vec())),
                Payload::Segmented(size) => {
                    self.size = size;
                    self.step = Step::Waiting;
                    self.ask();
                }
                Payload::ExpeditedUnsized(_) => self.abort(),
            },
            (Step::Waiting, Some(Response::UploadSegment { toggle, data, last }))
                if toggle == self.toggle && self.task.value.is_none() =>
            {
                self.data.extend_from_slice(data);
                self.toggle = !toggle;
                if last {
                    self.end_upload();
                } else {
                    self.ask();
                }
            }
            (Step::Initiated, Some(Response::InitiateDownload(_))) => {
                self.step = Step::Waiting;
                self.give();
            }
            (Step::Waiting, Some(Response::DownloadSegment { toggle }))
                if toggle != self.toggle && !self.task.is_block =>
            {
                if self.base >= self.data.len() {
                    self.outcome = Some(Ok(self.data.clone()));
                } else {
                    self.give();
                }
            }
            (step, Some(Response::Block(response))) => self.receive_block(step, response),
            _ => self.abort(),
        }
    }

    fn receive_block(&mut self, step: Step, response: BlockResponse) {
        match (step, response) {
            (Step::Initiated, BlockResponse::InitiateUpload { size, .. }) => {
                self.size = size;
                self.step = Step::Waiting;
                let start = Request::Block(BlockRequest::StartUpload);
                self.outbox.push_back(start.emit());
            }
            (Step::Initiated, BlockResponse::InitiateDownload { block_size, .. }) => {
                self.step = Step::Sending(block_size);
            }
            (
                Step::Sending(_) | Step::Waiting,
                BlockResponse::Acknowledge { seqno, block_size },
            ) if self.task.value.is_some() && seqno <= self.seqno => {
                let is_end = self.was_last && seqno == self.seqno;
                self.base += 7 * usize::from(seqno);
                self.seqno = 0;
                if is_end {
                    self.step = Step::Ending;
                    let empty = (7 - self.data.len() % 7) % 7;
                    let empty = if self.data.is_empty() { 7 } else { empty as u8 };
                    let crc = if self.task.has_crc {
                        crc::add(0, &self.data)
                    } else {
                        0
                    };
                    let end = Request::Block(BlockRequest::EndDownload { empty, crc });
                    self.outbox.push_back(end.emit());
                } else {
                    self.was_last = false;
                    self.step = Step::Sending(block_size);
                }
            }
            (Step::Ending, BlockResponse::EndDownload) => {
                self.outcome = Some(Ok(self.data.clone()));
            }
            (Step::Ending, BlockResponse::EndUpload { empty, crc }) => {
                let length = self.data.len().saturating_sub(empty.into());
                self.data.truncate(length);
                if self.task.has_crc && crc::add(0, &self.data) != crc {
                    self.abort();
                    return;
                }
                let end = Request::Block(BlockRequest::EndUpload);
                self.outbox.push_back(end.emit());
                self.end_upload();
            }
            _ => self.abort(),
        }
    }

    fn take_block_segment(&mut self, frame: &[u8; 8]) {
        if frame[0] == 0x80 {
            self.outcome = Some(Err(()));
            return;
        }
        let segment = BlockSegment::parse(frame);
        self.is_reminded = false;
        if segment.seqno == self.seqno + 1 {
            self.seqno += 1;
            self.data.extend_from_slice(&segment.data);
            self.was_last = segment.last;
        } else if segment.seqno <= self.seqno || (self.seqno == 0 && frame[0] == self.closing) {
            return;
        }
        if segment.last || segment.seqno >= self.block_size {
            self.confirm(frame[0]);
        }
    }

    /// Confirms a sub-block; another one begins, or the end.
    fn confirm(&mut self, closing: u8) {
        let seqno = self.seqno;
        let block_size = self.next_block_size();
        let request = Request::Block(BlockRequest::Acknowledge { seqno, block_size });
        self.outbox.push_back(request.emit());
        self.seqno = 0;
        self.closing = closing;
        if self.was_last {
            self.step = Step::Ending;
        }
    }

    fn next_block_size(&mut self) -> u8 {
        let sizes = &self.task.block_sizes;
        self.block_size = sizes[self.sub_blocks % sizes.len()];
        self.sub_blocks += 1;
        self.block_size
    }

    /// Asks for the next segment.
    fn ask(&mut self) {
        let toggle = self.toggle;
        self.outbox
            .push_back(Request::UploadSegment { toggle }.emit());
    }

    /// Sends the next segment.
    fn give(&mut self) {
        let rest = &self.data[self.base..];
        let data = &rest[..rest.len().min(7)];
        let request = Request::DownloadSegment {
            toggle: self.toggle,
            data,
            last: data.len() == rest.len(),
        };
        self.outbox.push_back(request.emit());
        self.base += data.len();
        self.toggle = !self.toggle;
    }

    fn end_upload(&mut self) {
        let is_right = self
            .size
            .is_none_or(|size| size as usize == self.data.len());
        self.outcome = Some(if is_right {
            Ok(self.data.clone())
        } else {
            Err(())
        });
    }
}

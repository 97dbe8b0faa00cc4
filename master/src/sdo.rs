//! The SDO client: expedited and segmented transfers, on the default channel (600h and 580h + node-ID) unless another server is chosen.
//!
//! The channel is meant for one client (CiA 301, 7.2.4.1), and people have more: a tool beside the master of the machine. Each hears the
//! answers to all. Those that begin or refuse a transfer name its object, so this client passes by what is for others. A transfer in
//! segments that another one has ended is begun anew when the server has been silent for a while, as is a read that had no answer while others had theirs. A short write that had none is
//! not repeated, as it may have been carried out: only if the server says that it was not.

use std::fmt;
use std::ops::RangeInclusive;

use canopen::{Duration, Frame, Instant};

use crate::{Failure, Line, Master};

/// A number or string as it travels in an SDO.
pub trait Value: Sized {
    /// From the bytes of an upload; `None` if their length does not fit.
    fn from_bytes(bytes: &[u8]) -> Option<Self>;
    /// The bytes of a download.
    fn to_bytes(&self) -> Vec<u8>;
}

macro_rules! numbers {
    ($($number:ty),*) => { $(
        impl Value for $number {
            fn from_bytes(bytes: &[u8]) -> Option<Self> {
                Some(<$number>::from_le_bytes(bytes.try_into().ok()?))
            }
            fn to_bytes(&self) -> Vec<u8> {
                self.to_le_bytes().to_vec()
            }
        }
    )* };
}

numbers!(u8, u16, u32, u64, i8, i16, i32, i64);

impl Value for String {
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Self::from_utf8(bytes.to_vec()).ok()
    }
    fn to_bytes(&self) -> Vec<u8> {
        self.as_bytes().to_vec()
    }
}

impl Value for Vec<u8> {
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Some(bytes.to_vec())
    }
    fn to_bytes(&self) -> Vec<u8> {
        self.clone()
    }
}

/// The identifiers of an SDO server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoChannel {
    /// Of the client's frames.
    pub request: u16,
    /// Of the server's.
    pub answer: u16,
}

impl<L: Line> Master<L> {
    /// From now on this node is read and written through another of its servers.
    pub fn set_sdo_channel(&mut self, node: u8, channel: SdoChannel) {
        self.sdo_channels.insert(node, channel);
    }

    /// The channel of a node.
    pub(super) fn channel(&self, node: u8) -> SdoChannel {
        let default = SdoChannel {
            request: 0x600 + u16::from(node),
            answer: 0x580 + u16::from(node),
        };
        self.sdo_channels.get(&node).copied().unwrap_or(default)
    }

    /// Tells the server of a node that its transfer is over (CiA 301, 7.2.4.3.17).
    pub fn abort_sdo(&mut self, node: u8, index: u16, sub: u8, code: u32) {
        let abort = Object::new(index, sub).request(ABORT, code.to_le_bytes());
        self.send_data(self.channel(node).request, &abort);
    }

    /// Reads an object.
    ///
    /// # Errors
    /// [`Failure::Abort`] if the device refuses, [`Failure::WrongValue`] if the length does not fit the type,
    /// [`Failure::Timeout`] or [`Failure::Unexpected`] if the device does not keep to the protocol.
    pub fn read<T: Value>(&mut self, node: u8, index: u16, sub: u8) -> Result<T, Failure> {
        let bytes = self.repeated(node, |master| master.upload(node, index, sub))?;
        T::from_bytes(&bytes).ok_or_else(|| Failure::WrongValue {
            expected: format!("{index:04X}h:{sub:02X} as {}", std::any::type_name::<T>()),
            got: format!("{bytes:02X?}"),
        })
    }

    /// Writes an object, expedited up to four bytes, segmented beyond.
    ///
    /// # Errors
    /// As [`Master::read`]. After [`Failure::Unexpected`] or [`Failure::Timeout`] the value may have been written.
    pub fn write<T: Value>(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        value: T,
    ) -> Result<(), Failure> {
        let bytes = value.to_bytes();
        match bytes.len() {
            1..=4 => self.download_once(node, index, sub, &bytes),
            _ => self.download_segmented(node, index, sub, &bytes),
        }
    }

    /// Sends one SDO request and waits for the answer that `is_own` knows. Answers to other clients are passed by.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if no answer came, [`Failure::Unexpected`] with the last one if none was it.
    pub(super) fn exchange(
        &mut self,
        node: u8,
        request: [u8; 8],
        is_own: impl Fn(&[u8; 8]) -> bool,
    ) -> Result<[u8; 8], Failure> {
        let SdoChannel {
            request: request_id,
            answer: answer_id,
        } = self.channel(node);
        let expected = format!("an SDO answer {answer_id:03X}");
        let answer = |frame: &Frame| (frame.standard_id() == Some(answer_id)).then_some(*frame);
        // Answers nobody waited for would be taken for this one's.
        while self.line.inbox().take_from(0, answer).is_some() {}
        self.send_data(request_id, &request);
        let end = self.now() + self.answer_time;
        let mut stranger = None;
        loop {
            let left = time_until(end, self.now());
            match (self.wait_for(&expected, left, answer), stranger) {
                (Ok(frame), _) => match frame.full_payload() {
                    Some(payload) if is_own(payload) => return Ok(*payload),
                    _ => stranger = Some(frame),
                },
                (Err(Failure::Timeout { at, .. }), Some(got)) => {
                    let expected = "the answer to this SDO request".to_owned();
                    return Err(Failure::Unexpected { expected, got, at });
                }
                (Err(Failure::Timeout { expected, at, .. }), None) => {
                    let within = self.answer_time;
                    return Err(Failure::Timeout {
                        expected,
                        within,
                        at,
                    });
                }
                (Err(failure), _) => return Err(failure),
            }
        }
    }

    fn upload(&mut self, node: u8, index: u16, sub: u8) -> Result<Vec<u8>, Failure> {
        let object = Object::new(index, sub);
        let request = object.request(0x40, [0; 4]);
        let answer = self.begin(node, object, request, |command| command & 0xE0 == 0x40)?;
        let [command, _, _, _, data @ ..] = answer;
        if command & 0x02 != 0 {
            let unused = if command & 0x01 != 0 {
                usize::from(command >> 2 & 0x03)
            } else {
                0
            };
            return Ok(data[..4 - unused].to_vec());
        }
        let announced = (command & 0x01 != 0).then(|| u32::from_le_bytes(data));
        let mut bytes = Vec::new();
        let mut toggle = 0x00;
        loop {
            let request = [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0];
            let answer = self.go_on(node, object, request, |command| command & 0xF0 == toggle)?;
            let [command, data @ ..] = answer;
            let part = &data[..7 - usize::from(command >> 1 & 0x07)];
            bytes.extend_from_slice(part);
            toggle ^= 0x10;
            if command & 0x01 != 0 {
                break;
            }
            if part.is_empty() {
                return Err(self.endless(node, object, "an empty segment"));
            }
            self.unless_endless(node, object, bytes.len(), announced)?;
        }
        match announced {
            Some(size) if size as usize != bytes.len() => Err(Failure::WrongValue {
                expected: format!("{size} bytes of {object}"),
                got: format!("{} bytes", bytes.len()),
            }),
            _ => Ok(bytes),
        }
    }

    /// What has come of an object is no more than was announced, or than is ever read; else the transfer is aborted.
    pub(super) fn unless_endless(
        &mut self,
        node: u8,
        object: Object,
        length: usize,
        announced: Option<u32>,
    ) -> Result<(), Failure> {
        let announced = announced.and_then(|size| usize::try_from(size).ok());
        let limit = self.longest_upload.min(announced.unwrap_or(usize::MAX));
        if length <= limit {
            return Ok(());
        }
        Err(self.endless(node, object, &format!("{limit} bytes")))
    }

    fn endless(&mut self, node: u8, object: Object, limit: &str) -> Failure {
        let abort = object.request(ABORT, TOO_LONG.to_le_bytes());
        self.send_data(self.channel(node).request, &abort);
        Failure::Endless {
            what: object.to_string(),
            limit: limit.to_owned(),
        }
    }

    fn download_expedited(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        let object = Object::new(index, sub);
        let unused = 4 - bytes.len() as u8;
        let mut data = [0; 4];
        data[..bytes.len()].copy_from_slice(bytes);
        let request = object.request(0x23 | unused << 2, data);
        self.begin(node, object, request, |command| command == 0x60)?;
        Ok(())
    }

    /// Again only if the server has refused it as out of step.
    fn download_once(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        for _ in 1..ATTEMPTS {
            match self.download_expedited(node, index, sub, bytes) {
                Err(Failure::Abort { code, .. }) if OUT_OF_STEP.contains(&code) => {
                    self.wait_for_silence(node)?;
                }
                result => return result,
            }
        }
        self.download_expedited(node, index, sub, bytes)
    }

    /// Writes an object in segments, whatever its length.
    ///
    /// # Errors
    /// As [`Master::read`].
    pub fn download_segmented(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        self.repeated(node, |master| master.download(node, index, sub, bytes))
    }

    fn download(&mut self, node: u8, index: u16, sub: u8, bytes: &[u8]) -> Result<(), Failure> {
        let object = Object::new(index, sub);
        let request = object.request(0x21, (bytes.len() as u32).to_le_bytes());
        self.begin(node, object, request, |command| command == 0x60)?;
        let mut toggle = 0x00;
        let mut rest = bytes;
        loop {
            let (part, after) = rest.split_at(rest.len().min(7));
            let mut request = [0; 8];
            request[0] = toggle | (7 - part.len() as u8) << 1 | u8::from(after.is_empty());
            request[1..=part.len()].copy_from_slice(part);
            self.go_on(node, object, request, |command| command == 0x20 | toggle)?;
            if after.is_empty() {
                return Ok(());
            }
            rest = after;
            toggle ^= 0x10;
        }
    }

    /// The first request of a transfer and its answer; an abort of the device is a failure. Both name the object.
    fn begin(
        &mut self,
        node: u8,
        object: Object,
        request: [u8; 8],
        is_good: impl Fn(u8) -> bool,
    ) -> Result<[u8; 8], Failure> {
        let answer = self.exchange(node, request, |answer| match answer[0] {
            ABORT => object.is_refused_by(answer),
            command => is_good(command) && object.is_named_by(answer),
        })?;
        object.unless_aborted(answer)
    }

    /// A later request of a transfer and its answer, which names no object. One that names another, because it begins or refuses another
    /// transfer, tells that this one is over: the next request would go to that one.
    fn go_on(
        &mut self,
        node: u8,
        object: Object,
        request: [u8; 8],
        is_good: impl Fn(u8) -> bool,
    ) -> Result<[u8; 8], Failure> {
        let of_other = |answer: &[u8; 8]| {
            answer[0] >= 0x40 && !object.is_named_by(answer) && !object.is_refused_by(answer)
        };
        let answer_id = self.channel(node).answer;
        let displaced = (self.line.inbox()).take_from(0, |frame| {
            let answer = frame.full_payload().copied().filter(of_other);
            answer.filter(|_| frame.standard_id() == Some(answer_id))
        });
        if let Some(answer) = displaced {
            return Err(self.unexpected(node, answer));
        }
        let answer = self.exchange(node, request, |answer| !of_other(answer))?;
        match answer[0] {
            ABORT if object.is_refused_by(&answer) => object.unless_aborted(answer),
            command if is_good(command) => Ok(answer),
            _ => Err(self.unexpected(node, answer)),
        }
    }

    pub(super) fn unexpected(&self, node: u8, answer: [u8; 8]) -> Failure {
        Failure::Unexpected {
            expected: "the answer to this SDO request".to_owned(),
            got: Frame::data_frame(self.channel(node).answer, &answer),
            at: self.now(),
        }
    }

    /// A transfer that may have been disturbed by another client is tried again.
    fn repeated<T>(
        &mut self,
        node: u8,
        mut transfer: impl FnMut(&mut Self) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        for _ in 1..ATTEMPTS {
            match transfer(self) {
                Err(Failure::Unexpected { .. } | Failure::WrongValue { .. }) => {}
                Err(Failure::Abort { code, .. }) if OUT_OF_STEP.contains(&code) => {}
                result => return result,
            }
            self.wait_for_silence(node)?;
        }
        transfer(self)
    }

    /// Lets another client have its turn: waits until nothing was sent to this server or by it for a while, but not for ever. How long the
    /// while is differs from time to time, so that two clients that wait for each other do not begin together.
    fn wait_for_silence(&mut self, node: u8) -> Result<(), Failure> {
        let channel = self.channel(node);
        let of_server = |frame: &Frame| {
            let id = frame.standard_id();
            (id == Some(channel.request) || id == Some(channel.answer)).then_some(())
        };
        let end = self.now() + LONGEST_TURN;
        loop {
            while self.line.inbox().take_from(0, of_server).is_some() {}
            let silence = SHORTEST_SILENCE * (1 + (self.now().ticks() / 7 % 8) as u32);
            match self.wait_for("silence", silence, of_server) {
                Ok(()) if self.now() < end => {}
                Ok(()) | Err(Failure::Timeout { .. }) => return Ok(()),
                Err(failure) => return Err(failure),
            }
        }
    }
}

/// How often a transfer is begun at most.
const ATTEMPTS: u32 = 8;

/// For how long another client is let to have its turn at most.
const LONGEST_TURN: Duration = Duration::from_ticks(1_000_000);

/// How long a server is silent at least between two transfers of others.
const SHORTEST_SILENCE: Duration = Duration::from_ticks(3_000);

/// The abort code for an object that is too long (CiA 301).
const TOO_LONG: u32 = 0x0607_0012;

/// The command of an abort.
pub(super) const ABORT: u8 = 0x80;

/// Abort codes of a server for a request that does not fit its open transfer: toggle bit, time-out, command specifier.
const OUT_OF_STEP: RangeInclusive<u32> = 0x0503_0000..=0x0504_0001;

/// What a transfer is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Object {
    index: u16,
    sub: u8,
}

impl Object {
    pub(super) const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }

    /// The frame that begins a transfer of it.
    pub(super) fn request(self, command: u8, [a, b, c, d]: [u8; 4]) -> [u8; 8] {
        let [low, high] = self.index.to_le_bytes();
        [command, low, high, self.sub, a, b, c, d]
    }

    pub(super) fn is_named_by(self, answer: &[u8; 8]) -> bool {
        let [low, high] = self.index.to_le_bytes();
        answer[1..4] == [low, high, self.sub]
    }

    /// Whether an abort is of a transfer of this object. A server that knows of no transfer names no object.
    pub(super) fn is_refused_by(self, answer: &[u8; 8]) -> bool {
        answer[0] == ABORT && (self.is_named_by(answer) || answer[1..4] == [0; 3])
    }

    /// An abort is a failure.
    pub(super) fn unless_aborted(self, answer: [u8; 8]) -> Result<[u8; 8], Failure> {
        match answer {
            [ABORT, _, _, _, code @ ..] => Err(Failure::Abort {
                index: self.index,
                sub: self.sub,
                code: u32::from_le_bytes(code),
            }),
            _ => Ok(answer),
        }
    }
}

impl fmt::Display for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h:{:02X}", self.index, self.sub)
    }
}

/// What is left of a time.
fn time_until(end: Instant, now: Instant) -> Duration {
    end.checked_duration_since(now)
        .unwrap_or(Duration::from_ticks(0))
}

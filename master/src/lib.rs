//! A CANopen master: for the demonstration and for tests on the simulated bus, for the tool `axis402` on real ones.
//!
//! A script reads like a story: send this, expect that, within so much time. Every step returns what came, or a [`Failure`]
//! that tells what was expected. Frames the script has not asked for yet wait in the inbox. The master knows its bus as a
//! [`Line`] only, so what it does on a real bus is what the tests see on virtual time.
//!
//! - [`bus`]: where frames travel. An in-process bus on virtual time, SLCAN, SocketCAN.
//! - [`data_sheet`]: what the objects of a device are called.
//! - [`trace`]: frames in candump notation, with their meaning.
//! - [`mod@axis402`]: a master's command line for real buses.
//! - [`scope`]: what a drive has recorded of itself.
//! - [`tuning`]: what a drive has measured of its motor, and how its loops answer.
//! - [`chart`], [`command_line`], [`system_error`]: what this command line and that of the virtual drive have in common.
//!
//! Nothing here knows a drive but by its data sheet.
#![forbid(unsafe_code)]

pub mod axis402;
mod block_upload;
pub mod bus;
pub mod chart;
pub mod command_line;
pub mod data_sheet;
mod drive;
mod failure;
mod inbox;
mod line;
mod lss;
mod pdo;
mod port;
mod real;
pub mod scope;
mod sdo;
pub mod system_error;
pub mod trace;
pub mod tuning;

use std::collections::BTreeMap;

use canopen::{Duration, Frame, Instant};

pub use failure::Failure;
pub use inbox::Inbox;
pub use line::{Line, LineDown, Simulated};
pub use lss::Identity;
pub use pdo::{MappedObject, PdoSetup};
pub use port::Port;
pub use real::Real;
pub use sdo::{SdoChannel, Value};

/// How long an answer may take by default.
pub const ANSWER_TIME: Duration = Duration::from_ticks(100_000);

/// How long each step of a fastscan waits by default for slaves to say that they match.
pub const SCAN_TIME: Duration = Duration::from_ticks(10_000);

/// The longest object that is read by default, in bytes: a device whose object does not end is left after so many.
pub const LONGEST_UPLOAD: usize = 4 << 20;

/// NMT commands (CiA 301, command specifier of the frame with identifier 000h).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum NmtCommand {
    /// Start remote node.
    Start = 0x01,
    /// Stop remote node.
    Stop = 0x02,
    /// Enter pre-operational.
    EnterPreOperational = 0x80,
    /// Reset node.
    ResetNode = 0x81,
    /// Reset communication.
    ResetCommunication = 0x82,
}

/// A master and the bus it is on.
#[derive(Debug)]
pub struct Master<L = Simulated> {
    line: L,
    answer_time: Duration,
    scan_time: Duration,
    longest_upload: usize,
    /// When nothing is waited for any more, and how long it is from the beginning.
    end: Option<(Instant, Duration)>,
    /// Of the nodes that are not asked on the default channel.
    sdo_channels: BTreeMap<u8, SdoChannel>,
}

impl<L: Line> Master<L> {
    /// A master on this line. An answer may take [`ANSWER_TIME`], one of a fastscan [`SCAN_TIME`].
    pub fn on(line: L) -> Self {
        Self {
            line,
            answer_time: ANSWER_TIME,
            scan_time: SCAN_TIME,
            longest_upload: LONGEST_UPLOAD,
            end: None,
            sdo_channels: BTreeMap::new(),
        }
    }

    /// Leaves the bus to somebody else.
    pub fn into_line(self) -> L {
        self.line
    }

    /// The line it is on.
    pub fn line_mut(&mut self) -> &mut L {
        &mut self.line
    }

    /// The present time of the bus.
    pub fn now(&self) -> Instant {
        self.line.now()
    }

    /// How long an answer may take.
    pub fn answer_time(&self) -> Duration {
        self.answer_time
    }

    /// How long an answer may take; returns how long it might before.
    pub fn set_answer_time(&mut self, answer_time: Duration) -> Duration {
        std::mem::replace(&mut self.answer_time, answer_time)
    }

    /// How long a fastscan waits at each bit; returns how long it did before. Too short a time reads bits as 1 that are 0, and the
    /// scan fails at the end of that number.
    pub fn set_scan_time(&mut self, scan_time: Duration) -> Duration {
        std::mem::replace(&mut self.scan_time, scan_time)
    }

    /// The longest object that is read, in bytes.
    pub fn set_longest_upload(&mut self, bytes: usize) {
        self.longest_upload = bytes;
    }

    /// From now on no more than this time passes before a wait ends with [`Failure::TimeIsUp`], once: what is put right afterwards has its
    /// time. So whatever devices send, a script comes to its end.
    pub fn set_time_limit(&mut self, limit: Duration) {
        self.end = Some((self.now() + limit, limit));
    }

    /// How long a fastscan waits at each bit.
    pub fn scan_time(&self) -> Duration {
        self.scan_time
    }

    /// Lets time pass; what comes meanwhile waits in the inbox.
    ///
    /// # Errors
    /// [`Failure::LineDown`] when the bus cannot be used any more.
    pub fn wait(&mut self, span: Duration) -> Result<(), Failure> {
        let end = self.now() + span;
        while self.line.step(end)? {}
        Ok(())
    }

    /// Queues a frame for sending; it goes out as the bus runs on.
    pub fn send(&mut self, frame: Frame) {
        self.line.send(frame);
    }

    /// Queues a data frame with an 11-bit identifier.
    pub fn send_data(&mut self, cob_id: u16, data: &[u8]) {
        self.send(Frame::data_frame(cob_id, data));
    }

    /// Sends an NMT command; node 0 is every node.
    pub fn nmt(&mut self, command: NmtCommand, node: u8) {
        self.send_data(0x000, &[command as u8, node]);
    }

    /// Sends SYNC.
    pub fn sync(&mut self) {
        self.send_data(0x080, &[]);
    }

    /// Takes all frames out of the inbox, oldest first.
    pub fn take_received(&mut self) -> Vec<(Instant, Frame)> {
        self.line.inbox().take_all()
    }

    /// Waits until a frame comes for which `pick` has a value, frames already in the inbox first (oldest first). That frame
    /// leaves the inbox, the others stay. `expected` is for the failure's text.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came `within` the time, [`Failure::TimeIsUp`] if there is none left at all.
    pub fn wait_for<T>(
        &mut self,
        expected: &str,
        within: Duration,
        mut pick: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<T, Failure> {
        if let Some((_, limit)) = self.end.take_if(|(end, _)| self.line.now() >= *end) {
            return Err(Failure::TimeIsUp { limit });
        }
        let end = self.now() + within;
        let mut seen = 0;
        loop {
            let inbox = self.line.inbox();
            if let Some(found) = inbox.take_from(seen, &mut pick) {
                return Ok(found);
            }
            seen = inbox.waiting();
            if !self.line.step(end)? {
                return Err(Failure::Timeout {
                    expected: expected.to_owned(),
                    within,
                    at: end,
                });
            }
        }
    }

    /// Like [`Master::wait_for`], for frames that come from now on only: the inbox is emptied first.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came `within` the time.
    pub fn wait_for_next<T>(
        &mut self,
        expected: &str,
        within: Duration,
        pick: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<T, Failure> {
        self.line.inbox().take_all();
        self.wait_for(expected, within, pick)
    }

    /// Waits for a data frame with this identifier; returns its bytes.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came in the time that an answer may take.
    pub fn expect_from(&mut self, cob_id: u16) -> Result<Vec<u8>, Failure> {
        self.wait_for(
            &format!("a frame {cob_id:03X}"),
            self.answer_time,
            |frame| {
                (frame.standard_id() == Some(cob_id) && !frame.is_remote())
                    .then(|| frame.payload().to_vec())
            },
        )
    }

    /// Waits for the boot-up message of a node.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if it did not come `within` the time.
    pub fn expect_boot_up(&mut self, node: u8, within: Duration) -> Result<(), Failure> {
        let boot_up = Frame::data_frame(0x700 + u16::from(node), &[0]);
        self.wait_for(&format!("boot-up of node {node}"), within, |frame| {
            (*frame == boot_up).then_some(())
        })
    }

    /// Asserts silence: no frame comes for `span`.
    ///
    /// # Errors
    /// [`Failure::Unexpected`] with the first frame that came.
    pub fn expect_nothing_for(&mut self, span: Duration) -> Result<(), Failure> {
        match self.wait_for_next("nothing", span, |frame| Some(*frame)) {
            Ok(frame) => Err(Failure::Unexpected {
                expected: format!("nothing for {} ms", span.to_millis()),
                got: frame,
                at: self.now(),
            }),
            Err(Failure::Timeout { .. }) => Ok(()),
            Err(failure) => Err(failure),
        }
    }
}

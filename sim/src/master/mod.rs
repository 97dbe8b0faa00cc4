//! A scripted CANopen master on the simulated bus, for the demonstration and for tests.
//!
//! A script reads like a story: send this, expect that, within so much virtual time. Every step returns what came, or a
//! [`Failure`] that tells what was expected. Frames the script has not asked for yet wait in the inbox.

mod drive;
mod failure;
mod lss;
mod pdo;
mod port;
mod sdo;

use canopen::{Duration, Frame, Instant};

use crate::bus::Station;
use crate::bus::simulated::{Bus, Handle};

pub use failure::Failure;
pub use lss::Identity;
pub use pdo::{MappedObject, PdoSetup};
pub use port::Port;
pub use sdo::Value;

/// How long an answer may take by default.
pub const ANSWER_TIME: Duration = Duration::from_ticks(100_000);

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
pub struct Master {
    bus: Bus,
    port: Handle<Port>,
}

impl Master {
    /// Attaches a master to a bus. It follows any bit rate until [`Port::set_bit_rate`].
    pub fn new(mut bus: Bus) -> Self {
        let port = bus.attach(Port::default());
        Self { bus, port }
    }

    /// The bus, to attach stations, to interfere, to let time pass.
    pub fn bus_mut(&mut self) -> &mut Bus {
        &mut self.bus
    }

    /// The bus, for its trace and stations.
    pub fn bus(&self) -> &Bus {
        &self.bus
    }

    /// The master's own controller and inbox.
    pub fn port_mut(&mut self) -> &mut Port {
        self.bus.station_mut(self.port)
    }

    /// A station of the bus.
    pub fn station<S: Station>(&self, handle: Handle<S>) -> &S {
        self.bus.station(handle)
    }

    /// A station of the bus, to act on it.
    pub fn station_mut<S: Station>(&mut self, handle: Handle<S>) -> &mut S {
        self.bus.station_mut(handle)
    }

    /// The present virtual time.
    pub fn now(&self) -> Instant {
        self.bus.now()
    }

    /// Lets virtual time pass.
    pub fn run_for(&mut self, span: Duration) {
        self.bus.run_for(span);
    }

    /// Queues a frame for sending; it goes out as the bus runs on.
    pub fn send(&mut self, frame: Frame) {
        self.port_mut().send(frame);
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
        self.port_mut().take_all()
    }

    /// Waits until a frame comes for which `pick` has a value, frames already in the inbox first (oldest first). That frame
    /// leaves the inbox, the others stay. `expected` is for the failure's text.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came `within` the time.
    pub fn wait_for<T>(
        &mut self,
        expected: &str,
        within: Duration,
        mut pick: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<T, Failure> {
        let end = self.now() + within;
        let mut seen = 0;
        loop {
            let inbox = self.port_mut();
            if let Some(found) = inbox.take_from(seen, &mut pick) {
                return Ok(found);
            }
            seen = inbox.waiting();
            if !self.bus.step(end) {
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
        self.port_mut().take_all();
        self.wait_for(expected, within, pick)
    }

    /// Waits for a data frame with this identifier; returns its bytes.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came within [`ANSWER_TIME`].
    pub fn expect_from(&mut self, cob_id: u16) -> Result<Vec<u8>, Failure> {
        self.wait_for(&format!("a frame {cob_id:03X}"), ANSWER_TIME, |frame| {
            (frame.standard_id() == Some(cob_id) && !frame.is_remote())
                .then(|| frame.payload().to_vec())
        })
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
            Err(_) => Ok(()),
        }
    }
}

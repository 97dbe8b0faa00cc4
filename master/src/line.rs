//! Where a master is: its end of a bus, which may be simulated or real.

use std::fmt;

use canopen::{BitRate, Duration, Frame, Instant};

use crate::bus::Station;
use crate::bus::simulated::{Bus, Handle};
use crate::inbox::Inbox;
use crate::port::Port;
use crate::{Failure, Master};

/// A master's end of a bus: a way out, an inbox, and the time of that bus. The protocols of the master are written against it
/// once, and run on virtual time as on a real bus.
pub trait Line {
    /// The present time of the bus.
    fn now(&self) -> Instant;

    /// Queues a frame; frames leave in this order.
    fn send(&mut self, frame: Frame);

    /// What has come.
    fn inbox(&mut self) -> &mut Inbox;

    /// Lets time pass until something happens, until `end` at the latest. Returns whether anything happened by then; if not,
    /// the time is `end`.
    ///
    /// # Errors
    /// [`LineDown`] when nothing can be sent or heard any more. A simulated bus is never down.
    fn step(&mut self, end: Instant) -> Result<bool, LineDown>;

    /// Changes the master's own bit rate. Returns false where that is not in its hands.
    ///
    /// # Errors
    /// [`LineDown`] when there is no bus at that rate.
    fn set_bit_rate(&mut self, bit_rate: BitRate) -> Result<bool, LineDown>;
}

/// The bus cannot be used any more; why, in a few words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineDown(pub String);

impl LineDown {
    /// A person wants no more of it.
    pub fn stopped() -> Self {
        Self("stopped".to_owned())
    }
}

impl fmt::Display for LineDown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for LineDown {}

/// On the simulated bus of one process.
#[derive(Debug)]
pub struct Simulated {
    bus: Bus,
    port: Handle<Port>,
}

impl Simulated {
    /// The bus.
    pub fn bus_mut(&mut self) -> &mut Bus {
        &mut self.bus
    }
}

impl Line for Simulated {
    fn now(&self) -> Instant {
        self.bus.now()
    }

    fn send(&mut self, frame: Frame) {
        self.bus.station_mut(self.port).send(frame);
    }

    fn inbox(&mut self) -> &mut Inbox {
        self.bus.station_mut(self.port).inbox()
    }

    fn step(&mut self, end: Instant) -> Result<bool, LineDown> {
        Ok(self.bus.step(end))
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) -> Result<bool, LineDown> {
        self.bus.station_mut(self.port).set_bit_rate(Some(bit_rate));
        Ok(true)
    }
}

impl Master {
    /// Attaches a master to a simulated bus. It follows any bit rate until [`Port::set_bit_rate`].
    pub fn new(mut bus: Bus) -> Self {
        let port = bus.attach(Port::default());
        Self::on(Simulated { bus, port })
    }

    /// The bus, to attach stations, to interfere, to let time pass.
    pub fn bus_mut(&mut self) -> &mut Bus {
        &mut self.line.bus
    }

    /// The bus, for its trace and stations.
    pub fn bus(&self) -> &Bus {
        &self.line.bus
    }

    /// The master's own controller.
    pub fn port_mut(&mut self) -> &mut Port {
        self.line.bus.station_mut(self.line.port)
    }

    /// A station of the bus.
    pub fn station<S: Station>(&self, handle: Handle<S>) -> &S {
        self.line.bus.station(handle)
    }

    /// A station of the bus, to act on it.
    pub fn station_mut<S: Station>(&mut self, handle: Handle<S>) -> &mut S {
        self.line.bus.station_mut(handle)
    }

    /// Lets virtual time pass.
    pub fn run_for(&mut self, span: Duration) {
        self.line.bus.run_for(span);
    }
}

impl From<LineDown> for Failure {
    fn from(down: LineDown) -> Self {
        Self::LineDown(down)
    }
}

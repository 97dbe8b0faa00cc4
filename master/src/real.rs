//! On a real bus, in the time of this computer.

use std::time::{Duration as WallDuration, Instant as WallClock};

use canopen::{BitRate, Frame, Instant};

use crate::bus::live::{Incoming, LiveBus, Source};
use crate::inbox::Inbox;
use crate::line::{Line, LineDown};
use crate::system_error::plain;

/// Frames that are still taken after the end of a wait. They had come before it, if this program was stalled; on a bus that is
/// never silent there is always one more.
const LATE: usize = 256;

/// On a real bus, through the adapter or the interface that a [`LiveBus`] has.
#[derive(Debug)]
pub struct Real {
    bus: LiveBus,
    start: WallClock,
    inbox: Inbox,
    late: usize,
    refused: u64,
}

impl Real {
    /// On this bus; its time begins now.
    pub fn new(bus: LiveBus) -> Self {
        Self {
            bus,
            start: WallClock::now(),
            inbox: Inbox::default(),
            late: 0,
            refused: 0,
        }
    }

    /// The transports.
    pub fn bus_mut(&mut self) -> &mut LiveBus {
        &mut self.bus
    }

    /// How many frames the adapter has refused to send.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

impl Line for Real {
    fn now(&self) -> Instant {
        Instant::from_ticks(self.start.elapsed().as_micros() as u64)
    }

    fn send(&mut self, frame: Frame) {
        // A master serves no clients that could be told to leave.
        let _ = self.bus.send(&frame, Source::Own, None);
    }

    fn inbox(&mut self) -> &mut Inbox {
        &mut self.inbox
    }

    fn step(&mut self, end: Instant) -> Result<bool, LineDown> {
        let is_over = self.now() >= end;
        self.late = if is_over { self.late + 1 } else { 0 };
        let wait = WallDuration::from_micros(end.ticks());
        let deadline = self.start.checked_add(wait).unwrap_or(self.start);
        let message = if self.late > LATE {
            None
        } else {
            self.bus.receive(deadline)
        };
        match message {
            Some(Incoming::Frame { frame, .. }) => self.inbox.put(self.now(), frame),
            Some(Incoming::Lost(_)) => {}
            Some(Incoming::Refused) => self.refused += 1,
            Some(Incoming::ClientLeft(_) | Incoming::ClientRefused(_)) => {}
            Some(Incoming::Failed(what)) => return Err(LineDown(what)),
            Some(Incoming::Stop) => return Err(LineDown::stopped()),
            None => {
                self.late = 0;
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) -> Result<bool, LineDown> {
        let changed = self.bus.set_adapter_bit_rate(bit_rate.into());
        changed.map_err(|error| LineDown(format!("the SLCAN adapter failed: {}", plain(error))))
    }
}

//! The master's CAN controller on a simulated bus: a queue out, an inbox in.

use std::collections::VecDeque;

use canopen::time::NEVER;
use canopen::{BitRate, Frame, Instant};

use crate::bus::Station;
use crate::inbox::Inbox;

/// A station that sends what it is told and keeps what it hears.
#[derive(Debug, Default)]
pub struct Port {
    outgoing: VecDeque<Frame>,
    inbox: Inbox,
    bit_rate: Option<BitRate>,
}

impl Port {
    /// Queues a frame; frames leave in this order.
    pub fn send(&mut self, frame: Frame) {
        self.outgoing.push_back(frame);
    }

    /// What it heard.
    pub fn inbox(&mut self) -> &mut Inbox {
        &mut self.inbox
    }

    /// Fixes the bit rate; `None` follows that of the bus.
    pub fn set_bit_rate(&mut self, bit_rate: Option<BitRate>) {
        self.bit_rate = bit_rate;
    }
}

impl Station for Port {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.inbox.put(now, *frame);
    }

    fn poll(&mut self, _now: Instant) -> Instant {
        NEVER
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.outgoing.pop_front()
    }

    fn bit_rate(&self) -> Option<BitRate> {
        self.bit_rate
    }
}

//! The master's CAN controller: a queue out, an inbox in.

use std::collections::VecDeque;

use canopen::time::NEVER;
use canopen::{BitRate, Frame, Instant};

use crate::bus::Station;

/// A station that sends what it is told and keeps what it hears.
#[derive(Debug, Default)]
pub struct Port {
    outgoing: VecDeque<Frame>,
    inbox: VecDeque<(Instant, Frame)>,
    bit_rate: Option<BitRate>,
}

impl Port {
    /// Queues a frame; frames leave in this order.
    pub fn send(&mut self, frame: Frame) {
        self.outgoing.push_back(frame);
    }

    /// Fixes the bit rate; `None` follows that of the bus.
    pub fn set_bit_rate(&mut self, bit_rate: Option<BitRate>) {
        self.bit_rate = bit_rate;
    }

    /// Frames in the inbox.
    pub fn waiting(&self) -> usize {
        self.inbox.len()
    }

    /// Empties the inbox, oldest first.
    pub fn take_all(&mut self) -> Vec<(Instant, Frame)> {
        self.inbox.drain(..).collect()
    }

    /// Removes the first frame, from the `skip`-th on, for which `pick` has a value, and returns that value.
    pub fn take_from<T>(
        &mut self,
        skip: usize,
        mut pick: impl FnMut(&Frame) -> Option<T>,
    ) -> Option<T> {
        let (place, found) = (self.inbox.iter().enumerate().skip(skip))
            .find_map(|(place, (_, frame))| pick(frame).map(|found| (place, found)))?;
        self.inbox.remove(place);
        Some(found)
    }
}

impl Station for Port {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.inbox.push_back((now, *frame));
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

//! A station that takes its time, as devices of different makes on one bus do.

use std::collections::VecDeque;

use canopen::time::NEVER;
use canopen::{BitRate, Duration, Frame, Instant};
use master::bus::Station;

/// A station that serves each frame a while after it came.
#[derive(Debug)]
pub struct Late<S> {
    station: S,
    delay: Duration,
    waiting: VecDeque<(Instant, Frame)>,
}

impl<S: Station> Late<S> {
    /// A station that serves each frame after `delay`.
    pub fn new(station: S, delay: Duration) -> Self {
        Self {
            station,
            delay,
            waiting: VecDeque::new(),
        }
    }
}

impl<S: Station> Station for Late<S> {
    fn receive(&mut self, frame: &Frame, now: Instant) {
        self.waiting.push_back((now + self.delay, *frame));
    }

    fn poll(&mut self, now: Instant) -> Instant {
        while let Some((_, frame)) = self.waiting.pop_front_if(|(due, _)| *due <= now) {
            self.station.receive(&frame, now);
        }
        let due = self.waiting.front().map_or(NEVER, |(due, _)| *due);
        self.station.poll(now).min(due)
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.station.transmit()
    }

    fn bit_rate(&self) -> Option<BitRate> {
        self.station.bit_rate()
    }

    fn was_reset(&mut self) -> bool {
        self.station.was_reset()
    }
}

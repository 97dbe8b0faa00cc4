//! Frames that the controller had no room for.
//!
//! The controller takes a frame only if it goes before all that wait in its mailboxes, and may give another back to make
//! room. So each time the most urgent frame is offered, whether it waits here or has just come from the device.
//!
//! The contract:
//! - Nothing is lost, and frames with the same identifier leave in the order they came.
//! - Frames are taken from the device one at a time, and only while a place is free: as long as not all places are taken, an
//!   urgent frame never waits behind others.

use canopen::Frame;
use heapless::Vec;

/// Places. Each is taken by a frame that was the most urgent of the device at its time, and was refused.
const PLACES: usize = 3;

/// What waits.
pub struct Outbox {
    /// The most urgent frame last, and of equals the oldest.
    waiting: Vec<Frame, PLACES>,
}

impl Outbox {
    /// Nothing waits.
    pub const fn new() -> Self {
        Self {
            waiting: Vec::new(),
        }
    }

    /// What waits is void.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Offers frames until one is refused or there are none left. `next` is the next frame of the device; `offer` gives
    /// back the frame if there is no room for it, or one of lower priority that had to make way.
    pub fn send(
        &mut self,
        mut next: impl FnMut() -> Option<Frame>,
        mut offer: impl FnMut(&Frame) -> Option<Frame>,
    ) {
        loop {
            if !self.waiting.is_full() {
                if let Some(frame) = next() {
                    self.put(frame, |waiting| waiting.id() <= frame.id());
                }
            }
            let Some(first) = self.waiting.pop() else {
                return;
            };
            if let Some(back) = offer(&first) {
                // It is older than those of its identifier that wait here.
                self.put(back, |waiting| waiting.id() < back.id());
                if back.id() == first.id() {
                    return;
                }
            }
        }
    }

    /// Puts a frame in front of those that leave before it. There is a free place.
    fn put(&mut self, frame: Frame, leaves_before_it: impl Fn(&Frame) -> bool) {
        let place = self.waiting.iter().position(leaves_before_it);
        let place = place.unwrap_or(self.waiting.len());
        let _ = self.waiting.insert(place, frame);
    }
}

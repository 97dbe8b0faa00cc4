//! Received frames on their way from a receive interrupt to the node task, each with the time it arrived.

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};

use canopen::{Frame, Instant};
use heapless::spsc::{Consumer, Producer, Queue};

use crate::ports::{Reception, Stamped};

/// Frames that can wait: at 1 Mbit/s and the shortest frames, the node task may be three milliseconds late.
pub const DEPTH: usize = 64;

/// The memory of the queue (one place stays empty).
pub type Memory = Queue<Stamped, { DEPTH + 1 }>;

/// The end the receive interrupt fills.
pub struct Inbox {
    frames: Producer<'static, Stamped>,
    lost: &'static Lost,
}

/// How many frames found no room, for ever since the start.
#[derive(Debug, Default)]
pub struct Lost(AtomicU32);

/// The end the node task empties.
pub struct Received {
    frames: Consumer<'static, Stamped>,
    lost: &'static Lost,
}

impl Inbox {
    /// Both ends of the queue.
    pub fn new(memory: &'static mut Memory, lost: &'static Lost) -> (Self, Received) {
        let (inbox, received) = memory.split();
        (
            Self {
                frames: inbox,
                lost,
            },
            Received {
                frames: received,
                lost,
            },
        )
    }

    /// Whether the next frame would be lost.
    pub fn is_full(&self) -> bool {
        !self.frames.ready()
    }

    /// Queues a frame that has just arrived.
    pub fn put(&mut self, frame: Frame, at: Instant) {
        if self.frames.enqueue(Stamped { frame, at }).is_err() {
            self.count_lost();
        }
    }

    /// How many were lost since power-on; it wraps.
    pub fn lost(&self) -> u32 {
        self.lost.count()
    }

    /// Counts a frame that was lost before it came here.
    pub fn count_lost(&mut self) {
        self.lost.0.fetch_add(1, Ordering::Relaxed);
    }
}

impl Reception for Received {
    fn receive(&mut self) -> Option<Stamped> {
        self.frames.dequeue()
    }

    fn lost(&self) -> u32 {
        self.lost.count()
    }
}

impl fmt::Debug for Received {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Received")
            .field("lost", self.lost)
            .finish_non_exhaustive()
    }
}

impl fmt::Debug for Inbox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Inbox")
            .field("lost", self.lost)
            .finish_non_exhaustive()
    }
}

impl Lost {
    /// None yet.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// The count; it wraps.
    pub fn count(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;

    use super::*;

    #[test]
    fn frames_keep_their_order_and_those_without_room_are_counted() {
        let lost: &'static Lost = Box::leak(Box::default());
        let (mut inbox, mut received) = Inbox::new(Box::leak(Box::default()), lost);
        for number in 0..=DEPTH as u64 {
            assert_eq!(inbox.is_full(), number == DEPTH as u64);
            let frame = Frame::data_frame(0x100, &number.to_le_bytes());
            inbox.put(frame, Instant::from_ticks(number));
        }
        assert_eq!(received.lost(), 1);
        for number in 0..DEPTH as u64 {
            let Stamped { frame, at } = received.receive().unwrap();
            assert_eq!(frame.payload(), number.to_le_bytes());
            assert_eq!(at.ticks(), number);
        }
        assert!(received.receive().is_none());
    }
}

//! Received frames on their way from the receive interrupt to the node task, each with the time it arrived.

use core::sync::atomic::{AtomicU32, Ordering};

use canopen::{Frame, Instant};
use heapless::spsc::{Consumer, Producer, Queue};

use crate::clock;

/// Frames that can wait: at 1 Mbit/s and the shortest frames, the node task may be three milliseconds late.
pub const DEPTH: usize = 64;

/// A frame and when it arrived.
#[derive(Clone, Copy, Debug)]
pub struct Stamped {
    pub frame: Frame,
    pub at: Instant,
}

/// The memory of the queue (one place stays empty).
pub type Memory = Queue<Stamped, { DEPTH + 1 }>;

/// The end the receive interrupt fills.
pub struct Inbox {
    frames: Producer<'static, Stamped>,
    lost: &'static Lost,
}

/// How many frames found no room, for ever since the start.
pub struct Lost(AtomicU32);

/// The end the node task empties.
pub type Received = Consumer<'static, Stamped>;

impl Inbox {
    /// Both ends of the queue.
    pub fn new(memory: &'static mut Memory, lost: &'static Lost) -> (Self, Received) {
        let (frames, received) = memory.split();
        (Self { frames, lost }, received)
    }

    /// Whether the next frame would be lost.
    pub fn is_full(&self) -> bool {
        !self.frames.ready()
    }

    /// Stamps a frame that has just arrived and queues it.
    pub fn put(&mut self, frame: Frame) {
        let at = clock::now();
        if self.frames.enqueue(Stamped { frame, at }).is_err() {
            self.count_lost();
        }
    }

    /// Counts a frame that was lost before it came here.
    pub fn count_lost(&mut self) {
        self.lost.0.fetch_add(1, Ordering::Relaxed);
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

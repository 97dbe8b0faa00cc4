//! The frames a master has heard and not asked for yet.

use std::collections::VecDeque;

use canopen::{Frame, Instant};

/// Frames with the time at which they came, oldest first.
#[derive(Debug, Default)]
pub struct Inbox {
    frames: VecDeque<(Instant, Frame)>,
}

impl Inbox {
    /// Puts a frame behind the others.
    pub fn put(&mut self, at: Instant, frame: Frame) {
        self.frames.push_back((at, frame));
    }

    /// How many frames there are.
    pub fn waiting(&self) -> usize {
        self.frames.len()
    }

    /// The frames behind the first `skip`, which stay.
    pub fn behind(&self, skip: usize) -> impl Iterator<Item = (Instant, Frame)> + '_ {
        self.frames.iter().skip(skip).copied()
    }

    /// Empties the inbox, oldest first.
    pub fn take_all(&mut self) -> Vec<(Instant, Frame)> {
        self.frames.drain(..).collect()
    }

    /// Removes the first frame, from the `skip`-th on, for which `pick` has a value, and returns that value.
    pub fn take_from<T>(
        &mut self,
        skip: usize,
        mut pick: impl FnMut(&Frame) -> Option<T>,
    ) -> Option<T> {
        let (place, found) = (self.frames.iter().enumerate().skip(skip))
            .find_map(|(place, (_, frame))| pick(frame).map(|found| (place, found)))?;
        self.frames.remove(place);
        Some(found)
    }
}

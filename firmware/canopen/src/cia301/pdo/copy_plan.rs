//! Copy plans: a resolved mapping as few copies between the frame and the memory of the dictionary.
//!
//! Values lie in the dictionary as they travel on the bus, so a mapped object is a copy of bytes. Objects that are
//! neighbours in the frame and in memory become one copy.

use heapless::Vec;

use super::mapping::{MOST_OBJECTS, Mapping};
use crate::copy::copy_few;
use crate::od::Location;

/// One copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step {
    memory: Location,
    /// First byte in the frame.
    position: u8,
    /// Bytes.
    length: u8,
}

impl Step {
    /// Whether `next` goes on where this step ends, in the frame and in memory.
    fn is_followed_by(&self, next: &Self) -> bool {
        let end = |offset: u16| offset.checked_add(u16::from(self.length));
        let in_memory = match (self.memory, next.memory) {
            (Location::Ram(first), Location::Ram(second))
            | (Location::Rom(first), Location::Rom(second)) => end(first) == Some(second),
            _ => false,
        };
        in_memory && self.position.checked_add(self.length) == Some(next.position)
    }
}

/// What a frame follows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CopyPlan {
    steps: Vec<Step, MOST_OBJECTS>,
}

impl CopyPlan {
    /// Nothing to copy.
    pub(super) const fn new() -> Self {
        Self { steps: Vec::new() }
    }

    /// The plan of a mapping.
    pub(super) fn of(mapping: &Mapping) -> Self {
        let mut plan = Self::new();
        for object in &mapping.objects {
            let next = Step {
                memory: object.entry.location(),
                position: object.position,
                // A mapping has no object longer than the frame.
                length: u8::try_from(object.entry.size).unwrap_or(0),
            };
            match plan.steps.last_mut() {
                Some(step) if step.is_followed_by(&next) => {
                    step.length = step.length.saturating_add(next.length);
                }
                // There are no more steps than objects, so there is room.
                _ => plan.steps.push(next).unwrap_or(()),
            }
        }
        plan
    }

    /// The frame's bytes from the dictionary; bytes beyond the mapping are 0.
    #[inline]
    pub(super) fn pack(&self, ram: &[u8], rom: &[u8]) -> [u8; 8] {
        match self.whole_frame(ram, rom) {
            Some(frame) => *frame,
            None => self.pack_steps(ram, rom),
        }
    }

    /// The eight bytes of a frame that is one copy.
    fn whole_frame<'a>(&self, ram: &'a [u8], rom: &'a [u8]) -> Option<&'a [u8; 8]> {
        match self.steps.first()? {
            Step {
                length: 8, memory, ..
            } => match *memory {
                Location::Ram(offset) => ram.get(usize::from(offset)..),
                Location::Rom(offset) => rom.get(usize::from(offset)..),
                Location::Application => None,
            }?
            .first_chunk(),
            _ => None,
        }
    }

    #[inline(never)]
    fn pack_steps(&self, ram: &[u8], rom: &[u8]) -> [u8; 8] {
        let mut frame = [0; 8];
        for step in &self.steps {
            let from = match step.memory {
                Location::Ram(offset) => ram.get(usize::from(offset)..),
                Location::Rom(offset) => rom.get(usize::from(offset)..),
                Location::Application => None,
            };
            if let (Some(from), Some(to)) = (from, frame.get_mut(usize::from(step.position)..)) {
                copy_few(to, from, usize::from(step.length));
            }
        }
        frame
    }

    /// The frame's bytes into the dictionary.
    pub(super) fn unpack(&self, frame: &[u8; 8], ram: &mut [u8]) {
        for step in &self.steps {
            let Location::Ram(offset) = step.memory else {
                continue;
            };
            if let (Some(from), Some(to)) = (
                frame.get(usize::from(step.position)..),
                ram.get_mut(usize::from(offset)..),
            ) {
                copy_few(to, from, usize::from(step.length));
            }
        }
    }

    /// How many copies a frame costs.
    #[cfg(test)]
    pub(super) fn step_count(&self) -> usize {
        self.steps.len()
    }
}

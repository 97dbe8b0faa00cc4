//! Edges of the digital inputs on their way from the input interrupt to the control tick, each with the position at which it came.
//!
//! Of several edges of one kind between two control ticks the first one counts: what follows is the bouncing of a contact.

use core::sync::atomic::{AtomicI32, AtomicU32, Ordering};

use cia402::inputs::{Captured, DigitalInputs, COUNT};

/// The memory that the interrupt and the control tick share. The interrupt writes a position only while its bit is 0, the control
/// tick clears the bit after it has read the position: so neither sees half of the other's work.
pub struct Edges {
    /// Rising edges of input `n` in bit `n − 1`, falling ones 16 bits above.
    seen: AtomicU32,
    rose: [AtomicI32; COUNT],
    fell: [AtomicI32; COUNT],
}

const FELL: u32 = 16;

impl Edges {
    /// None yet.
    pub const fn new() -> Self {
        Self {
            seen: AtomicU32::new(0),
            rose: [const { AtomicI32::new(0) }; COUNT],
            fell: [const { AtomicI32::new(0) }; COUNT],
        }
    }

    /// The inputs in `changed` have come to `levels` at this position. Called from the input interrupt.
    pub fn note(&self, changed: u8, levels: u8, position: i32) {
        let seen = self.seen.load(Ordering::Relaxed);
        let mut added = 0;
        for input in (0..COUNT).filter(|input| changed & 1 << input != 0) {
            let rises = levels & 1 << input != 0;
            let (cells, bit) = if rises {
                (&self.rose, 1 << input)
            } else {
                (&self.fell, 1 << input << FELL)
            };
            if seen & bit == 0 {
                cells[input].store(position, Ordering::Relaxed);
                added |= bit;
            }
        }
        self.seen.fetch_or(added, Ordering::Release);
    }

    /// What has come since the last call. Called from the control tick.
    pub fn take(&self, levels: u8) -> DigitalInputs {
        let mut inputs = DigitalInputs {
            levels,
            ..DigitalInputs::NONE
        };
        let seen = self.seen.load(Ordering::Acquire);
        if seen == 0 {
            return inputs;
        }
        inputs.changed = (seen | seen >> FELL) as u8;
        for (input, captured) in inputs.captured.iter_mut().enumerate() {
            let edge = |cells: &[AtomicI32; COUNT], bit: u32| {
                (seen & bit != 0).then(|| cells[input].load(Ordering::Relaxed))
            };
            *captured = Captured {
                rose: edge(&self.rose, 1 << input),
                fell: edge(&self.fell, 1 << input << FELL),
            };
        }
        self.seen.fetch_and(!seen, Ordering::Release);
        inputs
    }
}

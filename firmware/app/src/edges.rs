//! Edges of the digital inputs on their way from the input interrupt to the control tick, each with the position and the time at
//! which it came.
//!
//! There are two banks. The interrupt notes edges in the one that is open; the control tick opens the other one, then reads the
//! first at leisure. The interrupt goes before the control tick and is never interrupted by it: once another bank is open, nobody
//! writes to the old one. So no edge is lost or counted twice, and nothing is locked.

use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use cia402::inputs::{Captured, DigitalInputs, Edge, Edges as Passed, COUNT};

/// The memory that the interrupt and the control tick share.
pub struct Edges {
    banks: [Bank; 2],
    /// Where the interrupt notes edges.
    open: AtomicUsize,
    /// The levels after the last interrupt.
    levels: AtomicU32,
}

/// The edges between two control ticks.
struct Bank {
    /// The inputs that have risen in bits 0 to 5, those that have fallen 16 bits above.
    seen: AtomicU32,
    rose: [Cell; COUNT],
    fell: [Cell; COUNT],
}

/// The edges of one kind of one input.
struct Cell {
    count: AtomicU32,
    first: Place,
    last: Place,
}

/// Where and when an edge came.
struct Place {
    /// On the counter of steps.
    count: AtomicU32,
    /// On the counter of the board.
    ticks: AtomicU32,
}

const FELL: u32 = 16;

impl Edges {
    /// None yet.
    pub const fn new() -> Self {
        Self {
            banks: [const { Bank::new() }; 2],
            open: AtomicUsize::new(0),
            levels: AtomicU32::new(0),
        }
    }

    /// The inputs in `changed` have come to `levels` where `count` of an input says (what [`crate::board::Steps::count`] gives) and at this count of [`crate::board::Board::ticks`]. Called
    /// from the input interrupt. An input that is where it was before has been elsewhere meanwhile: it has seen both edges.
    pub fn note(&self, changed: u8, levels: u8, mut count: impl FnMut(usize) -> u32, ticks: u32) {
        let bank = &self.banks[self.open.load(Ordering::Relaxed) & 1];
        let before = self.levels.load(Ordering::Relaxed) as u8;
        self.levels.store(levels.into(), Ordering::Relaxed);
        for input in (0..COUNT).filter(|input| changed & 1 << input != 0) {
            let is_high = levels & 1 << input != 0;
            let position = count(input);
            if (before & 1 << input != 0) == is_high {
                bank.note(input, !is_high, position, ticks);
            }
            bank.note(input, is_high, position, ticks);
        }
    }

    /// Puts what has come since the last call, and the levels now, into `inputs`. Called from the control tick. `time` gives the
    /// drive's time in nanoseconds for a count of the board, `position` the position for a count of steps.
    pub fn take(
        &self,
        levels: u8,
        inputs: &mut DigitalInputs,
        time: impl Fn(u32) -> u32,
        position: impl Fn(u32) -> i32,
    ) {
        inputs.levels = levels;
        inputs.changed = 0;
        let open = self.open.load(Ordering::Relaxed) & 1;
        let bank = &self.banks[open];
        if bank.seen.load(Ordering::Relaxed) == 0 {
            return;
        }
        self.open.store(open ^ 1, Ordering::SeqCst);
        bank.take(inputs, |place| Edge {
            position: position(place.count.load(Ordering::Relaxed)),
            time: time(place.ticks.load(Ordering::Relaxed)),
        });
    }
}

impl Bank {
    const fn new() -> Self {
        Self {
            seen: AtomicU32::new(0),
            rose: [const { Cell::new() }; COUNT],
            fell: [const { Cell::new() }; COUNT],
        }
    }

    fn note(&self, input: usize, rises: bool, position: u32, ticks: u32) {
        let (cell, bit) = if rises {
            (&self.rose[input], 1 << input)
        } else {
            (&self.fell[input], 1 << input << FELL)
        };
        let seen = self.seen.load(Ordering::Relaxed);
        let mut count = 1;
        if seen & bit == 0 {
            cell.first.set(position, ticks);
        } else {
            count = cell.count.load(Ordering::Relaxed).wrapping_add(1);
        }
        cell.count.store(count, Ordering::Relaxed);
        cell.last.set(position, ticks);
        self.seen.store(seen | bit, Ordering::Relaxed);
    }

    #[cold]
    #[inline(never)]
    fn take(&self, inputs: &mut DigitalInputs, edge: impl Fn(&Place) -> Edge) {
        let seen = self.seen.load(Ordering::Relaxed);
        inputs.changed = (seen | seen >> FELL) as u8;
        for (input, captured) in inputs.captured.iter_mut().enumerate() {
            let edges =
                |cells: &[Cell; COUNT], bit| (seen & bit != 0).then(|| cells[input].passed(&edge));
            *captured = Captured {
                rose: edges(&self.rose, 1 << input),
                fell: edges(&self.fell, 1 << input << FELL),
            };
        }
        self.seen.store(0, Ordering::Relaxed);
    }
}

impl Cell {
    const fn new() -> Self {
        Self {
            count: AtomicU32::new(0),
            first: Place::new(),
            last: Place::new(),
        }
    }

    fn passed(&self, edge: &impl Fn(&Place) -> Edge) -> Passed {
        let count = self.count.load(Ordering::Relaxed);
        Passed {
            first: edge(&self.first),
            last: edge(&self.last),
            count: u16::try_from(count).unwrap_or(u16::MAX),
        }
    }
}

impl Place {
    const fn new() -> Self {
        Self {
            count: AtomicU32::new(0),
            ticks: AtomicU32::new(0),
        }
    }

    fn set(&self, count: u32, ticks: u32) {
        self.count.store(count, Ordering::Relaxed);
        self.ticks.store(ticks, Ordering::Relaxed);
    }
}

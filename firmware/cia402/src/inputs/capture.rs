//! Edges of the digital inputs on their way from a board's input interrupt to its control tick, each with the position and the time
//! at which it came.
//!
//! There are two banks. The interrupt notes edges in the one that is open; the control tick opens the other one, then reads the
//! first at leisure. The interrupt goes before the control tick and is never interrupted by it: once another bank is open, nobody
//! writes to the old one. So no edge is lost or counted twice, and nothing is locked. The levels that the tick gets are those after
//! the edges that it gets: what a pin says in that moment may have an edge that is still on its way. Only a level that stays
//! without an edge for a second tick is taken from the pin.
//!
//! The interrupt knows that there was an edge, and reads the level a moment later. An input that is where it was before has been
//! elsewhere meanwhile, so both edges are noted. Pulses shorter than that moment, about a microsecond, may count twice.

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering, compiler_fence};

use canopen::Instant;

use motion::low;

use super::{COUNT, Captured, DigitalInputs, Edge, Edges};

/// The memory that the interrupt and the control tick share.
#[derive(Debug)]
pub struct Capture {
    banks: [Bank; 2],
    /// The interrupt notes edges in the second bank.
    is_second_open: AtomicBool,
    /// The levels after the edges that were noted. Only the interrupt changes them.
    noted: AtomicU8,
    /// The levels that the last tick took, and the inputs that were at the other level without an edge. Only the tick changes them.
    taken: AtomicU8,
    differed: AtomicU8,
}

/// The edges between two control ticks.
#[derive(Debug)]
struct Bank {
    /// The inputs that have risen in bits 0 to 5, those that have fallen 16 bits above.
    seen: AtomicU32,
    /// The levels after the last edge.
    levels: AtomicU8,
    inputs: [Cells; COUNT],
}

/// The edges of one input.
#[derive(Debug)]
struct Cells {
    rose: Cell,
    fell: Cell,
}

/// The edges of one kind of one input.
#[derive(Debug)]
struct Cell {
    count: AtomicU32,
    first: Place,
    last: Place,
}

/// Where and when an edge came.
#[derive(Debug)]
struct Place {
    /// On the counter of steps.
    count: AtomicU32,
    /// On the counter of the board.
    ticks: AtomicU32,
}

const FELL: u32 = 16;

impl Capture {
    /// Nothing seen yet, all levels low.
    pub const fn new() -> Self {
        Self {
            banks: [const { Bank::new() }; 2],
            is_second_open: AtomicBool::new(false),
            noted: AtomicU8::new(0),
            taken: AtomicU8::new(0),
            differed: AtomicU8::new(0),
        }
    }

    /// The levels at the start, input `n` in bit `n − 1`. Called once, before the interrupt is on.
    pub fn begin(&self, levels: u8) {
        self.noted.store(levels, Ordering::Relaxed);
        self.taken.store(levels, Ordering::Relaxed);
    }

    /// The inputs in `changed` have had an edge and are now as in `levels`, input `n` in bit `n − 1`. `count` gives the board's count of
    /// steps at the edge of an input, 0 for the first one; `ticks` is the board's count of time. Called from the input interrupt. An
    /// input that is where it was before has been elsewhere meanwhile: it has seen both edges.
    pub fn note(&self, changed: u8, levels: u8, mut count: impl FnMut(usize) -> u32, ticks: u32) {
        let bank = self.open();
        let before = self.noted.load(Ordering::Relaxed);
        // Another input may have moved since its line was looked at; its edge comes with the next interrupt.
        let after = before & !changed | levels & changed;
        self.noted.store(after, Ordering::Relaxed);
        bank.levels.store(after, Ordering::Relaxed);
        let mut bit = 1;
        for (input, cells) in bank.inputs.iter().enumerate() {
            if changed & bit != 0 {
                let is_high = after & bit != 0;
                let position = count(input);
                if (before & bit != 0) == is_high {
                    bank.note(cells, bit, !is_high, position, ticks);
                }
                bank.note(cells, bit, is_high, position, ticks);
            }
            bit <<= 1;
        }
    }

    /// Puts what has come since the last call into `inputs`, with the levels that belong to it. Called from the control tick. `levels` were
    /// read just before, `time` gives the drive's time in nanoseconds for a count of the board, `position` the position for a count of
    /// steps.
    pub fn take(
        &self,
        levels: u8,
        inputs: &mut DigitalInputs,
        time: impl Fn(u32) -> u32,
        position: impl Fn(u32) -> i32,
    ) {
        inputs.changed = 0;
        let before = self.taken.load(Ordering::Relaxed);
        let mut after = before;
        let bank = self.open();
        if bank.seen.load(Ordering::Relaxed) != 0 {
            let is_second_open = self.is_second_open.load(Ordering::Relaxed);
            self.is_second_open
                .store(!is_second_open, Ordering::Relaxed);
            // The bank is read when the interrupt has left it.
            compiler_fence(Ordering::SeqCst);
            bank.take(inputs, |place| Edge {
                position: position(place.count.load(Ordering::Relaxed)),
                time: time(place.ticks.load(Ordering::Relaxed)),
            });
            let noted = bank.levels.load(Ordering::Relaxed);
            after = before & !inputs.changed | noted & inputs.changed;
        }
        // An edge on its way is in the next tick's bank. If it is not there, the board has not captured it.
        let differs = (levels ^ after) & !inputs.changed;
        let uncaptured = differs & self.differed.load(Ordering::Relaxed);
        self.differed
            .store(differs & !uncaptured, Ordering::Relaxed);
        inputs.levels = after ^ uncaptured;
        self.taken.store(inputs.levels, Ordering::Relaxed);
    }

    /// The bank in which the interrupt notes edges.
    fn open(&self) -> &Bank {
        let [first, second] = &self.banks;
        if self.is_second_open.load(Ordering::Relaxed) {
            second
        } else {
            first
        }
    }
}

impl Default for Capture {
    fn default() -> Self {
        Self::new()
    }
}

impl Bank {
    const fn new() -> Self {
        Self {
            seen: AtomicU32::new(0),
            levels: AtomicU8::new(0),
            inputs: [const { Cells::new() }; COUNT],
        }
    }

    fn note(&self, cells: &Cells, input: u8, rises: bool, position: u32, ticks: u32) {
        let (cell, bit) = if rises {
            (&cells.rose, u32::from(input))
        } else {
            (&cells.fell, u32::from(input) << FELL)
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
        inputs.changed = low::u8(seen | seen >> FELL);
        let mut bit = 1;
        for (captured, cells) in inputs.captured.iter_mut().zip(&self.inputs) {
            *captured = Captured {
                rose: (seen & bit != 0).then(|| cells.rose.passed(&edge)),
                fell: (seen & bit << FELL != 0).then(|| cells.fell.passed(&edge)),
            };
            bit <<= 1;
        }
        self.seen.store(0, Ordering::Relaxed);
    }
}

impl Cells {
    const fn new() -> Self {
        Self {
            rose: Cell::new(),
            fell: Cell::new(),
        }
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

    fn passed(&self, edge: &impl Fn(&Place) -> Edge) -> Edges {
        let count = self.count.load(Ordering::Relaxed);
        Edges {
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

/// The drive's time of an edge in nanoseconds, modulo 2³². The edge came `counts` of the board before `now`: a number with a sign, modulo
/// 2³², for it may also have come since `now` was read. Of a board that counts nothing in a microsecond it is `now`.
pub fn time_of_edge(now: Instant, counts: u32, counts_per_microsecond: u32) -> u32 {
    let age = i64::from(counts.cast_signed())
        .wrapping_mul(1_000)
        .checked_div(counts_per_microsecond.into())
        .unwrap_or(0);
    let time = now.ticks().wrapping_mul(1_000);
    low::u32(time.wrapping_sub(age.cast_unsigned()))
}

#[cfg(test)]
mod tests;

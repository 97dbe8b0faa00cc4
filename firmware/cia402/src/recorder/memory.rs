//! Where samples lie: words that the control tick writes and the node reads, without a lock and without half a word.
//!
//! Who may touch it is agreed by states, not by the type: the recorder while it is at work, the node while the memory says that there
//! is a recording. Should either be wrong, what is read is nonsense, and nothing else.

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};

use motion::low;

use crate::scope::{CHANNELS, Setup};

/// The length of the header of 20D3h in bytes.
pub const HEADER: u32 = 64;

/// The version of the format of 20D3h.
pub const VERSION: u16 = 1;

/// Words of the header.
const HEADER_WORDS: usize = HEADER as usize / 4;

/// Where the channel map begins in the header, in words.
const MAP: usize = HEADER_WORDS - CHANNELS;

/// Room for one recording, given by the firmware: `Memory<[AtomicU32; N]>` for N words of samples. Both halves of the drive have it, by
/// reference or in an `Arc`.
pub struct Memory<W: ?Sized = [AtomicU32]> {
    /// Which recording is there, from 1 on; 0 if there is none.
    whole: AtomicU32,
    /// The recording that was read to its end last.
    fetched: AtomicU32,
    /// Counts how often something was read.
    touched: AtomicU32,
    /// The word with which the oldest sample begins.
    oldest: AtomicU32,
    /// Words of all samples together, which the ring has.
    span: AtomicU32,
    header: [AtomicU32; HEADER_WORDS],
    samples: W,
}

impl<const N: usize> Memory<[AtomicU32; N]> {
    /// An empty one.
    pub const fn new() -> Self {
        Self {
            whole: AtomicU32::new(0),
            fetched: AtomicU32::new(0),
            touched: AtomicU32::new(0),
            oldest: AtomicU32::new(0),
            span: AtomicU32::new(0),
            header: [const { AtomicU32::new(0) }; HEADER_WORDS],
            samples: [const { AtomicU32::new(0) }; N],
        }
    }
}

impl<const N: usize> Default for Memory<[AtomicU32; N]> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a recording has become.
pub(super) struct Outcome {
    /// The word with which the oldest sample begins.
    pub(super) oldest: u32,
    /// How many samples there are.
    pub(super) count: u16,
    /// How many of them are older than the trigger.
    pub(super) before: u16,
    /// Control ticks from the trigger to the sample behind it.
    pub(super) late: u16,
    /// When the trigger came, in microseconds of the drive's clock.
    pub(super) triggered: u64,
}

impl Memory {
    /// How many words of samples it holds.
    pub(super) fn words(&self) -> u32 {
        u32::try_from(self.samples.len()).unwrap_or(u32::MAX)
    }

    /// There is nothing in it.
    pub(super) fn clear(&self) {
        self.whole.store(0, Ordering::Release);
    }

    /// Puts down a word of a sample.
    #[inline]
    pub(super) fn put(&self, position: u32, word: u32) {
        if let Some(cell) = self.samples.get(position as usize) {
            cell.store(word, Ordering::Relaxed);
        }
    }

    /// A recording is whole.
    pub(super) fn publish(&self, run: u32, setup: &Setup, tick: u32, outcome: &Outcome) {
        let stride = setup.stride();
        let lengths = u32::from(VERSION) | HEADER << 16;
        let channels = low::word(setup.signals().count());
        let [low, high] = [
            low::u32(outcome.triggered),
            (outcome.triggered >> 32) as u32,
        ];
        let head = [
            lengths,
            tick,
            u32::from(setup.divider) | channels << 16,
            (stride * 4) | u32::from(outcome.late) << 16,
            outcome.count.into(),
            outcome.before.into(),
            low,
            high,
        ];
        let map = setup
            .channels
            .map(|signal| signal.map_or(0, |signal| signal.mapping()));
        for (cell, word) in self.header.iter().zip(head.into_iter().chain(map)) {
            cell.store(word, Ordering::Relaxed);
        }
        self.oldest.store(outcome.oldest, Ordering::Relaxed);
        self.span.store(setup.span(self.words()), Ordering::Relaxed);
        self.whole.store(run, Ordering::Release);
    }

    /// Which recording is there; `None` if there is none.
    pub(super) fn whole(&self) -> Option<u32> {
        Some(self.whole.load(Ordering::Acquire)).filter(|run| *run != 0)
    }

    /// Whether the recording was read to its end, and the count of readings so far.
    pub(super) fn readings(&self, run: u32) -> (bool, u32) {
        let is_fetched = self.fetched.load(Ordering::Relaxed) == run;
        (is_fetched, self.touched.load(Ordering::Relaxed))
    }

    /// The recording was read up to somewhere.
    pub(super) fn read(&self, run: u32, is_end: bool) {
        let count = self.touched.load(Ordering::Relaxed);
        self.touched.store(count.wrapping_add(1), Ordering::Relaxed);
        if is_end {
            self.fetched.store(run, Ordering::Relaxed);
        }
    }

    /// The length of the recording in bytes, with its header.
    pub(super) fn length(&self) -> u32 {
        let [_, _, _, lengths, count, ..] = &self.header;
        let stride = lengths.load(Ordering::Relaxed) & 0xFFFF;
        let samples = count.load(Ordering::Relaxed).saturating_mul(stride);
        samples.saturating_add(HEADER)
    }

    /// A word of the recording, counted from the beginning of its header.
    pub(super) fn word(&self, position: u32) -> u32 {
        let Some(sample) = position.checked_sub(HEADER / 4) else {
            let cell = self.header.get(position as usize);
            return cell.map_or(0, |cell| cell.load(Ordering::Relaxed));
        };
        let span = self.span.load(Ordering::Relaxed);
        let place = self.oldest.load(Ordering::Relaxed).saturating_add(sample);
        let place = if place < span {
            place
        } else {
            place.saturating_sub(span)
        };
        let cell = self.samples.get(place as usize);
        cell.map_or(0, |cell| cell.load(Ordering::Relaxed))
    }
}

impl<W: ?Sized> fmt::Debug for Memory<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Memory")
            .field("whole", &self.whole)
            .finish_non_exhaustive()
    }
}

const _: () = assert!(MAP == 8, "the map follows the eight words of the head");

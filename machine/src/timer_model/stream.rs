//! The DMA stream, and the bursts of TIM1 that it serves: word by word, each read from memory when the one before it is written.

use motion::advanced_timer::{Ring, SLOTS, WORDS};

/// Words of the ring.
pub(super) const ALL_WORDS: u32 = (SLOTS * WORDS) as u32;

const BURST: u32 = WORDS as u32;

/// Stream 5 of DMA2, and what TIM1 wants of it.
#[derive(Debug)]
pub(super) struct Stream {
    /// NDTR: words left in this round.
    pub(super) left: u32,
    /// The next word, which is fetched ahead.
    ahead: u32,
    /// Words that TIM1 still wants in this burst. RM0090 does not say that this ends with UDE, or with the stream: here it does not.
    wanted: u32,
    /// When the next word is written.
    due: Option<u64>,
    /// Ticks from a request to the last word.
    pub(super) burst_ticks: u64,
    is_on: bool,
    is_stalled: bool,
}

impl Stream {
    pub(super) const fn new() -> Self {
        Self {
            left: 0,
            ahead: 0,
            wanted: 0,
            due: None,
            burst_ticks: 60,
            is_on: false,
            is_stalled: false,
        }
    }

    /// EN is set or cleared.
    pub(super) fn switch(&mut self, is_on: bool, ring: &Ring, now: u64) {
        if is_on && !self.is_on {
            assert_eq!(self.left, ALL_WORDS);
            [self.ahead, ..] = ring.words(0);
        }
        self.is_on = is_on;
        self.go_on(now);
    }

    /// It no longer serves requests, or does so again.
    pub(super) fn stall(&mut self, is_stalled: bool, now: u64) {
        self.is_stalled = is_stalled;
        self.go_on(now);
    }

    /// TIM1 is reset: it wants nothing.
    pub(super) fn forget(&mut self) {
        self.wanted = 0;
        self.due = None;
    }

    /// Whether a burst is on its way.
    pub(super) fn is_busy(&self) -> bool {
        self.due.is_some()
    }

    /// When the next word is written.
    pub(super) fn due(&self) -> Option<u64> {
        self.due
    }

    /// An update event of TIM1 wants a burst. What it wanted before and did not get is still wanted first.
    pub(super) fn request(&mut self, now: u64) {
        if self.wanted == 0 {
            self.wanted = BURST;
        }
        self.go_on(now);
    }

    fn go_on(&mut self, now: u64) {
        let is_served = self.is_on && !self.is_stalled && self.wanted > 0;
        let each = self.burst_ticks / u64::from(BURST);
        let first = self.burst_ticks - each * u64::from(BURST - 1);
        self.due = is_served.then_some(now + first);
    }

    /// A word is written: which of the five it is for TIM1, and the word.
    pub(super) fn deliver(&mut self, ring: &Ring, now: u64) -> (usize, u32) {
        let place = BURST - self.wanted;
        let word = self.ahead;
        self.wanted -= 1;
        self.left -= 1;
        if self.left == 0 {
            self.left = ALL_WORDS;
        }
        let next = ALL_WORDS - self.left;
        self.ahead = ring.words(next / BURST)[(next % BURST) as usize];
        let each = self.burst_ticks / u64::from(BURST);
        self.due = (self.wanted > 0).then_some(now + each);
        (place as usize, word)
    }
}

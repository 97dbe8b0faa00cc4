//! A bus between a client and a server that loses, doubles and delays frames. It keeps the order of each side, as CAN does,
//! and a second copy of a frame follows right behind the first.

use std::collections::VecDeque;

/// How bad it is: of 1000 frames so many suffer this.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions {
    pub(super) lost: u64,
    pub(super) doubled: u64,
    pub(super) delayed: u64,
    /// Most milliseconds of a delay.
    pub(super) delay: u64,
}

impl Conditions {
    /// Nothing happens to a frame.
    pub(super) const GOOD: Self = Self {
        lost: 0,
        doubled: 0,
        delayed: 0,
        delay: 1,
    };
}

/// A generator of numbers from a seed (xorshift).
#[derive(Debug)]
pub(super) struct Chance(u64);

impl Chance {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed | 1)
    }

    /// A number below `bound`.
    pub(super) fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % bound
    }
}

/// One direction; times in milliseconds.
#[derive(Debug, Default)]
pub(super) struct Line {
    under_way: VecDeque<(u64, [u8; 8])>,
    newest: u64,
}

impl Line {
    pub(super) fn send(
        &mut self,
        frame: [u8; 8],
        now: u64,
        conditions: &Conditions,
        chance: &mut Chance,
    ) {
        if chance.below(1000) < conditions.lost {
            return;
        }
        let mut arrival = now;
        if chance.below(1000) < conditions.delayed {
            arrival += chance.below(conditions.delay);
        }
        self.newest = self.newest.max(arrival);
        self.under_way.push_back((self.newest, frame));
        if chance.below(1000) < conditions.doubled {
            self.under_way.push_back((self.newest, frame));
        }
    }

    pub(super) fn receive(&mut self, now: u64) -> Option<[u8; 8]> {
        let (arrival, _) = self.under_way.front()?;
        if *arrival > now {
            return None;
        }
        self.under_way.pop_front().map(|(_, frame)| frame)
    }
}

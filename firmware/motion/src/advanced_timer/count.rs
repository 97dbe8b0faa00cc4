//! The position from counted pulses: the counter only counts up, and the direction of each pulse is known.

use heapless::Deque;

use super::ring::SLOTS;
use crate::Direction;
use crate::low;

/// Changes of direction that are remembered, those still to come included.
const MARKS: usize = 16;

/// A mark that is more pulses behind than this is moved on: differences of counts must stay below 2³¹.
const FAR: i32 = 1 << 24;

/// From this pulse on, pulses go this way.
#[derive(Clone, Copy, Debug)]
struct Mark {
    /// Pulses counted, modulo 2³².
    count: u32,
    position: i64,
    direction: Direction,
    /// The slot of the train that begins with it; [`BEFORE`] if it belongs to an earlier one.
    slot: u32,
}

/// The slot of a mark that is older than the train.
const BEFORE: u32 = u32::MAX;

impl Mark {
    /// The position when the counter shows `count`, as if no other mark followed.
    fn position_at(&self, count: u32) -> i64 {
        let pulses = i64::from(count.wrapping_sub(self.count).cast_signed());
        let distance = match self.direction {
            Direction::Forward => pulses,
            Direction::Reverse => pulses.wrapping_neg(),
        };
        self.position.wrapping_add(distance)
    }
}

/// Every change of direction, from a while ago to the end of what is committed.
#[derive(Debug)]
pub(super) struct PulseCount {
    /// What holds before the first mark that is kept.
    first: Mark,
    later: Deque<Mark, MARKS>,
    /// The direction of the last mark.
    direction: Direction,
}

impl PulseCount {
    /// The counter shows `count` at `position`.
    pub(super) const fn new(count: u32, position: i64) -> Self {
        Self {
            first: Mark {
                count,
                position,
                direction: Direction::Forward,
                slot: BEFORE,
            },
            later: Deque::new(),
            direction: Direction::Forward,
        }
    }

    /// Whether another change of direction can be remembered. `count` is what the counter shows now.
    pub(super) fn has_room(&mut self, count: u32) -> bool {
        // A few changes that lie behind are kept for edges that were captured before them.
        if self.later.is_full()
            && let Some(next) = self.later.front().copied()
            && has_passed(&next, count)
        {
            self.first = next;
            self.later.pop_front();
        }
        !self.later.is_full()
    }

    /// From `count` on, which is the beginning of this slot of the train, pulses go the other way.
    pub(super) fn turn(&mut self, count: u32, direction: Direction, slot: u32) {
        let mark = Mark {
            count,
            position: self.last().position_at(count),
            direction,
            slot,
        };
        // There is room, or the mark is not made ([`PulseCount::has_room`]).
        let _ = self.later.push_back(mark);
        self.direction = self.last().direction;
    }

    /// The direction of the last committed pulses.
    #[inline]
    pub(super) const fn direction(&self) -> Direction {
        self.direction
    }

    /// The position when the counter shows `count`.
    pub(super) fn position_at(&self, count: u32) -> i64 {
        let passed = self.later.iter().rev().find(|mark| has_passed(mark, count));
        passed.unwrap_or(&self.first).position_at(count)
    }

    /// The position when the counter shows `count`, if no more slots than the first `fetched` have come to the timer and the last of them was played
    /// again and again: a turn in those behind it has not been made, whatever the count says.
    pub(super) fn position_stuck(&self, count: u32, fetched: u32) -> i64 {
        let is_made = |mark: &&Mark| {
            mark.slot.wrapping_sub(fetched) >= low::word(SLOTS) && has_passed(mark, count)
        };
        let mark = self.later.iter().rev().find(is_made);
        mark.unwrap_or(&self.first).position_at(count)
    }

    /// Another train begins, and its slots are counted anew: changes of direction up to its first slot are older than the train.
    pub(super) fn begin_train(&mut self) {
        for mark in &mut self.later {
            mark.slot = BEFORE;
        }
    }

    /// Moves a mark on that is far behind the counter, which shows `count` now.
    pub(super) fn go_on(&mut self, count: u32) {
        let behind = count.wrapping_sub(self.first.count).cast_signed();
        if behind > FAR {
            if let Some(next) = self.later.front().copied()
                && has_passed(&next, count)
            {
                self.first = next;
                self.later.pop_front();
            } else if self.later.is_empty() {
                let count = self.first.count.wrapping_add(FAR as u32);
                self.first = Mark {
                    count,
                    position: self.first.position_at(count),
                    ..self.first
                };
            }
        }
    }

    fn last(&self) -> &Mark {
        self.later.back().unwrap_or(&self.first)
    }
}

fn has_passed(mark: &Mark, count: u32) -> bool {
    count.wrapping_sub(mark.count).cast_signed() >= 0
}

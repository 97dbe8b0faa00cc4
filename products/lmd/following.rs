//! Following an external encoder (2231h): in each sample period a relative move is made of the counts that have come.
//!
//! The manual does not tell what begins it: here bit 0 of the direction, 2231h:1, in profile position. Nor does it tell the law. Up to the minimum
//! threshold a count is four microsteps; beyond, it is the gain, twice that from a spacing of thresholds further, three times from two on.
//! A move is at least the minimum and at most the maximum one.

use canopen::od::Dictionary;
use cia402::behaviour::number;
use cia402::commands::Commands;
use cia402::controlword::{CHANGE_IMMEDIATELY, NEW_SET_POINT, RELATIVE};

const FOLLOWING: u16 = 0x2231;
const ENABLE: i64 = 1 << 0;
const REVERSE: i64 = 1 << 7;

/// What is followed, and how far.
#[derive(Debug, Default)]
pub(super) struct Following {
    direction: i64,
    /// Since the motor follows: the counter at the last sample, and when the next one is, in microseconds.
    sampled: Option<(i32, u64)>,
    target: i32,
    /// A move is to begin with the next commands.
    begins: bool,
    /// When the motor moved last.
    moved: u64,
    /// The target does not count as reached yet.
    pub(super) is_pending: bool,
}

impl Following {
    pub(super) fn set_up<D: Dictionary>(&mut self, dictionary: &D) {
        self.direction = number(dictionary, FOLLOWING, 1);
    }

    /// A control tick at this time: the counter, and where the motor is to be. Returns whether the commands are others now.
    pub(super) fn look<D: Dictionary>(
        &mut self,
        dictionary: &D,
        at: u64,
        is_ready: bool,
        (counter, demand, is_moving): (i32, i32, bool),
    ) -> bool {
        let was_on = self.sampled.is_some();
        if !is_ready || self.direction & ENABLE == 0 {
            *self = Self {
                direction: self.direction,
                ..Self::default()
            };
            return was_on;
        }
        let period = number(dictionary, FOLLOWING, 2).max(1) as u64 * 1_000;
        let Some((before, due)) = self.sampled else {
            self.sampled = Some((counter, at + period));
            self.target = demand;
            self.moved = at;
            self.is_pending = true;
            return true;
        };
        let has_begun = core::mem::take(&mut self.begins);
        if is_moving || has_begun {
            self.moved = at;
        }
        let delay = number(dictionary, FOLLOWING, 3) as u64 * 1_000;
        self.is_pending = at.saturating_sub(self.moved) < delay;
        if at < due {
            return has_begun;
        }
        self.sampled = Some((counter, due.max(at.saturating_sub(period)) + period));
        let way = way(dictionary, counter.wrapping_sub(before));
        let is_reverse = self.direction & REVERSE != 0;
        let way = if is_reverse { -way } else { way };
        self.target = self.target.wrapping_add(way);
        self.begins = way != 0;
        has_begun || self.begins
    }

    pub(super) fn command(&self, commands: &mut Commands) {
        if self.sampled.is_none() {
            return;
        }
        commands.controlword &= !(NEW_SET_POINT | RELATIVE);
        commands.rising &= !NEW_SET_POINT;
        if self.begins {
            commands.controlword |= NEW_SET_POINT | CHANGE_IMMEDIATELY;
            commands.rising |= NEW_SET_POINT;
            commands.target_position = self.target;
        }
    }
}

/// The move that so many counts make, in microsteps.
fn way<D: Dictionary>(dictionary: &D, counts: i32) -> i32 {
    let [threshold, least, most, gain, spacing] =
        [4, 5, 6, 7, 8].map(|sub| number(dictionary, FOLLOWING, sub).max(0));
    let amount = i64::from(counts.unsigned_abs());
    if amount == 0 {
        return 0;
    }
    let way = if amount <= threshold {
        amount * 4
    } else {
        let thresholds = (amount - threshold).checked_div(spacing).unwrap_or(2);
        amount * gain * (1 + thresholds.min(2))
    };
    let way = i32::try_from(way.max(least).min(most)).unwrap_or(i32::MAX);
    way * counts.signum()
}

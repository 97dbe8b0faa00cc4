//! The frame of positions: which number of the user belongs to which increment.

use motion::low;

use super::{Range, Ratio, Units};

/// One position of which the number of the user is known exactly, because it was commanded or homing gave it: there it is shown
/// as it was given, and not rounded from the increments. And the name of the home position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PositionFrame {
    increments: i64,
    user: i64,
    /// What the last homing has called the home position, in units of the user; 0 before.
    home: i64,
    /// The same in increments.
    home_increments: i64,
    /// Counts homings.
    homings: u32,
    /// The units of the positions above, and where they wrap.
    ratio: Ratio,
    polarity: bool,
    range: Range,
}

impl PositionFrame {
    /// Both counts begin at 0, and a unit is an increment.
    pub(crate) const fn new() -> Self {
        Self {
            increments: 0,
            user: 0,
            home: 0,
            home_increments: 0,
            homings: 0,
            ratio: Ratio::ONE,
            polarity: false,
            range: Range::ALL,
        }
    }

    /// A position on the count that goes on behind the ends of 607Bh, in units of the user.
    #[inline(never)]
    pub(crate) fn position(&self, increments: i64, units: &Units) -> i64 {
        if increments == self.increments {
            self.user
        } else {
            units.position_in_units(increments)
        }
    }

    /// The same, not to the nearest but to the greater number, or to the lesser one, if it lies between two: so that what is beyond it
    /// in that direction is ahead of the motor.
    pub(crate) fn position_beyond(&self, increments: i64, units: &Units, is_greater: bool) -> i64 {
        let user = self.position(increments, units);
        if increments == self.increments {
            return user;
        }
        let nearest = units.position(user);
        let is_below =
            nearest != increments && (nearest < increments) != units.has_position_polarity();
        let is_above = nearest != increments && !is_below;
        if is_greater && is_below {
            user.saturating_add(1)
        } else if !is_greater && is_above {
            user.saturating_sub(1)
        } else {
            user
        }
    }

    /// A position as objects show it.
    #[inline]
    pub(crate) fn shown(&self, increments: i64, units: &Units) -> i32 {
        if units.shows_increments() {
            return low::i32(increments);
        }
        units.range().shown(self.position(increments, units))
    }

    /// The number of the user at a position is this one.
    pub(crate) const fn remember(&mut self, user: i64, increments: i64) {
        self.user = user;
        self.increments = increments;
    }

    /// The home position has got this name.
    pub(crate) const fn found_home(&mut self, name: i32, increments: i64) {
        self.home = name as i64;
        self.home_increments = increments;
        self.homings = self.homings.wrapping_add(1);
        self.remember(name as i64, increments);
    }

    /// What the home position is called since the last homing, in the units of now.
    pub(crate) const fn home(&self) -> i64 {
        self.home
    }

    /// Counts homings.
    pub(crate) const fn homings(&self) -> u32 {
        self.homings
    }

    /// These are the units from now on. Where they are others, a position has another number, and so has the home position. Returns
    /// whether positions are shown otherwise than before.
    pub(crate) fn set_units(&mut self, units: &Units) -> bool {
        let has_new_range = core::mem::replace(&mut self.range, units.range()) != units.range();
        let polarity = units.has_position_polarity();
        let has_new_units = units.position != self.ratio || polarity != self.polarity;
        if has_new_units {
            self.ratio = units.position;
            self.polarity = polarity;
            self.home = units.position_in_units(self.home_increments);
            self.remember(0, 0);
        }
        has_new_units || has_new_range
    }
}

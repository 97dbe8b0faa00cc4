//! How the numbers of the user lie on the increments.

use super::Units;

/// One position of which the number of the user is known exactly, because it was commanded or homing gave it: there it is shown
/// as it was given, and not rounded from the increments. And the name of the home position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Frame {
    increments: i64,
    user: i64,
    /// What the last homing has called the home position, in units of the user; 0 before.
    home: i32,
}

impl Frame {
    /// A position on the count that goes on behind the ends of 607Bh, in units of the user.
    #[inline]
    pub(crate) fn position(&self, increments: i64, units: &Units) -> i64 {
        if increments == self.increments {
            self.user
        } else {
            units.position_in_units(increments)
        }
    }

    /// The number of the user at a position is this one.
    pub(crate) const fn remember(&mut self, user: i64, increments: i64) {
        self.user = user;
        self.increments = increments;
    }

    /// The home position has got this name.
    pub(crate) const fn found_home(&mut self, name: i32, increments: i64) {
        self.home = name;
        self.remember(name as i64, increments);
    }

    /// What the last homing has called the home position.
    pub(crate) const fn home(&self) -> i32 {
        self.home
    }

    /// The units are others.
    pub(crate) const fn forget(&mut self) {
        self.remember(0, 0);
    }
}

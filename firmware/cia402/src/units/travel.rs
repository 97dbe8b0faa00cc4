//! Where the motor may go by 607Dh.

use super::Frame;
use crate::configuration::Configuration;

/// The lowest and the highest position, on the count that goes on behind the ends of 607Bh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Travel {
    /// In units of the user.
    pub(crate) user: (i64, i64),
    /// In increments; with a polarity they are the other way round.
    pub(crate) increments: (i64, i64),
}

impl Travel {
    /// No end on either side.
    pub(crate) const NONE: Self = Self {
        user: (i64::MIN, i64::MAX),
        increments: (i64::MIN, i64::MAX),
    };

    /// What 607Dh means to a motor that is at `position`. Off while the minimum is not below the maximum, and, if that is
    /// asked for, while the home position is not known. One at the end of what 32 bits hold is none on its side. On an axis whose
    /// positions wrap they are in the turn in which it stands.
    pub(crate) fn new(
        configuration: &Configuration,
        frame: &Frame,
        position: i64,
        is_referenced: bool,
    ) -> Self {
        let units = &configuration.units;
        let (low, high) = configuration.position_limits;
        let options = configuration.position_limit_options;
        if low >= high || options.need_home && !is_referenced {
            return Self::NONE;
        }
        let home = if options.are_as_shown {
            0
        } else {
            frame.home()
        };
        let turn = units.range().turn(frame.position(position, units));
        let user = |limit: i32| {
            turn.saturating_add(home.into())
                .saturating_add(limit.into())
        };
        let has_low = low != i32::MIN;
        let has_high = high != i32::MAX;
        let user = (
            if has_low { user(low) } else { i64::MIN },
            if has_high { user(high) } else { i64::MAX },
        );
        let mut below = has_low.then(|| units.position(user.0));
        let mut above = has_high.then(|| units.position(user.1));
        if units.has_position_polarity() {
            core::mem::swap(&mut below, &mut above);
        }
        Self {
            user,
            increments: (below.unwrap_or(i64::MIN), above.unwrap_or(i64::MAX)),
        }
    }
}

//! Where the motor may go by 607Dh.
//!
//! The limits stay where they are. On an axis whose positions wrap they are at the same places in each turn, and one turn has to be
//! chosen: as soon as they count from a home position that is known, it is that of the home position, however many turns away
//! the motor is. Otherwise it goes by where the motor stands, and only when the limits are others, or homing has given positions
//! other names: whatever else is written does not move them.

use crate::configuration::{Configuration, PositionLimitOptions};
use crate::units::{PositionFrame, Range, Ratio, Units};

/// The lowest and the highest position, on the count that goes on behind the ends of 607Bh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Travel {
    /// In units of the user.
    pub(crate) user: (i64, i64),
    /// In increments; with a polarity they change places.
    pub(crate) increments: (i64, i64),
}

impl Travel {
    /// No end on either side.
    pub(crate) const NONE: Self = Self {
        user: (i64::MIN, i64::MAX),
        increments: (i64::MIN, i64::MAX),
    };

    /// Between two positions in units of the user.
    fn between(low: Option<i64>, high: Option<i64>, units: &Units) -> Self {
        let user = (low.unwrap_or(i64::MIN), high.unwrap_or(i64::MAX));
        let mut below = low.map(|low| units.position(low));
        let mut above = high.map(|high| units.position(high));
        if units.has_position_polarity() {
            core::mem::swap(&mut below, &mut above);
        }
        Self {
            user,
            increments: (below.unwrap_or(i64::MIN), above.unwrap_or(i64::MAX)),
        }
    }
}

/// The limits, and what they were worked out from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoftwareLimits {
    travel: Travel,
    /// What a position has in the turn of the limits beyond the one that is shown.
    turn: i64,
    basis: Option<Basis>,
    is_referenced: bool,
}

/// While nothing of this changes, the limits stay in their turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Basis {
    ratio: Ratio,
    has_polarity: bool,
    range: Range,
    limits: (i32, i32),
    options: PositionLimitOptions,
    homings: u32,
}

impl Basis {
    fn of(configuration: &Configuration, frame: &PositionFrame, units: &Units) -> Self {
        Self {
            ratio: units.of_positions(),
            has_polarity: units.has_position_polarity(),
            range: units.range(),
            limits: configuration.position_limits,
            options: configuration.position_limit_options,
            homings: frame.homings(),
        }
    }
}

impl SoftwareLimits {
    /// None yet.
    pub(crate) const fn new() -> Self {
        Self {
            travel: Travel::NONE,
            turn: 0,
            basis: None,
            is_referenced: false,
        }
    }

    /// Where the motor may go.
    pub(crate) const fn travel(&self) -> &Travel {
        &self.travel
    }

    /// Whether homing, or the loss of the home position, has made these limits old.
    pub(crate) fn are_old(&self, frame: &PositionFrame, is_referenced: bool) -> bool {
        self.is_referenced != is_referenced
            || self
                .basis
                .is_none_or(|basis| basis.homings != frame.homings())
    }

    /// Works out what 607Dh means to a motor that is at `position`. Off while the minimum is not below the maximum, and, if that
    /// is asked for, while the home position is not known. One at the end of what 32 bits hold is none on its side.
    pub(crate) fn work_out(
        &mut self,
        configuration: &Configuration,
        (frame, units): (&PositionFrame, &Units),
        position: i64,
        is_referenced: bool,
    ) {
        self.is_referenced = is_referenced;
        let (low, high) = configuration.position_limits;
        let options = configuration.position_limit_options;
        let home = if options.are_as_shown {
            0
        } else {
            frame.home()
        };
        let limit =
            |limit: i32, none: i32| (limit != none).then(|| home.saturating_add(limit.into()));
        let (low_limit, high_limit) = (limit(low, i32::MIN), limit(high, i32::MAX));
        let basis = Some(Basis::of(configuration, frame, units));
        if self.basis != basis {
            self.basis = basis;
            self.turn = if is_referenced && !options.are_as_shown {
                0
            } else {
                let position = frame.position(position, units);
                turn_of(low_limit.zip(high_limit), position, units.range())
            };
        }
        self.travel = if low >= high || options.need_home && !is_referenced {
            Travel::NONE
        } else {
            let turn = self.turn;
            Travel::between(
                low_limit.map(|limit| limit.saturating_add(turn)),
                high_limit.map(|limit| limit.saturating_add(turn)),
                units,
            )
        };
    }
}

/// The turn of the limits between which a motor at `position` is; if it is beyond them in each, or if one of them is missing, the turn in
/// which it is.
fn turn_of(limits: Option<(i64, i64)>, position: i64, range: Range) -> i64 {
    let between = limits.and_then(|(low, high)| {
        let middle = low.saturating_add(high) >> 1;
        let turn = range.nearest(middle, position).saturating_sub(middle);
        let away = position.saturating_sub(turn);
        (low <= away && away <= high).then_some(turn)
    });
    between.unwrap_or_else(|| range.turn(position))
}

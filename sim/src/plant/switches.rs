//! Limit and home switches, as positions.

use std::ops::RangeInclusive;

/// Where the switches are mounted, in steps. A switch that is not mounted is never active.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// The negative limit switch is active at this position and below.
    pub negative_limit: Option<i64>,
    /// The positive limit switch is active at this position and above.
    pub positive_limit: Option<i64>,
    /// The home switch is active in this range.
    pub home: Option<RangeInclusive<i64>>,
}

/// Which switches are active.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SwitchStates {
    /// The negative limit switch.
    pub negative_limit: bool,
    /// The positive limit switch.
    pub positive_limit: bool,
    /// The home switch.
    pub home: bool,
}

impl Switches {
    /// Which switches are active with the motor at `position`.
    pub fn at(&self, position: i64) -> SwitchStates {
        SwitchStates {
            negative_limit: self.negative_limit.is_some_and(|limit| position <= limit),
            positive_limit: self.positive_limit.is_some_and(|limit| position >= limit),
            home: self
                .home
                .as_ref()
                .is_some_and(|range| range.contains(&position)),
        }
    }
}

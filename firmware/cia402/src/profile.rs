//! The motion profile type 6086h: how the velocity changes.
//!
//! | 6086h | ramps |
//! |---|---|
//! | 0 | linear: the trapezoid |
//! | 1 | sin², as long as the linear ones (cargo feature `sin-squared` of `motion`; without it linear) |
//! | 2 | "jerk-free": the moving average of the trapezoid at the jerk 60A4h:1. The motor comes to rest a window of (a + d) / j later |
//! | 3 | "jerk-limited": the double-S at the jerk 60A4h:1, the fastest from rest to rest (cargo feature `limited-jerk`; without it as 2) |
//!
//! The profile counts in profile position, profile velocity, the velocity mode and their halt, from the next set-point or target velocity
//! on. Homing and stops at a limit switch have linear ramps.
//!
//! A stop on the quick stop ramp (codes 2 to 4 and 6 to 8 of 605Ah, 2 to 4 of 605Dh and 605Eh) is linear too, as it is to be short;
//! 20A0h = 1 keeps the profile there.

use motion::{Ramps, SIN_SQUARED};

use crate::objects::Objects;
use crate::option_codes::StopRamp;
use crate::units::Units;

/// What a motion profile type asks for, with this jerk in steps/s³; `None` if it is not supported.
pub(crate) const fn ramps(code: i16, jerk: u32) -> Option<Ramps> {
    let jerk = if jerk == 0 { 1 } else { jerk };
    match code {
        0 => Some(Ramps::Linear),
        1 if SIN_SQUARED => Some(Ramps::SinSquared),
        2 => Some(Ramps::MovingAverage(jerk)),
        3 => Some(jerk_limited(jerk)),
        _ => None,
    }
}

/// 3: where limited jerk is not built in, the moving average has the same jerk.
const fn jerk_limited(jerk: u32) -> Ramps {
    #[cfg(feature = "limited-jerk")]
    let ramps = Ramps::JerkLimited(jerk);
    #[cfg(not(feature = "limited-jerk"))]
    let ramps = Ramps::MovingAverage(jerk);
    ramps
}

/// All that are built in, those with a jerk at this one.
#[cfg(test)]
pub(crate) fn all_ramps(jerk: u32) -> std::vec::Vec<Ramps> {
    let mut ramps: std::vec::Vec<_> = (0..4).filter_map(|code| ramps(code, jerk)).collect();
    ramps.dedup();
    ramps
}

/// What is set up of the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProfileConfiguration {
    /// 6086h with 60A4h:1.
    pub ramps: Ramps,
    /// 20A0h: the quick stop ramp has the profile too.
    pub has_smooth_quick_stop: bool,
}

impl ProfileConfiguration {
    /// What holds before anything is set up: the trapezoid.
    pub const NONE: Self = Self {
        ramps: Ramps::Linear,
        has_smooth_quick_stop: false,
    };

    /// What the objects of a dictionary say.
    pub(crate) fn of<D: Objects>(dictionary: &D, units: &Units) -> Self {
        let jerk = units.jerk(dictionary.profile_jerk());
        Self {
            ramps: ramps(dictionary.motion_profile_type(), jerk).unwrap_or(Self::NONE.ramps),
            has_smooth_quick_stop: dictionary.smooth_quick_stop() == 1,
        }
    }

    /// Whether a stop on this ramp has the profile that is chosen.
    pub(crate) const fn is_smooth(&self, ramp: StopRamp) -> bool {
        match ramp {
            StopRamp::SlowDown => true,
            StopRamp::QuickStop | StopRamp::CurrentLimit | StopRamp::VoltageLimit => {
                self.has_smooth_quick_stop
            }
        }
    }
}

#[cfg(all(test, not(feature = "limited-jerk")))]
mod tests {
    use super::{Ramps, ramps};

    #[test]
    fn three_is_the_moving_average_where_limited_jerk_is_not_built_in() {
        for jerk in [1, 5_000_000, u32::MAX] {
            assert_eq!(ramps(3, jerk), Some(Ramps::MovingAverage(jerk)));
            assert_eq!(ramps(3, jerk), ramps(2, jerk));
        }
    }
}

//! What is asked of a plan, and why there may be none.

use core::fmt;

use crate::speed::{SignedSpeed, Speed};

/// What a motion may ask of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Profile velocity (6081h), more than 0. More than half a step per tick is cut to that.
    pub velocity: Speed,
    /// Profile acceleration (6083h) in steps/s², at least 1: rules while the speed grows.
    pub acceleration: u32,
    /// Profile deceleration (6084h) in steps/s², at least 1: rules while the speed falls.
    pub deceleration: u32,
}

/// Whether sin² ramps are built in (cargo feature `sin-squared`); otherwise [`Ramps::SinSquared`] is linear.
pub const SIN_SQUARED: bool = cfg!(feature = "sin-squared");

/// How the velocity changes (motion profile type, 6086h).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ramps {
    /// At constant acceleration: the trapezoid.
    #[default]
    Linear,
    /// As sin², within the time that the linear ramp takes and over the same distance; the acceleration reaches π/2 times its limit. The position
    /// is within 0.01 steps of that. A motion that leaves such a ramp before its end first finishes it, if it would accelerate or brake as
    /// far anyway; otherwise it brings the acceleration to zero, at the jerk at which that ramp began.
    SinSquared,
    /// With this jerk (60A4h) in steps/s³, at least 1: the double-S.
    #[cfg(feature = "limited-jerk")]
    JerkLimited(u32),
    /// As the moving average of linear ramps, at this jerk (60A4h) in steps/s³, at least 1. The plan is that of linear ramps; the axis
    /// takes the mean, and comes to rest a window later than the plan.
    MovingAverage(u32),
}

#[cfg(test)]
impl Ramps {
    /// Limited jerk, if it is built in.
    pub(crate) fn limited(jerk: u32) -> Option<Self> {
        #[cfg(feature = "limited-jerk")]
        return Some(Self::JerkLimited(jerk));
        #[cfg(not(feature = "limited-jerk"))]
        return Some(jerk).and(None);
    }

    /// The jerk that is limited.
    pub(crate) fn jerk(self) -> Option<u32> {
        match self {
            #[cfg(feature = "limited-jerk")]
            Self::JerkLimited(jerk) => Some(jerk),
            _ => None,
        }
    }
}

/// What a motion is after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// To stand at this position, in whole steps.
    Rest(i64),
    /// To pass this position, in whole steps, with this velocity (6082h), and keep it; see [`Plan::then_move_through`](super::Plan::then_move_through).
    Pass(i64, Speed),
    /// To keep this velocity; 0 is a stop.
    Velocity(SignedSpeed),
}

impl Goal {
    /// A stop: what [`Axis::stop`](crate::Axis::stop) asks for at `deceleration` steps/s².
    pub const fn stop(deceleration: u32) -> (Self, Limits) {
        let limits = Limits {
            velocity: Speed::ZERO,
            acceleration: 0,
            deceleration,
        };
        (Self::Velocity(SignedSpeed::ZERO), limits)
    }

    /// The same where all positions have other numbers, more by `shift`. One that is too far away stays so.
    #[must_use]
    #[inline(never)]
    pub const fn shifted(self, shift: i64) -> Self {
        match self {
            Self::Rest(target) => Self::Rest(target.saturating_add(shift)),
            Self::Pass(target, end) => Self::Pass(target.saturating_add(shift), end),
            Self::Velocity(_) => self,
        }
    }
}

/// Why there is no plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanError {
    /// The velocity limit is 0: the target would never be reached.
    ZeroVelocity,
    /// The acceleration limit is 0.
    ZeroAcceleration,
    /// The deceleration limit is 0: the axis would never stop.
    ZeroDeceleration,
    /// The jerk is 0: no ramp would begin.
    ZeroJerk,
    /// The target is 2³² steps or more away, or braking takes the axis that far from it. With limited jerk, an axis that cannot reach
    /// the target without coming to rest first may take less than 2³¹ steps for that.
    OutOfRange,
    /// A plan needs more pieces than it has room for, which cannot be. The axis is to be stopped: it goes on as the last piece does.
    Internal,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ZeroVelocity => "velocity limit is zero",
            Self::ZeroAcceleration => "acceleration limit is zero",
            Self::ZeroDeceleration => "deceleration limit is zero",
            Self::ZeroJerk => "jerk is zero",
            Self::OutOfRange => "target out of range",
            Self::Internal => "plan has no room for its pieces",
        })
    }
}

impl core::error::Error for PlanError {}

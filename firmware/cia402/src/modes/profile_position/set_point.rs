//! A set-point of profile position: what is asked for, and what the limits leave of it.

use motion::{Limits, Ramps, Speed};

use crate::actuator::Actuator;
use crate::commands;
use crate::modes::{Context, Types, braking};
use crate::motor::Motor;
use crate::travel::Travel;
use crate::units::Units;

/// A target with its profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SetPoint {
    /// The target that is asked for, in units of the user.
    wanted: i64,
    /// Where it begins in units of the user. From beyond a software limit it goes the way that it says, or nowhere.
    start: i64,
    /// The target in units of the user.
    pub(super) user: i64,
    /// The same in increments.
    pub(super) target: i64,
    /// 6081h, 6083h and 6084h.
    pub(super) asked: Limits,
    pub(super) limits: Limits,
    /// How the velocity changes: 6086h as it was at the edge of bit 4.
    pub(super) ramps: Ramps,
    /// 6082h.
    asked_end: Speed,
    /// What is left of the velocity at the target.
    pub(super) end_velocity: Speed,
    /// The target or the velocity is not what the master asked for.
    pub(super) limited: Limited,
    /// Of one that waits: the one before it does not slow down at its target more than needed.
    pub(super) blends: bool,
}

/// Which part of a set-point was cut to a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limited {
    pub(super) target: bool,
    pub(super) profile: bool,
}

impl Limited {
    pub(super) const NONE: Self = Self {
        target: false,
        profile: false,
    };
}

impl SetPoint {
    /// The set-point that is asked for; not within any limits yet. `wanted` is its target and `start`
    /// where it begins, in units of the user.
    pub(super) const fn new(
        given: commands::SetPoint,
        (start, wanted): (i64, i64),
        ramps: Ramps,
    ) -> Self {
        let asked = Limits {
            velocity: given.profile_velocity,
            acceleration: given.profile_acceleration,
            deceleration: given.profile_deceleration,
        };
        Self {
            wanted,
            start,
            user: wanted,
            target: 0,
            asked,
            limits: asked,
            ramps,
            asked_end: given.end_velocity,
            end_velocity: given.end_velocity,
            limited: Limited::NONE,
            blends: false,
        }
    }

    /// It begins here, in units of the user.
    pub(super) const fn begins_at(&mut self, start: i64) {
        self.start = start;
    }

    /// Cuts velocities and ramps to 607Fh, 6080h, 60C5h, 60C6h and what the pulses can reach, and 6082h to 6081h.
    #[inline(never)]
    pub(super) fn limit_profile(&mut self, context: &Context<'_, impl Types>) {
        (self.limits, self.limited.profile) = context.within(self.asked);
        if context.habits().start_speed {
            self.end_velocity = Speed::ZERO;
            return;
        }
        self.end_velocity = self.asked_end.min(self.limits.velocity);
        self.limited.profile |= self.end_velocity != self.asked_end;
    }

    /// 6082h of a drive to which it is a start speed.
    pub(super) fn start_speed(&self) -> Speed {
        self.asked_end.min(self.limits.velocity)
    }

    /// Cuts the target to the software limits, to 32 bits around `here`, in units of the user, and to these increments.
    pub(super) fn aim(
        &mut self,
        context: &Context<'_, impl Types>,
        here: i64,
        (nearest, farthest): (i64, i64),
    ) {
        let units = context.units();
        let (low, high) = context.travel.user;
        let (low, high) = (low.min(self.start), high.max(self.start));
        let (least, max) = units.range().within_reach(here);
        let user = self.wanted.max(least).min(max).max(low).min(high);
        let far = units.position(user);
        self.target = far.max(nearest).min(farthest);
        self.user = if self.target == far {
            user
        } else {
            units.position_in_units(self.target)
        };
        self.limited.target = self.user != self.wanted;
    }

    /// Cuts the velocity at the target so that the motor can stop at the software limit behind it. `direction` is the sign of the way, and
    /// `window` that of the mean in force, in microseconds.
    pub(super) fn end_within(&mut self, travel: Travel, direction: i64, window: u64) {
        if self.end_velocity == Speed::ZERO {
            return;
        }
        let (low, high) = travel.increments;
        let limit = if direction < 0 { low } else { high };
        let available = limit.saturating_sub(self.target).unsigned_abs();
        let end = if direction == 0 {
            Speed::ZERO
        } else {
            braking::stoppable(self.accelerations(), self.ramps, window, available)
        };
        self.limited.profile |= end < self.end_velocity;
        self.end_velocity = self.end_velocity.min(end);
    }

    /// Up and down, in steps/s².
    const fn accelerations(&self) -> (u32, u32) {
        (self.limits.acceleration, self.limits.deceleration)
    }

    /// Raises the velocity at the target to that with which the motor can still stop at `next`, so many steps behind it. It does so with
    /// the window of this one, if that is a mean: of so many microseconds, unless it is still to be chosen.
    pub(super) fn blend(&mut self, next: &Self, available: u64, window: u64) {
        let window = window.max(braking::window(self.accelerations(), self.ramps));
        let end = braking::stoppable(next.accelerations(), next.ramps, window, available);
        self.end_velocity = self.end_velocity.max(end.min(self.limits.velocity));
    }

    /// The positions between which the target is the end that lies ahead of the motor.
    pub(super) fn around(&self, motor: &Motor<impl Actuator>) -> (i64, i64) {
        let (low, high) = Travel::NONE.increments;
        if self.target < motor.committed_position() {
            (self.target, high)
        } else {
            (low, self.target)
        }
    }

    /// Whether the motor is beyond the limit that the target was cut to.
    pub(super) fn is_passed_by(&self, motor: &Motor<impl Actuator>, units: &Units) -> bool {
        let wanted = units.position(self.wanted);
        let position = motor.committed_position();
        wanted > self.target && self.target < position
            || wanted < self.target && position < self.target
    }
}

//! Velocity, mode 2 (CiA 402-2, "vl"): the motor keeps the velocity 6042h, as frequency converters do.
//!
//! - 6042h counts at once. Its amount is raised to 6046h:1 and cut to 6046h:2 (bit 11); 0 stays 0. Multiplied by 604Ch:1 and
//!   divided by 604Ch:2 it is a number of steps/s, and so are 6043h, 6044h, 6046h and the speeds of 6048h to 604Ah.
//! - 6048h, 6049h and 604Ah are a speed and the seconds for it: the ramps to speed up, to slow down, and of a quick stop.
//!   60C5h and 60C6h cap them.
//! - Controlword bit 4, enable ramp: 0 stops the motor on the quick stop ramp. Bit 5, unlock ramp: 0 holds the velocity where it is.
//!   Bit 6, reference ramp: 0 takes 0 for 6042h. All three are 1 in normal operation.
//! - Halt (bit 8) stops on the ramp of 605Dh, which here means 6049h or 604Ah. Software limits hold as in profile velocity.
//!
//! Bit 10: the velocity demand is what 6042h asks for; during halt the motor stands. Bits 12 and 13 are 0.

use motion::{Limits, SignedSpeed};

use super::kept_velocity::{KeptVelocity, Order};
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::configuration::VelocityConfiguration;
use crate::controlword::{ENABLE_RAMP, REFERENCE_RAMP, UNLOCK_RAMP};
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::{INTERNAL_LIMIT, TARGET_REACHED};

/// Who decides on the velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Control {
    Reference,
    Halt,
    /// Bit 4 is 0.
    Disabled,
    /// Bit 5 is 0; the velocity that is held.
    Locked(SignedSpeed),
}

/// The mode.
#[derive(Debug)]
pub(super) struct Velocity {
    motion: KeptVelocity,
    control: Control,
    /// What the velocity below was made from.
    source: Option<(i16, VelocityConfiguration)>,
    /// What 6042h asks for.
    asked: SignedSpeed,
    is_cut: bool,
    /// The velocity or a ramp of the order is cut to another limit.
    is_limited: bool,
}

impl Velocity {
    pub(super) const fn new() -> Self {
        Self {
            motion: KeptVelocity::new(),
            control: Control::Reference,
            source: None,
            asked: SignedSpeed::ZERO,
            is_cut: false,
            is_limited: false,
        }
    }

    /// The mode begins, whatever the motor does.
    pub(super) const fn enter(&mut self) {
        *self = Self::new();
    }

    /// The velocity that the motor is to keep; `None` if it is to stand.
    pub(super) const fn kept_velocity(&self) -> Option<SignedSpeed> {
        self.motion.velocity()
    }

    /// A limit switch is stopping the motor.
    pub(super) fn on_limit(&mut self, motor: &Motor<impl Actuator>) {
        self.motion.on_limit(motor);
    }

    /// One control tick; returns statusword bits 10 and 11.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        self.read(context);
        let before = self.control;
        self.control = self.controlled_by(context);
        let (asked, velocity) = match self.control {
            Control::Halt | Control::Disabled => {
                if before != self.control {
                    self.motion.forget();
                    self.stop(context);
                }
                let reached = context.motor.standstill() && context.is_brake_open;
                return self.bits(context, reached, false);
            }
            Control::Locked(velocity) => (velocity, velocity),
            Control::Reference => (i32::from(Self::reference(context)).into(), self.asked),
        };
        if !(context.is_as_before && self.motion.goes_on()) {
            let profile = &context.configuration.velocity;
            let (limits, is_limited) = context.within(Limits {
                velocity: velocity.unsigned_abs(),
                acceleration: profile.acceleration,
                deceleration: profile.deceleration,
            });
            self.is_limited = is_limited;
            let order = Order {
                asked,
                velocity: limits.velocity.with_sign_of(velocity),
                limits,
                travel: context.travel.increments,
                ramps: context.configuration.profile.ramps,
                quick_stop: context.deceleration(StopRamp::QuickStop),
            };
            self.motion.follow(order, context);
        }
        let is_cut = self.is_cut || self.is_limited;
        self.bits(
            context,
            context.demand.velocity.is_close_to(self.asked),
            is_cut,
        )
    }

    /// The controlword, with the bits of the ramp as they count.
    const fn controlword(context: &Context<'_, impl Types>) -> u16 {
        let given = context.commands.controlword;
        if context.habits().velocity_without_ramp_bits {
            given | ENABLE_RAMP | UNLOCK_RAMP | REFERENCE_RAMP
        } else {
            given
        }
    }

    /// 6042h as it is written; 0 without the reference ramp.
    const fn reference(context: &Context<'_, impl Types>) -> i16 {
        if Self::controlword(context) & REFERENCE_RAMP == 0 {
            0
        } else {
            context.commands.vl_target_velocity
        }
    }

    /// 6042h with its limits. The division is made only when something has changed.
    fn read(&mut self, context: &Context<'_, impl Types>) {
        if context.is_as_before && self.source.is_some() {
            return;
        }
        let profile = context.configuration.velocity;
        let reference = Self::reference(context);
        if self.source == Some((reference, profile)) {
            return;
        }
        self.source = Some((reference, profile));
        let amount = u32::from(reference.unsigned_abs());
        let within = if amount == 0 {
            0
        } else {
            amount.max(profile.min_amount).min(profile.max_amount)
        };
        self.is_cut = within != amount;
        self.asked = profile.speed(within, reference < 0);
    }

    fn controlled_by(&self, context: &Context<'_, impl Types>) -> Control {
        let controlword = Self::controlword(context);
        if context.is_held() {
            Control::Halt
        } else if controlword & ENABLE_RAMP == 0 {
            Control::Disabled
        } else if controlword & UNLOCK_RAMP != 0 {
            Control::Reference
        } else if let Control::Locked(velocity) = self.control {
            Control::Locked(velocity)
        } else {
            Control::Locked(context.motor.committed_velocity())
        }
    }

    fn stop(&self, context: &mut Context<'_, impl Types>) {
        if self.control == Control::Halt {
            context.halt();
        } else if !context.motor.standstill() {
            context.stop_on(StopRamp::QuickStop);
        }
    }

    fn bits(&self, context: &Context<'_, impl Types>, reached: bool, is_cut: bool) -> u16 {
        let is_limited = is_cut || self.motion.is_limited(context.motor);
        let bit = |condition, bit| if condition { bit } else { 0 };
        bit(reached, TARGET_REACHED) | bit(is_limited, INTERNAL_LIMIT)
    }
}

#[cfg(test)]
mod tests;

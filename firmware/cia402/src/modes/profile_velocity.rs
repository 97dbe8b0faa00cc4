//! Profile velocity, mode 3 (CiA 402-2): the motor keeps the target velocity 60FFh.
//!
//! - 60FFh counts at once, whenever it is written; speeding up takes 6083h, slowing down 6084h, and a change of sign passes
//!   through standstill with first the one and then the other. A change of a ramp or limit counts at once too.
//! - It counts from operation enabled on, also when it was written before. Halt (bit 8) stops on the ramp of 605Dh; releasing it
//!   ramps to 60FFh again.
//! - The velocity is cut to 607Fh, to 6080h and to what the pulses can reach. Before a software limit 607Dh the motor slows
//!   down and stops on it; the way back is free. Bit 11 shows each of these.
//! - The mode may begin while the motor moves: it ramps from there.
//!
//! Bit 10, target reached: 606Ch has been within 606Dh of 60FFh for 606Eh; during halt the motor stands. Bit 12, speed: 0 as soon as
//! 606Ch has been above 606Fh for 6070h, 1 otherwise. Bit 13, slippage error: 606Bh and 606Ch differ by more than 60F8h.

use motion::{Limits, SignedSpeed, Speed};

use super::kept_velocity::{KeptVelocity, Order};
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::{INTERNAL_LIMIT, SLIPPAGE, SPEED_ZERO, TARGET_REACHED};
use crate::window_timer::WindowTimer;

/// The mode.
#[derive(Debug)]
pub(super) struct ProfileVelocity {
    motion: KeptVelocity,
    /// The velocity or a ramp of the order is cut to its limit.
    is_cut: bool,
    is_held: bool,
    reached: WindowTimer,
    moving: WindowTimer,
}

impl ProfileVelocity {
    pub(super) const fn new() -> Self {
        Self {
            motion: KeptVelocity::new(),
            is_cut: false,
            is_held: false,
            reached: WindowTimer::new(),
            moving: WindowTimer::new(),
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

    /// One control tick; returns statusword bits 10 to 13.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        let is_held = context.is_held();
        if is_held && !self.is_held {
            self.motion.forget();
            context.halt();
        }
        self.is_held = is_held;
        if !(context.is_as_before && self.motion.goes_on()) {
            let order = self.order(context);
            if !is_held {
                self.motion.follow(order, context);
            }
        }
        self.bits(context)
    }

    /// What is asked for now.
    fn order(&mut self, context: &Context<'_, impl Types>) -> Order {
        let asked = context.commands.target_velocity;
        let (limits, is_cut) = context.within(Limits {
            velocity: asked.unsigned_abs(),
            acceleration: context.commands.profile_acceleration,
            deceleration: context.commands.profile_deceleration,
        });
        self.is_cut = is_cut;
        Order {
            asked,
            velocity: limits.velocity.with_sign_of(asked),
            limits,
            travel: context.travel.increments,
            ramps: context.configuration.profile.ramps,
            quick_stop: context.deceleration(StopRamp::QuickStop),
        }
    }

    fn bits(&mut self, context: &Context<'_, impl Types>) -> u16 {
        let (configuration, asked) = (context.configuration, context.commands.target_velocity);
        let velocity = context.observed.velocity;
        let reached = self.reached.has_held(
            context.now,
            velocity.abs_diff(asked) <= configuration.velocity_window.plus(Speed::TOLERANCE),
            configuration.velocity_window_time,
        );
        let moving = self.moving.has_held(
            context.now,
            velocity.unsigned_abs() > configuration.velocity_threshold,
            configuration.velocity_threshold_time,
        );
        let is_limited = self.is_cut || self.motion.is_limited(context.motor);
        let slips = context.observed.slippage.unsigned_abs() > configuration.max_slippage;
        let bit = |condition, bit| if condition { bit } else { 0 };
        let reached = if context.is_halted() {
            context.motor.standstill()
        } else {
            reached
        };
        bit(reached, TARGET_REACHED)
            | bit(is_limited, INTERNAL_LIMIT)
            | bit(!moving, SPEED_ZERO)
            | bit(slips, SLIPPAGE)
    }
}

#[cfg(test)]
mod tests;

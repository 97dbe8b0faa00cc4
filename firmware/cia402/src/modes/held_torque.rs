//! Holding a torque: what profile torque and cyclic synchronous torque share.
//!
//! The contract:
//! - The torque is held within the limits of torque and current; the velocity is held within 6080h and 607Fh, by less torque.
//! - A torque into a limit switch, or towards a software limit 607Dh from where the quick stop ramp would end beyond it, is not held: the motor
//!   stops on that ramp and stays. A torque the other way is held at once.

use motion::{Ramps, low};

use super::{Context, Types};
use crate::actuator::Actuator;
use crate::option_codes::StopRamp;
use crate::statusword::INTERNAL_LIMIT;

/// The state of a held torque.
#[derive(Debug)]
pub(super) struct HeldTorque {
    /// A limit of the position is in the way of a torque of this sign; 0 for none.
    blocked: i16,
}

impl HeldTorque {
    pub(super) const fn new() -> Self {
        Self { blocked: 0 }
    }

    /// A limit switch is stopping the motor.
    pub(super) fn on_limit(&mut self, torque: i16) {
        self.blocked = torque.signum();
    }

    /// Holds a torque, in thousandths of the rated one. Returns bit 11.
    pub(super) fn hold(&mut self, asked: i16, context: &mut Context<'_, impl Types>) -> u16 {
        let limits = context.configuration.torque;
        let positive = limits.max.min(limits.positive);
        let negative = limits.max.min(limits.negative);
        let least = i16::try_from(negative).map_or(-i16::MAX, i16::wrapping_neg);
        let max = i16::try_from(positive).unwrap_or(i16::MAX);
        let torque = asked.min(max).max(least);
        let sign = torque.signum();
        if sign != self.blocked && sign != 0 {
            self.blocked = 0;
        }
        let is_free = context.motor.is_free(torque.into()).is_ok();
        if !is_free || self.is_beyond(sign, context) {
            self.blocked = sign;
        }
        if self.blocked != 0 {
            if !context.motor.is_stopping() && !context.motor.standstill() {
                context.stop_on(StopRamp::QuickStop);
            }
            return INTERNAL_LIMIT;
        }
        // It is free, and a mode of torque is there only where the actuator has one.
        let _ = context.motor.hold_torque(torque);
        if torque == asked { 0 } else { INTERNAL_LIMIT }
    }

    /// Whether the quick stop ramp would end beyond a software limit.
    fn is_beyond(&self, sign: i16, context: &Context<'_, impl Types>) -> bool {
        let (low, high) = context.travel.increments;
        let deceleration = context.deceleration(StopRamp::QuickStop);
        // It can be told in the next tick, and takes effect some pulses later.
        let distance = i128::from(context.motor.committed_velocity().bits())
            .wrapping_mul(i128::from(context.elapsed).wrapping_mul(2))
            .wrapping_div(1_000_000)
            >> 32;
        let rest = context
            .motor
            .stop_preview(deceleration, Ramps::Linear, None);
        let end = rest.saturating_add(low::i64(distance));
        match sign {
            1 => end >= high,
            -1 => end <= low,
            _ => end > high || end < low,
        }
    }
}

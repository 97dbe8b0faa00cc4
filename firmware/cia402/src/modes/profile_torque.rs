//! Profile torque, mode 4 (CiA 402-2): the motor holds the target torque 6071h.
//!
//! - 6071h counts at once, whenever it is written; the demand 6074h goes there by 6087h in each second, from the torque that the motor has when the mode begins.
//! - How a torque is held, [`HeldTorque`] says.
//! - Halt (bit 8) stops the motor on the ramp of 605Dh; released, the torque begins anew from what the motor has then.
//! - The mode may begin while the motor moves.
//!
//! Bit 10, target reached: 6074h is 6071h; during halt, the motor stands. Bit 11: a limit is in the way.

use motion::low;

use super::held_torque::HeldTorque;
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::motor::Motor;
use crate::statusword::TARGET_REACHED;

/// Parts of a thousandth in which the demand is kept: what 6087h adds in a microsecond is a whole number of them.
const PARTS: i64 = 1_000_000;

/// The mode.
#[derive(Debug)]
pub(super) struct ProfileTorque {
    held: HeldTorque,
    /// The demand, in parts of a thousandth; `None` until the motor has said where it begins.
    demand: Option<i64>,
    is_halted: bool,
}

impl ProfileTorque {
    pub(super) const fn new() -> Self {
        Self {
            held: HeldTorque::new(),
            demand: None,
            is_halted: false,
        }
    }

    /// The mode begins, whatever the motor does.
    pub(super) const fn enter(&mut self) {
        *self = Self::new();
    }

    /// A limit switch is stopping the motor.
    pub(super) fn on_limit(&mut self, motor: &Motor<impl Actuator>) {
        self.held.on_limit(motor);
    }

    /// One control tick; returns statusword bits 10 and 11.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        if context.is_held() {
            if !self.is_halted {
                self.is_halted = true;
                context.halt();
            }
            self.held.forget();
            self.demand = None;
            let stands = context.is_halted() && context.motor.standstill();
            return if stands { TARGET_REACHED } else { 0 };
        }
        self.is_halted = false;
        let target = context.commands.target_torque;
        let wanted = i64::from(target).wrapping_mul(PARTS);
        let before = self.demand.unwrap_or_else(|| {
            let torque = context.motor.torque().map_or(0, |torque| torque.demand);
            i64::from(torque).wrapping_mul(PARTS)
        });
        let slope = u64::from(context.configuration.torque.slope);
        let change = slope.saturating_mul(context.elapsed.into());
        let change = i64::try_from(change).unwrap_or(i64::MAX);
        let demand = wanted
            .max(before.saturating_sub(change))
            .min(before.saturating_add(change));
        self.demand = Some(demand);
        // It lies between two numbers of 16 bits.
        let bits = self.held.hold(low::i16(demand / PARTS), context);
        if demand == wanted {
            bits | TARGET_REACHED
        } else {
            bits
        }
    }
}

//! Cyclic synchronous position, mode 8 (CiA 402-2): the master gives a position in each period, and the motor is there a constant time
//! later.
//!
//! - The set-point is 607Ah plus 60B0h, as they are at SYNC; what is written after it counts at the next one, and of several writes the
//!   last. Without SYNC each write of 607Ah is one. How it is followed, [`Following`] says.
//! - 60B1h, the velocity feed-forward, is given to the loops beside the velocity of the path; it has nothing to do where no loop is closed.
//! - It begins with the demand where the motor stands, and waits for the first set-point.
//! - Halt (bit 8) stops on the ramp of 605Dh; released, the motor catches up with the set-points.
//! - Too many set-points missing: the motor stops with 6085h, and 2051h:2 says what else. It follows again when it has come to rest
//!   and set-points come.
//!
//! Bit 10: during halt, the motor stands. Bit 11: a set-point was cut to a limit, or is being caught up with. Bit 12, drive follows the
//! command value: 1 as long as it does. Bit 13: following error.

use super::following::{Following, Outcome};
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::statusword::{FOLLOWS, INTERNAL_LIMIT, TARGET_REACHED};

/// The mode.
#[derive(Debug)]
pub(super) struct CyclicPosition {
    motion: Following,
    is_held: bool,
}

impl CyclicPosition {
    pub(super) const fn new() -> Self {
        Self {
            motion: Following::new(),
            is_held: false,
        }
    }

    /// The mode begins; the motor stands, or comes to rest.
    pub(super) const fn enter(&mut self) {
        *self = Self::new();
    }

    /// A limit switch is stopping the motor.
    pub(super) fn on_limit(&mut self) {
        self.motion.on_limit();
    }

    /// One control tick; returns statusword bits 10 to 12.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        if context.is_held() {
            if !self.is_held {
                self.is_held = true;
                self.motion.forget();
                context.halt();
            }
        } else {
            self.is_held = false;
            for slot in context.slots {
                let position = slot.event.and_then(|event| event.position);
                let target = position.map(|position| context.target(position));
                if self.motion.take(*slot, target, context) == Outcome::Lost {
                    self.motion.forget();
                    context.lose_set_points();
                }
            }
            if context.is_running_out() {
                self.motion.forget();
                context.lose_set_points();
            }
        }
        bits(&self.motion, context)
    }
}

/// Statusword bits 10 to 12 of the modes that follow positions.
pub(super) fn bits(motion: &Following, context: &Context<'_, impl Types>) -> u16 {
    let bit = |condition, bit| if condition { bit } else { 0 };
    let stands = context.is_halted() && context.motor.standstill();
    bit(stands, TARGET_REACHED)
        | bit(motion.is_limited(), INTERNAL_LIMIT)
        | bit(motion.follows(), FOLLOWS)
}

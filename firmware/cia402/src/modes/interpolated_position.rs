//! Interpolated position, mode 7 (CiA 402-2): the motor goes through the data records 60C1h, one in each period 60C2h.
//!
//! - Each write of 60C1h:1 puts a record into the buffer 60C4h. While controlword bit 4 is 1 (enable interpolation) and there is no halt, one
//!   record leaves it at each SYNC that is due by 60C2h; without SYNC, in each period. How it is followed, [`Following`] says.
//! - An empty buffer is bridged as a missing set-point is. Then the motor stops with 6085h, and 2051h:2 says what else.
//! - Bit 4 = 0 and halt stop on the ramp of 605Dh. The records stay, and those that come are kept, until 60C4h:6 = 0 clears the buffer. Leaving
//!   the mode, or operation enabled, clears it too. Halt with bit 4 = 0 says that nothing is wanted: what comes meanwhile is dropped, or it would
//!   be in the way of a master that repeats its RPDO with each SYNC.
//!
//! Bit 10: the motor stands at the last record and none waits; not where a limit or a stop has kept it from there. During halt, the motor
//! stands. Bit 11 as in cyclic synchronous position. Bit 12: the
//! motor follows records.

use super::cyclic_position::bits;
use super::following::{Following, Outcome};
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::controlword::NEW_SET_POINT;
use crate::statusword::TARGET_REACHED;

/// Controlword bit 4 in this mode.
const ENABLE: u16 = NEW_SET_POINT;

/// The mode.
#[derive(Debug)]
pub(super) struct InterpolatedPosition {
    motion: Following,
    is_held: bool,
    /// The motor stands where the last record has led it.
    is_there: bool,
}

impl InterpolatedPosition {
    pub(super) const fn new() -> Self {
        Self {
            motion: Following::new(),
            is_held: false,
            is_there: false,
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
        let is_enabled = context.commands.controlword & ENABLE != 0;
        if context.is_held() || !is_enabled {
            if !self.is_held {
                self.is_held = true;
                self.motion.forget();
                context.halt();
            }
        } else {
            self.is_held = false;
            for slot in context.slots {
                let record = context.buffer.pop();
                let target = record.map(|record| context.target(record));
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
        // Somebody else stops the motor, or it has been at rest since it came there.
        let is_there = self.motion.is_at_goal().unwrap_or(self.is_there);
        self.is_there = is_there && context.motor.standstill();
        let is_over = self.is_there && context.buffer.len() == 0;
        let reached = if is_over { TARGET_REACHED } else { 0 };
        bits(&self.motion, context) | reached
    }
}

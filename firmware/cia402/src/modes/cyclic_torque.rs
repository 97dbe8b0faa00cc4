//! Cyclic synchronous torque, mode 10 (CiA 402-2): the master gives a torque in each period.
//!
//! - The set-point is 6071h plus 60B2h, as they are at SYNC, or as 6071h is written where there is none. It is held until the next. How, [`HeldTorque`] says.
//! - The mode may begin while the motor moves; until the first set-point the motor goes on to a standstill with 6085h and stays there.
//! - A missing set-point keeps the torque, as often as 2051h:1 says. Then the motor stops with 6085h, and 2051h:2 says what else.
//! - Halt (bit 8) stops on the ramp of 605Dh; set-points that come after it count again.
//!
//! Bit 10: during halt, the motor stands. Bit 11: a limit is in the way. Bit 12, drive follows the command value.

use super::held_torque::HeldTorque;
use super::{Context, Types};
use crate::actuator::Actuator;
use crate::motor::Motor;
use crate::option_codes::StopRamp;
use crate::statusword::{FOLLOWS, INTERNAL_LIMIT, TARGET_REACHED};

/// The mode.
#[derive(Debug)]
pub(super) struct CyclicTorque {
    held: HeldTorque,
    /// The last set-point; `None` while none is followed.
    torque: Option<i16>,
    bridged: u8,
    is_halted: bool,
}

impl CyclicTorque {
    pub(super) const fn new() -> Self {
        Self {
            held: HeldTorque::new(),
            torque: None,
            bridged: 0,
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

    /// One control tick; returns statusword bits 10 to 12.
    #[inline(never)]
    pub(super) fn tick(&mut self, context: &mut Context<'_, impl Types>) -> u16 {
        if context.is_held() {
            if !self.is_halted {
                self.is_halted = true;
                context.halt();
            }
            self.held.forget();
            self.torque = None;
            let stands = context.is_halted() && context.motor.standstill();
            return if stands { TARGET_REACHED } else { 0 };
        }
        self.is_halted = false;
        let lost = &context.configuration.cyclic.lost;
        for slot in context.slots {
            match slot.event.and_then(|event| event.torque) {
                Some(torque) => {
                    self.torque = Some(torque);
                    self.bridged = 0;
                }
                None if self.torque.is_none() || lost.is_as_before() => {}
                None if self.bridged >= lost.bridged => {
                    self.torque = None;
                    context.lose_set_points();
                }
                None => self.bridged = self.bridged.saturating_add(1),
            }
        }
        let Some(torque) = self.torque else {
            self.held.forget();
            if !context.motor.is_stopping() && !context.motor.standstill() {
                context.stop_on(StopRamp::QuickStop);
            }
            return 0;
        };
        let bits = self.held.hold(torque, context);
        if bits & INTERNAL_LIMIT == 0 {
            FOLLOWS
        } else {
            bits
        }
    }
}

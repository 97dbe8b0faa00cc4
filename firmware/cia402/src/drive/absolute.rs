//! An absolute encoder at power-up: positions begin at its zero, and home may be there.
//!
//! It knows the angle within a turn. Its board counts from its zero, so 6064h begins within the turn, in the direction of 2072h. With 2030h:1 bit 9 the zero is
//! the home position, called as homing calls it (607Ch), and known: the machine has no way beyond a turn. Of the zeros that are whole turns apart
//! it is the one that has the motor nearest to the middle of 607Dh; without both limits, or with limits more than a turn apart, that of the board's count.

use super::Drive;
use crate::actuator::{Actuator, TORQUE_MODES};
use crate::board::Inputs;
use crate::objects::Objects;

/// Where positions begin with an absolute encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// The configuration has not come yet.
    NotConfigured,
    /// Nor has the angle of an absolute encoder. That of any other never comes.
    Awaited,
    /// It is taken.
    Taken,
}

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// A step axis has no absolute encoder: nothing of this is linked there.
    const MAY_BE_ABSOLUTE: bool = Self::MODES & TORQUE_MODES != 0;

    /// The configuration has come.
    pub(super) fn await_origin(&mut self) {
        if Self::MAY_BE_ABSOLUTE && self.origin == Origin::NotConfigured {
            self.origin = Origin::Awaited;
        }
    }

    /// Takes the direction of counting over, and the origin once it is known. There is no power.
    pub(super) fn take_direction(&mut self, inputs: &Inputs) {
        if Self::MAY_BE_ABSOLUTE && self.origin == Origin::Awaited && inputs.absolute_turn != 0 {
            self.begin_at_encoder(inputs);
        }
        let is_reversed = self.configuration.is_reversed;
        self.motor.set_reversed(is_reversed, inputs.position);
    }

    #[cold]
    #[inline(never)]
    fn begin_at_encoder(&mut self, inputs: &Inputs) {
        self.origin = Origin::Taken;
        self.motor.count_as_encoder(self.configuration.is_reversed);
        if !self.configuration.homing.is_encoder_zero() {
            return;
        }
        let position = self.motor.position_of(inputs.position);
        self.look_at_units(position);
        let position = position.wrapping_add(self.call_home(position, 0));
        // Of what 607Dh means from there.
        self.look_at_units(position);
        let (low, high) = self.limits.travel().increments;
        let turn = i64::from(inputs.absolute_turn);
        if high.saturating_sub(low) > turn {
            return;
        }
        let middle = low.saturating_add(high) >> 1;
        let away = middle.saturating_sub(position).saturating_add(turn / 2);
        let turns = away.checked_div_euclid(turn).unwrap_or(0);
        let name = self.home_name();
        self.call_home(position, name.wrapping_sub(turns.wrapping_mul(turn)));
    }

    /// What the home position is called, in increments.
    fn home_name(&self) -> i64 {
        let units = self.configuration.units.of_drive::<D>();
        units.position(self.configuration.homing.position_at_home().into())
    }

    /// The position `home` is that of a motor that stands at `position`, as after homing. Returns by how much all positions have changed.
    fn call_home(&mut self, position: i64, home: i64) -> i64 {
        let name = self.home_name();
        let user = self.configuration.homing.position_at_home();
        let change = self.motor.set_home(position, motion::low::i32(home), name);
        self.frame.found_home(user, name);
        change
    }
}

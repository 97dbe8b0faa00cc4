//! What a tick publishes: statusword, mode display and actual values of one moment, in units of the user. Increments become
//! these here and nowhere else.

use canopen::Instant;

use motion::low;

use super::{Drive, Inputs};
use crate::actuator::{Actuator, TORQUE_MODES, Torque};
use crate::cyclic::LOCKED;
use crate::exchange::Actuals;
use crate::mode::Mode;
use crate::objects::Objects;
use crate::state_machine::State;
use crate::statusword;

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// The statusword bits of the mode outside of operation enabled.
    pub(super) const fn idle_bits(&self) -> u16 {
        self.modes.idle_bits(&self.motor, &self.configuration)
    }

    pub(super) fn actuals(&self, now: Instant, inputs: &Inputs, mode_bits: u16) -> Actuals {
        let state = self.machine.state();
        let bit = |condition, bit| if condition { bit } else { 0 };
        let units = self.configuration.units.of_drive::<D>();
        let shown = |increments| self.frame.shown(increments, units);
        let position = self.motor.position_of(inputs.position);
        let (demand, observed) = (self.motor.demand(), self.monitor.observed());
        let mode = self.modes.active();
        let position_demand = shown(demand.position);
        let velocity_demand = units.velocity_in_units(demand.velocity);
        // A motor that follows its pulses needs no conversions of its own.
        let position_actual = if position == demand.position {
            position_demand
        } else {
            shown(position)
        };
        let vl = |velocity| match mode {
            Mode::Velocity => self.configuration.velocity.shown(velocity),
            _ => 0,
        };
        let vl_velocity_demand = vl(demand.velocity);
        let (velocity_actual, vl_velocity_actual) = if observed.velocity == demand.velocity {
            (velocity_demand, vl_velocity_demand)
        } else {
            let velocity = observed.velocity;
            (units.velocity_in_units(velocity), vl(velocity))
        };
        let sync = self.cyclic.status();
        let is_on = self.power.is_on() || state == State::SwitchedOn;
        let is_fed =
            self.periphery.stage.has_supply && (!D::DRIVE_HABITS.voltage_needs_power || is_on);
        Actuals {
            at: now,
            statusword: state.statusword()
                | bit(is_fed, statusword::VOLTAGE_ENABLED)
                | bit(
                    D::DRIVE_HABITS.quick_stop_bit_while_disabled
                        && state == State::SwitchOnDisabled,
                    statusword::QUICK_STOP,
                )
                | bit(self.faults.warning(), statusword::WARNING)
                | bit(
                    self.commands.remote || D::DRIVE_HABITS.is_always_remote,
                    statusword::REMOTE,
                )
                | bit(
                    self.monitor.had_following_error() && mode.has_following_error(),
                    statusword::FOLLOWING_ERROR,
                )
                | bit(
                    D::DRIVE_HABITS.lock_is_bit_8 && sync.state == LOCKED,
                    statusword::LOCKED,
                )
                | mode_bits,
            mode_display: mode.code(),
            error_code: self.faults.error_code(),
            vl_velocity_demand,
            vl_velocity_actual,
            position_demand,
            position_actual_internal: low::i32(position),
            position_actual,
            velocity_demand,
            velocity_actual,
            following_error: units.distance_in_units(observed.following_error),
            torque: if Self::MODES & TORQUE_MODES == 0 {
                Torque::NONE
            } else {
                self.motor.torque().unwrap_or(Torque::NONE)
            },
            digital_inputs: self.switches.word(),
            counter: inputs.counter,
            has_compare: inputs.has_compare,
            referenced: self.motor.is_referenced(),
            homing_failure: self.modes.homing_failure(),
            sync,
            is_moving: !self.motor.standstill(),
            safe: !self.power.is_on()
                && self.motor.standstill()
                && matches!(state, State::SwitchOnDisabled | State::Fault)
                && self.commands.restart == self.has_restarted,
        }
    }
}

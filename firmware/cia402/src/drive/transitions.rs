//! The state machine in a tick: what it looks at, and what a transition does to the motor.

use super::stopping::Power;
use super::{Drive, Tick};
use crate::actuator::Actuator;
use crate::controlword::Command;
use crate::faults::Reaction;
use crate::objects::Objects;
use crate::option_codes::{Stop, StopRamp};
use crate::state_machine::{Conditions, Progress, State, Transition};

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// Whether operation is enabled as it was in the tick before, and nothing else is asked for: only a fault changes the state.
    pub(super) fn is_unchanged(&self, is_asked: bool) -> bool {
        !is_asked && self.machine.progress() == Progress::Settled
    }

    /// Faults, then the state machine, then what a transition does to the motor.
    #[inline(never)]
    pub(super) fn change_state(&mut self, tick: &Tick<'_>, command: Option<Command>) {
        let now = tick.now;
        let both_limits = self.switches.both_limits();
        let found = tick.inputs.fault.or(self.commands.fault);
        let detected = self.faults.detect(
            tick.inputs,
            self.power.is_on(),
            !D::DRIVE_HABITS.following_error_is_told
                && (tick.is_displaced || self.monitor.observed().exceeds_window),
            both_limits,
            &self.periphery.stage,
            found,
        );
        let control = self.control(tick, command);
        let (remote, command) = (control.is_remote, self.gated(control.command));
        let silent = self.check_set_points();
        let late = self.check_pulses();
        let reaction = detected.or(control.fault).or(silent).or(late);
        if self.is_unchanged(tick.is_asked) && reaction.is_none() {
            return;
        }
        let is_over = self.motor.standstill() && self.is_held_by_brake(now, remote, command);
        // Where a motor that is only switched on has current, that goes behind its brake.
        let waits = D::DRIVE_HABITS.power_when_switched_on
            && self.machine.state() == State::SwitchedOn
            && !is_over;
        let has_shown = self.has_shown(tick);
        let reset = self.take_fault_reset(is_over, has_shown, reaction.is_some());
        let conditions = Conditions {
            command: command.filter(|command| !waits || *command != Command::Shutdown),
            remote,
            quick_stop: self.configuration.quick_stop,
            at_once: self.leaving(command) == Some(Stop::PowerOff),
            standstill: is_over && has_shown,
            fault: reaction.is_some(),
            fault_reset: reset && !self.faults.cause_stands(),
        };
        if reset && self.machine.state() == State::Fault && self.faults.cause_stands() {
            self.faults.renew();
        }
        if let Some(transition) = self.machine.step(now, &conditions) {
            self.carry_out(transition, reaction);
        } else if reaction == Some(Reaction::PowerOff) {
            self.power_off();
        } else if control.begins_stop && self.is_stopped_by_state() {
            self.stop(Stop::Ramp(StopRamp::QuickStop));
        }
        if command == Some(Command::DisableVoltage) {
            // It waits for nothing, and no fault reaction goes on against it.
            self.power_off();
        }
        let may_open = now >= self.brakes.may_open_at && !self.is_leaving(remote, command);
        let is_open = self.power.is_on() && (self.brakes.wanted.is_released() || may_open);
        self.brakes.wanted.set(is_open, now);
        self.end_own_stop(now, remote);
        self.machine.settle(
            command == Some(Command::EnableOperation)
                && self.commands.remote
                && self.power == Power::On
                && self.brakes.wanted.is_released()
                && !tick.is_asked,
        );
    }

    /// The command, unless it leads towards power where there is none to be had.
    fn gated(&self, command: Option<Command>) -> Option<Command> {
        let is_gated = D::DRIVE_HABITS.supply_gates_ready
            && !self.periphery.stage.has_supply
            && self.machine.state() == State::SwitchOnDisabled;
        command.filter(|command| {
            !is_gated || matches!(command, Command::DisableVoltage | Command::QuickStop)
        })
    }

    /// The action of a transition (CiA 402-2, "transition events and actions").
    fn carry_out(&mut self, transition: Transition, reaction: Option<Reaction>) {
        match transition.to {
            State::OperationEnabled => {
                self.power = Power::On;
                self.modes.enter(&self.motor);
            }
            State::SwitchedOn if D::DRIVE_HABITS.power_when_switched_on => self.power = Power::On,
            State::QuickStopActive => self.stop(self.machine.quick_stop().stop()),
            State::FaultReactionActive => match reaction {
                Some(Reaction::AsConfigured) if self.power.is_on() => {
                    self.stop(self.configuration.fault_reaction);
                }
                _ => self.power_off(),
            },
            State::SwitchOnDisabled if transition.from == State::Fault => {
                self.monitor.forget_following_error();
                self.faults.reset();
            }
            _ => self.power_off(),
        }
    }
}

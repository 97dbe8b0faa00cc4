//! Which command a tick obeys: what the master wrote, what it wrote too fast to be seen, and what 6007h makes of its silence.

use super::Drive;
use crate::controlword::{Command, FAULT_RESET};
use crate::faults::Reaction;
use crate::objects::Objects;
use crate::option_codes::AbortConnectionOption;
use crate::state_machine::State;

impl<D: Objects> Drive<D> {
    /// The command of this tick: that of the controlword; or, as a controlword with bit 7 is none, the one before it to leave
    /// operation enabled, while that waits for the motor.
    pub(super) fn command(&mut self) -> Option<Command> {
        let given = self.given_command();
        if self.machine.state() != State::OperationEnabled {
            self.pending = None;
        } else if given.is_some() {
            self.pending = given.filter(|given| self.leaving(Some(*given)).is_some());
        }
        given.or(self.pending)
    }

    /// What the master has given: a command to stop that was overwritten since the last tick, else "shutdown" if a master in a
    /// hurry has gone past it already, else the one that stands in the controlword, or stood there before one with bit 7.
    fn given_command(&mut self) -> Option<Command> {
        let commands = &self.commands;
        let standing = Command::decode(commands.controlword).or(commands.overwritten);
        let leads_up = matches!(standing, Some(Command::SwitchOn | Command::EnableOperation));
        let hurried =
            commands.remote && leads_up && (self.shutdown_first || commands.shutdown_first);
        // It waits for the stop or the fault reset that came before it; that may wait for the end of a reaction that is being shown.
        let is_faulty = matches!(
            self.machine.state(),
            State::Fault | State::FaultReactionActive
        );
        let resets = is_faulty && (self.resets_early || commands.rising & FAULT_RESET != 0);
        self.shutdown_first = hurried && (commands.stop.is_some() || resets);
        if commands.stop.is_some() {
            commands.stop
        } else if hurried && self.machine.state() == State::SwitchOnDisabled {
            Some(Command::Shutdown)
        } else {
            standing
        }
    }

    /// Whether the master resets a fault: in this tick, or when the reaction was over already and went on only to be seen
    /// (`is_over`, and not yet `has_shown`). A fault that comes later is no one's that the master knows.
    pub(super) fn resets_fault(&mut self, is_over: bool, has_shown: bool, is_new: bool) -> bool {
        let edge = self.commands.remote && self.commands.rising & FAULT_RESET != 0;
        if self.machine.state() != State::FaultReactionActive {
            self.is_only_shown = false;
            return edge | core::mem::take(&mut self.resets_early);
        }
        let is_only_shown = is_over && !has_shown;
        let was_only_shown = core::mem::replace(&mut self.is_only_shown, is_only_shown);
        self.resets_early |= edge && (is_only_shown || was_only_shown);
        self.resets_early &= !is_new;
        edge
    }

    /// What is left of remote control: whether there is one, the command, and the fault that its loss is. A reset of the device
    /// always stops the motor; otherwise 6007h says what the loss means to a drive with power.
    pub(super) fn under_6007h(
        &mut self,
        command: Option<Command>,
    ) -> (bool, Option<Command>, Option<Reaction>) {
        let Some(code) = self
            .commands
            .connection_error
            .filter(|_| !self.commands.remote)
        else {
            self.is_abandoned = false;
            return (self.commands.remote, command, None);
        };
        match self.configuration.abort_connection {
            AbortConnectionOption::NoAction => (true, command, None),
            AbortConnectionOption::FaultSignal if self.power && !self.is_abandoned => {
                self.is_abandoned = true;
                self.faults.connection_lost(code);
                let command = command.filter(|given| *given == Command::DisableVoltage);
                (true, command, Some(Reaction::AsConfigured))
            }
            AbortConnectionOption::DisableVoltage => (true, Some(Command::DisableVoltage), None),
            AbortConnectionOption::FaultSignal | AbortConnectionOption::QuickStop => {
                (false, command, None)
            }
        }
    }

    /// The fault that too many missing set-points of a cyclic mode are, if 2051h:2 makes them one. The mode has stopped the motor
    /// already.
    pub(super) fn set_points_lost(&mut self) -> Option<Reaction> {
        let cyclic = &self.configuration.cyclic;
        self.faults
            .beat_differs(self.cyclic.differs() && self.modes.active().is_cyclic() && self.power);
        if !core::mem::take(&mut self.cyclic.has_lost) {
            return None;
        }
        self.cyclic.lost = self.cyclic.lost.saturating_add(1);
        let is_fault = cyclic.lost.is_fault() && self.machine.state() == State::OperationEnabled;
        is_fault.then(|| self.faults.set_points_lost())
    }

    /// The fault that pulses are that came too late, if 20A2h makes them one: the motor has stopped between two steps, and may stand
    /// anywhere.
    pub(super) fn pulses_late(&mut self) -> Option<Reaction> {
        let is_late = self.motor.take_late();
        if is_late && self.configuration.late_is_fault {
            self.motor.lose_reference();
            return Some(self.faults.pulses_lost());
        }
        if is_late || self.settled {
            self.faults.pulses_late(is_late);
        }
        None
    }
}

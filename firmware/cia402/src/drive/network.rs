//! What the network may do: remote control, what 6007h makes of its loss, and a restart.

use super::{Drive, Tick};
use crate::actuator::Actuator;
use crate::controlword::Command;
use crate::faults::Reaction;
use crate::objects::Objects;
use crate::option_codes::AbortConnectionOption;
use crate::state_machine::State;

/// What is left of remote control in a tick.
pub(super) struct Control {
    /// The network may command the drive.
    pub(super) is_remote: bool,
    pub(super) command: Option<Command>,
    /// The loss of the network is a fault.
    pub(super) fault: Option<Reaction>,
    /// It was lost in this tick, and the drive stops because of that.
    pub(super) begins_stop: bool,
}

impl Control {
    /// The network commands the drive, as before.
    const fn by_network(command: Option<Command>) -> Self {
        Self {
            is_remote: true,
            command,
            fault: None,
            begins_stop: false,
        }
    }
}

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// What is left of remote control. A reset of the device always stops the motor; otherwise 6007h says what the loss means to a drive
    /// with power.
    pub(super) fn control(&mut self, tick: &Tick<'_>, command: Option<Command>) -> Control {
        if tick.is_calm {
            return Control::by_network(command);
        }
        let (is_remote, command, fault) = self.under_6007h(command);
        let was_remote = core::mem::replace(&mut self.network.is_commanding, is_remote);
        Control {
            is_remote,
            command,
            fault,
            begins_stop: was_remote && !is_remote && !self.network.is_abandoned,
        }
    }

    fn under_6007h(
        &mut self,
        command: Option<Command>,
    ) -> (bool, Option<Command>, Option<Reaction>) {
        let Some(code) = self
            .commands
            .connection_error
            .filter(|_| !self.commands.remote)
        else {
            self.network.is_abandoned = false;
            return (self.commands.remote, command, None);
        };
        match self.configuration.abort_connection {
            AbortConnectionOption::NoAction => (true, command, None),
            AbortConnectionOption::FaultSignal if self.power && !self.network.is_abandoned => {
                self.network.is_abandoned = true;
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

    /// Whether the drive starts anew in this tick: a restart is asked for and has not been done, there is no power, and nothing that still
    /// has to be done. An early tick leaves that to the next one.
    pub(super) fn restarts(&mut self, tick: &Tick<'_>) -> bool {
        let is_idle = !self.power
            && self.motor.standstill()
            && self.machine.state() != State::FaultReactionActive;
        let has_restarted = self.network.has_restarted && self.commands.restart;
        let restarts = self.commands.restart && !has_restarted && is_idle && !tick.is_early;
        self.network.has_restarted = has_restarted || restarts;
        restarts
    }
}

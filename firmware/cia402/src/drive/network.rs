//! What the network may do: remote control, what 6007h makes of its loss, and a restart.

use super::{Drive, Tick};
use crate::actuator::Actuator;
use crate::controlword::Command;
use crate::faults::Reaction;
use crate::objects::Objects;
use crate::option_codes::AbortConnectionOption;
use crate::state_machine::State;

/// What the network may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Network {
    /// It may not command the drive.
    Lost,
    /// It may command the drive, or 6007h = 0 lets the drive go on without it.
    Commanding,
    /// It is lost, and 6007h = 1 has made a fault of that.
    Abandoned,
}

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
        if self.is_unchanged(tick.is_asked) {
            return Control::by_network(command);
        }
        let error = self
            .commands
            .connection_error
            .filter(|_| !self.commands.remote);
        let (is_remote, command, fault) = self.apply_abort_connection(error, command);
        let is_abandoned = self.network == Network::Abandoned && error.is_some();
        let network = if fault.is_some() || is_abandoned {
            Network::Abandoned
        } else if is_remote {
            Network::Commanding
        } else {
            Network::Lost
        };
        let before = core::mem::replace(&mut self.network, network);
        Control {
            is_remote,
            command,
            fault,
            begins_stop: before == Network::Commanding && network == Network::Lost,
        }
    }

    /// Whether the network may command the drive, the command, and the fault that the loss of it is.
    fn apply_abort_connection(
        &mut self,
        error: Option<u16>,
        command: Option<Command>,
    ) -> (bool, Option<Command>, Option<Reaction>) {
        let Some(code) = error else {
            return (self.commands.remote, command, None);
        };
        match self.configuration.abort_connection {
            AbortConnectionOption::NoAction => (true, command, None),
            AbortConnectionOption::FaultSignal
                if self.power.is_on() && self.network != Network::Abandoned =>
            {
                self.faults.lose_connection(code);
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
    pub(super) fn take_restart(&mut self, tick: &Tick<'_>) -> bool {
        let is_idle = !self.power.is_on()
            && self.motor.standstill()
            && self.machine.state() != State::FaultReactionActive;
        let has_restarted = self.has_restarted && self.commands.restart;
        let restarts = self.commands.restart && !has_restarted && is_idle && !tick.is_early;
        self.has_restarted = has_restarted || restarts;
        restarts
    }
}

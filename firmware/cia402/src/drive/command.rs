//! Which command a tick obeys: what the master wrote, and what it wrote too fast to be seen; and the faults that the drive finds itself.

use super::Drive;
use crate::actuator::{Actuator, ActuatorErrors};
use crate::controlword::{Command, FAULT_RESET};
use crate::faults::Reaction;
use crate::objects::Objects;
use crate::state_machine::{Progress, State};

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// The command of this tick: the one in the controlword. Without one (bit 7 is set) it is the earlier command to leave operation
    /// enabled, as long as that waits for the motor to stand.
    pub(super) fn command(&mut self) -> Option<Command> {
        let given = self.given_command();
        if let Some(command) = given {
            self.machine.order(command);
        }
        given.or(self.machine.pending())
    }

    /// The command that the master has given. A command to stop that was overwritten since the last tick goes first; then "shutdown", if a
    /// fast master has overwritten it; then the command in the controlword, or the last one before a controlword with bit 7.
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
        let resets = is_faulty
            && (self.machine.progress() == Progress::Reset || commands.rising & FAULT_RESET != 0);
        self.shutdown_first = hurried && (commands.stop.is_some() || resets);
        if commands.stop.is_some() {
            commands.stop
        } else if hurried && self.machine.state() == State::SwitchOnDisabled {
            Some(Command::Shutdown)
        } else {
            standing
        }
    }

    /// Whether the master resets the fault: in this tick, or earlier, when the reaction was over and lasted only to be shown
    /// (`is_over`, and not yet `has_shown`). A reset does not count for a fault that came after it.
    pub(super) fn take_fault_reset(
        &mut self,
        is_over: bool,
        has_shown: bool,
        is_new: bool,
    ) -> bool {
        let edge = self.commands.remote && self.commands.rising & FAULT_RESET != 0;
        let is_only_shown = is_over && !has_shown;
        edge | self.machine.take_fault_reset(edge, is_only_shown, is_new)
    }

    /// The fault of too many missing set-points in a cyclic mode, if 2051h:2 asks for one. The mode has stopped the motor already.
    pub(super) fn check_set_points(&mut self) -> Option<Reaction> {
        let cyclic = &self.configuration.cyclic;
        self.faults.warn_of_sync_period(
            self.cyclic.differs() && self.modes.active().is_cyclic() && self.power.is_on(),
        );
        if !core::mem::take(&mut self.cyclic.set_points_lost) {
            return None;
        }
        self.cyclic.lost = self.cyclic.lost.saturating_add(1);
        let is_fault = cyclic.lost.is_fault() && self.machine.state() == State::OperationEnabled;
        is_fault.then(|| self.faults.raise_lost_set_points())
    }

    /// The fault of pulses that came too late, if 20A2h asks for one: the motor may have lost steps. A planner or an axis that has failed
    /// is always a fault.
    pub(super) fn check_pulses(&mut self) -> Option<Reaction> {
        let ActuatorErrors { is_late, is_broken } = self.motor.take_errors();
        if is_broken || is_late && self.configuration.late_is_fault {
            self.motor.lose_reference();
            return Some(self.faults.raise_lost_pulses());
        }
        if is_late || self.motor.standstill() {
            self.faults.warn_of_late_pulses(is_late);
        }
        None
    }
}

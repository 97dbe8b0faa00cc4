//! Stops that the mode of operation does not make: by option codes, for the brake, at limits.

use canopen::{Duration, Instant};

use super::{Drive, Tick};
use crate::actuator::Actuator;
use crate::controlword::Command;
use crate::inputs::ActiveLimits;
use crate::mode::Mode;
use crate::objects::Objects;
use crate::option_codes::{Stop, StopRamp};
use crate::state_machine::State;
use crate::statusword;

/// The power of the motor, and how long a stop has taken that the drive makes on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Power {
    Off,
    On,
    /// On, and since then the drive stops on its own: the network may not command it, or there is a fault.
    Stopping {
        since: Instant,
    },
}

impl Power {
    /// Whether there is current in the motor.
    pub(super) const fn is_on(self) -> bool {
        !matches!(self, Self::Off)
    }
}

/// So long does a state wait for a transmit PDO.
const LONGEST_SHOWN: Duration = Duration::from_ticks(50_000);

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// Whether the state is about to be left with the power going off, once the motor stands.
    pub(super) fn is_leaving(&self, remote: bool, command: Option<Command>) -> bool {
        match self.machine.state() {
            State::OperationEnabled => {
                let keeps = D::DRIVE_HABITS.power_when_switched_on;
                let is_kept = keeps && command == Some(Command::SwitchOn);
                !is_kept && matches!(self.leaving(command), Some(Stop::Ramp(_)))
            }
            State::SwitchedOn => {
                D::DRIVE_HABITS.power_when_switched_on && command == Some(Command::Shutdown)
            }
            State::QuickStopActive => !remote || !self.machine.quick_stop().stays(),
            State::FaultReactionActive => true,
            _ => false,
        }
    }

    /// Before the power goes off, the brake closes on a motor that stands. True as well where the power stays on, or is off.
    pub(super) fn is_held_by_brake(
        &mut self,
        now: Instant,
        remote: bool,
        command: Option<Command>,
    ) -> bool {
        if !self.power.is_on() || !self.is_leaving(remote, command) {
            return true;
        }
        if self.motor.standstill() {
            self.brakes.wanted.set(false, now);
        }
        self.brakes.wanted.is_closed(self.configuration.brake, now)
    }

    /// Bounds a stop that the drive makes on its own, whatever its ramp: after 20A1h the brake closes, and then the power goes off.
    pub(super) fn end_own_stop(&mut self, now: Instant, remote: bool) {
        let is_own = !remote || self.machine.state() == State::FaultReactionActive;
        if is_own && self.power == Power::On {
            self.power = Power::Stopping { since: now };
        }
        if self.is_overdue(now) {
            self.brakes.wanted.set(false, now);
            if self.brakes.wanted.is_closed(self.configuration.brake, now) {
                self.power_off();
            }
        }
    }

    /// Whether the motor turns longer than it may.
    pub(super) fn is_overdue(&self, now: Instant) -> bool {
        let longest = u64::from(self.configuration.longest_stop) * 1_000;
        matches!(self.power, Power::Stopping { since } if now.ticks().saturating_sub(since.ticks()) >= longest)
    }

    /// Whether the state may end by itself: a transmit PDO has shown it, or its longest time is over.
    pub(super) fn has_shown(&self, tick: &Tick<'_>) -> bool {
        !self.machine.state().is_transient()
            || tick.is_seen
            || tick
                .now
                .checked_duration_since(self.machine.entered())
                .is_some_and(|span| span >= LONGEST_SHOWN)
    }

    /// How operation ends with a command that leaves it by 605Bh or 605Ch; `None` for any other.
    pub(super) fn leaving(&self, command: Option<Command>) -> Option<Stop> {
        match command {
            Some(Command::Shutdown) => Some(self.configuration.shutdown),
            Some(Command::SwitchOn) => Some(self.configuration.disable_operation),
            _ => None,
        }
    }

    /// Whether the state itself stops the motor.
    pub(super) const fn is_stopped_by_state(&self) -> bool {
        matches!(
            self.machine.state(),
            State::QuickStopActive | State::FaultReactionActive
        )
    }

    pub(super) fn stop(&mut self, stop: Stop) {
        match stop {
            Stop::PowerOff => self.power_off(),
            Stop::Ramp(ramp) if !self.motor.standstill() => {
                // A fault in a quick stop, say, must not make that gentler.
                let is_smooth = self.configuration.profile.is_smooth(ramp);
                self.motor
                    .stop_no_gentler(self.deceleration(ramp), is_smooth);
            }
            Stop::Ramp(_) => {}
        }
    }

    pub(super) fn deceleration(&self, ramp: StopRamp) -> u32 {
        self.modes
            .deceleration(ramp, &self.commands, &self.configuration)
    }

    pub(super) fn power_off(&mut self) {
        if self.power.is_on() {
            self.power = Power::Off;
            self.motor.cut_off();
        }
    }

    /// The limit switches, always but while homing looks for one: a motion into one is stopped on the quick stop ramp, and none
    /// begins. Returns bit 11 of the statusword.
    pub(super) fn enforce_limit_switches(&mut self) -> u16 {
        let is_homing = self.machine.state() == State::OperationEnabled && self.modes.is_homing();
        let active = if is_homing {
            ActiveLimits::default()
        } else {
            self.switches.active_limits()
        };
        if self.motor.take_limits(active) {
            let deceleration = self.deceleration(StopRamp::QuickStop);
            self.motor.stop_at_limit(deceleration);
            self.modes.on_limit(&self.motor);
        }
        if active == ActiveLimits::default() {
            0
        } else {
            statusword::INTERNAL_LIMIT
        }
    }

    /// A stop that would end beyond a software limit goes on with the quick stop ramp, if that is harder; homing, that gives the limits
    /// their places, goes beyond them. Returns bit 11 of the statusword.
    pub(super) fn enforce_software_limits(&mut self) -> u16 {
        if !self.motor.is_stopping() || self.modes.active() == Mode::Homing {
            return 0;
        }
        let deceleration = self.deceleration(StopRamp::QuickStop);
        let travel = self.limits.travel().increments;
        if self.motor.keep_stop_within(travel, deceleration) {
            0
        } else {
            statusword::INTERNAL_LIMIT
        }
    }
}

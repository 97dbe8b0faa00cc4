//! The plant: a stepper motor on its driver, with limit and home switches, on virtual time.
//!
//! It takes the same pulse records as the step timer of a board and plays them tick by tick: each pulse moves the motor by
//! one step. What it counts is what really left, so it is the judge of every move.

mod pulses;
mod switches;

pub use pulses::PulsePlayer;
pub use switches::{SwitchStates, Switches};

use canopen::Instant;

/// The step clock: 84 MHz, that of the STM32F405's timer 2.
pub const STEP_CLOCK_HZ: u32 = 84_000_000;

/// The motor and what is around it.
#[derive(Clone, Debug)]
pub struct Plant {
    pulses: PulsePlayer,
    now: Instant,
    energised: bool,
    /// Where the motor stood at power-on, as the switches measure it.
    origin: i64,
    /// The supply of the power stage is there.
    pub supply: bool,
    /// A fault the power stage reports, as a CiA 402 error code (2310h: over-current ...).
    pub fault: Option<u16>,
    /// Where the switches are mounted, measured from where the motor stood at its first power-on.
    pub switches: Switches,
}

impl Plant {
    /// A motor at rest at position 0 with its supply on and no switches mounted.
    pub fn new(now: Instant) -> Self {
        Self {
            pulses: PulsePlayer::default(),
            now,
            energised: false,
            origin: 0,
            supply: true,
            fault: None,
            switches: Switches::default(),
        }
    }

    /// The power is back: no fault, no current, nothing to play, and the position counts from 0. The motor and its switches
    /// are where they were.
    pub fn power_on(&mut self, now: Instant) {
        self.origin += self.position();
        self.pulses = PulsePlayer::default();
        self.now = now;
        self.energised = false;
        self.fault = None;
    }

    /// Lets the motor run until `now`.
    pub fn advance(&mut self, now: Instant) {
        let Some(span) = now.checked_duration_since(self.now) else {
            return;
        };
        self.pulses
            .play(span.ticks() * u64::from(STEP_CLOCK_HZ / 1_000_000));
        self.now = now;
    }

    /// Current in the motor or not.
    pub fn energise(&mut self, on: bool) {
        self.energised = on;
    }

    /// Whether there is current in the motor.
    pub fn is_energised(&self) -> bool {
        self.energised
    }

    /// The position in steps: every pulse that left, by its direction.
    pub fn position(&self) -> i64 {
        self.pulses.position()
    }

    /// The motor is somewhere else all of a sudden: turned by hand, or stuck while pulses were sent. In steps.
    pub fn displace(&mut self, steps: i64) {
        self.pulses.displace(steps);
    }

    /// What the switches say where the motor is.
    pub fn switch_states(&self) -> SwitchStates {
        self.switches.at(self.origin + self.position())
    }

    /// The pulse records on their way to the motor.
    pub fn pulses(&self) -> &PulsePlayer {
        &self.pulses
    }

    /// The pulse records on their way to the motor, to add to them or to drop them.
    pub fn pulses_mut(&mut self) -> &mut PulsePlayer {
        &mut self.pulses
    }
}

#[cfg(test)]
mod tests;

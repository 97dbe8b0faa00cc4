//! The current that the motor driver is to put into the motor: objects 2070h.
//!
//! A stepper needs its full current to move, more to accelerate, and much less to hold. While the velocity demand changes the motor gets the
//! boost current (2070h:3; 0: there is none, the run current counts); at constant velocity the run current (2070h:1); and when it
//! has stood for the hold delay (2070h:4) the hold current (2070h:2). Without power there is none.

use crate::configuration::MotorCurrents;

/// A ramp counts as one for so many microseconds after the velocity demand, a whole number of steps/s, has changed: a gentle one
/// does not change it in every tick.
pub const RAMP: u32 = 20_000;

/// What the motor does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Motion {
    /// There is power.
    pub(crate) power: bool,
    /// The motor stands, and no pulse is pending.
    pub(crate) standstill: bool,
    /// The velocity demand in steps/s.
    pub(crate) velocity: i32,
}

/// The choice between them.
#[derive(Debug)]
pub(crate) struct MotorCurrent {
    velocity: i32,
    /// Microseconds since the velocity demand changed.
    since_change: u32,
    /// Microseconds since the motor moved, or since the power came.
    since_motion: u32,
}

impl MotorCurrent {
    pub(crate) const fn new() -> Self {
        Self {
            velocity: 0,
            since_change: u32::MAX,
            since_motion: 0,
        }
    }

    /// The current in milliamperes for what the motor does in this tick, `elapsed` microseconds after the last one.
    pub(crate) fn choose(&mut self, motion: Motion, elapsed: u32, currents: &MotorCurrents) -> u16 {
        if !motion.power {
            *self = Self::new();
            return 0;
        }
        self.since_change = self.since_change.saturating_add(elapsed);
        if motion.velocity != self.velocity {
            self.velocity = motion.velocity;
            self.since_change = 0;
        }
        if !motion.standstill {
            self.since_motion = 0;
            let is_ramp = self.since_change < RAMP && currents.boost > 0;
            return if is_ramp {
                currents.boost
            } else {
                currents.run
            };
        }
        let delay = u32::from(currents.hold_delay) * 1000;
        if self.since_motion >= delay {
            return currents.hold;
        }
        self.since_motion = self.since_motion.saturating_add(elapsed);
        currents.run
    }
}

#[cfg(test)]
mod tests;

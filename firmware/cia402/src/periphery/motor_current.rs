//! The current that the motor driver is to put into the motor: objects 2070h.
//!
//! A stepper needs its full current to move, more to accelerate, and much less to hold. While the velocity demand changes the motor gets the
//! boost current (2070h:3; 0: there is none, the run current counts); at constant velocity the run current (2070h:1); and when it
//! has stood for the hold delay (2070h:4) the hold current (2070h:2). Without power there is none.

use crate::objects::Objects;

/// The currents, and when the motor counts as holding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotorCurrents {
    /// 2070h:1 in milliamperes.
    pub run: u16,
    /// 2070h:2 in milliamperes.
    pub hold: u16,
    /// 2070h:3 in milliamperes; 0: as `run`.
    pub boost: u16,
    /// 2070h:4 in milliseconds.
    pub hold_delay: u16,
}

impl MotorCurrents {
    /// What holds before anything is set up: no current.
    pub const NONE: Self = Self {
        run: 0,
        hold: 0,
        boost: 0,
        hold_delay: 0,
    };

    /// What the objects say.
    pub(crate) fn of<D: Objects>(dictionary: &D) -> Self {
        Self {
            run: dictionary.run_current(),
            hold: dictionary.hold_current(),
            boost: dictionary.boost_current(),
            hold_delay: dictionary.hold_delay(),
        }
    }
}

/// A ramp counts as one for so many microseconds after the velocity demand, a whole number of steps/s, has changed: a gentle one
/// does not change it in every tick.
pub const RAMP: u32 = 20_000;

/// What the motor does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Motion {
    /// There is power.
    pub(crate) power: bool,
    /// The motor stands, and nothing is on its way to it.
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
        let delay = u32::from(currents.hold_delay).wrapping_mul(1000);
        if self.since_motion >= delay {
            return currents.hold;
        }
        self.since_motion = self.since_motion.saturating_add(elapsed);
        currents.run
    }
}

#[cfg(test)]
mod tests;

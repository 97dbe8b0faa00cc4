//! What the loops of a servo are built for: the motor, and the stage that drives it.

use servo::feedback::absolute::ENTRIES;
use servo::{Angle, Motor};

/// The power stage, and what it measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageData {
    /// A period of the modulation, in s.
    pub period: f32,
    /// Periods of the modulation in one of the velocity and position loops.
    pub control: u8,
    /// The bus as it is to be, in V.
    pub voltage: f32,
    /// The dead time, as a share of the period.
    pub dead_time: f32,
    /// The ripple of the current, in A.
    pub ripple: f32,
    /// The greatest share of the period that is switched.
    pub reach: f32,
    /// Amperes of a count of the converter; below 0 where a current into the motor makes less.
    pub current: f32,
    /// The count without a current, and how far from it a sensor may be.
    pub middle: (u16, u16),
    /// Volts of a count of the bus.
    pub bus: f32,
    /// What it bears for ever, in A, and how long it bears the peak of the motor, in s.
    pub bears: (f32, f32),
}

/// What tells where the magnet is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feedback {
    /// An incremental encoder alone: the magnet is looked for as the power comes first.
    #[default]
    Incremental,
    /// Hall sensors beside it, for [`Current::hall`](super::Current::hall): nothing is looked for.
    Hall,
    /// The word of an absolute encoder in place of it, for [`Current::word`](super::Current::word): nothing is looked for, and positions begin at the angle within
    /// the turn.
    Absolute {
        /// Of a word, 12 to 20.
        bits: u8,
        /// See [`Absolute::with_table`](servo::feedback::Absolute::with_table).
        table: &'static [i32; ENTRIES],
        /// The electrical angle where the word is 0.
        offset: Angle,
    },
}

/// A motor on a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoData {
    /// The motor, until a master says more (20C2h).
    pub motor: Motor,
    /// The torque of its dry friction, in N·m.
    pub friction: f32,
    /// Of the velocity loop, in rad/s.
    pub bandwidth: f32,
    /// The greatest speed, in 1/min.
    pub speed: u32,
    /// What tells where the magnet is.
    pub feedback: Feedback,
    /// Counts of its encoder in a turn, where positions are finer or coarser than they are: those are the counts of the motor. 0 is as many.
    pub encoder: u32,
    /// What drives it.
    pub stage: StageData,
}

impl ServoData {
    /// The greatest speed, in rad/s.
    pub fn max_speed(&self) -> f32 {
        self.speed as f32 * (core::f32::consts::TAU / 60.0)
    }

    /// A period of the loops above the current, in s.
    pub fn control_period(&self) -> f32 {
        self.stage.period * f32::from(self.stage.control)
    }

    /// Those of a turn, as the timer counts them, with what is set (0 if nothing is). The word of an absolute encoder comes in counts of the motor.
    pub fn encoder_counts(&self, set: u32) -> u32 {
        match (self.feedback, set, self.encoder) {
            (Feedback::Absolute { .. }, ..) | (_, 0, 0) => self.motor.counts,
            (_, 0, own) => own,
            (_, set, _) => set,
        }
    }

    /// The trip of a phase, in A.
    pub fn trip(&self) -> f32 {
        2.0 * self.motor.peak_current
    }

    /// The least and the greatest voltage of the bus, in V.
    pub fn bounds(&self) -> (f32, f32) {
        (0.6 * self.stage.voltage, 1.25 * self.stage.voltage)
    }
}

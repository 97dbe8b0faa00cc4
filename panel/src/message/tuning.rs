//! What a drive has measured of its motor, and how its loops answer (docs/servo.md).

use serde::{Deserialize, Serialize};

/// What shall be measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct TuningWish {
    /// The motor.
    #[serde(default)]
    pub motor: bool,
    /// What the speed makes of a torque, over the frequency.
    #[serde(default)]
    pub response: bool,
    /// A hundredth of a turn at once.
    #[serde(default)]
    pub step: bool,
    /// In per cent of the rated current; as it is if nothing is said.
    #[serde(default)]
    pub current: Option<u16>,
    /// Of the velocity loop, in 1/s; as it is if nothing is said.
    #[serde(default)]
    pub bandwidth: Option<u16>,
}

/// How far it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TuningProgress {
    /// What is under way.
    pub words: &'static str,
    /// Which part of so many that is.
    pub part: u32,
    /// How many there are.
    pub parts: u32,
}

/// What is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tuned {
    /// Of which node.
    pub node: u8,
    /// What the drive takes for a measurement without a wish, in thousandths of the rated current.
    pub current: u32,
    /// The bandwidth that it thinks of without one, in 1/s; 0 is its own.
    pub bandwidth: u32,
    /// What can be written, beside what is set.
    pub parameters: Vec<TunedParameter>,
    /// What the encoder is to the motor, if that was measured.
    pub encoder: Option<String>,
    /// Whether what was measured is what is set.
    pub is_written: bool,
    /// The frequency response; empty before it was measured.
    pub response: Response,
    /// The step; empty before.
    pub step: Step,
}

/// A value of the motor or a gain.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TunedParameter {
    /// What it is called.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where it is written.
    pub object: String,
    /// What was measured, or is proposed.
    pub found: Option<String>,
    /// What is set; `None` is what the drive is built with.
    pub set: Option<String>,
}

/// What the speed makes of a torque.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Response {
    /// In Hz.
    pub frequency: Vec<f64>,
    /// In dB of rad/s for 1 N·m.
    pub decibels: Vec<f64>,
    /// In degrees.
    pub phase: Vec<f64>,
}

/// A move at once.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Step {
    /// In ms.
    pub time: Vec<f64>,
    /// The position that was wanted, in increments from where it began.
    pub wanted: Vec<i32>,
    /// The position that was there.
    pub was: Vec<i32>,
}

//! What a drive has recorded, and what its PDOs bring live.

use master::scope::Report;
use serde::{Deserialize, Serialize};

/// What shall be recorded.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Wish {
    /// Objects, by number or name; up to eight.
    pub channels: Vec<String>,
    /// As on the command line: `now`, `fault`, `606C>500`, `6041#10`.
    pub trigger: String,
    /// A sample every so many control ticks.
    pub divider: Option<u16>,
    /// Samples in all; as many as there is room for without it.
    pub samples: Option<u16>,
    /// How many per cent of them are older than the trigger.
    pub before: Option<u8>,
}

/// What the recorder is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Recorder {
    /// It waits for its trigger.
    Armed,
    /// The trigger has come.
    Triggered,
}

/// A recording, and how many there have been.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recorded {
    /// The first one is 1.
    pub number: u64,
    /// What it holds.
    pub report: Report,
}

/// An object that can be a channel of the recorder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recordable {
    /// `6064h:00`.
    pub object: String,
    /// What it is called.
    pub name: String,
    /// Whether most people want it.
    pub is_usual: bool,
}

/// A value that a transmit PDO brings.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LiveChannel {
    /// `6064h:00`.
    pub object: String,
    /// What it is called.
    pub name: String,
    /// Which transmit PDO brings it.
    pub pdo: u16,
}

/// Values of a channel since the last message.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LiveValues {
    /// Which one, in the order of the channels.
    pub channel: usize,
    /// When each came, in seconds.
    pub at: Vec<f64>,
    /// The values.
    pub values: Vec<i64>,
}

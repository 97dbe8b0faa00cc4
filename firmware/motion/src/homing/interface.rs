//! What homing is told and what it answers.

use super::method::Switch;
use crate::Direction;

/// How to go about it. The defaults are what most masters expect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Settings {
    /// Methods 3 to 6 and 19 to 22: a limit switch in the way turns the search round, once. Else it is an error.
    pub turns_at_limit: bool,
    /// A start on the switch goes straight into the last move where that leads off it. Else it is left and entered again first,
    /// so that the last move is short.
    pub is_direct: bool,
    /// Drives back to the home position. Else the motor stays where it stopped behind it.
    pub returns: bool,
    /// Without an index pulse, the last move is at search speed as well.
    pub last_move_is_fast: bool,
    /// Methods -1 to -4 with the directions exchanged: the negative hard stop for -1 and -3, the positive one for -2 and -4.
    pub other_block_signs: bool,
    /// At a hard stop home is where the motor has backed off to. Else it is where it was blocked.
    pub home_is_backed_off: bool,
    /// The longest distance in steps, all moves together; 0 is no bound.
    pub longest_distance: u32,
    /// The longest time in milliseconds; 0 is no bound. It stands still during a halt.
    pub longest_time: u32,
    /// How far to go for an index pulse, in steps; 0 is no bound.
    pub longest_distance_to_index: u32,
    /// How long the motor must be blocked to count as at a hard stop, in milliseconds.
    pub block_time: u16,
    /// How far to back off from a hard stop, in steps, at most 2³¹−1.
    pub back_off: u32,
}

/// What the drive can see at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub struct Fitted {
    pub negative_limit: bool,
    pub positive_limit: bool,
    pub home: bool,
    pub index: bool,
    /// The drive can tell that the motor is blocked: it has hard stop methods.
    pub block: bool,
}

/// A switch in one tick. One that is not fitted is never active.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SwitchState {
    /// The switch is active, bounces and glitches filtered out.
    pub active: bool,
    /// In the tick in which `active` changes: the position captured at the edge, if it was. Else the position in that tick counts.
    pub edge: Option<i32>,
    /// The filter has seen an edge and is not sure of it yet: where it was. It becomes that of a change, or it is dropped. A
    /// filter must decide within a bounded time, whatever the contact does: the motor waits for it at rest.
    pub pending: Option<i32>,
}

/// What homing is told in one tick. Positions are in steps, modulo 2³².
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inputs {
    /// Microseconds since the tick before.
    pub elapsed: u32,
    /// Where the motor is.
    pub position: i32,
    /// The motor stands, and has nothing left to do.
    pub standstill: bool,
    /// The motor is to pause.
    pub halt: bool,
    /// The negative limit switch.
    pub negative_limit: SwitchState,
    /// The positive limit switch.
    pub positive_limit: SwitchState,
    /// The home switch.
    pub home: SwitchState,
    /// The position captured at an index pulse since the tick before.
    pub index: Option<i32>,
    /// The motor does not follow.
    pub blocked: bool,
}

impl Inputs {
    /// One of the switches.
    pub(super) const fn switch(&self, switch: Switch) -> SwitchState {
        match switch {
            Switch::NegativeLimit => self.negative_limit,
            Switch::PositiveLimit => self.positive_limit,
            Switch::Home => self.home,
        }
    }
}

/// Which of the two homing speeds (6099h).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speed {
    /// 6099h:1, speed during search for switch.
    Search,
    /// 6099h:2, speed during search for zero.
    Zero,
}

/// What the motor is to do from now on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// What it does.
    GoOn,
    /// Run, until told otherwise.
    Run(Direction, Speed),
    /// Slow down to rest.
    Stop,
    /// Go to this position at the slow homing speed, and stay there.
    Go(i32),
    /// Home is found, and is this position: go back to it, as by [`Order::Go`]. Who sets the home
    /// position at once still tells homing positions in the count in which it was found.
    Return(i32),
    /// Drop the pulses that have not left: the motor is blocked.
    CutOff,
}

/// How homing goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It is under way.
    UnderWay(Order),
    /// The motor stands; this is the home position.
    Attained(i32),
    /// It has failed. The motor is to stop; the tick is not called again.
    Failed(Failure),
}

/// Why homing has failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// A switch, the index pulse or the sense for a hard stop is not there.
    NotFitted,
    /// A limit switch was met that is not looked for.
    Limit,
    /// Both limit switches are active.
    BothLimits,
    /// The longest distance or the longest time is over.
    TooLong,
    /// No index pulse within the longest distance to it.
    NoIndex,
    /// The switch is too narrow for the search speed: its edge was run over again and again, or it was passed to the limit switch and
    /// touched for less than its filter wants.
    TooNarrow,
}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotFitted => "a switch that the method needs is not fitted",
            Self::Limit => "a limit switch was met",
            Self::BothLimits => "both limit switches are active",
            Self::TooLong => "homing took too long",
            Self::NoIndex => "no index pulse",
            Self::TooNarrow => "the switch is too narrow for the search speed",
        })
    }
}

impl core::error::Error for Failure {}

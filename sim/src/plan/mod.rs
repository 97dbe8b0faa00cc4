//! `sim plan`: a move as the drive would make it, without a drive.
//!
//! The planner plans it, an axis turns the plan into pulse-train records, and these are played tick by tick. What is told about
//! the pulses is measured on them: how many there were, where they lead, and how far each is from where and when the plan has it.
//! Units are steps and seconds.

mod curve;
mod decimal;
mod pulses;
mod report;
mod request;

use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;

use motion::{SignedSpeed, Speed};

use master::system_error::plain;
use report::Report;
use request::Move;

/// What to plan, in steps and seconds.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// How far to go, in steps; negative is backwards
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true)]
    pub distance: i64,
    /// Profile velocity in steps/s, an amount. A decimal such as 0.000278 counts to 2⁻³² steps/s, here, in --initial-velocity and in --end-velocity
    #[arg(long, value_name = "STEPS/S", value_parser = decimal::speed, allow_negative_numbers = true)]
    pub velocity: Speed,
    /// Profile acceleration in steps/s², while the speed grows; a whole number
    #[arg(long, value_name = "STEPS/S²", allow_negative_numbers = true)]
    pub acceleration: u32,
    /// Profile deceleration in steps/s², while the speed falls; without it as the acceleration
    #[arg(long, value_name = "STEPS/S²", allow_negative_numbers = true)]
    pub deceleration: Option<u32>,
    /// Jerk in steps/s³, for the profiles `jerk` and `average`
    #[arg(long, value_name = "STEPS/S³", allow_negative_numbers = true)]
    pub jerk: Option<u32>,
    /// How the velocity changes; with a jerk `jerk`, without one `trapezoid`
    #[arg(
        long,
        value_enum,
        value_name = "PROFILE",
        allow_negative_numbers = true
    )]
    pub profile: Option<Profile>,
    /// The velocity at the start in steps/s; negative is backwards
    #[arg(
        long,
        value_name = "STEPS/S",
        value_parser = decimal::velocity,
        default_value = "0",
        allow_negative_numbers = true
    )]
    pub initial_velocity: SignedSpeed,
    /// The velocity at the target in steps/s, an amount, which is kept beyond
    #[arg(
        long,
        value_name = "STEPS/S",
        value_parser = decimal::speed,
        default_value = "0",
        allow_negative_numbers = true
    )]
    pub end_velocity: Speed,
    /// The clock of the step timer in Hz
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 168_000_000,
        allow_negative_numbers = true
    )]
    pub clock: u32,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Write every pulse: the tick at which it begins, and the position it leads to, both from the start
    #[arg(long, value_name = "FILE")]
    pub pulses: Option<PathBuf>,
    /// Write a picture of position, velocity and acceleration as SVG
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
}

/// The motion profile types of 6086h.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Profile {
    /// Constant acceleration
    Trapezoid,
    /// sin² ramps, as long as the linear ones
    Sin2,
    /// Limited jerk: the fastest
    Jerk,
    /// Moving average of the trapezoid, at limited jerk
    Average,
}

/// Why there is nothing to show.
#[derive(Debug)]
pub enum Problem {
    /// The move cannot be, and why.
    Impossible(String),
    /// A file cannot be written, and why.
    File(PathBuf, String),
    /// Nobody takes the output.
    Output(io::Error),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Impossible(why) => f.write_str(why),
            Self::File(path, why) => write!(f, "cannot write {}: {why}", path.display()),
            Self::Output(error) => write!(f, "cannot print: {error}"),
        }
    }
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Plans, plays, measures and tells.
///
/// # Errors
/// [`Problem`].
pub fn show(arguments: &Arguments, output: &mut dyn Write) -> Result<(), Problem> {
    let planned = Move::of(arguments).map_err(Problem::Impossible)?;
    let unwritable = |path: &PathBuf| {
        let path = path.clone();
        move |error: io::Error| Problem::File(path, plain(error))
    };
    let played = match &arguments.pulses {
        Some(path) => pulses::write(&planned, path).map_err(unwritable(path))?,
        None => pulses::play(&planned, None)?,
    };
    if let Some(path) = &arguments.plot {
        report::plot(&planned, path).map_err(|why| Problem::File(path.clone(), why))?;
    }
    let report = Report::of(&planned, &played);
    if arguments.json {
        let text = serde_json::to_string_pretty(&report).map_err(io::Error::from)?;
        writeln!(output, "{text}")?;
    } else {
        write!(output, "{report}")?;
    }
    Ok(())
}

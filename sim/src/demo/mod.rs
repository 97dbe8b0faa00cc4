//! The demonstration: an unconfigured drive and a master in one process, on a bus of real frames, as fast as possible.
//!
//! [`play`] is the story itself on virtual time, without any output; [`show`] tells it: frames with their meaning, the move
//! as a plot, what to try next.

mod plot;
mod product;
mod script;

use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;

use canopen::BitRate;

use crate::drive::MotionSample;
use crate::plant::ServoAxisData;
use crate::products::Product;
use master::Failure;
use master::bus::simulated::{Bus, Logged};
use master::command_line::cannot_write;
use master::data_sheet::DataSheet;
use master::trace::{Group, Interpreter, candump, condense};

pub use product::{play as play_product, play_axis};
pub use script::play;

/// The node-ID that the master gives to the drive.
pub const NODE_ID: u8 = 4;

/// The target of the move, in steps.
pub const TARGET: i32 = 20_000;

/// What to demonstrate.
#[derive(Clone, Debug, PartialEq)]
pub struct Demo {
    /// The node-ID that the master gives to the drive, 1 to 127.
    pub node_id: u8,
    /// Another maker's drive.
    pub product: Option<Product>,
    /// The drive on this axis, whose motor is moved by its current.
    pub axis: Option<ServoAxisData>,
    /// Where to write the picture of the move, as SVG.
    pub plot: Option<PathBuf>,
}

/// A part of the story: what it is about, and its frames.
#[derive(Clone, Debug)]
pub struct Chapter {
    /// What happens.
    pub title: String,
    /// The frames.
    pub frames: Vec<Logged>,
}

/// What happened.
#[derive(Clone, Debug)]
pub struct Story {
    /// The chapters, in order.
    pub chapters: Vec<Chapter>,
    /// The motor at each control tick.
    pub motion: Vec<MotionSample>,
    /// 6064h where the drive should have gone, by its target: read by SDO after each move.
    pub arrivals: Vec<(i32, i32)>,
    /// 6077h by 6071h, read by SDO.
    pub torques: Vec<(i16, i16)>,
}

/// Why a demonstration failed.
#[derive(Debug)]
pub enum Problem {
    /// A step of the script.
    Step(Failure),
    /// The drive is not where it was sent: target and 6064h.
    Missed(i32, i32),
    /// The output could not be written.
    Output(io::Error),
    /// The picture could not be written.
    Picture(PathBuf, String),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(failure) => write!(f, "the demonstration stopped: {failure}"),
            Self::Missed(target, position) => {
                write!(f, "the drive was sent to {target} and is at {position}")
            }
            Self::Output(error) => f.write_str(&cannot_write(error)),
            Self::Picture(path, reason) => {
                write!(f, "cannot write the picture {}: {reason}", path.display())
            }
        }
    }
}

impl std::error::Error for Problem {}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        Self::Step(failure)
    }
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Plays the demonstration and tells it on `output`.
///
/// # Errors
/// If a step failed, the drive missed a target, or something could not be written.
pub fn show(demo: &Demo, output: &mut dyn Write) -> Result<(), Problem> {
    show_on(Bus::new(BitRate::Kbit1000), demo, output)
}

/// [`show`] on a bus of any kind: on one that interferes, the story ends early.
pub(crate) fn show_on(bus: Bus, demo: &Demo, output: &mut dyn Write) -> Result<(), Problem> {
    let (story, mut interpreter) = match (demo.product, &demo.axis) {
        (None, Some(axis)) => {
            writeln!(
                output,
                "A drive on the axis {} and a CANopen master, on one CAN bus at 1 Mbit/s. {LINES}",
                axis.name
            )?;
            let story = play_axis(axis, demo.node_id)?;
            (story, Interpreter::new(DataSheet::servo()))
        }
        (Some(product), _) => {
            let title = product.title();
            writeln!(
                output,
                "A {title} and a CANopen master, on one CAN bus at 1 Mbit/s. {LINES}"
            )?;
            let story = product::play(product, demo.axis, demo.node_id)?;
            (story, Interpreter::new(product.data_sheet()))
        }
        (None, None) => {
            let story = script::play_on(bus, demo.node_id)?;
            writeln!(output, "{INTRODUCTION} {LINES}")?;
            (story, script::interpreter(demo.node_id))
        }
    };
    for chapter in &story.chapters {
        writeln!(output, "\n{}\n", chapter.title)?;
        tell_frames(&chapter.frames, &mut interpreter, output)?;
    }
    writeln!(output)?;
    plot::in_terminal(&story.motion, output)?;
    for (target, position) in &story.arrivals {
        if target != position {
            return Err(Problem::Missed(*target, *position));
        }
        writeln!(
            output,
            "Sent to {target:>6}, 6064h is {position:>6}: exact."
        )?;
    }
    for (target, torque) in &story.torques {
        writeln!(
            output,
            "Target torque {target:>4}, 6077h is {torque:>4} thousandths of the rated torque."
        )?;
    }
    if let Some(path) = &demo.plot {
        plot::as_svg(&story.motion, path)
            .map_err(|reason| Problem::Picture(path.clone(), reason))?;
        writeln!(output, "Picture: {}", path.display())?;
    }
    match (demo.product, &demo.axis) {
        (None, Some(axis)) => writeln!(output, "{}", next_on(axis.name))?,
        _ => writeln!(output, "{NEXT}")?,
    }
    output.flush()?;
    Ok(())
}

fn tell_frames(
    frames: &[Logged],
    interpreter: &mut Interpreter,
    output: &mut dyn Write,
) -> io::Result<()> {
    // Every frame is followed, also those that are left out below.
    let meanings: Vec<String> = frames
        .iter()
        .map(|logged| interpreter.meaning(&logged.frame))
        .collect();
    let numbered: Vec<(usize, Logged)> = frames.iter().copied().enumerate().collect();
    for group in condense(&numbered, |(_, logged)| script::stream(&logged.frame)) {
        match group {
            Group::One((number, logged)) => {
                let line = candump::line(logged.at, &logged.frame);
                writeln!(output, "  {line:<58}  {}", meanings[number])?;
            }
            Group::LeftOut(count) => writeln!(output, "  ... {count} more of them ...")?,
        }
    }
    Ok(())
}

const INTRODUCTION: &str = "\
A drive that has no node-ID yet and a CANopen master, on one CAN bus at 1 Mbit/s.";

const LINES: &str = "\
Each line is a frame:
(time in s)  interface  identifier  [length]  bytes in hexadecimal  meaning";

const NEXT: &str = "
What to try next:
  cargo run -- demo --plot move.svg                              the move as a picture
  cargo run -- serve --slcan 127.0.0.1:2402 --node-id 4          this drive for your own master (python-canopen: see README.md)
  cargo xtask qemu --slcan 127.0.0.1:2402                        the firmware image itself, in an emulator
  cargo xtask test                                               every test";

/// The same for a drive on a ready axis.
fn next_on(axis: &str) -> String {
    format!(
        "
What to try next:
  cargo run -- demo --panel --axis {axis}          you move it, in the browser
  cargo run -- serve --axis {axis} --node-id 4 --slcan 127.0.0.1:2402
                                                        this drive for your own master (python-canopen: see README.md)
  cargo axis402 tune 4 --slcan 127.0.0.1:2402           that one measures its motor
  docs/servo.md                                         all that it can do"
    )
}

#[cfg(test)]
mod tests;

//! `axis402 tune`: a drive with a servo measures its motor; gains for its loops; its frequency response through the scope.
//!
//! The motor moves. What is found is written only where that is asked for ([`crate::tuning`]).

mod report;

use std::path::PathBuf;

use canopen::Duration;

use super::{Console, Node, Problem};
use crate::tuning::{self, Host, Stage, Wanted};
use crate::{Line, Master};

use report::{draw, draw_step, tell};

/// What is wanted.
#[derive(Clone, Debug, Default)]
pub struct Tuning {
    /// The current of the measurement, in thousandths of the rated one; what the drive has without it.
    pub current: Option<u16>,
    /// The bandwidth of the velocity loop in 1/s; what the drive thinks fit without it.
    pub bandwidth: Option<u16>,
    /// No frequency response.
    pub is_short: bool,
    /// Write what was found.
    pub writes: bool,
    /// Draw the frequency response there.
    pub plot: Option<PathBuf>,
    /// Move by a hundredth of a turn at once, and draw that there.
    pub step: Option<PathBuf>,
    /// One object for programs.
    pub json: bool,
}

/// Measures, and tells what was found.
///
/// # Errors
/// As [`tuning::tune`]; [`Problem::Usage`] if a file cannot be written.
pub fn tune<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    wanted: &Tuning,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let mut host = AtConsole {
        master,
        console,
        node: node.id,
        is_told: false,
    };
    let found = tuning::tune(
        &mut host,
        node,
        &Wanted {
            motor: true,
            current: wanted.current,
            bandwidth: wanted.bandwidth,
            writes: wanted.writes,
            response: !wanted.is_short,
            step: wanted.step.is_some(),
        },
    );
    if matches!(found, Err(Problem::Stopped)) {
        let text = format!("node {}: stopped; its motor has no power", node.id);
        console.remark(&text);
    }
    let found = found?;
    if let Some(path) = &wanted.plot {
        draw(&found.response, path)?;
    }
    if let Some(path) = &wanted.step {
        draw_step(&found.step, path)?;
    }
    if wanted.json {
        let text =
            serde_json::to_string(&found).map_err(|error| Problem::Failed(error.to_string()))?;
        return console.say(&text);
    }
    tell(node.id, &found, console)
}

/// A person at a terminal waits.
struct AtConsole<'a, 'b, L> {
    master: &'a mut Master<L>,
    console: &'a mut Console<'b>,
    node: u8,
    is_told: bool,
}

impl<L: Line> Host for AtConsole<'_, '_, L> {
    type Line = L;

    fn master(&mut self) -> &mut Master<L> {
        self.master
    }

    fn pause(&mut self, span: Duration) -> Result<(), Problem> {
        Ok(self.master.wait(span)?)
    }

    fn at(&mut self, stage: Stage) {
        if !std::mem::replace(&mut self.is_told, true) {
            self.console.remark(&format!(
                "node {}: the motor is measured, and moves by itself",
                self.node
            ));
        }
        self.console
            .progress(stage.words(), stage as u32, Stage::Step as u32);
    }
}

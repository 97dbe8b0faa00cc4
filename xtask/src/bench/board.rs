//! Waits, masked interrupts, stacks and shares of the image of the board under load, on the model of its chip (`tests/machine/measure.py`).

use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use super::image;
use super::table::Table;
use crate::firmware::Image;
use crate::words::tell;
use crate::{place, setup};

/// A wait that moved by no more clocks is the same: what the core does is exact to a slice of instructions.
const SLACK: u64 = 200;

/// Builds the image of the board and runs it under load.
pub fn measure() -> Result<Table> {
    let python = setup::python_environment()?;
    setup::rust_target()?;
    let mut command = Command::new(python);
    command
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(place::root());
    command.arg("tests/machine/measure.py");
    command.arg("--image").arg(Image::Board.build()?);
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .context("starting Python")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut tables = Vec::new();
    for line in text.lines() {
        if !image::take(line, &mut tables) {
            tell!("{line}");
        }
    }
    ensure!(output.status.success(), "the board failed under its load");
    let table = tables.pop().context("no table of the board")?;
    Ok(Table {
        slack: SLACK,
        ..table
    })
}

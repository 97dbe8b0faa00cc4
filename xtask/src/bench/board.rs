//! Waits, masked interrupts, stacks and shares of the images of the boards under load, on the model of their chip (`tests/machine/measure.py`,
//! `measure_servo.py`).

use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use super::image;
use super::table::Table;
use crate::firmware::Image;
use crate::words::tell;
use crate::{place, setup};

/// A wait that moved by no more clocks is the same: what the core does is exact to a slice of instructions.
const SLACK: u64 = 200;

/// A period of the currents that moved by no more clocks is the same.
const PERIOD_SLACK: u64 = 10;

/// Builds the images of the boards and runs them under load.
pub fn measure() -> Result<[Table; 2]> {
    let python = setup::python_environment()?;
    setup::rust_target()?;
    let run = |program: &str, images: &[(&str, Image)], slack| {
        let mut command = Command::new(&python);
        command.arg(program);
        for (option, image) in images {
            command.arg(option).arg(image.build()?);
        }
        table(command, program, slack)
    };
    let servos = [
        ("--odrive36", Image::Odrive),
        ("--stepper405", Image::Stepper),
    ];
    Ok([
        run(
            "tests/machine/measure.py",
            &[("--image", Image::Board)],
            SLACK,
        )?,
        run("tests/machine/measure_servo.py", &servos, PERIOD_SLACK)?,
    ])
}

/// The table that a program prints.
fn table(mut command: Command, program: &str, slack: u64) -> Result<Table> {
    let output = command
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(place::root())
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
    ensure!(
        output.status.success(),
        "{program}: a board failed under its load"
    );
    let table = tables.pop().context("no table of the board")?;
    Ok(Table { slack, ..table })
}

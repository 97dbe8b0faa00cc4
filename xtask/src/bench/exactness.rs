//! How exact the pulses are: measured on a model of the timers, on virtual time, so the same on every PC.

use std::process::Stdio;

use anyhow::{Context, Result, ensure};

use super::image;
use super::table::Table;
use crate::place;
use crate::words::tell;

/// Builds `machine/examples/exactness.rs` for speed and runs it. Each row gets one figure.
pub fn measure() -> Result<Vec<Table>> {
    let mut command = place::cargo();
    command.args(["run", "--quiet", "--release", "--package", "machine"]);
    command.args(["--example", "exactness"]);
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .context("starting cargo")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut tables = Vec::new();
    for line in text.lines() {
        if !image::take(line, &mut tables) {
            tell!("{line}");
        }
    }
    ensure!(output.status.success(), "the pulses are not exact");
    Ok(tables)
}

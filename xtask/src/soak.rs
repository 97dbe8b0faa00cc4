//! `cargo xtask soak`: very many pulses through planner, train and the modelled timers of the board, built for speed.
//!
//! It is the test `machine/tests/soak.rs` at any length: as it stands half a minute of counting behind some minutes of building, and a night
//! with larger numbers. Every pulse on the modelled pins is counted; one too many or too few fails.

use std::process::ExitCode;

use anyhow::Result;

use crate::place;
use crate::process;

/// How much.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Pulses of long moves
    #[arg(long, default_value_t = 1_000_000_000)]
    pulses: u64,
    /// Random sequences of commands
    #[arg(long, default_value_t = 1_000_000)]
    sequences: u64,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let mut command = place::cargo();
    command
        .args([
            "test",
            "--release",
            "--package",
            "machine",
            "--test",
            "soak",
        ])
        .args(["--", "--nocapture"])
        .env("AXIS402_SOAK_PULSES", arguments.pulses.to_string())
        .env("AXIS402_SOAK_SEQUENCES", arguments.sequences.to_string());
    Ok(if process::run(&mut command)?.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

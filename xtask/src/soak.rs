//! `cargo xtask soak`: very many pulses through planner, train and the modelled timers of the board, and very many SYNCs, built for speed.
//!
//! It is the tests `machine/tests/soak.rs` and `sim/tests/sync_soak.rs` at any length: as it stands some minutes of counting behind some
//! minutes of building, and a night with larger numbers. Every pulse on the modelled pins is counted; one too many or too few fails. Each
//! SYNC takes four counters to the drive and brings them back; one that is missing, mixed with another SYNC's, or later than the others fails. A servo of the plant loses its
//! supply, encoder, a phase or its freedom at random moments of a motion, and must end its current and its motion with the fault for it; a stepper has loads at random beyond what it can hold, and must lose no step. Random motors are measured, each within the bounds of docs/servo.md, the inertia within 30 %. Then faults
//! come at random moments on the model of the board's chip (`tests/machine/random_faults.py`), and each must have its reaction and no pulse be wild. The panel tells eight channels at 1 kHz for an hour of
//! virtual time, with one window that never reads. Then each fuzz target runs for a while (`cargo xtask fuzz`), and goes on
//! where earlier runs have been.

use std::process::{Command, ExitCode};

use anyhow::Result;

use crate::firmware::Image;
use crate::{fuzz, place, process, setup};

/// How much.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Pulses of long moves
    #[arg(long, default_value_t = 1_000_000_000)]
    pulses: u64,
    /// Random sequences of commands
    #[arg(long, default_value_t = 1_000_000)]
    sequences: u64,
    /// SYNCs at 1 kHz, each with four receive and four transmit PDOs
    #[arg(long, default_value_t = 600_000)]
    syncs: u32,
    /// Moments at which something of a servo breaks
    #[arg(long, default_value_t = 10_000)]
    breaks: u32,
    /// Random loads of a stepper by its load angle
    #[arg(long, default_value_t = 100_000)]
    profiles: u32,
    /// Random motors that are measured
    #[arg(long, default_value_t = 2_000)]
    motors: u32,
    /// Faults at random on the model of the board
    #[arg(long, default_value_t = 1_000)]
    faults: u32,
    /// Seconds of eight channels at 1 kHz in the panel
    #[arg(long, default_value_t = 3_600, value_name = "SECONDS")]
    live: u32,
    /// Seconds of each fuzz target
    #[arg(long, default_value_t = 600, value_name = "SECONDS")]
    fuzz: u32,
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
            "--package",
            "sim",
            "--test",
            "soak",
            "--test",
            "sync_soak",
        ])
        .args(["--", "--nocapture"])
        .env("AXIS402_SOAK_SYNCS", arguments.syncs.to_string())
        .env("AXIS402_SOAK_PULSES", arguments.pulses.to_string())
        .env("AXIS402_SOAK_SEQUENCES", arguments.sequences.to_string());
    if !process::run(&mut command)?.success() {
        return Ok(ExitCode::FAILURE);
    }
    let mut breaks = place::cargo();
    breaks
        .args(["test", "--release", "--package", "sim", "--lib", "servo"])
        .args(["--", "--nocapture"])
        .env("AXIS402_SOAK_BREAKS", arguments.breaks.to_string())
        .env("AXIS402_SOAK_PROFILES", arguments.profiles.to_string());
    if !process::run(&mut breaks)?.success() {
        return Ok(ExitCode::FAILURE);
    }
    let mut motors = place::cargo();
    motors
        .args(["test", "--release", "--package", "servo"])
        .args(["--test", "tuning"])
        .env("AXIS402_SOAK_MOTORS", arguments.motors.to_string());
    if !process::run(&mut motors)?.success() {
        return Ok(ExitCode::FAILURE);
    }
    let python = setup::python_environment()?;
    setup::rust_target()?;
    let mut faults = Command::new(python);
    faults
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(place::root());
    faults.args(["tests/machine/random_faults.py", "--runs"]);
    faults.arg(arguments.faults.to_string());
    faults.arg("--image").arg(Image::Board.build()?);
    if !process::run(&mut faults)?.success() {
        return Ok(ExitCode::FAILURE);
    }
    let mut live = place::cargo();
    live.args([
        "test",
        "--release",
        "--package",
        "panel",
        "--lib",
        "eight_channels",
    ])
    .env("AXIS402_SOAK_LIVE", arguments.live.to_string());
    if !process::run(&mut live)?.success() {
        return Ok(ExitCode::FAILURE);
    }
    fuzz::run(&fuzz::Arguments {
        targets: Vec::new(),
        seconds: arguments.fuzz,
    })
}

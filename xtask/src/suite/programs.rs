//! The programs on the PC that the Python tests start.
//!
//! They are built as `cargo test --workspace` builds them, so that both share every library: of a few packages alone cargo would build most libraries once more, with
//! fewer features. They are copied, as cargo may build them anew while a test runs one of them.

use std::process::Command;

use anyhow::{Context, Result};

use crate::{firmware, place};

/// The virtual drive, the one in virtual time, a master's command line, the panel, the generator's, this program, a device that is
/// no drive, the plant of the servo, the plant of a step motor on its wires, and the measurement of a motor in virtual time.
const PROGRAMS: [&str; 10] = [
    "sim",
    "stepped_drive",
    "axis402",
    "axis402-panel",
    "od-gen",
    "xtask",
    "examples/io_device",
    "examples/plant_trace",
    "examples/stepped_axis",
    "examples/stepped_tune",
];

/// The command that builds them.
pub fn build_command() -> Command {
    let mut command = place::cargo();
    command.args(["build", "--workspace", "--exclude", "app"]);
    // With the examples come the features of what only tests depend on.
    command.args(["--bins", "--examples"]);
    command
}

/// Copies what cargo built to where [`place::kept`] says.
///
/// # Errors
/// When one of them is missing.
pub fn keep() -> Result<()> {
    for name in PROGRAMS {
        let (built, kept) = (place::built(name), place::kept(name));
        firmware::replace(&built, &kept)
            .with_context(|| format!("copying {} to {}", built.display(), kept.display()))?;
    }
    Ok(())
}

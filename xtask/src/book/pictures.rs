//! The pictures of the pages are made by commands. Drawings come out the same every time and are compared; the pictures of the panel are
//! compared in the browser, by its tests.

use std::fs;
use std::path::Path;

use anyhow::{Result, anyhow, bail};

use super::run_well;
use crate::{place, process, suite};

/// Each drawing in docs/, and what `sim` is told to make it.
const DRAWINGS: [(&str, &[&str]); 2] = [
    ("demo.svg", &["demo", "--plot"]),
    (
        "plan.svg",
        &[
            "plan",
            "--distance",
            "100000",
            "--velocity",
            "100000",
            "--acceleration",
            "500000",
            "--plot",
        ],
    ),
];

/// Makes all of them anew, in docs/.
///
/// # Errors
/// When a command fails.
pub fn make() -> Result<()> {
    let docs = place::root().join("docs");
    for (name, words) in DRAWINGS {
        draw(words, &docs.join(name))?;
    }
    run_well(&mut suite::panel_pictures(&docs)?)
}

/// Whether the drawings in docs/ are those that the commands make.
///
/// # Errors
/// When one is not, or a command fails.
pub fn check() -> Result<()> {
    let folder = tempfile::tempdir()?;
    for (name, words) in DRAWINGS {
        let made = folder.path().join(name);
        draw(words, &made)?;
        if fs::read(&made)? != fs::read(place::root().join("docs").join(name))? {
            bail!("docs/{name} is not what `sim` draws: `cargo xtask book --pictures`");
        }
    }
    Ok(())
}

fn draw(words: &[&str], file: &Path) -> Result<()> {
    let mut command = place::cargo();
    command.args(["run", "--quiet", "--package", "sim", "--bin", "sim", "--"]);
    command.args(words).arg(file);
    let said = process::ask(&mut command);
    said.map(drop)
        .ok_or_else(|| anyhow!("`{}` failed", process::line(&command)))
}

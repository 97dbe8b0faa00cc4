//! The Python environment of the tests: CANopen masters and checkers, each version pinned.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result};

use super::debian;
use crate::refusal::refuse;
use crate::words::tell;
use crate::{place, process};

/// The virtual environment in the build folder with everything of `tests/python/requirements.txt`; gives its `python`.
///
/// # Errors
/// When Python or its `venv` module is missing and may not be installed, or when `pip` fails.
pub fn environment() -> Result<PathBuf> {
    let folder = place::target().join("venv");
    let python = folder.join("bin").join("python");
    let wanted_file = place::root().join("tests/python/requirements.txt");
    let wanted = fs::read_to_string(&wanted_file)
        .with_context(|| format!("reading {}", wanted_file.display()))?;
    // A copy of the list is left in the environment when it is complete.
    let installed_file = folder.join("requirements.txt");
    if python.exists()
        && fs::read_to_string(&installed_file).is_ok_and(|installed| installed == wanted)
    {
        return Ok(python);
    }

    debian::program("python3", &["python3", "python3-venv"])?;
    if !has_venv() {
        debian::install("python3 -m venv", &["python3-venv"])?;
    }
    tell!("xtask: making the Python environment {}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    }
    let mut make = Command::new("python3");
    make.args(["-m", "venv"])
        .arg(&folder)
        .stdout(std::io::stderr());
    if !process::run(&mut make)?.success() {
        return Err(refuse(format!("`{}` failed", process::line(&make))));
    }
    let mut pip = Command::new(&python);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--requirement",
    ])
    .arg(&wanted_file);
    pip.stdout(std::io::stderr());
    if !process::run(&mut pip)?.success() {
        return Err(refuse(format!(
            "the Python packages could not be installed: `{}`",
            process::line(&pip)
        )));
    }
    fs::write(&installed_file, wanted)
        .with_context(|| format!("writing {}", installed_file.display()))?;
    Ok(python)
}

/// Debian's `python3` has the module `venv` but not `ensurepip`, without which it does not work.
fn has_venv() -> bool {
    let mut import = Command::new("python3");
    import
        .args(["-c", "import venv, ensurepip"])
        .stderr(Stdio::null());
    process::ask(&mut import).is_some()
}

//! The packages of the tests on Node.js: node-canopen, pinned by the lock file of npm.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use super::debian;
use crate::refusal::refuse;
use crate::words::tell;
use crate::{place, process};

/// What is copied beside the packages: npm installs where the list lies, and the source tree stays as it is.
const LISTS: [&str; 2] = ["package.json", "package-lock.json"];

/// The folder `node_modules` in the build folder with everything of `tests/node/package-lock.json`.
///
/// # Errors
/// When Node.js is missing and may not be installed, or when npm fails.
pub fn packages() -> Result<PathBuf> {
    let folder = place::target().join("node");
    let modules = folder.join("node_modules");
    let source = place::root().join("tests/node");
    let read =
        |file: PathBuf| fs::read(&file).with_context(|| format!("reading {}", file.display()));
    let wanted = read(source.join(LISTS[1]))?;
    // npm leaves its own list in the folder; this copy is there when it is complete.
    let installed = modules.join("complete");
    if fs::read(&installed).is_ok_and(|installed| installed == wanted) {
        return Ok(modules);
    }
    debian::program("node", &["nodejs"])?;
    debian::program("npm", &["npm"])?;
    tell!(
        "xtask: installing the packages for Node.js in {}",
        folder.display()
    );
    fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
    for list in LISTS {
        fs::copy(source.join(list), folder.join(list))
            .with_context(|| format!("copying {list}"))?;
    }
    let mut npm = Command::new("npm");
    npm.args(["ci", "--no-audit", "--no-fund", "--loglevel=error"])
        .current_dir(&folder)
        .stdout(std::io::stderr());
    if !process::run(&mut npm)?.success() {
        return Err(refuse(format!(
            "the packages for Node.js could not be installed: `{}`",
            process::line(&npm)
        )));
    }
    fs::write(&installed, wanted).with_context(|| format!("writing {}", installed.display()))?;
    Ok(modules)
}

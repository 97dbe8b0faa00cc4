//! mdBook, which makes the book: one version for everybody, in the build folder.

use std::path::PathBuf;

use anyhow::Result;

use crate::refusal::refuse;
use crate::words::tell;
use crate::{place, process};

const VERSION: &str = "0.5.4";

/// The program, installed by cargo if it is not there.
///
/// # Errors
/// When cargo cannot install it.
pub fn program() -> Result<PathBuf> {
    // A folder for each version, so that another one is not taken for it.
    let folder = place::target()
        .join("tools")
        .join(format!("mdbook-{VERSION}"));
    let program = folder.join("bin").join("mdbook");
    if program.is_file() {
        return Ok(program);
    }
    tell!(
        "xtask: installing mdbook {VERSION} into {}",
        folder.display()
    );
    let mut install = place::cargo();
    // It makes one small book: the time to build it counts for more than its own.
    install.args([
        "install",
        "--quiet",
        "--locked",
        "--debug",
        "--version",
        VERSION,
    ]);
    install.args(["--no-default-features", "--features", "search", "--root"]);
    install.arg(&folder).arg("mdbook");
    install.stdout(std::io::stderr());
    if process::run(&mut install)?.success() {
        return Ok(program);
    }
    Err(refuse(format!(
        "mdbook is missing, and `{}` failed",
        process::line(&install)
    )))
}

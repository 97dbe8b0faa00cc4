//! Programs that come as Debian packages: installed when this user may, otherwise named.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::Result;

use crate::refusal::refuse;
use crate::words::tell;
use crate::{place, process};

/// Finds the program, and installs the packages that have it if it is missing.
///
/// # Errors
/// When it is missing and this user may not install packages, or when that fails.
pub fn program(name: &str, packages: &[&str]) -> Result<PathBuf> {
    if let Some(path) = place::program(name) {
        return Ok(path);
    }
    install(name, packages)?;
    place::program(name).ok_or_else(|| {
        refuse(format!(
            "`{name}` is still missing after installing {}",
            packages.join(" ")
        ))
    })
}

/// Installs packages because `what` is missing.
///
/// # Errors
/// When this user may not install packages, or when that fails.
pub fn install(what: &str, packages: &[&str]) -> Result<()> {
    let names = packages.join(" ");
    if place::program("apt-get").is_none() {
        return Err(refuse(format!(
            "`{what}` is missing: install it (on Debian: `apt-get install {names}`), then try again"
        )));
    }
    let Some(rights) = Rights::find() else {
        return Err(refuse(format!(
            "`{what}` is missing: type `sudo apt-get update && sudo apt-get install {names}`, then try again"
        )));
    };
    let install = |packages: &[&str]| {
        let mut command = rights.apt_get();
        command
            .args(["install", "--yes", "--no-install-recommends"])
            .args(packages);
        process::run(&mut command)
    };
    tell!("xtask: `{what}` is missing, installing {names}");
    // A machine that never fetched its package lists, or fetched them long ago, needs them first.
    if install(packages)?.success() {
        return Ok(());
    }
    process::run(rights.apt_get().arg("update"))?;
    if install(packages)?.success() {
        return Ok(());
    }
    Err(refuse(format!(
        "`{what}` is missing, and `apt-get install {names}` failed"
    )))
}

/// How this user may install packages.
enum Rights {
    Root,
    Sudo,
}

impl Rights {
    fn find() -> Option<Self> {
        if process::ask(Command::new("id").arg("-u")).as_deref() == Some("0") {
            return Some(Self::Root);
        }
        let mut sudo = Command::new("sudo");
        sudo.args(["-n", "true"]).stderr(Stdio::null());
        process::ask(&mut sudo).map(|_| Self::Sudo)
    }

    /// `apt-get` that asks nothing, with its words on the standard error: the standard output belongs to the tests.
    fn apt_get(&self) -> Command {
        let mut command = match self {
            Self::Root => Command::new("apt-get"),
            Self::Sudo => {
                let mut sudo = Command::new("sudo");
                sudo.args(["-n", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
                sudo
            }
        };
        command
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdin(Stdio::null());
        command.stdout(std::io::stderr());
        command
    }
}

//! The Rust target of the microcontroller.

use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::firmware::TARGET;
use crate::refusal::refuse;
use crate::{place, process};

/// Installs the core library for the target, if it is not there.
///
/// # Errors
/// When it is missing and `rustup` is missing too, or fails.
pub fn add_target() -> Result<()> {
    let mut sysroot = Command::new("rustc");
    sysroot
        .args(["--print", "sysroot"])
        .current_dir(place::root());
    if let Some(folder) = process::ask(&mut sysroot)
        && Path::new(&folder).join("lib/rustlib").join(TARGET).is_dir()
    {
        return Ok(());
    }
    let by_hand = format!(
        "type `rustup target add {TARGET}` in {}",
        place::root().display()
    );
    if place::program("rustup").is_none() {
        return Err(refuse(format!(
            "the Rust target {TARGET} is missing, and so is rustup (https://rustup.rs): {by_hand}"
        )));
    }
    let mut rustup = Command::new("rustup");
    rustup
        .args(["target", "add", TARGET])
        .current_dir(place::root());
    if process::run(&mut rustup)?.success() {
        Ok(())
    } else {
        Err(refuse(format!(
            "rustup could not install the target {TARGET}: {by_hand}"
        )))
    }
}

//! `axis402-panel`: what `axis402 panel` runs.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    panel::run(std::env::args_os())
}

//! `sim`: the virtual drive's command line (see [`sim::cli`]).
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    sim::cli::run(std::env::args_os())
}

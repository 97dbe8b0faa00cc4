//! `axis402`: a CANopen master on the command line (see [`master::axis402`]).
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    master::axis402::run(std::env::args_os())
}

//! The command line. `od-gen --help` lists the commands; each is a file here.
//!
//! Exit codes: 0 for success; 1 when a data sheet is wrong (its findings are on standard error), and for `diff` when the files
//! differ; 2 when the command line is wrong, or when a file cannot be read or written (one line).
#![forbid(unsafe_code)]

mod arguments;
mod bindings;
mod check;
mod convert;
mod dcf;
mod diff;
mod doc;
mod dump;
mod fmt;
mod input;
mod network;
mod output;
mod rules;
mod rust;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};
use od_gen::{files, standard_output};
use output::{one_line, reason, tell};

/// Why a command ends early.
enum Failure {
    /// Everything has been said: exit code 1.
    Findings,
    /// One line about a file or the command line: exit code 2.
    Refused(String),
}

fn main() -> ExitCode {
    files::outlive_limit();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => {
            tell(&one_line(&error));
            return ExitCode::from(2);
        }
        Err(help) => {
            return match standard_output::help(&help) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => {
                    tell(&format!("error: {}", reason(&error)));
                    ExitCode::from(2)
                }
            };
        }
    };
    let done = match arguments.command {
        Command::Bindings(arguments) => bindings::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Dcf(arguments) => dcf::run(&arguments),
        Command::Diff(arguments) => diff::run(&arguments),
        Command::Doc(arguments) => doc::run(&arguments),
        Command::Dump(arguments) => dump::run(&arguments),
        Command::Fmt(arguments) => fmt::run(&arguments),
        Command::Network(arguments) => network::run(&arguments),
        Command::Rules(arguments) => rules::run(&arguments),
        Command::Rust(arguments) => rust::run(&arguments),
    };
    match done {
        Ok(code) => code,
        Err(Failure::Findings) => ExitCode::FAILURE,
        Err(Failure::Refused(line)) => {
            tell(&line);
            ExitCode::from(2)
        }
    }
}

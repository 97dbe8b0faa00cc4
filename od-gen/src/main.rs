//! The command line: `od-gen rust FILE`.
//!
//! Exit codes: 0 for success, 1 when the data sheet is wrong (every finding on a line of its own), 2 when the command line is, or
//! when the file cannot be read (one line).
#![forbid(unsafe_code)]

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use od_gen::{Options, ReadError};

/// Electronic data sheets (CiA 306) in, typed static object dictionaries in Rust out.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Check a data sheet and print its dictionary as a Rust module
    Rust {
        /// The electronic data sheet
        file: PathBuf,
        /// Implement `cia402::Objects` too
        #[arg(long)]
        cia402: bool,
    },
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => return refuse(&one_line(&error)),
        Err(help) => {
            // Nobody left to tell when this fails.
            let _ = help.print();
            return ExitCode::SUCCESS;
        }
    };
    let Command::Rust { file, cia402 } = arguments.command;
    let model = match od_gen::read(&file) {
        Ok(model) => model,
        Err(error @ ReadError::File { .. }) => return refuse(&error.to_string()),
        Err(error @ ReadError::Findings(_)) => {
            tell(&error.to_string());
            return ExitCode::FAILURE;
        }
    };
    match io::stdout().write_all(od_gen::generate(&model, Options { cia402 }).as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader went away, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => refuse(&format!("error: {error}")),
    }
}

/// One line, exit code 2.
fn refuse(message: &str) -> ExitCode {
    tell(message);
    ExitCode::from(2)
}

/// Standard error; its reader may have gone away, as `head` does, and the exit code says enough then.
fn tell(message: &str) {
    let _ = writeln!(io::stderr(), "{message}");
}

/// What is wrong, on one line; the rest of clap's message is advice.
fn one_line(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "error: a command is missing, see --help".into();
    }
    let message = error.to_string();
    let lines = message
        .lines()
        .map(str::trim)
        .take_while(|line| !line.is_empty());
    lines.collect::<Vec<_>>().join(" ")
}

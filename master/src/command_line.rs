//! What the command lines have in common: every mistake in one is one line on standard error and exit code 2.

use std::io::{self, Write};
use std::process::ExitCode;

use canopen::BitRate;
use clap::CommandFactory;
use clap::error::ErrorKind;
use od_gen::standard_output;

use crate::system_error::plain;

/// Exit code for a bad command line, a busy port, a missing interface.
const USAGE: u8 = 2;

/// A bit rate of CANopen in kbit/s.
///
/// # Errors
/// Which ones there are.
pub fn bit_rate(text: &str) -> Result<BitRate, String> {
    let known = || {
        BitRate::ALL
            .map(|rate| rate.kbit_per_second().to_string())
            .join(", ")
    };
    let number = text.parse::<u32>().ok();
    (BitRate::ALL
        .into_iter()
        .find(|rate| Some(rate.kbit_per_second()) == number))
    .ok_or_else(|| format!("not one of {}", known()))
}

/// Help and version go out as they are; a mistake in the command line of `program` as one line.
pub fn refused<P: CommandFactory>(program: &str, error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => match standard_output::help(error) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => fail(program, &cannot_write(&error)),
        },
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            fail(program, &P::command().render_usage().to_string())
        }
        _ => {
            let text = error.to_string();
            let first = text.split("\n\n").next().unwrap_or_default();
            let words: Vec<&str> = first.split_whitespace().collect();
            let line = words.join(" ");
            fail(program, line.strip_prefix("error: ").unwrap_or(&line))
        }
    }
}

/// What went wrong with standard output.
pub fn cannot_write(error: &io::Error) -> String {
    format!("cannot write the output: {}", plain(error))
}

/// A line on standard error, if anybody has it open.
pub fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Tells in one line what is wrong.
pub fn fail(program: &str, problem: &str) -> ExitCode {
    note(&format!("{program}: {problem}"));
    ExitCode::from(USAGE)
}

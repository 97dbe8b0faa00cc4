//! `cargo xtask`: what a person would otherwise type by hand.
//!
//! | command | what it does |
//! |---|---|
//! | `test`  | installs what is missing and runs every test, the firmware in the emulator included |
//! | `board-test` | runs the image of the board on a model of its chip; a part of `test` |
//! | `board` | builds the image of the board, flashes it and shows its logs, also as `cargo board` |
//! | `qemu`  | builds the firmware and runs it in QEMU, its CAN bus served as SLCAN on TCP |
//! | `book`  | makes docs/ into one site with the references of dictionary and crates, and looks up its links |
//! | `size`  | flash and RAM of the firmware by crate, its stack, the length of the sources |
//! | `bench` | instruction counts in the emulator, and how exact the pulses are, compared with the committed tables |
//! | `soak`  | a thousand million step pulses through planner, train and a model of the timers: none too many, none too few |
//! | `fuzz`  | random inputs for whatever reads what others have made, as long as you like |
//!
//! Exit codes: 0 all is well; 1 something was tried and failed (a test, a build, a changed benchmark); 2 it could not
//! be tried (a bad argument, a busy port, a tool that may not be installed), with one line that says why.
#![forbid(unsafe_code)]
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod bench;
mod book;
mod budget;
mod emulator;
mod firmware;
mod fuzz;
mod place;
mod process;
mod product;
mod qemu;
mod refusal;
mod setup;
mod size;
mod soak;
mod socketcan;
mod suite;
mod words;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

use words::tell;

/// Set-up, tests, emulator, sizes and benchmarks of Axis402.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Install what is missing and run every test
    Test(suite::Arguments),
    /// Build the image of the board and run it on a model of its chip; a part of the test run
    BoardTest,
    /// Build the image of the board, flash it over a debug probe and show its logs until stopped
    Board(product::Board),
    /// Build the firmware and run it in QEMU until stopped; `ready` is printed once it can be reached
    Qemu(qemu::Arguments),
    /// Make docs/ into one site, with the references of the dictionary and the crates, and look up its links
    Book(book::Arguments),
    /// Print flash and RAM of the firmware by crate, its stack and the length of the sources
    Size(size::Arguments),
    /// Count instructions in the emulator, measure pulses, and compare them with docs/benchmarks.md
    Bench(bench::Arguments),
    /// Fuzz the node, the SDO server, the LSS slave and the reader of data sheets; what is found is kept in the build folder
    Fuzz(fuzz::Arguments),
    /// Send very many step pulses through planner, train and a model of the timers, and count them
    Soak(soak::Arguments),
    /// The first process inside user-mode Linux: bring up vcan0 and run a command
    #[command(hide = true)]
    SocketcanInit,
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(answer) if !answer.use_stderr() => {
            // Nobody may be reading.
            let _ = answer.print();
            return ExitCode::SUCCESS;
        }
        Err(mistake) => {
            tell!("xtask: {}", one_line(&mistake));
            return ExitCode::from(2);
        }
    };
    let result = match arguments.task {
        Task::Test(arguments) => suite::run(&arguments),
        Task::BoardTest => suite::run(&suite::Arguments::board()),
        Task::Board(arguments) => product::board(&arguments),
        Task::Qemu(arguments) => qemu::run(&arguments),
        Task::Book(arguments) => book::run(&arguments),
        Task::Size(arguments) => size::run(&arguments),
        Task::Bench(arguments) => bench::run(&arguments),
        Task::Fuzz(arguments) => fuzz::run(&arguments),
        Task::Soak(arguments) => soak::run(&arguments),
        Task::SocketcanInit => socketcan::init(),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            tell!("xtask: {}", words::one_line(&error));
            if error.is::<refusal::Refusal>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

/// What is wrong with the arguments: the first paragraph of the message, without the usage and the advice after it.
fn one_line(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return Arguments::command().render_usage().to_string();
    }
    let message = error.to_string();
    let words: Vec<_> = message
        .split("\n\n")
        .take(1)
        .flat_map(str::split_whitespace)
        .collect();
    let line = words.join(" ");
    line.strip_prefix("error: ").unwrap_or(&line).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_bad_argument_is_one_clear_line() {
        let line = |words: &[&str]| one_line(&Arguments::try_parse_from(words).unwrap_err());
        assert_eq!(
            line(&["xtask", "qemu", "--slcan", "localhost:4000", "--fast"]),
            "unexpected argument '--fast' found"
        );
        assert_eq!(
            line(&["xtask", "qemu"]),
            "the following required arguments were not provided: --slcan <ADDRESS:PORT>"
        );
        assert_eq!(line(&["xtask", "sail"]), "unrecognized subcommand 'sail'");
        assert_eq!(line(&["xtask"]), "Usage: cargo xtask <COMMAND>");
    }
}

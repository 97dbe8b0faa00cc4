//! `axis402 panel`: a program of its own (`axis402-panel`), so that this one stays light. It is run as a person would run it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use crate::command_line::fail;
use crate::system_error::plain;

/// The program.
const NAME: &str = "axis402-panel";

/// Runs the panel in the place of this program: the one that lies beside it, or on the path; inside `cargo run` the one of the
/// workspace, built if need be. `program` is the name in front of a message.
pub fn panel(program: &str, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let mut command = match std::env::var_os("CARGO") {
        Some(cargo) => {
            let mut command = Command::new(cargo);
            command.args(["run", "--quiet", "--package", "panel", "--bin", NAME, "--"]);
            command
        }
        None => Command::new(beside().unwrap_or_else(|| NAME.into())),
    };
    let problem = become_program(command.args(arguments));
    match problem {
        Ok(code) => code,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => fail(
            program,
            &format!("{NAME} is not installed: cargo install --path panel"),
        ),
        Err(error) => fail(program, &format!("cannot run {NAME}: {}", plain(error))),
    }
}

/// The program in the folder of this one.
fn beside() -> Option<PathBuf> {
    let own = std::env::current_exe().ok()?;
    let file = own.with_file_name(format!("{NAME}{}", std::env::consts::EXE_SUFFIX));
    file.exists().then_some(file)
}

/// The other program takes over: signals are its own, and so is the exit code.
#[cfg(unix)]
fn become_program(command: &mut Command) -> std::io::Result<ExitCode> {
    use std::os::unix::process::CommandExt;
    Err(command.exec())
}

#[cfg(not(unix))]
fn become_program(command: &mut Command) -> std::io::Result<ExitCode> {
    let status = command.status()?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(ExitCode::from(code.unwrap_or(1)))
}

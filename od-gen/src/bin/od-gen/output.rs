//! Standard output, standard error and files, with readers that may go away.

use std::io::{self, IsTerminal, Write};
use std::path::Path;

use clap::error::ErrorKind;
use od_gen::{Colour, files, standard_output};

use crate::Failure;

/// Writes to a file, or to standard output.
pub(crate) fn write(text: &str, file: Option<&Path>) -> Result<(), Failure> {
    let Some(file) = file else {
        return print(text);
    };
    write_bytes(text.as_bytes(), file)
}

/// Writes to a file.
pub(crate) fn write_bytes(bytes: &[u8], file: &Path) -> Result<(), Failure> {
    files::write(file, bytes)
        .map_err(|error| Failure::Refused(format!("{}: error: {}", file.display(), reason(&error))))
}

/// Writes to standard output.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    if text.is_empty() {
        return Ok(());
    }
    let mut output = standard_output::lock();
    match output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
    {
        Ok(()) => Ok(()),
        // The reader went away, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::Refused(format!("error: {}", reason(&error)))),
    }
}

/// Whether what goes to standard output is coloured.
pub(crate) fn colour() -> Colour {
    colour_on(io::stdout().is_terminal())
}

/// Whether what goes to standard error is coloured.
pub(crate) fn colour_of_errors() -> Colour {
    colour_on(io::stderr().is_terminal())
}

/// Only a terminal shows colours, and its user may not want them (<https://no-color.org>).
fn colour_on(is_terminal: bool) -> Colour {
    let is_unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if is_terminal && !is_unwanted {
        Colour::Always
    } else {
        Colour::Never
    }
}

/// Standard error; its reader may have gone away, as `head` does, and the exit code says enough then.
pub(crate) fn tell(message: &str) {
    let _ = writeln!(io::stderr(), "{message}");
}

/// What the system says, without the number that it gives to it.
pub(crate) fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error ") {
        Some((reason, _)) => reason.into(),
        None => text,
    }
}

/// What is wrong, on one line; the rest of clap's message is advice.
pub(crate) fn one_line(error: &clap::Error) -> String {
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

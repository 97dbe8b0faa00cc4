//! Child processes whose output is shown as it comes.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};

use anyhow::{Context, Result};

use crate::refusal::refuse;
use crate::words::plain;

/// The command as a person would type it, without the folder of the program.
pub fn line(command: &Command) -> String {
    let word = |part: &OsStr| {
        let text = part.to_string_lossy();
        let special = |c: char| c.is_whitespace() || "\"'\\$`*?[]<>|&;(){}!#~".contains(c);
        if text.contains(special) {
            format!("'{text}'")
        } else {
            text.into_owned()
        }
    };
    let program = Path::new(command.get_program());
    let mut words = vec![word(program.file_name().unwrap_or(program.as_os_str()))];
    words.extend(command.get_args().map(word));
    words.join(" ")
}

/// Runs the command with its output on the terminal.
pub fn run(command: &mut Command) -> Result<ExitStatus> {
    command
        .status()
        .map_err(|error| cannot_start(command, &error))
}

/// Runs the command silently, and gives what it wrote to its standard output when it ended well.
pub fn ask(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).output().ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Runs the command; every line of its standard output is given to `take`, which shows it, until it cannot.
pub fn stream(
    command: &mut Command,
    mut take: impl FnMut(&str) -> Result<()>,
) -> Result<ExitStatus> {
    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| cannot_start(command, &error))?;
    let mut said = Ok(());
    if let Some(output) = child.stdout.take() {
        each_line(output, |text| {
            if said.is_ok() {
                said = take(text);
            }
        });
    }
    let status = child
        .wait()
        .with_context(|| format!("waiting for `{}`", line(command)))?;
    said.map(|()| status)
}

/// Gives every line that comes from `output` to `take`, until the other end is closed.
pub fn each_line(output: impl Read, mut take: impl FnMut(&str)) {
    let mut reader = BufReader::new(output);
    let mut bytes = Vec::new();
    while matches!(reader.read_until(b'\n', &mut bytes), Ok(count) if count > 0) {
        take(String::from_utf8_lossy(&bytes).trim_end());
        bytes.clear();
    }
}

fn cannot_start(command: &Command, error: &std::io::Error) -> anyhow::Error {
    refuse(format!(
        "cannot start `{}`: {}",
        command.get_program().to_string_lossy(),
        plain(error)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_can_read_the_line_of_a_command() {
        let mut command = Command::new("/bin/echo");
        command.args(["--config", r#"a=["b"]"#, "two words", "plain,word=1"]);
        assert_eq!(
            line(&command),
            r#"echo --config 'a=["b"]' 'two words' plain,word=1"#
        );
    }
}

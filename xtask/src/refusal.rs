//! What cannot be tried at all: a bad argument, a busy port, a tool that may not be installed. Exit code 2.

use std::fmt;

/// The text says in one line what is wrong and, where there is something to do, exactly what to type.
#[derive(Debug)]
pub struct Refusal(String);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

/// A [`Refusal`] as the error of a command.
pub fn refuse(text: impl Into<String>) -> anyhow::Error {
    Refusal(text.into()).into()
}

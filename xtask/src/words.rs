//! What the commands say: the one place that writes to the standard output and to the standard error.
//!
//! Whoever reads may leave early (`cargo xtask size | head -3`). What is left to say is then dropped, and the work
//! goes on to its exit code: a test run that nobody watches still tells whether it passed.

use std::fmt;
use std::io::{self, Write};

use anyhow::{Context, Result};

/// Writes a line to the standard output. The result is an error when it cannot be written and somebody reads it.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::words::to_output(format_args!($($words)*))
    };
}

/// Writes a line to the standard error, if anybody has it open.
macro_rules! tell {
    ($($words:tt)*) => {
        $crate::words::to_error(format_args!($($words)*))
    };
}

pub(crate) use {say, tell};

/// What [`say!`] does.
pub fn to_output(words: fmt::Arguments) -> Result<()> {
    write_line(&mut io::stdout().lock(), words).context("cannot write to the standard output")
}

/// What [`tell!`] does.
pub fn to_error(words: fmt::Arguments) {
    // There is no other place to complain at.
    let _ = write_line(&mut io::stderr().lock(), words);
}

fn write_line(to: &mut impl Write, words: fmt::Arguments) -> io::Result<()> {
    match writeln!(to, "{words}") {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// An error of the system as words in a sentence, without Rust's "(os error 98)".
pub fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((plain, _)) => plain.to_lowercase(),
        None => text,
    }
}

/// An error and its causes in one line.
pub fn one_line(error: &anyhow::Error) -> String {
    let words = |cause: &(dyn std::error::Error + 'static)| match cause.downcast_ref() {
        Some(error) => plain(error),
        None => cause.to_string(),
    };
    error.chain().map(words).collect::<Vec<_>>().join(": ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A standard output that cannot be written.
    struct Closed(io::ErrorKind);

    impl Write for Closed {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Err(self.0.into())
        }
    }

    #[test]
    fn a_reader_that_left_is_no_error_and_a_full_disk_is_one() {
        let write = |kind| write_line(&mut Closed(kind), format_args!("words"));
        assert!(write(io::ErrorKind::BrokenPipe).is_ok());
        assert_eq!(
            write(io::ErrorKind::StorageFull).unwrap_err().kind(),
            io::ErrorKind::StorageFull
        );
    }

    #[test]
    fn causes_are_one_line_without_numbers_of_the_system() {
        let missing = io::Error::from_raw_os_error(2);
        let error = anyhow::Error::new(missing).context("reading notes.txt");
        assert_eq!(
            one_line(&error),
            "reading notes.txt: no such file or directory"
        );
    }
}

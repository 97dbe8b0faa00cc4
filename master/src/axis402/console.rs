//! Where a command writes: results to one place, what it is at to another.

use std::io::Write;

use super::Problem;

/// Output and progress of a command. A script reads the one, a person the other.
pub struct Console<'a> {
    output: &'a mut dyn Write,
    progress: &'a mut dyn Write,
    is_terminal: bool,
    /// What stands in the last line of the terminal.
    line: Option<String>,
}

impl<'a> Console<'a> {
    /// Results go to `output`, remarks to `progress`; and progress, if that is a terminal, in one line that changes.
    pub fn new(output: &'a mut dyn Write, progress: &'a mut dyn Write, is_terminal: bool) -> Self {
        Self {
            output,
            progress,
            is_terminal,
            line: None,
        }
    }

    /// A line of the result.
    ///
    /// # Errors
    /// [`Problem::Output`].
    pub fn say(&mut self, line: &str) -> Result<(), Problem> {
        self.end_progress();
        writeln!(self.output, "{line}")?;
        // What is told is to be seen now, whoever reads it.
        self.output.flush()?;
        Ok(())
    }

    /// A remark that is no part of the result.
    pub fn remark(&mut self, line: &str) {
        self.end_progress();
        // Nobody may be reading.
        let _ = writeln!(self.progress, "{line}");
    }

    /// How far a long work is, on a terminal.
    pub fn progress(&mut self, what: &str, done: u32, of: u32) {
        let percent = (u64::from(done) * 100).checked_div(of.into()).unwrap_or(0);
        let line = format!("{what}: {percent} %");
        if self.is_terminal && self.line.as_ref() != Some(&line) {
            let _ = write!(self.progress, "\r\x1B[K{line}").and_then(|()| self.progress.flush());
            self.line = Some(line);
        }
    }

    /// Takes the progress off the terminal.
    fn end_progress(&mut self) {
        if self.line.take().is_some() {
            let _ = write!(self.progress, "\r\x1B[K").and_then(|()| self.progress.flush());
        }
    }
}

impl Drop for Console<'_> {
    fn drop(&mut self) {
        self.end_progress();
    }
}

impl std::fmt::Debug for Console<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Console")
            .field("line", &self.line)
            .finish_non_exhaustive()
    }
}

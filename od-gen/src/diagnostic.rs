//! What is wrong with a data sheet, in the form compilers use.

use std::fmt;

/// One finding: `file:line: error: message`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The file as its reader named it.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: error: {}", self.file, self.line, self.message)
    }
}

impl std::error::Error for Diagnostic {}

/// Collects the findings of one file, so that one run shows them all.
#[derive(Debug)]
pub(crate) struct Findings {
    file: String,
    list: Vec<Diagnostic>,
}

impl Findings {
    pub(crate) fn new(file: &str) -> Self {
        Self {
            file: file.into(),
            list: Vec::new(),
        }
    }

    pub(crate) fn error(&mut self, line: usize, message: impl Into<String>) {
        self.list.push(Diagnostic {
            file: self.file.clone(),
            line,
            message: message.into(),
        });
    }

    /// The value, or a finding in its place.
    pub(crate) fn take<T, E: Into<String>>(
        &mut self,
        line: usize,
        result: Result<T, E>,
    ) -> Option<T> {
        result.map_err(|message| self.error(line, message)).ok()
    }

    /// All findings in the order of the file.
    pub(crate) fn into_sorted(mut self) -> Vec<Diagnostic> {
        self.list.sort_by_key(|finding| finding.line);
        self.list
    }
}

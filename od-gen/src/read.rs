//! A data sheet from a file.

use std::path::Path;
use std::{fmt, fs, io};

use crate::diagnostic::Diagnostic;
use crate::model::Model;
use crate::parse::parse;

/// Why there is no model.
#[derive(Debug)]
pub enum ReadError {
    /// The file cannot be read.
    File {
        /// The file.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The file is wrong.
    Findings(Vec<Diagnostic>),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { file, source } => write!(f, "{file}: error: {source}"),
            Self::Findings(findings) => {
                for (number, finding) in findings.iter().enumerate() {
                    let separator = if number == 0 { "" } else { "\n" };
                    write!(f, "{separator}{finding}")?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::File { source, .. } => Some(source),
            Self::Findings(_) => None,
        }
    }
}

/// Reads and checks a data sheet in UTF-8, with or without byte order mark, with any line ends.
///
/// # Errors
/// The file cannot be read, or everything that is wrong with it.
pub fn read(path: &Path) -> Result<Model, ReadError> {
    let file = path.display().to_string();
    let bytes = fs::read(path).map_err(|source| ReadError::File {
        file: file.clone(),
        source,
    })?;
    let Some(wrong) = wrong_encoding(&file, &bytes) else {
        return parse(&file, &String::from_utf8_lossy(&bytes)).map_err(ReadError::Findings);
    };
    let mut findings = vec![wrong];
    if !is_utf_16(&bytes) {
        // A few letters are lost, every other mistake can still be found.
        findings.extend(
            parse(&file, &String::from_utf8_lossy(&bytes))
                .err()
                .unwrap_or_default(),
        );
        findings.sort_by_key(|finding| finding.line);
    }
    Err(ReadError::Findings(findings))
}

/// What is said about a file that is not in UTF-8.
fn wrong_encoding(file: &str, bytes: &[u8]) -> Option<Diagnostic> {
    let error = std::str::from_utf8(bytes).err()?;
    let before = bytes.iter().take(error.valid_up_to());
    Some(Diagnostic {
        file: file.into(),
        line: before.filter(|byte| **byte == b'\n').count() + 1,
        message: "this is not UTF-8: save the file in that encoding".into(),
    })
}

/// Whether the file begins with the byte order mark of UTF-16, which leaves nothing to read as UTF-8.
fn is_utf_16(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF])
}

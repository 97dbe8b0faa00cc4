//! Data sheets from files.

use std::path::Path;

use od_gen::{Model, ReadError};

use crate::Failure;
use crate::output::{reason, tell};

/// A checked data sheet, or its findings on standard error.
pub(crate) fn model(file: &Path) -> Result<Model, Failure> {
    od_gen::read(file).map_err(|error| match error {
        ReadError::File { file, source } => {
            Failure::Refused(format!("{file}: error: {}", reason(&source)))
        }
        ReadError::Findings(_) => {
            tell(&error.to_string());
            Failure::Findings
        }
    })
}

//! Data sheets from files.

use std::path::Path;

use od_gen::bind::{self, Binding};
use od_gen::{BindingReport, Colour, Model, ReadError};

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

/// The bindings beside a data sheet; what there is to say about them goes to standard error.
pub(crate) fn bindings(file: &Path, model: &Model) -> Result<Vec<Binding>, Failure> {
    let report = BindingReport::beside(file, model).map_err(|error| {
        let file = bind::file_beside(file);
        Failure::Refused(format!("{}: error: {}", file.display(), reason(&error)))
    })?;
    let Some(report) = report else {
        return Ok(Vec::new());
    };
    if !report.findings.is_empty() {
        tell(report.render(Colour::Never).trim_end());
    }
    if report.has_errors() {
        return Err(Failure::Findings);
    }
    Ok(report.bindings)
}

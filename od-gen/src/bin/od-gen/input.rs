//! Data sheets from files.

use std::path::Path;

use od_gen::bind::{self, Binding};
use od_gen::{BindingReport, Model, Report};

use crate::Failure;
use crate::output::{self, reason};

/// A file with its findings.
pub(crate) fn report(file: &Path) -> Result<Report, Failure> {
    Report::read(file).map_err(|error| unreadable(file, &error))
}

/// One line about a file that cannot be read or written.
pub(crate) fn unreadable(file: &Path, error: &std::io::Error) -> Failure {
    Failure::Refused(format!("{}: error: {}", file.display(), reason(error)))
}

/// What a file means that code is to be made of. Its findings go to standard error; without an error among them there is a model.
pub(crate) fn model_for_code(file: &Path) -> Result<Model, Failure> {
    let report = Report::read_for_code(file).map_err(|error| unreadable(file, &error))?;
    if !report.findings.is_empty() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    report.into_result().map_err(|_| Failure::Findings)
}

/// What a file means. Its findings go to standard error; without an error among them there is a model.
pub(crate) fn model(file: &Path) -> Result<Model, Failure> {
    let report = report(file)?;
    if !report.findings.is_empty() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    report.into_result().map_err(|_| Failure::Findings)
}

/// The bindings beside a data sheet with everything that there is to say about them.
pub(crate) fn binding_report(file: &Path, model: &Model) -> Result<Option<BindingReport>, Failure> {
    BindingReport::beside(file, model).map_err(|error| {
        let file = bind::file_beside(file);
        Failure::Refused(format!("{}: error: {}", file.display(), reason(&error)))
    })
}

/// The bindings beside a data sheet; what there is to say about them goes to standard error.
pub(crate) fn bindings(file: &Path, model: &Model) -> Result<Vec<Binding>, Failure> {
    let Some(report) = binding_report(file, model)? else {
        return Ok(Vec::new());
    };
    if !report.findings.is_empty() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    if report.has_errors() {
        return Err(Failure::Findings);
    }
    Ok(report.bindings)
}

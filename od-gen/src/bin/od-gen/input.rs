//! Data sheets from files.

use std::path::Path;

use od_gen::bind::{self, Bindings};
use od_gen::{BindingReport, Model, Report, Severity};

use crate::Failure;
use crate::arguments::Allow;
use crate::output::{self, reason};

/// A file with its findings.
pub(crate) fn report(file: &Path, allow: &Allow) -> Result<Report, Failure> {
    Report::read_allowing(file, &allow.rules).map_err(|error| unreadable(file, &error))
}

/// A file of which something could be read. Where it has errors, one line says so.
pub(crate) fn readable(file: &Path, allow: &Allow) -> Result<Report, Failure> {
    let report = report(file, allow)?;
    if !report.has_model() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
        return Err(Failure::Findings);
    }
    let errors = report.count(Severity::Error);
    if errors > 0 {
        let (file, plural) = (file.display(), if errors == 1 { "" } else { "s" });
        output::tell(&format!(
            "{file}: {errors} error{plural}, which `od-gen check` shows; what could be read is used"
        ));
    }
    Ok(report)
}

/// One line about a file that cannot be read or written.
pub(crate) fn unreadable(file: &Path, error: &std::io::Error) -> Failure {
    Failure::Refused(format!("{}: error: {}", file.display(), reason(error)))
}

/// A file that code is to be made of, and that has no errors. Its findings go to standard error.
pub(crate) fn report_for_code(file: &Path, allow: &Allow) -> Result<Report, Failure> {
    let report =
        Report::read_for_code(file, &allow.rules).map_err(|error| unreadable(file, &error))?;
    if !report.findings.is_empty() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    if report.has_errors() {
        return Err(Failure::Findings);
    }
    Ok(report)
}

/// What a file means. Its findings go to standard error; without an error among them there is a model.
pub(crate) fn model(file: &Path, allow: &Allow) -> Result<Model, Failure> {
    let report = report(file, allow)?;
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
pub(crate) fn bindings(file: &Path, model: &Model) -> Result<Bindings, Failure> {
    let Some(report) = binding_report(file, model)? else {
        return Ok(Bindings::default());
    };
    if !report.findings.is_empty() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    if report.has_errors() {
        return Err(Failure::Findings);
    }
    Ok(report.bindings)
}

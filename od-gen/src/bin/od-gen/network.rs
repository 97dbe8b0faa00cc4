//! `od-gen network`: the configurations of all nodes and of the master.

use std::path::Path;
use std::process::ExitCode;

use od_gen::network::{Made, NetworkReport};
use od_gen::{Report, Severity};

use crate::Failure;
use crate::arguments::Network;
use crate::{input, output};

pub(crate) fn run(arguments: &Network) -> Result<ExitCode, Failure> {
    let file = &arguments.file;
    let report = NetworkReport::read(file).map_err(|error| input::unreadable(file, &error))?;
    if !report.findings.is_empty() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    for sheet in &report.sheets {
        let errors = sheet.count(Severity::Error);
        if errors > 0 {
            let file = &sheet.source.file;
            output::tell(&format!(
                "{file}: {errors} errors: `od-gen check` shows them"
            ));
        }
    }
    if report.has_errors() {
        return Err(Failure::Findings);
    }
    let mut is_wrong = false;
    for made in &report.files {
        is_wrong |= tell_what_is_wrong(made, &report.sheets);
    }
    if is_wrong {
        return Err(Failure::Findings);
    }
    if !arguments.check {
        let folder = arguments.output.as_deref().unwrap_or(Path::new(""));
        for made in &report.files {
            output::write_bytes(&made.bytes, &folder.join(&made.name))?;
        }
    }
    output::print(&report.load)?;
    Ok(ExitCode::SUCCESS)
}

/// What each value is on its own may be wrong for all of them together. What the data sheet has already is not said again.
fn tell_what_is_wrong(made: &Made, sheets: &[Report]) -> bool {
    if !made.name.ends_with(".dcf") {
        return false;
    }
    let sheet = made.sheet.as_deref();
    let sheet = sheets.iter().find(|own| Some(&*own.source.file) == sheet);
    let mut report = Report::of_bytes(&made.name, &made.bytes);
    report.findings.retain(|finding| {
        let is_known = sheet.is_some_and(|sheet| {
            let mut known = sheet.findings.iter();
            known.any(|own| own.says_what(finding))
        });
        finding.severity == Severity::Error && !is_known
    });
    if report.has_errors() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
    }
    report.has_errors()
}

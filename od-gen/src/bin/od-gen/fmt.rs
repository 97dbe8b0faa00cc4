//! `od-gen fmt`: data sheets in their canonical form.

use std::path::Path;
use std::process::ExitCode;

use od_gen::Diagnostic;

use crate::Failure;
use crate::arguments::Fmt;
use crate::{input, output};

pub(crate) fn run(arguments: &Fmt) -> Result<ExitCode, Failure> {
    let mut is_wrong = false;
    for file in &arguments.files {
        let Some((before, after)) = formatted(file)? else {
            is_wrong = true;
            continue;
        };
        if before == after.as_bytes() {
            continue;
        }
        if arguments.check {
            is_wrong = true;
            output::print(&format!("{}\n", file.display()))?;
        } else {
            output::write(&after, Some(file))?;
        }
    }
    Ok(if is_wrong {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// What a file holds, and what it should hold; `None` after a finding that leaves no way to say that.
fn formatted(file: &Path) -> Result<Option<(Vec<u8>, String)>, Failure> {
    let before = std::fs::read(file).map_err(|error| input::unreadable(file, &error))?;
    let report = input::report(file)?;
    if report.source.text().trim_start().starts_with('<') {
        let file = file.display();
        let line =
            format!("{file}: error: this is XML: only EDS and DCF files have a canonical form");
        return Err(Failure::Refused(line));
    }
    // They are left out while reading: to write the text back would delete them.
    let is_lost = |finding: &&Diagnostic| finding.rule.name == "control-character";
    let mut lost = report.findings.iter().filter(is_lost).peekable();
    if lost.peek().is_some() {
        for finding in lost {
            let shown = od_gen::render(finding, &report.source, output::colour_of_errors());
            output::tell(&shown);
        }
        return Ok(None);
    }
    match od_gen::format(&report.source.file, report.source.text()) {
        Ok(after) => Ok(Some((before, after))),
        Err(findings) => {
            for finding in findings {
                let shown = od_gen::render(&finding, &report.source, output::colour_of_errors());
                output::tell(&shown);
            }
            Ok(None)
        }
    }
}

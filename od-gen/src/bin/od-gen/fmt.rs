//! `od-gen fmt`: data sheets in their canonical form.

use std::path::Path;
use std::process::ExitCode;

use crate::Failure;
use crate::arguments::Fmt;
use crate::{input, output};

pub(crate) fn run(arguments: &Fmt) -> Result<ExitCode, Failure> {
    let mut is_wrong = false;
    let mut is_refused = false;
    for file in &arguments.files {
        match format(file, arguments) {
            Ok(is_right) => is_wrong |= !is_right,
            Err(Failure::Findings) => is_wrong = true,
            // It hides nothing of the others.
            Err(Failure::Refused(line)) => {
                output::tell(&line);
                is_refused = true;
            }
        }
    }
    Ok(match (is_refused, is_wrong) {
        (true, _) => ExitCode::from(2),
        (false, true) => ExitCode::FAILURE,
        (false, false) => ExitCode::SUCCESS,
    })
}

/// Brings a file into its canonical form, or only asks. Whether nothing is left to say about it.
fn format(file: &Path, arguments: &Fmt) -> Result<bool, Failure> {
    let only_asks = arguments.check;
    let Some((before, after)) = formatted(file, arguments)? else {
        return Ok(false);
    };
    if before == after.as_bytes() {
        return Ok(true);
    }
    if only_asks {
        output::print(&format!("{}\n", file.display()))?;
    } else {
        output::write(&after, Some(file))?;
    }
    Ok(!only_asks)
}

/// What a file holds, and what it should hold; `None` after a finding that leaves no way to say that.
fn formatted(file: &Path, arguments: &Fmt) -> Result<Option<(Vec<u8>, String)>, Failure> {
    let is_toml = |extension: &std::ffi::OsStr| extension.eq_ignore_ascii_case("toml");
    if file.extension().is_some_and(is_toml) {
        let file = file.display();
        let line = format!(
            "{file}: error: this is a recipe: only EDS and DCF files have a canonical form"
        );
        return Err(Failure::Refused(line));
    }
    let before = od_gen::files::read(file).map_err(|error| input::unreadable(file, &error))?;
    let report = input::readable(file, &arguments.allow)?;
    if report.source.text().trim_start().starts_with('<') {
        let file = file.display();
        let line =
            format!("{file}: error: this is XML: only EDS and DCF files have a canonical form");
        return Err(Failure::Refused(line));
    }
    // They are left out while reading: to write the text back would delete them.
    let is_lost = |finding: &&od_gen::Diagnostic| finding.is_loss();
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

//! `od-gen check`: what is wrong with data sheets.

use std::io::IsTerminal;
use std::process::ExitCode;

use od_gen::{Report, Severity};
use serde_json::{Value, json};

use crate::Failure;
use crate::arguments::{Check, CheckFormat};
use crate::{input, output};

pub(crate) fn run(arguments: &Check) -> Result<ExitCode, Failure> {
    let mut code = ExitCode::SUCCESS;
    let mut is_unread = false;
    let mut reports = Vec::new();
    for file in &arguments.files {
        let report = match input::report(file) {
            Ok(report) => report,
            // It hides nothing of the others.
            Err(Failure::Refused(line)) => {
                output::tell(&line);
                is_unread = true;
                continue;
            }
            Err(failure) => return Err(failure),
        };
        if report.has_errors() || (arguments.deny_warnings && !report.findings.is_empty()) {
            code = ExitCode::FAILURE;
        }
        match arguments.format {
            CheckFormat::Full => {
                output::print(&report.render(output::colour()))?;
                summarize(&report);
            }
            CheckFormat::Short => {
                let lines = report.findings.iter().map(|finding| format!("{finding}\n"));
                output::print(&lines.collect::<String>())?;
                summarize(&report);
            }
            CheckFormat::Json => reports.push(value(&report)),
        }
    }
    if arguments.format == CheckFormat::Json {
        output::print(&format!("{:#}\n", Value::Array(reports)))?;
    }
    Ok(if is_unread { ExitCode::from(2) } else { code })
}

/// One line about a file, for a person who looks on.
fn summarize(report: &Report) {
    if !std::io::stderr().is_terminal() {
        return;
    }
    let count = |number: usize, what: &str| {
        let plural = if number == 1 { "" } else { "s" };
        format!("{number} {what}{plural}")
    };
    let errors = count(report.count(Severity::Error), "error");
    let warnings = count(report.count(Severity::Warning), "warning");
    let silenced = report.silenced.len();
    output::tell(&format!(
        "{}: {errors}, {warnings}, {silenced} silenced",
        report.source.file
    ));
}

/// A file and its findings for programs.
fn value(report: &Report) -> Value {
    let finding = |finding: &od_gen::Diagnostic| {
        json!({
            "rule": finding.rule.name,
            "severity": finding.severity.to_string(),
            "line": finding.span.line,
            "column": finding.span.column,
            "length": finding.span.length,
            "message": finding.message,
            "help": finding.help,
        })
    };
    let silenced = report.silenced.iter().map(|(silenced, reason)| {
        let mut value = finding(silenced);
        value["reason"] = json!(reason);
        value
    });
    json!({
        "file": report.source.file,
        "findings": report.findings.iter().map(finding).collect::<Vec<_>>(),
        "silenced": silenced.collect::<Vec<_>>(),
    })
}

//! `od-gen check`: what is wrong with data sheets, and with the bindings beside them.

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

use od_gen::{BindingReport, Diagnostic, Report, Severity};
use serde_json::{Value, json};

use crate::Failure;
use crate::arguments::{Check, CheckFormat};
use crate::{input, output};

pub(crate) fn run(arguments: &Check) -> Result<ExitCode, Failure> {
    let mut code = ExitCode::SUCCESS;
    let mut is_unread = false;
    let mut reports = Vec::new();
    for file in &arguments.files {
        if arguments.fix {
            put_right(file, arguments)?;
        }
        let report = match input::report(file, &arguments.allow) {
            Ok(report) => report,
            // It hides nothing of the others.
            Err(Failure::Refused(line)) => {
                output::tell(&line);
                is_unread = true;
                continue;
            }
            Err(failure) => return Err(failure),
        };
        // Of a file that is wrong nobody knows what its bindings mean.
        let bindings = match report.has_errors() {
            true => Ok(None),
            false => input::binding_report(file, &report.model),
        };
        let mut checked = vec![Checked::of_file(report, arguments.all)];
        match bindings {
            Ok(bindings) => checked.extend(bindings.map(Checked::of_bindings)),
            Err(Failure::Refused(line)) => {
                output::tell(&line);
                is_unread = true;
            }
            Err(failure) => return Err(failure),
        }
        for checked in checked {
            if checked.count(Severity::Error) > 0
                || (arguments.deny_warnings && !checked.findings.is_empty())
            {
                code = ExitCode::FAILURE;
            }
            match arguments.format {
                CheckFormat::Full => {
                    output::print(&checked.rendered)?;
                    checked.summarize();
                }
                CheckFormat::Short => {
                    let lines = checked.findings.iter();
                    let lines = lines.map(|finding| format!("{finding}\n"));
                    output::print(&lines.collect::<String>())?;
                    checked.summarize();
                }
                CheckFormat::Json => reports.push(checked.value()),
            }
        }
    }
    if arguments.format == CheckFormat::Json {
        output::print(&format!("{:#}\n", Value::Array(reports)))?;
    }
    Ok(if is_unread { ExitCode::from(2) } else { code })
}

/// Puts right what is plain in a file, and says how much that was.
fn put_right(file: &Path, arguments: &Check) -> Result<(), Failure> {
    let mut fixed = 0;
    // What is put right may uncover another mistake on its line.
    for _ in 0..MOST_ROUNDS {
        let Ok(bytes) = od_gen::files::read(file) else {
            // The check says why.
            return Ok(());
        };
        let Ok(text) = String::from_utf8(bytes) else {
            let file = file.display();
            output::tell(&format!("{file}: not in UTF-8: nothing is put right"));
            return Ok(());
        };
        let report = input::report(file, &arguments.allow)?;
        let Some((new, count)) = od_gen::fix(&report, &text) else {
            break;
        };
        output::write(&new, Some(file))?;
        fixed += count;
    }
    if fixed > 0 {
        output::tell(&format!("{}: {fixed} put right", file.display()));
    }
    Ok(())
}

/// How often a file is looked at again.
const MOST_ROUNDS: usize = 8;

/// A data sheet, or bindings, with what there is to say.
struct Checked {
    file: String,
    findings: Vec<Diagnostic>,
    silenced: Vec<(Diagnostic, String)>,
    rendered: String,
}

impl Checked {
    fn of_file(report: Report, shows_all: bool) -> Self {
        let colour = output::colour();
        Self {
            rendered: match shows_all {
                true => report.render_all(colour),
                false => report.render(colour),
            },
            file: report.source.file,
            findings: report.findings,
            silenced: report.silenced,
        }
    }

    fn of_bindings(report: BindingReport) -> Self {
        Self {
            rendered: report.render(output::colour()),
            file: report.source.file,
            findings: report.findings,
            silenced: report.silenced,
        }
    }

    /// How many findings are this bad.
    fn count(&self, severity: Severity) -> usize {
        let findings = self.findings.iter();
        findings
            .filter(|finding| finding.severity == severity)
            .count()
    }

    /// One line about it, for a person who looks on.
    fn summarize(&self) {
        // A file that is right has nothing to say, but to a person who looks on.
        let is_silent = self.findings.is_empty();
        if is_silent && !std::io::stderr().is_terminal() {
            return;
        }
        let count = |number: usize, what: &str| {
            let plural = if number == 1 { "" } else { "s" };
            format!("{number} {what}{plural}")
        };
        let errors = count(self.count(Severity::Error), "error");
        let warnings = count(self.count(Severity::Warning), "warning");
        let silenced = self.silenced.len();
        let silenced = match silenced {
            0 => String::new(),
            number => format!(", {number} silenced"),
        };
        let hint = match self.findings.first() {
            Some(finding) => {
                let name = finding.rule.name;
                format!("; `od-gen rules NAME` explains a rule, such as `od-gen rules {name}`")
            }
            None => String::new(),
        };
        output::tell(&format!(
            "{}: {errors}, {warnings}{silenced}{hint}",
            self.file
        ));
    }

    /// It and its findings for programs.
    fn value(&self) -> Value {
        let finding = |finding: &Diagnostic| {
            json!({
                "file": finding.file,
                "rule": finding.rule.name,
                "class": finding.rule.class.name(),
                "severity": finding.severity.to_string(),
                "line": finding.span.line,
                "column": finding.span.column,
                "length": finding.span.length,
                "message": finding.message,
                "help": finding.help,
            })
        };
        let silenced = self.silenced.iter().map(|(silenced, reason)| {
            let mut value = finding(silenced);
            value["reason"] = json!(reason);
            value
        });
        json!({
            "file": self.file,
            "findings": self.findings.iter().map(finding).collect::<Vec<_>>(),
            "silenced": silenced.collect::<Vec<_>>(),
        })
    }
}

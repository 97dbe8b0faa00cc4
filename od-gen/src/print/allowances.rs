//! Allowances of what printing puts right: in what is printed they would silence nothing.

use std::collections::HashMap;

use crate::diagnostic::without;
use crate::document;
use crate::report::Report;
use crate::rules::reading;

/// An allowance that silences nothing: its reason, which stays when others leave the comment, and its rule.
pub(super) type Unused = (String, String);

/// How often what is left has to be looked at: an allowance may be of use only for another one.
const ROUNDS: usize = 2;

/// The allowances of a text that silence nothing, by line.
fn unused(report: &Report) -> Vec<(u32, Unused)> {
    let findings = report.findings.iter();
    let unused = findings.filter(|finding| finding.rule == &reading::UNUSED_ALLOWANCE);
    let named = unused.filter_map(|finding| {
        let line = finding.span.line;
        let (_, reason) = report.source.line(line)?.split_once(" because ")?;
        let rule = finding.message.split('`').nth(1)?;
        Some((line, (reason.trim().to_owned(), rule.to_owned())))
    });
    named.collect()
}

/// Those of a text that is at hand. Of its encoding nothing is known.
pub(super) fn unused_in(file: &str, text: &str) -> Vec<Unused> {
    let unused = unused(&Report::new(file, text)).into_iter();
    let unused = unused.map(|(_, unused)| unused);
    unused
        .filter(|(_, rule)| rule != reading::NOT_UTF_8.name)
        .collect()
}

/// Takes the allowances away that silence nothing in a printed text, but for those that did not before.
pub(super) fn without_unused(file: &str, mut text: String, before: &[Unused]) -> String {
    for _ in 0..ROUNDS {
        // Most texts have none at all.
        if !text.to_ascii_lowercase().contains("od-gen") {
            return text;
        }
        let report = Report::new(file, &text);
        let mut lines: HashMap<u32, Vec<String>> = HashMap::new();
        for (line, unused) in unused(&report) {
            if !before.contains(&unused) {
                lines.entry(line).or_default().push(unused.1);
            }
        }
        if lines.is_empty() {
            return text;
        }
        let mut kept = String::with_capacity(text.len());
        for (number, line) in (1..).zip(text.lines()) {
            match lines.get(&number) {
                None => kept += line,
                Some(rules) => match without(line, rules) {
                    Some(line) => kept += &line,
                    None => continue,
                },
            }
            kept += "\n";
        }
        let report = Report::new(file, &kept);
        let mut unsaid = crate::diagnostic::Findings::new(file);
        let document = document::read(&report.source, &mut unsaid);
        text = document::write(&document::canonical(document));
    }
    text
}

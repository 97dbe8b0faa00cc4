//! Putting right what is plain: a file with what the advice says to write, and everything else as it stands.

use std::collections::BTreeMap;

use crate::diagnostic::Diagnostic;
use crate::report::Report;
use crate::rules;
use crate::xdd;

/// What is to be done to a line.
enum Change {
    /// These characters of it become another text.
    Replace(usize, usize, String),
    /// Another line comes below it.
    Below(String),
}

/// The text of a file after each mistake of spelling and structure is put right whose advice leaves one reading, and how many there
/// are. Line ends, comments and all other lines stay. `None` where nothing is to be done, and for XML.
pub fn fix(report: &Report, text: &str) -> Option<(String, usize)> {
    // A recipe is no data sheet: its findings are about the files that it is made of.
    if xdd::is_xml(report.source.text()) || !report.source.parts().is_empty() {
        return None;
    }
    let mut changes: BTreeMap<u32, Change> = BTreeMap::new();
    for finding in &report.findings {
        let line = report.source.line(finding.span.line).unwrap_or_default();
        if rules::is_of_files(finding.rule)
            && let Some(change) = change(finding, line)
        {
            // One at a time: a second one on the line is found when the first is done.
            changes.entry(finding.span.line).or_insert(change);
        }
    }
    let mut fixed = String::with_capacity(text.len());
    let mut count = 0;
    for (number, line) in (1..).zip(text.split_inclusive('\n')) {
        let body = line.trim_end_matches(['\r', '\n']);
        let end = line.get(body.len()..).unwrap_or_default();
        let mark = if number == 1 { "\u{feff}" } else { "" };
        // What is not as it was read, such as a line with control characters, is not touched.
        let is_as_read = report.source.line(number) == Some(body.trim_start_matches(mark));
        let is_possible =
            |change: &&Change| !end.is_empty() || matches!(change, Change::Replace(..));
        let change = changes.get(&number).filter(|_| is_as_read);
        match change.filter(is_possible) {
            Some(Change::Replace(start, length, new)) => {
                let body = body.trim_start_matches(mark);
                let before: String = body.chars().take(*start).collect();
                let after: String = body.chars().skip(start + length).collect();
                let mark = if line.starts_with('\u{feff}') {
                    mark
                } else {
                    ""
                };
                fixed += &format!("{mark}{before}{new}{after}{end}");
                count += 1;
            }
            Some(Change::Below(new)) => {
                fixed += &format!("{line}{new}{end}");
                count += 1;
            }
            None => fixed += line,
        }
    }
    (count > 0).then_some((fixed, count))
}

/// What the advice `write ...` comes to on its line; `None` where it has two readings or is about another line.
fn change(finding: &Diagnostic, line: &str) -> Option<Change> {
    let advice = finding.help.as_ref()?.strip_prefix("write ")?;
    let has_one_reading = !advice.contains(", ") && !advice.contains(" or ");
    let new = advice.trim_matches('`');
    if !has_one_reading || new.is_empty() || new.contains('`') {
        return None;
    }
    let start = usize::try_from(finding.span.column.checked_sub(1)?).ok()?;
    let length = usize::try_from(finding.span.length).ok()?;
    let key = line.split('=').next().unwrap_or_default().trim();
    match new.split_once('=') {
        // A key that is missing in the section that the finding is about.
        Some(_) if line.trim_start().starts_with('[') => Some(Change::Below(new.into())),
        Some((name, value)) if name.eq_ignore_ascii_case(key) => {
            Some(Change::Replace(start, length, value.into()))
        }
        Some((name, _)) if line.trim_start().starts_with(&format!("{name}:")) => {
            Some(Change::Replace(start, length, new.into()))
        }
        Some(_) => None,
        None => Some(Change::Replace(start, length, new.into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: &str = include_str!("../tests/data/makers/numbers.eds");

    #[test]
    fn what_is_plain_is_put_right_and_nothing_else_changes() {
        let text = NUMBERS
            .replace('\n', "\r\n")
            .replace("SupportedObjects=1\r\n", "; a comment\r\n");
        let mut now = text.clone();
        let mut count = 0;
        while let Some((fixed, number)) = fix(&Report::new("x.eds", &now), &now) {
            (now, count) = (fixed, count + number);
            assert!(count < 100);
        }
        assert_eq!(count, 5);
        assert!(!Report::new("x.eds", &now).has_errors(), "{now}");
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
        let (before, after) = (lines(&text), lines(&now));
        assert_eq!(now.matches("\r\n").count(), now.matches('\n').count());
        let new: Vec<_> = after.iter().filter(|line| !before.contains(line)).collect();
        let expected = [
            "SupportedObjects=1",
            "DataType=0x0006",
            "DefaultValue=8",
            "DefaultValue=0x1000",
            "DefaultValue=1",
        ];
        for line in new {
            assert!(expected.contains(&line.as_str()), "{line}");
        }
        assert!(fix(&Report::new("x.eds", &now), &now).is_none());
    }

    #[test]
    fn what_has_two_readings_is_left_alone() {
        let text = include_str!("../tests/data/makers/wrong_counts.eds");
        assert!(fix(&Report::new("x.eds", text), text).is_none());
    }
}

//! From lines to a [`Document`].

use std::borrow::Cow;
use std::collections::HashMap;
use std::mem;

use super::{Comment, Document, Key, Section};
use crate::diagnostic::Findings;
use crate::rules::reading;
use crate::source::{Source, Span};

/// Reads the lines of a file.
pub(crate) fn read<'a>(source: &'a Source, findings: &mut Findings) -> Document<'a> {
    read_lines(source, false, findings)
}

/// Reads the lines of a file that is to be written again: those that mean nothing are kept as comments.
pub(crate) fn read_all<'a>(source: &'a Source, findings: &mut Findings) -> Document<'a> {
    read_lines(source, true, findings)
}

fn read_lines<'a>(source: &'a Source, keeps_all: bool, findings: &mut Findings) -> Document<'a> {
    let mut reader = Reader {
        keeps_all,
        document: Document::default(),
        lead: Vec::new(),
        after_blank: true,
        keys: HashMap::new(),
        findings,
    };
    let mut last = 0;
    for (number, line) in (1..).zip(source.text().lines()) {
        reader.line(number, line);
        last = number;
    }
    reader.finish(last + 1)
}

struct Reader<'a, 'f> {
    document: Document<'a>,
    /// Whether lines that mean nothing become comments.
    keeps_all: bool,
    /// Comments after a blank line: they belong to the next section, if that comes before the next key.
    lead: Vec<Comment<'a>>,
    after_blank: bool,
    /// Where each key of the present section is, in lower case.
    keys: HashMap<String, usize>,
    findings: &'f mut Findings,
}

impl<'a> Reader<'a, '_> {
    fn line(&mut self, number: u32, line: &'a str) {
        let text = line.trim();
        let span = Span::of(number, line, text);
        match text.chars().next() {
            None => self.after_blank = true,
            Some(';' | '#') => {
                let text = text.get(1..).unwrap_or_default();
                self.comment(text, span);
            }
            Some('[') => {
                self.section(text, span);
                self.after_blank = false;
            }
            Some(_) => match text.split_once('=') {
                Some((name, value)) if !name.trim().is_empty() => {
                    self.key(number, line, name.trim(), value.trim());
                    self.after_blank = false;
                }
                _ => {
                    let message =
                        format!("`{text}` is neither a section nor key=value nor a ;comment");
                    let finding = self.findings.report(&reading::STRAY_LINE, span, message);
                    let name = |name: &str| !name.is_empty() && !name.contains(char::is_whitespace);
                    match text.split_once(':').filter(|(key, _)| name(key)) {
                        Some((key, value)) => finding.help(format!(
                            "write `{key}={}`, or put `;` in front of it",
                            value.trim()
                        )),
                        None => finding.help("remove it, or put `;` in front of it"),
                    }
                    self.keep(text, span);
                }
            },
        }
    }

    /// Keeps a text that means nothing.
    fn keep(&mut self, text: &'a str, span: Span) {
        if self.keeps_all && !text.is_empty() {
            self.comment(super::left_out(text), span);
        }
    }

    fn comment(&mut self, text: impl Into<Cow<'a, str>>, span: Span) {
        let mut comment = Comment {
            text: text.into(),
            span,
            position: 0,
        };
        match self.document.sections.last_mut() {
            None => self.document.head.push(comment),
            Some(section) => {
                comment.position = section.keys.len();
                if self.after_blank || !self.lead.is_empty() {
                    self.lead.push(comment);
                } else {
                    section.comments.push(comment);
                }
            }
        }
    }

    fn section(&mut self, text: &'a str, span: Span) {
        let inner = text.strip_prefix('[').unwrap_or(text);
        let (name, rest) = inner.split_once(']').unwrap_or((inner, ""));
        let comment = rest.trim_start().strip_prefix(';');
        if comment.is_some() {
            let message = format!("the section is read as `[{name}]`, up to the `;`");
            let finding = self
                .findings
                .report(&reading::TRAILING_COMMENT, span, message);
            finding.help("put the comment on a line of its own: not every reader cuts it off");
        } else if !inner.ends_with(']') || !rest.is_empty() {
            let message = format!("`{text}` is not a section: it must end with its `]`");
            self.findings
                .report(&reading::UNCLOSED_SECTION, span, message);
        }
        let name = name.trim();
        let rest = if comment.is_some() { "" } else { rest.trim() };
        self.keys.clear();
        let lead = mem::take(&mut self.lead);
        let start = lead.first().map_or(span.line, |comment| comment.span.line);
        self.close(start);
        self.document.sections.push(Section {
            lead,
            name: name.into(),
            span,
            lines: start..u32::MAX,
            also: Vec::new(),
            keys: Vec::new(),
            comments: comment
                .map(|text| Comment {
                    text: text.into(),
                    span,
                    position: 0,
                })
                .into_iter()
                .collect(),
        });
        self.after_blank = false;
        self.keep(rest, span);
    }

    fn key(&mut self, number: u32, line: &'a str, name: &'a str, value: &'a str) {
        let name_span = Span::of(number, line, name);
        let Some(section) = self.document.sections.last_mut() else {
            let message = format!("`{name}` stands before the first section");
            self.findings
                .report(&reading::KEY_OUTSIDE, name_span, message);
            self.keep(line.trim(), name_span);
            return;
        };
        section.comments.append(&mut self.lead);
        let (value, comment) = split_comment(value);
        let span = Span::of(number, line, value);
        if let Some(comment) = comment {
            section.comments.push(Comment {
                text: comment.into(),
                span: Span::of(number, line, comment),
                position: section.keys.len(),
            });
            let message = format!("the value of `{name}` is read as `{value}`, up to the `;`");
            let finding = self
                .findings
                .report(&reading::TRAILING_COMMENT, span, message);
            finding.help("put the comment on a line of its own: not every reader cuts it off");
        }
        let at = section.keys.len();
        let first = *self.keys.entry(name.to_ascii_lowercase()).or_insert(at);
        if let Some(first) = section.keys.get(first).filter(|_| first != at) {
            let (on, known) = (first.span.line, &first.value);
            let rule = if *known == value {
                &reading::REPEATED_KEY
            } else {
                &reading::CONTRADICTING_KEY
            };
            let message = format!("`{name}` is already on line {on}, as `{known}`");
            let place = first.span;
            let finding = self.findings.report(rule, name_span, message);
            finding.help("only the first one counts: remove one of them");
            finding.also(place, "this one counts");
            if rule == &reading::CONTRADICTING_KEY {
                self.keep(line.trim(), name_span);
            }
            return;
        }
        section.keys.push(Key {
            name: name.into(),
            value: value.into(),
            name_span,
            span,
        });
    }

    /// The present section ends above this line.
    fn close(&mut self, line: u32) {
        if let Some(section) = self.document.sections.last_mut() {
            section.lines.end = line;
        }
    }

    fn finish(mut self, end: u32) -> Document<'a> {
        self.close(end);
        let lead = mem::take(&mut self.lead);
        if let Some(section) = self.document.sections.last_mut() {
            section.comments.extend(lead);
        }
        self.document.keep_first(self.keeps_all, self.findings);
        self.document
    }
}

/// A value, and the comment behind it. CiA 306 knows no such comments, most readers do.
fn split_comment(value: &str) -> (&str, Option<&str>) {
    let marks = [" ;", "\t;"].into_iter();
    let at = match value.strip_prefix(';') {
        Some(_) => Some(0),
        None => marks.filter_map(|mark| value.find(mark)).min(),
    };
    let Some((before, behind)) = at.and_then(|at| value.split_at_checked(at)) else {
        return (value, None);
    };
    let comment = behind.trim_start();
    (
        before.trim_end(),
        Some(comment.strip_prefix(';').unwrap_or(comment)),
    )
}

//! Silencing a finding: a comment `;od-gen: allow RULE because REASON` in the section it concerns (that of an object is for its
//! sub-indices too), or above the first section for the whole file.
//!
//! A finding can be silenced where the file still has a sensible meaning without it; a value that cannot be read stays an
//! error. An allowance without a reason and one that silences nothing are findings themselves.

use std::collections::HashMap;
use std::ops::Range;

use super::{Diagnostic, Findings};
use crate::document::{Comment, Document};
use crate::rules::{self, Rule, reading};
use crate::source::Span;

#[derive(Debug)]
struct Allowance {
    rule: &'static Rule,
    reason: String,
    span: Span,
    is_used: bool,
}

/// Lines that an allowance is for.
#[derive(Debug)]
struct Place {
    lines: Range<u32>,
    /// Which allowance.
    allowance: usize,
    /// The highest end of the lines of this place and of all before it.
    reach: u32,
}

/// The allowances of a file.
#[derive(Debug, Default)]
pub(crate) struct Allowances {
    /// In the order of the file.
    list: Vec<Allowance>,
    /// Those in sections, by their first line.
    places: Vec<Place>,
    /// How many of the list are for the whole file: the first ones.
    whole: usize,
}

impl Allowances {
    /// Reads the comments of a file. What is allowed in the section of an object is allowed in those of its sub-indices too.
    pub(crate) fn read(document: &Document<'_>, findings: &mut Findings) -> Self {
        let mut allowances = Self::default();
        for comment in &document.head {
            allowances.take(comment, &[], findings);
        }
        allowances.whole = allowances.list.len();
        let mut parts: HashMap<String, Vec<Range<u32>>> = HashMap::new();
        for section in &document.sections {
            let name = section.name.to_ascii_lowercase();
            let (object, _) = name.split_once("sub").unwrap_or((&name, ""));
            let lines = parts.entry(object.to_owned()).or_default();
            lines.push(section.lines.clone());
        }
        for section in &document.sections {
            let own = [section.lines.clone()];
            let all = parts.get(&section.name.to_ascii_lowercase());
            let lines = all.map_or(&own[..], Vec::as_slice);
            for comment in section.lead.iter().chain(&section.comments) {
                allowances.take(comment, lines, findings);
            }
        }
        allowances.places.sort_by_key(|place| place.lines.start);
        let mut reach = 0;
        for place in &mut allowances.places {
            reach = place.lines.end.max(reach);
            place.reach = reach;
        }
        allowances
    }

    fn take(&mut self, comment: &Comment<'_>, lines: &[Range<u32>], findings: &mut Findings) {
        let Some(request) = request(&comment.text) else {
            return;
        };
        let span = comment.span;
        let Some((rules, reason)) = spelled_right(request) else {
            let finding = findings.report(
                &reading::ALLOWANCE_WITHOUT_REASON,
                span,
                "this silences nothing: it has no reason",
            );
            finding.help("write `;od-gen: allow RULE because REASON`");
            return;
        };
        for name in rules.split(',').map(str::trim) {
            let Some(rule) = rules::find(name) else {
                let message = format!("there is no rule `{name}`");
                let finding = findings.report(&reading::ALLOWANCE_OF_NO_RULE, span, message);
                finding.help("`od-gen rules` lists the rules");
                continue;
            };
            if !rule.can_be_allowed {
                let message = format!("`{name}` cannot be silenced: the file has no meaning then");
                findings.report(&reading::ALLOWANCE_REFUSED, span, message);
                continue;
            }
            let allowance = self.list.len();
            self.places.extend(lines.iter().map(|lines| Place {
                lines: lines.clone(),
                allowance,
                reach: 0,
            }));
            self.list.push(Allowance {
                rule,
                reason: reason.into(),
                span,
                is_used: false,
            });
        }
    }

    /// The allowance for a finding: the one in a section whose lines begin last, or else one for the whole file.
    fn find(&mut self, finding: &Diagnostic) -> Option<&mut Allowance> {
        let line = finding.span.line;
        let end = (self.places).partition_point(|place| place.lines.start <= line);
        let near = self.places.iter().take(end).rev();
        // Where nothing reaches the line any more, nothing above does.
        let near = near.take_while(|place| place.reach > line);
        let near = near.filter(|place| place.lines.contains(&line));
        let numbers = near.map(|place| place.allowance).chain(0..self.whole);
        let is_for = |number: &usize| {
            let allowance = self.list.get(*number);
            allowance.is_some_and(|own| own.rule.name == finding.rule.name)
        };
        let found = numbers.into_iter().find(is_for)?;
        self.list.get_mut(found)
    }

    /// Takes away what is allowed, and reports allowances that silence nothing. Returns the silenced ones with their reasons.
    pub(crate) fn apply(mut self, findings: &mut Findings) -> Vec<(Diagnostic, String)> {
        let mut silenced = Vec::new();
        let mut kept = Vec::new();
        for finding in findings.list.drain(..) {
            match self.find(&finding) {
                Some(allowance) => {
                    allowance.is_used = true;
                    silenced.push((finding, allowance.reason.clone()));
                }
                None => kept.push(finding),
            }
        }
        findings.list = kept;
        for allowance in self.list.iter().filter(|allowance| !allowance.is_used) {
            let message = format!(
                "`{}` finds nothing here to be silenced",
                allowance.rule.name
            );
            let finding = findings.report(&reading::UNUSED_ALLOWANCE, allowance.span, message);
            finding.help("remove the allowance");
        }
        silenced
    }
}

/// What follows `od-gen:` in a comment.
fn request(comment: &str) -> Option<&str> {
    let (tool, request) = comment.trim().split_once(':')?;
    tool.trim_end()
        .eq_ignore_ascii_case("od-gen")
        .then(|| request.trim())
}

/// The rules and the reason.
fn spelled_right(request: &str) -> Option<(&str, &str)> {
    let (rules, reason) = request.strip_prefix("allow ")?.split_once(" because ")?;
    let reason = reason.trim();
    (!reason.is_empty()).then_some((rules, reason))
}

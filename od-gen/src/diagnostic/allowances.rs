//! Silencing a finding: a comment `;od-gen: allow RULE because REASON` in the section it concerns (that of an object is for its
//! sub-indices too), or above the first section for the whole file.
//!
//! A finding can be silenced where the file still has a sensible meaning: the explanation of its rule says which. An allowance without
//! a reason and one that silences nothing are findings themselves. What is allowed about files beside the data sheet (its bindings,
//! the values of a configuration) stands above its first section, or in those files.

use std::collections::HashMap;
use std::ops::Range;

use super::{Diagnostic, Exemption, Findings};
use crate::document::{Comment, Document};
use crate::model::Remarks;
use crate::rules::{self, Rule, reading};
use crate::source::Span;

#[derive(Clone, Debug)]
struct Allowance {
    rule: &'static Rule,
    reason: String,
    /// Of the comment; `None` in another file.
    span: Option<Span>,
    is_used: bool,
}

/// Lines that an allowance is for.
#[derive(Clone, Debug)]
struct Place {
    lines: Range<u32>,
    /// Which allowance.
    allowance: usize,
    /// The highest end of the lines of this place and of all before it.
    reach: u32,
}

/// The allowances of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Allowances {
    /// In the order of the file.
    list: Vec<Allowance>,
    /// Those in sections, by their first line.
    places: Vec<Place>,
    /// How many of the list are for the whole file: the first ones.
    whole: usize,
    /// Whether the file is a data sheet, which has others beside it.
    is_of_data_sheet: bool,
}

impl Allowances {
    /// Reads the comments of a file. What is allowed in the section of an object is allowed in those of its sub-indices too.
    pub(crate) fn read(document: &Document<'_>, findings: &mut Findings) -> Self {
        let mut allowances = Self {
            is_of_data_sheet: true,
            ..Self::default()
        };
        for comment in &document.head {
            allowances.take(comment, &[], findings);
        }
        let exemptions = findings.exemptions().to_vec();
        let is_whole = |own: &&Exemption| own.objects.is_empty();
        for own in exemptions.iter().filter(is_whole) {
            allowances.exempt(own);
        }
        allowances.whole = allowances.list.len();
        let mut parts: HashMap<String, Vec<Range<u32>>> = HashMap::new();
        for section in &document.sections {
            let name = section.name.to_ascii_lowercase();
            let (object, _) = name.split_once("sub").unwrap_or((&name, ""));
            let lines = parts.entry(object.to_owned()).or_default();
            lines.push(section.lines.clone());
            lines.extend(section.also.iter().cloned());
        }
        for section in &document.sections {
            let own = [section.lines.clone()];
            let all = parts.get(&section.name.to_ascii_lowercase());
            let lines = all.map_or(&own[..], Vec::as_slice);
            for comment in section.lead.iter().chain(&section.comments) {
                allowances.take(comment, lines, findings);
            }
        }
        for own in exemptions.iter().filter(|own| !is_whole(own)) {
            let allowance = allowances.list.len();
            for (object, lines) in &parts {
                let index = object
                    .get(..4)
                    .and_then(|text| u16::from_str_radix(text, 16).ok());
                let is_for = |index| own.objects.iter().any(|range| range.contains(&index));
                if index.is_some_and(is_for) {
                    let places = lines.iter().map(|lines| Place {
                        lines: lines.clone(),
                        allowance,
                        reach: 0,
                    });
                    allowances.places.extend(places);
                }
            }
            allowances.exempt(own);
        }
        allowances.sort();
        allowances
    }

    /// Takes what is allowed from outside.
    fn exempt(&mut self, own: &Exemption) {
        self.list.push(Allowance {
            rule: own.rule,
            reason: own.reason.clone(),
            span: None,
            is_used: false,
        });
    }

    /// What a data sheet, by its remarks, allows for a file beside it, which has comments of its own: each with the lines it is for, none for
    /// the whole file.
    pub(crate) fn beside(
        remarks: &Remarks,
        own: &[(Comment<'_>, Option<Range<u32>>)],
        findings: &mut Findings,
    ) -> Self {
        let mut allowances = Self::default();
        for remark in &remarks.0 {
            let comment = Comment::new(remark, 0);
            // What is wrong with it is said about the data sheet.
            let mut unsaid = findings.same_file();
            let before = allowances.list.len();
            allowances.take(&comment, &[], &mut unsaid);
            for allowance in allowances.list.iter_mut().skip(before) {
                allowance.span = None;
            }
        }
        for (comment, _) in own.iter().filter(|(_, lines)| lines.is_none()) {
            allowances.take(comment, &[], findings);
        }
        allowances.whole = allowances.list.len();
        for (comment, lines) in own {
            if let Some(lines) = lines {
                allowances.take(comment, std::slice::from_ref(lines), findings);
            }
        }
        allowances.sort();
        allowances
    }

    /// Brings the places into their order.
    fn sort(&mut self) {
        self.places.sort_by_key(|place| place.lines.start);
        let mut reach = 0;
        for place in &mut self.places {
            reach = place.lines.end.max(reach);
            place.reach = reach;
        }
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
                let message =
                    format!("`{name}` cannot be silenced: nothing of the file can be read then");
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
                span: Some(span),
                is_used: false,
            });
        }
    }

    /// Which allowance is for a finding of this rule on this line: the one in a section whose lines begin last, or else one for the
    /// whole file.
    fn find(&self, rule: &Rule, line: u32) -> Option<usize> {
        let end = (self.places).partition_point(|place| place.lines.start <= line);
        let near = self.places.iter().take(end).rev();
        // Where nothing reaches the line any more, nothing above does.
        let near = near.take_while(|place| place.reach > line);
        let near = near.filter(|place| place.lines.contains(&line));
        let mut numbers = near.map(|place| place.allowance).chain(0..self.whole);
        let is_for = |number: &usize| {
            let allowance = self.list.get(*number);
            allowance.is_some_and(|own| own.rule.name == rule.name)
        };
        numbers.find(is_for)
    }

    /// Whether a finding of this rule is silenced here.
    pub(super) fn allow(&self, rule: &Rule, span: Span) -> bool {
        self.find(rule, span.line).is_some()
    }

    /// Takes away what is allowed, and reports allowances that silence nothing. Returns the silenced ones with their reasons.
    pub(super) fn apply(mut self, findings: &mut Findings) -> Vec<(Diagnostic, String)> {
        let mut silenced = Vec::new();
        self.silence(findings, &mut silenced);
        // Whether an allowance of `unused-allowance` is of use is known after all others.
        for is_about_others in [true, false] {
            let mut unused = findings.same_file();
            for (number, allowance) in self.list.iter().enumerate() {
                let Allowance { rule, span, .. } = *allowance;
                let is_of_other_file = self.is_of_data_sheet
                    && number < self.whole
                    && rules::is_about_other_files(rule);
                let is_about_other = rule.name != reading::UNUSED_ALLOWANCE.name;
                if allowance.is_used || is_of_other_file || is_about_other != is_about_others {
                    continue;
                }
                if let Some(span) = span {
                    let message = format!("`{}` finds nothing here to be silenced", rule.name);
                    let finding = unused.report(&reading::UNUSED_ALLOWANCE, span, message);
                    finding.help("remove the allowance");
                }
            }
            self.silence(&mut unused, &mut silenced);
            findings.list.append(&mut unused.list);
        }
        silenced
    }

    /// Moves what is allowed from one list to the other.
    fn silence(&mut self, findings: &mut Findings, silenced: &mut Vec<(Diagnostic, String)>) {
        let mut kept = Vec::new();
        for finding in findings.list.drain(..) {
            let found = self.find(finding.rule, finding.span.line);
            match found.and_then(|number| self.list.get_mut(number)) {
                Some(allowance) => {
                    allowance.is_used = true;
                    silenced.push((finding, allowance.reason.clone()));
                }
                None => kept.push(finding),
            }
        }
        findings.list = kept;
    }
}

/// Whether a comment asks for something to be silenced.
pub(crate) fn is_allowance(comment: &Comment<'_>) -> bool {
    request(&comment.text).is_some()
}

/// The line of a comment without its allowances of these rules; `None` when nothing is left of it.
pub(crate) fn without(line: &str, gone: &[String]) -> Option<String> {
    let (rules, _) = spelled_right(request(line.trim().get(1..)?)?)?;
    let left = rules.split(',').map(str::trim);
    let left: Vec<&str> = left
        .filter(|rule| !gone.iter().any(|gone| gone == rule))
        .collect();
    (!left.is_empty()).then(|| line.replacen(rules, &left.join(", "), 1))
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

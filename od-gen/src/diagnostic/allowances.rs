//! Silencing a finding: a comment `;od-gen: allow RULE because REASON` in the section it concerns, or above the first section
//! for the whole file.
//!
//! A finding can be silenced where the file still has a sensible meaning without it; a value that cannot be read stays an
//! error. An allowance without a reason and one that silences nothing are findings themselves.

use super::{Diagnostic, Findings};
use crate::document::{Comment, Document};
use crate::rules::{self, Rule, reading};
use crate::source::Span;

#[derive(Debug)]
struct Allowance {
    rule: &'static Rule,
    reason: String,
    /// The lines it is for.
    lines: std::ops::Range<u32>,
    span: Span,
    is_used: bool,
}

/// The allowances of a file.
#[derive(Debug, Default)]
pub(crate) struct Allowances {
    /// In the order of the file, those for the whole file first.
    list: Vec<Allowance>,
}

impl Allowances {
    /// Reads the comments of a file.
    pub(crate) fn read(document: &Document<'_>, findings: &mut Findings) -> Self {
        let mut allowances = Self::default();
        for comment in &document.head {
            allowances.take(comment, 0..u32::MAX, findings);
        }
        for section in &document.sections {
            for comment in section.lead.iter().chain(&section.comments) {
                allowances.take(comment, section.lines.clone(), findings);
            }
        }
        allowances
    }

    fn take(
        &mut self,
        comment: &Comment<'_>,
        lines: std::ops::Range<u32>,
        findings: &mut Findings,
    ) {
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
            self.list.push(Allowance {
                rule,
                reason: reason.into(),
                lines: lines.clone(),
                span,
                is_used: false,
            });
        }
    }

    /// Takes away what is allowed, and reports allowances that silence nothing. Returns the silenced ones with their reasons.
    pub(crate) fn apply(mut self, findings: &mut Findings) -> Vec<(Diagnostic, String)> {
        let mut silenced = Vec::new();
        let mut kept = Vec::new();
        let sections = self
            .list
            .partition_point(|allowance| allowance.lines.start == 0);
        for finding in findings.list.drain(..) {
            // Sections follow each other: of those whose lines begin above the finding, the last ones are around it.
            let line = finding.span.line;
            let end = self
                .list
                .partition_point(|allowance| allowance.lines.start <= line);
            let is_for = |allowance: &&mut Allowance| {
                allowance.lines.contains(&line) && allowance.rule.name == finding.rule.name
            };
            let (whole, rest) = self.list.split_at_mut(sections);
            let near = rest.get_mut(..end.saturating_sub(sections));
            let near = near.into_iter().flatten().rev();
            let near = near.take_while(|allowance| allowance.lines.contains(&line));
            match near.chain(whole).find(is_for) {
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

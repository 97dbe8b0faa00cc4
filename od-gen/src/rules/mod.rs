//! The rules a data sheet is held to, by name.
//!
//! Each file here declares the rules of one subject. Those about reading, structure and values are checked while a file is
//! parsed; the others look at the finished model.

mod cob_ids;
mod communication;
mod device_info;
mod pdo_mapping;
pub(crate) mod reading;
pub(crate) mod structure;
pub(crate) mod value;

use crate::diagnostic::{Findings, Severity};
use crate::model::Model;
use crate::parse::Broken;

/// A rule.
#[derive(Debug, PartialEq, Eq)]
pub struct Rule {
    /// Its name, in words joined by hyphens.
    pub name: &'static str,
    /// How bad it is to break it.
    pub severity: Severity,
    /// Whether a comment in the file can silence it: the file has a sensible meaning without it.
    pub can_be_allowed: bool,
    /// What it asks, in a sentence.
    pub summary: &'static str,
    /// Why, and what to do.
    pub explanation: &'static str,
}

impl Rule {
    /// A rule whose findings leave the file usable.
    pub(crate) const fn warning(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        Self {
            name,
            severity: Severity::Warning,
            can_be_allowed: true,
            summary,
            explanation,
        }
    }

    /// A rule that a file must keep, unless it says why it does not.
    pub(crate) const fn error(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        Self {
            name,
            severity: Severity::Error,
            can_be_allowed: true,
            summary,
            explanation,
        }
    }

    /// A rule without which the file has no meaning.
    pub(crate) const fn fatal(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        Self {
            name,
            severity: Severity::Error,
            can_be_allowed: false,
            summary,
            explanation,
        }
    }
}

/// The rules by subject.
const SUBJECTS: &[&[&Rule]] = &[
    reading::RULES,
    structure::RULES,
    value::RULES,
    device_info::RULES,
    communication::RULES,
    cob_ids::RULES,
    pdo_mapping::RULES,
];

/// What the rules about the model look at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subject<'a> {
    /// What could be read.
    pub(crate) model: &'a Model,
    /// What is there, but could not be read.
    pub(crate) broken: &'a Broken,
}

impl Subject<'_> {
    /// Whether a value is really not there; one that could not be read is.
    pub(crate) fn lacks(&self, index: u16, sub: u8) -> bool {
        self.model.entry(index, sub).is_none() && !self.broken.has(index, sub)
    }

    /// Whether an object is there, readable or not.
    pub(crate) fn has_object(&self, index: u16) -> bool {
        self.model.object(index).is_some() || self.broken.objects.contains(&index)
    }
}

/// Holds a model to the rules about models.
pub(crate) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    device_info::check(subject, findings);
    communication::check(subject, findings);
    cob_ids::check(subject, findings);
    pdo_mapping::check(subject, findings);
}

/// All rules, by subject.
pub fn all() -> impl Iterator<Item = &'static Rule> {
    SUBJECTS.iter().copied().flatten().copied()
}

/// The rule with this name.
pub fn find(name: &str) -> Option<&'static Rule> {
    all().find(|rule| rule.name == name)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn each_rule_has_a_name_of_its_own_and_explains_itself() {
        let mut names = HashSet::new();
        for rule in all() {
            assert!(names.insert(rule.name), "{} is there twice", rule.name);
            assert!(
                rule.name.bytes().all(|letter| letter.is_ascii_lowercase()
                    || letter.is_ascii_digit()
                    || letter == b'-'),
                "{}",
                rule.name
            );
            assert!(rule.summary.ends_with('.'), "{}", rule.name);
            assert!(rule.explanation.ends_with('.'), "{}", rule.name);
        }
    }
}

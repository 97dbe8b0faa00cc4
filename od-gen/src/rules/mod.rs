//! The rules a data sheet is held to, by name.
//!
//! Each file here declares the rules of one subject. Those about reading, structure and values are checked while a file is
//! parsed; the others look at the finished model.

pub(crate) mod binding;
mod communication;
mod drive;
pub(crate) mod reading;
mod setting;
mod standard;
pub(crate) mod structure;
pub(crate) mod value;

use std::ops::Deref;

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

/// The rules of a file, by subject.
const FILE_SUBJECTS: &[&[&Rule]] = &[
    reading::RULES,
    structure::RULES,
    value::RULES,
    binding::RULES,
];

/// The rules of the finished model, by subject.
const MODEL_SUBJECTS: &[&[&Rule]] = &[
    standard::check::RULES,
    communication::device_info::RULES,
    communication::device_type::RULES,
    communication::error_control::RULES,
    communication::sync::RULES,
    communication::storage::RULES,
    communication::cob_id::RULES,
    communication::predefined::RULES,
    communication::pdo::RULES,
    communication::mapping::RULES,
    drive::objects::RULES,
    drive::modes::RULES,
    drive::units::RULES,
    drive::values::RULES,
];

/// What holds a model to the rules of one subject.
type Check = fn(&Subject<'_>, &mut Findings);

/// Those of the finished model.
const CHECKS: &[Check] = &[
    standard::check::check,
    communication::device_info::check,
    communication::device_type::check,
    communication::error_control::check,
    communication::sync::check,
    communication::storage::check,
    communication::cob_id::check,
    communication::predefined::check,
    communication::pdo::check,
    communication::mapping::check,
    drive::objects::check,
    drive::modes::check,
    drive::units::check,
    drive::values::check,
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

    /// Whether an object is really not there.
    pub(crate) fn lacks_object(&self, index: u16) -> bool {
        let is_broken = self.broken.objects.contains(&index) || self.broken.has(index, 0);
        self.model.object(index).is_none() && !is_broken
    }
}

impl Deref for Subject<'_> {
    type Target = Model;

    fn deref(&self) -> &Model {
        self.model
    }
}

/// Holds a model to the rules about models.
pub(crate) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    for check in CHECKS {
        check(subject, findings);
    }
}

/// All rules, by subject.
pub fn all() -> impl Iterator<Item = &'static Rule> {
    let subjects = FILE_SUBJECTS.iter().chain(MODEL_SUBJECTS);
    subjects.copied().flatten().copied()
}

/// The rule with this name.
pub fn find(name: &str) -> Option<&'static Rule> {
    all().find(|rule| rule.name == name)
}

#[cfg(test)]
mod tests;

//! The rules a data sheet is held to, by name.
//!
//! Each file here declares the rules of one subject. Those about reading, structure and values are checked while a file is
//! parsed; the others look at the finished model.

pub(crate) mod binding;
mod communication;
pub(crate) mod configuration;
mod drive;
mod modules;
pub(crate) mod network;
pub(crate) mod reading;
pub(crate) mod recipe;
mod setting;
pub(crate) mod standard;
pub(crate) mod structure;
pub(crate) mod value;

use std::ops::Deref;

use crate::diagnostic::{Findings, Severity};
use crate::model::Model;
use crate::parse::Broken;

/// What it is that a finding breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// CiA 306 or CiA 301: the file is wrong, whoever reads it.
    Standard,
    /// What masters and tools expect: some of them stumble over it.
    Masters,
    /// What this firmware and its generator can do: no matter for anybody else.
    Firmware,
    /// Good sense.
    Advice,
}

impl Class {
    /// Its name in lists.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Masters => "masters",
            Self::Firmware => "firmware",
            Self::Advice => "advice",
        }
    }
}

/// A rule.
#[derive(Debug, PartialEq, Eq)]
pub struct Rule {
    /// Its name, in words joined by hyphens.
    pub name: &'static str,
    /// What is broken with it.
    pub class: Class,
    /// How bad it is to break it.
    pub severity: Severity,
    /// How bad it is where code is to be made of the file.
    pub severity_for_code: Severity,
    /// Whether a comment in the file can silence it: the file has a sensible meaning without it.
    pub can_be_allowed: bool,
    /// What it asks, in a sentence.
    pub summary: &'static str,
    /// Why, and what to do.
    pub explanation: &'static str,
}

impl Rule {
    const fn new(
        class: Class,
        severity: Severity,
        (name, summary, explanation): (&'static str, &'static str, &'static str),
    ) -> Self {
        Self {
            name,
            class,
            severity,
            severity_for_code: severity,
            can_be_allowed: true,
            summary,
            explanation,
        }
    }

    /// What is unwise.
    pub(crate) const fn warning(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        let text = (name, summary, explanation);
        Self::new(Class::Advice, Severity::Warning, text)
    }

    /// What makes masters stumble.
    pub(crate) const fn masters(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        let text = (name, summary, explanation);
        Self::new(Class::Masters, Severity::Warning, text)
    }

    /// What this firmware cannot do: no code is made of it.
    pub(crate) const fn firmware(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        let text = (name, summary, explanation);
        Self::new(Class::Firmware, Severity::Warning, text).strict()
    }

    /// What breaks the standard.
    pub(crate) const fn error(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        let text = (name, summary, explanation);
        Self::new(Class::Standard, Severity::Error, text)
    }

    /// A rule without which nothing of the file can be read, and so no comment that could silence it.
    pub(crate) const fn fatal(
        name: &'static str,
        summary: &'static str,
        explanation: &'static str,
    ) -> Self {
        Self {
            can_be_allowed: false,
            ..Self::error(name, summary, explanation)
        }
    }

    /// No code is made of a file that breaks it.
    pub(crate) const fn strict(self) -> Self {
        Self {
            severity_for_code: Severity::Error,
            ..self
        }
    }

    /// The same rule of another class.
    pub(crate) const fn of(self, class: Class) -> Self {
        Self { class, ..self }
    }
}

/// Rules that belong together.
#[derive(Clone, Copy, Debug)]
pub struct Chapter {
    /// What they are about.
    pub title: &'static str,
    /// In the order in which they are listed.
    pub rules: &'static [&'static Rule],
}

/// The rules that are checked while a file is read.
const OF_FILES: [Chapter; 3] = [
    Chapter {
        title: "Text",
        rules: reading::RULES,
    },
    Chapter {
        title: "Sections",
        rules: structure::RULES,
    },
    Chapter {
        title: "Values",
        rules: value::RULES,
    },
];

/// The rules of files beside a data sheet.
const OF_OTHER_FILES: [Chapter; 2] = [
    Chapter {
        title: "Bindings",
        rules: binding::RULES,
    },
    Chapter {
        title: "Values for a configuration",
        rules: configuration::OF_VALUES,
    },
];

/// The rules of what other files are made of.
const OF_DESCRIPTIONS: [Chapter; 2] = [
    Chapter {
        title: "Recipes",
        rules: recipe::RULES,
    },
    Chapter {
        title: "Networks",
        rules: network::RULES,
    },
];

/// The rules of the finished model.
const OF_MODELS: [Chapter; 15] = [
    Chapter {
        title: "Objects of CiA 301 and CiA 402",
        rules: standard::check::RULES,
    },
    Chapter {
        title: "Device information",
        rules: communication::device_info::RULES,
    },
    Chapter {
        title: "Device type",
        rules: communication::device_type::RULES,
    },
    Chapter {
        title: "Error control and start-up",
        rules: communication::error_control::RULES,
    },
    Chapter {
        title: "SYNC and emergencies",
        rules: communication::sync::RULES,
    },
    Chapter {
        title: "Storing parameters and programs",
        rules: communication::storage::RULES,
    },
    Chapter {
        title: "COB-IDs",
        rules: communication::cob_id::RULES,
    },
    Chapter {
        title: "Predefined connection set",
        rules: communication::predefined::RULES,
    },
    Chapter {
        title: "PDOs",
        rules: communication::pdo::RULES,
    },
    Chapter {
        title: "PDO mappings",
        rules: communication::mapping::RULES,
    },
    Chapter {
        title: "Configured values",
        rules: configuration::RULES,
    },
    Chapter {
        title: "Drives: objects",
        rules: drive::objects::RULES,
    },
    Chapter {
        title: "Drives: modes",
        rules: drive::modes::RULES,
    },
    Chapter {
        title: "Drives: factors and units",
        rules: drive::units::RULES,
    },
    Chapter {
        title: "Drives: defaults",
        rules: drive::values::RULES,
    },
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
    configuration::check,
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
    modules::check(subject, findings);
}

/// All rules, by what they are about.
pub fn chapters() -> impl Iterator<Item = Chapter> {
    let files = OF_FILES.into_iter().chain(OF_OTHER_FILES);
    files.chain(OF_DESCRIPTIONS).chain(OF_MODELS)
}

/// Whether a rule is about files beside a data sheet; the data sheet can silence it all the same.
pub(crate) fn is_about_other_files(rule: &Rule) -> bool {
    let mut rules = OF_OTHER_FILES.iter().flat_map(|chapter| chapter.rules);
    rules.any(|other| other.name == rule.name)
}

/// Whether a rule is about how a file is written, not about the device in it.
pub(crate) fn is_of_files(rule: &Rule) -> bool {
    let mut rules = OF_FILES.iter().flat_map(|chapter| chapter.rules);
    rules.any(|other| other.name == rule.name)
}

/// All rules.
pub fn all() -> impl Iterator<Item = &'static Rule> {
    chapters().flat_map(|chapter| chapter.rules).copied()
}

/// The rule with this name.
pub fn find(name: &str) -> Option<&'static Rule> {
    all().find(|rule| rule.name == name)
}

#[cfg(test)]
mod tests;

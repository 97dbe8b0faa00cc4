//! What is wrong with a data sheet, in the form compilers use.

mod allowances;
mod beside;
mod render;

use std::fmt;

use crate::rules::Rule;
use crate::source::Span;
use crate::xdd::words::in_words_of_xml;

pub(crate) use allowances::{Allowances, is_allowance, without};
pub(crate) use beside::read as read_beside;
pub use beside::{Exemption, allowances_beside};
pub(crate) use render::render_some;
pub use render::{Colour, render};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The file can be used as it was read.
    Warning,
    /// The file cannot be used.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// One finding. It shows as `file:line:column: error[rule]: message`; [`render()`] shows the line too, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The rule that is broken.
    pub rule: &'static Rule,
    /// How bad it is for what the file is read for.
    pub severity: Severity,
    /// The file as its reader named it.
    pub file: String,
    /// Where.
    pub span: Span,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// Another place that has to do with it, and what is there.
    pub other: Option<(Span, String)>,
}

impl Diagnostic {
    /// Whether another finding says the same, of whichever format.
    pub fn says_what(&self, other: &Self) -> bool {
        let said = in_words_of_xml(&other.message);
        self.rule == other.rule && in_words_of_xml(&self.message).ends_with(&said)
    }

    /// Shows another place too.
    pub(crate) fn also(&mut self, span: Span, what: impl Into<String>) -> &mut Self {
        self.other = Some((span, what.into()));
        self
    }

    /// Whether it is about a character that formatting would lose. The end mark of old systems and NUL say nothing.
    pub fn is_loss(&self) -> bool {
        let says_nothing = ["U+001A", "U+0000"];
        let is_harmless = says_nothing.iter().any(|mark| self.message.contains(mark));
        self.rule == &crate::rules::reading::CONTROL_CHARACTER && !is_harmless
    }

    /// Says what to do.
    pub fn help(&mut self, help: impl Into<String>) {
        self.help = Some(help.into());
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Span { line, column, .. } = self.span;
        let (file, severity, rule) = (&self.file, self.severity, self.rule.name);
        write!(
            f,
            "{file}:{line}:{column}: {severity}[{rule}]: {}",
            self.message
        )
    }
}

impl std::error::Error for Diagnostic {}

/// Why a text cannot be read: what is wrong with it, and what to write in its place where that is plain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mistake {
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Mistake {
    /// The same about a key: `Granularity: ...`.
    pub(crate) fn of(mut self, key: &str) -> Self {
        self.message = format!("{key}: {}", self.message);
        self
    }
}

impl From<String> for Mistake {
    fn from(message: String) -> Self {
        let help = None;
        Self { message, help }
    }
}

/// Collects the findings of one file, so that one run shows them all.
#[derive(Debug)]
pub struct Findings {
    file: String,
    list: Vec<Diagnostic>,
    /// What the file silences.
    allowances: Allowances,
    /// Whether code is to be made of the file.
    is_for_code: bool,
    /// What is allowed from outside.
    exemptions: Vec<Exemption>,
}

impl Findings {
    pub(crate) fn new(file: &str) -> Self {
        Self {
            file: file.into(),
            list: Vec::new(),
            allowances: Allowances::default(),
            is_for_code: false,
            exemptions: Vec::new(),
        }
    }

    /// For a file that code is to be made of: 0 stands in for what it does not state.
    pub(crate) fn for_code(mut self) -> Self {
        self.is_for_code = true;
        self
    }

    /// With what is allowed from outside of the file.
    pub(crate) fn exempting(mut self, exemptions: Vec<Exemption>) -> Self {
        self.exemptions = exemptions;
        self
    }

    /// What is allowed from outside of the file.
    pub(crate) fn exemptions(&self) -> &[Exemption] {
        &self.exemptions
    }

    /// Whether code is to be made of the file.
    pub(crate) fn is_for_code(&self) -> bool {
        self.is_for_code
    }

    /// The file, as its reader named it.
    pub(crate) fn file(&self) -> &str {
        &self.file
    }

    /// Findings of these rules at these places are to be silenced.
    pub(crate) fn allow(&mut self, allowances: Allowances) {
        self.allowances = allowances;
    }

    /// What stands in for a value that breaks a rule here; `None` where the file does not allow it.
    pub(crate) fn allowed<T>(&self, rule: &Rule, span: Span, instead: T) -> Option<T> {
        self.allowances.allow(rule, span).then_some(instead)
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are errors behind the first ones that the file does not silence.
    pub(crate) fn has_errors_after(&self, first: usize) -> bool {
        let mut rest = self.list.iter().skip(first);
        rest.any(|finding| {
            let is_silenced = self.allowances.allow(finding.rule, finding.span);
            finding.severity == Severity::Error && !is_silenced
        })
    }

    /// Whether one of these rules is broken.
    pub(crate) fn has_errors_of(&self, rules: &[&Rule]) -> bool {
        let mut list = self.list.iter();
        list.any(|finding| rules.contains(&finding.rule))
    }

    /// Takes away what is silenced, and returns it with the reasons.
    pub(crate) fn silence(&mut self) -> Vec<(Diagnostic, String)> {
        let allowances = std::mem::take(&mut self.allowances);
        let mut silenced = allowances.apply(self);
        silenced.sort_by_key(|(finding, _)| finding.span);
        silenced
    }

    /// Adds a finding; its severity is the rule's.
    pub(crate) fn report(
        &mut self,
        rule: &'static Rule,
        span: Span,
        message: impl Into<String>,
    ) -> &mut Diagnostic {
        let at = self.list.len();
        self.list.push(Diagnostic {
            rule,
            severity: self.severity(rule),
            file: self.file.clone(),
            span,
            message: message.into(),
            help: None,
            other: None,
        });
        &mut self.list[at]
    }

    /// For more findings of the same file.
    pub(crate) fn same_file(&self) -> Self {
        let is_for_code = self.is_for_code;
        Self {
            is_for_code,
            ..Self::new(&self.file)
        }
    }

    /// Adds findings that are known already.
    pub(crate) fn extend(&mut self, more: impl Iterator<Item = Diagnostic>) {
        self.list.extend(more);
    }

    /// Adds all of another list.
    pub(crate) fn append(&mut self, mut more: Self) {
        self.list.append(&mut more.list);
    }

    /// Makes them findings of one rule.
    pub(crate) fn all_under(&mut self, rule: &'static Rule) {
        let severity = self.severity(rule);
        for finding in &mut self.list {
            (finding.rule, finding.severity) = (rule, severity);
        }
    }

    /// How bad it is to break a rule, for what the file is read for.
    fn severity(&self, rule: &Rule) -> Severity {
        if self.is_for_code {
            rule.severity_for_code
        } else {
            rule.severity
        }
    }

    /// Adds those of another list that are asked for and are not here yet.
    pub(crate) fn merge(&mut self, more: Self, is_for: impl Fn(&Diagnostic) -> bool) {
        for finding in more.list {
            if is_for(&finding) && !self.list.contains(&finding) {
                self.list.push(finding);
            }
        }
    }

    /// The value, or a finding in its place.
    pub(crate) fn take<T, E: Into<Mistake>>(
        &mut self,
        rule: &'static Rule,
        span: Span,
        result: Result<T, E>,
    ) -> Option<T> {
        let mistaken = |mistake: E| {
            let Mistake { message, help } = mistake.into();
            self.report(rule, span, message).help = help;
        };
        result.map_err(mistaken).ok()
    }

    /// All findings in the order of the file.
    pub(crate) fn into_sorted(mut self) -> Vec<Diagnostic> {
        self.list.sort_by_key(|finding| finding.span);
        self.list
    }
}

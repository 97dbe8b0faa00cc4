//! A file with everything that there is to say about it.

use std::collections::HashMap;
use std::path::Path;
use std::{fmt, io};

use crate::diagnostic::{
    Allowances, Colour, Diagnostic, Exemption, Findings, Severity, read_beside, render, render_some,
};
use crate::document::Document;
use crate::model::{FileKind, Model};
use crate::recipe::{self, Recipe};
use crate::rules::{self, Subject, reading};
use crate::source::Source;
use crate::{document, files, parse as parser, xdd};

/// What is known about a file after it has been read and checked.
#[derive(Clone, Debug)]
pub struct Report {
    /// The text that the findings point into.
    pub source: Source,
    /// What the file means, as far as it could be read: whole where there are no errors.
    pub model: Model,
    /// What is wrong, in the order of the file.
    pub findings: Vec<Diagnostic>,
    /// What the file silences, with the reasons it gives.
    pub silenced: Vec<(Diagnostic, String)>,
    /// The variables of the environment that a recipe asks for.
    pub variables: Vec<String>,
}

/// What there is to say about sections.
struct Judged {
    model: Model,
    findings: Vec<Diagnostic>,
    silenced: Vec<(Diagnostic, String)>,
    is_for_code: bool,
}

impl Judged {
    fn of(file: &str, document: &Document<'_>, is_xml: bool, mut findings: Findings) -> Self {
        let allowances = Allowances::read(document, &mut findings);
        findings.allow(allowances);
        let (mut model, broken) = parser::parse(file, document, &mut findings);
        if is_xml {
            model.kind = FileKind::Xdd;
        }
        let subject = Subject {
            model: &model,
            broken: &broken,
        };
        rules::check(&subject, &mut findings);
        let is_for_code = findings.is_for_code();
        let silenced = findings.silence();
        Self {
            model,
            findings: findings.into_sorted(),
            silenced,
            is_for_code,
        }
    }

    /// Leaves out what is said of allowances that silence nothing where they are for what only code asks for.
    fn leave_to_code(&mut self, of_code: impl Fn() -> Vec<Diagnostic>) {
        let is_unused = |finding: &Diagnostic| finding.rule == &reading::UNUSED_ALLOWANCE;
        if !self.is_for_code && self.findings.iter().any(is_unused) {
            let of_code = of_code();
            self.findings
                .retain(|finding| !is_unused(finding) || of_code.contains(finding));
        }
    }

    fn for_each(&mut self, mut change: impl FnMut(&mut Diagnostic)) {
        self.findings.iter_mut().for_each(&mut change);
        let silenced = self.silenced.iter_mut();
        silenced.for_each(|(finding, _)| change(finding));
    }

    fn into_report(self, source: Source, variables: Vec<String>) -> Report {
        Report {
            source,
            model: self.model,
            findings: self.findings,
            silenced: self.silenced,
            variables,
        }
    }
}

impl Report {
    /// Reads and checks a file, in whatever encoding and with whatever line ends it comes. What is allowed beside it is silenced
    /// ([`allowances_beside`](crate::allowances_beside)).
    ///
    /// # Errors
    /// The file, or that of its allowances, cannot be read.
    pub fn read(path: &Path) -> io::Result<Self> {
        Self::read_allowing(path, &[])
    }

    /// The same with more rules that are silenced.
    ///
    /// # Errors
    /// The file, or that of its allowances, cannot be read.
    pub fn read_allowing(path: &Path, exemptions: &[Exemption]) -> io::Result<Self> {
        if recipe::is_recipe(path) {
            return Self::of_recipe(path, exemptions, false);
        }
        let (bytes, findings) = opened(path, exemptions)?;
        Ok(Self::decoded(&bytes, findings))
    }

    /// Reads and checks a file that code is to be made of: 0 stands in for each default that it does not state.
    ///
    /// # Errors
    /// The file, or that of its allowances, cannot be read.
    pub fn read_for_code(path: &Path, exemptions: &[Exemption]) -> io::Result<Self> {
        if recipe::is_recipe(path) {
            return Self::of_recipe(path, exemptions, true);
        }
        let (bytes, findings) = opened(path, exemptions)?;
        Ok(Self::decoded(&bytes, findings.for_code()))
    }

    /// Checks a text that code is to be made of, as [`Report::read_for_code`] does.
    pub fn for_code(file: &str, text: &str) -> Self {
        let mut findings = Findings::new(file).for_code();
        let source = Source::new(file, text, &mut findings);
        Self::of(source, findings)
    }

    /// Checks what a file holds, in whatever encoding and with whatever line ends. `file` is its name, for the findings.
    pub fn of_bytes(file: &str, bytes: &[u8]) -> Self {
        Self::decoded(bytes, Findings::new(file))
    }

    fn decoded(bytes: &[u8], mut findings: Findings) -> Self {
        let file = findings.file().to_owned();
        match Source::decode(&file, bytes, &mut findings) {
            Some(source) => Self::of(source, findings),
            None => Self::unreadable(Source::new(&file, "", &mut Findings::new(&file)), findings),
        }
    }

    /// Checks a text that is at hand. `file` is its name, for the findings.
    pub fn new(file: &str, text: &str) -> Self {
        let mut findings = Findings::new(file);
        let source = Source::new(file, text, &mut findings);
        Self::of(source, findings)
    }

    fn of(source: Source, mut findings: Findings) -> Self {
        let is_xml = xdd::is_xml(source.text());
        let document = if is_xml {
            xdd::read(&source, &mut findings)
        } else {
            Some(document::read(&source, &mut findings))
        };
        let Some(document) = document else {
            return Self::unreadable(source, findings);
        };
        let exemptions = findings.exemptions().to_vec();
        let mut judged = Judged::of(&source.file, &document, is_xml, findings);
        if is_xml {
            judged.for_each(|finding| xdd::words::translate(finding, &source));
        }
        judged.leave_to_code(|| {
            let of_code = Findings::new(&source.file).for_code();
            Self::of(source.clone(), of_code.exempting(exemptions.clone())).findings
        });
        judged.into_report(source, Vec::new())
    }

    /// Checks a data sheet that is made of a base and parts.
    fn of_recipe(path: &Path, exemptions: &[Exemption], is_for_code: bool) -> io::Result<Self> {
        let recipe = Recipe::load(path)?;
        let mut findings = Findings::new(&path.display().to_string());
        if is_for_code {
            findings = findings.for_code();
        }
        let all = recipe.exemptions.iter().chain(exemptions).cloned();
        let mut findings = findings.exempting(all.collect());
        let variables = recipe.variables.clone();
        let Some(document) = recipe.document(&mut findings) else {
            let mut unreadable = Self::unreadable(Source::default(), findings);
            for finding in &mut unreadable.findings {
                recipe.place(finding);
            }
            unreadable.source = recipe.into_source();
            unreadable.model.file.clone_from(&unreadable.source.file);
            return Ok(unreadable);
        };
        let mut judged = Judged::of(recipe.file(), &document, false, findings);
        judged.for_each(|finding| recipe.place(finding));
        judged.leave_to_code(|| {
            let of_code = Self::of_recipe(path, exemptions, true);
            of_code.map_or_else(|_| Vec::new(), |report| report.findings)
        });
        Ok(judged.into_report(recipe.into_source(), variables))
    }

    fn unreadable(source: Source, findings: Findings) -> Self {
        let model = Model {
            file: source.file.clone(),
            ..Model::default()
        };
        Self {
            source,
            model,
            findings: findings.into_sorted(),
            silenced: Vec::new(),
            variables: Vec::new(),
        }
    }

    /// Whether anything of a dictionary could be read: there may be errors all the same.
    pub fn has_model(&self) -> bool {
        let is_fatal =
            |own: &Diagnostic| own.severity == Severity::Error && !own.rule.can_be_allowed;
        let is_fatal = self.findings.iter().any(is_fatal);
        !is_fatal && (!self.model.objects.is_empty() || !self.has_errors())
    }

    /// Whether something is wrong: no code is made of the file then.
    pub fn has_errors(&self) -> bool {
        self.count(Severity::Error) > 0
    }

    /// How many findings are this bad.
    pub fn count(&self, severity: Severity) -> usize {
        let findings = self.findings.iter();
        findings
            .filter(|finding| finding.severity == severity)
            .count()
    }

    /// The findings with their lines, one after the other. Of those that break one rule the first ones are shown, the others counted.
    pub fn render(&self, colour: Colour) -> String {
        let mut lines: HashMap<(&str, &str), Vec<u32>> = HashMap::new();
        for finding in &self.findings {
            let own = lines.entry((&finding.file, finding.rule.name)).or_default();
            own.push(finding.span.line);
        }
        let mut seen: HashMap<(&str, &str), usize> = HashMap::new();
        let mut rendered = Vec::new();
        for finding in &self.findings {
            let place = (finding.file.as_str(), finding.rule.name);
            let number = seen.entry(place).or_default();
            *number += 1;
            let all = lines.get(&place).map_or(&[][..], Vec::as_slice);
            // One more takes no more room than to say that there is one more.
            let is_shown = *number <= SHOWN || all.len() <= SHOWN + 1;
            let others = (*number == SHOWN && all.len() > SHOWN + 1)
                .then(|| others(all.get(SHOWN..).unwrap_or_default()));
            if is_shown {
                let others = others.as_deref();
                rendered.push(render_some(finding, &self.source, colour, others) + "\n");
            }
        }
        rendered.join("\n")
    }

    /// All findings with their lines, one after the other.
    pub fn render_all(&self, colour: Colour) -> String {
        let findings = self.findings.iter();
        let rendered = findings.map(|finding| render(finding, &self.source, colour) + "\n");
        rendered.collect::<Vec<_>>().join("\n")
    }

    /// The model, or the findings when there is an error among them.
    ///
    /// # Errors
    /// All findings, in the order of the file.
    pub fn into_result(self) -> Result<Model, Vec<Diagnostic>> {
        if self.has_errors() {
            Err(self.findings)
        } else {
            Ok(self.model)
        }
    }
}

/// How many findings of one rule are shown.
const SHOWN: usize = 3;
/// How many lines of the others are named.
const NAMED: usize = 8;

/// What there is beside the findings that are shown.
fn others(lines: &[u32]) -> String {
    let named = lines.iter().take(NAMED).map(u32::to_string);
    let named = named.collect::<Vec<_>>().join(", ");
    let more = if lines.len() > NAMED { ", ..." } else { "" };
    format!("{} more like this, on lines {named}{more}", lines.len())
}

/// What a file holds, and room for findings about it.
fn opened(path: &Path, exemptions: &[Exemption]) -> io::Result<(Vec<u8>, Findings)> {
    let bytes = files::read(path)?;
    let mut all = read_beside(path)?;
    all.extend_from_slice(exemptions);
    let findings = Findings::new(&path.display().to_string());
    Ok((bytes, findings.exempting(all)))
}

/// Why there is no model.
#[derive(Debug)]
pub enum ReadError {
    /// The file cannot be read.
    File {
        /// The file.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The file is wrong.
    Findings(Vec<Diagnostic>),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { file, source } => write!(f, "{file}: error: {source}"),
            Self::Findings(findings) => {
                for (number, finding) in findings.iter().enumerate() {
                    let separator = if number == 0 { "" } else { "\n" };
                    write!(f, "{separator}{finding}")?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::File { source, .. } => Some(source),
            Self::Findings(_) => None,
        }
    }
}

/// Reads and checks a data sheet. `file` is its name, for the findings.
///
/// # Errors
/// Everything that is wrong with it, in the order of its lines, when an error is among it.
pub fn parse(file: &str, text: &str) -> Result<Model, Vec<Diagnostic>> {
    Report::new(file, text).into_result()
}

/// Reads and checks a data sheet from a file.
///
/// # Errors
/// The file cannot be read, or everything that is wrong with it when an error is among it.
pub fn read(path: &Path) -> Result<Model, ReadError> {
    let report = Report::read(path).map_err(|source| ReadError::File {
        file: path.display().to_string(),
        source,
    })?;
    report.into_result().map_err(ReadError::Findings)
}

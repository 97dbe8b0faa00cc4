//! Bindings: which objects of a manufacturer stand for which parameters of the drive.
//!
//! A file `*.bind.toml` beside the data sheet lists them. With it the dictionary of another vendor drives the same firmware
//! without code: `parameter = object * scale + offset`, or a list of values for codes. Every line is checked against the data
//! sheet and against the parameters that the drive offers ([`cia402_parameters`]).
//!
//! ```toml
//! [[binding]]
//! object = "2054h"                # index; a sub-index behind a colon
//! parameter = "profile_velocity"
//! scale = "1/10"                  # a whole number or a fraction; 1 if left out
//! offset = 0
//! access = "rw"                   # ro: shows only, wo: is taken only, rw: both
//!
//! [[binding]]
//! object = "2060h:1"
//! parameter = "quick_stop_option_code"
//! values = { 0 = 2, 1 = 6 }       # object = parameter; other values are refused
//!
//! [storage]
//! objects = ["2100h-21FFh"]       # meant to be plain storage: not reported
//!
//! [foreign]
//! objects = ["6082h"]             # means something else than CiA 402 says: storage, unless a binding says what
//!
//! [constants]
//! microsteps = 256                # a parameter that no object stands for
//!
//! [unset]
//! profile_acceleration = 10000    # what counts while its object is 0, which says nothing
//!
//! [habits]                        # what the device does in the way of its maker
//! node_id = 65
//! wrong_signature = 0x08000022
//!
//! [virtual]
//! axis = "servo_100w"             # the ready axis that the virtual drive has
//!
//! [[word]]                        # an object whose bits are facts of the drive
//! object = "1002h"
//! facts = { 0 = "statusword", 16 = "input 3", 17 = "power", 18 = "error 8611h" }
//!
//! [[mask]]                        # an object whose bits are the inputs (or outputs) that have a function of the drive
//! object = "2002h:1"
//! inputs = 3                      # home switch
//!
//! [[error]]                       # how masters are told of an error that the drive has another code for
//! cause = 0x3210
//! code = 0x3110
//! register = 0x04                 # its bits of 1001h
//! info = [1]                      # bytes 3 to 7 of the message
//! ```
//!
//! A finding is silenced by a comment `# od-gen: allow RULE because REASON`: in a table or right above it for that table, above
//! everything else for the whole file, as is the same comment above the first section of the data sheet.

mod check;
mod file;
mod habits;
mod place;
mod unbound;
mod words;

use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use cia402_parameters::Conversion;
use cia402_parameters::{ALL, Description, PROFILE};

pub(crate) use file::comments;
pub use habits::{Habit, KNOWN as HABITS, Known, Owner};
pub(crate) use place::{entry, indices};
pub use words::{ErrorMapping, Fact, Mask, Word};

use crate::diagnostic::{Allowances, Colour, Diagnostic, Findings, Severity, render};
use crate::files;
use crate::generate::snake_case;
use crate::model::{Entry, Model};
use crate::source::Source;

/// One object that stands for a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// The parameter.
    pub parameter: &'static Description,
    /// How their numbers relate.
    pub meaning: Meaning,
    /// Whether a write to the object changes the parameter.
    pub is_taken: bool,
    /// Whether the object follows the parameter.
    pub is_shown: bool,
}

/// All that a file says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bindings {
    /// Objects that stand for parameters.
    pub rows: Vec<Binding>,
    /// Objects of the drive profile that do not mean here what CiA 402 says.
    pub foreign: Vec<RangeInclusive<u16>>,
    /// Parameters that no object stands for, with their numbers.
    pub constants: Vec<(&'static Description, i64)>,
    /// What counts while the object of a parameter is 0.
    pub unset: Vec<(&'static Description, i64)>,
    /// What the device does in the way of its maker.
    pub habits: Vec<Habit>,
    /// The ready axis of the virtual drive; without one it is moved by pulses. The firmware has nothing of it.
    pub axis: Option<String>,
    /// Objects whose bits are facts of the drive.
    pub words: Vec<Word>,
    /// Objects whose bits are inputs or outputs.
    pub masks: Vec<Mask>,
    /// How the maker tells of errors.
    pub errors: Vec<ErrorMapping>,
}

impl Bindings {
    /// Nothing is said.
    pub const NONE: &'static Self = &NONE;

    /// Whether an object does not mean what CiA 402 says.
    pub fn is_foreign(&self, index: u16) -> bool {
        self.foreign.iter().any(|range| range.contains(&index))
    }

    /// The number of a parameter that no object stands for.
    pub fn constant(&self, parameter: &Description) -> Option<i64> {
        number(&self.constants, parameter)
    }

    /// The number that a parameter of this name has before anything is written; `None` where nothing stands for it.
    pub fn initial(&self, model: &Model, name: &str) -> Option<i64> {
        let parameter = ALL.iter().find(|known| known.name == name)?;
        let number = |entry: &Entry| i64::try_from(entry.default_number()?).ok();
        let bound = || {
            let row = self.rows.iter().find(|row| row.parameter == parameter)?;
            let object = number(model.entry(row.index, row.sub)?)?;
            row.meaning.to_parameter(object)
        };
        let own = || number(home(model, parameter)?);
        self.constant(parameter).or_else(bound).or_else(own)
    }

    /// What counts while the object of a parameter is 0.
    pub fn unset(&self, parameter: &Description) -> Option<i64> {
        number(&self.unset, parameter)
    }
}

/// The number of a parameter in a list.
fn number(list: &[(&Description, i64)], parameter: &Description) -> Option<i64> {
    let mut list = list.iter();
    list.find_map(|(own, number)| (*own == parameter).then_some(*number))
}

static NONE: Bindings = Bindings {
    rows: Vec::new(),
    foreign: Vec::new(),
    constants: Vec::new(),
    unset: Vec::new(),
    habits: Vec::new(),
    axis: None,
    words: Vec::new(),
    masks: Vec::new(),
    errors: Vec::new(),
};

/// How the numbers of an object and of its parameter relate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// `parameter = object * numerator / denominator + offset`.
    Scale {
        /// Not 0.
        numerator: i32,
        /// Above 0.
        denominator: i32,
        /// In the unit of the parameter.
        offset: i64,
    },
    /// Pairs of a number of the object and one of the parameter.
    Values(Vec<(i64, i64)>),
}

impl Meaning {
    /// What a number of the object means, as the firmware will have it.
    pub fn to_parameter(&self, object: i64) -> Option<i64> {
        match self {
            Self::Scale {
                numerator,
                denominator,
                offset,
            } => Some(Conversion::new(*numerator, *denominator, *offset).to_parameter(object)),
            Self::Values(pairs) => {
                let found = pairs.iter().find(|(from, _)| *from == object);
                found.map(|(_, to)| *to)
            }
        }
    }
}

/// The bindings of a data sheet, with everything that there is to say about them.
#[derive(Clone, Debug)]
pub struct BindingReport {
    /// The text that the findings point into.
    pub source: Source,
    /// What could be read: all where there are no errors.
    pub bindings: Bindings,
    /// Objects of the manufacturer that stand for nothing: plain storage.
    pub unbound: Vec<u16>,
    /// What is wrong, in the order of the file.
    pub findings: Vec<Diagnostic>,
    /// What is silenced, by comments of the file or of the data sheet, with the reasons given there.
    pub silenced: Vec<(Diagnostic, String)>,
}

impl BindingReport {
    /// Reads the bindings beside a data sheet; `None` where it has none.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn beside(eds: &Path, model: &Model) -> io::Result<Option<Self>> {
        let path = file_beside(eds);
        match files::read_text(&path) {
            Ok(text) => Ok(Some(Self::new(&path.display().to_string(), &text, model))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Checks a text that is at hand. `file` is its name, for the findings.
    pub fn new(file: &str, text: &str, model: &Model) -> Self {
        let mut findings = Findings::new(file);
        let source = Source::new(file, text, &mut findings);
        let comments = comments(&source);
        let allowances = Allowances::beside(&model.remarks, &comments, &mut findings);
        findings.allow(allowances);
        let (bindings, unbound) = match file::read(&source, &mut findings) {
            Some(file) => check::check(&file, &source, model, &mut findings),
            None => Default::default(),
        };
        let silenced = findings.silence();
        Self {
            bindings,
            unbound,
            findings: findings.into_sorted(),
            silenced,
            source,
        }
    }

    /// Whether something is wrong that leaves the file unusable.
    pub fn has_errors(&self) -> bool {
        let mut findings = self.findings.iter();
        findings.any(|finding| finding.severity == Severity::Error)
    }

    /// The findings with their lines, one after the other.
    pub fn render(&self, colour: Colour) -> String {
        let findings = self.findings.iter();
        let rendered = findings.map(|finding| render(finding, &self.source, colour) + "\n");
        rendered.collect::<Vec<_>>().join("\n")
    }
}

/// The object that a parameter has without a binding: that of CiA 402, or one of the manufacturer that is called by the parameter's
/// name.
pub fn home<'a>(model: &'a Model, parameter: &Description) -> Option<&'a Entry> {
    let (index, sub) = parameter.home;
    let entry = model.entry(index, sub)?;
    is_home(entry, parameter).then_some(entry)
}

/// Whether the entry at the place of a parameter's home is its home.
pub(crate) fn is_home(entry: &Entry, parameter: &Description) -> bool {
    let (index, _) = parameter.home;
    let is_meant = index >= PROFILE || snake_case(&entry.name) == parameter.name;
    is_meant && !entry.is_with_application
}

/// The file with the bindings of a data sheet: its name with `.bind.toml` in place of the extension.
pub fn file_beside(eds: &Path) -> PathBuf {
    eds.with_extension("bind.toml")
}

#[cfg(test)]
mod tests;

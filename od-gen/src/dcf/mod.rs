//! From a data sheet to the configuration of one device: a DCF (CiA 306).
//!
//! The data sheet stays what it is; the node gets its number and its bit rate, and the values that are asked for become
//! ParameterValue. What the device would refuse is found before anything is written:
//!
//! ```
//! use od_gen::dcf::{self, Values};
//! use od_gen::model::Commissioning;
//!
//! # let sheet = include_str!("../../tests/data/every.dcf");
//! # let mut model = od_gen::Report::new("every.dcf", sheet).model;
//! let node = Commissioning { node_id: 5, bit_rate: 125, ..Commissioning::default() };
//! dcf::commission(&mut model, node, "pump.dcf");
//! let findings = dcf::apply(&mut model, &Values::new("pump.values", "1017=500\n"));
//! assert!(findings.is_empty());
//! assert!(od_gen::print(&model).contains("ParameterValue=500"));
//! ```

use std::collections::HashMap;
use std::io;
use std::ops::Range;
use std::path::Path;

use crate::data_type::DataType;
use crate::diagnostic::{Allowances, Diagnostic, Findings};
use crate::document::Comment;
use crate::files;
use crate::model::{Commissioning, Entry, FileKind, Model};
use crate::parse::value::{Written, value};
use crate::rules::configuration as rule;
use crate::source::{Source, Span};

/// Values for one device: a line `INDEX=VALUE` or `INDEX:SUB=VALUE` for each, index and sub-index in hexadecimal. Of a DOMAIN
/// it is the file that is loaded into it. A comment `; od-gen: allow RULE because REASON` silences findings, as it does above the first
/// section of the data sheet.
#[derive(Clone, Debug)]
pub struct Values {
    source: Source,
    findings: Vec<Diagnostic>,
}

impl Values {
    /// Values that are at hand. `file` is their name, for the findings.
    pub fn new(file: &str, text: &str) -> Self {
        let mut findings = Findings::new(file);
        let source = Source::new(file, text, &mut findings);
        let findings = findings.into_sorted();
        Self { source, findings }
    }

    /// Values from a file.
    ///
    /// # Errors
    /// The file cannot be read from its disk.
    pub fn read(path: &Path) -> io::Result<Self> {
        let file = path.display().to_string();
        let bytes = files::read(path)?;
        let mut findings = Findings::new(&file);
        let source = Source::decode(&file, &bytes, &mut findings).unwrap_or_default();
        let findings = findings.into_sorted();
        Ok(Self { source, findings })
    }

    /// Its comments, which are for all of its lines.
    fn comments(&self) -> Vec<(Comment<'_>, Option<Range<u32>>)> {
        let lines = (1..).zip(self.source.text().lines());
        let comments = lines.filter_map(|(number, line)| {
            let text = line.trim();
            let comment = text.strip_prefix([';', '#'])?;
            Some((Comment::at(comment, Span::of(number, line, text)), None))
        });
        comments.collect()
    }

    /// The text that the findings point into.
    pub fn source(&self) -> &Source {
        &self.source
    }
}

/// Makes a data sheet the configuration of this node. `file` is the name that the configuration will have.
pub fn commission(model: &mut Model, node: Commissioning, file: &str) {
    if model.kind != FileKind::Dcf {
        model.file_info.last_eds = model.file_info.file_name.clone();
    }
    model.kind = FileKind::Dcf;
    model.file_info.file_name = file.into();
    model.commissioning = Some(node);
}

/// Puts values into a configuration. Returns what is wrong with them, in the order of their lines; what is an error there has
/// not been put.
pub fn apply(model: &mut Model, values: &Values) -> Vec<Diagnostic> {
    // They are to be written: what a device refuses is an error here.
    let mut findings = Findings::new(&values.source.file).for_code();
    let allowances = Allowances::beside(&model.remarks, &values.comments(), &mut findings);
    findings.allow(allowances);
    findings.extend(values.findings.iter().cloned());
    let mut seen = HashMap::new();
    for (number, line) in (1..).zip(values.source.text().lines()) {
        let text = line.trim();
        if text.is_empty() || text.starts_with([';', '#']) {
            continue;
        }
        let Some(assignment) = Assignment::read(number, line, text) else {
            let message = format!("`{text}` is not INDEX=VALUE or INDEX:SUB=VALUE");
            let span = Span::of(number, line, text);
            let finding = findings.report(&rule::VALUE_LINE, span, message);
            finding.help("index and sub-index are hexadecimal: `6081=1000`, `1800:5=100`");
            continue;
        };
        let Assignment { index, sub, .. } = assignment;
        if let Some(first) = seen.insert((index, sub), number) {
            let message = format!("{index:04X}h:{sub:X} has a value on line {first} already");
            findings.report(&rule::VALUE_TWICE, assignment.place, message);
        }
        put(model, &assignment, &mut findings);
    }
    let _ = findings.silence();
    findings.into_sorted()
}

/// One line of values.
pub(crate) struct Assignment<'a> {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    /// Of index and sub-index.
    pub(crate) place: Span,
    pub(crate) text: &'a str,
    pub(crate) span: Span,
}

impl<'a> Assignment<'a> {
    fn read(number: u32, line: &'a str, text: &'a str) -> Option<Self> {
        let (name, value) = text.split_once('=')?;
        let (name, value) = (name.trim(), value.trim());
        let (index, sub) = name.split_once([':', '.']).unwrap_or((name, "0"));
        Some(Self {
            index: u16::try_from(hexadecimal(index)?).ok()?,
            sub: u8::try_from(hexadecimal(sub)?).ok()?,
            place: Span::of(number, line, name),
            text: value,
            span: Span::of(number, line, value),
        })
    }
}

/// A hexadecimal number, as `6081`, `0x6081` or `6081h`.
fn hexadecimal(text: &str) -> Option<u32> {
    let text = text.trim();
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    let digits = digits
        .or_else(|| text.strip_suffix(['h', 'H']))
        .unwrap_or(text);
    let is_right = !digits.is_empty() && digits.chars().all(|digit| digit.is_ascii_hexdigit());
    u32::from_str_radix(digits, 16).ok().filter(|_| is_right)
}

/// Configures one value; leaves it as it is when an error is in the way. Whether it is configured.
pub(crate) fn put(model: &mut Model, assignment: &Assignment<'_>, findings: &mut Findings) -> bool {
    let Assignment {
        index, sub, span, ..
    } = *assignment;
    let node_id = model.commissioning.as_ref().map(|node| node.node_id);
    let place = format!("{index:04X}h:{sub:X}");
    let Some(entry) = entry_of(model, index, sub) else {
        let message = format!("there is no {place} in the data sheet");
        findings.report(&rule::VALUE_OF_NOTHING, assignment.place, message);
        return false;
    };
    if entry.data_type == DataType::Domain {
        entry.download_file = Some(assignment.text.into());
        return true;
    }
    let written = Written {
        key: "the value",
        text: assignment.text,
        span,
    };
    let before = findings.len();
    let value = value(written, entry.data_type, findings)
        .filter(|value| rule::check_value(&place, entry, value, node_id, span, findings));
    let is_right = value.is_some() && !findings.has_errors_after(before);
    if is_right {
        entry.configured = value;
    }
    is_right
}

fn entry_of(model: &mut Model, index: u16, sub: u8) -> Option<&mut Entry> {
    let at = model
        .objects
        .binary_search_by_key(&index, |object| object.index);
    let object = model.objects.get_mut(at.ok()?)?;
    let at = object.entries.binary_search_by_key(&sub, |entry| entry.sub);
    object.entries.get_mut(at.ok()?)
}

#[cfg(test)]
mod tests;

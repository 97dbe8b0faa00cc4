//! The file as TOML has it.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use toml::{Spanned, Value};

use crate::diagnostic::Findings;
use crate::rules::binding;
use crate::source::{Source, Span};

/// A file of bindings.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    /// The tables `[[binding]]`.
    #[serde(default)]
    pub(super) binding: Vec<Spanned<Row>>,
    /// The table `[storage]`.
    #[serde(default)]
    pub(super) storage: Storage,
}

/// One table `[[binding]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    pub(super) object: Spanned<String>,
    pub(super) parameter: Spanned<String>,
    pub(super) scale: Option<Spanned<Value>>,
    pub(super) offset: Option<Spanned<i64>>,
    pub(super) access: Option<Spanned<String>>,
    pub(super) values: Option<Spanned<BTreeMap<String, i64>>>,
}

/// The table `[storage]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Storage {
    /// Objects that are meant to stand for nothing.
    pub(super) objects: Vec<Spanned<String>>,
}

/// Reads the text; what TOML has to say against it is one finding.
pub(super) fn read(source: &Source, findings: &mut Findings) -> Option<File> {
    match toml::from_str(source.text()) {
        Ok(file) => Some(file),
        Err(error) => {
            let span = error
                .span()
                .map_or(Span::START, |range| place(source, range));
            findings.report(&binding::SYNTAX, span, error.message());
            None
        }
    }
}

/// The place of a range of bytes; of more than one line the first.
pub(super) fn place(source: &Source, range: Range<usize>) -> Span {
    let text = source.text();
    let before = text.get(..range.start).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    let length = |text: &str| u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
    let inside = text.get(range).unwrap_or_default();
    Span {
        line: length(&before.replace(|letter| letter != '\n', "")) + 1,
        column: length(before.get(start..).unwrap_or_default()) + 1,
        length: length(inside.lines().next().unwrap_or_default()),
    }
}

//! The file as TOML has it.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use toml::{Spanned, Value};

use crate::diagnostic::Findings;
use crate::document::Comment;
use crate::rules::binding;
use crate::source::{Source, Span};

/// A file of bindings.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    /// The tables `[[binding]]`.
    #[serde(default)]
    pub(super) binding: Vec<Spanned<Row>>,
    /// The table `[storage]`.
    #[serde(default)]
    pub(super) storage: Storage,
    /// The table `[foreign]`.
    #[serde(default)]
    pub(super) foreign: Storage,
    /// The table `[constants]`: parameters without an object.
    #[serde(default)]
    pub(super) constants: BTreeMap<Spanned<String>, Spanned<i64>>,
    /// The table `[unset]`: what counts while an object is 0.
    #[serde(default)]
    pub(super) unset: BTreeMap<Spanned<String>, Spanned<i64>>,
    /// The table `[habits]`.
    #[serde(default)]
    pub(super) habits: BTreeMap<Spanned<String>, Spanned<Value>>,
    /// The table `[virtual]`.
    #[serde(default, rename = "virtual")]
    pub(super) virtual_drive: VirtualDrive,
    /// The tables `[[word]]`.
    #[serde(default)]
    pub(super) word: Vec<Spanned<WordRow>>,
    /// The tables `[[mask]]`.
    #[serde(default)]
    pub(super) mask: Vec<Spanned<MaskRow>>,
    /// The tables `[[error]]`.
    #[serde(default)]
    pub(super) error: Vec<Spanned<ErrorRow>>,
}

/// One table `[[mask]]`: an object whose bits are the inputs or outputs that have a function.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaskRow {
    pub(super) object: Spanned<String>,
    pub(super) inputs: Option<u8>,
    pub(super) outputs: Option<u8>,
}

/// One table `[[word]]`: an object, and what its bits tell.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WordRow {
    pub(super) object: Spanned<String>,
    pub(super) facts: BTreeMap<String, String>,
}

/// One table `[[error]]`: how a maker tells of an error of the drive.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ErrorRow {
    pub(super) cause: u16,
    pub(super) code: u16,
    #[serde(default)]
    pub(super) register: u8,
    #[serde(default)]
    pub(super) info: Vec<u8>,
    #[serde(default)]
    pub(super) history: u16,
    pub(super) number_byte: Option<u8>,
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

/// The tables `[storage]` and `[foreign]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Storage {
    /// Objects that are meant to stand for nothing, or for something else than CiA 402 says.
    pub(super) objects: Vec<Spanned<String>>,
}

/// The table `[virtual]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VirtualDrive {
    pub(super) axis: Option<String>,
}

/// The comments that take a line of their own, each with the lines of its table. Those above a table, without a blank line between, belong
/// to it; those above everything else belong to the whole file and have no lines.
pub(crate) fn comments(source: &Source) -> Vec<(Comment<'_>, Option<Range<u32>>)> {
    let mut comments: Vec<(Comment<'_>, Option<Range<u32>>)> = Vec::new();
    // The line of the first comment above which something else stands, and of the table's head.
    let (mut above, mut table) = (None, None);
    let mut tables: Vec<u32> = Vec::new();
    for (number, line) in (1..).zip(source.text().lines()) {
        let text = line.trim();
        if let Some(comment) = text.strip_prefix('#') {
            above.get_or_insert(number);
            let lines = table.map(|table| table..u32::MAX);
            comments.push((Comment::at(comment, Span::of(number, line, text)), lines));
            continue;
        }
        if text.starts_with('[') {
            let start = above.unwrap_or(number);
            for (comment, lines) in &mut comments {
                if comment.span.line >= start {
                    *lines = Some(start..u32::MAX);
                }
            }
            tables.push(start);
            table = Some(start);
        }
        above = None;
    }
    for (_, lines) in &mut comments {
        if let Some(lines) = lines {
            let next = tables.iter().find(|start| **start > lines.start);
            lines.end = next.copied().unwrap_or(u32::MAX);
        }
    }
    comments
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
            findings.allowed(&binding::SYNTAX, span, File::default())
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

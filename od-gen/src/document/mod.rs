//! A data sheet as sections, keys and comments (the INI layer of CiA 306), each with its place.
//!
//! Nothing is dropped: comments stay where they stand, so that a file can be printed again. Names are compared without regard
//! to case, as CiA 306 asks.

mod order;
mod read;
mod write;

use std::borrow::Cow;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

use crate::diagnostic::Findings;
use crate::rules::reading;
use crate::source::Span;

pub(crate) use order::{SECTIONS, canonical, identity};
pub(crate) use read::{read, read_all};
pub(crate) use write::write;

/// A file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Document<'a> {
    /// Comments above the first section.
    pub(crate) head: Vec<Comment<'a>>,
    /// In the order of the file, each name once.
    pub(crate) sections: Vec<Section<'a>>,
}

/// `[name]` and what follows it.
#[derive(Clone, Debug)]
pub(crate) struct Section<'a> {
    /// Comments right above it, after a blank line.
    pub(crate) lead: Vec<Comment<'a>>,
    pub(crate) name: Cow<'a, str>,
    /// `[name]`.
    pub(crate) span: Span,
    /// Its lines, those of `lead` among them.
    pub(crate) lines: Range<u32>,
    /// The lines of other files that say more of it, in a recipe.
    pub(crate) also: Vec<Range<u32>>,
    pub(crate) keys: Vec<Key<'a>>,
    pub(crate) comments: Vec<Comment<'a>>,
}

impl Document<'_> {
    /// Of a section that is there twice, however its name is spelled, the first one stays; the others are reported, and become
    /// comments behind what stands above them where nothing may be lost.
    pub(crate) fn keep_first(&mut self, keeps_all: bool, findings: &mut Findings) {
        if keeps_all {
            self.quote_others();
        }
        let mut first = HashMap::new();
        self.sections.retain(|section| {
            let (name, span) = (&section.name, section.span);
            let line = match first.entry(identity(name)) {
                Entry::Vacant(place) => {
                    place.insert(span.line);
                    return true;
                }
                Entry::Occupied(place) => *place.get(),
            };
            let message = format!("the section [{name}] is already on line {line}");
            let finding = findings.report(&reading::REPEATED_SECTION, span, message);
            finding.help("only the first one counts: remove one of them");
            finding.also(
                Span {
                    line,
                    ..Span::START
                },
                "the first one",
            );
            false
        });
    }

    /// Makes comments of the sections that do not count.
    fn quote_others(&mut self) {
        let mut seen = HashSet::new();
        let mut kept: Vec<Section<'_>> = Vec::new();
        for section in std::mem::take(&mut self.sections) {
            if seen.insert(identity(&section.name)) {
                kept.push(section);
                continue;
            }
            let Some(above) = kept.last_mut() else {
                continue;
            };
            let position = above.keys.len();
            let mut quote = |text: &str| {
                let quoted = Comment::new(left_out(text), position);
                above.comments.push(quoted);
            };
            quote(&format!("[{}]", section.name));
            for key in &section.keys {
                quote(&format!("{}={}", key.name, key.value));
            }
            for comment in section.lead.iter().chain(&section.comments) {
                quote(&comment.text);
            }
        }
        self.sections = kept;
    }
}

/// What a line that means nothing becomes; no tool takes it for a note.
fn left_out(text: &str) -> String {
    format!(" left out: {text}")
}

impl<'a> Section<'a> {
    /// A key that has a value; `key=` counts as absent.
    pub(crate) fn key(&self, name: &str) -> Option<&Key<'a>> {
        self.keys
            .iter()
            .find(|key| key.name.eq_ignore_ascii_case(name) && !key.value.is_empty())
    }
}

/// `key=value`.
#[derive(Clone, Debug)]
pub(crate) struct Key<'a> {
    pub(crate) name: Cow<'a, str>,
    pub(crate) value: Cow<'a, str>,
    /// The name.
    pub(crate) name_span: Span,
    /// The value.
    pub(crate) span: Span,
}

impl<'a> Section<'a> {
    /// A section that is in no file.
    pub(crate) fn new(name: impl Into<Cow<'a, str>>) -> Self {
        Self {
            lead: Vec::new(),
            name: name.into(),
            span: Span::default(),
            lines: 0..0,
            also: Vec::new(),
            keys: Vec::new(),
            comments: Vec::new(),
        }
    }

    /// Adds `name=value`.
    pub(crate) fn put(&mut self, name: impl Into<Cow<'a, str>>, value: impl Into<Cow<'a, str>>) {
        self.keys.push(Key {
            name: name.into(),
            value: value.into(),
            name_span: Span::default(),
            span: Span::default(),
        });
    }

    /// Adds `;text` below the keys that are there.
    pub(crate) fn remark(&mut self, text: impl Into<Cow<'a, str>>) {
        self.comments.push(Comment::new(text, self.keys.len()));
    }
}

/// `; text`.
#[derive(Clone, Debug)]
pub(crate) struct Comment<'a> {
    /// What follows the `;`.
    pub(crate) text: Cow<'a, str>,
    pub(crate) span: Span,
    /// How many keys of its section stand above it.
    pub(crate) position: usize,
}

impl<'a> Comment<'a> {
    /// A comment that is in no file.
    pub(crate) fn new(text: impl Into<Cow<'a, str>>, position: usize) -> Self {
        Self {
            text: text.into(),
            span: Span::default(),
            position,
        }
    }

    /// A comment at this place.
    pub(crate) fn at(text: &'a str, span: Span) -> Self {
        Self {
            text: text.into(),
            span,
            position: 0,
        }
    }

    /// What a comment of the form `;Name=value` says: CiA 306 has no keys for it, and tools complain about keys that are not in it.
    pub(crate) fn note(&self) -> Option<(&str, &str)> {
        let (name, value) = self.text.split_once('=')?;
        let (name, value) = (name.trim(), value.trim());
        let is_name = !name.is_empty() && name.bytes().all(|letter| letter.is_ascii_alphanumeric());
        is_name.then_some((name, value))
    }
}

//! A data sheet as sections, keys and comments (the INI layer of CiA 306), each with its place.
//!
//! Nothing is dropped: comments stay where they stand, so that a file can be printed again. Names are compared without regard
//! to case, as CiA 306 asks.

mod read;

use std::borrow::Cow;
use std::ops::Range;

use crate::source::Span;

pub(crate) use read::read;

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
    pub(crate) keys: Vec<Key<'a>>,
    pub(crate) comments: Vec<Comment<'a>>,
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

/// `; text`.
#[derive(Clone, Debug)]
pub(crate) struct Comment<'a> {
    /// What follows the `;`.
    pub(crate) text: Cow<'a, str>,
    pub(crate) span: Span,
    /// How many keys of its section stand above it.
    pub(crate) position: usize,
}

//! A recipe as TOML has it.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::{Spanned, Value};

/// A recipe.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) base: Part,
    #[serde(default)]
    pub(super) part: Vec<Part>,
    /// Keys of the table `[identity]`.
    #[serde(default)]
    pub(super) identity: BTreeMap<Spanned<String>, Spanned<Value>>,
    /// Values and their defaults.
    #[serde(default)]
    pub(super) defaults: BTreeMap<Spanned<String>, Spanned<Value>>,
}

/// The table `[base]`, or one `[[part]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Part {
    /// A data sheet of any format, or a recipe; from the folder of this one. A part that only removes has none.
    pub(super) eds: Option<Spanned<String>>,
    /// What is taken of it; all where nothing is said.
    pub(super) objects: Option<Vec<Spanned<String>>>,
    /// What goes away: of what there was before, or of the base.
    #[serde(default)]
    pub(super) remove: Vec<Spanned<String>>,
}

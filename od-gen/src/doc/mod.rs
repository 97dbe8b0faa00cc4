//! The dictionary reference that a user prints: one HTML page that needs nothing else, or Markdown.
//!
//! Both are made from the same `view`, so that they say the same.

mod pdo;
mod value;
mod view;

use std::fmt::Display;

use askama::Template;

use crate::model::Model;
use view::View;

/// The page for a browser and for paper: contents, search, PDO defaults and every object, in one file.
pub fn html(model: &Model) -> String {
    rendered(&Html {
        view: View::of(model),
    })
}

/// The same in Markdown.
pub fn markdown(model: &Model) -> String {
    rendered(&Markdown {
        view: View::of(model),
    })
}

#[derive(Template)]
#[template(path = "dictionary.html")]
struct Html {
    view: View,
}

#[derive(Template)]
#[template(path = "dictionary.md", escape = "none")]
struct Markdown {
    view: View,
}

/// Writing into memory does not fail, and the templates hold nothing else that can.
fn rendered(template: &impl Template) -> String {
    let mut text = template.render().unwrap_or_default();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    text
}

/// What the templates may do to a value.
mod filters {
    use super::{Display, cell_text};

    /// A text as one cell of a Markdown table.
    #[askama::filter_fn]
    pub(super) fn cell(text: impl Display, _: &dyn askama::Values) -> askama::Result<String> {
        Ok(cell_text(&text.to_string()))
    }
}

/// Text in which nothing is taken for Markdown, on one line.
fn cell_text(text: &str) -> String {
    let mut cell = String::with_capacity(text.len());
    for letter in text.chars() {
        if matches!(
            letter,
            '\\' | '|' | '*' | '_' | '`' | '[' | ']' | '<' | '>' | '#'
        ) {
            cell.push('\\');
        }
        cell.push(letter);
    }
    cell
}

#[cfg(test)]
mod tests;

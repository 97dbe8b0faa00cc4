//! Document type definitions: read, and kept from blowing up.
//!
//! An XML file may define abbreviations, entities, and use them as `&name;`. Entities that stand for others let a kilobyte grow to
//! gigabytes, and so does a long one that is used often: both are refused. What lies outside of the file is never looked at.

use std::ops::Range;

/// The most bytes that all uses of entities may take.
const MOST_BYTES: usize = 1 << 24;

/// What every XML file may use without a definition.
const PREDEFINED: [&str; 6] = ["amp;", "lt;", "gt;", "quot;", "apos;", "#"];

/// Why the entities of a file are too much, and where that stands.
pub(super) fn mistake(text: &str) -> Option<(Range<usize>, String)> {
    let mut longest = 0;
    let mut first = 0..0;
    for (at, start) in text.match_indices("<!ENTITY") {
        let rest = text.get(at + start.len()..).unwrap_or_default();
        let declaration = rest
            .split_once('>')
            .map_or(rest, |(declaration, _)| declaration);
        let name = declaration.split_whitespace().find(|word| *word != "%");
        let name = name.unwrap_or_default();
        let value = quoted(rest);
        let place = at..at + start.len();
        if has_entity(value) {
            let message = format!("the entity `{name}` stands for other entities");
            return Some((place, message));
        }
        if value.len() > longest {
            (longest, first) = (value.len(), place);
        }
    }
    let uses = text.matches('&').count();
    let is_too_much = longest.saturating_mul(uses) > MOST_BYTES;
    is_too_much.then(|| (first, "the entities of this file make it too large".into()))
}

/// What stands between the first two quotation marks of a kind.
fn quoted(text: &str) -> &str {
    let marked = text.find(['"', '\'']).and_then(|at| text.get(at..));
    let Some(marked) = marked else { return "" };
    let mut parts = marked.splitn(3, if marked.starts_with('"') { '"' } else { '\'' });
    parts.nth(1).unwrap_or_default()
}

/// Whether a text uses an entity of the file. An `&` that is written as a number could begin one.
fn has_entity(text: &str) -> bool {
    text.match_indices('&').any(|(at, _)| {
        let rest = text.get(at + 1..).unwrap_or_default();
        let is_plain = PREDEFINED.iter().any(|known| rest.starts_with(known));
        !is_plain
            || ["#38;", "#x26;", "#X26;", "#0"]
                .iter()
                .any(|mark| rest.starts_with(mark))
    })
}

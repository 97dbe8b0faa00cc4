//! Findings as a person reads them: file, line and column, the line itself, and what to do.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use super::{Diagnostic, Severity};
use crate::rules::Class;
use crate::source::{Source, Span};

/// Whether to use colours; only a terminal shows them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colour {
    /// Plain text.
    #[default]
    Never,
    /// With the escape sequences of a terminal.
    Always,
}

/// A finding with its line.
pub fn render(finding: &Diagnostic, source: &Source, colour: Colour) -> String {
    render_some(finding, source, colour, None)
}

/// A finding with its line, and a word about others of its kind that are not shown.
pub(crate) fn render_some(
    finding: &Diagnostic,
    source: &Source,
    colour: Colour,
    others: Option<&str>,
) -> String {
    let renderer = match colour {
        Colour::Never => Renderer::plain(),
        Colour::Always => Renderer::styled(),
    };
    let level = match finding.severity {
        Severity::Warning => Level::WARNING,
        Severity::Error => Level::ERROR,
    };
    let snippet = |span: Span, kind: AnnotationKind, label| {
        let line = source.of(&finding.file).line(span.line).unwrap_or_default();
        let range = range(line, span);
        Snippet::source(line)
            .path(&finding.file)
            .line_start(usize::try_from(span.line).unwrap_or(1))
            .annotation(kind.span(range).label(label))
    };
    // What breaks the standard needs no word.
    let class = match finding.rule.class {
        Class::Standard => None,
        Class::Masters => Some("masters expect it otherwise"),
        Class::Firmware => Some("a limit of this firmware"),
        Class::Advice => Some("advice"),
    };
    let first = snippet(finding.span, AnnotationKind::Primary, class);
    let mut group = level
        .primary_title(&finding.message)
        .id(finding.rule.name)
        .element(first);
    if let Some((span, what)) = &finding.other {
        group = group.element(snippet(*span, AnnotationKind::Context, Some(what.as_str())));
    }
    if let Some(help) = &finding.help {
        group = group.element(Level::HELP.message(help));
    }
    if let Some(others) = others {
        group = group.element(Level::NOTE.message(others));
    }
    renderer.render(&[group])
}

/// The bytes of a line that a span covers.
fn range(line: &str, span: Span) -> std::ops::Range<usize> {
    let column = usize::try_from(span.column.saturating_sub(1)).unwrap_or_default();
    let length = usize::try_from(span.length).unwrap_or_default();
    let offset = |characters: usize| {
        let letter = line.char_indices().nth(characters);
        letter.map_or(line.len(), |(at, _)| at)
    };
    offset(column)..offset(column.saturating_add(length))
}

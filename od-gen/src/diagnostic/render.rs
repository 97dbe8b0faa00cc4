//! Findings as a person reads them: file, line and column, the line itself, and what to do.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use super::{Diagnostic, Severity};
use crate::source::Source;

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
    let renderer = match colour {
        Colour::Never => Renderer::plain(),
        Colour::Always => Renderer::styled(),
    };
    let level = match finding.severity {
        Severity::Warning => Level::WARNING,
        Severity::Error => Level::ERROR,
    };
    let line = source.line(finding.span.line).unwrap_or_default();
    let column = usize::try_from(finding.span.column.saturating_sub(1)).unwrap_or_default();
    let length = usize::try_from(finding.span.length).unwrap_or_default();
    let offset = |characters: usize| {
        let letter = line.char_indices().nth(characters);
        letter.map_or(line.len(), |(at, _)| at)
    };
    let span = offset(column)..offset(column.saturating_add(length));
    let snippet = Snippet::source(line)
        .path(&finding.file)
        .line_start(usize::try_from(finding.span.line).unwrap_or(1))
        .annotation(AnnotationKind::Primary.span(span));
    let mut group = level
        .primary_title(&finding.message)
        .id(finding.rule.name)
        .element(snippet);
    if let Some(help) = &finding.help {
        group = group.element(Level::HELP.message(help));
    }
    renderer.render(&[group])
}

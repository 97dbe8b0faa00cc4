//! Recipes: a data sheet made of a base and parts, so that a family of devices shares what it has in common.
//!
//! A recipe is TOML. It names the base, parts that add to it or override it, what goes away, and the identity, which can come from the
//! environment of a build. A recipe stands wherever a data sheet does; a base or a part can be one itself. Findings name the file and
//! the line of the part that they come from.
//!
//! ```toml
//! [base]
//! eds = "drive.eds"
//! remove = ["20D0h-20D3h"]        # objects, ranges of them, or one sub-index (2050h:3)
//!
//! [[part]]
//! eds = "brake.eds"               # a section that is there already gets the keys that this one states
//! objects = ["2100h-210Fh"]       # all of it where nothing is said
//!
//! [identity]
//! product_code = "$PRODUCT_CODE"  # of the environment; or a number
//!
//! [defaults]
//! "6098h" = 35
//! ```
//!
//! While it is read every part has lines of its own: those of its file, behind those of the parts before it.

mod file;
mod merge;

use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Exemption, Findings, read_beside};
use crate::document::{self, Document};
use crate::rules::recipe as rule;
use crate::source::{Source, Span};
use crate::{files, xdd};
use file::File;
use merge::Merged;

/// How deep recipes are made of recipes.
const DEEPEST: usize = 8;
/// Of how many files, each as often as it is named.
const MOST: usize = 256;

/// Whether a path names a recipe.
pub(crate) fn is_recipe(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// A file of a recipe, with the place of its lines among those of all.
#[derive(Debug)]
struct Piece {
    source: Source,
    /// What is added to its lines.
    offset: u32,
    /// What was found while it was decoded.
    findings: Vec<Diagnostic>,
}

/// What a piece is.
#[derive(Debug)]
enum Node {
    Sheet(usize),
    /// A recipe, and what it is made of: the base and the parts.
    Recipe(usize, Box<File>, Vec<Option<Node>>),
}

/// A recipe with all of its files.
#[derive(Debug)]
pub(crate) struct Recipe {
    pieces: Vec<Piece>,
    root: Option<Node>,
    /// What could not be loaded.
    findings: Vec<Diagnostic>,
    /// The variables of the environment that it asks for.
    pub(crate) variables: Vec<String>,
    /// What is allowed beside it and beside its parts.
    pub(crate) exemptions: Vec<Exemption>,
}

impl Recipe {
    /// Loads a recipe and all of its parts.
    ///
    /// # Errors
    /// The recipe itself cannot be read; a part that cannot is a finding.
    pub(crate) fn load(path: &Path) -> std::io::Result<Self> {
        let bytes = files::read(path)?;
        let mut recipe = Self {
            pieces: Vec::new(),
            root: None,
            findings: Vec::new(),
            variables: Vec::new(),
            exemptions: Vec::new(),
        };
        recipe.root = recipe.add(path, &bytes, &mut Vec::new());
        for piece in &recipe.pieces {
            let beside = read_beside(Path::new(&piece.source.file))?;
            recipe.exemptions.extend(beside);
        }
        recipe.variables.sort();
        recipe.variables.dedup();
        Ok(recipe)
    }

    /// Adds a file and what it is made of. `above` are the recipes that it is a part of.
    fn add(&mut self, path: &Path, bytes: &[u8], above: &mut Vec<PathBuf>) -> Option<Node> {
        let name = path.display().to_string();
        let mut findings = Findings::new(&name);
        let source = Source::decode(&name, bytes, &mut findings).unwrap_or_default();
        let last = self.pieces.last();
        let offset = last.map_or(0, |piece| piece.offset + piece.source.line_count());
        let at = self.pieces.len();
        self.pieces.push(Piece {
            source: source.clone(),
            offset,
            findings: findings.into_sorted(),
        });
        if !is_recipe(path) {
            return Some(Node::Sheet(at));
        }
        let file: File = match toml::from_str(source.text()) {
            Ok(file) => file,
            Err(error) => {
                let span = error.span().map_or(Span::START, |range| source.span(range));
                self.report(at, &rule::SYNTAX, span, error.message());
                return None;
            }
        };
        above.push(path.to_owned());
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut parts = Vec::new();
        for (number, part) in std::iter::once(&file.base).chain(&file.part).enumerate() {
            let Some(eds) = &part.eds else {
                if number == 0 {
                    let message = "[base] has no `eds`";
                    self.report(at, &rule::PART, Span::START, message);
                }
                parts.push(None);
                continue;
            };
            let span = source.span(eds.span());
            let path = folder.join(eds.get_ref());
            if above.contains(&path) || above.len() >= DEEPEST {
                let message = format!("`{}` is made of itself", eds.get_ref());
                self.report(at, &rule::PART, span, message);
                parts.push(None);
                continue;
            }
            if self.pieces.len() >= MOST {
                let message = format!("the recipe is made of more than {MOST} files");
                self.report(at, &rule::PART, span, message);
                break;
            }
            let node = match files::read(&path) {
                Ok(bytes) => self.add(&path, &bytes, above),
                Err(error) => {
                    let error = error.to_string();
                    let reason = error.split(" (os error").next().unwrap_or_default();
                    let message = format!("{}: {reason}", path.display());
                    self.report(at, &rule::PART, span, message);
                    None
                }
            };
            parts.push(node);
        }
        above.pop();
        for value in file.identity.values() {
            let variable = value
                .get_ref()
                .as_str()
                .and_then(|text| text.strip_prefix('$'));
            self.variables.extend(variable.map(str::to_owned));
        }
        Some(Node::Recipe(at, Box::new(file), parts))
    }

    fn report(
        &mut self,
        piece: usize,
        rule: &'static crate::rules::Rule,
        span: Span,
        message: impl Into<String>,
    ) {
        let Some(piece) = self.pieces.get(piece) else {
            return;
        };
        let mut findings = Findings::new("");
        findings.report(rule, shifted(span, piece.offset), message);
        self.findings.extend(findings.into_sorted());
    }

    /// All files as one, as far as they could be read; each line stands behind those of the pieces before it.
    pub(crate) fn document(&self, findings: &mut Findings) -> Option<Document<'_>> {
        findings.extend(self.findings.iter().cloned());
        for piece in &self.pieces {
            let found = piece.findings.iter().cloned();
            findings.extend(found.map(|finding| moved(finding, piece.offset)));
        }
        let merged = self.merge(self.root.as_ref()?, findings)?;
        Some(merged.into_document())
    }

    fn merge<'a>(&'a self, node: &'a Node, findings: &mut Findings) -> Option<Merged<'a>> {
        match node {
            Node::Sheet(at) => {
                let piece = self.pieces.get(*at)?;
                let mut own = Findings::new(&piece.source.file);
                let document = if xdd::is_xml(piece.source.text()) {
                    xdd::read(&piece.source, &mut own)
                } else {
                    Some(document::read(&piece.source, &mut own))
                };
                let own = own.into_sorted().into_iter();
                findings.extend(own.map(|finding| moved(finding, piece.offset)));
                let mut document = document?;
                shift(&mut document, piece.offset);
                Some(Merged::new(document))
            }
            Node::Recipe(at, file, parts) => {
                let piece = self.pieces.get(*at)?;
                let place = |range| shifted(piece.source.span(range), piece.offset);
                let mut parts = parts.iter();
                let base = parts.next()?.as_ref()?;
                let mut merged = self.merge(base, findings)?;
                merged.select(&file.base, &place, findings);
                merged.remove(&file.base, &place, findings);
                for (part, node) in file.part.iter().zip(parts) {
                    merged.remove(part, &place, findings);
                    if let Some(node) = node {
                        let mut more = self.merge(node, findings)?;
                        more.select(part, &place, findings);
                        merged.add(more);
                    }
                }
                merged.identify(file, &place, findings);
                merged.put_defaults(file, &place, findings);
                let comments = crate::bind::comments(&piece.source);
                for (mut comment, _) in comments {
                    comment.span = shifted(comment.span, piece.offset);
                    merged.remark(comment);
                }
                Some(merged)
            }
        }
    }

    /// The piece that a line is of.
    fn piece(&self, line: u32) -> Option<&Piece> {
        let behind = (self.pieces).partition_point(|piece| piece.offset < line.max(1));
        self.pieces.get(behind.checked_sub(1)?)
    }

    /// Gives a finding the file and the line that it is about, and the words of that file.
    pub(crate) fn place(&self, finding: &mut Diagnostic) {
        let Some(piece) = self.piece(finding.span.line) else {
            return;
        };
        if let Some((span, what)) = finding.other.take()
            && let Some(other) = self.piece(span.line)
        {
            let line = span.line.saturating_sub(other.offset);
            if other.offset == piece.offset {
                finding.other = Some((Span { line, ..span }, what));
            } else {
                let file = &other.source.file;
                finding.message += &format!(" ({file}:{line}: {what})");
            }
        }
        finding.span.line = finding.span.line.saturating_sub(piece.offset);
        finding.file.clone_from(&piece.source.file);
        if xdd::is_xml(piece.source.text()) {
            xdd::words::translate(finding, &piece.source);
        }
    }

    /// The texts that the findings point into: the recipe with its parts.
    pub(crate) fn into_source(self) -> Source {
        let mut sources = self.pieces.into_iter().map(|piece| piece.source);
        let mut source = sources.next().unwrap_or_default();
        source.set_parts(sources.collect());
        source
    }

    /// The name of the recipe.
    pub(crate) fn file(&self) -> &str {
        self.pieces.first().map_or("", |piece| &piece.source.file)
    }
}

fn shifted(mut span: Span, offset: u32) -> Span {
    span.line = span.line.saturating_add(offset);
    span
}

fn moved(mut finding: Diagnostic, offset: u32) -> Diagnostic {
    finding.span = shifted(finding.span, offset);
    if let Some((span, _)) = &mut finding.other {
        *span = shifted(*span, offset);
    }
    finding
}

/// Moves everything behind the lines of the pieces before.
fn shift(document: &mut Document<'_>, offset: u32) {
    for comment in &mut document.head {
        comment.span = shifted(comment.span, offset);
    }
    for section in &mut document.sections {
        section.span = shifted(section.span, offset);
        if !section.lines.is_empty() {
            section.lines.start = section.lines.start.saturating_add(offset);
            section.lines.end = section.lines.end.saturating_add(offset);
        }
        for comment in section.lead.iter_mut().chain(&mut section.comments) {
            comment.span = shifted(comment.span, offset);
        }
        for key in &mut section.keys {
            key.span = shifted(key.span, offset);
            key.name_span = shifted(key.name_span, offset);
        }
    }
}

#[cfg(test)]
mod tests;

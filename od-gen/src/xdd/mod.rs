//! Data sheets in XML (CiA 311, XDD 1.1; XDC for a configured device) as a [`Document`].
//!
//! An XDD says in other words what an EDS says, so it is put into the words of an EDS: each object becomes the section that it
//! would have there, and every key points at the attribute it came from. All that is asked of an EDS is asked of it then.
//! What an object refers to by `uniqueIDRef` (access, default, limits, unit) is looked up in the list of parameters.
//!
//! An XML comment `od-gen: allow RULE because REASON` silences findings, inside of an object or above everything else.

mod device;
mod entities;
mod object;
mod text;
pub(crate) mod words;
mod write;

use std::collections::HashMap;

use roxmltree::{Document as Xml, Node, ParsingOptions};

use crate::diagnostic::Findings;
use crate::document::{Comment, Document, Key, Section};
use crate::rules::reading;
use crate::source::{Source, Span, has_extension};
use text::one_line;
pub use write::write;

/// Whether a text is XML rather than a list of keys.
pub(crate) fn is_xml(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// Reads an XDD; `None` when it is none, which has then been reported.
pub(crate) fn read<'a>(source: &'a Source, findings: &mut Findings) -> Option<Document<'a>> {
    if let Some((place, message)) = entities::mistake(source.text()) {
        let finding = findings.report(&reading::NOT_XML, source.span(place), message);
        finding.help("write out what the entities stand for");
        return None;
    }
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let xml = match Xml::parse_with_options(source.text(), options) {
        Ok(xml) => xml,
        Err(error) => {
            let position = error.pos();
            use roxmltree::Error::{UnclosedRootNode, UnexpectedEndOfStream};
            let end = matches!(error, UnexpectedEndOfStream | UnclosedRootNode);
            let span = Span {
                line: if end {
                    u32::try_from(source.text().lines().count()).unwrap_or(u32::MAX)
                } else {
                    position.row.clamp(1, source.line_count())
                },
                column: position.col.max(1),
                length: 1,
            };
            findings.report(&reading::NOT_XML, span, error.to_string());
            return None;
        }
    };
    let root = xml.root();
    let reader = Reader {
        source,
        parameters: parameters(&xml),
        is_configured: has_extension(&source.file, "xdc") || has_node_id(root) || has_values(root),
    };
    let Some(list) = find(root, "CANopenObjectList") else {
        let message = "there is no CANopenObjectList";
        findings.report(&reading::NOT_XML, Span::START, message);
        return None;
    };
    let mut document = Document {
        head: reader.comments(root, |node| node.ancestors().any(|above| above == list)),
        sections: reader.device(root),
    };
    document.sections.extend(reader.objects(list));
    document.keep_first(false, findings);
    Some(document)
}

/// Whether the device has been given its node-ID: 0 is none.
fn has_node_id(root: Node<'_, '_>) -> bool {
    let node = find(root, "deviceCommissioning");
    let node_id = node.and_then(|node| node.attribute("nodeID"));
    node_id.is_some_and(|node_id| node_id.trim() != "0")
}

/// Whether anything is configured: tools write the values of a device that is for no node yet.
fn has_values(root: Node<'_, '_>) -> bool {
    let mut values = root.descendants().filter_map(|node| match node {
        node if is(node, "actualValue") => node.attribute("value"),
        node => node.attribute("actualValue"),
    });
    values.any(|value| !value.trim().is_empty())
}

/// The parameters that objects refer to, by their uniqueID.
fn parameters<'x>(xml: &'x Xml<'x>) -> HashMap<&'x str, Node<'x, 'x>> {
    let all = xml.descendants().filter(|node| is(*node, "parameter"));
    all.filter_map(|node| Some((node.attribute("uniqueID")?, node)))
        .collect()
}

fn is(node: Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// The first element of this name, in whatever namespace.
fn find<'x>(node: Node<'x, 'x>, name: &str) -> Option<Node<'x, 'x>> {
    node.descendants().find(|node| is(*node, name))
}

struct Reader<'a, 'x> {
    source: &'a Source,
    parameters: HashMap<&'x str, Node<'x, 'x>>,
    /// Whether the file describes one device: it is an XDC, has a node-ID, or values.
    is_configured: bool,
}

impl<'a, 'x> Reader<'a, 'x> {
    /// The comments below a node, but for those that something else has.
    fn comments(
        &self,
        node: Node<'_, 'x>,
        has_another: impl Fn(Node<'_, 'x>) -> bool,
    ) -> Vec<Comment<'a>> {
        let comments = node.descendants().filter(Node::is_comment);
        comments
            .filter(|node| !has_another(*node))
            .map(|node| Comment {
                text: one_line(node.text().unwrap_or_default()).into(),
                span: self.source.span(node.range()),
                position: 0,
            })
            .collect()
    }

    /// A section with the place of an element.
    fn section(&self, name: String, node: Node<'_, '_>) -> Section<'a> {
        let mut section = Section::new(name);
        let range = node.range();
        let tag = range.start..range.start + 1 + node.tag_name().name().len();
        section.span = self.source.span(tag);
        let end = self.source.span(range.end..range.end).line;
        section.lines = section.span.line..end.saturating_add(1);
        section
    }

    /// Adds `key=value` with the place of an attribute, where the element has it and `spell` knows how to write it.
    fn put(
        &self,
        section: &mut Section<'a>,
        key: &'static str,
        (node, attribute): (Node<'_, '_>, &str),
        spell: impl Fn(&str) -> String,
    ) {
        let found = node.attributes().find(|found| found.name() == attribute);
        let Some(found) = found else { return };
        let value = one_line(found.value());
        if value.is_empty() {
            return;
        }
        let span = self.source.span(found.range_value());
        section.keys.push(Key {
            name: key.into(),
            value: spell(&value).into(),
            name_span: span,
            span,
        });
    }
}

/// As it is.
fn as_it_is(value: &str) -> String {
    value.to_owned()
}

/// A number in hexadecimal that does not say so; what is none stays as it is.
fn hexadecimal(value: &str) -> String {
    let is_bare = !value.is_empty() && value.chars().all(|digit| digit.is_ascii_hexdigit());
    if is_bare {
        format!("0x{value}")
    } else {
        value.to_owned()
    }
}

/// `true` and `false` as data sheets write them. Some tools shout.
fn flag(value: &str) -> String {
    match value.to_ascii_lowercase().as_str() {
        "true" => "1".into(),
        "false" => "0".into(),
        _ => value.into(),
    }
}

#[cfg(test)]
mod tests;

//! From a [`Model`] to the text of a data sheet (CiA 306), in canonical form.
//!
//! What is read again is the same model. Compact notations are written out, comments stand at the top of their sections. An allowance of
//! what is put right by that is left out.

mod allowances;
mod device;
mod modules;
mod object;
pub(crate) mod value;

use crate::diagnostic::{Diagnostic, Findings};
use crate::document::{self, Comment, Document, Section};
use crate::model::{FileKind, Model};
use crate::source::Source;
use allowances::{unused_in, without_unused};

/// Writes a model as an EDS; as a DCF when it is the configuration of one device.
pub fn print(model: &Model) -> String {
    let sections = sections(model);
    let document = Document {
        head: (model.remarks.0.iter())
            .map(|remark| Comment::new(remark, 0))
            .collect(),
        sections,
    };
    let file = match model.kind {
        FileKind::Dcf => "printed.dcf",
        FileKind::Eds | FileKind::Xdd => "printed.eds",
    };
    let text = document::write(&document::canonical(document));
    without_unused(file, text, &[])
}

/// The sections of a model.
pub(crate) fn sections(model: &Model) -> Vec<Section<'_>> {
    let mut sections = device::sections(model);
    modules::write(model, &mut sections);
    sections.extend(lists(model));
    for object in model.types.iter().chain(&model.objects) {
        object::write(object, &mut sections);
    }
    sections
}

/// The three lists of objects.
fn lists(model: &Model) -> Vec<Section<'static>> {
    let is_mandatory = |index: &u16| matches!(index, 0x1000 | 0x1001 | 0x1018);
    let is_manufacturers = |index: &u16| (0x2000..=0x5FFF).contains(index);
    let all = || model.objects.iter().map(|object| object.index);
    let mandatory = all().filter(is_mandatory).collect();
    let optional = all().filter(|index| !is_mandatory(index) && !is_manufacturers(index));
    let manufacturers = all().filter(is_manufacturers).collect();
    let lists: [(_, Vec<u16>); 3] = [
        ("MandatoryObjects", mandatory),
        ("OptionalObjects", optional.collect()),
        ("ManufacturerObjects", manufacturers),
    ];
    let sections = lists.into_iter().map(|(name, indices)| {
        let mut section = Section::new(name);
        section.put("SupportedObjects", indices.len().to_string());
        for (number, index) in (1..).zip(indices) {
            section.put(format!("{number}"), format!("0x{index:04X}"));
        }
        section
    });
    sections.collect()
}

/// Brings a data sheet into canonical form: spelling, order of sections and keys, blank lines. Comments stay, and so does
/// everything that is not known. The text means the same as before, and formatting it again changes nothing.
///
/// # Errors
/// What is wrong with the text where formatting it would lose something.
pub fn format(file: &str, text: &str) -> Result<String, Vec<Diagnostic>> {
    let mut findings = Findings::new(file);
    let source = Source::new(file, text, &mut findings);
    formatted(&source, findings)
}

/// Formats what a file holds.
pub(crate) fn formatted(
    source: &Source,
    mut findings: Findings,
) -> Result<String, Vec<Diagnostic>> {
    let document = document::read_all(source, &mut findings);
    let findings = findings.into_sorted();
    // Control characters are gone by now: a file without them would come out shorter than it went in.
    let is_loss = Diagnostic::is_loss;
    if findings.iter().any(is_loss) {
        return Err(findings.into_iter().filter(is_loss).collect());
    }
    let text = document::write(&document::canonical(document));
    let before = unused_in(&source.file, source.text());
    Ok(without_unused(&source.file, text, &before))
}

#[cfg(test)]
pub(crate) mod tests;

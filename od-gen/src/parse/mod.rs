//! From the text of a data sheet to its [`Model`].
//!
//! Each step reports what it finds and goes on, so that one run shows every mistake of a file. A step whose material is broken
//! stays silent: the mistake behind it has been reported already.

mod compact;
mod compact_pdo;
mod device;
mod entry;
mod lists;
mod modules;
mod objects;
mod orphans;
mod sections;
pub(crate) mod value;

use std::collections::BTreeSet;

use crate::data_type::DataType;
use crate::diagnostic::{Findings, is_allowance};
use crate::document::{Comment, Document};
use crate::model::{Entry, FileKind, Model};
use crate::rules::value as rule;
use crate::source::Span;
pub(crate) use device::{COMMISSIONING_KEYS, DEVICE_INFO_KEYS, FILE_INFO_KEYS};
pub(crate) use entry::LEAST_CAPACITY;
pub(crate) use modules::module_name;
use sections::Sections;

/// The longest value that an SDO transfer of the firmware keeps, in bytes: its staging buffer, `SDO_BUFFER` of the crate `canopen`.
/// What can be written and is longer is served by the application, piece by piece.
pub const LARGEST_VALUE: u16 = 128;

/// The most bytes of RAM, or of flash, that the values of one dictionary take: descriptors hold 16-bit offsets.
const LARGEST_DICTIONARY: usize = 0xFFFF;

/// Objects and values that are in the file, but could not be read: nobody should call them missing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Broken {
    pub(crate) objects: BTreeSet<u16>,
    pub(crate) entries: BTreeSet<(u16, u8)>,
}

impl Broken {
    /// Whether a value is there that could not be read.
    pub(crate) fn has(&self, index: u16, sub: u8) -> bool {
        self.objects.contains(&index) || self.entries.contains(&(index, sub))
    }
}

/// Reads the sections of a file.
pub(crate) fn parse(
    file: &str,
    document: &Document<'_>,
    findings: &mut Findings,
) -> (Model, Broken) {
    let sections = Sections::sort(document, file, findings);
    let mut broken = Broken::default();
    let mut model = Model {
        file: file.into(),
        kind: if sections.is_dcf {
            FileKind::Dcf
        } else {
            FileKind::Eds
        },
        file_info: device::file_info(&sections, findings),
        device: device::device_info(&sections, findings),
        commissioning: device::commissioning(&sections, findings),
        dummies: device::dummies(&sections, findings),
        comments: device::lines(sections.comments),
        dynamic_channels: device::dynamic_channels(&sections, findings),
        tools: device::tools(&sections),
        remarks: entry::remarks(document.head.iter().chain(allowances_of_sections(document))),
        ..Model::default()
    };
    objects::read(&sections, &mut model, &mut broken, findings);
    compact_pdo::expand(&mut model, &broken);
    modules::read(&sections, &mut model, &mut broken, findings);
    lists::check(&sections, findings);
    check_room(&mut model, findings);
    if findings.is_for_code() {
        stand_in(&mut model);
    }
    (model, broken)
}

/// Gives every number the default that the device starts with.
fn stand_in(model: &mut Model) {
    let objects = model.objects.iter_mut();
    for entry in objects.flat_map(|object| &mut object.entries) {
        if entry.default.is_none() && entry.data_type.size().is_some() {
            entry.default = Some(entry.initial());
        }
    }
}

/// Allowances in sections of which the model keeps no comments: they are for the whole file when it is printed.
fn allowances_of_sections<'a>(document: &'a Document<'a>) -> impl Iterator<Item = &'a Comment<'a>> {
    let sections = document.sections.iter();
    let sections = sections.filter(|section| !sections::is_object(&section.name));
    let comments = sections.flat_map(|section| section.lead.iter().chain(&section.comments));
    comments.filter(|comment| is_allowance(comment))
}

/// Whether the values and their limits find room in 16-bit offsets. What does not goes to the application, where that is allowed.
fn check_room(model: &mut Model, findings: &mut Findings) {
    // The application keeps what it streams: DOMAINs, and long strings that can be written.
    let is_kept = |entry: &Entry| {
        let is_streamed = entry.size > LARGEST_VALUE && entry.access.is_writable();
        !(is_streamed || entry.data_type == DataType::Domain || entry.is_with_application)
    };
    let is_limited = |entry: &Entry| entry.low_limit.is_some() || entry.high_limit.is_some();
    let (mut values, mut limits) = (0, 0);
    let (mut are_values_too_large, mut are_limits_too_large) = (false, false);
    let is_allowed = findings
        .allowed(&rule::DICTIONARY_TOO_LARGE, Span::START, ())
        .is_some();
    for object in &mut model.objects {
        for entry in &mut object.entries {
            let size = usize::from(entry.size);
            if is_kept(entry) {
                let is_too_large = values + size + 2 > LARGEST_DICTIONARY;
                are_values_too_large |= is_too_large;
                if is_too_large && is_allowed && object.index >= 0x2000 {
                    entry.is_with_application = true;
                    entry.storage = None;
                    entry.pdo_mapping = false;
                } else {
                    values += size + 2;
                }
            }
            // Two for each; their place is counted in pairs of bytes.
            if is_limited(entry) {
                let is_too_large = limits + size > LARGEST_DICTIONARY;
                are_limits_too_large |= is_too_large;
                if is_too_large && is_allowed {
                    (entry.low_limit, entry.high_limit) = (None, None);
                } else {
                    limits += size;
                }
            }
        }
    }
    for (is_too_large, message) in [
        (
            are_values_too_large,
            "the values of the dictionary take more than 64 KiB",
        ),
        (
            are_limits_too_large,
            "the limits of the dictionary take more than 128 KiB",
        ),
    ] {
        if is_too_large {
            findings.report(&rule::DICTIONARY_TOO_LARGE, Span::START, message);
        }
    }
}

#[cfg(test)]
mod tests;

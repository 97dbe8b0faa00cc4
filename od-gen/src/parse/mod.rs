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
mod sections;
pub(crate) mod value;

use std::collections::BTreeSet;

use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::document::Document;
use crate::model::{FileKind, Model};
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
        remarks: entry::remarks(document.head.iter()),
        ..Model::default()
    };
    objects::read(&sections, &mut model, &mut broken, findings);
    compact_pdo::expand(&mut model, &broken);
    modules::read(&sections, &mut model, &mut broken, findings);
    lists::check(&sections, findings);

    // The application keeps what it streams: DOMAINs, and long strings that can be written.
    let kept = model.entries().filter(|(_, entry)| {
        let is_long = entry.size > LARGEST_VALUE;
        let is_streamed = is_long && entry.access.is_writable();
        !(is_streamed || entry.data_type == DataType::Domain || entry.is_with_application)
    });
    let sizes = kept.map(|(_, entry)| usize::from(entry.size) + 2);
    if sizes.sum::<usize>() > LARGEST_DICTIONARY {
        let message = "the values of the dictionary take more than 64 KiB";
        findings.report(&rule::DICTIONARY_TOO_LARGE, Span::START, message);
    }
    // Two limits for each, and their place is counted in pairs of bytes.
    let limited = model.entries().map(|(_, entry)| entry);
    let limited = limited.filter(|entry| entry.low_limit.is_some() || entry.high_limit.is_some());
    let sizes = limited.map(|entry| usize::from(entry.size));
    if sizes.sum::<usize>() > LARGEST_DICTIONARY {
        let message = "the limits of the dictionary take more than 128 KiB";
        findings.report(&rule::DICTIONARY_TOO_LARGE, Span::START, message);
    }
    (model, broken)
}

#[cfg(test)]
mod tests;

//! From the text of a data sheet to a checked [`Model`].
//!
//! Each step reports what it finds and goes on, so that one run shows every mistake of a file. A step whose material is broken
//! stays silent: the mistake behind it has been reported already.

mod cob_ids;
mod communication;
mod device_info;
mod entry;
mod lists;
mod objects;
mod pdo_mapping;
mod sections;

use crate::diagnostic::{Diagnostic, Findings};
use crate::ini;
use crate::model::Model;
use sections::Sections;

/// The longest value that an SDO transfer of the firmware can carry, in bytes: its staging buffer, `SDO_BUFFER` of the crate
/// `canopen`.
pub const LARGEST_VALUE: u16 = 128;

/// The most bytes of RAM, or of flash, that the values of one dictionary take: descriptors hold 16-bit offsets.
const LARGEST_DICTIONARY: usize = 0xFFFF;

/// Reads a data sheet. `file` is its name, for the findings.
///
/// # Errors
/// Everything that is wrong with it, in the order of its lines.
pub fn parse(file: &str, text: &str) -> Result<Model, Vec<Diagnostic>> {
    let mut findings = Findings::new(file);
    let sections = ini::read(text, &mut findings);
    let sections = Sections::sort(&sections, &mut findings);

    let objects = objects::read(&sections, &mut findings);
    lists::check(&sections, &mut findings);
    let device = device_info::read(&sections, &objects, &mut findings);
    communication::check(&sections, &objects, &mut findings);
    cob_ids::check(&sections, &objects, &mut findings);
    pdo_mapping::check(&sections, &objects, &mut findings);

    let values = objects.list.iter().flat_map(|object| &object.entries);
    if values
        .map(|entry| usize::from(entry.size) + 2)
        .sum::<usize>()
        > LARGEST_DICTIONARY
    {
        findings.error(1, "the values of the dictionary take more than 64 KiB");
    }

    let findings = findings.into_sorted();
    if findings.is_empty() {
        Ok(Model {
            file: file.into(),
            device,
            objects: objects.list,
        })
    } else {
        Err(findings)
    }
}

#[cfg(test)]
mod tests;

//! MandatoryObjects, OptionalObjects, ManufacturerObjects: what is listed has a section, what has a section is listed.

use std::collections::BTreeMap;

use super::sections::Sections;
use crate::diagnostic::Findings;
use crate::ini::Section;
use crate::number::Number;

/// The objects that every device has (CiA 306, MandatoryObjects).
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];

#[derive(Clone, Copy, PartialEq, Eq)]
enum List {
    Mandatory,
    Optional,
    Manufacturer,
}

impl List {
    fn name(self) -> &'static str {
        match self {
            Self::Mandatory => "MandatoryObjects",
            Self::Optional => "OptionalObjects",
            Self::Manufacturer => "ManufacturerObjects",
        }
    }

    /// The list in which an object belongs.
    fn of(index: u16) -> Self {
        match index {
            _ if MANDATORY.contains(&index) => Self::Mandatory,
            0x2000..=0x5FFF => Self::Manufacturer,
            _ => Self::Optional,
        }
    }
}

pub(super) fn check(sections: &Sections<'_>, findings: &mut Findings) {
    let mut listed = BTreeMap::new();
    for (list, section) in [
        (List::Mandatory, sections.mandatory),
        (List::Optional, sections.optional),
        (List::Manufacturer, sections.manufacturer),
    ] {
        if let Some(section) = section {
            read(list, section, &mut listed, findings);
        }
    }
    for (index, line) in &listed {
        if !sections.objects.contains_key(index) {
            findings.error(
                *line,
                format!("{index:04X}h is listed, but there is no section [{index:04X}]"),
            );
        }
    }
    for (index, section) in &sections.objects {
        if !listed.contains_key(index) {
            let list = List::of(*index).name();
            findings.error(
                section.line,
                format!("{index:04X}h is not listed in [{list}]"),
            );
        }
    }
    for index in MANDATORY {
        // Listed without a section, or the other way round, has been reported.
        if !listed.contains_key(&index) && !sections.objects.contains_key(&index) {
            findings.error(1, format!("the mandatory object {index:04X}h is missing"));
        }
    }
}

/// Reads one list into `listed`: index and line.
fn read(list: List, section: &Section, listed: &mut BTreeMap<u16, usize>, findings: &mut Findings) {
    let (mut count, mut next) = (0, 1);
    for key in &section.keys {
        let line = key.line;
        if key.name.eq_ignore_ascii_case("SupportedObjects") {
            continue;
        }
        let number = Number::parse(&key.name).map(|number| number.value).ok();
        if number != Some(next) {
            findings.error(
                line,
                format!("`{}` where number {next} of the list should be", key.name),
            );
        }
        count += 1;
        next = number.unwrap_or(next) + 1;
        let index = Number::parse(&key.value)
            .ok()
            .and_then(|number| u16::try_from(number.value).ok());
        let Some(index) = index.filter(|index| *index >= 0x1000) else {
            findings.error(
                line,
                format!("`{}` is not an index (0x1000 to 0xFFFF)", key.value),
            );
            continue;
        };
        if let Some(first) = listed.insert(index, line) {
            findings.error(
                line,
                format!("{index:04X}h is already listed on line {first}"),
            );
        } else if List::of(index) != list {
            findings.error(
                line,
                format!("{index:04X}h belongs in [{}]", List::of(index).name()),
            );
        }
    }
    match section.key("SupportedObjects") {
        None => findings.error(
            section.line,
            format!("`SupportedObjects` is missing in [{}]", section.name),
        ),
        Some(key) => match Number::parse(&key.value) {
            Ok(number) if number.value == count => {}
            Ok(_) => findings.error(
                key.line,
                format!("SupportedObjects is {}, but {count} are listed", key.value),
            ),
            Err(message) => findings.error(key.line, message),
        },
    }
}

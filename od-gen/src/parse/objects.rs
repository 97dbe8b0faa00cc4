//! The sections of the objects and of their sub-indices.

use std::collections::BTreeSet;

use super::entry::{self, ENTRY_KEYS};
use super::sections::{Sections, check_keys};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::ini::Section;
use crate::model::{Access, Entry, Object, ObjectType};
use crate::number::Number;

/// What could be read.
#[derive(Debug, Default)]
pub(super) struct Objects {
    /// By index; entries that are broken are left out.
    pub(super) list: Vec<Object>,
    /// Entries with findings of their own, so that nobody calls them missing.
    broken: BTreeSet<(u16, u8)>,
}

impl Objects {
    pub(super) fn object(&self, index: u16) -> Option<&Object> {
        self.list.iter().find(|object| object.index == index)
    }

    pub(super) fn entry(&self, index: u16, sub: u8) -> Option<&Entry> {
        self.object(index)?
            .entries
            .iter()
            .find(|entry| entry.sub == sub)
    }

    /// Whether an entry is really not there; one that could not be read is.
    pub(super) fn lacks(&self, index: u16, sub: u8) -> bool {
        self.entry(index, sub).is_none() && !self.broken.contains(&(index, sub))
    }
}

pub(super) fn read(sections: &Sections<'_>, findings: &mut Findings) -> Objects {
    let mut objects = Objects::default();
    for (index, section) in &sections.objects {
        let Some(object_type) = object_type(section, findings) else {
            objects
                .broken
                .extend((0..=u8::MAX).map(|sub| (*index, sub)));
            continue;
        };
        let entries = match object_type {
            ObjectType::Var => read_variable(*index, section, &mut objects.broken, findings),
            ObjectType::Array | ObjectType::Record => {
                read_subs(*index, section, sections, &mut objects.broken, findings)
            }
        };
        let name = section.key("ParameterName").map_or("", |key| &key.value);
        let object = Object {
            index: *index,
            name: name.into(),
            object_type,
            entries,
            line: section.line,
        };
        check_sub_numbers(&object, section, sections, &objects.broken, findings);
        objects.list.push(object);
    }
    for ((index, _), section) in &sections.subs {
        if !sections.objects.contains_key(index) {
            findings.error(
                section.line,
                format!(
                    "[{}] has no object: there is no section [{index:04X}]",
                    section.name
                ),
            );
        }
    }
    objects
}

fn object_type(section: &Section, findings: &mut Findings) -> Option<ObjectType> {
    let Some(key) = section.key("ObjectType") else {
        return Some(ObjectType::Var);
    };
    match Number::parse(&key.value).map(|number| number.value) {
        Ok(7) => Some(ObjectType::Var),
        Ok(8) => Some(ObjectType::Array),
        Ok(9) => Some(ObjectType::Record),
        Ok(2) => {
            findings.error(key.line, "ObjectType DOMAIN is not supported");
            None
        }
        Ok(_) => {
            findings.error(
                key.line,
                format!(
                    "ObjectType {} is not 0x7 (VAR), 0x8 (ARRAY) or 0x9 (RECORD)",
                    key.value
                ),
            );
            None
        }
        Err(message) => {
            findings.error(key.line, message);
            None
        }
    }
}

fn read_variable(
    index: u16,
    section: &Section,
    broken: &mut BTreeSet<(u16, u8)>,
    findings: &mut Findings,
) -> Vec<Entry> {
    check_keys(
        section,
        &[&ENTRY_KEYS[..], &["SubNumber", "CompactSubObj"]].concat(),
        findings,
    );
    let entry = entry::read(section, 0, findings);
    if entry.is_none() {
        broken.insert((index, 0));
    }
    entry.into_iter().collect()
}

fn read_subs(
    index: u16,
    section: &Section,
    sections: &Sections<'_>,
    broken: &mut BTreeSet<(u16, u8)>,
    findings: &mut Findings,
) -> Vec<Entry> {
    check_keys(
        section,
        &[
            "ParameterName",
            "ObjectType",
            "SubNumber",
            "CompactSubObj",
            "ObjFlags",
        ],
        findings,
    );
    entry::parameter_name(section, findings);
    entry::check_object_flags(section, findings);
    let mut entries = Vec::new();
    for ((_, sub), section) in sections.subs.range((index, 0)..=(index, u8::MAX)) {
        if *sub == u8::MAX {
            findings.error(section.line, "sub-index FFh is reserved");
        }
        if let Some(key) = section.key("ObjectType")
            && Number::parse(&key.value).is_ok_and(|number| number.value != 7)
        {
            findings.error(
                key.line,
                format!("ObjectType of a sub-index is 0x7 (VAR), not {}", key.value),
            );
        }
        check_keys(section, &ENTRY_KEYS, findings);
        match entry::read(section, *sub, findings) {
            Some(entry) => entries.push(entry),
            None => _ = broken.insert((index, *sub)),
        }
    }
    entries
}

/// SubNumber, CompactSubObj, sub-index 0 and what an ARRAY asks of its elements.
fn check_sub_numbers(
    object: &Object,
    section: &Section,
    sections: &Sections<'_>,
    broken: &BTreeSet<(u16, u8)>,
    findings: &mut Findings,
) {
    let index = object.index;
    if let Some(key) = section.key("CompactSubObj")
        && Number::parse(&key.value).is_ok_and(|number| number.value != 0)
    {
        findings.error(
            key.line,
            "CompactSubObj is not supported: write the sub-indices out",
        );
        return;
    }
    let subs: Vec<u8> = sections
        .subs
        .range((index, 0)..=(index, u8::MAX))
        .map(|((_, sub), _)| *sub)
        .collect();
    let sub_number = section.key("SubNumber");
    match sub_number.map(|key| (key.line, Number::parse(&key.value))) {
        Some((line, Err(message))) => findings.error(line, message),
        Some((line, Ok(number))) if number.value != subs.len() as i128 => {
            findings.error(
                line,
                format!(
                    "SubNumber is {}, but {index:04X}h has {} sub sections",
                    number.value,
                    subs.len()
                ),
            );
        }
        None if object.object_type != ObjectType::Var => {
            findings.error(
                section.line,
                format!("`SubNumber` is missing in [{}]", section.name),
            );
        }
        None if !subs.is_empty() => findings.error(
            section.line,
            format!("{index:04X}h is a VAR: it has no sub-indices"),
        ),
        Some((line, Ok(number))) if object.object_type == ObjectType::Var && number.value != 0 => {
            findings.error(
                line,
                format!("{index:04X}h is a VAR: it has no sub-indices"),
            );
        }
        _ => {}
    }
    if object.object_type == ObjectType::Var || broken.contains(&(index, 0)) {
        return;
    }
    let Some(first) = object.entries.first().filter(|entry| entry.sub == 0) else {
        findings.error(section.line, format!("{index:04X}h has no sub-index 0"));
        return;
    };
    check_highest(
        index,
        first,
        subs.last().copied().unwrap_or_default(),
        findings,
    );
    if object.object_type == ObjectType::Array {
        let mut elements = object.entries.iter().skip(1);
        if let Some(model) = elements.next() {
            for odd in elements.filter(|entry| entry.data_type != model.data_type) {
                let (is, should) = (odd.data_type.name(), model.data_type.name());
                findings.error(
                    odd.line,
                    format!(
                        "an ARRAY has one type: {index:04X}h:{:X} is {is}, not {should}",
                        odd.sub
                    ),
                );
            }
        }
    }
}

/// Sub-index 0 is the number of the highest one; where it can change (1003h, PDO mappings), it is not above it.
fn check_highest(index: u16, first: &Entry, highest: u8, findings: &mut Findings) {
    if first.data_type != DataType::Unsigned8 {
        findings.error(
            first.line,
            format!(
                "{index:04X}h:0 is {}, not UNSIGNED8",
                first.data_type.name()
            ),
        );
        return;
    }
    let default = first.default_number().unwrap_or_default();
    let is_fixed = matches!(first.access, Access::Constant | Access::ReadOnly) && index != 0x1003;
    if is_fixed && default != i128::from(highest) {
        findings.error(
            first.line,
            format!("{index:04X}h:0 is {default}, but the highest sub-index is {highest}"),
        );
    } else if default > i128::from(highest) {
        findings.error(
            first.line,
            format!("{index:04X}h:0 is {default}, above the highest sub-index {highest}"),
        );
    }
}

//! CompactSubObj: an object whose sub-indices are all alike is described once (CiA 306, 4.6.3).
//!
//! `[2000]` with `CompactSubObj=8` stands for sub-index 0 and eight others with the type, access, limits and default of the
//! object; they are called by its name and their number. `[2000Name]`, `[2000Value]` and `[2000Denotation]` list those that
//! differ. A value is a default in an EDS and a configured value in a DCF.

use super::Broken;
use super::entry::{self, Context};
use super::lists::check_count;
use super::sections::{CompactList, Sections};
use super::value::{self, Written};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::document::Section;
use crate::model::{Access, DefaultValue, Entry, Field, Object, Places};
use crate::number::Number;
use crate::rules::structure as rule;

/// Fills in the entries of an object that has `count` sub-indices beside sub-index 0.
pub(super) fn expand(
    object: &mut Object,
    section: &Section<'_>,
    sections: &Sections<'_>,
    count: u8,
    broken: &mut Broken,
    findings: &mut Findings,
) {
    let context = Context {
        index: object.index,
        sub: 1,
        is_dcf: sections.is_dcf,
        is_domain: false,
        is_compact: true,
        is_extension: false,
        types: &sections.types,
    };
    let Some(model) = entry::read(section, context, findings) else {
        broken.objects.insert(object.index);
        return;
    };
    let mut first = Entry::new(0, "NrOfObjects", DataType::Unsigned8);
    first.access = Access::ReadOnly;
    first.default = Some(DefaultValue::number(count.into()));
    first.places = Places::new(section.span);
    object.entries = vec![first];
    for sub in 1..=count {
        let mut entry = model.clone();
        entry.sub = sub;
        entry.name = format!("{}{sub}", object.name);
        object.entries.push(entry);
    }
    read_list(
        CompactList::Name,
        object,
        sections,
        findings,
        |entry, text, _| {
            entry.name = text.text.into();
            entry.places.put(Field::ParameterName, text.span);
        },
    );
    read_list(
        CompactList::Denotation,
        object,
        sections,
        findings,
        |entry, text, _| {
            entry.denotation = Some(text.text.into());
            entry.places.put(Field::Denotation, text.span);
        },
    );
    let is_dcf = sections.is_dcf;
    read_list(
        CompactList::Value,
        object,
        sections,
        findings,
        |entry, text, findings| {
            let value = value::value(text, entry.data_type, findings);
            if is_dcf {
                entry.configured = value;
                entry.places.put(Field::ParameterValue, text.span);
            } else {
                entry.default = value;
                entry.places.put(Field::DefaultValue, text.span);
                entry::check_default(entry, Some(text.text), findings);
            }
        },
    );
    // Once for all of them.
    let is_open = |entry: &&Entry| entry.sub > 0 && entry.default.is_none();
    if let Some(entry) = object.entries.iter().find(is_open) {
        entry::check_constant(entry, section.span, findings);
    }
}

/// Calls `take` for each sub-index in one of the lists.
fn read_list(
    list: CompactList,
    object: &mut Object,
    sections: &Sections<'_>,
    findings: &mut Findings,
    take: impl Fn(&mut Entry, Written<'_>, &mut Findings),
) {
    let Some(section) = sections.compact.get(&(object.index, list)) else {
        return;
    };
    let mut count = 0;
    for key in &section.keys {
        if key.name.eq_ignore_ascii_case("NrOfEntries") {
            continue;
        }
        count += 1;
        let sub = Number::parse(&key.name).ok();
        let sub = sub.and_then(|number| u8::try_from(number.value).ok());
        let found = sub.filter(|sub| *sub > 0).and_then(|sub| {
            let mut entries = object.entries.iter_mut();
            entries.find(|entry| entry.sub == sub)
        });
        let Some(entry) = found else {
            let (name, index) = (&key.name, object.index);
            let message = format!("`{name}` is no sub-index of {index:04X}h");
            findings.report(&rule::COMPACT_LIST, key.name_span, message);
            continue;
        };
        if !key.value.is_empty() {
            let written = Written {
                key: &key.name,
                text: &key.value,
                span: key.span,
            };
            take(entry, written, findings);
        }
    }
    check_count(section, "NrOfEntries", count, findings);
}

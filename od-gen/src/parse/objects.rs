//! The sections of the objects and of their sub-indices.

use super::entry::{self, Context};
use super::sections::{Sections, number};
use super::{Broken, compact, orphans};
use crate::data_type::DataType;
use crate::diagnostic::{Findings, Mistake};
use crate::document::Section;
use crate::model::{Access, DefaultValue, Entry, Field, Model, Object, ObjectType, Places};
use crate::number::Number;
use crate::rules::structure as rule;
use crate::source::Span;

/// Fills in the types and the objects of the model.
pub(super) fn read(
    sections: &Sections<'_>,
    model: &mut Model,
    broken: &mut Broken,
    findings: &mut Findings,
) {
    for (index, section) in &sections.objects {
        let object = read_object(*index, section, sections, broken, findings);
        // Nothing is left of it, which has been reported.
        let is_empty = object.entries.is_empty() && broken.has(*index, 0);
        if is_empty {
            broken.objects.insert(*index);
            continue;
        }
        let defines_type = matches!(
            object.object_type,
            ObjectType::DefType | ObjectType::DefStruct
        );
        let is_type_index = *index < 0x1000;
        if defines_type != is_type_index {
            let span = object.places.of(Field::ObjectType);
            let message = if is_type_index {
                format!("{index:04X}h is below 1000h: it must be a DEFTYPE or a DEFSTRUCT")
            } else {
                format!("{index:04X}h defines a data type: it must be below 1000h")
            };
            findings.report(&rule::TYPE_DEFINITION, span, message);
        }
        if defines_type {
            model.types.push(object);
        } else if !is_type_index {
            model.objects.push(object);
        }
    }
    orphans::read(sections, model, broken, findings);
    for ((index, _), section) in &sections.compact {
        let object = sections.objects.get(index);
        if object.is_none_or(|object| object.key("CompactSubObj").is_none()) {
            let message = format!(
                "[{}] goes with CompactSubObj in [{index:04X}]",
                section.name
            );
            findings.report(&rule::COMPACT_LIST, section.span, message);
        }
    }
}

fn read_object(
    index: u16,
    section: &Section<'_>,
    sections: &Sections<'_>,
    broken: &mut Broken,
    findings: &mut Findings,
) -> Object {
    let has_subs = section.key("CompactSubObj").is_some()
        || (sections.subs.range((index, 0)..=(index, u8::MAX)).next()).is_some();
    let likely = if has_subs {
        ObjectType::Record
    } else {
        ObjectType::Var
    };
    let object_type = object_type(section, likely, findings);
    let is_type = matches!(object_type, ObjectType::DefType | ObjectType::DefStruct);
    let count = compact_count(section, findings).filter(|count| *count > 0);
    let is_value = match object_type {
        ObjectType::Null => false,
        ObjectType::DefType => section.key("AccessType").is_some(),
        _ => !object_type.has_subs() || count.is_some(),
    };
    let mut object = Object {
        index,
        object_type,
        ..Object::default()
    };
    if is_value {
        // Name, places and keys are looked after with the value.
        let name = section.key("ParameterName");
        object.name = name.map_or_else(
            || format!("Object {index:04X}h"),
            |key| key.value.to_string(),
        );
        object.places = quiet_places(section);
    } else {
        object.places = entry::places(section, (sections.is_dcf, false), findings);
        object.name = entry::parameter_name(section, (index, 0), findings);
        object.flags = entry::object_flags(section, findings);
        object.notes = entry::notes(section);
        object.remarks = entry::remarks(section.lead.iter().chain(&section.comments));
        object.denotation = (section.key("Denotation").filter(|_| sections.is_dcf))
            .map(|key| key.value.to_string());
    }
    if object_type.has_subs() {
        object.data_type = number(section, "DataType", (0, 0xFFFF), findings)
            .and_then(|code| u16::try_from(code).ok());
    }
    match (object_type, count) {
        (_, Some(count)) if object_type.has_subs() => {
            compact::expand(&mut object, section, sections, count, broken, findings);
            read_subs(&mut object, section, sections, broken, findings);
        }
        _ if object_type.has_subs() => {
            read_subs(&mut object, section, sections, broken, findings);
            check_sub_number(&object, section, sections, findings);
        }
        _ => {
            check_no_subs(&object, section, sections, findings);
            if is_value {
                let context = Context {
                    index,
                    sub: 0,
                    is_dcf: sections.is_dcf,
                    is_domain: object_type == ObjectType::Domain,
                    is_compact: false,
                    is_extension: false,
                    types: &sections.types,
                };
                match entry::read(section, context, findings) {
                    Some(entry) => object.entries.push(entry),
                    None => _ = broken.entries.insert((index, 0)),
                }
            }
        }
    }
    if object_type.has_subs() && count.is_none() {
        check_header(&object, section, sections, findings);
    }
    if object_type.has_subs() && !is_type && !broken.objects.contains(&index) {
        check_sub_0(&mut object, section, broken, findings);
        check_array(&object, findings);
    }
    object
}

/// CompactSubObj. One that says too much stands for as many sub-indices as there can be, so that nothing else is said about them.
fn compact_count(section: &Section<'_>, findings: &mut Findings) -> Option<u8> {
    let key = section.key("CompactSubObj")?;
    let before = findings.len();
    let count = number(section, "CompactSubObj", (0, 254), findings);
    if findings.len() == before {
        return count.and_then(|count| u8::try_from(count).ok());
    }
    let stated = Number::parse(&key.value).ok()?;
    (stated.value > 254).then_some(254)
}

/// The header of an object with sub-indices has what is true of all of them; the rest is theirs.
fn check_header(
    object: &Object,
    section: &Section<'_>,
    sections: &Sections<'_>,
    findings: &mut Findings,
) {
    let of_values = ["AccessType", "LowLimit", "HighLimit", "DefaultValue"];
    let mut keys: Vec<_> = of_values
        .iter()
        .filter_map(|name| section.key(name))
        .collect();
    // A RECORD may name the DEFSTRUCT that it is made by (CiA 301, table 44: 0020h to 0FFFh).
    let is_simple = |code: u16| DataType::from_code(code.into()).is_some();
    if object.object_type == ObjectType::Record
        && object.data_type.is_some_and(is_simple)
        && let Some(key) = section.key("DataType")
    {
        keys.push(key);
    }
    let Some(first) = keys.iter().min_by_key(|key| key.span) else {
        return;
    };
    let names: Vec<&str> = keys.iter().map(|key| &*key.name).collect();
    let (names, kind) = (names.join(", "), object.object_type.name());
    let has_subs = sections
        .subs
        .range((object.index, 0)..=(object.index, u8::MAX));
    let article = if kind.starts_with('A') { "an" } else { "a" };
    let message = format!(
        "[{}] is {article} {kind}: {names} means nothing here",
        section.name
    );
    let finding = findings.report(&rule::HEADER_KEY, first.span, message);
    finding.help(if has_subs.count() == 0 {
        "the sub-indices have such keys; if it is one value, write ObjectType=0x7"
    } else {
        "the sub-indices have such keys: remove it here"
    });
}

fn quiet_places(section: &Section<'_>) -> Places {
    let mut places = Places::new(section.span);
    for key in &section.keys {
        if let Some(field) = Field::from_name(&key.name).filter(|_| !key.value.is_empty()) {
            places.put(field, key.span);
        }
    }
    places
}

/// The kind of an object; `likely` where it cannot be read, and that is allowed.
fn object_type(section: &Section<'_>, likely: ObjectType, findings: &mut Findings) -> ObjectType {
    let Some(key) = section.key("ObjectType") else {
        return ObjectType::Var;
    };
    let named = ObjectType::from_name(&key.value);
    let code = Number::parse(&key.value).map_err(|mistake| Mistake {
        help: named
            .map(|kind| format!("write ObjectType=0x{:X}", kind.code()))
            .or(mistake.help),
        ..mistake
    });
    let code = findings.take(&rule::OBJECT_TYPE, key.span, code);
    let object_type = code.and_then(|code| ObjectType::from_code(code.value));
    if object_type.is_none() && code.is_some() {
        let message = format!("ObjectType {} is no kind of object", key.value);
        let finding = findings.report(&rule::OBJECT_TYPE, key.span, message);
        finding.help(
            "0x0 NULL, 0x2 DOMAIN, 0x5 DEFTYPE, 0x6 DEFSTRUCT, 0x7 VAR, 0x8 ARRAY, 0x9 RECORD",
        );
    }
    object_type.or(named).unwrap_or(likely)
}

pub(super) fn read_subs(
    object: &mut Object,
    section: &Section<'_>,
    sections: &Sections<'_>,
    broken: &mut Broken,
    findings: &mut Findings,
) {
    let index = object.index;
    let is_compact = !object.entries.is_empty();
    // `;Storage=` of an object is for all its sub-indices that do not say otherwise.
    let storage = entry::storage_note(section, findings);
    // So is `;Memory=`, but for sub-index 0, which only counts them.
    let memory = entry::note_place(section, "Memory");
    for ((_, sub), section) in sections.subs.range((index, 0)..=(index, u8::MAX)) {
        if is_compact {
            let message = format!("{index:04X}h has CompactSubObj and sub sections");
            findings.report(&rule::COMPACT_AND_SUBS, section.span, message);
        }
        if *sub == u8::MAX {
            let message = "sub-index FFh is reserved";
            findings.report(&rule::SUB_FF, section.span, message);
        }
        let kind = object_type(section, ObjectType::Var, findings);
        if !matches!(kind, ObjectType::Var | ObjectType::Domain) {
            let span = section
                .key("ObjectType")
                .map_or(section.span, |key| key.span);
            let message = format!(
                "ObjectType of a sub-index is 0x7 (VAR), not {}",
                kind.name()
            );
            findings.report(&rule::SUB_OBJECT_TYPE, span, message);
        }
        let context = Context {
            index,
            sub: *sub,
            is_dcf: sections.is_dcf,
            is_domain: kind == ObjectType::Domain,
            is_compact: false,
            is_extension: false,
            types: &sections.types,
        };
        let Some(mut entry) = entry::read(section, context, findings) else {
            broken.entries.insert((index, *sub));
            continue;
        };
        if let Some((_, group)) = storage
            && entry.note("Storage").is_none()
            && entry.access.is_writable()
        {
            entry.storage = group;
        }
        if let Some(memory) = memory.filter(|_| *sub > 0 && !entry.is_with_application) {
            entry::give_to_application(&mut entry, index, memory, findings);
        }
        match object.entries.binary_search_by_key(sub, |entry| entry.sub) {
            Ok(at) => object.entries[at] = entry,
            Err(at) => object.entries.insert(at, entry),
        }
    }
}

/// SubNumber is how many sub sections there are.
fn check_sub_number(
    object: &Object,
    section: &Section<'_>,
    sections: &Sections<'_>,
    findings: &mut Findings,
) {
    let index = object.index;
    let count = sections.subs.range((index, 0)..=(index, u8::MAX)).count();
    let Some(key) = section.key("SubNumber") else {
        let message = format!("`SubNumber` is missing in [{}]", section.name);
        let finding = findings.report(&rule::NO_SUB_NUMBER, section.span, message);
        finding.help(format!("write SubNumber={count}"));
        return;
    };
    match Number::parse(&key.value) {
        Ok(number) if number.value == count as i128 => {}
        Ok(number) => {
            let number = number.value;
            let message =
                format!("SubNumber is {number}, but {index:04X}h has {count} sub sections");
            let finding = findings.report(&rule::SUB_NUMBER, key.span, message);
            finding.help(if number > count as i128 {
                format!("write SubNumber={count}, or add the sections that are missing")
            } else {
                format!("write SubNumber={count}, or remove the sections that are too much")
            });
        }
        Err(mistake) => _ = findings.take::<(), _>(&rule::SUB_NUMBER, key.span, Err(mistake)),
    }
}

/// A VAR, a DOMAIN and the like have no sub-indices.
fn check_no_subs(
    object: &Object,
    section: &Section<'_>,
    sections: &Sections<'_>,
    findings: &mut Findings,
) {
    let (index, kind) = (object.index, object.object_type.name());
    let mut subs = sections.subs.range((index, 0)..=(index, u8::MAX));
    let counts = ["SubNumber", "CompactSubObj"].into_iter();
    let stated = counts.filter_map(|name| section.key(name)).find(|key| {
        let number = Number::parse(&key.value);
        number.is_ok_and(|number| number.value != 0)
    });
    let span = match (stated, subs.next()) {
        (Some(key), _) => key.span,
        (None, Some((_, sub))) => sub.span,
        (None, None) => return,
    };
    let message = format!("{index:04X}h is a {kind}: it has no sub-indices");
    findings.report(&rule::SUBS_OF_A_VARIABLE, span, message);
}

/// Sub-index 0 is there, and is the number of the highest one.
fn check_sub_0(
    object: &mut Object,
    section: &Section<'_>,
    broken: &Broken,
    findings: &mut Findings,
) {
    let index = object.index;
    let named = |entry: &&Entry| entry.sub != u8::MAX;
    let highest = object.entries.iter().rfind(named);
    let present = highest.map_or(0, |entry| entry.sub);
    // A sub-index that could not be read counts too.
    let unread = broken
        .entries
        .range((index, 0)..(index, u8::MAX))
        .next_back();
    let highest = present.max(unread.map_or(0, |(_, sub)| *sub));
    if broken.entries.contains(&(index, 0)) {
        // It has been told why; the object has one all the same.
        if object.entry(0).is_none() {
            add_sub_0(object, present, section.span);
        }
        return;
    }
    let Some(first) = object.entry(0) else {
        let message = format!("{index:04X}h has no sub-index 0");
        let finding = findings.report(&rule::NO_SUB_0, section.span, message);
        finding.help(format!(
            "add [{index:04X}sub0] with DataType=0x0005, AccessType=const, DefaultValue={highest}"
        ));
        add_sub_0(object, highest, section.span);
        return;
    };
    if first.data_type != DataType::Unsigned8 {
        let name = first.data_type.name();
        let message = format!("{index:04X}h:0 is {name}, not UNSIGNED8");
        findings.report(&rule::SUB_0_TYPE, first.places.of(Field::DataType), message);
        return;
    }
    let Some(default) = first.default_number() else {
        fix_count(object, broken, findings);
        return;
    };
    let is_mapping = matches!(index, 0x1600..=0x17FF | 0x1A00..=0x1BFF);
    // Of a multiplexed PDO it is no number of objects (CiA 301, 7.5.2.36 and 7.5.2.38).
    if is_mapping && matches!(default, 254 | 255) {
        return;
    }
    let is_fixed = is_count(index, first);
    let message = if is_fixed && default != i128::from(highest) {
        format!("{index:04X}h:0 is {default}, but the highest sub-index is {highest}")
    } else if default > i128::from(highest) {
        format!("{index:04X}h:0 is {default}, above the highest sub-index {highest}")
    } else {
        fix_count(object, broken, findings);
        return;
    };
    let last = object.entries.iter().rfind(|entry| entry.sub == highest);
    let finding = findings.report(
        &rule::SUB_0_VALUE,
        first.places.of(Field::DefaultValue),
        message,
    );
    if let Some(last) = last.filter(|last| last.sub != 0) {
        finding.also(last.places.section, "the highest sub-index");
    }
    // Names of sections are hexadecimal: somebody who counts on after sub9 with sub10 has 16.
    let is_decimal = format!("{highest:X}") == default.to_string();
    finding.help(if default > i128::from(highest) {
        format!("write DefaultValue={highest}, or describe the sub-indices up to {default}")
    } else if is_decimal {
        format!("write DefaultValue={highest}, or name the sections in hexadecimal: [{index:04X}sub{default:X}] is sub-index {default}")
    } else {
        format!("write DefaultValue={highest}")
    });
}

/// Adds the sub-index 0 that an object must have.
pub(super) fn add_sub_0(object: &mut Object, highest: u8, span: Span) {
    let mut first = Entry::new(0, "Highest sub-index supported", DataType::Unsigned8);
    first.access = Access::Constant;
    first.default = Some(DefaultValue::number(highest.into()));
    first.places = Places::new(span);
    object.entries.insert(0, first);
}

/// Whether a sub-index 0 always tells the highest one: that of a mapping and of the list of errors changes.
fn is_count(index: u16, first: &Entry) -> bool {
    let is_mapping = matches!(index, 0x1600..=0x17FF | 0x1A00..=0x1BFF);
    let is_read_only = matches!(first.access, Access::Constant | Access::ReadOnly);
    is_read_only && !is_mapping && index != 0x1003
}

/// A dictionary does not have what could not be read, and its sub-index 0 says so.
fn fix_count(object: &mut Object, broken: &Broken, findings: &Findings) {
    let index = object.index;
    let highest = object.entries.iter().rfind(|entry| entry.sub != u8::MAX);
    let present = highest.map_or(0, |entry| entry.sub);
    let mut unread = broken.entries.range((index, 0)..(index, u8::MAX));
    let is_whole = unread.next().is_none();
    let first = object.entries.first_mut();
    if let Some(first) = first.filter(|first| first.sub == 0 && is_count(index, first))
        && (findings.is_for_code() || !is_whole)
    {
        first.default = Some(DefaultValue::number(present.into()));
    }
}

/// The elements of an ARRAY have one type.
fn check_array(object: &Object, findings: &mut Findings) {
    if object.object_type != ObjectType::Array {
        return;
    }
    let index = object.index;
    let mut elements = object.entries.iter().filter(|entry| entry.sub != 0);
    let Some(model) = elements.next() else {
        return;
    };
    for odd in elements.filter(|entry| entry.data_type != model.data_type) {
        let (is, should, sub) = (odd.data_type.name(), model.data_type.name(), odd.sub);
        let message = format!("an ARRAY has one type: {index:04X}h:{sub:X} is {is}, not {should}");
        let finding = findings.report(
            &rule::ARRAY_OF_MANY_TYPES,
            odd.places.of(Field::DataType),
            message,
        );
        finding.also(model.places.of(Field::DataType), "the type of the first");
    }
}

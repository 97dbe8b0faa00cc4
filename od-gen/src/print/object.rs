//! Objects and their sub-indices.

use super::value;
use crate::data_type::DataType;
use crate::document::Section;
use crate::model::{DefaultValue, Entry, Field, Note, Object, ObjectType, Remarks, StorageGroup};
use crate::parse::LEAST_CAPACITY;

/// Adds the sections of an object.
pub(super) fn write<'a>(object: &'a Object, sections: &mut Vec<Section<'a>>) {
    let index = object.index;
    if !object.object_type.has_subs() {
        let mut section = Section::new(format!("{index:04X}"));
        match object.entries.first() {
            Some(entry) => write_entry(
                (index, Some(object)),
                entry,
                object.object_type,
                &mut section,
            ),
            None => write_head(object, &mut section),
        }
        sections.push(section);
        return;
    }
    let mut section = Section::new(format!("{index:04X}"));
    write_head(object, &mut section);
    put(
        &mut section,
        Field::SubNumber,
        object.entries.len().to_string(),
    );
    if let Some(data_type) = object.data_type {
        put(&mut section, Field::DataType, format!("0x{data_type:04X}"));
    }
    sections.push(section);
    for entry in &object.entries {
        let mut section = Section::new(format!("{index:04X}sub{:X}", entry.sub));
        write_entry((index, Some(object)), entry, ObjectType::Var, &mut section);
        sections.push(section);
    }
}

pub(super) fn put(section: &mut Section<'_>, field: Field, value: String) {
    section.put(field.name(), value);
}

fn kind(kind: ObjectType) -> String {
    format!("0x{:X}", kind.code())
}

/// What an object has beside its values.
fn write_head<'a>(object: &'a Object, section: &mut Section<'a>) {
    remarks(&object.remarks, section);
    notes(&object.notes, section);
    section.put(Field::ParameterName.name(), &object.name);
    if let Some(denotation) = &object.denotation {
        section.put(Field::Denotation.name(), denotation);
    }
    put(section, Field::ObjectType, kind(object.object_type));
    flags(object.flags, section);
}

fn flags(flags: u32, section: &mut Section<'_>) {
    if flags != 0 {
        put(section, Field::ObjFlags, format!("0x{flags:X}"));
    }
}

fn remarks<'a>(remarks: &'a Remarks, section: &mut Section<'a>) {
    for remark in &remarks.0 {
        section.remark(remark);
    }
}

fn notes<'a>(notes: &'a [Note], section: &mut Section<'a>) {
    for note in notes {
        section.remark(format!("{}={}", note.name, note.value));
    }
}

/// Writes a value at an index; the object it belongs to may say what stores it.
pub(super) fn write_entry<'a>(
    (index, object): (u16, Option<&'a Object>),
    entry: &'a Entry,
    object_type: ObjectType,
    section: &mut Section<'a>,
) {
    remarks(&entry.remarks, section);
    notes(&entry.notes, section);
    if entry.note("Capacity").is_none()
        && let Some(capacity) = capacity(entry)
    {
        section.remark(format!("Capacity={capacity}"));
    }
    // What the application has is not stored.
    if !entry.is_with_application
        && entry.note("Storage").is_none()
        && entry.storage != implied_storage((index, object), entry)
    {
        let name = entry.storage.map_or("none", StorageGroup::name);
        section.remark(format!("Storage={name}"));
    }
    section.put(Field::ParameterName.name(), &entry.name);
    put(section, Field::ObjectType, kind(object_type));
    let data_type = entry.data_type;
    put(
        section,
        Field::DataType,
        format!("0x{:04X}", data_type.code()),
    );
    section.put(Field::AccessType.name(), entry.access.name());
    for (field, limit) in [
        (Field::LowLimit, entry.low_limit),
        (Field::HighLimit, entry.high_limit),
    ] {
        if let Some(limit) = limit {
            put(section, field, value::limit(limit, data_type));
        }
    }
    if let Some(default) = &entry.default {
        put(
            section,
            Field::DefaultValue,
            value::value(default, data_type),
        );
    }
    section.put(
        Field::PdoMapping.name(),
        if entry.pdo_mapping { "1" } else { "0" },
    );
    flags(entry.flags, section);
    let configured = entry.configured.as_ref();
    let configured = configured.map(|configured| value::value(configured, data_type));
    for (field, text) in [
        (Field::ParameterValue, &configured),
        (Field::Denotation, &entry.denotation),
        (Field::UploadFile, &entry.upload_file),
        (Field::DownloadFile, &entry.download_file),
    ] {
        if let Some(text) = text {
            put(section, field, text.clone());
        }
    }
}

/// The size that the file must state, as nothing else says it.
fn capacity(entry: &Entry) -> Option<u16> {
    let length = |value: Option<&DefaultValue>| match value {
        Some(DefaultValue::Text(bytes)) => bytes.len(),
        _ => 0,
    };
    let longest = length(entry.default.as_ref()).max(length(entry.configured.as_ref()));
    let implied = match entry.data_type {
        DataType::Domain => 0,
        _ if !entry.data_type.is_text() || !entry.access.is_writable() => return None,
        _ => longest.max(LEAST_CAPACITY.into()),
    };
    (usize::from(entry.size) != implied).then_some(entry.size)
}

/// What stores a value of whose section says nothing about it.
fn implied_storage((index, object): (u16, Option<&Object>), entry: &Entry) -> Option<StorageGroup> {
    let notes = object.into_iter().flat_map(|object| &object.notes);
    let mut stated = notes.filter(|note| note.name.eq_ignore_ascii_case("Storage"));
    match stated.next() {
        Some(note) if entry.access.is_writable() => StorageGroup::from_name(&note.value),
        _ => StorageGroup::default_of(index, entry.access),
    }
}

//! One value: type, access, limits, default.

use std::collections::BTreeMap;

use super::sections::{number, unknown_key};
use super::value::{self, LARGEST_NODE_ID, Written};
use crate::data_type::DataType;
use crate::diagnostic::{Findings, Mistake};
use crate::document::{Comment, Key, Section};
use crate::model::{
    Access, DefaultValue, Entry, Field, Limit, Note, Places, Remarks, StorageGroup,
};
use crate::number::Number;
use crate::rules::{Rule, reading, structure, value as rule};
use crate::source::Span;

/// Characters that a string can hold when neither its default nor a comment asks for more.
pub(crate) const LEAST_CAPACITY: u16 = 32;

/// What is known of a value before its section is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Context<'a> {
    pub(super) index: u16,
    pub(super) sub: u8,
    /// Whether the file is the configuration of one device.
    pub(super) is_dcf: bool,
    /// Whether its object is a DOMAIN: its data type then goes without saying.
    pub(super) is_domain: bool,
    /// Whether it stands for many: their lists of values are still to come.
    pub(super) is_compact: bool,
    /// Whether it says how a module extends an object.
    pub(super) is_extension: bool,
    /// The types that the file defines, by index.
    pub(super) types: &'a BTreeMap<u16, DataType>,
}

/// Reads a section; `None` when it leaves no value, which has then been reported.
pub(super) fn read(
    section: &Section<'_>,
    context: Context<'_>,
    findings: &mut Findings,
) -> Option<Entry> {
    let places = places(section, (context.is_dcf, context.is_extension), findings);
    let name = parameter_name(section, (context.index, context.sub), findings);
    let data_type = data_type(section, context, findings);
    let access = access(section, context, findings);
    let flags = object_flags(section, findings);
    let mapping = number(section, "PDOMapping", (0, 1), findings);
    let notes = notes(section);
    let data_type = data_type?;

    let mut entry = Entry::new(context.sub, name, data_type);
    entry.access = access;
    entry.flags = flags;
    entry.pdo_mapping = mapping == Some(1);
    entry.notes = notes;
    entry.remarks = remarks(section.lead.iter().chain(&section.comments));
    if entry.pdo_mapping && data_type.size().is_none() {
        let span = places.of(Field::PdoMapping);
        let message = format!("PDOMapping of a {} is not supported", data_type.name());
        findings.report(&rule::MAPPING_OF_VARIABLE_LENGTH, span, message);
        // The file has it; a generated dictionary does not.
        entry.pdo_mapping = !findings.is_for_code();
    }
    let mut limit = |name: &str| value::limit(written(section.key(name)?), data_type, findings);
    (entry.low_limit, entry.high_limit) = (limit("LowLimit"), limit("HighLimit"));
    let mut of = |name: &str| value::value(written(section.key(name)?), data_type, findings);
    let (default, configured) = (of("DefaultValue"), of("ParameterValue"));
    entry.default = default;
    if context.is_dcf {
        entry.configured = configured;
        let text = |name: &str| section.key(name).map(|key| key.value.to_string());
        entry.denotation = text("Denotation");
        entry.upload_file = text("UploadFile");
        entry.download_file = text("DownloadFile");
    }
    entry.places = places;
    check_order(&mut entry, section, findings);
    check_default(
        &entry,
        section.key("DefaultValue").map(|key| &*key.value),
        findings,
    );
    if !context.is_compact {
        check_constant(&entry, section.span, findings);
    }
    entry.size = size(section, &entry, findings)?;
    entry.storage = storage(section, context.index, access, findings);
    if let Some((span, note)) = note_place(section, "Memory") {
        give_to_application(&mut entry, context.index, (span, note), findings);
    }
    Some(entry)
}

fn written<'a>(key: &'a Key<'a>) -> Written<'a> {
    Written {
        key: &key.name,
        text: &key.value,
        span: key.span,
    }
}

/// Where the keys of a section stand; keys that mean nothing are reported.
pub(super) fn places(
    section: &Section<'_>,
    (is_dcf, is_extension): (bool, bool),
    findings: &mut Findings,
) -> Places {
    let mut places = Places::new(section.span);
    for key in &section.keys {
        let field = Field::from_name(&key.name);
        let Some(field) = field.filter(|field| is_extension || !field.is_of_module()) else {
            let known = Field::ALL.iter().map(|field| field.name());
            unknown_key(key, section, known, findings);
            continue;
        };
        if field.is_of_dcf() && !is_dcf && !key.value.is_empty() {
            let (name, section) = (&key.name, &section.name);
            let message = format!("`{name}` in [{section}] belongs to a DCF, not to an EDS");
            let finding = findings.report(&reading::KEY_OF_DCF, key.name_span, message);
            finding.help("it means nothing here: remove it");
        }
        if !key.value.is_empty() {
            places.put(field, key.span);
        }
    }
    places
}

/// The name of an object or a sub-index. It becomes a name in Rust, so there must be something in it to make one of.
pub(super) fn parameter_name(
    section: &Section<'_>,
    (index, sub): (u16, u8),
    findings: &mut Findings,
) -> String {
    let mut keys = section.keys.iter();
    let key = keys.find(|key| key.name.eq_ignore_ascii_case("ParameterName"));
    match key {
        Some(key) => {
            let name = &key.value;
            let is_plain = name.contains(|letter: char| letter.is_ascii_alphanumeric());
            if !is_plain {
                let message =
                    format!("ParameterName `{name}` has none of the letters A to Z and no digit");
                findings.report(&structure::PLAIN_NAME, key.span, message);
            }
            if !name.is_empty() {
                return name.to_string();
            }
        }
        None => {
            let message = missing("ParameterName", section);
            findings.report(&structure::NO_NAME, section.span, message);
        }
    }
    if sub == 0 {
        format!("Object {index:04X}h")
    } else {
        format!("Sub-index {sub:02X}h")
    }
}

fn missing(key: &str, section: &Section<'_>) -> String {
    format!("`{key}` is missing in [{}]", section.name)
}

/// ObjFlags tell configuration tools what to leave out; the device has no use for them.
pub(super) fn object_flags(section: &Section<'_>, findings: &mut Findings) -> u32 {
    let flags = number(section, "ObjFlags", (0, u32::MAX.into()), findings);
    flags
        .and_then(|flags| u32::try_from(flags).ok())
        .unwrap_or_default()
}

fn required<'a>(
    section: &'a Section<'a>,
    name: &str,
    rule: &'static Rule,
    findings: &mut Findings,
) -> Option<&'a Key<'a>> {
    let key = section.key(name);
    if key.is_none() {
        findings.report(rule, section.span, missing(name, section));
    }
    key
}

fn data_type(
    section: &Section<'_>,
    context: Context<'_>,
    findings: &mut Findings,
) -> Option<DataType> {
    if context.is_domain && section.key("DataType").is_none() {
        return Some(DataType::Domain);
    }
    let key = required(section, "DataType", &rule::NO_DATA_TYPE, findings)?;
    let named = DataType::from_name(&key.value.to_ascii_uppercase());
    let code = Number::parse(&key.value).map_err(|mistake| Mistake {
        help: named
            .map(|data_type| format!("write DataType=0x{:04X}", data_type.code()))
            .or(mistake.help),
        ..mistake
    });
    let Some(code) = findings.take(&rule::NOT_A_NUMBER, key.span, code) else {
        return named;
    };
    let defined = || context.types.get(&u16::try_from(code.value).ok()?).copied();
    let data_type = DataType::from_code(code.value).or_else(defined);
    if data_type.is_none() {
        let message = format!("DataType {} is no type of a value", key.value);
        let finding = findings.report(&rule::DATA_TYPE, key.span, message);
        let known = DataType::ALL
            .iter()
            .map(|data_type| format!("0x{:02X} {}", data_type.code(), data_type.name()));
        finding.help(known.collect::<Vec<_>>().join(", "));
    }
    data_type
}

fn access(section: &Section<'_>, context: Context<'_>, findings: &mut Findings) -> Access {
    if context.is_domain && section.key("AccessType").is_none() {
        return Access::ReadWrite;
    }
    let Some(key) = required(section, "AccessType", &rule::NO_ACCESS, findings) else {
        return unknown_access(&rule::NO_ACCESS, section.span, findings);
    };
    if let Some(access) = Access::from_name(&key.value) {
        return access;
    }
    let text = &key.value;
    let message = format!("AccessType `{text}` is not ro, wo, rw, rwr, rww or const");
    let meant = Access::meant(text);
    let finding = findings.report(&rule::ACCESS, key.span, message);
    if let Some(meant) = meant {
        finding.help(format!("write `AccessType={}`", meant.name()));
    }
    meant.unwrap_or_else(|| unknown_access(&rule::ACCESS, key.span, findings))
}

/// A value that nobody knows how to reach is ro where that is meant to be; else it is rw, of which nothing follows that could be wrong too.
fn unknown_access(rule: &Rule, span: Span, findings: &Findings) -> Access {
    let read_only = findings.allowed(rule, span, Access::ReadOnly);
    read_only.unwrap_or(Access::ReadWrite)
}

/// The limits leave room.
fn check_order(entry: &mut Entry, section: &Section<'_>, findings: &mut Findings) {
    if let (Some(low), Some(high)) = (entry.low_limit, entry.high_limit)
        && low > high
    {
        let span = entry.places.of(Field::LowLimit);
        // A pattern such as 0xFF is not what it looks like where the type has a sign.
        let shown = |name: &str, limit: Limit| match section.key(name) {
            Some(key) if key.value.contains(['x', 'X']) => format!("{} ({limit})", key.value),
            _ => limit.to_string(),
        };
        let (low, high) = (shown("LowLimit", low), shown("HighLimit", high));
        let name = entry.data_type.name();
        let message = format!("LowLimit {low} is above HighLimit {high} in {name}");
        let finding = findings.report(&rule::LOW_ABOVE_HIGH, span, message);
        finding.also(entry.places.of(Field::HighLimit), "the upper limit");
        finding.help("either LowLimit is wrong, or HighLimit");
        (entry.low_limit, entry.high_limit) = (None, None);
    }
}

/// The default lies between the limits with every node-ID; `text` is how it is written.
pub(super) fn check_default(entry: &Entry, text: Option<&str>, findings: &mut Findings) {
    // The device starts with 0 where nothing is stated, and of that only code is made.
    let default = match &entry.default {
        None if findings.is_for_code() => Some(entry.initial()),
        default => default.clone(),
    };
    let (least, most) = match default {
        Some(DefaultValue::Number {
            value,
            adds_node_id: true,
        }) => (
            Limit::Integer(value + 1),
            Limit::Integer(value + LARGEST_NODE_ID),
        ),
        Some(DefaultValue::Number { value, .. }) => (Limit::Integer(value), Limit::Integer(value)),
        Some(DefaultValue::Real(value)) => (Limit::Real(value), Limit::Real(value)),
        Some(DefaultValue::Text(_)) | None => return,
    };
    let text = text.unwrap_or("0 (there is none)");
    let (outside, limit) = match (entry.low_limit, entry.high_limit) {
        (Some(low), _) if least < low => (format!("below LowLimit {low}"), Field::LowLimit),
        (_, Some(high)) if most > high => (format!("above HighLimit {high}"), Field::HighLimit),
        _ => return,
    };
    let span = entry.places.of(Field::DefaultValue);
    let message = format!("DefaultValue {text} is {outside}");
    let finding = findings.report(&rule::DEFAULT_OUTSIDE_LIMITS, span, message);
    finding.also(entry.places.of(limit), "the limit");
    let is_zero = |limit: Option<Limit>| limit == Some(Limit::Integer(0));
    if is_zero(entry.low_limit) && is_zero(entry.high_limit) {
        finding.help("some tools write 0 and 0 where there are no limits: remove both");
    } else {
        finding.help("either the default is wrong, or the limit");
    }
}

pub(super) fn check_constant(entry: &Entry, span: Span, findings: &mut Findings) {
    let is_number = entry.data_type.size().is_some();
    let has_default = entry.default.is_some() || entry.places.has(Field::DefaultValue);
    if entry.access == Access::Constant && is_number && !has_default {
        let message = format!("`{}` is const: it needs a DefaultValue", entry.name);
        findings.report(&rule::CONST_WITHOUT_DEFAULT, span, message);
    }
}

/// The bytes a value takes; of a string that can be written, its capacity.
fn size(section: &Section<'_>, entry: &Entry, findings: &mut Findings) -> Option<u16> {
    let is_domain = entry.data_type == DataType::Domain;
    let capacity = match note_place(section, "Capacity") {
        Some((span, text)) => {
            let capacity = Number::parse_within(text, 1, u16::MAX.into());
            let capacity = capacity.map_err(|why| why.of("Capacity"));
            let capacity = findings.take(&rule::CAPACITY, span, capacity);
            capacity.map(|capacity| (span, u16::try_from(capacity).unwrap_or(u16::MAX)))
        }
        None => None,
    };
    if entry.data_type.size().is_some() {
        if let Some((span, _)) = capacity {
            let message = format!("Capacity does not go with {}", entry.data_type.name());
            findings.report(&rule::CAPACITY_OF_NO_STRING, span, message);
        }
        return entry.data_type.size();
    }
    if is_domain {
        return Some(capacity.map_or(0, |(_, capacity)| capacity));
    }
    let length = |value: &Option<DefaultValue>| match value {
        Some(DefaultValue::Text(text)) => text.len(),
        _ => 0,
    };
    let length = length(&entry.default).max(length(&entry.configured));
    let Ok(length) = u16::try_from(length) else {
        let message = format!(
            "[{}] takes {length} bytes, a value has at most 65535",
            section.name
        );
        findings.report(&rule::VALUE_TOO_LARGE, section.span, message);
        return None;
    };
    Some(match capacity {
        Some((span, _)) if !entry.access.is_writable() => {
            let message = "Capacity of a string that cannot be written";
            findings.report(&rule::CAPACITY_OF_NO_STRING, span, message);
            length
        }
        Some((span, capacity)) if capacity < length => {
            let message =
                format!("Capacity {capacity} is less than the {length} bytes of the default");
            findings.report(&rule::CAPACITY_TOO_SMALL, span, message);
            length
        }
        Some((_, capacity)) => capacity,
        None if entry.access.is_writable() => length.max(LEAST_CAPACITY),
        None => length,
    })
}

/// The comment `;Memory=application`: the application has the value.
pub(super) fn give_to_application(
    entry: &mut Entry,
    index: u16,
    (span, note): (Span, &str),
    findings: &mut Findings,
) {
    let message = if !note.eq_ignore_ascii_case("application") {
        format!("Memory `{note}` is not application")
    } else if index < 0x2000 && !(0x1023..=0x1026).contains(&index) {
        format!("{index:04X}h belongs to the communication, which has its memory")
    } else if entry.pdo_mapping {
        "a PDO carries only what the dictionary has".into()
    } else if entry.access == Access::Constant {
        "a value that is const lies in flash".into()
    } else if entry.note("Storage").is_some() {
        "1010h stores only what the dictionary has".into()
    } else {
        entry.is_with_application = true;
        entry.storage = None;
        return;
    };
    findings.report(&rule::MEMORY, span, message);
}

/// What stores a value: by the comment `;Storage=` in its section, or by its index and access.
fn storage(
    section: &Section<'_>,
    index: u16,
    access: Access,
    findings: &mut Findings,
) -> Option<StorageGroup> {
    let default = StorageGroup::default_of(index, access);
    match storage_note(section, findings) {
        None => default,
        Some((_, None)) => None,
        Some((span, Some(_))) if !access.is_writable() => {
            let message = format!("Storage of a value that is {}", access.name());
            findings.report(&rule::STORAGE_OF_FIXED, span, message);
            None
        }
        Some((_, group)) => group,
    }
}

/// The comment `;Storage=` with its place: stored or not. `None` when there is none, or a wrong one.
pub(super) fn storage_note(
    section: &Section<'_>,
    findings: &mut Findings,
) -> Option<(Span, Option<StorageGroup>)> {
    let (span, text) = note_place(section, "Storage")?;
    if text.eq_ignore_ascii_case("none") {
        return Some((span, None));
    }
    if let Some(group) = StorageGroup::from_name(text) {
        return Some((span, Some(group)));
    }
    let message =
        format!("Storage `{text}` is not none, communication, application or manufacturer");
    findings.report(&rule::STORAGE, span, message);
    None
}

/// The comments of the form `;Name=value`: CiA 306 has no keys for them, and tools complain about keys that are not in it.
pub(super) fn notes(section: &Section<'_>) -> Vec<Note> {
    let comments = section.comments.iter();
    let pairs = comments.filter_map(Comment::note);
    pairs
        .map(|(name, value)| Note {
            name: name.into(),
            value: value.into(),
        })
        .collect()
}

/// All other comments.
pub(super) fn remarks<'a>(comments: impl Iterator<Item = &'a Comment<'a>>) -> Remarks {
    let remarks = comments.filter(|comment| comment.note().is_none());
    Remarks(remarks.map(|comment| comment.text.to_string()).collect())
}

pub(super) fn note_place<'a>(section: &'a Section<'a>, name: &str) -> Option<(Span, &'a str)> {
    section.comments.iter().find_map(|comment| {
        let (own, value) = comment.note()?;
        own.eq_ignore_ascii_case(name)
            .then_some((comment.span, value))
    })
}

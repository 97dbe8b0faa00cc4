//! The canonical form of a [`Document`]: what CiA 306 spells in one way is spelled like that, and stands in one order.
//!
//! What the file means does not change, comments stay with what they stand above, and what is not known stays as it is.
//! The form is a fixed point: bringing it about twice changes nothing.

use std::borrow::Cow;
use std::mem;

use super::{Comment, Document, Key, Section};
use crate::model::Field;
use crate::number::Number;
use crate::parse::{COMMISSIONING_KEYS, DEVICE_INFO_KEYS, FILE_INFO_KEYS, module_name};

/// Sections that are no objects, in the order in which they are written; objects stand below the list they belong in.
pub(crate) const SECTIONS: [&str; 13] = [
    "FileInfo",
    "DeviceInfo",
    "DeviceComissioning",
    "DummyUsage",
    "StandardDataTypes",
    "DynamicChannels",
    "SupportedModules",
    "ConnectedModules",
    "Tools",
    "Comments",
    MANDATORY,
    OPTIONAL,
    MANUFACTURER,
];
const MANDATORY: &str = "MandatoryObjects";
const OPTIONAL: &str = "OptionalObjects";
const MANUFACTURER: &str = "ManufacturerObjects";

/// The keys of the sections that are no objects.
const KEYS: [&[&str]; 4] = [
    &FILE_INFO_KEYS,
    &DEVICE_INFO_KEYS,
    &COMMISSIONING_KEYS,
    &["SupportedObjects", "NrOfEntries", "Lines"],
];

/// Where a section stands: twice its place among [`SECTIONS`] (one more for what stands below it), module, kind of its section,
/// index, sub-index, kind of list.
type Rank = (usize, u8, u8, u16, u16, u8);

/// Behind everything that is known.
const UNKNOWN: Rank = (usize::MAX, 0, 0, 0, 0, 0);

/// The sections of a module, in the order in which they are written; its objects stand below their list.
const MODULE: [&str; 6] = [
    "ModuleInfo",
    "Comments",
    "FixedObjects",
    "Fixed",
    "SubExtends",
    "SubExt",
];

/// Brings about the canonical form.
pub(crate) fn canonical(mut document: Document<'_>) -> Document<'_> {
    let mut sections: Vec<(Rank, Section<'_>)> = Vec::new();
    for mut section in mem::take(&mut document.sections) {
        let rank = name(&mut section);
        sort_keys(&mut section);
        sections.push((rank, section));
    }
    // Sections of the same rank, such as unknown ones, stay in their order.
    sections.sort_by_key(|(rank, _)| *rank);
    document.sections = sections.into_iter().map(|(_, section)| section).collect();
    // What is above the first section is read as the comment of the file.
    if let Some(first) = document.sections.first_mut() {
        document.head.append(&mut first.lead);
    }
    document
}

/// A name as the canonical form spells it, in lower case: equal for two names of the same section.
pub(crate) fn identity(section: &str) -> String {
    let mut section = Section::new(section);
    name(&mut section);
    section.name.to_ascii_lowercase()
}

/// Spells the name of a section, and says where it stands.
fn name(section: &mut Section<'_>) -> Rank {
    let mut lower = section.name.to_ascii_lowercase();
    if lower == "devicecommissioning" {
        // CiA 306 spells it with one `m`.
        lower = "devicecomissioning".into();
    }
    if let Some(place) = SECTIONS
        .iter()
        .position(|own| own.eq_ignore_ascii_case(&lower))
    {
        section.name = SECTIONS.get(place).copied().unwrap_or_default().into();
        return (2 * place, 0, 0, 0, 0, 0);
    }
    if let Some((number, rest)) = module_name(&lower) {
        return module(section, number, rest).unwrap_or(UNKNOWN);
    }
    let Some((name, index, sub, list)) = object(&lower) else {
        return UNKNOWN;
    };
    section.name = name.into();
    // Data types are defined above the first list.
    let (above, below) = match index {
        0..=0x0FFF => (MANDATORY, -1),
        0x1000 | 0x1001 | 0x1018 => (MANDATORY, 1),
        0x2000..=0x5FFF => (MANUFACTURER, 1),
        _ => (OPTIONAL, 1),
    };
    let place = SECTIONS.iter().position(|own| *own == above);
    let place = place.map_or(usize::MAX, |place| (2 * place).saturating_add_signed(below));
    (place, 0, 0, index, sub, list)
}

/// Spells the name of a section of a module, and says where it stands.
fn module(section: &mut Section<'_>, number: u8, rest: &str) -> Option<Rank> {
    let place = SECTIONS.iter().position(|own| *own == "SupportedModules");
    let place = 2 * place? + 1;
    let kind = |name: &str| {
        let kind = MODULE
            .iter()
            .position(|own| own.eq_ignore_ascii_case(name))?;
        u8::try_from(kind).ok()
    };
    if let Some((kind, name)) =
        kind(rest).zip(MODULE.iter().find(|own| own.eq_ignore_ascii_case(rest)))
    {
        section.name = format!("M{number}{name}").into();
        return Some((place, number, kind, 0, 0, 0));
    }
    let (prefix, rest) = match rest.strip_prefix("fixed") {
        Some(rest) => ("Fixed", rest),
        None => ("SubExt", rest.strip_prefix("subext")?),
    };
    let (name, index, sub, list) = object(rest)?;
    section.name = format!("M{number}{prefix}{name}").into();
    Some((place, number, kind(prefix)?, index, sub, list))
}

/// The name of an object's section, spelled, with index, sub-index and kind of list.
fn object(name: &str) -> Option<(String, u16, u16, u8)> {
    let (digits, rest) = name.split_at_checked(4)?;
    let index = is_hexadecimal(digits).then(|| u16::from_str_radix(digits, 16).ok())??;
    let (sub, list, rest) = match rest {
        "" => (0, 0, String::new()),
        "name" => (u16::MAX, 0, "Name".into()),
        "value" => (u16::MAX, 1, "Value".into()),
        "denotation" => (u16::MAX, 2, "Denotation".into()),
        _ => {
            let digits = rest.strip_prefix("sub");
            let digits = digits.filter(|digits| is_hexadecimal(digits))?;
            let sub = u8::from_str_radix(digits, 16).ok()?;
            (u16::from(sub) + 1, 0, format!("sub{sub:X}"))
        }
    };
    Some((format!("{index:04X}{rest}"), index, sub, list))
}

fn is_hexadecimal(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|digit| digit.is_ascii_hexdigit())
}

/// Spells the keys of a section and puts them in order; comments go with the key below them, notes such as `;Unit=mm` to the top.
fn sort_keys<'a>(section: &mut Section<'a>) {
    let is_list = [MANDATORY, OPTIONAL, MANUFACTURER].contains(&&*section.name);
    let lower = section.name.to_ascii_lowercase();
    let own = match module_name(&lower) {
        Some((_, rest)) => rest.strip_prefix("fixed").or(rest.strip_prefix("subext")),
        None => Some(lower.as_str()),
    };
    let is_object = own
        .and_then(object)
        .is_some_and(|(_, _, sub, _)| sub != u16::MAX);
    let comments = mem::take(&mut section.comments);
    let (top, comments): (Vec<_>, Vec<_>) = comments
        .into_iter()
        .partition(|comment| comment.position == 0 || comment.note().is_some());
    let mut comments = comments.into_iter().peekable();

    let mut keys: Vec<(usize, Vec<Comment<'a>>, Key<'a>)> = Vec::new();
    let mut above = Vec::new();
    for (position, mut key) in mem::take(&mut section.keys).into_iter().enumerate() {
        while let Some(comment) = comments.next_if(|comment| comment.position <= position) {
            above.push(comment);
        }
        let rank = if is_object {
            let rank = field(&mut key);
            // `LowLimit=` says nothing.
            if rank < Field::ALL.len() && key.value.is_empty() {
                continue;
            }
            rank
        } else if is_list {
            spell_key(&mut key);
            spell_number(&mut key.value, |value| {
                if key.name.eq_ignore_ascii_case("SupportedObjects") {
                    value.to_string()
                } else {
                    format!("0x{value:04X}")
                }
            });
            0
        } else {
            spell_key(&mut key);
            0
        };
        keys.push((rank, mem::take(&mut above), key));
    }
    keys.sort_by_key(|(rank, ..)| *rank);

    let mut place = |mut comment: Comment<'a>, position| {
        comment.position = position;
        section.comments.push(comment);
    };
    for comment in top {
        place(comment, 0);
    }
    for (position, (_, above, key)) in keys.into_iter().enumerate() {
        for comment in above {
            place(comment, position);
        }
        section.keys.push(key);
    }
    let end = section.keys.len();
    for comment in above.into_iter().chain(comments) {
        place(comment, end);
    }
}

/// Spells a key of a section that is no object.
fn spell_key(key: &mut Key<'_>) {
    let known = KEYS.iter().copied().flatten();
    if let Some(name) = known
        .copied()
        .find(|known| known.eq_ignore_ascii_case(&key.name))
    {
        key.name = name.into();
    }
}

/// Spells a key of an object, and says where it stands.
fn field(key: &mut Key<'_>) -> usize {
    let Some(field) = Field::from_name(&key.name) else {
        return Field::ALL.len();
    };
    key.name = field.name().into();
    match field {
        Field::ObjectType => spell_number(&mut key.value, |value| format!("0x{value:X}")),
        Field::DataType => spell_number(&mut key.value, |value| format!("0x{value:04X}")),
        Field::PdoMapping | Field::SubNumber | Field::CompactSubObj => {
            spell_number(&mut key.value, |value| value.to_string());
        }
        Field::AccessType => key.value = key.value.to_ascii_lowercase().into(),
        _ => {}
    }
    let found = Field::ALL.iter().position(|own| *own == field);
    found.unwrap_or(Field::ALL.len())
}

/// Spells a number that is not negative; what is none stays as it is.
fn spell_number(text: &mut Cow<'_, str>, spell: impl Fn(i128) -> String) {
    let value = Number::parse(text).map(|number| number.value);
    if let Some(value) = value.ok().filter(|value| *value >= 0) {
        *text = spell(value).into();
    }
}

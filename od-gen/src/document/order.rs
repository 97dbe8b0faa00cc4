//! The canonical form of a [`Document`]: what CiA 306 spells in one way is spelled like that, and stands in one order.
//!
//! What the file means does not change, comments stay with what they stand above, and what is not known stays as it is.
//! The form is a fixed point: bringing it about twice changes nothing.

use std::borrow::Cow;
use std::mem;

use super::{Comment, Document, Key, Section};
use crate::model::Field;
use crate::number::Number;
use crate::parse::{COMMISSIONING_KEYS, DEVICE_INFO_KEYS, FILE_INFO_KEYS};

/// Sections that are no objects, in the order in which they are written; objects stand below the list they belong in.
const SECTIONS: [&str; 13] = [
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

/// Where a section stands: twice its place among [`SECTIONS`] (one more for an object below its list), index, sub-index, list.
type Rank = (usize, u16, u16, u8);

/// Behind everything that is known.
const UNKNOWN: Rank = (usize::MAX, 0, 0, 0);

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
    document
}

/// Spells the name of a section, and says where it stands.
fn name(section: &mut Section<'_>) -> Rank {
    let is_own = |own: &&str| own.eq_ignore_ascii_case(&section.name);
    if let Some(place) = SECTIONS.iter().position(is_own) {
        section.name = SECTIONS.get(place).copied().unwrap_or_default().into();
        return (2 * place, 0, 0, 0);
    }
    let Some((index, rest)) = object(&section.name) else {
        return UNKNOWN;
    };
    let (sub, kind, rest) = match rest.as_str() {
        "" => (0, 0, String::new()),
        "name" => (u16::MAX, 0, "Name".into()),
        "value" => (u16::MAX, 1, "Value".into()),
        "denotation" => (u16::MAX, 2, "Denotation".into()),
        _ => {
            let digits = rest
                .strip_prefix("sub")
                .filter(|digits| is_hexadecimal(digits));
            let sub = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
            let Some(sub) = sub else {
                return UNKNOWN;
            };
            (u16::from(sub) + 1, 0, format!("sub{sub:X}"))
        }
    };
    section.name = format!("{index:04X}{rest}").into();
    let list = |name: &str| SECTIONS.iter().position(|own| *own == name);
    let place = match index {
        // Data types are defined above the first list.
        0..=0x0FFF => list(MANDATORY).map(|place| 2 * place - 1),
        0x1000 | 0x1001 | 0x1018 => list(MANDATORY).map(|place| 2 * place + 1),
        0x2000..=0x5FFF => list(MANUFACTURER).map(|place| 2 * place + 1),
        _ => list(OPTIONAL).map(|place| 2 * place + 1),
    };
    (place.unwrap_or(usize::MAX), index, sub, kind)
}

/// The index in the name of a section, and what follows it in lower case.
fn object(name: &str) -> Option<(u16, String)> {
    let (digits, rest) = name.split_at_checked(4)?;
    let index = is_hexadecimal(digits).then(|| u16::from_str_radix(digits, 16).ok())??;
    Some((index, rest.to_ascii_lowercase()))
}

fn is_hexadecimal(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|digit| digit.is_ascii_hexdigit())
}

/// Spells the keys of a section and puts them in order; comments go with the key below them.
fn sort_keys<'a>(section: &mut Section<'a>) {
    let is_list = [MANDATORY, OPTIONAL, MANUFACTURER].contains(&&*section.name);
    let is_object =
        object(&section.name).is_some_and(|(_, rest)| rest.is_empty() || rest.starts_with("sub"));
    let comments = mem::take(&mut section.comments);
    let (top, comments): (Vec<_>, Vec<_>) = comments
        .into_iter()
        .partition(|comment| comment.position == 0);
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

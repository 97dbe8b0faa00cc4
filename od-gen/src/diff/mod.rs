//! What two data sheets mean differently.
//!
//! The models are compared, not the texts: spelling, order, comments, compact notations and dates make no difference. A change
//! that can break a master which was made for the first file is marked: what is gone, what has another type or length, what can
//! no longer be written or mapped, what has narrower limits.

mod device;
mod entry;
mod text;

use std::fmt;

use crate::model::{Model, Object};

/// One difference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Where it is.
    pub place: Place,
    /// What it is.
    pub change: Change,
    /// Whether it can break a master that was made for the first file.
    pub breaks: bool,
}

/// What a difference is about.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// A section that is no object, such as DeviceInfo.
    Section(&'static str),
    /// An object.
    Object(u16),
    /// A value of an object with sub-indices.
    Entry(u16, u8),
}

/// What is different.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Only the second file has it.
    Added(String),
    /// Only the first file has it.
    Removed(String),
    /// Both have it, with other values of this key.
    Changed {
        /// The key.
        key: &'static str,
        /// In the first file.
        before: String,
        /// In the second file.
        after: String,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Section(name) => write!(f, "[{name}]"),
            Self::Object(index) => write!(f, "{index:04X}h"),
            Self::Entry(index, sub) => write!(f, "{index:04X}h:{sub:X}"),
        }
    }
}

/// One line: `+` for what is added, `-` for what is removed, `~` for what is changed, `!` at its end when it can break a master.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = &self.place;
        match &self.change {
            Change::Added(what) => write!(f, "+ {place} {what}")?,
            Change::Removed(what) => write!(f, "- {place} {what}")?,
            Change::Changed { key, before, after } => {
                let (before, after) = (or_none(before), or_none(after));
                write!(f, "~ {place} {key}: {before} -> {after}")?;
            }
        }
        if self.breaks {
            f.write_str("  !")
        } else {
            Ok(())
        }
    }
}

fn or_none(text: &str) -> &str {
    if text.is_empty() { "(none)" } else { text }
}

/// What `after` means differently from `before`: sections first, then objects by index and sub-index.
pub fn diff(before: &Model, after: &Model) -> Vec<Difference> {
    let mut differences = Differences::default();
    device::compare(before, after, &mut differences);
    for (first, second) in [
        (&before.types, &after.types),
        (&before.objects, &after.objects),
    ] {
        let pairs = pairs(first, second, |object: &Object| object.index);
        for (first, second) in pairs {
            match (first, second) {
                (Some(first), Some(second)) => object(first, second, &mut differences),
                (Some(gone), None) => {
                    let place = Place::Object(gone.index);
                    differences.put(place, Change::Removed(text::object(gone)), true);
                }
                (None, Some(new)) => {
                    let place = Place::Object(new.index);
                    differences.put(place, Change::Added(text::object(new)), false);
                }
                (None, None) => {}
            }
        }
    }
    differences.list
}

/// Two sorted lists side by side.
fn pairs<'a, T, K: Ord>(
    first: &'a [T],
    second: &'a [T],
    key: impl Fn(&T) -> K,
) -> Vec<(Option<&'a T>, Option<&'a T>)> {
    let (mut first, mut second) = (first.iter().peekable(), second.iter().peekable());
    let mut pairs = Vec::new();
    loop {
        let order = match (first.peek(), second.peek()) {
            (Some(a), Some(b)) => key(a).cmp(&key(b)),
            (Some(_), None) => std::cmp::Ordering::Less,
            (None, Some(_)) => std::cmp::Ordering::Greater,
            (None, None) => return pairs,
        };
        pairs.push((
            if order.is_le() { first.next() } else { None },
            if order.is_ge() { second.next() } else { None },
        ));
    }
}

fn object(before: &Object, after: &Object, differences: &mut Differences) {
    let index = before.index;
    let place = Place::Object(index);
    differences.change(&place, "ParameterName", &before.name, &after.name, false);
    let kinds = (before.object_type, after.object_type);
    let is_other_shape = kinds.0.has_subs() != kinds.1.has_subs();
    let (first, second) = (kinds.0.name(), kinds.1.name());
    differences.change(&place, "ObjectType", first, second, is_other_shape);
    if kinds.0.has_subs() || kinds.1.has_subs() {
        // A VAR has these in its only entry.
        let text = |object: &Object| {
            let data_type = object.data_type.map(|code| format!("0x{code:04X}"));
            let flags = format!("0x{:X}", object.flags);
            (data_type.unwrap_or_default(), flags)
        };
        let (first, second) = (text(before), text(after));
        differences.change(&place, "DataType", &first.0, &second.0, false);
        differences.change(&place, "ObjFlags", &first.1, &second.1, false);
        let denotation = |object: &Object| object.denotation.clone().unwrap_or_default();
        let (first, second) = (denotation(before), denotation(after));
        differences.change(&place, "Denotation", &first, &second, false);
    }
    for (first, second) in pairs(&before.entries, &after.entries, |entry| entry.sub) {
        let Some(sub) = first.or(second).map(|entry| entry.sub) else {
            continue;
        };
        let has_subs = kinds.0.has_subs() || kinds.1.has_subs();
        let place = if has_subs {
            Place::Entry(index, sub)
        } else {
            Place::Object(index)
        };
        match (first, second) {
            (Some(first), Some(second)) => {
                // A VAR has the name of its object.
                if has_subs {
                    differences.change(&place, "ParameterName", &first.name, &second.name, false);
                }
                entry::compare(&place, first, second, differences);
            }
            (Some(gone), None) => differences.put(place, Change::Removed(text::entry(gone)), true),
            (None, Some(new)) => differences.put(place, Change::Added(text::entry(new)), false),
            (None, None) => {}
        }
    }
}

/// Differences in the order in which they are found.
#[derive(Debug, Default)]
struct Differences {
    list: Vec<Difference>,
}

impl Differences {
    fn put(&mut self, place: Place, change: Change, breaks: bool) {
        self.list.push(Difference {
            place,
            change,
            breaks,
        });
    }

    /// A key, when it has another value.
    fn change(
        &mut self,
        place: &Place,
        key: &'static str,
        before: &str,
        after: &str,
        breaks: bool,
    ) {
        if before == after {
            return;
        }
        let (before, after) = (before.into(), after.into());
        self.put(
            place.clone(),
            Change::Changed { key, before, after },
            breaks,
        );
    }
}

#[cfg(test)]
mod tests;

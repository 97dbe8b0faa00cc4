//! Names of the standards as names of Rust.

use std::collections::{BTreeMap, BTreeSet};

use super::layout::Row;
use crate::model::{Model, Object};

/// Words a method cannot or should not be called by.
const RESERVED: [&str; 57] = [
    "abstract", "as", "async", "await", "become", "box", "break", "clone", "const", "continue",
    "crate", "default", "do", "dyn", "else", "enum", "extern", "false", "final", "fmt", "fn",
    "for", "gen", "if", "impl", "in", "let", "loop", "macro", "match", "mod", "move", "mut", "new",
    "override", "priv", "pub", "ram", "ram_mut", "ref", "return", "self", "static", "struct",
    "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield",
];

/// The name of each value's getter, in the order of the entries: `identity_object_serial_number`.
pub(super) fn getters(model: &Model) -> Vec<String> {
    let values = model.objects.iter().flat_map(|object| {
        object
            .entries
            .iter()
            .map(move |entry| match object.object_type.has_subs() {
                false => (snake_case(&object.name), format!("{:04x}", object.index)),
                true => {
                    let name = format!("{} {}", object.name, entry.name);
                    (
                        snake_case(&name),
                        format!("{:04x}_{:x}", object.index, entry.sub),
                    )
                }
            })
    });
    unique(values.collect())
}

/// The name of each object's index, in their order: `IDENTITY_OBJECT`.
pub(super) fn indices(model: &Model) -> Vec<String> {
    let name = |object: &Object| (snake_case(&object.name), format!("{:04x}", object.index));
    let names = unique(model.objects.iter().map(name).collect());
    names.into_iter().map(|name| name.to_uppercase()).collect()
}

/// The method for each group of values that the application has: that of its getter, or of its array.
pub(super) fn values(groups: &[Vec<&Row<'_>>]) -> Vec<String> {
    let named = groups.iter().filter_map(|group| match group.as_slice() {
        [] => None,
        [row] => {
            let place = format!("{:04x}_{:x}", row.object.index, row.entry.sub);
            Some((row.name.clone(), place))
        }
        [first, ..] => {
            let index = format!("{:04x}", first.object.index);
            Some((snake_case(&first.object.name), index))
        }
    });
    unique(named.collect())
}

/// The type that serves each streamed object, by its getter: `File1`. Digits close up to their word, so `file_1` and `file1` give
/// the same type, and both get the place of their object behind it: `File1At2000`.
pub(super) fn stream_types(rows: &[&Row<'_>]) -> Vec<String> {
    let types = rows.iter().map(|row| {
        let number = match row.object.object_type.has_subs() {
            false => format!("At{:04X}", row.object.index),
            true => format!("At{:04X}Sub{:X}", row.object.index, row.entry.sub),
        };
        (camel_case(&row.name), number)
    });
    numbered(types.collect(), "", |_| false)
}

/// Puts the number behind each name that is not the only one of its kind, is a word of the language, or could be taken for
/// the setter of another.
fn unique(names: Vec<(String, String)>) -> Vec<String> {
    numbered(names, "_", |name| RESERVED.contains(&name))
}

/// Puts the number behind each name that is reserved or clashes with another, until none does. A name with its number can be
/// that of another object, which then gets its number too. As no two numbers are the same, no two names that end in theirs are,
/// and each round numbers one more: this ends.
fn numbered(
    names: Vec<(String, String)>,
    joint: &str,
    is_reserved: impl Fn(&str) -> bool,
) -> Vec<String> {
    // Each with its number while it has not got it yet.
    let mut names: Vec<(String, Option<String>)> = names
        .into_iter()
        .map(|(name, number)| (name, Some(number)))
        .collect();
    loop {
        let mut uses = BTreeMap::<&str, usize>::new();
        for (name, _) in &names {
            *uses.entry(name).or_default() += 1;
        }
        let fixed: BTreeSet<&str> = names
            .iter()
            .filter(|(_, number)| number.is_none())
            .map(|(name, _)| name.as_str())
            .collect();
        let has_to_move = |(name, number): &(String, Option<String>)| {
            let is_setter = name
                .strip_prefix("set_")
                .is_some_and(|rest| uses.contains_key(rest));
            let has_fixed_setter = || fixed.contains(format!("set_{name}").as_str());
            let is_free = uses.get(name.as_str()) == Some(&1)
                && !is_reserved(name)
                && !is_setter
                && !has_fixed_setter();
            number.is_some() && !is_free
        };
        let moving: Vec<bool> = names.iter().map(has_to_move).collect();
        if !moving.contains(&true) {
            return names.into_iter().map(|(name, _)| name).collect();
        }
        for ((name, number), _) in names.iter_mut().zip(moving).filter(|(_, moves)| *moves) {
            if let Some(number) = number.take() {
                *name = format!("{name}{joint}{number}");
            }
        }
    }
}

/// `Max. motor-speed (rpm)` is `max_motor_speed_rpm`.
pub(crate) fn snake_case(name: &str) -> String {
    let words = name
        .split(|letter: char| !letter.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("_").to_ascii_lowercase();
    if name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        name
    } else {
        format!("object_{name}")
    }
}

/// `max_motor_speed` as a type: `MaxMotorSpeed`.
fn camel_case(name: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|first| first.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    name.split('_').map(word).collect()
}

/// A text that shows as it is in documentation.
pub(super) fn documentation(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        if matches!(letter, '[' | ']' | '<' | '>' | '*' | '_' | '`' | '\\') {
            escaped.push('\\');
        }
        escaped.push(letter);
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_snake_case() {
        for (name, snake) in [
            ("Controlword", "controlword"),
            ("COB-ID client to server (rx)", "cob_id_client_to_server_rx"),
            ("  Max.  motor-speed ", "max_motor_speed"),
            ("2nd axis", "object_2nd_axis"),
            ("Größe", "gr_e"),
            ("", "object_"),
        ] {
            assert_eq!(snake_case(name), snake);
        }
    }

    #[test]
    fn names_that_are_taken_get_their_number() {
        let names = [
            "speed",
            "set_speed",
            "speed_limit",
            "type",
            "twice",
            "twice",
        ];
        let numbered = (0..)
            .zip(names)
            .map(|(number, name)| (name.to_string(), format!("{number:04x}")))
            .collect();
        let expected = [
            "speed",
            "set_speed_0001",
            "speed_limit",
            "type_0003",
            "twice_0004",
            "twice_0005",
        ];
        assert_eq!(unique(numbered), expected);
    }

    #[test]
    fn a_number_makes_no_name_that_is_taken() {
        let unique_of = |names: &[(&str, &str)]| {
            let names = names
                .iter()
                .map(|(name, number)| ((*name).into(), (*number).into()));
            unique(names.collect())
        };
        assert_eq!(
            unique_of(&[("speed", "2000"), ("speed", "2001"), ("speed_2001", "2003")]),
            ["speed_2000", "speed_2001", "speed_2001_2003"]
        );
        assert_eq!(
            unique_of(&[
                ("speed", "2000"),
                ("speed", "2001"),
                ("set_speed_2000", "2002")
            ]),
            ["speed_2000", "speed_2001", "set_speed_2000_2002"]
        );
        assert_eq!(
            unique_of(&[
                ("set_speed", "2000"),
                ("set_speed", "2001"),
                ("speed_2000", "2002")
            ]),
            ["set_speed_2000", "set_speed_2001", "speed_2000_2002"]
        );
        assert_eq!(
            unique_of(&[("a", "1"), ("a", "2"), ("a_1", "3"), ("a_1_3", "4")]),
            ["a_1", "a_2", "a_1_3", "a_1_3_4"]
        );
    }

    #[test]
    fn reserved_words_are_each_there_once() {
        assert!(RESERVED.is_sorted_by(|left, right| left < right));
    }
}

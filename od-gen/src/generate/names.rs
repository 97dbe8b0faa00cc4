//! Names of the standards as names of Rust.

use std::collections::BTreeMap;

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

/// Puts the number behind each name that is not the only one of its kind, is a word of the language, or could be taken for
/// the setter of another.
fn unique(names: Vec<(String, String)>) -> Vec<String> {
    let mut uses = BTreeMap::<String, usize>::new();
    for (name, _) in &names {
        *uses.entry(name.clone()).or_default() += 1;
    }
    let is_free = |name: &str| {
        let is_setter = name
            .strip_prefix("set_")
            .is_some_and(|rest| uses.contains_key(rest));
        uses.get(name) == Some(&1) && !RESERVED.contains(&name) && !is_setter
    };
    let number = |(name, number): (String, String)| {
        if is_free(&name) {
            name
        } else {
            format!("{name}_{number}")
        }
    };
    names.into_iter().map(number).collect()
}

/// `Max. motor-speed (rpm)` is `max_motor_speed_rpm`.
fn snake_case(name: &str) -> String {
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
pub(super) fn camel_case(name: &str) -> String {
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
    fn reserved_words_are_each_there_once() {
        assert!(RESERVED.is_sorted_by(|left, right| left < right));
    }
}

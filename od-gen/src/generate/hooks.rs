//! What the application says to writes, and who serves the objects that are not in memory: typed, object by object.
//!
//! `Hooks` has two methods for each object that can be written, neither of which need be there: one is asked before the write,
//! one is told after it. `Streams` has one for each streamed object, which must be there. `Hooked` puts them behind the
//! interface of the node. A method that nobody writes is an empty one to the compiler, which leaves it out.

use super::accessors::value_type;
use super::documentation::{facts, title};
use super::format::{head, signature};
use super::layout::{Layout, Place, Row};
use super::values::{self, Value, is_value};
use super::{ABORT_CODE, ALLOW_UNUSED, names};

pub(super) fn write(layout: &Layout<'_>) -> String {
    let hooked: Vec<&Row<'_>> = layout.rows.iter().filter(|row| has_hooks(row)).collect();
    let with_application = |row: &&Row<'_>| row.place == Place::Application;
    let streamed: Vec<&Row<'_>> = layout
        .rows
        .iter()
        .filter(|row| with_application(row) && !is_value(row))
        .collect();
    let values = values::values(&layout.rows);
    let mut out = hooks(&hooked);
    out += &streams(&streamed);
    out += &values::write(&values);
    out += &adapter(&hooked, &streamed, &values);
    out
}

/// Whether the application is asked about writes to an object: to its own, not to those of the communication profile.
fn has_hooks(row: &Row<'_>) -> bool {
    let is_own = !(0x1000..=0x1FFF).contains(&row.object.index);
    is_own && row.entry.access.is_writable() && matches!(row.place, Place::Ram(_))
}

fn hooks(rows: &[&Row<'_>]) -> String {
    let mut out = String::from(
        "\
/// What the application says to writes. `check_` methods are asked before a write that keeps every rule of the data sheet; the
/// dictionary still has the old value, an error is sent to who writes, and nothing changes. `apply_` methods are told after
/// a write. Methods that are left out allow everything and do nothing.
",
    );
    out += ALLOW_UNUSED;
    out += "pub trait Hooks {\n";
    for row in rows {
        let name = &row.name;
        let value = format!("value: {}", value_type(row.entry.data_type));
        out += &format!("    /// {}: {}.\n", title(row), facts(row));
        out += &head(
            4,
            &format!("fn check_{name}"),
            &["&mut self", "dictionary: &Dictionary", &value],
            &format!("Result<(), {ABORT_CODE}>"),
        );
        out += "        let _ = (dictionary, value);\n        Ok(())\n    }\n\n";
        out += &format!("    /// {} has been written.\n", title(row));
        out += &head(
            4,
            &format!("fn apply_{name}"),
            &["&mut self", "dictionary: &mut Dictionary"],
            "",
        );
        out += "        let _ = dictionary;\n    }\n\n";
    }
    out += "    /// Power-on values have been loaded.\n";
    out += "    fn power_on(&mut self, dictionary: &mut Dictionary) {\n        let _ = dictionary;\n    }\n}\n\n";
    out
}

fn streams(rows: &[&Row<'_>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut out = String::from(
        "/// Who serves the objects whose values are not in memory: read and written piece by piece, never whole.\n",
    );
    out += ALLOW_UNUSED;
    out += "pub trait Streams {\n";
    let types = names::stream_types(rows);
    for (number, (row, own_type)) in rows.iter().zip(types).enumerate() {
        if number > 0 {
            out += "\n";
        }
        let access = row.entry.access;
        let kind = match (access.is_readable(), access.is_writable()) {
            (true, true) => "::canopen::Source<Dictionary> + ::canopen::Sink<Dictionary>",
            (true, false) => "::canopen::Source<Dictionary>",
            (false, _) => "::canopen::Sink<Dictionary>",
        };
        let (title, facts) = (title(row), facts(row));
        out += &format!("    /// What serves {title}.\n    type {own_type}: {kind};\n\n");
        out += &format!("    /// {title}: {facts}.\n");
        let start = format!("fn {}", row.name);
        out += &signature(4, &start, &["&mut self"], &format!("&mut Self::{own_type}"));
    }
    out += "}\n\n";
    out
}

/// The calls of `canopen::Application` for streamed objects: name, arguments with their types, result, trait and method behind
/// it, and what an entry gets that is not streamed.
struct StreamCall {
    name: &'static str,
    dictionary: &'static str,
    arguments: &'static [(&'static str, &'static str)],
    result: &'static str,
    is_write: bool,
    method: &'static str,
    otherwise: &'static str,
}

const STREAM_CALLS: [StreamCall; 6] = [
    StreamCall {
        name: "size",
        dictionary: "&Dictionary",
        arguments: &[],
        result: "Option<u32>",
        is_write: false,
        method: "::canopen::Source::size",
        otherwise: "Err(::canopen::cia301::sdo::AbortCode::UnsupportedAccess)",
    },
    StreamCall {
        name: "read_at",
        dictionary: "&Dictionary",
        arguments: &[("position", "u32"), ("into", "&mut [u8]")],
        result: "usize",
        is_write: false,
        method: "::canopen::Source::read_at",
        otherwise: "Err(::canopen::cia301::sdo::AbortCode::UnsupportedAccess)",
    },
    StreamCall {
        name: "begin_write",
        dictionary: "&Dictionary",
        arguments: &[("size", "Option<u32>")],
        result: "()",
        is_write: true,
        method: "::canopen::Sink::begin",
        otherwise: "Err(::canopen::cia301::sdo::AbortCode::UnsupportedAccess)",
    },
    StreamCall {
        name: "write_at",
        dictionary: "&Dictionary",
        arguments: &[("position", "u32"), ("data", "&[u8]")],
        result: "()",
        is_write: true,
        method: "::canopen::Sink::write_at",
        otherwise: "Err(::canopen::cia301::sdo::AbortCode::UnsupportedAccess)",
    },
    StreamCall {
        name: "end_write",
        dictionary: "&mut Dictionary",
        arguments: &[("length", "u32")],
        result: "::canopen::cia301::sdo::Completion",
        is_write: true,
        method: "::canopen::Sink::end",
        otherwise: "Err(::canopen::cia301::sdo::AbortCode::UnsupportedAccess)",
    },
    StreamCall {
        name: "abandon_write",
        dictionary: "&Dictionary",
        arguments: &[],
        result: "",
        is_write: true,
        method: "::canopen::Sink::abandon",
        otherwise: "{}",
    },
];

fn adapter(hooked: &[&Row<'_>], streamed: &[&Row<'_>], values: &[Value<'_>]) -> String {
    let mut bounds = String::from("Hooks");
    if !streamed.is_empty() {
        bounds += " + Streams";
    }
    if !values.is_empty() {
        bounds += " + Values";
    }
    let mut out =
        String::from("/// An application with hooks, as the node takes it.\n#[derive(Debug)]\n");
    out += ALLOW_UNUSED;
    out += "pub struct Hooked<A>(pub A);\n\n";
    // One line for each object, however long its name is.
    out += "#[rustfmt::skip]\n";
    out += &format!("impl<A: {bounds}> ::canopen::Application<Dictionary> for Hooked<A> {{\n");
    if !hooked.is_empty() {
        out += &validate(hooked);
        out += "\n";
        out += &written(hooked);
        out += "\n";
    }
    for call in &STREAM_CALLS {
        let is_for = |row: &&&Row<'_>| {
            let access = row.entry.access;
            if call.is_write {
                access.is_writable()
            } else {
                access.is_readable()
            }
        };
        let rows: Vec<&Row<'_>> = streamed.iter().filter(is_for).copied().collect();
        let values = values.iter().filter(|value| value.allows(call.is_write));
        let arms: String = match call.name {
            "read_at" => values.map(Value::read_arm).collect(),
            "write_at" => values.map(Value::write_arm).collect(),
            // What has no streams needs no word on their end.
            "end_write" if !rows.is_empty() => values.map(Value::end_arm).collect(),
            _ => String::new(),
        };
        if !rows.is_empty() || !arms.is_empty() {
            out += &stream(call, &rows, &arms);
            out += "\n";
        }
    }
    out += "    fn power_on(&mut self, dictionary: &mut Dictionary) {\n        Hooks::power_on(&mut self.0, dictionary);\n    }\n}\n\n";
    out
}

fn validate(rows: &[&Row<'_>]) -> String {
    let mut out = head(
        4,
        "fn validate",
        &[
            "&mut self",
            "dictionary: &Dictionary",
            "entry: &::canopen::od::Entry",
            "value: &[u8]",
        ],
        &format!("Result<(), {ABORT_CODE}>"),
    );
    out += "        let Self(hooks) = self;\n        match (entry.index, entry.sub) {\n";
    for row in rows {
        let is_text = row.entry.data_type.size().is_none();
        let value = if is_text {
            "value"
        } else {
            "::canopen::od::Value::of(value)"
        };
        let start = format!("Hooks::check_{}", row.name);
        out += &arm(row, &start, &["hooks", "dictionary", value]);
    }
    out += "            _ => Ok(()),\n        }\n    }\n";
    out
}

fn written(rows: &[&Row<'_>]) -> String {
    let mut out = allow_single(rows, true);
    out += &head(
        4,
        "fn written",
        &[
            "&mut self",
            "dictionary: &mut Dictionary",
            "entry: &::canopen::od::Entry",
        ],
        "",
    );
    out += "        let Self(hooks) = self;\n        match (entry.index, entry.sub) {\n";
    for row in rows {
        let start = format!("Hooks::apply_{}", row.name);
        out += &arm(row, &start, &["hooks", "dictionary"]);
    }
    out += "            _ => {}\n        }\n    }\n";
    out
}

fn stream(call: &StreamCall, rows: &[&Row<'_>], values: &str) -> String {
    let dictionary = format!("dictionary: {}", call.dictionary);
    let own: Vec<String> = call
        .arguments
        .iter()
        .map(|(name, its_type)| match *name {
            // A number comes whole.
            "position" if rows.is_empty() => format!("_: {its_type}"),
            name => format!("{name}: {its_type}"),
        })
        .collect();
    let mut arguments = vec!["&mut self", &dictionary, "entry: &::canopen::od::Entry"];
    arguments.extend(own.iter().map(String::as_str));
    let result = if call.result.is_empty() {
        String::new()
    } else {
        format!("Result<{}, {ABORT_CODE}>", call.result)
    };
    let mut out = allow_single(rows, call.result.is_empty());
    out += &head(4, &format!("fn {}", call.name), &arguments, &result);
    out += "        let Self(streams) = self;\n        match (entry.index, entry.sub) {\n";
    for row in rows {
        let stream = format!("streams.{}()", row.name);
        let mut passed = vec![stream.as_str(), "dictionary"];
        passed.extend(call.arguments.iter().map(|(name, _)| *name));
        out += &arm(row, call.method, &passed);
    }
    out += values;
    let end = if call.otherwise == "{}" { "" } else { "," };
    out += &format!(
        "            _ => {}{end}\n        }}\n    }}\n",
        call.otherwise
    );
    out
}

/// A lint would have an `if` where a data sheet has only one object of a kind.
fn allow_single(rows: &[&Row<'_>], is_unit: bool) -> String {
    if is_unit && rows.len() == 1 {
        "    #[allow(clippy::single_match, reason = \"there could be more objects\")]\n".into()
    } else {
        String::new()
    }
}

fn key(row: &Row<'_>) -> String {
    format!("(0x{:04X}, {})", row.object.index, row.entry.sub)
}

/// One arm of a `match` whose body is a call.
fn arm(row: &Row<'_>, function: &str, arguments: &[&str]) -> String {
    format!(
        "            {} => {function}({}),\n",
        key(row),
        arguments.join(", ")
    )
}

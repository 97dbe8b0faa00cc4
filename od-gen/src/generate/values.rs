//! Numbers that the application has (`;Memory=application`), such as the elements of large arrays: typed, one at a time.
//!
//! `Values` has a method for each that can be read and one for each that can be written. The elements of an ARRAY share theirs, which
//! are told the sub-index.

use super::accessors::{is_narrow, value_type};
use super::documentation::{facts, title};
use super::format::signature;
use super::layout::{Place, Row};
use super::{ABORT_CODE, ALLOW_UNUSED, names};
use crate::data_type::DataType;
use crate::model::ObjectType;

/// What one pair of methods is for: one value, or the elements of an array.
#[derive(Debug)]
pub(super) struct Value<'a> {
    /// In ascending order of the sub-index; never empty.
    rows: Vec<&'a Row<'a>>,
    name: String,
}

/// Those among the rows that the application has.
pub(super) fn values<'a>(rows: &'a [Row<'a>]) -> Vec<Value<'a>> {
    let mut groups: Vec<Vec<&Row<'_>>> = Vec::new();
    for row in rows.iter().filter(|row| is_value(row)) {
        match groups
            .last_mut()
            .filter(|group| group.iter().all(|other| is_brother(row, other)))
        {
            Some(group) => group.push(row),
            None => groups.push(vec![row]),
        }
    }
    let names = names::values(&groups);
    let pairs = groups.into_iter().zip(names);
    pairs.map(|(rows, name)| Value { rows, name }).collect()
}

/// Whether the application has a number; a text is streamed.
pub(super) fn is_value(row: &Row<'_>) -> bool {
    row.place == Place::Application && row.entry.data_type.size().is_some()
}

/// Whether two rows are elements of one array.
fn is_brother(row: &Row<'_>, other: &Row<'_>) -> bool {
    let is_array = row.object.object_type == ObjectType::Array;
    let kind = |row: &Row<'_>| (row.object.index, row.entry.data_type, row.entry.access);
    is_array && kind(row) == kind(other)
}

/// The trait; nothing where there are no such values.
pub(super) fn write(values: &[Value<'_>]) -> String {
    if values.is_empty() {
        return String::new();
    }
    let mut out = String::from(
        "/// Who has the numbers that are not in memory: asked for one of them at a time. An error is sent to who reads or writes. What is\n\
         /// written has passed every rule of the data sheet.\n",
    );
    out += ALLOW_UNUSED;
    out += "pub trait Values {\n";
    let mut methods = Vec::new();
    for value in values {
        let access = value.first().map(|row| row.entry.access);
        if access.is_some_and(|access| access.is_readable()) {
            methods.push(value.getter());
        }
        if access.is_some_and(|access| access.is_writable()) {
            methods.push(value.setter());
        }
    }
    out + &methods.join("\n") + "}\n\n"
}

impl Value<'_> {
    fn first(&self) -> Option<&Row<'_>> {
        self.rows.first().copied()
    }

    fn data_type(&self) -> DataType {
        let first = self.first();
        first.map_or(DataType::Unsigned8, |row| row.entry.data_type)
    }

    /// Whether it can be read, or written.
    pub(super) fn allows(&self, is_write: bool) -> bool {
        self.first().is_some_and(|row| match is_write {
            true => row.entry.access.is_writable(),
            false => row.entry.access.is_readable(),
        })
    }

    fn is_array(&self) -> bool {
        self.rows.len() > 1
    }

    /// What it is, for the comments.
    fn title(&self) -> String {
        let Some(first) = self.first() else {
            return String::new();
        };
        match self.rows.last().filter(|_| self.is_array()) {
            Some(last) => {
                let object = names::documentation(&first.object.name);
                let (index, low, high) = (first.object.index, first.entry.sub, last.entry.sub);
                format!("{index:04X}h:{low} to {index:04X}h:{high}, {object}")
            }
            None => title(first),
        }
    }

    fn getter(&self) -> String {
        let facts = self.first().map(facts).unwrap_or_default();
        let result = format!("Result<{}, {ABORT_CODE}>", value_type(self.data_type()));
        let mut arguments = vec!["&mut self", "dictionary: &Dictionary"];
        if self.is_array() {
            arguments.push("sub: u8");
        }
        let head = signature(4, &format!("fn {}", self.name), &arguments, &result);
        format!("    /// {}: {facts}.\n{head}", self.title())
    }

    fn setter(&self) -> String {
        let value = format!("value: {}", value_type(self.data_type()));
        let mut arguments = vec!["&mut self", "dictionary: &Dictionary"];
        if self.is_array() {
            arguments.push("sub: u8");
        }
        arguments.push(&value);
        let result = format!("Result<(), {ABORT_CODE}>");
        let head = signature(4, &format!("fn set_{}", self.name), &arguments, &result);
        format!("    /// Takes a new value of {}.\n{head}", self.title())
    }

    /// The pattern that its entries match; `sub` is bound where it is needed.
    fn pattern(&self, is_bound: bool) -> String {
        let index = self.first().map_or(0, |row| row.object.index);
        let mut runs: Vec<(u8, u8)> = Vec::new();
        for row in &self.rows {
            let sub = row.entry.sub;
            match runs
                .last_mut()
                .filter(|(_, last)| last.checked_add(1) == Some(sub))
            {
                Some((_, last)) => *last = sub,
                None => runs.push((sub, sub)),
            }
        }
        let runs: Vec<String> = runs
            .into_iter()
            .map(|(first, last)| match first == last {
                true => first.to_string(),
                false => format!("{first}..={last}"),
            })
            .collect();
        let subs = runs.join(" | ");
        match self.is_array() && is_bound {
            true if runs.len() > 1 => format!("(0x{index:04X}, sub @ ({subs}))"),
            true => format!("(0x{index:04X}, sub @ {subs})"),
            false => format!("(0x{index:04X}, {subs})"),
        }
    }

    /// The arm of `read_at`: the bytes of the value.
    pub(super) fn read_arm(&self) -> String {
        let (pattern, name) = (self.pattern(true), &self.name);
        let sub = if self.is_array() { ", sub" } else { "" };
        let bytes = self.bytes();
        format!(
            "            {pattern} => {{\n                let value = Values::{name}(streams, dictionary{sub})?;\n                \
             Ok(::canopen::od::give({bytes}, into))\n            }}\n"
        )
    }

    /// The bytes of `value`, an expression.
    fn bytes(&self) -> String {
        let data_type = self.data_type();
        if data_type == DataType::Boolean {
            return "[u8::from(value)]".into();
        }
        if !is_narrow(data_type) {
            return "value.to_le_bytes()".into();
        }
        let sign = if data_type.is_signed() {
            "signed"
        } else {
            "unsigned"
        };
        let size = data_type.size().unwrap_or_default();
        // 40 bits and more are numbers of 64 bits already.
        let wide = if size > 4 { "value" } else { "value.into()" };
        format!("::canopen::od::{sign}_bytes::<{size}>({wide})?")
    }

    /// The arm of `write_at`.
    pub(super) fn write_arm(&self) -> String {
        let (pattern, name) = (self.pattern(true), &self.name);
        let sub = if self.is_array() { ", sub" } else { "" };
        format!(
            "            {pattern} => Values::set_{name}(streams, dictionary{sub}, ::canopen::od::Value::of(data)),\n"
        )
    }

    /// The arm of `end_write`: it has been taken already.
    pub(super) fn end_arm(&self) -> String {
        let pattern = self.pattern(false);
        format!("            {pattern} => Ok(::canopen::cia301::sdo::Completion::Now),\n")
    }
}

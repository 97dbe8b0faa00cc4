//! A getter for each value in memory, a setter for each number in RAM.

use super::layout::{Layout, Place, Row};
use super::{ALLOW_UNUSED, names};
use crate::data_type::DataType;
use crate::model::DefaultValue;

pub(super) fn write(layout: &Layout<'_>) -> String {
    let mut out = String::from("/// Typed access to each value.\n");
    out += ALLOW_UNUSED;
    out += "impl Dictionary {\n";
    let in_memory = |row: &Row<'_>| row.place != Place::Application;
    let rows = layout.rows.iter().enumerate();
    for (number, (position, row)) in rows.filter(|(_, row)| in_memory(row)).enumerate() {
        if number > 0 {
            out += "\n";
        }
        out += &getter(position, row);
        out += &setter(row);
    }
    out += "}\n\n";
    out
}

/// The Rust type of a number.
pub(super) fn number_type(data_type: DataType) -> Option<&'static str> {
    Some(match data_type {
        DataType::Boolean => "bool",
        DataType::Integer8 => "i8",
        DataType::Integer16 => "i16",
        DataType::Integer24 | DataType::Integer32 => "i32",
        DataType::Integer40 | DataType::Integer48 | DataType::Integer56 | DataType::Integer64 => {
            "i64"
        }
        DataType::Unsigned8 => "u8",
        DataType::Unsigned16 => "u16",
        DataType::Unsigned24 | DataType::Unsigned32 => "u32",
        DataType::Unsigned40
        | DataType::Unsigned48
        | DataType::Unsigned56
        | DataType::Unsigned64
        | DataType::TimeOfDay
        | DataType::TimeDifference => "u64",
        DataType::Real32 => "f32",
        DataType::Real64 => "f64",
        DataType::VisibleString
        | DataType::OctetString
        | DataType::UnicodeString
        | DataType::Domain => return None,
    })
}

/// Which value this is: `1018h:4, Identity object: Serial number`.
pub(super) fn title(row: &Row<'_>) -> String {
    let index = row.object.index;
    let object = names::documentation(&row.object.name);
    if row.object.object_type.has_subs() {
        let value = names::documentation(&row.entry.name);
        format!("{index:04X}h:{}, {object}: {value}", row.entry.sub)
    } else {
        format!("{index:04X}h, {object}")
    }
}

fn getter(position: usize, row: &Row<'_>) -> String {
    let (title, name) = (title(row), &row.name);
    let size = usize::from(row.entry.size);
    let is_text = row.entry.data_type == DataType::VisibleString;
    let (constness, returned, body) = match (
        row.place,
        number_type(row.entry.data_type),
        &row.entry.default,
    ) {
        (Place::Rom(_), Some("bool"), DefaultValue::Number { value, .. }) => {
            ("const ", "bool", (*value != 0).to_string())
        }
        (Place::Rom(_), Some(number), DefaultValue::Number { value, .. }) => {
            ("const ", number, literal(*value, row.entry.data_type))
        }
        (Place::Rom(_), Some(number), DefaultValue::Real(value)) => {
            ("const ", number, format!("{value:?}"))
        }
        (Place::Rom(_), None, DefaultValue::Text(bytes)) if is_text => (
            "const ",
            "&'static str",
            format!("{:?}", String::from_utf8_lossy(bytes)),
        ),
        (Place::Rom(_), _, DefaultValue::Text(bytes)) => {
            ("const ", "&'static [u8]", format!("&{bytes:?}"))
        }
        (Place::Ram(offset), Some("bool"), _) => ("", "bool", format!("self.ram[{offset}] != 0")),
        (Place::Ram(offset), Some(number), _) => {
            let bytes: Vec<String> = (offset..offset + size)
                .map(|at| format!("self.ram[{at}]"))
                .collect();
            // The type of Rust may be wider: the value is shifted down from its top, which keeps the sign.
            let missing = width(number) - size;
            let bytes = [vec![String::from("0"); missing], bytes].concat();
            let mut body = format!("{number}::from_le_bytes([{}])", bytes.join(", "));
            if missing > 0 {
                body += &format!(" >> {}", 8 * missing);
            }
            ("", number, body)
        }
        // A string, in RAM.
        _ => (
            "",
            "&[u8]",
            format!("::canopen::od::value(self, &table::ENTRIES[{position}])"),
        ),
    };
    format!(
        "    /// {title}.\n    pub {constness}fn {name}(&self) -> {returned} {{\n        {body}\n    }}\n"
    )
}

/// The bytes of a type of Rust.
fn width(number: &str) -> usize {
    match number {
        "i32" | "u32" | "f32" => 4,
        "i64" | "u64" | "f64" => 8,
        "i16" | "u16" => 2,
        _ => 1,
    }
}

/// A number the way its type is usually written: bit patterns in hexadecimal.
fn literal(value: i128, data_type: DataType) -> String {
    let size = usize::from(data_type.size().unwrap_or_default());
    if data_type.is_signed() || size == 1 {
        value.to_string()
    } else {
        format!("0x{value:0digits$X}", digits = 2 * size)
    }
}

fn setter(row: &Row<'_>) -> String {
    let (Place::Ram(offset), Some(number)) = (row.place, number_type(row.entry.data_type)) else {
        return String::new();
    };
    let size = usize::from(row.entry.size);
    let body = if number == "bool" {
        format!("        self.ram[{offset}] = u8::from(value);\n")
    } else {
        let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
        let bytes = names.get(..size).unwrap_or_default();
        let rest = if width(number) > size { ", .." } else { "" };
        let mut body = format!(
            "        let [{}{rest}] = value.to_le_bytes();\n",
            bytes.join(", ")
        );
        for (at, byte) in (offset..).zip(bytes) {
            body += &format!("        self.ram[{at}] = {byte};\n");
        }
        body
    };
    let (title, name) = (title(row), &row.name);
    format!(
        "\n    /// Sets {title}.\n    pub fn set_{name}(&mut self, value: {number}) {{\n{body}    }}\n"
    )
}

//! A getter for each value in memory, a setter for each one in RAM.

use super::documentation::{facts, title};
use super::format::head;
use super::layout::{Layout, Place, Row};
use super::{ABORT_CODE, ALLOW_UNUSED};
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
        getter(&mut out, position, row);
        setter(&mut out, position, row);
    }
    out += "}\n\n";
    out
}

/// The Rust type of a value: of a number, a time or a string.
pub(super) fn value_type(data_type: DataType) -> &'static str {
    match data_type {
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
        | DataType::Unsigned64 => "u64",
        DataType::Real32 => "f32",
        DataType::Real64 => "f64",
        DataType::TimeOfDay | DataType::TimeDifference => "::canopen::od::DayTime",
        DataType::VisibleString
        | DataType::OctetString
        | DataType::UnicodeString
        | DataType::Domain => "&[u8]",
    }
}

/// Whether a number has fewer bytes than its Rust type.
pub(super) fn is_narrow(data_type: DataType) -> bool {
    let size = data_type.size().unwrap_or_default();
    data_type.range().is_some() && matches!(size, 3 | 5..=7) && !is_time(data_type)
}

fn is_time(data_type: DataType) -> bool {
    matches!(data_type, DataType::TimeOfDay | DataType::TimeDifference)
}

/// The value of `bytes`, an expression for an array that has the size of the type.
fn from_bytes(data_type: DataType, bytes: &str) -> String {
    let value_type = value_type(data_type);
    if data_type == DataType::Boolean {
        format!("{bytes} != [0]")
    } else if is_narrow(data_type) {
        let sign = if data_type.is_signed() {
            "signed"
        } else {
            "unsigned"
        };
        let size = data_type.size().unwrap_or_default();
        let cast = if size == 3 {
            format!(" as {value_type}")
        } else {
            String::new()
        };
        format!("::canopen::od::{sign}::<{size}>({bytes}){cast}")
    } else {
        format!("{value_type}::from_le_bytes({bytes})")
    }
}

fn getter(out: &mut String, position: usize, row: &Row<'_>) {
    let data_type = row.entry.data_type;
    let own_type = value_type(data_type);
    let is_text = data_type == DataType::VisibleString;
    let default = row.entry.initial();
    let (constness, returned, body) = match (row.place, &default) {
        (Place::Rom(_), DefaultValue::Text(bytes)) if is_text => (
            "const ",
            "&'static str",
            format!("{:?}", String::from_utf8_lossy(bytes)),
        ),
        (Place::Rom(_), DefaultValue::Text(bytes)) => (
            "const ",
            "&'static [u8]",
            format!("b\"{}\"", bytes.escape_ascii()),
        ),
        (Place::Rom(_), default) => ("const ", own_type, literal(default, data_type)),
        (Place::Ram(offset), DefaultValue::Number { .. } | DefaultValue::Real(_)) => {
            let size = row.entry.size;
            let bytes = format!("::canopen::od::bytes_at::<{offset}, {size}, _>(&self.ram)");
            ("", own_type, from_bytes(data_type, &bytes))
        }
        // A string in RAM.
        _ => (
            "",
            own_type,
            format!("::canopen::od::value(self, &table::ENTRIES[{position}])"),
        ),
    };
    *out += &format!(
        "    /// {}.\n    ///\n    /// {}.\n",
        title(row),
        facts(row)
    );
    *out += &head(
        4,
        &format!("pub {constness}fn {}", row.name),
        &["&self"],
        returned,
    );
    *out += &format!("        {body}\n    }}\n");
}

/// A number the way its type is usually written: bit patterns in hexadecimal.
fn literal(default: &DefaultValue, data_type: DataType) -> String {
    let size = usize::from(data_type.size().unwrap_or_default());
    match (default, data_type) {
        (DefaultValue::Number { value, .. }, DataType::Boolean) => (*value != 0).to_string(),
        (DefaultValue::Number { value, .. }, _) if is_time(data_type) => {
            let bytes: Vec<String> = value
                .to_le_bytes()
                .iter()
                .take(size)
                .map(u8::to_string)
                .collect();
            format!(
                "::canopen::od::DayTime::from_le_bytes([{}])",
                bytes.join(", ")
            )
        }
        (DefaultValue::Number { value, .. }, _) if data_type.is_signed() || size == 1 => {
            value.to_string()
        }
        (DefaultValue::Number { value, .. }, _) => {
            format!("0x{value:0digits$X}", digits = 2 * size)
        }
        #[allow(
            clippy::cast_possible_truncation,
            reason = "a REAL32 holds what fits in it"
        )]
        (DefaultValue::Real(value), DataType::Real32) => {
            format!("f32::from_bits(0x{:08X})", (*value as f32).to_bits())
        }
        (DefaultValue::Real(value), _) => format!("f64::from_bits(0x{:016X})", value.to_bits()),
        (DefaultValue::Text(_), _) => String::new(),
    }
}

fn setter(out: &mut String, position: usize, row: &Row<'_>) {
    let Place::Ram(offset) = row.place else {
        return;
    };
    let (data_type, size) = (row.entry.data_type, row.entry.size);
    let value = format!("value: {}", value_type(data_type));
    *out += &format!("\n    /// Sets {}.\n", title(row));
    let start = format!("pub fn set_{}", row.name);
    let arguments = ["&mut self", value.as_str()];
    let put = |bytes: &str| {
        format!("        ::canopen::od::put_at::<{offset}, {size}, _>(&mut self.ram, {bytes});\n")
    };
    if data_type.size().is_none() {
        *out += &format!(
            "    ///\n    /// # Errors\n    /// 06070012h, length too high: more than {size} bytes.\n"
        );
        *out += &head(4, &start, &arguments, &format!("Result<(), {ABORT_CODE}>"));
        *out += &format!("        ::canopen::od::set(self, &table::ENTRIES[{position}], value)\n");
    } else if is_narrow(data_type) {
        let sign = if data_type.is_signed() {
            "signed"
        } else {
            "unsigned"
        };
        let bits = size * 8;
        *out += &format!(
            "    ///\n    /// # Errors\n    /// The number does not fit into {bits} bits.\n"
        );
        *out += &head(
            4,
            &start,
            &arguments,
            "Result<(), ::canopen::od::OutOfRange>",
        );
        // 40 bits and more are numbers of 64 bits already.
        let wide = if size > 4 { "value" } else { "value.into()" };
        *out += &format!("        let bytes = ::canopen::od::{sign}_bytes::<{size}>({wide})?;\n");
        *out += &put("bytes");
        *out += "        Ok(())\n";
    } else {
        *out += &head(4, &start, &arguments, "");
        *out += &put(if data_type == DataType::Boolean {
            "[u8::from(value)]"
        } else {
            "value.to_le_bytes()"
        });
    }
    *out += "    }\n";
}

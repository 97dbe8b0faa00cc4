//! What the device does in the way of its maker, as constants of the dictionary.

use std::fmt::Write;

use crate::bind::{Bindings, ErrorMapping, Habit, Owner};

/// The constant of the node; empty where all is as the standards say.
pub(super) fn of_node(bound: &Bindings) -> String {
    let habits = &bound.habits;
    let (mut node_id, mut bit_rate) = (None, None);
    let mut fields = String::new();
    for habit in habits
        .iter()
        .filter(|habit| habit.known.owner == Owner::Node)
    {
        match habit.known.name {
            "node_id" => node_id = Some(&habit.value),
            "bit_rate" => bit_rate = Some(&habit.value),
            _ => field(&mut fields, habit),
        }
    }
    let is_setting =
        |habit: &Habit| matches!(habit.known.name, "node_id_object" | "bit_rate_object");
    if habits.iter().any(is_setting) {
        fields += "        settings_are_objects: true,\n";
    }
    if !bound.errors.is_empty() {
        let rows: String = bound.errors.iter().map(error_mapping).collect();
        fields += &format!("        errors: &[\n{rows}        ],\n");
    }
    if node_id.is_some() || bit_rate.is_some() {
        let node_id = node_id.map_or_else(
            || "::canopen::NodeId::UNCONFIGURED".to_owned(),
            |id| {
                format!(
                    "match ::canopen::NodeId::new({id}) {{\n                \
                     Some(node_id) => node_id,\n                \
                     None => ::canopen::NodeId::UNCONFIGURED,\n            }}"
                )
            },
        );
        let bit_rate = bit_rate.map_or("1000", String::as_str);
        // Writing to a text cannot fail.
        let _ = write!(
            fields,
            "        factory: ::canopen::Configuration {{\n            node_id: {node_id},\n            \
             bit_timing: ::canopen::BitTiming::Fixed(::canopen::BitRate::Kbit{bit_rate}),\n        }},\n"
        );
    }
    constant("HABITS", "::canopen::od::Habits", &fields)
}

fn error_mapping(mapping: &ErrorMapping) -> String {
    let ErrorMapping {
        cause,
        code,
        register,
        info,
        history,
        number_byte,
    } = mapping;
    format!(
        "            ::canopen::od::ErrorMapping {{
                cause: 0x{cause:04X},
                code: 0x{code:04X},
                register: 0x{register:02X},
                info: {info:?},
                history: 0x{history:04X},
                number_byte: {number_byte:?},
            }},\n"
    )
}

/// The constant of the drive.
pub(super) fn of_drive(habits: &[Habit]) -> String {
    let mut fields = String::new();
    for habit in habits
        .iter()
        .filter(|habit| habit.known.owner == Owner::Drive)
    {
        field(&mut fields, habit);
    }
    let mut objects = String::new();
    for habit in habits {
        let name = match habit.known.name {
            "node_id_object" => "node_id",
            "bit_rate_object" => "bit_rate",
            "bit_rate_numbers" => "bit_rates",
            "serial_number_object" => "serial_number",
            _ => continue,
        };
        objects += &format!("            {name}: {},\n", habit.value);
    }
    if !objects.is_empty() {
        const OF: &str = "::cia402::NetworkObjects";
        fields +=
            &format!("        network: {OF} {{\n{objects}            ..{OF}::OWN\n        }},\n");
    }
    constant("DRIVE_HABITS", "::cia402::Habits", &fields)
}

fn field(fields: &mut String, habit: &Habit) {
    let _ = writeln!(fields, "        {}: {},", habit.known.name, habit.value);
}

fn constant(name: &str, of: &str, fields: &str) -> String {
    if fields.is_empty() {
        return String::new();
    }
    format!(
        "    #[allow(clippy::needless_update, reason = \"there could be more habits\")]\n    \
         const {name}: {of} = {of} {{\n{fields}        ..{of}::STANDARD\n    }};\n\n"
    )
}

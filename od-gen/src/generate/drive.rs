//! The CiA 402 objects as the firmware sees them: an implementation of `cia402::Objects`.
//!
//! Each method has the type of the data sheet, so a data sheet that disagrees with the firmware does not compile. Objects the
//! data sheet leaves out keep the trait's own answer.

use super::accessors::value_type;
use super::documentation::title;
use super::layout::Layout;

enum Way {
    Get,
    Set,
}

/// The methods of `cia402::Objects`: name of the object, its place in the dictionary, and the way it goes.
const OBJECTS: [(&str, u16, u8, Way); 19] = [
    ("error_code", 0x603F, 0, Way::Set),
    ("controlword", 0x6040, 0, Way::Get),
    ("statusword", 0x6041, 0, Way::Set),
    ("quick_stop_option_code", 0x605A, 0, Way::Get),
    ("modes_of_operation", 0x6060, 0, Way::Get),
    ("modes_of_operation_display", 0x6061, 0, Way::Set),
    ("position_demand_value", 0x6062, 0, Way::Set),
    ("position_actual_internal_value", 0x6063, 0, Way::Set),
    ("position_actual_value", 0x6064, 0, Way::Set),
    ("position_window", 0x6067, 0, Way::Get),
    ("position_window_time", 0x6068, 0, Way::Get),
    ("target_position", 0x607A, 0, Way::Get),
    ("min_position_limit", 0x607D, 1, Way::Get),
    ("max_position_limit", 0x607D, 2, Way::Get),
    ("profile_velocity", 0x6081, 0, Way::Get),
    ("profile_acceleration", 0x6083, 0, Way::Get),
    ("profile_deceleration", 0x6084, 0, Way::Get),
    ("quick_stop_deceleration", 0x6085, 0, Way::Get),
    ("supported_drive_modes", 0x6502, 0, Way::Get),
];

pub(super) fn write(layout: &Layout<'_>) -> String {
    let mut methods = Vec::new();
    for (method, index, sub, way) in OBJECTS {
        let Some(row) = layout.row(index, sub) else {
            continue;
        };
        // Where the trait has another type, the compiler says so.
        let number = value_type(row.entry.data_type);
        let (title, own) = (title(row), &row.name);
        methods.push(match way {
            Way::Get => format!(
                "    // {title}.\n    fn {method}(&self) -> {number} {{\n        Self::{own}(self)\n    }}\n"
            ),
            Way::Set => format!(
                "    // {title}.\n    fn set_{method}(&mut self, value: {number}) {{\n        Self::set_{own}(self, value);\n    }}\n"
            ),
        });
    }
    format!(
        "impl ::cia402::Objects for Dictionary {{\n{}}}\n\n",
        methods.join("\n")
    )
}

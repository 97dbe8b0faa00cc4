//! Indices by name, and how many PDOs there are.

use super::{ALLOW_UNUSED, names};
use crate::model::Model;

pub(super) fn write(model: &Model) -> String {
    let mut out = String::new();
    for (name, what, count) in [
        ("RPDO_COUNT", "receive PDOs", model.rpdo_count()),
        ("TPDO_COUNT", "transmit PDOs", model.tpdo_count()),
    ] {
        out += &format!(
            "/// How many {what} there are.\n{ALLOW_UNUSED}pub const {name}: usize = {count};\n\n"
        );
    }
    out += "/// The index of each object.\n";
    out += ALLOW_UNUSED;
    out += "pub mod index {\n";
    for (object, name) in model.objects.iter().zip(names::indices(model)) {
        let title = names::documentation(&object.name);
        out += &format!(
            "    /// {title}.\n    pub const {name}: u16 = 0x{:04X};\n",
            object.index
        );
    }
    out += "}\n\n";
    out
}

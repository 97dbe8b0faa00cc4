//! Indices by name, and how many of each service there are.

use super::format::constant;
use super::{ALLOW_UNUSED, names};
use crate::model::Model;

pub(super) fn write(model: &Model) -> String {
    let mut out = String::new();
    out += &counts(model);
    out += "/// The index of each object.\n";
    out += ALLOW_UNUSED;
    out += "pub mod index {\n";
    for (object, name) in model.objects.iter().zip(names::indices(model)) {
        let title = names::documentation(&object.name);
        out += &format!("    /// {title}.\n");
        out += &constant(
            4,
            &format!("pub const {name}: u16"),
            &format!("0x{:04X}", object.index),
        );
    }
    out += "}\n\n";
    out
}

/// The places that the services of the device need.
fn counts(model: &Model) -> String {
    let (rpdos, tpdos) = (model.rpdo_count(), model.tpdo_count());
    let (servers, consumers) = (model.sdo_server_count(), model.heartbeat_consumer_count());
    let mapped = model.mapped_object_count();
    format!(
        "/// Receive PDOs, transmit PDOs, SDO servers, heartbeat consumers, objects in a PDO.\n\
         pub type Counts = ::canopen::od::Count<{rpdos}, {tpdos}, {servers}, {consumers}, {mapped}>;\n\n"
    )
}

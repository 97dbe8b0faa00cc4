//! Indices by name, and how many of each service there are.

use super::format::constant;
use super::layout::Layout;
use super::{ALLOW_UNUSED, documentation, names};
use crate::model::Model;

pub(super) fn write(model: &Model, layout: &Layout<'_>) -> String {
    let mut out = String::new();
    out += &counts(model, layout);
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

/// Bytes that an SDO server needs at least: a segment, and one more.
const SHORTEST_BUFFER: u16 = 8;

/// Services that send, beside PDO and SDO: each has a bit in the words of senders.
const SERVICES: usize = 7;

/// The places that the services of the device need.
fn counts(model: &Model, layout: &Layout<'_>) -> String {
    let (rpdos, tpdos) = (model.rpdo_count(), model.tpdo_count());
    let (servers, consumers) = (model.sdo_server_count(), model.heartbeat_consumer_count());
    let mapped = model.mapped_object_count();
    // What the application serves piece by piece passes through the buffer too.
    let longest = layout.longest_in_ram().max(SHORTEST_BUFFER);
    // One word of senders is the default.
    let words = match (tpdos + servers + SERVICES).div_ceil(32) {
        1 => String::new(),
        words => format!(", {words}"),
    };
    format!(
        "/// Receive PDOs, transmit PDOs, SDO servers, heartbeat consumers, objects in a PDO, bytes of the longest value in RAM.\n\
         pub type Counts = ::canopen::od::Count<{rpdos}, {tpdos}, {servers}, {consumers}, {mapped}, {longest}{words}>;\n\n"
    )
}

/// What every value is called, for traces and tools.
pub(super) fn names(layout: &Layout<'_>) -> String {
    let count = layout.rows.len();
    let mut out =
        String::from("/// The name of each value, in the order of the descriptor table.\n");
    out += ALLOW_UNUSED;
    out += "#[rustfmt::skip]\n";
    out += &format!("pub static NAMES: [&str; {count}] = [\n");
    for row in &layout.rows {
        let name = if row.object.object_type.has_subs() {
            format!("{}: {}", row.object.name, row.entry.name)
        } else {
            row.object.name.clone()
        };
        out += &format!("    {name:?},\n");
    }
    out += "];\n\n";
    out += "/// What the data sheet says of each value, in the order of the descriptor table.\n";
    out += ALLOW_UNUSED;
    out += "#[rustfmt::skip]\n";
    out += &format!("pub static DESCRIPTIONS: [&str; {count}] = [\n");
    for row in &layout.rows {
        out += &format!("    {:?},\n", documentation::description(row));
    }
    out += "];\n\n";
    out
}

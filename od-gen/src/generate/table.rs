//! The descriptor table and the blocks of bytes.

use super::layout::{Layout, Place, Row};
use crate::data_type::DataType;
use crate::model::StorageGroup;

pub(super) fn write(layout: &Layout<'_>) -> String {
    let ram_size = layout.defaults.len();
    let entries: String = layout.rows.iter().map(entry).collect();
    let (count, buckets) = (layout.rows.len(), layout.buckets());
    let (limits, limits_size) = (bytes(&layout.limits), layout.limits.len());
    let (rom, rom_size) = (bytes(&layout.rom), layout.rom.len());
    let defaults = bytes(&layout.defaults);
    let range = |range: &std::ops::Range<usize>| format!("{}..{}", range.start, range.end);
    let storage = layout
        .storage
        .iter()
        .map(range)
        .collect::<Vec<_>>()
        .join(", ");
    format!(
        "\
#[rustfmt::skip]
mod table {{
    use ::canopen::od::{{Attributes, DataType, Entry, Table, buckets}};

    pub(super) const RAM_SIZE: usize = {ram_size};

    pub(super) static TABLE: Table = Table {{
        entries: &ENTRIES,
        buckets: &BUCKETS,
        rom: &ROM,
        defaults: &DEFAULTS,
        limits: &LIMITS,
        storage: [{storage}],
    }};

    pub(super) static ENTRIES: [Entry; {count}] = [
{entries}    ];

    static BUCKETS: [u16; {buckets}] = buckets(&ENTRIES);

    static LIMITS: [u8; {limits_size}] = [
{limits}    ];

    static ROM: [u8; {rom_size}] = [
{rom}    ];

    pub(super) const DEFAULTS: [u8; RAM_SIZE] = [
{defaults}    ];

    const NONE: u16 = Entry::NO_LIMITS;
}}
"
    )
}

/// One line of the table; its comment is the name of its getter.
fn entry(row: &Row<'_>) -> String {
    let (index, sub) = (row.object.index, row.entry.sub);
    let data_type = variant(row.entry.data_type);
    let offset = match row.place {
        Place::Ram(offset) | Place::Rom(offset) => offset,
        Place::Application => 0,
    };
    let attributes = attributes(row);
    // Of a number the place of its limits, of everything else its length.
    let detail = match (row.entry.data_type.size(), row.limits) {
        (None, _) => row.entry.size.to_string(),
        (Some(_), Some(at)) => (at / 2).to_string(),
        (Some(_), None) => "NONE".into(),
    };
    let name = &row.name;
    format!(
        "        // {name}\n        Entry::new((0x{index:04X}, {sub}), DataType::{data_type}, {offset}, {detail}, {attributes}),\n"
    )
}

fn attributes(row: &Row<'_>) -> String {
    let entry = row.entry;
    let attributes = [
        ("READ", entry.access.is_readable()),
        ("WRITE", entry.access.is_writable()),
        ("TPDO", entry.is_tpdo_mappable()),
        ("RPDO", entry.is_rpdo_mappable()),
        ("NODE_ID", entry.adds_node_id()),
        ("ROM", matches!(row.place, Place::Rom(_))),
        ("STREAMED", row.place == Place::Application),
        ("CONSTANT", entry.access == crate::model::Access::Constant),
    ];
    let set = attributes.iter().filter(|(_, is_set)| *is_set);
    let names = set.map(|(name, _)| format!("Attributes::{name}"));
    let storage = row.storage.map(|group| match group {
        StorageGroup::Communication => "Attributes::COMMUNICATION".into(),
        StorageGroup::Application => "Attributes::APPLICATION".into(),
        StorageGroup::Manufacturer => "Attributes::MANUFACTURER".into(),
    });
    names.chain(storage).collect::<Vec<_>>().join(" | ")
}

/// The type's name in `canopen::od::DataType`.
fn variant(data_type: DataType) -> String {
    format!("{data_type:?}")
}

/// Bytes, sixteen to a line.
fn bytes(bytes: &[u8]) -> String {
    let line = |bytes: &[u8]| {
        bytes
            .iter()
            .map(|byte| format!("0x{byte:02X},"))
            .collect::<Vec<_>>()
            .join(" ")
    };
    bytes
        .chunks(16)
        .map(|bytes| format!("        {}\n", line(bytes)))
        .collect()
}

//! What the reference shows, as text: the templates only lay it out.

use super::{pdo, value};
use crate::model::{Access, Entry, Model, Object, StorageGroup};

/// The whole reference.
pub(super) struct View {
    pub(super) title: String,
    pub(super) facts: Vec<Fact>,
    /// What the data sheet itself remarks.
    pub(super) remarks: Vec<String>,
    pub(super) pdos: Vec<pdo::Pdo>,
    pub(super) groups: Vec<Group>,
    pub(super) object_count: usize,
    pub(super) entry_count: usize,
    pub(super) file: String,
    pub(super) version: &'static str,
}

/// A line about the device.
pub(super) struct Fact {
    pub(super) label: &'static str,
    pub(super) value: String,
}

/// The objects of one area of the dictionary (CiA 301, table 43).
pub(super) struct Group {
    pub(super) title: &'static str,
    pub(super) anchor: &'static str,
    pub(super) objects: Vec<ObjectView>,
}

/// An object.
pub(super) struct ObjectView {
    pub(super) anchor: String,
    pub(super) index: String,
    pub(super) name: String,
    pub(super) kind: &'static str,
    pub(super) has_subs: bool,
    pub(super) remarks: Vec<String>,
    pub(super) rows: Vec<Row>,
}

/// One value of an object.
pub(super) struct Row {
    pub(super) anchor: String,
    pub(super) sub: String,
    pub(super) name: String,
    pub(super) data_type: String,
    pub(super) access: &'static str,
    pub(super) pdo: &'static str,
    pub(super) default: String,
    pub(super) range: String,
    pub(super) unit: String,
    pub(super) storage: &'static str,
}

/// The areas of the dictionary by their last index.
const AREAS: [(u16, &str, &str); 5] = [
    (0x0FFF, "Data types", "types"),
    (0x1FFF, "Communication", "communication"),
    (0x5FFF, "Manufacturer", "manufacturer"),
    (0x9FFF, "Device profile", "profile"),
    (0xFFFF, "Further objects", "further"),
];

impl View {
    pub(super) fn of(model: &Model) -> Self {
        let entries = model.objects.iter().map(|object| object.entries.len());
        Self {
            title: title(model),
            facts: facts(model),
            remarks: model.comments.clone(),
            pdos: pdo::defaults(model),
            groups: groups(model),
            object_count: model.objects.len(),
            entry_count: entries.sum(),
            file: file_name(&model.file).into(),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

fn title(model: &Model) -> String {
    let device = &model.device;
    match (device.vendor_name.as_str(), device.product_name.as_str()) {
        ("", "") => file_name(&model.file).into(),
        ("", name) | (name, "") => name.into(),
        (_, product) => product.into(),
    }
}

/// The folders of whoever made the reference are nobody's business.
fn file_name(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

fn facts(model: &Model) -> Vec<Fact> {
    let device = &model.device;
    let identity = |sub| {
        let entry = model.entry(0x1018, sub)?;
        Some(format!("{:08X}h", entry.default_number()?))
    };
    let rates: Vec<String> = device.bit_rates.iter().map(u16::to_string).collect();
    let rates = (!rates.is_empty()).then(|| format!("{} kbit/s", rates.join(", ")));
    let text = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    let counted = |count: usize| Some(count.to_string());
    [
        ("Vendor", text(&device.vendor_name)),
        ("Vendor-ID", identity(1)),
        ("Product code", identity(2)),
        ("Revision number", identity(3)),
        ("Device type", device_type(model)),
        ("Bit rates", rates),
        (
            "Receive PDOs",
            counted(model.objects_in(0x1400..=0x15FF).len()),
        ),
        (
            "Transmit PDOs",
            counted(model.objects_in(0x1800..=0x19FF).len()),
        ),
        ("LSS", text(if device.lss { "yes" } else { "no" })),
    ]
    .into_iter()
    .filter_map(|(label, value)| {
        Some(Fact {
            label,
            value: value?,
        })
    })
    .collect()
}

fn device_type(model: &Model) -> Option<String> {
    let value = model.entry(0x1000, 0)?.default_number()?;
    Some(match value & 0xFFFF {
        0 => format!("{value:08X}h (no profile)"),
        profile => format!("{value:08X}h (CiA {profile})"),
    })
}

fn groups(model: &Model) -> Vec<Group> {
    let mut first = 0;
    let mut groups = Vec::new();
    for (last, title, anchor) in AREAS {
        let start = model.objects.partition_point(|object| object.index < first);
        let end = model.objects.partition_point(|object| object.index <= last);
        let objects = model.objects.get(start..end).unwrap_or_default();
        if !objects.is_empty() {
            let objects = objects.iter().map(object).collect();
            groups.push(Group {
                title,
                anchor,
                objects,
            });
        }
        first = last.saturating_add(1);
    }
    groups
}

fn object(object: &Object) -> ObjectView {
    let rows = object.entries.iter();
    ObjectView {
        anchor: anchor(object.index),
        index: format!("{:04X}h", object.index),
        name: object.name.clone(),
        kind: object.object_type.name(),
        has_subs: object.object_type.has_subs(),
        remarks: Vec::new(),
        rows: rows.map(|entry| row(object, entry)).collect(),
    }
}

/// The place of an object on the page.
pub(super) fn anchor(index: u16) -> String {
    format!("x{index:04X}")
}

fn row(object: &Object, entry: &Entry) -> Row {
    Row {
        anchor: format!("x{:04X}-{:02X}", object.index, entry.sub),
        sub: format!("{:02X}h", entry.sub),
        name: entry.name.clone(),
        data_type: value::data_type(entry),
        access: access(entry.access),
        pdo: match (entry.is_rpdo_mappable(), entry.is_tpdo_mappable()) {
            (false, false) => "no",
            (true, false) => "receive",
            (false, true) => "transmit",
            (true, true) => "both",
        },
        default: value::default(entry),
        range: value::range(entry),
        unit: entry.unit().unwrap_or_default().into(),
        storage: entry.storage.map_or("", StorageGroup::name),
    }
}

fn access(access: Access) -> &'static str {
    match access {
        Access::ReadOnly => "ro",
        Access::WriteOnly => "wo",
        Access::ReadWrite => "rw",
        Access::ReadWriteInput => "rwr",
        Access::ReadWriteOutput => "rww",
        Access::Constant => "const",
    }
}

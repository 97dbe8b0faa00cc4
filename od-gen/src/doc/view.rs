//! What the reference shows, as text: the templates only lay it out.

use super::{pdo, value};
use crate::model::{Entry, Model, Note, Object, Remarks, StorageGroup};

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
    /// Kind, and what else there is to say in a word.
    pub(super) kind: String,
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
        ("Order code", text(&device.order_code)),
        ("Vendor-ID", identity(1)),
        ("Product code", identity(2)),
        ("Revision number", identity(3)),
        ("Device type", device_type(model)),
        ("Node", node(model)),
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

/// The node that a DCF configures.
fn node(model: &Model) -> Option<String> {
    let node = model.commissioning.as_ref()?;
    let name = if node.node_name.is_empty() {
        String::new()
    } else {
        format!(" ({})", node.node_name)
    };
    Some(format!("{}{name}, {} kbit/s", node.node_id, node.bit_rate))
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
    let mut kind = object.object_type.name().to_owned();
    if let Some(name) = &object.denotation {
        kind = format!("{kind}, {name}");
    }
    let own = remarks(&object.remarks, &object.notes);
    // A VAR has its comments at its only value.
    let of_entries = object
        .entries
        .iter()
        .flat_map(|entry| remarks(&entry.remarks, &entry.notes));
    let mut all: Vec<String> = Vec::new();
    for remark in own.into_iter().chain(of_entries) {
        if !all.contains(&remark) {
            all.push(remark);
        }
    }
    let rows = object.entries.iter();
    ObjectView {
        anchor: anchor(object.index),
        index: format!("{:04X}h", object.index),
        name: object.name.clone(),
        kind,
        has_subs: object.object_type.has_subs(),
        remarks: all,
        rows: rows.map(|entry| row(object, entry)).collect(),
    }
}

/// What a comment says to a reader of the dictionary: not what it says to tools.
fn remarks(remarks: &Remarks, notes: &[Note]) -> Vec<String> {
    let is_for_people = |text: &&String| {
        let text = text.trim().to_ascii_lowercase();
        !text.is_empty() && !text.starts_with("od-gen")
    };
    let texts = remarks.0.iter().filter(is_for_people);
    let texts = texts.map(|text| text.trim().to_owned());
    let known = ["Unit", "Storage", "Capacity"];
    let notes = notes.iter().filter(|note| {
        let is_known = |name: &&str| name.eq_ignore_ascii_case(&note.name);
        !known.iter().any(is_known)
    });
    let notes = notes.map(|note| format!("{}: {}", note.name, note.value));
    texts.chain(notes).collect()
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
        access: entry.access.name(),
        pdo: match (entry.is_rpdo_mappable(), entry.is_tpdo_mappable()) {
            (false, false) => "no",
            (true, false) => "receive",
            (false, true) => "transmit",
            (true, true) => "both",
        },
        default: value::default(object.index, entry),
        range: value::range(entry),
        unit: entry.unit().unwrap_or_default().into(),
        storage: entry.storage.map_or("", StorageGroup::name),
    }
}

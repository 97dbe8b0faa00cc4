//! CompactPDO: PDOs whose parameters are all alike need no sections (CiA 306, DeviceInfo).
//!
//! The key has a bit for each sub-index of the communication parameters, the lowest one for sub-index 1. NrOfRXPDO and NrOfTXPDO
//! say how many PDOs there are; those that have sections of their own keep them. CiA 306 leaves the defaults open: the PDOs added
//! here are empty, switched off until a master maps something into them, and have the identifiers of the predefined connection set.

use super::Broken;
use crate::data_type::DataType;
use crate::model::{Access, DefaultValue, Entry, Model, Object, ObjectType, Places, StorageGroup};

/// A PDO that is not valid (CiA 301, 7.5.2.35).
const INVALID: i128 = 1 << 31;
/// Between the communication parameters of a PDO and its mapping.
const MAPPING: u16 = 0x200;
/// Sent and taken at an event that the device profile defines.
const EVENT: i128 = 255;

/// The sub-indices 1 to 6 of the communication parameters: name, type, default.
const PARAMETERS: [(&str, DataType, i128); 6] = [
    ("COB-ID used by PDO", DataType::Unsigned32, INVALID),
    ("Transmission type", DataType::Unsigned8, EVENT),
    ("Inhibit time", DataType::Unsigned16, 0),
    ("Compatibility entry", DataType::Unsigned8, 0),
    ("Event timer", DataType::Unsigned16, 0),
    ("SYNC start value", DataType::Unsigned8, 0),
];

/// Adds the PDOs that no section describes.
pub(super) fn expand(model: &mut Model, broken: &Broken) {
    let device = &model.device;
    let bits = device.compact_pdo;
    if bits == 0 {
        return;
    }
    let places = Places::new(device.places.of("CompactPDO"));
    // As many objects as a frame has room for; where nothing is said, a byte each.
    let objects = 64 / device.granularity.clamp(1, 64);
    let objects = if device.granularity == 0 { 8 } else { objects };
    let directions = [
        ("RPDO", device.rpdos, 0x1400, 0x200),
        ("TPDO", device.tpdos, 0x1800, 0x180),
    ];
    for (name, count, first, identifier) in directions {
        for number in 0..count.unwrap_or_default().min(512) {
            let communication = communication(name, number, first + number, identifier, bits);
            let mapping = mapping(name, number, first + number + MAPPING, objects);
            for mut object in [communication, mapping] {
                let is_there = |index| model.object(index).is_some();
                if is_there(object.index) || broken.objects.contains(&object.index) {
                    continue;
                }
                object.places = places.clone();
                for entry in &mut object.entries {
                    entry.places = places.clone();
                    entry.storage = StorageGroup::default_of(object.index, entry.access);
                }
                let at = (model.objects).partition_point(|other| other.index < object.index);
                model.objects.insert(at, object);
            }
        }
    }
}

/// The communication parameters of a PDO; its number counts from 0.
fn communication(name: &str, number: u16, index: u16, identifier: i128, bits: u8) -> Object {
    let mut object = Object {
        index,
        name: format!("{name} {} communication parameter", number + 1),
        object_type: ObjectType::Record,
        ..Object::default()
    };
    for (sub, (name, data_type, default)) in (1..).zip(PARAMETERS) {
        if bits & 1 << (sub - 1) == 0 {
            continue;
        }
        let mut entry = Entry::new(sub, name, data_type);
        entry.default = Some(if sub == 1 && number < 4 {
            DefaultValue::Number {
                value: INVALID + identifier + 0x100 * i128::from(number),
                adds_node_id: true,
            }
        } else {
            DefaultValue::number(default)
        });
        object.entries.push(entry);
    }
    let highest = object.entries.last().map_or(0, |entry| entry.sub);
    let mut first = Entry::new(0, "Highest sub-index supported", DataType::Unsigned8);
    first.access = Access::Constant;
    first.default = Some(DefaultValue::number(highest.into()));
    object.entries.insert(0, first);
    object
}

/// The mapping of a PDO: nothing yet, and room for so many objects.
fn mapping(name: &str, number: u16, index: u16, objects: u8) -> Object {
    let count = "Number of mapped application objects";
    let mut first = Entry::new(0, count, DataType::Unsigned8);
    first.default = Some(DefaultValue::number(0));
    let mut entries = vec![first];
    entries.extend((1..=objects).map(|sub| {
        let name = format!("Application object {sub}");
        Entry::new(sub, name, DataType::Unsigned32)
    }));
    Object {
        index,
        name: format!("{name} {} mapping parameter", number + 1),
        object_type: ObjectType::Record,
        entries,
        ..Object::default()
    }
}

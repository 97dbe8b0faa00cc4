//! PDOs that no section describes.

use super::*;
use crate::model::ObjectType;
use crate::print;

/// The device with so many PDOs; those of its first receive and transmit PDO are described.
fn with(keys: &str) -> Model {
    let (old, new) = ("NrOfRXPDO=1\nNrOfTXPDO=1\n", format!("{keys}\n"));
    assert_eq!(SMALL.matches(old).count(), 1);
    let report = Report::new("small.eds", &SMALL.replacen(old, &new, 1));
    assert_eq!(said(&report), "");
    report.model
}

#[test]
fn pdos_without_sections_have_the_sub_indices_of_the_bits() {
    let model = with("CompactPDO=0x13\nNrOfRXPDO=6\nNrOfTXPDO=2");
    assert_eq!((model.rpdo_count(), model.tpdo_count()), (6, 2));
    let own = small();
    for index in [0x1400, 0x1600, 0x1800, 0x1A00] {
        assert_eq!(model.object(index), own.object(index), "{index:04X}");
    }
    let communication = model.object(0x1801).unwrap();
    assert_eq!(communication.object_type, ObjectType::Record);
    let subs = communication.entries.iter().map(|entry| entry.sub);
    assert_eq!(subs.collect::<Vec<_>>(), [0, 1, 2, 5]);
    assert_eq!(communication.entries[0].initial(), number(5));
    let cob_id = DefaultValue::Number {
        value: 0x8000_0280,
        adds_node_id: true,
    };
    assert_eq!(communication.entries[1].initial(), cob_id);
    assert_eq!(
        model.entry(0x1405, 1).unwrap().initial(),
        number(0x8000_0000),
        "beyond the predefined connection set"
    );
    let mapping = model.object(0x1A01).unwrap();
    assert_eq!(mapping.entries.len(), 9, "a byte each");
    assert_eq!(mapping.entries[0].initial(), number(0));
    assert!(mapping.entries[8].access.is_writable());
}

#[test]
fn the_granularity_says_how_many_objects_a_pdo_has() {
    let model = with("CompactPDO=3\nNrOfRXPDO=1\nNrOfTXPDO=2");
    assert_eq!(model.object(0x1A01).unwrap().entries.len(), 9);
    let text = SMALL
        .replacen("NrOfTXPDO=1", "NrOfTXPDO=2\nCompactPDO=3", 1)
        .replacen("Granularity=8", "Granularity=1", 1);
    let model = Report::new("small.eds", &text).model;
    assert_eq!(model.object(0x1A01).unwrap().entries.len(), 65);
}

#[test]
fn pdos_are_described_one_by_one_when_the_file_is_printed() {
    let model = with("CompactPDO=0x1F\nNrOfRXPDO=3\nNrOfTXPDO=3");
    let printed = print(&model);
    assert!(printed.contains("[1802sub5]"));
    assert_eq!(Report::new("small.eds", &printed).model, model);
}

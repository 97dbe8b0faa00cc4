//! Where values lie.

use super::*;
use crate::model::{Limit, StorageGroup};
use crate::report::parse;
use layout::{Place, Row};
use std::collections::BTreeMap;

fn small() -> Model {
    parse("small.eds", include_str!("../../tests/data/small.eds")).unwrap()
}

fn place(model: &Model, index: u16, sub: u8) -> Place {
    Layout::new(model).row(index, sub).unwrap().place
}

#[test]
fn values_in_ram_follow_each_other_without_gaps() {
    let model = small();
    let layout = Layout::new(&model);
    let in_ram = layout.rows.iter().filter_map(|row| match row.place {
        Place::Ram(offset) => Some((offset, row)),
        _ => None,
    });
    let by_offset: BTreeMap<usize, &Row<'_>> = in_ram.collect();
    let mut next = 0;
    for (offset, row) in by_offset {
        assert_eq!(offset, next);
        let is_text = row.entry.data_type.size().is_none();
        next += usize::from(row.entry.size) + if is_text { 2 } else { 0 };
    }
    assert_eq!(layout.defaults.len(), next);
}

#[test]
fn the_values_of_a_storage_group_lie_side_by_side() {
    let model = small();
    let layout = Layout::new(&model);
    let [communication, application, manufacturer] = layout.storage.clone();
    assert_eq!(communication.start, 0);
    assert_eq!(
        (communication.end, application.end),
        (application.start, manufacturer.start)
    );
    assert!(application.is_empty(), "no object of a profile");
    for row in &layout.rows {
        let Place::Ram(offset) = row.place else {
            assert_eq!(row.storage, None);
            continue;
        };
        let groups = [
            (StorageGroup::Communication, &communication),
            (StorageGroup::Application, &application),
            (StorageGroup::Manufacturer, &manufacturer),
        ];
        for (group, range) in groups {
            assert_eq!(
                row.storage == Some(group),
                range.contains(&offset),
                "{}",
                row.name
            );
        }
    }
}

#[test]
fn only_parameters_are_stored() {
    let model = small();
    let layout = Layout::new(&model);
    let group = |index, sub| layout.row(index, sub).unwrap().storage;
    assert_eq!(group(0x1005, 0), Some(StorageGroup::Communication));
    assert_eq!(group(0x2000, 0), Some(StorageGroup::Manufacturer));
    assert_eq!(group(0x2001, 0), None, "rww");
    assert_eq!(group(0x2002, 0), None, "rwr");
    assert_eq!(group(0x2003, 0), None, "wo");
    assert_eq!(group(0x1001, 0), None, "ro");
    assert_eq!(group(0x1000, 0), None, "const");
}

#[test]
fn a_long_string_that_can_be_written_is_with_the_application() {
    let mut model = small();
    for object in &mut model.objects {
        for entry in &mut object.entries {
            if matches!(object.index, 0x2006 | 0x2008) {
                entry.size = 129;
            }
        }
    }
    let layout = Layout::new(&model);
    assert_eq!(layout.row(0x2006, 0).unwrap().place, Place::Application);
    let constant = layout.row(0x2008, 0).unwrap().place;
    assert!(matches!(constant, Place::Rom(_)), "read where it lies");
}

#[test]
fn ram_holds_only_what_can_change() {
    let model = small();
    let is_rom = |index, sub| matches!(place(&model, index, sub), Place::Rom(_));
    assert!(is_rom(0x1000, 0), "const");
    assert!(is_rom(0x1018, 0), "the highest sub-index of a record, ro");
    assert!(is_rom(0x2008, 0), "a string that is ro");
    assert!(!is_rom(0x1018, 1), "ro: the device may change it");
    assert!(!is_rom(0x1A00, 0), "a sub-index 0 that is rw");
    assert!(!is_rom(0x2009, 0), "const, but with the node-ID");
}

#[test]
fn the_number_of_errors_is_counted_in_ram() {
    let mut model = small();
    let object = model
        .objects
        .iter_mut()
        .find(|object| object.index == 0x1018)
        .unwrap();
    object.index = 0x1003;
    assert!(matches!(place(&model, 0x1003, 0), Place::Ram(_)));
}

#[test]
fn flash_holds_equal_bytes_once() {
    let model = small();
    // The 2 before the table's elements is found in the revision number 00010002h.
    assert_eq!(place(&model, 0x200A, 0), place(&model, 0x1018, 3));
}

#[test]
fn a_string_is_preceded_by_its_present_length() {
    let model = small();
    let layout = Layout::new(&model);
    let Place::Ram(offset) = place(&model, 0x2006, 0) else {
        panic!("rw, so in RAM")
    };
    assert_eq!(layout.defaults[offset..offset + 7], *b"\x05\0hello");
}

#[test]
fn limits_are_kept_once_each() {
    let mut model = small();
    for object in &mut model.objects {
        for entry in object
            .entries
            .iter_mut()
            .filter(|entry| entry.data_type.size() == Some(1))
        {
            let limit = |value| Some(Limit::Integer(value));
            (entry.low_limit, entry.high_limit) = (limit(0), limit(7));
        }
    }
    let layout = Layout::new(&model);
    let of = |index, sub| layout.row(index, sub).unwrap().limits.unwrap();
    assert_eq!(layout.limits[of(0x1018, 0)..][..2], [0, 7]);
    assert_eq!(of(0x1018, 0), of(0x2001, 0));
    let wide = [1_u64, u64::MAX].map(u64::to_le_bytes).concat();
    assert_eq!(
        layout.limits[of(0x2005, 0)..][..16],
        wide,
        "UNSIGNED64 without HighLimit"
    );
}

#[test]
fn streams_whose_names_differ_in_a_gap_have_types_of_their_own() {
    let mut model = small();
    for (index, name) in [(0x2006, "File 1"), (0x2007, "File1")] {
        let mut objects = model.objects.iter_mut();
        let object = objects.find(|object| object.index == index).unwrap();
        object.name = name.into();
        object.entries[0].access = crate::model::Access::ReadWrite;
        object.entries[0].size = 129;
    }
    let text = generate(&model, Options::DEVICE);
    for own_type in ["type File1At2006: ", "type File1At2007: "] {
        assert_eq!(text.matches(own_type).count(), 1, "{own_type}");
    }
    assert_eq!(text.matches("type File1: ").count(), 0);
}

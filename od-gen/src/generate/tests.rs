//! Where values lie.

use super::*;
use crate::parse::parse;
use layout::Place;

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
    let mut next = 0;
    for row in &layout.rows {
        if let Place::Ram(offset) = row.place {
            assert_eq!(offset, next);
            let prefix = if row.entry.data_type.size().is_none() {
                2
            } else {
                0
            };
            next += usize::from(row.entry.size) + prefix;
        }
    }
    assert_eq!(layout.defaults.len(), next);
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
            (entry.low_limit, entry.high_limit) = (Some(0), Some(7));
        }
    }
    let layout = Layout::new(&model);
    let shared = layout
        .limits
        .iter()
        .filter(|limits| **limits == (0, 7))
        .count();
    assert_eq!(shared, 1);
    assert!(
        layout.limits.contains(&(1, i64::MAX)),
        "UNSIGNED64 without HighLimit"
    );
}

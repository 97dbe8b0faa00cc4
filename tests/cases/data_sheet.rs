//! The dictionary on the bus against the data sheet it was made from.

use canopen::od::{Access, Dictionary as _, Entry};
use od_gen::model::DefaultValue;
use sim::dictionary::Dictionary;
use tests::DriveBench;

/// The default of the data sheet as node 4 must show it on the bus.
fn default_bytes(entry: &od_gen::model::Entry) -> Vec<u8> {
    match &entry.initial() {
        DefaultValue::Text(text) => text.clone(),
        DefaultValue::Real(_) => panic!("the drive has no REAL objects"),
        DefaultValue::Number {
            value,
            adds_node_id,
        } => {
            let size = entry.data_type.size().expect("a number").into();
            let number = value + if *adds_node_id { 4 } else { 0 };
            number.to_le_bytes()[..size].to_vec()
        }
    }
}

#[test]
fn o01_every_object_has_the_type_access_and_default_of_the_data_sheet() {
    let model = od_gen::read(std::path::Path::new("../eds/axis402.eds")).unwrap();
    let mut drive = DriveBench::booted(4);
    let mut compared = 0;
    for object in &model.objects {
        for sheet in &object.entries {
            let entry: &Entry = Dictionary::TABLE.find(object.index, sheet.sub).unwrap();
            assert_eq!(
                entry.data_type as u16,
                sheet.data_type.code(),
                "{:04X}h:{:02X}",
                object.index,
                sheet.sub
            );
            let read = drive.try_read(object.index, sheet.sub);
            match entry.access() {
                Access::WriteOnly => assert_eq!(read, Err(0x0601_0001)),
                _ if object.index == 0x1003 && sheet.sub > 0 => assert_eq!(read, Err(0x0800_0024)),
                // What the drive itself changes from the first tick on, what it measures, and its node-ID and bit rate.
                _ if matches!(object.index, 0x6041 | 0x6061 | 0x6079)
                    || matches!((object.index, sheet.sub), (0x2050, 7) | (0x2074, 1))
                    || object.index == 0x5FF0 && sheet.sub > 0
                    || matches!((object.index, sheet.sub), (0x1018, 4) | (0x20D0, 8 | 9)) =>
                {
                    assert!(read.is_ok());
                }
                _ => {
                    let expected = default_bytes(sheet);
                    assert_eq!(
                        read.as_deref(),
                        Ok(expected.as_slice()),
                        "{:04X}h:{:02X}",
                        object.index,
                        sheet.sub
                    );
                    compared += 1;
                }
            }
            if matches!(entry.access(), Access::ReadOnly | Access::Constant) {
                let refused = drive.try_write(
                    object.index,
                    sheet.sub,
                    &vec![0; usize::from(entry.size()).max(1)],
                );
                assert_eq!(
                    refused,
                    Err(0x0601_0002),
                    "{:04X}h:{:02X}",
                    object.index,
                    sheet.sub
                );
            }
        }
    }
    assert!(compared > 130, "{compared}");
}

#[test]
fn o05_the_generator_writes_the_same_twice() {
    let model = || od_gen::read(std::path::Path::new("../eds/axis402.eds")).unwrap();
    let options = od_gen::Options::DRIVE;
    assert_eq!(
        od_gen::generate(&model(), options),
        od_gen::generate(&model(), options)
    );
}

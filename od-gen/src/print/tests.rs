//! What is printed is read as the same again.

use proptest::prelude::*;

use super::*;
use crate::data_type::DataType;
use crate::model::{
    Access, Commissioning, DefaultValue, Entry, FileKind, Limit, Object, ObjectType, StorageGroup,
};
use crate::report::Report;

const FILES: [(&str, &str); 6] = [
    ("small.eds", include_str!("../../tests/data/small.eds")),
    ("drive.eds", include_str!("../../tests/data/drive.eds")),
    ("every.dcf", include_str!("../../tests/data/every.dcf")),
    ("coupler.eds", include_str!("../../tests/data/coupler.eds")),
    ("axis402.eds", include_str!("../../../eds/axis402.eds")),
    (
        "test-device.eds",
        include_str!("../../../tests/eds/test-device.eds"),
    ),
];

/// The model of a text, whatever is wrong with it.
fn model(file: &str, text: &str) -> Model {
    Report::new(file, text).model
}

#[test]
fn a_printed_model_is_read_as_the_same() {
    for (file, text) in FILES {
        let read = model(file, text);
        let printed = print(&read);
        assert_eq!(model(file, &printed), read, "{file}");
        assert_eq!(format(file, &printed).unwrap(), printed, "{file}");
    }
}

#[test]
fn a_formatted_file_means_the_same_and_stays_as_it_is() {
    for (file, text) in FILES {
        let formatted = format(file, text).unwrap();
        assert_eq!(model(file, &formatted), model(file, text), "{file}");
        assert_eq!(format(file, &formatted).unwrap(), formatted, "{file}");
    }
}

#[test]
fn comments_and_what_is_not_known_stay() {
    let text = "\u{feff}; of the file\r\n\r\n[ManufacturerObjects]\r\nsupportedobjects=1\r\n1=8192\r\n\r\n\
                ; above [2000]\r\n[2000]\r\n;Unit=mm\r\n\r\ndatatype=7\r\nDEFAULTVALUE = 5 ; why\r\n; of the access\r\n\
                AccessType=RW\r\nParameterName=Way\r\nColour=blue\r\nLowLimit=\r\n; at the end\r\n\
                \r\n[Maker]\r\nb=2\r\na=1\r\n[fileinfo]\r\n; no key\r\n";
    let expected = "\
; of the file

[FileInfo]
; no key

[ManufacturerObjects]
SupportedObjects=1
1=0x2000

; above [2000]
[2000]
;Unit=mm
ParameterName=Way
DataType=0x0007
; of the access
AccessType=rw
; why
DefaultValue=5
Colour=blue
; at the end

[Maker]
b=2
a=1
";
    assert_eq!(format("x.eds", text).unwrap(), expected);
    assert_eq!(format("x.eds", expected).unwrap(), expected);
}

#[test]
fn of_two_notes_the_first_one_stays_the_first() {
    let text = "[2000]\nMaker=1\n;Capacity=5\nX=1\n;Capacity=6\nDataType=9\n";
    let formatted = format("x.eds", text).unwrap();
    assert!(
        formatted.starts_with("[2000]\n;Capacity=5\n;Capacity=6\nDataType"),
        "{formatted}"
    );
    assert_eq!(format("x.eds", &formatted).unwrap(), formatted);
}

#[test]
fn a_comment_above_what_becomes_the_first_section_is_one_of_the_file() {
    let text = "[Maker]\na=1\n\n; of the information\n[FileInfo]\nFileName=x.eds\n";
    let formatted = format("x.eds", text).unwrap();
    assert!(
        formatted.starts_with("; of the information\n\n[FileInfo]\n"),
        "{formatted}"
    );
    assert_eq!(format("x.eds", &formatted).unwrap(), formatted);
}

#[test]
fn lines_that_mean_nothing_stay_as_comments() {
    for (text, formatted) in [
        (
            "[1000]\n[1000]\na=1\n;c\n",
            "[1000]\n; left out: [1000]\n; left out: a=1\n; left out: c\n",
        ),
        (
            "[2000sub1]\nDataType=5\n[2000sub01]\nDataType=6\n",
            "[2000sub1]\nDataType=0x0005\n; left out: [2000sub01]\n; left out: DataType=6\n",
        ),
        ("[1000]\nnothing\n", "[1000]\n; left out: nothing\n"),
        ("[1000] junk\n", "[1000]\n; left out: junk\n"),
        ("[1000]\na=1\na=2\n", "[1000]\na=1\n; left out: a=2\n"),
        ("a=1\n[1000]\n", "; left out: a=1\n\n[1000]\n"),
    ] {
        assert_eq!(format("x.eds", text).unwrap(), formatted);
        assert_eq!(format("x.eds", formatted).unwrap(), formatted);
    }
}

fn data_type() -> impl Strategy<Value = DataType> {
    proptest::sample::select(DataType::ALL.to_vec())
}

fn access() -> impl Strategy<Value = Access> {
    proptest::sample::select(vec![
        Access::ReadOnly,
        Access::WriteOnly,
        Access::ReadWrite,
        Access::ReadWriteInput,
        Access::ReadWriteOutput,
        Access::Constant,
    ])
}

/// A text that an INI file can hold as a value.
fn name() -> impl Strategy<Value = String> {
    "[A-Za-z0-9]([ -~]{0,20}[!-~])?".prop_filter("a comment", |text| !text.contains(" ;"))
}

/// Limits, default and size for a type, by three numbers.
fn fill(entry: &mut Entry, numbers: [u64; 3], text: String, adds_node_id: bool) {
    let data_type = entry.data_type;
    if let Some((low, high)) = data_type.range() {
        let mut values = numbers.map(|number| low + i128::from(number) % (high - low + 1));
        values.sort_unstable();
        let [first, value, last] = values;
        entry.default = Some(DefaultValue::number(value));
        let largest = i128::from(i64::MAX);
        entry.low_limit = (first < largest).then_some(Limit::Integer(first));
        entry.high_limit = (last < largest).then_some(Limit::Integer(last));
        if adds_node_id && !data_type.is_signed() && data_type != DataType::Boolean {
            entry.default = Some(DefaultValue::Number {
                value: value.min(high - 127),
                adds_node_id,
            });
            (entry.low_limit, entry.high_limit) = (Some(Limit::NodeId(first.max(0))), None);
        }
    } else if data_type.is_real() {
        let value = f64::from(f32::from_bits(numbers[0] as u32));
        entry.default = Some(DefaultValue::Real(if value.is_finite() {
            value
        } else {
            -1.5
        }));
    } else if data_type == DataType::Domain {
        entry.size = numbers[0] as u16;
    } else {
        let bytes = match data_type {
            DataType::UnicodeString => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
            _ => text.into_bytes(),
        };
        let length = bytes.len() as u16;
        entry.default = (!bytes.is_empty()).then_some(DefaultValue::Text(bytes));
        entry.size = match entry.access.is_writable() {
            true => length.max(1) + (numbers[0] % 300) as u16,
            false => length,
        };
    }
}

fn entry(index: u16, sub: u8) -> impl Strategy<Value = Entry> {
    let storage = proptest::sample::select(vec![
        None,
        Some(StorageGroup::Communication),
        Some(StorageGroup::Application),
        Some(StorageGroup::Manufacturer),
    ]);
    let what = (data_type(), access(), name(), name());
    let how = (any::<[u64; 3]>(), any::<bool>(), any::<bool>(), storage);
    (what, how, 0..4u32).prop_map(move |((data_type, access, name, text), how, flags)| {
        let (numbers, adds_node_id, mapping, storage) = how;
        let mut entry = Entry::new(sub, name, data_type);
        entry.access = access;
        entry.flags = flags;
        entry.pdo_mapping = mapping && data_type.size().is_some();
        fill(&mut entry, numbers, text, adds_node_id);
        entry.storage = match access.is_writable() {
            true if index & 1 == 0 => storage,
            _ => StorageGroup::default_of(index, access),
        };
        entry
    })
}

/// An object at an index of its own.
fn object(index: u16) -> impl Strategy<Value = Object> {
    let subs = proptest::collection::vec(entry(index, 1), 1..5);
    (name(), subs, any::<bool>()).prop_map(move |(name, mut entries, is_record)| {
        let mut object = Object {
            index,
            name,
            ..Object::default()
        };
        if is_record {
            object.object_type = ObjectType::Record;
            for (sub, entry) in (1..).zip(&mut entries) {
                entry.sub = sub;
            }
            let mut first = Entry::new(0, "Highest sub-index supported", DataType::Unsigned8);
            first.access = Access::Constant;
            first.default = Some(DefaultValue::number(entries.len() as i128));
            entries.insert(0, first);
        } else {
            entries.truncate(1);
            let entry = &mut entries[0];
            entry.sub = 0;
            entry.name = object.name.clone();
            if entry.data_type == DataType::Domain {
                object.object_type = ObjectType::Domain;
            }
        }
        object.entries = entries;
        object
    })
}

pub(crate) fn made_up() -> impl Strategy<Value = Model> {
    let indices = proptest::collection::btree_set(0x2000..0xA000u16, 0..8);
    let objects = indices.prop_flat_map(|indices| {
        let objects = indices.into_iter().map(object);
        objects.collect::<Vec<_>>()
    });
    (
        objects,
        proptest::option::of(1..=127u8),
        proptest::collection::vec(name(), 0..3),
    )
        .prop_map(|(objects, node_id, comments)| Model {
            file: "made-up.eds".into(),
            kind: node_id.map_or(FileKind::Eds, |_| FileKind::Dcf),
            commissioning: node_id.map(|node_id| Commissioning {
                node_id,
                node_name: "node".into(),
                bit_rate: 500,
                ..Commissioning::default()
            }),
            comments,
            dummies: vec![5, 6],
            objects,
            ..Model::default()
        })
}

#[test]
fn comments_of_objects_are_printed() {
    let text = include_str!("../../tests/data/allowed.eds");
    let mut report = Report::new("allowed.eds", text);
    let printed = print(&report.model);
    for comment in [
        "; od-gen: allow missing-mandatory-object because this file shows allowances\n",
        ";od-gen: allow default-outside-limits because 0 is written by nobody\n",
    ] {
        assert!(printed.contains(comment), "{printed}");
    }
    report.model.remarks.0.clear();
    assert!(!print(&report.model).contains("missing-mandatory-object"));
}

#[test]
fn an_allowance_of_what_printing_puts_right_is_left_out() {
    let allow = |rules: &str| format!(";od-gen: allow {rules} because a test asks for it\n");
    let (old, new) = ("DefaultValue=128\n", "DefaultValue=128 ; SYNC\n");
    let text = FILES[0].1.replace(old, new);
    assert_ne!(text, FILES[0].1);
    let text = allow("trailing-comment") + &text;
    assert!(Report::new("small.eds", &text).findings.is_empty());
    for printed in [
        print(&model("small.eds", &text)),
        format("small.eds", &text).unwrap(),
    ] {
        assert!(!printed.contains("trailing-comment"), "{printed}");
        let report = Report::new("small.eds", &printed);
        assert!(report.findings.is_empty(), "{:?}", report.findings);
        assert_eq!(format("small.eds", &printed).unwrap(), printed);
    }
    // What silences nothing in the file as it is stays: formatting loses no comment.
    let text = text.replace("allow trailing", "allow no-sub-0, trailing");
    let formatted = format("small.eds", &text).unwrap();
    assert!(formatted.contains(&allow("no-sub-0")), "{formatted}");
}

#[test]
fn an_allowance_of_a_section_without_objects_is_printed_for_the_whole_file() {
    let comment = ";od-gen: allow vendor-name because it has none";
    let text = FILES[0].1.replace(
        "VendorName=Nobody",
        &format!("{comment}\nVendorName=Nobody"),
    );
    let printed = Report::new("small.eds", &text).model.remarks.0;
    assert_eq!(printed.len(), 2, "{printed:?}");
}

/// Comments are notes once they have been read.
pub(crate) fn without_notes(mut model: Model) -> Model {
    for entry in model
        .objects
        .iter_mut()
        .flat_map(|object| &mut object.entries)
    {
        entry.notes.clear();
    }
    model
}

proptest! {
    #[test]
    fn a_made_up_dictionary_is_printed_and_read_as_the_same(made_up in made_up()) {
        let printed = print(&made_up);
        let read = model("made-up.eds", &printed);
        prop_assert_eq!(without_notes(read.clone()), made_up, "{}", printed);
        prop_assert_eq!(print(&read), printed.clone());
        prop_assert_eq!(format("made-up.eds", &printed).unwrap(), printed);
    }

    #[test]
    fn a_spoiled_file_is_formatted_without_a_change_of_its_meaning_or_refused(
        at in 0..FILES[0].1.len(),
        cut in 0usize..40,
        put in "([0-9A-Fa-fx$\\[\\]=;+ -]|\\n|\\PC){0,8}",
    ) {
        let text = FILES[0].1;
        let end = (at + cut).min(text.len());
        let spoiled = format!("{}{put}{}", &text[..at], &text[end..]);
        if let Ok(formatted) = format("x.eds", &spoiled) {
            prop_assert_eq!(model("x.eds", &formatted), model("x.eds", &spoiled), "{}", formatted);
            prop_assert_eq!(format("x.eds", &formatted).unwrap(), formatted);
        }
    }
}

#[test]
fn formatting_refuses_what_it_would_lose() {
    let findings = format("x.eds", "[2000]\nParameterName=A\u{7}B\n").unwrap_err();
    assert_eq!(findings.len(), 1, "{findings:?}");
    // What old systems end a file with.
    assert_eq!(
        format("x.eds", "[2000]\na=1\n\u{1A}").unwrap(),
        "[2000]\na=1\n"
    );
}

#[test]
fn sections_of_tools_are_printed_as_they_are() {
    let tools = "[StandardDataTypes]\n0x0001=1\n\n[Tools]\nItems=1\n\n[Tool1]\nName=Editor\nCommand=edit $DCF\n";
    let text = format!("{}\n{}", FILES[0].1, tools.replace("[Tools]", "[TOOLS]"));
    let report = Report::new("small.eds", &text);
    assert!(report.findings.is_empty(), "{:?}", report.findings);
    let printed = print(&report.model);
    for section in tools.split("\n\n") {
        assert!(printed.contains(section), "{printed}");
    }
}

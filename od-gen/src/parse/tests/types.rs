//! A configured device with a value of every type.

use crate::data_type::DataType;
use crate::model::StorageGroup;
use crate::model::{Commissioning, DefaultValue, Entry, FileKind, Limit, Model, ObjectType};
use crate::report::{Report, parse};

const EVERY: &str = include_str!("../../../tests/data/every.dcf");

fn every() -> Model {
    parse("every.dcf", EVERY).unwrap()
}

fn entry(index: u16) -> Entry {
    every().entry(index, 0).unwrap().clone()
}

fn node_id_plus(value: i128) -> DefaultValue {
    DefaultValue::Number {
        value,
        adds_node_id: true,
    }
}

#[test]
fn every_type_has_its_default_and_size() {
    let model = every();
    assert_eq!(model.kind, FileKind::Dcf);
    let expected = [
        (DataType::Boolean, 1, 1),
        (DataType::Integer8, -128, 1),
        (DataType::Integer16, -0o17, 2),
        (DataType::Unsigned8, 0o17, 1),
        (DataType::Unsigned32, 0xFFFF_FFFF, 4),
        (DataType::TimeOfDay, 0x3CC0_0000_05A0, 6),
        (DataType::TimeDifference, 0, 6),
        (DataType::Integer24, -0x80_0000, 3),
        (DataType::Integer40, -0x80_0000_0000, 5),
        (DataType::Integer48, -1, 6),
        (DataType::Integer56, 0x7F_FFFF_FFFF_FFFF, 7),
        (DataType::Unsigned24, 0xFF_FFFF, 3),
        (DataType::Unsigned40, 0xFF_FFFF_FFFF, 5),
        (DataType::Unsigned64, 0xFFFF_FFFF_FFFF_FFFF, 8),
    ];
    for (data_type, value, size) in expected {
        let entry = entry(0x2000 + data_type.code());
        assert_eq!(entry.data_type, data_type);
        assert_eq!(
            entry.initial(),
            DefaultValue::number(value),
            "{data_type:?}"
        );
        assert_eq!(entry.size, size);
    }
    assert_eq!(entry(0x2008).initial(), DefaultValue::Real(1.5));
    assert_eq!(entry(0x2008).low_limit, Some(Limit::Real(-1500.0)));
    assert_eq!(
        entry(0x2008).configured,
        Some(DefaultValue::Real(f64::from(0.1f32)))
    );
    assert_eq!(entry(0x2011).initial(), DefaultValue::Real(1e-300));
    assert_eq!(entry(0x200A).initial(), DefaultValue::Text(vec![0, 10]));
    let letters = vec![b's', 0, 0xFC, 0, 0xDF, 0];
    assert_eq!(entry(0x200B).initial(), DefaultValue::Text(letters));
}

#[test]
fn a_device_is_configured() {
    let node = Commissioning {
        node_id: 17,
        node_name: "Mixer".into(),
        bit_rate: 500,
        net_number: 3,
        network_name: "Kitchen".into(),
        is_manager: false,
        serial_number: Some(77),
    };
    assert_eq!(every().commissioning, Some(node));
    assert_eq!(every().file_info.last_eds, "every.eds");
    assert_eq!(entry(0x1014).initial(), node_id_plus(0x80));
    assert_eq!(entry(0x1014).configured, Some(node_id_plus(0x90)));
    assert_eq!(entry(0x2005).configured, Some(DefaultValue::number(18)));
    assert_eq!(entry(0x2005).denotation.as_deref(), Some("Stirrer"));
    assert_eq!(
        every().object(0x1018).unwrap().denotation.as_deref(),
        Some("Who am I")
    );
    assert_eq!(
        entry(0x2009).configured,
        Some(DefaultValue::Text(b"frying pan".to_vec()))
    );
    assert_eq!(entry(0x2009).size, 40);
    let recipe = entry(0x200F);
    assert_eq!((recipe.data_type, recipe.size), (DataType::Domain, 4096));
    assert_eq!(recipe.upload_file.as_deref(), Some("recipe.out"));
    assert_eq!(recipe.download_file.as_deref(), Some("recipe.in"));
    assert_eq!(entry(0x2003).flags, 3);
}

#[test]
fn the_values_of_a_compact_object_are_configured_ones() {
    let model = every();
    let object = model.object(0x2100).unwrap();
    let rows: Vec<_> = object.entries[1..].iter().collect();
    assert!(
        rows.iter()
            .all(|entry| entry.initial() == DefaultValue::number(9))
    );
    assert_eq!(rows[0].configured, Some(DefaultValue::number(7)));
    assert_eq!(
        (rows[1].name.as_str(), &rows[1].configured),
        ("Salt", &None)
    );
    assert_eq!(rows[2].configured, Some(node_id_plus(1)));
    assert_eq!(rows[2].denotation.as_deref(), Some("Pinch"));
}

#[test]
fn types_are_defined_beside_the_objects() {
    let model = every();
    let kinds: Vec<_> = (model.types.iter())
        .map(|object| (object.index, object.object_type))
        .collect();
    assert_eq!(
        kinds,
        [(0x40, ObjectType::DefType), (0x41, ObjectType::DefStruct)]
    );
    let taken = model.object(0x2200).unwrap();
    assert_eq!(
        (taken.object_type, taken.entries.len()),
        (ObjectType::Null, 0)
    );
}

#[test]
fn the_file_says_what_stores_a_value() {
    assert_eq!(entry(0x1014).storage, Some(StorageGroup::Communication));
    assert_eq!(entry(0x2001).storage, Some(StorageGroup::Manufacturer));
    assert_eq!(entry(0x2013).storage, Some(StorageGroup::Application));
    assert_eq!(entry(0x2014).storage, None);
    let text = EVERY.replace(";Storage=none", ";Storage=somewhere");
    let findings = Report::for_code("every.dcf", &text).findings;
    assert_eq!(findings[0].rule.name, "storage");
    assert_eq!(findings.len(), 1);
}

#[test]
fn values_of_every_type_are_checked() {
    for (old, new, rule) in [
        (
            "DefaultValue=0x3FC00000",
            "DefaultValue=1,5",
            "not-a-number",
        ),
        (
            "DefaultValue=0x3FC00000",
            "DefaultValue=nan",
            "not-a-number",
        ),
        (
            "DefaultValue=0x3FC00000",
            "DefaultValue=1501",
            "default-outside-limits",
        ),
        ("LowLimit=-1.5e3", "LowLimit=1.5e4", "low-above-high"),
        (
            "DefaultValue=0xFFFFFF\n",
            "DefaultValue=0x1000000\n",
            "default-type",
        ),
        (
            "DefaultValue=0x800000\n",
            "DefaultValue=0x1000000\n",
            "default-type",
        ),
        (
            "DefaultValue=0x3CC0000005A0",
            "DefaultValue=0x1000000000000",
            "default-type",
        ),
        ("ParameterValue=18", "ParameterValue=256", "default-type"),
        ("NodeID=0x11", "NodeID=0x80", "out-of-range"),
        (
            "ParameterValue=frying pan\n;Capacity=40",
            "ParameterValue=frying pan\n;Capacity=9",
            "capacity-too-small",
        ),
    ] {
        assert_eq!(EVERY.matches(old).count(), 1, "{old}");
        let report = Report::new("every.dcf", &EVERY.replace(old, new));
        let rules: Vec<_> = report
            .findings
            .iter()
            .map(|finding| finding.rule.name)
            .collect();
        assert_eq!(rules, [rule], "{new}");
    }
}

#[test]
fn a_type_of_the_file_stands_for_its_base_type() {
    let small = include_str!("../../../tests/data/small.eds");
    let defined = "[0060]\nParameterName=Count\nObjectType=5\nDataType=7\nAccessType=ro\n";
    let object = "[2005]";
    let (before, behind) = small.split_once(object).unwrap();
    let behind = behind.replacen("DataType=0x001B", "DataType=0x60", 1);
    let behind = behind.replacen("=0xFFFFFFFFFFFFFFFF", "=0xFFFFFFFF", 1);
    let behind = behind.replacen("=18446744073709551615", "=1", 1);
    let said = |text: &str| {
        let report = Report::new("small.eds", text);
        let lines = report.findings.iter().map(|found| found.message.clone());
        (lines.collect::<Vec<_>>(), report.model)
    };
    let (findings, model) = said(&format!("{before}{defined}{object}{behind}"));
    assert_eq!(findings, Vec::<String>::new());
    assert_eq!(
        model.entry(0x2005, 0).unwrap().data_type,
        DataType::Unsigned32
    );
    let (findings, _) = said(&format!("{before}{object}{behind}"));
    assert_eq!(findings, ["DataType 0x60 is no type of a value"]);
    // By way of another one, and in a circle.
    let twice = defined.replace("DataType=7", "DataType=0x61");
    let last = defined.replace("[0060]", "[0061]");
    let (findings, model) = said(&format!("{before}{twice}{last}{object}{behind}"));
    assert_eq!(findings, Vec::<String>::new());
    assert_eq!(
        model.entry(0x2005, 0).unwrap().data_type,
        DataType::Unsigned32
    );
    let circle = last.replace("DataType=7", "DataType=0x60");
    let (findings, _) = said(&format!("{before}{twice}{circle}{object}{behind}"));
    assert_eq!(
        findings,
        [
            "DataType 0x61 is no type of a value",
            "DataType 0x60 is no type of a value",
            "DataType 0x60 is no type of a value"
        ]
    );
}

#[test]
fn the_application_has_what_the_file_gives_to_it() {
    let types = include_str!("../../../tests/data/types.eds");
    let model = parse("types.eds", types).unwrap();
    let is_given = |index, sub| model.entry(index, sub).unwrap().is_with_application;
    assert!(is_given(0x201A, 0) && is_given(0x201B, 1) && is_given(0x2100, 200));
    assert!(!is_given(0x201B, 0) && !is_given(0x2100, 0) && !is_given(0x2000, 0));
    assert_eq!(model.entry(0x2100, 1).unwrap().storage, None);
    let odometer = "[201A]\n;Memory=application\n";
    assert_eq!(types.matches(odometer).count(), 1);
    for (new, said) in [
        (
            "[201A]\n;Memory=elsewhere\n",
            "Memory `elsewhere` is not application",
        ),
        (
            "[201A]\n;Memory=application\nPDOMapping=1\n",
            "a PDO carries only what the dictionary has",
        ),
        (
            "[201A]\n;Memory=application\n;Storage=manufacturer\n",
            "1010h stores only what the dictionary has",
        ),
    ] {
        let report = Report::new("types.eds", &types.replace(odometer, new));
        let found = report
            .findings
            .iter()
            .filter(|found| found.rule.name == "memory");
        assert_eq!(
            found.map(|found| &*found.message).collect::<Vec<_>>(),
            [said]
        );
    }
    // What belongs to the operating system of the device is the application's below 2000h too.
    let prompt = parse("types.eds", &types.replace("201A", "1026")).unwrap();
    assert!(prompt.entry(0x1026, 0).unwrap().is_with_application);
    let heartbeat = types.replacen("[1001]\n", "[1001]\n;Memory=application\n", 1);
    let report = Report::new("types.eds", &heartbeat);
    assert!(
        report
            .findings
            .iter()
            .any(|found| found.rule.name == "memory")
    );
}

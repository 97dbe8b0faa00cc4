//! A correct data sheet, and what is said when one thing in it is changed.

use proptest::prelude::*;

use crate::data_type::DataType;
use crate::model::{Access, DefaultValue, Entry, Model};
use crate::report::{Report, parse};

mod cob_ids;
mod compact_pdo;
mod dictionary;
mod entries;
mod modules;
mod places;
mod text;
mod types;

const SMALL: &str = include_str!("../../../tests/data/small.eds");

/// The findings, one a line as `line: message`, after `old` (which is there once) has become `new`.
fn findings(old: &str, new: &str) -> String {
    assert_eq!(SMALL.matches(old).count(), 1, "{old}");
    said(&Report::new("small.eds", &SMALL.replacen(old, new, 1)))
}

fn said(report: &Report) -> String {
    let findings = report.findings.iter();
    let lines = findings.map(|finding| format!("{}: {}", finding.span.line, finding.message));
    lines.collect::<Vec<_>>().join("\n")
}

/// The line on which `text` begins.
fn line_of(text: &str) -> usize {
    SMALL[..SMALL.find(text).unwrap()].lines().count() + 1
}

/// One change, one finding, on the line of `at` or below it in the same section.
#[track_caller]
fn finds(old: &str, new: &str, at: &str, message: &str) {
    let said = findings(old, new);
    let (line, found) = said.split_once(": ").unwrap_or(("0", "nothing"));
    assert_eq!(found, message);
    let first = line_of(at);
    let below = SMALL.lines().skip(first);
    let last = first + below.take_while(|line| !line.starts_with('[')).count() + 1;
    let line: usize = line.parse().unwrap();
    assert!(
        (first..=last).contains(&line),
        "line {line} is not in {first}..={last}"
    );
}

/// One change, and nothing to say.
#[track_caller]
fn finds_nothing(old: &str, new: &str) {
    assert_eq!(findings(old, new), "");
}

/// One change, and one finding where code is to be made of it.
#[track_caller]
fn finds_for_code(old: &str, new: &str, message: &str) {
    assert!(SMALL.contains(old), "{old}");
    let report = Report::for_code("small.eds", &SMALL.replacen(old, new, 1));
    let said: Vec<&str> = (report.findings.iter())
        .map(|finding| &*finding.message)
        .collect();
    assert_eq!(said, [message]);
}

fn small() -> Model {
    parse("small.eds", SMALL).unwrap()
}

fn number(value: i128) -> DefaultValue {
    DefaultValue::Number {
        value,
        adds_node_id: false,
    }
}

#[test]
fn every_notation_is_read() {
    let model = small();
    let default = |index, sub| model.entry(index, sub).unwrap().initial();
    assert_eq!(default(0x1000, 0), number(0x0004_0192));
    assert_eq!(default(0x1018, 2), number(18));
    assert_eq!(
        default(0x1400, 1),
        DefaultValue::Number {
            value: 0x200,
            adds_node_id: true
        }
    );
    assert_eq!(
        default(0x1800, 1),
        DefaultValue::Number {
            value: 0x4000_0180,
            adds_node_id: true
        }
    );
    assert_eq!(
        default(0x2009, 0),
        DefaultValue::Number {
            value: 0,
            adds_node_id: true
        }
    );
    assert_eq!(default(0x2003, 0), number(-2));
    assert_eq!(default(0x2004, 0), number(i64::MIN.into()));
    assert_eq!(default(0x2005, 0), number(u64::MAX.into()));
    assert_eq!(
        default(0x2008, 0),
        DefaultValue::Text(vec![0x01, 0xAB, 0xFF])
    );
    assert_eq!(
        default(0x1008, 0),
        DefaultValue::Text(br#"Small "quoted" \ name"#.to_vec())
    );
}

#[test]
fn what_is_left_out_has_its_standard_value() {
    let model = small();
    let register = model.entry(0x1001, 0).unwrap();
    assert_eq!(
        (
            register.default.clone(),
            register.low_limit,
            register.high_limit
        ),
        (None, None, None)
    );
    assert!(!model.entry(0x1000, 0).unwrap().pdo_mapping);
    assert_eq!(register.initial(), number(0), "where code is generated");
    let text = model.entry(0x2007, 0).unwrap();
    assert_eq!(text.default, None);
    assert_eq!(text.initial(), DefaultValue::Text(Vec::new()));
}

#[test]
fn limits_as_wide_as_the_type_are_none() {
    let model = small();
    let limits = |index, sub| {
        let entry = model.entry(index, sub).unwrap();
        entry.integer_limits()
    };
    assert_eq!(limits(0x2003, 0), (None, None));
    assert_eq!(limits(0x2005, 0), (Some(1), None));
    assert_eq!(limits(0x2001, 0), (Some(-5), None));
    assert_eq!(limits(0x200A, 1), (Some(-5), Some(200)));
}

#[test]
fn strings_have_the_capacity_of_their_comment_their_default_or_32() {
    let model = small();
    let size = |index| model.entry(index, 0).unwrap().size;
    assert_eq!((size(0x2006), size(0x2007), size(0x2008)), (5, 32, 3));
    let long = "x".repeat(40);
    let text = SMALL
        .replace(";Capacity=5", "")
        .replace("=hello", &format!("={long}"));
    assert_eq!(
        parse("small.eds", &text)
            .unwrap()
            .entry(0x2006, 0)
            .unwrap()
            .size,
        40
    );
}

#[test]
fn access_decides_the_direction_of_a_mapping() {
    let model = small();
    let mappable = |index| {
        let entry = model.entry(index, 0).unwrap();
        (entry.is_rpdo_mappable(), entry.is_tpdo_mappable())
    };
    assert_eq!(mappable(0x1001), (false, true));
    assert_eq!(mappable(0x2001), (true, false), "rww");
    assert_eq!(mappable(0x2002), (false, true), "rwr");
    assert_eq!(mappable(0x2003), (true, false), "wo");
    assert_eq!(mappable(0x2004), (false, false), "PDOMapping=0");
}

#[test]
fn the_device_is_described() {
    let model = small();
    assert_eq!(model.device.product_name, "Small [test] device");
    assert_eq!(model.device.bit_rates, [125, 1000]);
    assert!(model.device.lss);
    assert_eq!((model.rpdo_count(), model.tpdo_count()), (1, 1));
}

#[test]
fn o04_line_ends_byte_order_mark_and_letter_case_do_not_matter() {
    let same = small();
    for text in [
        SMALL.replace('\n', "\r\n"),
        format!("\u{feff}{SMALL}"),
        SMALL
            .replace("ParameterName=", "PARAMETERNAME = ")
            .replace("DataType=0x", "  datatype=0X"),
        SMALL
            .replace("[MandatoryObjects]", "[MANDATORYOBJECTS]")
            .replace("[1A00]", "[1a00]")
            .replace("=rw\n", "=RW\n"),
    ] {
        assert_eq!(parse("small.eds", &text).unwrap(), same);
    }
    assert_eq!(
        same.entry(0x2004, 0).unwrap().data_type,
        DataType::Integer64
    );
    assert_eq!(
        same.entry(0x2005, 0).unwrap().data_type,
        DataType::Unsigned64
    );
    assert_eq!(same.entry(0x200A, 2).unwrap().access, Access::ReadWrite);
}

#[test]
fn o04_compact_sub_indices_are_written_out() {
    let start = SMALL.find("[200A]").unwrap();
    let end = SMALL.find("[200B]").unwrap();
    let compact = "[200A]\nParameterName=Table\nObjectType=8\nCompactSubObj=3\nDataType=4\nAccessType=rw\n\
                   LowLimit=-5\nDefaultValue=7\nPDOMapping=1\n\
                   [200aName]\nNrOfEntries=1\n2=Second\n\
                   [200AValue]\nNrOfEntries=2\n1=0x10\n3=-5\n";
    let text = format!("{}{compact}{}", &SMALL[..start], &SMALL[end..]);
    let model = parse("small.eds", &text).unwrap();
    let object = model.object(0x200A).unwrap();
    let rows = object.entries.iter().map(|entry| {
        let default = entry.default_number().unwrap();
        (entry.sub, entry.name.as_str(), entry.data_type, default)
    });
    assert_eq!(
        rows.collect::<Vec<_>>(),
        [
            (0, "NrOfObjects", DataType::Unsigned8, 3),
            (1, "Table1", DataType::Integer32, 16),
            (2, "Second", DataType::Integer32, 7),
            (3, "Table3", DataType::Integer32, -5),
        ]
    );
    assert!(object.entries[1..].iter().all(Entry::is_rpdo_mappable));

    let wrong = text
        .replace("3=-5", "4=-5")
        .replace("[200aName]\nNrOfEntries=1", "[200aName]\nNrOfEntries=2");
    assert_eq!(
        said(&Report::new("small.eds", &wrong)),
        "283: NrOfEntries is 2, but 1 are listed\n288: `4` is no sub-index of 200Ah"
    );
    let section = "[200B]\nParameterName=Flag";
    finds(
        section,
        "[200AName]\n[200B]\nParameterName=Flag",
        section,
        "[200AName] goes with CompactSubObj in [200A]",
    );
}

#[test]
fn o04_a_missing_sub_index_0_is_found() {
    let old = "SubNumber=3\n\n[200ASub0]\nParameterName=Highest sub-index supported\nDataType=0x0005\nAccessType=const\n\
               DefaultValue=0x2\n";
    finds(old, "SubNumber=2\n", "[200A]", "200Ah has no sub-index 0");
}

#[test]
fn a_section_that_is_spelled_in_two_ways_is_there_twice() {
    let at = "[ManufacturerObjects]";
    for (again, first) in [("[1018sub01]", "[1018sub1]"), ("[1018SUB1]", "[1018sub1]")] {
        let first = line_of(first);
        finds(
            at,
            &format!("{again}\n{at}"),
            at,
            &format!("the section {again} is already on line {first}"),
        );
    }
    let twice = "[DeviceComissioning]\nNodeID=1\nBaudrate=125\n[DeviceCommissioning]\nNodeID=2\n";
    let said = findings(at, &format!("{twice}{at}"));
    let first = line_of(at);
    assert!(
        said.contains(&format!(
            "{}: the section [DeviceCommissioning] is already on line {first}",
            first + 3
        )),
        "{said}"
    );
}

#[test]
fn nothing_may_be_there_twice() {
    finds(
        "[ManufacturerObjects]",
        "[1000]\n[ManufacturerObjects]",
        "[ManufacturerObjects]",
        "the section [1000] is already on line 31",
    );
    finds(
        "FileRevision=0",
        "FILEVERSION=0",
        "FileRevision",
        "`FILEVERSION` is already on line 4, as `1`",
    );
    let findings = findings(
        "SupportedObjects=3\n1=0x1000\n2=0x1001\n",
        "SupportedObjects=3\n1=0x1000\n2=0x1000\n",
    );
    assert!(
        findings.contains("28: 1000h is already listed on line 27"),
        "{findings}"
    );
}

#[test]
fn what_is_not_known_is_never_dropped() {
    let section = "[ManufacturerObjects]";
    let with = |name: &str| format!("{name}\n{section}");
    for name in [
        "Vendor",
        "1000subG",
        "1000subFFF",
        "10G0",
        "0x1000",
        "DevisInfo",
    ] {
        let message = format!("the section [{name}] is not known");
        finds(section, &with(&format!("[{name}]")), section, &message);
    }
    finds(
        section,
        &with("[2FFF]\nParameterName=x\nObjectType=5"),
        section,
        "2FFFh is not listed in [ManufacturerObjects]\n192: 2FFFh defines a data type: it must be below 1000h",
    );
    finds(
        section,
        &with("[0005]\nParameterName=x\nDataType=5\nAccessType=rw"),
        section,
        "0005h is below 1000h: it must be a DEFTYPE or a DEFSTRUCT",
    );
    finds(
        "Granularity=8",
        "CompactPDO=1",
        "Granularity",
        "CompactPDO is 1: PDOs have a COB-ID and a transmission type",
    );
    finds(
        "Granularity=8",
        "BaudRate_100=1",
        "Granularity",
        "`BaudRate_100` in [DeviceInfo] is not known",
    );
    finds(
        "Granularity=8",
        "Granularity=65",
        "Granularity",
        "Granularity: 65 is not between 0 and 64",
    );
    finds(
        "Dummy0006=0",
        "Dummy00AA=0",
        "Dummy0006",
        "`Dummy00AA` in [DummyUsage] is no data type",
    );
    let default = "DefaultValue=hello";
    finds(
        default,
        "ParameterValue=hello",
        default,
        "`ParameterValue` in [2006] belongs to a DCF, not to an EDS",
    );
}

#[test]
fn sections_that_must_be_there_are_missed() {
    let text = "[Comments]\nLines=0\n";
    let findings = parse("empty.eds", text).unwrap_err();
    let messages: Vec<&str> = findings
        .iter()
        .map(|finding| finding.message.as_str())
        .collect();
    assert_eq!(
        messages,
        [
            "the section [FileInfo] is missing",
            "the section [DeviceInfo] is missing",
            "the section [MandatoryObjects] is missing",
            "the mandatory object 1000h is missing",
            "the mandatory object 1001h is missing",
            "the mandatory object 1018h is missing",
        ]
    );
}

#[test]
fn all_findings_come_in_one_run_in_the_order_of_the_file() {
    let text = SMALL
        .replace("DataType=0x0001", "DataType=0x0028")
        .replace("FileVersion=1", "?");
    let findings = parse("small.eds", &text).unwrap_err();
    let lines: Vec<usize> = findings
        .iter()
        .map(|finding| finding.span.line as usize)
        .collect();
    let flag = line_of("[200B]\n") + 2;
    assert_eq!(
        lines,
        [line_of("FileVersion"), line_of("[2000]\n") + 2, flag]
    );
}

#[test]
fn the_dictionary_has_room_for_16_bit_offsets() {
    let mut text = SMALL.to_string();
    let listed: String = (0..600)
        .map(|number| format!("{}=0x{:04X}\n", number + 13, 0x3000 + number))
        .collect();
    text = text
        .replace("SupportedObjects=12", "SupportedObjects=612")
        .replace("12=0x200B\n", &format!("12=0x200B\n{listed}"));
    for number in 0..600 {
        let index = 0x3000 + number;
        text += &format!(
            "[{index:04X}]\n;Capacity=128\nParameterName=Text\nDataType=0x9\nAccessType=rw\n"
        );
    }
    assert!(parse("big.eds", &text).is_ok(), "others can read it");
    let findings = Report::for_code("big.eds", &text).findings;
    assert_eq!(findings.len(), 1);
    assert_eq!(
        findings[0].to_string(),
        "big.eds:1:1: error[dictionary-too-large]: the values of the dictionary take more than 64 KiB"
    );
}

#[test]
fn long_constants_take_room_in_the_dictionary_too() {
    let mut text = SMALL
        .replace("SupportedObjects=12", "SupportedObjects=14")
        .replace("12=0x200B\n", "12=0x200B\n13=0x3000\n14=0x3001\n");
    for index in ["3000", "3001"] {
        let value = "x".repeat(40_000);
        text += &format!(
            "[{index}]\nParameterName=Text\nDataType=0x9\nAccessType=const\nDefaultValue={value}\n"
        );
    }
    let findings = Report::for_code("big.eds", &text).findings;
    assert_eq!(findings[0].rule.name, "dictionary-too-large");
}

proptest! {
    #[test]
    fn a_spoiled_data_sheet_gets_a_model_or_findings_that_name_a_line(
        at in 0..SMALL.len(),
        cut in 0usize..40,
        put in "([0-9A-Fa-fx$\\[\\]=;+-]|\\n|\\PC){0,8}",
    ) {
        let end = (at + cut).min(SMALL.len());
        let text = format!("{}{put}{}", &SMALL[..at], &SMALL[end..]);
        if let Err(findings) = parse("spoiled.eds", &text) {
            prop_assert!(!findings.is_empty());
            prop_assert!(findings.is_sorted_by_key(|finding| finding.span));
            prop_assert!(findings.iter().all(|finding| (1..=text.lines().count().max(1)).contains(&(finding.span.line as usize))));
        }
    }
}

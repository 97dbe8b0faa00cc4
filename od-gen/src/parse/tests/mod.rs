//! A correct data sheet, and what is said when one thing in it is changed.

use proptest::prelude::*;

use super::*;
use crate::data_type::DataType;
use crate::model::{Access, DefaultValue};

mod cob_ids;
mod dictionary;
mod entries;

const SMALL: &str = include_str!("../../../tests/data/small.eds");

/// The findings, one a line, after `old` (which is there once) has become `new`.
fn findings(old: &str, new: &str) -> String {
    assert_eq!(SMALL.matches(old).count(), 1, "{old}");
    let text = SMALL.replacen(old, new, 1);
    let findings = parse("small.eds", &text).map_or_else(|findings| findings, |_| Vec::new());
    findings
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join("\n")
}

/// The line on which `text` begins.
fn line_of(text: &str) -> usize {
    SMALL[..SMALL.find(text).unwrap()].lines().count() + 1
}

/// One change, one finding, on the line of `at`.
#[track_caller]
fn finds(old: &str, new: &str, at: &str, message: &str) {
    assert_eq!(
        findings(old, new),
        format!("small.eds:{}: error: {message}", line_of(at))
    );
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
    let default = |index, sub| model.entry(index, sub).unwrap().default.clone();
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
        (number(0), None, None)
    );
    assert!(!model.entry(0x1000, 0).unwrap().pdo_mapping);
    assert_eq!(
        model.entry(0x2007, 0).unwrap().default,
        DefaultValue::Text(Vec::new())
    );
}

#[test]
fn limits_as_wide_as_the_type_are_none() {
    let model = small();
    let limits = |index, sub| {
        let entry = model.entry(index, sub).unwrap();
        (entry.low_limit, entry.high_limit)
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
fn o04_compact_sub_indices_are_refused_with_their_line() {
    finds(
        "ObjectType=8\nSubNumber=3",
        "ObjectType=8\nCompactSubObj=3",
        "SubNumber=3\n\n[200ASub0]",
        "CompactSubObj is not supported: write the sub-indices out",
    );
    let section = "[200B]\nParameterName=Flag";
    finds(
        section,
        "[200AName]\n[200B]\nParameterName=Flag",
        section,
        "compact sub-indices are not supported: write [200AName] out as sub sections",
    );
}

#[test]
fn o04_a_missing_sub_index_0_is_found() {
    let old = "SubNumber=3\n\n[200ASub0]\nParameterName=Highest sub-index supported\nDataType=0x0005\nAccessType=const\n\
               DefaultValue=0x2\n";
    finds(old, "SubNumber=2\n", "[200A]", "200Ah has no sub-index 0");
}

#[test]
fn lines_that_are_nothing_are_found() {
    finds(
        "FileVersion=1",
        "nonsense",
        "FileVersion=1",
        "`nonsense` is neither a section nor key=value nor a ;comment",
    );
    finds(
        "[FileInfo]",
        "Early=1\n[FileInfo]",
        "[FileInfo]",
        "`Early` stands before the first section",
    );
    finds(
        "[1000]",
        "[1000] x",
        "[1000]",
        "`[1000] x` is not a section: it must end with its `]`",
    );
    finds(
        "[1000]",
        "[1000",
        "[1000]",
        "`[1000` is not a section: it must end with its `]`",
    );
    finds(
        "EDSVersion=4.0",
        "EDSVersion=4.0 ; old",
        "EDSVersion",
        "a comment takes a line of its own: move `;` out of `EDSVersion`",
    );
}

#[test]
fn control_characters_are_found_and_do_no_other_harm() {
    let old = "ParameterName=Flag";
    for (control, code) in [
        ('\0', "0000"),
        ('\u{1B}', "001B"),
        ('\r', "000D"),
        ('\u{7F}', "007F"),
        ('\u{85}', "0085"),
        ('\u{202E}', "202E"),
    ] {
        for new in [
            format!("ParameterName=Fl{control}ag"),
            format!("Param{control}eterName=Flag"),
            format!(";a comment{control}!\nParameterName=Flag"),
        ] {
            let message = format!("control character U+{code}: remove it");
            finds(old, &new, old, &message);
        }
    }
    assert_eq!(findings(old, "ParameterName\t=\tFlag\t"), "");
}

#[test]
fn nothing_may_be_there_twice() {
    finds(
        "[ManufacturerObjects]",
        "[1000]\n[ManufacturerObjects]",
        "[ManufacturerObjects]",
        "section [1000] is already on line 31",
    );
    finds(
        "FileRevision=0",
        "FILEVERSION=0",
        "FileRevision",
        "`FILEVERSION` is already on line 4",
    );
    let findings = findings(
        "SupportedObjects=3\n1=0x1000\n2=0x1001\n",
        "SupportedObjects=3\n1=0x1000\n2=0x1000\n",
    );
    assert!(
        findings.contains("small.eds:28: error: 1000h is already listed on line 27"),
        "{findings}"
    );
}

#[test]
fn what_is_not_supported_is_never_dropped() {
    let section = "[ManufacturerObjects]";
    let with = |name: &str| format!("{name}\n{section}");
    finds(
        section,
        &with("[Tools]"),
        section,
        "the section [Tools] is not supported",
    );
    finds(
        section,
        &with("[DynamicChannels]"),
        section,
        "the section [DynamicChannels] is not supported",
    );
    finds(
        section,
        &with("[0005]"),
        section,
        "0005h defines a data type, which is not supported",
    );
    finds(
        section,
        &with("[1000subG]"),
        section,
        "the section [1000subG] is not supported",
    );
    finds(
        "EDSVersion=4.0",
        "LastEDS=old.eds",
        "EDSVersion",
        "`LastEDS` in [FileInfo] is not supported here",
    );
    finds(
        "Granularity=8",
        "CompactPDO=1",
        "Granularity",
        "CompactPDO is not supported: it must be 0",
    );
    finds(
        "Granularity=8",
        "BaudRate_100=1",
        "Granularity",
        "`BaudRate_100` in [DeviceInfo] is not supported here",
    );
    finds(
        "Granularity=8",
        "Granularity=65",
        "Granularity",
        "Granularity: 65 is not between 0 and 64",
    );
    finds(
        "Dummy0006=0",
        "Dummy0008=0",
        "Dummy0006",
        "`Dummy0008` in [DummyUsage] is not supported",
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
        .replace("DataType=0x0001", "DataType=0x0008")
        .replace("FileVersion=1", "?");
    let findings = parse("small.eds", &text).unwrap_err();
    let lines: Vec<usize> = findings.iter().map(|finding| finding.line).collect();
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
    let findings = parse("big.eds", &text).unwrap_err();
    assert_eq!(findings.len(), 1);
    assert_eq!(
        findings[0].to_string(),
        "big.eds:1: error: the values of the dictionary take more than 64 KiB"
    );
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
            prop_assert!(findings.is_sorted_by_key(|finding| finding.line));
            prop_assert!(findings.iter().all(|finding| (1..=text.lines().count().max(1)).contains(&finding.line)));
        }
    }
}

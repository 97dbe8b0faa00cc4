//! Mistakes between objects.

use super::{SMALL, finds};
use crate::report::Report;

#[test]
fn objects_are_of_a_known_kind() {
    let old = "ObjectType=8";
    finds(
        old,
        "ObjectType=4",
        old,
        "ObjectType 4 is no kind of object",
    );
    finds(
        old,
        "ObjectType=2",
        old,
        "200Ah is a DOMAIN: it has no sub-indices",
    );
    let old = "[200asub1]\n";
    finds(
        old,
        "[200asub1]\nObjectType=8\n",
        "ParameterName=Element\nDataType=0x0004\nAccessType=rw\nLow",
        "ObjectType of a sub-index is 0x7 (VAR), not ARRAY",
    );
    let odd = "Element\nDataType=0x0004\nAccessType=rw\n\n";
    finds(
        odd,
        "Element\nDataType=0x0007\nAccessType=rw\n\n",
        "[200AsUB2]",
        "an ARRAY has one type: 200Ah:2 is UNSIGNED32, not INTEGER32",
    );
}

#[test]
fn sub_numbers_count_the_sub_sections() {
    let old = "SubNumber=3\n\n[200A";
    finds(
        old,
        "SubNumber=2\n\n[200A",
        old,
        "SubNumber is 2, but 200Ah has 3 sub sections",
    );
    finds(
        old,
        "SubNumber=0x3z\n\n[200A",
        old,
        "`0x3z` is not a number (decimal, 0x hexadecimal or leading-zero octal)",
    );
    finds(old, "\n[200A", "[200A]", "`SubNumber` is missing in [200A]");
    let flag = "ParameterName=Flag";
    finds(
        flag,
        "SubNumber=1\nParameterName=Flag",
        flag,
        "200Bh is a VAR: it has no sub-indices",
    );
    let flag = "[200B]\nParameterName=Flag\nDataType=0x0001\nAccessType=const\nDefaultValue=1\n";
    let with_sub = format!("{flag}[200BSub1]\nParameterName=x\nDataType=5\nAccessType=rw\n");
    finds(
        flag,
        &with_sub,
        flag,
        "200Bh is a VAR: it has no sub-indices",
    );
    finds(
        "[200B]\n",
        "[3000sub1]\n[200B]\n",
        "[200B]\n",
        "[3000sub1] has no object: there is no section [3000]",
    );
}

#[test]
fn sub_index_0_is_the_highest_one() {
    let old = "DefaultValue=0x2\n\n[200asub1]";
    finds(
        old,
        "DefaultValue=1\n\n[200asub1]",
        "[200ASub0]",
        "200Ah:0 is 1, but the highest sub-index is 2",
    );
    finds(
        "Highest sub-index supported\nDataType=0x0005\nAccessType=const\nDefaultValue=0x2",
        "Highest\nDataType=0x0006\nAccessType=const\nDefaultValue=0x2",
        "[200ASub0]",
        "200Ah:0 is UNSIGNED16, not UNSIGNED8",
    );
    let old = "DefaultValue=1\n\n[1A00sub1]";
    let message = "1A00h:0 is 2, above the highest sub-index 1";
    finds(old, "DefaultValue=2\n\n[1A00sub1]", "[1A00sub0]", message);
}

/// A data type that is none is a warning, and cost the object its sub-index 0: what was written of it was read as another.
#[test]
fn a_sub_index_0_that_cannot_be_read_is_there() {
    let old = "Highest sub-index supported\nDataType=0x0005\nAccessType=ro";
    let text = SMALL.replacen(old, "Highest\nDataType=0x0000\nAccessType=ro", 1);
    let report = Report::new("small.eds", &text);
    assert!(!report.has_errors() && report.findings.len() == 1);
    let object = report.model.object(0x1018).unwrap();
    let first = object.entry(0).unwrap();
    assert_eq!(
        (first.data_type, &first.default),
        (super::DataType::Unsigned8, &Some(super::number(3)))
    );
    let again = super::parse("small.eds", &crate::print(&report.model)).unwrap();
    assert_eq!(again, report.model);
}

#[test]
fn lists_and_sections_agree() {
    finds(
        "SupportedObjects=12\n",
        "SupportedObjects=13\n",
        "SupportedObjects=12",
        "SupportedObjects is 13, but 12 are listed",
    );
    finds(
        "SupportedObjects=12\n",
        "",
        "[ManufacturerObjects]",
        "`SupportedObjects` is missing in [ManufacturerObjects]",
    );
    finds(
        "SupportedObjects=12\n",
        "SupportedObjects=\n",
        "[ManufacturerObjects]",
        "`SupportedObjects` is missing in [ManufacturerObjects]",
    );
    let list = "SupportedObjects=12\n1=0x2000\n2=0x2001\n";
    finds(
        "12=0x200B\n",
        "13=0x200B\n",
        "12=0x200B",
        "`13` where number 12 of the list should be",
    );
    finds(
        list,
        "SupportedObjects=12\n1=0x2000\n2=0x2fff\n",
        "2=0x2001",
        "2FFFh is listed, but there is no section [2FFF]\n211: 2001h is not listed in [ManufacturerObjects]",
    );
    finds(
        "1=0x1005\n",
        "1=5\n",
        "1=0x1005",
        "`5` is not an index (0x1000 to 0xFFFF)\n82: 1005h is not listed in [OptionalObjects]",
    );
    let (old, new) = ("6=0x1A00\n", "6=0x1A00\n7=0x2000\n");
    assert!(SMALL.contains("SupportedObjects=6"));
    let findings = super::findings(old, new);
    assert!(
        findings.contains("2000h belongs in [ManufacturerObjects]"),
        "{findings}"
    );
    assert!(
        findings.contains("2000h is already listed on line"),
        "{findings}"
    );
}

#[test]
fn device_info_repeats_what_the_dictionary_says() {
    finds(
        "VendorNumber=0x11",
        "VendorNumber=0x12",
        "VendorNumber",
        "VendorNumber is 0x00000012, but 1018h:1 is 0x00000011",
    );
    finds(
        "ProductNumber=18",
        "ProductNumber=19",
        "ProductNumber",
        "ProductNumber is 0x00000013, but 1018h:2 is 0x00000012",
    );
    finds(
        "NrOfRXPDO=1",
        "NrOfRXPDO=2",
        "NrOfRXPDO",
        "NrOfRXPDO is 2, but 1 are described from 1400h on",
    );
    finds(
        "NrOfTXPDO=1",
        "NrOfTXPDO=0",
        "NrOfTXPDO",
        "NrOfTXPDO is 0, but 1 are described from 1800h on",
    );
}

#[test]
fn communication_objects_have_their_standard_types() {
    let old = "ParameterName=COB-ID SYNC message\nDataType=0x0007";
    finds(
        old,
        "ParameterName=COB-ID SYNC message\nDataType=0x0006",
        "[1005]",
        "1005h is UNSIGNED16, but CiA 301 makes it UNSIGNED32",
    );
    let old = "ParameterName=Inhibit time\nDataType=0x0006";
    finds(
        old,
        "ParameterName=Inhibit time\nDataType=0x0005",
        "[1800sub3]",
        "1800h:3 is UNSIGNED8, but CiA 301 makes it UNSIGNED16",
    );
}

#[test]
fn pdos_come_in_pairs_from_number_1_on() {
    let text = SMALL.replace("[1600", "[1601").replace("0x1600", "0x1601");
    let found: Vec<String> = Report::new("x.eds", &text)
        .findings
        .iter()
        .map(|finding| finding.message.clone())
        .collect();
    assert_eq!(
        found,
        [
            "RPDO 1: the mapping 1600h is missing",
            "RPDO 2: the communication parameter 1401h is missing"
        ]
    );
    let text = SMALL
        .replace("[1A00", "[1A01")
        .replace("0x1A00", "0x1A01")
        .replace("[1800", "[1801")
        .replace("0x1800", "0x1801");
    let found: Vec<String> = Report::new("x.eds", &text)
        .findings
        .iter()
        .map(|finding| finding.message.clone())
        .collect();
    assert_eq!(
        found,
        [
            "TPDO 2 follows a gap: 1800h is not there",
            "1801h:1 is 180h + node-ID, but 280h + node-ID is predefined"
        ]
    );
    finds(
        "[1400sub2]\n",
        "[1400sub4]\n",
        "[1400]",
        "1400h has no sub-index 2, which CiA 301 asks for\n103: 1400h:0 is 2, but the highest sub-index is 4",
    );
}

#[test]
fn default_mappings_can_be_carried() {
    let receive = "DefaultValue=0x20030010";
    let at = "[1600sub2]";
    finds(
        receive,
        "DefaultValue=0x5FFF0010",
        at,
        "1600h:2 maps 5FFF0010h: 5FFFh:0 does not exist",
    );
    finds(
        receive,
        "DefaultValue=0x20030110",
        at,
        "1600h:2 maps 20030110h: 2003h:1 does not exist",
    );
    finds(
        receive,
        "DefaultValue=0x20030008",
        at,
        "1600h:2 maps 20030008h: 2003h:0 has 16 bits, not 8",
    );
    finds(
        receive,
        "DefaultValue=0x20020008",
        at,
        "1600h:2 maps 20020008h: 2002h:0 is rwr, which does not go into a receive PDO",
    );
    finds(
        receive,
        "DefaultValue=0x20000008",
        at,
        "1600h:2 maps 20000008h: 2000h:0 cannot be mapped",
    );
    finds(
        receive,
        "DefaultValue=0x00060010",
        at,
        "1600h:2 maps 00060010h: [DummyUsage] does not allow Dummy0006",
    );
    finds(
        receive,
        "DefaultValue=0x00050108",
        at,
        "1600h:2 maps 00050108h: 0005h:1 is no data type of a gap",
    );
    finds(
        receive,
        "DefaultValue=0x00050010",
        at,
        "1600h:2 maps 00050010h: 0005h:0 has 8 bits, not 16",
    );
    let transmit = "DefaultValue=0x10010008";
    finds(
        transmit,
        "DefaultValue=0x20030010",
        "[1A00sub1]",
        "1A00h:1 maps 20030010h: 2003h:0 is wo, which does not go into a transmit PDO",
    );
    finds(
        transmit,
        "DefaultValue=0x00050008",
        "[1A00sub1]",
        "1A00h:1 maps 00050008h: a gap is for receive PDOs",
    );
    finds(
        transmit,
        "DefaultValue=0",
        "[1A00sub1]",
        "1A00h:1 maps nothing, but 1A00h:0 is 1",
    );
}

#[test]
fn default_mappings_fit_in_a_frame() {
    let text = SMALL.replace(
        "AccessType=rw\nDefaultValue=-92233",
        "AccessType=rw\nPDOMapping=1\nDefaultValue=-92233",
    );
    let text = text.replace("0x20030010", "0x20040040");
    let findings = super::parse("x.eds", &text).unwrap_err();
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].message, "1600h maps 72 bits, a PDO carries 64");
}

#[test]
fn a_broken_object_is_not_called_missing_by_its_mapping() {
    finds(
        "ParameterName=Pattern\nDataType=0x0003",
        "ParameterName=Pattern\nDataType=0x0003x",
        "DataType=0x0003\nAccessType=wo",
        "`0x0003x` is not a number (decimal, 0x hexadecimal or leading-zero octal)",
    );
}

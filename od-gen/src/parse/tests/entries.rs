//! Mistakes in one value.

use super::{SMALL, findings, finds, finds_for_code, finds_nothing, line_of, said};
use crate::model::{Entry, Limit};
use crate::report::Report;

#[test]
fn keys_that_must_be_there_are_missed() {
    finds(
        "ParameterName=Pattern\n",
        "",
        "[2003]",
        "`ParameterName` is missing in [2003]",
    );
    finds(
        "ParameterName=Table\n",
        "",
        "[200A]",
        "`ParameterName` is missing in [200A]",
    );
    let (old, at) = ("ParameterName=Flag\nDataType=0x0001\n", "[200B]");
    finds(
        old,
        "ParameterName=Flag\n",
        at,
        "`DataType` is missing in [200B]",
    );
    finds(
        "Flag\nDataType=0x0001\nAccessType=const",
        "Flag\nDataType=0x0001\nAccessType=",
        at,
        "`AccessType` is missing in [200B]",
    );
}

#[test]
fn types_and_accesses_are_known_ones() {
    let at = "DataType=0x0015";
    finds(
        at,
        "DataType=0x0028",
        at,
        "DataType 0x0028 is no type of a value",
    );
    finds(
        at,
        "DataType=long",
        at,
        "`long` is not a number (decimal, 0x hexadecimal or leading-zero octal)",
    );
    finds(
        "AccessType=wo",
        "AccessType=w",
        "AccessType=wo",
        "AccessType `w` is not ro, wo, rw, rwr, rww or const",
    );
    let old = "PDOMapping=1\nLowLimit=-5";
    finds(
        old,
        "PDOMapping=2\nLowLimit=-5",
        old,
        "PDOMapping: 2 is not between 0 and 1",
    );
    let old = "AccessType=rw\nDefaultValue=hello";
    finds(
        old,
        &format!("PDOMapping=1\n{old}"),
        old,
        "PDOMapping of a VISIBLE_STRING is not supported",
    );
    finds(
        old,
        &format!("ObjFlags=x\n{old}"),
        old,
        "ObjFlags: `x` is not a number (decimal, 0x hexadecimal or leading-zero octal)",
    );
}

#[test]
fn s30_a_default_fits_its_type_and_its_limits() {
    let old = "DefaultValue=-1";
    finds(
        old,
        "DefaultValue=-129",
        old,
        "DefaultValue -129 does not fit INTEGER8 (-128 to 127)",
    );
    finds(
        old,
        "DefaultValue=0x100",
        old,
        "DefaultValue 0x100 does not fit INTEGER8 (-128 to 127)",
    );
    finds(
        old,
        "DefaultValue=128",
        old,
        "DefaultValue 128 does not fit INTEGER8 (-128 to 127)",
    );
    finds(
        old,
        "DefaultValue=-6",
        old,
        "DefaultValue -6 is below LowLimit -5",
    );
    finds(
        old,
        "DefaultValue=0xFA",
        old,
        "DefaultValue 0xFA is below LowLimit -5",
    );
    finds(
        "HighLimit=200\nPDOMapping=1",
        "HighLimit=200\nDefaultValue=201",
        "PDOMapping=1\n\n[2003]",
        "DefaultValue 201 is above HighLimit 200",
    );
    let old = "DefaultValue=18446744073709551615";
    finds_nothing(old, "");
    finds_for_code(
        old,
        "",
        "DefaultValue 0 (there is none) is below LowLimit 1",
    );
    finds(
        old,
        "DefaultValue=18446744073709551616",
        old,
        "`18446744073709551616` is beyond 64 bits",
    );
}

#[test]
fn s30_limits_fit_their_type_and_leave_room() {
    finds(
        "LowLimit=0x8000",
        "LowLimit=-32769",
        "LowLimit=0x8000",
        "LowLimit -32769 does not fit INTEGER16 (-32768 to 32767)",
    );
    finds(
        "HighLimit=200\nPDO",
        "HighLimit=256\nPDO",
        "HighLimit=200\nPDO",
        "HighLimit 256 does not fit UNSIGNED8 (0 to 255)",
    );
    finds(
        "HighLimit=200\n\n",
        "HighLimit=-6\n\n",
        "[200asub1]",
        "LowLimit -5 is above HighLimit -6 in INTEGER32",
    );
    finds(
        "DefaultValue=hello",
        "LowLimit=1\nDefaultValue=hello",
        "DefaultValue=hello",
        "LowLimit does not go with VISIBLE_STRING",
    );
}

#[test]
fn the_node_id_goes_where_it_fits() {
    let old = "DefaultValue=-1";
    finds(
        old,
        "DefaultValue=$NODEID+1",
        old,
        "$NODEID does not go with INTEGER8",
    );
    let old = "DefaultValue=$NODEID\n";
    finds(
        old,
        "DefaultValue=$NODEID+0xFF81\n",
        old,
        "DefaultValue $NODEID+0xFF81 leaves no room for the node-ID",
    );
    finds(
        old,
        "DefaultValue=$NODEID-1\n",
        old,
        "`$NODEID-1` is not a number, $NODEID, $NODEID+number or number+$NODEID",
    );
    finds(
        old,
        "DefaultValue=1+2\n",
        old,
        "`1+2` is not a number (decimal, 0x hexadecimal or leading-zero octal)",
    );
    let limited = "LowLimit=2\nDefaultValue=$NODEID\n";
    finds(
        old,
        limited,
        "\n[200A]",
        "DefaultValue $NODEID is below LowLimit 2",
    );
    let limited = "HighLimit=126\nDefaultValue=$NODEID\n";
    finds(
        old,
        limited,
        "\n[200A]",
        "DefaultValue $NODEID is above HighLimit 126",
    );
}

#[test]
fn limits_may_have_the_node_id_in_them() {
    let old = "DefaultValue=$NODEID\n";
    let new = "LowLimit=$NODEID\nHighLimit=0x180+$NODEID\nDefaultValue=$NODEID\n";
    let text = SMALL.replacen(old, new, 1);
    let report = Report::new("small.eds", &text);
    assert!(!report.has_errors(), "{}", said(&report));
    let is_node_id = |entry: &&Entry| entry.adds_node_id() && entry.default_number() == Some(0);
    let mut entries = report.model.entries().map(|(_, entry)| entry);
    let entry = entries.find(is_node_id).unwrap();
    let limits = (entry.low_limit, entry.high_limit);
    assert_eq!(limits, (Some(Limit::NodeId(0)), Some(Limit::NodeId(0x180))));
    assert_eq!(entry.integer_limits(), (None, None));
    // It is written again as it was, and what is above another in every node is told.
    let printed = crate::print(&report.model);
    assert!(printed.contains("LowLimit=$NODEID\nHighLimit=$NODEID+0x180\n"));
    assert!(crate::json(&report.model).contains("\"low_limit\": \"$NODEID\""));
    let turned = text.replacen("LowLimit=$NODEID", "LowLimit=$NODEID+0x200", 1);
    let turned = said(&Report::new("small.eds", &turned));
    let above = "LowLimit $NODEID+0x200 (200h + node-ID) is above HighLimit";
    assert!(turned.contains(above), "{turned}");
    finds_for_code(
        old,
        "LowLimit=$NODEID\nDefaultValue=$NODEID\n",
        "LowLimit $NODEID differs from node to node",
    );
}

#[test]
fn strings_are_spelled_and_fit_an_sdo_transfer() {
    let old = "DefaultValue=hello";
    finds(
        old,
        "DefaultValue=helö",
        old,
        "a VISIBLE_STRING holds the characters 20h to 7Eh",
    );
    finds(
        old,
        "DefaultValue=hello!",
        ";Capacity=5",
        "Capacity 5 is less than the 6 bytes of the default",
    );
    finds(
        ";Capacity=5",
        ";Capacity=65536",
        ";Capacity=5",
        "Capacity: 65536 is not between 1 and 65535",
    );
    finds(
        ";Capacity=5",
        "; capacity = ?",
        ";Capacity=5",
        "Capacity: `?` is not a number (decimal, 0x hexadecimal or leading-zero octal)",
    );
    finds(
        "[2004]",
        "[2004]\n;Capacity=5",
        "ParameterName=Wide\n",
        "Capacity does not go with INTEGER64",
    );
    finds(
        "[2008]",
        "[2008]\n;Capacity=5",
        "ParameterName=Fixed",
        "Capacity of a string that cannot be written",
    );
    let old = "DefaultValue=01 aB ff";
    finds(
        old,
        "DefaultValue=01 a",
        old,
        "`01 a` is not an OCTET_STRING: two hexadecimal digits a byte",
    );
    finds(
        old,
        "DefaultValue=0x01",
        old,
        "`0x01` is not an OCTET_STRING: two hexadecimal digits a byte",
    );
    let long = format!("DefaultValue={}", "00".repeat(65536));
    finds(
        old,
        &long,
        "[2008]",
        "[2008] takes 65536 bytes, a value has at most 65535",
    );
}

#[test]
fn a_constant_has_a_value() {
    finds(
        "DefaultValue=$NODEID\n",
        "",
        "[2009]",
        "`Own identifier` is const: it needs a DefaultValue",
    );
}

#[test]
fn a_name_has_something_to_make_a_name_of() {
    // Of a variable, of a record, of a sub-index.
    for old in [
        "ParameterName=Flag",
        "ParameterName=RPDO communication parameter",
        "ParameterName=Inhibit time",
    ] {
        for name in ["***", "-", "_", "\u{4F4D}"] {
            let message =
                format!("ParameterName `{name}` has none of the letters A to Z and no digit");
            finds(old, &format!("ParameterName={name}"), old, &message);
        }
        for name in ["7", "*x*"] {
            assert_eq!(findings(old, &format!("ParameterName={name}")), "");
        }
    }
}

#[test]
fn the_limits_of_an_unsigned64_reach_to_its_end() {
    let old = "HighLimit=0xFFFFFFFFFFFFFFFF";
    for high in [i64::MAX.into(), 1_i128 << 63, (1_i128 << 64) - 2] {
        let new = format!("HighLimit=0x{high:X}");
        let report = Report::new(
            "small.eds",
            &SMALL
                .replace(old, &new)
                .replace("=18446744073709551615", "=1"),
        );
        assert!(!report.has_errors());
        let entry = report.model.entry(0x2005, 0).unwrap();
        assert_eq!(entry.high_limit, Some(Limit::Integer(high)));
        assert_eq!(entry.integer_limits(), (Some(1), Some(high)));
        let printed = crate::print(&report.model);
        assert_eq!(Report::new("small.eds", &printed).model, report.model);
    }
}

#[test]
fn what_a_variable_and_a_domain_cannot_have_is_found() {
    finds(
        "ParameterName=Flag",
        "CompactSubObj=8\nParameterName=Flag",
        "ParameterName=Flag",
        "200Bh is a VAR: it has no sub-indices",
    );
    assert_eq!(
        findings("ParameterName=Flag", "CompactSubObj=0\nParameterName=Flag"),
        ""
    );
    let old = "ParameterName=Flag\nDataType=0x0001\nAccessType=const\nDefaultValue=1";
    finds(
        old,
        "ParameterName=Flag\nObjectType=2\nAccessType=rw\nDefaultValue=hello",
        old,
        "DefaultValue of a DOMAIN means nothing",
    );
}

#[test]
fn an_allowance_of_an_object_is_for_its_sub_indices_too() {
    let said = |text: &str| {
        let report = Report::new("small.eds", text);
        let silenced = report.silenced.iter();
        let silenced = silenced.map(|(finding, _)| finding.span.line).collect();
        (said(&report), silenced)
    };
    let (_, before): (_, Vec<u32>) = said(SMALL);
    let broken = SMALL.replacen("[1018sub1]\n", "[1018sub1]\nLowLimit=0x12\n", 1);
    let outside = format!(
        "{}: DefaultValue 0x11 is below LowLimit 18",
        line_of("[1018sub1]") + 5
    );
    assert_eq!(said(&broken).0, outside);
    let allowance = "; od-gen: allow default-outside-limits because it is a test\n";
    for section in ["[1018]\n", "[1018sub1]\n"] {
        let text = broken.replacen(section, &format!("{section}{allowance}"), 1);
        let (findings, silenced) = said(&text);
        assert_eq!(findings, "", "{section}");
        assert_eq!(silenced.len(), before.len() + 1);
    }
    let elsewhere = broken.replacen("[1018sub2]\n", &format!("[1018sub2]\n{allowance}"), 1);
    assert_eq!(
        said(&elsewhere).0.lines().count(),
        2,
        "and it silences nothing there"
    );
}

#[test]
fn limits_of_0_and_0_may_be_meant_as_none() {
    let old = "LowLimit=-5\nDefaultValue=-1\n";
    assert_eq!(SMALL.matches(old).count(), 1);
    let help = |limits: &str| {
        let new = format!("{limits}DefaultValue=-1\n");
        let report = Report::new("small.eds", &SMALL.replacen(old, &new, 1));
        let finding = report.findings.into_iter().next();
        finding.and_then(|finding| finding.help)
    };
    let either = "either the default is wrong, or the limit";
    assert_eq!(help("LowLimit=-5\nHighLimit=-3\n").as_deref(), Some(either));
    let none = "some tools write 0 and 0 where there are no limits: remove both";
    assert_eq!(help("LowLimit=0\nHighLimit=0\n").as_deref(), Some(none));
}

#[test]
fn nothing_hides_another_mistake() {
    let old = "AccessType=wo\nPDOMapping=1\nLowLimit=0x8000\nHighLimit=0x7FFF\n";
    assert_eq!(SMALL.matches(old).count(), 1);
    let new = "AccessType=w/o\nPDOMapping=1\nLowLimit=low\nHighLimit=70000\n";
    let text = SMALL.replacen(old, new, 1);
    let report = Report::new("small.eds", &text);
    let rules = report.findings.iter().map(|finding| finding.rule.name);
    let rules: Vec<&str> = rules.collect();
    assert_eq!(rules, ["access-type", "not-a-number", "limit-type"]);
    let entry = report.model.entry(0x2003, 0).unwrap();
    assert_eq!(
        entry.access,
        crate::model::Access::WriteOnly,
        "plainly meant"
    );
    assert_eq!((entry.low_limit, entry.high_limit), (None, None));
    assert!(entry.default.is_some());
}

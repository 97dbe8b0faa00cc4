use super::*;
use crate::model::DefaultValue;
use crate::print::print;
use crate::report::{Report, parse};

const SMALL: &str = include_str!("../../tests/data/small.eds");

fn configured(values: &str) -> (Model, Vec<String>) {
    let mut model = parse("small.eds", SMALL).unwrap();
    let node = Commissioning {
        node_id: 5,
        node_name: "Pump".into(),
        bit_rate: 125,
        ..Commissioning::default()
    };
    commission(&mut model, node, "pump.dcf");
    let findings = apply(&mut model, &Values::new("values", values));
    (model, findings.iter().map(ToString::to_string).collect())
}

#[test]
fn a_configuration_is_read_as_it_was_made() {
    let (model, findings) = configured(
        "# speeds\n2001=-3\n 0x200A : 1 = 0x64 \n1400h:1=$NODEID+0x300\n\n; names\n2006=abc\n2007=with = in it\n",
    );
    assert_eq!(findings, [""; 0]);
    let report = Report::new("pump.dcf", &print(&model));
    assert!(
        !report.has_errors(),
        "{}",
        report.render(crate::Colour::Never)
    );
    let read = report.model;
    let value = |index, sub| read.entry(index, sub).unwrap().configured.clone();
    assert_eq!(value(0x2001, 0), Some(DefaultValue::number(-3)));
    assert_eq!(value(0x200A, 1), Some(DefaultValue::number(100)));
    assert_eq!(
        value(0x1400, 1),
        Some(DefaultValue::Number {
            value: 0x300,
            adds_node_id: true
        })
    );
    assert_eq!(value(0x2006, 0), Some(DefaultValue::Text(b"abc".to_vec())));
    assert_eq!(
        value(0x2007, 0),
        Some(DefaultValue::Text(b"with = in it".to_vec()))
    );
    assert_eq!(
        value(0x2000, 0),
        None,
        "what is not asked for is left to the device"
    );
    let node = read.commissioning.unwrap();
    assert_eq!(
        (node.node_id, node.bit_rate, node.node_name.as_str()),
        (5, 125, "Pump")
    );
    assert_eq!(read.file_info.file_name, "pump.dcf");
    assert_eq!(read.file_info.last_eds, "small.eds");
}

#[test]
fn what_the_device_would_refuse_is_found() {
    let (model, findings) = configured(
        "1000=1\n200A:1=201\n200A:1=-6\n2001=300\n2006=abcdef\n3000=1\n200A:9=1\n2001\n20G0=1\n2002=x\n2000=$NODEID\n",
    );
    insta::assert_snapshot!(findings.join("\n"));
    assert!(model.entries().all(|(_, entry)| entry.configured.is_none()));
}

#[test]
fn the_last_of_two_values_counts() {
    let (model, findings) = configured("2001=1\n2001:0=2\n");
    assert_eq!(
        findings,
        ["values:2:1: warning[value-twice]: 2001h:0 has a value on line 1 already"]
    );
    assert_eq!(
        model.entry(0x2001, 0).unwrap().configured,
        Some(DefaultValue::number(2))
    );
}

#[test]
fn a_printed_configuration() {
    let (model, _) = configured("2001=-3\n1400:1=$NODEID+0x300\n");
    let printed = print(&model);
    let head = printed.split("[DummyUsage]").next().unwrap();
    let values: Vec<&str> = printed
        .lines()
        .filter(|line| line.starts_with("ParameterValue"))
        .collect();
    insta::assert_snapshot!(format!("{head}{}", values.join("\n")));
}

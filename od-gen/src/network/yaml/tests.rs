//! Descriptions in YAML.

use proptest::prelude::*;

use crate::network::NetworkReport;
use crate::network::tests::{MACHINE, lines, network, sheet};

const YAML: &str = include_str!("../../../tests/data/network/machine.yaml");

fn yaml(text: &str) -> NetworkReport {
    NetworkReport::new("net.yaml", text, sheet)
}

#[test]
fn the_same_network_in_yaml_makes_the_same_files() {
    let (toml, yaml) = (network(MACHINE), yaml(YAML));
    assert_eq!(lines(&yaml), [""; 0]);
    assert_eq!(toml.files.len(), 7);
    for (own, other) in toml.files.iter().zip(&yaml.files) {
        assert_eq!(own, other, "{}", own.name);
    }
    assert_eq!(toml.files.len(), yaml.files.len());
    assert_eq!(toml.load, yaml.load);
}

#[test]
fn every_mistake_in_yaml_is_told_with_its_line() {
    let many: String = (0..20)
        .map(|row| {
            let last = if row == 0 {
                "0".into()
            } else {
                format!("*a{}", row - 1)
            };
            format!("a{row}: &a{row} [{last}, {last}]\n")
        })
        .collect();
    let deep = format!("node: {}", "[".repeat(100));
    let mut said = String::new();
    for (old, new) in [
        ("bit_rate: 500", "bit_rate: fast"),
        ("bit_rate: 500", "bit_rate: '500'"),
        ("bit_rate: 500", "bit_rate:"),
        ("bit_rate: 500", "bit_rate: 500.5"),
        ("bit_rate: 500", "bit_rate: 300"),
        ("bit_rate: 500", "bit_rate: !!int 500"),
        ("bit_rate: 500", "bit_rate: 70000"),
        ("bit_rate: 500", "\tbit_rate: 500"),
        ("bit_rate: 500", "bit_rate: 500\n  bit_rate: 500"),
        ("bit_rate: 500", "bitrate: 500"),
        ("name: machine", "name: [machine"),
        ("period: 4000", "period: *off"),
        ("period: 4000", "period: &own [*own]"),
        ("period: 4000", "? {period: 1}\n  : 4000"),
        ("statusword", "statuswort"),
        ("{event_timer: 500}", "{event_time: 500}"),
        ("node_id: 10", "node_id: 2"),
        ("number: 12345", "number: 12_345"),
        ("master:", "---\nmaster:"),
        (YAML, "- network"),
        (YAML, "network"),
        (YAML, ""),
        (YAML, &many),
        (YAML, &deep),
    ] {
        assert!(YAML.contains(old), "{old}");
        let report = yaml(&YAML.replacen(old, new, 1));
        let shown: String = new.chars().take(40).collect();
        said += &format!("{shown:?}\n{}\n\n", lines(&report).join("\n"));
    }
    insta::assert_snapshot!(said);
}

#[test]
fn numbers_are_those_of_the_core_schema() {
    for (period, expected) in [
        ("4000", true),
        ("004000", true),
        ("0xFA0", true),
        ("0o7640", true),
        ("+4000", true),
        ("4e3", false),
        ("\"4000\"", false),
    ] {
        let report = yaml(&YAML.replace("period: 4000", &format!("period: {period}")));
        assert_eq!(!report.has_errors(), expected, "{period}");
    }
    let report = yaml(&YAML.replace(
        "bit_rate: 500",
        "heartbeat_multiplier: 2.5\n  bit_rate: 500",
    ));
    assert_eq!(lines(&report), [""; 0]);
}

#[test]
fn a_comment_in_yaml_silences() {
    // What is switched on by the data sheet alone, nobody sends.
    let text = YAML.replace(
        "      3: *off\n    tpdo:\n      1: {transmission: 255",
        "    tpdo:\n      1: {transmission: 255",
    );
    assert_ne!(text, YAML);
    assert!(
        lines(&yaml(&text))
            .join("")
            .contains("rpdo-without-producer")
    );
    let silent = format!("# od-gen: allow rpdo-without-producer because a PLC sends it\n\n{text}");
    let silent = yaml(&silent);
    assert_eq!((silent.findings.len(), silent.silenced.len()), (0, 1));
}

proptest! {
    /// Whatever stands there: a finding or files, no panic, and no end of memory.
    #[test]
    fn any_text_is_read(text in "[a-z0-9:&*\\-\\[\\]{},'\"#! \n\t?|>%~<.µ]{0,200}") {
        let report = yaml(&text);
        prop_assert!(report.has_errors());
    }

    #[test]
    fn any_piece_of_a_description_is_read(start in 0..YAML.len(), length in 0_usize..60) {
        let Some(text) = YAML.get(..start).zip(YAML.get((start + length).min(YAML.len())..)) else {
            return Ok(());
        };
        let report = yaml(&format!("{}{}", text.0, text.1));
        prop_assert_eq!(report.has_errors(), report.files.is_empty());
    }
}

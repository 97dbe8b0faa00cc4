//! Modular devices.

use crate::data_type::DataType;
use crate::model::{Access, DynamicChannel, Model};
use crate::report::{Report, parse};

const COUPLER: &str = include_str!("../../../tests/data/coupler.eds");

fn coupler() -> Model {
    let report = Report::new(
        "coupler.eds",
        COUPLER.replace("; od-gen", ";od-gen").as_str(),
    );
    report.model
}

#[test]
fn modules_say_what_they_add() {
    let model = coupler();
    assert_eq!(model.connected, [2, 1, 2]);
    let [output, input] = model.modules.as_slice() else {
        panic!("{:?}", model.modules);
    };
    assert_eq!((output.number, output.order_code.as_str()), (1, "AO2"));
    assert_eq!(output.comments, ["Two channels"]);
    assert_eq!(output.fixed[0].index, 0x6444);
    assert_eq!(
        output.fixed[0].entry(1).unwrap().data_type,
        DataType::Integer32
    );
    assert_eq!((input.product_version, input.product_revision), (1, 2));
    assert_eq!(input.fixed[0].entries[0].data_type, DataType::Boolean);
    let inputs = &input.extensions[0];
    assert_eq!(
        (inputs.index, inputs.count, inputs.continues),
        (0x6000, 1, true)
    );
    assert!(inputs.entry.is_tpdo_mappable());
    assert!(model.object(0x6005).is_none(), "only with a module");
}

#[test]
fn variables_have_ranges_of_indices() {
    assert_eq!(
        coupler().dynamic_channels[1],
        DynamicChannel {
            data_type: 5,
            access: Some(Access::ReadWriteOutput),
            first: 0xA400,
            last: 0xA43F,
            offset: 64,
            difference: None,
        }
    );
}

#[test]
fn mistakes_in_modules_are_found() {
    for (old, new, rule) in [
        ("3=2\n", "3=5\n", "no-module"),
        (
            "[SupportedModules]\nNrOfEntries=2",
            "[SupportedModules]\nNrOfEntries=3",
            "list-count",
        ),
        ("1=0x6005", "1=0x6006", "listed-without-section"),
        ("[M2Fixed6005]", "[M2Fixe6005]", "unknown-section"),
        ("Count=1", "Count=x", "not-a-number"),
        ("OrderCode=AO2", "Ordercode2=AO2", "unknown-key"),
        ("SubNumber=2\n\n[M1", "SubNumber=3\n\n[M1", "sub-number"),
        ("[1017]\n", "[1017]\nCount=1\n", "unknown-key"),
    ] {
        assert_eq!(COUPLER.matches(old).count(), 1, "{old}");
        let report = Report::new("coupler.eds", &COUPLER.replace(old, new));
        let has = report
            .findings
            .iter()
            .any(|finding| finding.rule.name == rule);
        assert!(has, "{new}: {:?}", report.findings);
    }
}

#[test]
fn a_modular_device_without_dynamic_channels_is_no_mistake() {
    let text = COUPLER.replace("DynamicChannelsSupported=1", "DynamicChannelsSupported=0");
    assert!(parse("coupler.eds", &text).is_ok());
}

#[test]
fn what_a_module_adds_is_held_to_the_rules_about_models() {
    let found = |text: &str| {
        let report = Report::new("coupler.eds", text);
        let found = report.findings.iter();
        found
            .map(|finding| (finding.rule.name, finding.span.line))
            .collect::<Vec<_>>()
    };
    let of_mappings = |found: &[(&str, u32)]| {
        let mut found = found.iter();
        found.any(|(rule, _)| *rule == "mapping-without-pdo")
    };
    assert!(!of_mappings(&found(COUPLER)));
    let mapping = COUPLER.replace("6444", "1A05");
    let line = mapping
        .find("[M1Fixed1A05]")
        .map(|at| mapping[..at].lines().count() + 1);
    let line = u32::try_from(line.unwrap()).unwrap();
    let said = found(&mapping);
    assert!(said.contains(&("mapping-without-pdo", line)), "{said:?}");
    // Two modules that have the same object are both looked at.
    let both = mapping.replace("6005", "1A05");
    let lines: Vec<usize> = ["[M1Fixed1A05]", "[M2Fixed1A05]"]
        .map(|name| both[..both.find(name).unwrap()].lines().count() + 1)
        .into();
    let said = found(&both);
    for line in lines {
        let line = u32::try_from(line).unwrap();
        assert!(said.contains(&("mapping-without-pdo", line)), "{said:?}");
    }
}

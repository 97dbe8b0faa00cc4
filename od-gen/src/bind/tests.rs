//! Bindings of a foreign drive, right and wrong.

use super::*;
use crate::model::Model;
use crate::report::parse;

fn model() -> Model {
    parse("foreign.eds", include_str!("../../tests/data/foreign.eds")).unwrap()
}

fn report(text: &str) -> BindingReport {
    BindingReport::new("foreign.bind.toml", text, &model())
}

/// What is said about one table.
fn said(table: &str) -> Vec<String> {
    let text = format!("[storage]\nobjects = [\"2000h-5FFFh\"]\n[[binding]]\n{table}\n");
    let findings = report(&text).findings;
    findings.iter().map(ToString::to_string).collect()
}

#[test]
fn bindings_are_read_with_scale_values_and_access() {
    let report = report(include_str!("../../tests/data/foreign.bind.toml"));
    assert!(
        report.findings.is_empty(),
        "{}",
        report.render(Colour::Never)
    );
    let of = |index: u16| {
        let found = report
            .bindings
            .rows
            .iter()
            .find(|binding| binding.index == index);
        found.unwrap()
    };
    assert_eq!(of(0x2003).meaning.to_parameter(10), Some(16));
    assert_eq!(of(0x2005).meaning.to_parameter(10), Some(-990));
    assert_eq!(of(0x2000).meaning.to_parameter(7), Some(1));
    assert_eq!(of(0x2000).meaning.to_parameter(1), None);
    assert_eq!((of(0x2003).is_taken, of(0x2003).is_shown), (true, true));
    assert_eq!((of(0x2004).is_taken, of(0x2004).is_shown), (false, true));
    assert_eq!(
        (of(0x2002).is_taken, of(0x2002).is_shown),
        (false, false),
        "const"
    );
    assert_eq!(report.unbound, [0x2010, 0x2011]);
}

#[test]
fn the_axis_of_the_virtual_drive_is_read_and_nothing_else_beside_it() {
    let axis = |text| report(text).bindings.axis;
    assert_eq!(
        axis("[virtual]\naxis = \"nema23\"\n").as_deref(),
        Some("nema23")
    );
    assert_eq!(axis(""), None);
    assert!(report("[virtual]\nmotor = \"nema23\"\n").has_errors());
}

#[test]
fn a_parameter_begins_with_its_constant_the_object_that_is_bound_or_its_own_one() {
    let initial = |text: &str, name| report(text).bindings.initial(&model(), name);
    let bound = "[[binding]]\nobject = \"2006h\"\nparameter = \"profile_velocity\"\noffset = 7\n";
    assert_eq!(initial(bound, "profile_velocity"), Some(507));
    let constant = "[constants]\nmicrosteps = 256\n";
    assert_eq!(initial(constant, "microsteps"), Some(256));
    assert_eq!(initial(constant, "profile_velocity"), None);
    let own = model().entry(0x6083, 0).unwrap().default_number();
    assert_eq!(initial("", "profile_acceleration").map(i128::from), own);
    assert_eq!(initial("", "no_parameter"), None);
}

#[test]
fn objects_that_stand_for_nothing_are_reported_unless_that_is_meant() {
    let unmentioned = report("");
    assert!(!unmentioned.has_errors());
    let [finding] = unmentioned.findings.as_slice() else {
        panic!("{:?}", unmentioned.findings)
    };
    assert_eq!(finding.rule.name, "unbound-object");
    assert!(
        finding.message.starts_with("12 objects"),
        "{}",
        finding.message
    );
    assert!(
        report("[storage]\nobjects = [\"2000h-5FFFh\"]\n")
            .findings
            .is_empty()
    );
}

#[test]
fn every_mistake_is_shown_with_its_line() {
    for (table, expected) in [
        (
            "object = \"speed\"\nparameter = \"profile_velocity\"",
            "4:10: error[binding-object]: `speed` is not an object",
        ),
        (
            "object = \"2FFFh\"\nparameter = \"profile_velocity\"",
            "4:10: error[binding-object]: 2FFFh is not in the data sheet",
        ),
        (
            "object = \"1018h:1\"\nparameter = \"profile_velocity\"",
            "4:10: error[binding-object]: 1018h belongs to the communication",
        ),
        (
            "object = \"2010h\"\nparameter = \"profile_velocity\"",
            "4:10: error[binding-object-type]: 2010h is a VISIBLE_STRING",
        ),
        (
            "object = \"2006h\"\nparameter = \"profile_velocty\"",
            "5:13: error[binding-parameter]: the drive has no parameter `profile_velocty`",
        ),
        (
            "object = \"6083h\"\nparameter = \"profile_velocity\"",
            "4:10: error[bound-twice]: 6083h is profile_acceleration in CiA 402",
        ),
        (
            "object = \"2006h\"\nparameter = \"statusword\"",
            "4:10: error[binding-access]: 2006h is rw, and the drive only shows statusword",
        ),
        (
            "object = \"2006h\"\nparameter = \"profile_velocity\"\naccess = \"ro\"",
            "6:10: error[binding-access]: 2006h is rw: what masters write would be lost",
        ),
        (
            "object = \"2004h\"\nparameter = \"target_position\"\naccess = \"rw\"",
            "6:10: error[binding-access]: 2004h is ro in the data sheet",
        ),
        (
            "object = \"2006h\"\nparameter = \"profile_velocity\"\nscale = 0.1",
            "6:9: error[binding-scale]: this is not a scale",
        ),
        (
            "object = \"2006h\"\nparameter = \"profile_velocity\"\nscale = \"1/0\"",
            "6:9: error[binding-scale]: this is not a scale",
        ),
        (
            "object = \"2006h\"\nparameter = \"profile_velocity\"\nscale = 2\nvalues = { 500 = 1 }",
            "7:10: error[binding-scale]: a list of values has no scale and no offset",
        ),
        (
            "object = \"2006h\"\nparameter = \"profile_velocity\"\nvalues = { 1 = 1 }",
            "4:10: error[binding-range]: the default 500 of 2006h is not among the values",
        ),
        (
            "object = \"2000h\"\nparameter = \"modes_of_operation\"\nvalues = { 0 = 1, 1 = 1 }",
            "6:10: error[binding-values]: 0 and 1 both mean 1: which one is shown?",
        ),
        (
            "object = \"2000h\"\nparameter = \"modes_of_operation\"\nvalues = { 0 = 1, 256 = 2 }",
            "6:10: error[binding-values]: 256 does not fit UNSIGNED8",
        ),
        (
            "object = \"2000h\"\nparameter = \"profile_acceleration\"\naccess = \"wo\"",
            "4:10: error[binding-range]: the default 0 of 2000h is 0 for profile_acceleration, which is 1 to 4294967295",
        ),
        (
            "object = \"2000h\"\nparameter = \"modes_of_operation\"\nunit = \"m\"",
            "6:1: error[binding-syntax]: unknown field `unit`, expected one of `object`, `parameter`, `scale`, `offset`, `access`, `values`",
        ),
    ] {
        assert_eq!(
            said(table),
            [format!("foreign.bind.toml:{expected}")],
            "{table}"
        );
    }
    let twice = "object = \"2006h\"\nparameter = \"profile_velocity\"\n";
    let twice = said(&format!("{twice}[[binding]]\n{twice}"));
    assert_eq!(
        twice,
        ["foreign.bind.toml:7:10: error[bound-twice]: 2006h is bound already"]
    );
}

#[test]
fn a_name_that_is_nearly_right_is_offered() {
    let text = "[[binding]]\nobject = \"2006h\"\nparameter = \"profile_velocty\"\n";
    let findings = report(text).findings;
    let help = findings
        .iter()
        .find_map(|finding| finding.help.clone().filter(|help| help.contains("mean")));
    assert_eq!(help.as_deref(), Some("did you mean `profile_velocity`?"));
}

#[test]
fn the_default_of_an_object_that_follows_is_never_seen() {
    assert!(model().entry(0x6083, 0).is_some());
    let bound = "object = \"2000h\"\nparameter = \"profile_acceleration\"";
    assert_eq!(said(bound), Vec::<String>::new());
}

#[test]
fn a_mask_is_one_of_inputs_or_of_outputs() {
    let of = |what: &str| report(&format!("[[mask]]\nobject = \"2000h\"\n{what}\n"));
    let taken = of("inputs = 3");
    assert!(!taken.has_errors(), "{:?}", taken.findings);
    let [mask] = taken.bindings.masks.as_slice() else {
        panic!("{:?}", taken.bindings.masks)
    };
    assert_eq!(
        (mask.index, mask.function, mask.is_of_outputs),
        (0x2000, 3, false)
    );
    assert!(of("inputs = 3\noutputs = 4").has_errors());
    assert!(of("").has_errors());
}

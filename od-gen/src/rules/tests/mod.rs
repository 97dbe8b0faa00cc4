//! Each rule about a model: a device that breaks it, and the nearest one that does not.

use std::collections::{BTreeSet, HashSet};

use super::*;
use crate::diagnostic::Colour;
use crate::report::Report;

mod communication;
mod device;
mod drive;
mod pdo;
mod silencing;

/// A rule with differences that break it, and others that do not.
struct Case {
    rule: &'static str,
    bad: &'static [&'static str],
    good: &'static [&'static str],
}

const fn case(
    rule: &'static str,
    bad: &'static [&'static str],
    good: &'static [&'static str],
) -> Case {
    Case { rule, bad, good }
}

fn cases() -> impl Iterator<Item = &'static Case> {
    communication::CASES
        .iter()
        .chain(pdo::CASES)
        .chain(drive::CASES)
}

fn report(differences: &[&str]) -> Report {
    Report::new("test.eds", &device::data_sheet(differences))
}

#[test]
fn a_device_without_a_flaw_is_found_to_be_one() {
    for differences in [&[][..], &["drive"]] {
        let report = report(differences);
        assert!(
            report.findings.is_empty(),
            "{}",
            report.render(Colour::Never)
        );
    }
}

#[test]
fn each_rule_finds_what_breaks_it_and_nothing_else() {
    for case in cases() {
        let report = report(case.bad);
        assert!(
            !report.findings.is_empty(),
            "{} finds nothing in {:?}",
            case.rule,
            case.bad
        );
        for finding in &report.findings {
            assert_eq!(
                finding.rule.name,
                case.rule,
                "{:?}\n{}",
                case.bad,
                report.render(Colour::Never)
            );
        }
    }
}

#[test]
fn each_rule_leaves_the_nearest_right_device_alone() {
    for case in cases() {
        let report = report(case.good);
        assert!(
            report.findings.is_empty(),
            "{} {:?}\n{}",
            case.rule,
            case.good,
            report.render(Colour::Never)
        );
    }
}

#[test]
fn each_rule_about_models_has_a_case() {
    let tested: HashSet<&str> = cases().map(|case| case.rule).collect();
    for rule in OF_MODELS.iter().flat_map(|chapter| chapter.rules) {
        assert!(tested.contains(rule.name), "{}", rule.name);
    }
}

#[test]
fn what_is_said() {
    let mut said = String::new();
    for case in cases() {
        said += &report(case.bad).render(Colour::Never);
        said += "\n";
    }
    insta::assert_snapshot!(said);
}

#[test]
fn a_rule_that_compares_two_places_shows_both() {
    let found = cases().flat_map(|case| report(case.bad).findings);
    let shown: BTreeSet<&str> = found
        .filter(|finding| finding.other.is_some())
        .map(|finding| finding.rule.name)
        .collect();
    let expected = [
        "axis-device-type",
        "cob-id-used-twice",
        "cob-id-used-twice-with-a-node-id",
        "crossed-limits",
        "default-mode",
        "guarding-beside-heartbeat",
        "heartbeat-consumed-twice",
        "homing-method",
        "identity-mismatch",
        "mapped-direction",
        "mapped-length",
        "mapped-object-unmappable",
        "mapped-twice",
        "mapping-gap",
        "mapping-granularity",
        "mode-not-claimed",
        "nmt-startup",
        "objects-without-profile",
        "pdo-without-objects",
        "sync-producer-without-period",
        "sync-start-without-counter",
        "sync-window",
        "velocity-above-maximum",
    ];
    assert_eq!(shown, expected.into());
}

#[test]
fn each_rule_has_a_name_of_its_own_and_explains_itself() {
    let mut names = HashSet::new();
    for rule in all() {
        assert!(names.insert(rule.name), "{} is there twice", rule.name);
        assert!(
            rule.name.bytes().all(|letter| letter.is_ascii_lowercase()
                || letter.is_ascii_digit()
                || letter == b'-'),
            "{}",
            rule.name
        );
        assert!(rule.summary.ends_with('.'), "{}", rule.name);
        assert!(rule.explanation.ends_with('.'), "{}", rule.name);
    }
}

//! A mistake that may be in either of two places shows both.

use super::*;

/// The line that a finding is about, and the other one with what is said of it.
fn places(text: &str, rule: &str) -> (String, String, String) {
    let report = Report::new("small.eds", text);
    let mut findings = report.findings.iter();
    let finding = findings.find(|finding| finding.rule.name == rule);
    let finding = finding.unwrap_or_else(|| panic!("{rule}: {}", said(&report)));
    let line = |number| report.source.line(number).unwrap().to_owned();
    let (other, what) = finding.other.clone().unwrap_or_else(|| panic!("{rule}"));
    (line(finding.span.line), line(other.line), what)
}

#[test]
fn a_mistake_between_two_places_shows_both() {
    for (old, new, rule, place, other, what) in [
        (
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=5\nHighLimit=4\nDefaultValue=5",
            "low-above-high",
            "LowLimit=5",
            "HighLimit=4",
            "the upper limit",
        ),
        (
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=-6",
            "default-outside-limits",
            "DefaultValue=-6",
            "LowLimit=-5",
            "the limit",
        ),
        (
            "LowLimit=-5\nDefaultValue=-1",
            "HighLimit=-5\nDefaultValue=-1",
            "default-outside-limits",
            "DefaultValue=-1",
            "HighLimit=-5",
            "the limit",
        ),
        (
            "12=0x200B",
            "12=0x200A",
            "listed-twice",
            "12=0x200A",
            "11=0x200A",
            "the first one",
        ),
        (
            "DefaultValue=0x2\n\n[200asub1]",
            "DefaultValue=7\n\n[200asub1]",
            "sub-0-value",
            "DefaultValue=7",
            "[200AsUB2]",
            "the highest sub-index",
        ),
        (
            "[200AsUB2]\nParameterName=Element\nDataType=0x0004",
            "[200AsUB2]\nParameterName=Element\nDataType=0x0007",
            "array-of-many-types",
            "DataType=0x0007",
            "DataType=0x0004",
            "the type of the first",
        ),
        (
            "NrOfRXPDO=1",
            "NrOfRXPDO=2",
            "pdo-count",
            "NrOfRXPDO=2",
            "[1400]",
            "the first of them",
        ),
        (
            "NrOfTXPDO=1",
            "NrOfTXPDO=0",
            "pdo-count",
            "NrOfTXPDO=0",
            "[1800]",
            "the first of them",
        ),
        (
            "HighLimit=200\nPDOMapping=1",
            "HighLimit=200\nHighLimit=100\nPDOMapping=1",
            "contradicting-key",
            "HighLimit=100",
            "HighLimit=200",
            "this one counts",
        ),
        (
            "HighLimit=200\nPDOMapping=1",
            "HighLimit=200\nHighLimit=200\nPDOMapping=1",
            "repeated-key",
            "HighLimit=200",
            "HighLimit=200",
            "this one counts",
        ),
        (
            "[200B]",
            "[200a]\nParameterName=Again\n\n[200B]",
            "repeated-section",
            "[200a]",
            "[200A]",
            "the first one",
        ),
    ] {
        assert_eq!(SMALL.matches(old).count(), 1, "{old}");
        let found = places(&SMALL.replacen(old, new, 1), rule);
        let expected = (place.to_owned(), other.to_owned(), what.to_owned());
        assert_eq!(found, expected, "{rule}");
    }
}

#[test]
fn the_type_of_an_array_is_that_of_its_first_element() {
    let (old, new) = (
        "[200asub1]\nParameterName=Element\nDataType=0x0004",
        "[200asub1]\nParameterName=Element\nDataType=0x0003",
    );
    let text = SMALL.replacen(old, new, 1);
    let report = Report::new("small.eds", &text);
    let mut findings = report.findings.iter();
    let finding = findings
        .find(|finding| finding.rule.name == "array-of-many-types")
        .unwrap();
    let first = text.lines().position(|line| line == "[200asub1]").unwrap();
    let (other, _) = finding.other.as_ref().unwrap();
    assert_eq!(usize::try_from(other.line).unwrap(), first + 3);
}

//! Every rule is silenced once, by name and with a reason, and a dictionary can be generated then.

mod breaches;

use std::collections::HashMap;

use breaches::{BINDINGS, CHANGES, VALUES};

use super::{OF_DESCRIPTIONS, OF_FILES, OF_MODELS, OF_OTHER_FILES, Rule, all, cases, device};
use crate::bind::BindingReport;
use crate::dcf::{self, Values};
use crate::diagnostic::Colour;
use crate::generate::{Options, generate};
use crate::model::Model;
use crate::print::print;
use crate::report::{Report, parse};

const SMALL: &str = include_str!("../../../tests/data/small.eds");
const FOREIGN: &str = include_str!("../../../tests/data/foreign.eds");

/// Those that cannot be silenced: there is no comment to be read.
const REFUSED: [&str; 2] = ["not-text", "not-xml"];

fn changed(changes: &[(&str, &str)]) -> String {
    let mut text = SMALL.to_owned();
    for (old, new) in changes {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text = text.replace(old, new);
    }
    text.replace("LONG", &"x".repeat(65_536))
        .replace("BYTES", &"AB".repeat(65_500))
}

fn allowance(rule: &str) -> String {
    format!(";od-gen: allow {rule} because a test asks for it\n")
}

/// The report of a text whose letters above 7Fh are bytes of Latin-1 where that is what breaks the rule.
fn report(rule: &str, text: &str) -> Report {
    if rule == "not-utf-8" {
        let bytes: Vec<u8> = text
            .chars()
            .map(|letter| u8::try_from(letter).unwrap())
            .collect();
        Report::of_bytes("test.eds", &bytes)
    } else {
        Report::new("test.eds", text)
    }
}

/// Silences a rule above the first section: nothing else is left to be said, and a dictionary comes out.
fn silence(rule: &str, text: &str, is_dcf: bool) {
    let broken = report(rule, text);
    let is_found = |report: &Report| report.findings.iter().any(|found| found.rule.name == rule);
    assert!(
        is_found(&broken),
        "{rule}: {}",
        broken.render(Colour::Never)
    );
    let silent = report(rule, &(allowance(rule) + text));
    assert!(
        silent.findings.is_empty(),
        "{rule}\n{}",
        silent.render(Colour::Never)
    );
    let mut silenced = silent.silenced.iter();
    let is_known =
        silenced.any(|(found, reason)| found.rule.name == rule && reason == "a test asks for it");
    assert!(is_known, "{rule}");
    is_generated(rule, &silent.model);
    // What is printed says the same, and nothing of it is superfluous.
    let printed = print(&silent.model);
    let name = if is_dcf { "test.dcf" } else { "test.eds" };
    let again = Report::new(name, &printed);
    assert!(
        again.findings.is_empty(),
        "{rule}\n{}\n{printed}",
        again.render(Colour::Never)
    );
}

/// What is generated is whole: every bracket that is opened is closed.
fn is_generated(rule: &str, model: &Model) {
    let text = generate(model, Options::DEVICE);
    let code = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let code: String = code.collect();
    for (open, closed) in [('(', ')'), ('[', ']'), ('{', '}')] {
        let (opened, closed) = (code.matches(open).count(), code.matches(closed).count());
        assert!(opened == closed && opened > 0, "{rule}");
    }
}

#[test]
fn rules_that_are_checked_while_a_data_sheet_is_read() {
    for (rule, changes) in CHANGES {
        silence(rule, &changed(changes), false);
    }
    let missing = device::data_sheet(&["-1018", "@LSS_Supported=0"]);
    silence("missing-mandatory-object", &missing, false);
    // What is printed has the section, and it is empty.
    let text = allowance("missing-section, lss-without-identity")
        + &SMALL.replace("; od-gen: allow", "; od-gen; allow");
    let start = text.find("[DeviceInfo]").unwrap();
    let end = text.find("[DummyUsage]").unwrap();
    let report = Report::new("test.eds", &format!("{}{}", &text[..start], &text[end..]));
    assert!(!report.has_errors(), "{}", report.render(Colour::Never));
    is_generated("missing-section", &report.model);
}

#[test]
fn what_was_plainly_meant_counts_when_it_is_silenced() {
    for (old, new) in [
        ("ProductNumber=18", "ProductNumber=018"),
        ("BaudRate_125=1", "BaudRate_125=TRUE"),
        (
            "DataType=0x0005\nAccessType=ro\nPDOMapping=1",
            "DataType=UNSIGNED8\nAccessType=ro\nPDOMapping=yes",
        ),
        ("DefaultValue=$NODEID+0x200", "DefaultValue=nodeid+0x200"),
        ("LowLimit=0x8000", "LowLimit=8000h"),
        ("DefaultValue=0x10002", "DefaultValue=10002h"),
        ("HighLimit=200\n\n", "HighLimit=200u\n\n"),
        ("12=0x200B", "12=200Bh"),
    ] {
        let text = changed(&[(old, new)]);
        assert!(Report::new("small.eds", &text).has_errors(), "{new}");
        let report = Report::new(
            "small.eds",
            &(allowance("not-a-number, not-an-index") + &text),
        );
        let left = report
            .findings
            .iter()
            .filter(|found| found.rule.name != "unused-allowance");
        // The count of a list is of what can be read as it stands.
        assert_eq!(
            left.filter(|found| found.rule.name != "list-count").count(),
            0,
            "{new}"
        );
        assert_eq!(report.model, parse("small.eds", SMALL).unwrap(), "{new}");
    }
}

#[test]
fn rules_about_models() {
    for case in cases() {
        let is_dcf = case
            .bad
            .iter()
            .any(|difference| difference.starts_with("node"));
        silence(case.rule, &device::data_sheet(case.bad), is_dcf);
    }
}

#[test]
fn rules_about_bindings_are_silenced_in_their_file_and_in_the_data_sheet() {
    let said = |eds: &str, text: &str| {
        let model = parse("foreign.eds", eds).unwrap();
        BindingReport::new("foreign.bind.toml", text, &model)
    };
    for (rule, text) in BINDINGS {
        let storage = "[storage]\nobjects = [\"2000h-5FFFh\"]\n";
        let is_whole = text.is_empty() || text.contains("[storage]") || *rule == "binding-syntax";
        let text = if is_whole {
            (*text).to_owned()
        } else {
            format!("{storage}{text}")
        };
        let found = said(FOREIGN, &text).findings;
        assert!(
            found.iter().any(|found| found.rule.name == *rule),
            "{rule}: {found:?}"
        );
        let own = allowance(rule).replace(';', "# ");
        let whole = format!("{own}\n{text}");
        let mut reports = vec![
            said(FOREIGN, &whole),
            said(&(allowance(rule) + FOREIGN), &text),
        ];
        if text.contains("[[binding]]") {
            // Above a table, and in it.
            reports.push(said(
                FOREIGN,
                &text.replace("[[binding]]", &format!("{own}[[binding]]")),
            ));
            reports.push(said(FOREIGN, &format!("{text}{own}")));
        }
        for report in reports {
            let left = report
                .findings
                .iter()
                .filter(|found| found.rule.name != "unbound-object");
            assert_eq!(left.count(), 0, "{rule}\n{}", report.render(Colour::Never));
            assert_eq!(
                report.silenced.first().map(|(found, _)| found.rule.name),
                Some(*rule)
            );
        }
    }
    let elsewhere = "# od-gen: allow binding-object because of a test\n[storage]\nobjects = [\"2000h-5FFFh\"]\n\n";
    let found = said(
        FOREIGN,
        &format!("{elsewhere}[[binding]]\nobject = \"x\"\nparameter = \"statusword\"\n"),
    );
    let names: Vec<_> = found.findings.iter().map(|found| found.rule.name).collect();
    assert_eq!(names, ["unused-allowance", "binding-object"]);
}

#[test]
fn rules_about_the_values_of_a_configuration() {
    for (rule, line) in VALUES {
        let apply = |eds: &str, values: &str| {
            let mut model = parse("small.eds", eds).unwrap();
            dcf::apply(&mut model, &Values::new("small.values", values))
        };
        let found = apply(SMALL, line);
        assert!(
            found.iter().all(|found| found.rule.name == *rule),
            "{found:?}"
        );
        assert_eq!(found.len(), 1, "{rule}");
        let own = format!("{line}{}", allowance(rule));
        assert_eq!(apply(SMALL, &own), [], "{rule}");
        assert_eq!(apply(&(allowance(rule) + SMALL), line), [], "{rule}");
    }
}

#[test]
fn no_rule_is_left_out() {
    let mut tested: HashMap<&str, usize> = HashMap::new();
    let changes = CHANGES.iter().map(|(rule, _)| *rule);
    let others = BINDINGS.iter().chain(VALUES).map(|(rule, _)| *rule);
    let models = cases().map(|case| case.rule);
    for rule in changes
        .chain(others)
        .chain(models)
        .chain(["missing-mandatory-object", "missing-section"])
    {
        *tested.entry(rule).or_default() += 1;
    }
    // Errors of a recipe or of a network leave nothing to be made.
    let of_networks = |rule: &&Rule| {
        let mut chapters = OF_DESCRIPTIONS.iter();
        chapters.any(|chapter| chapter.rules.contains(rule))
    };
    for rule in all().filter(|rule| !of_networks(rule)) {
        let is_refused = REFUSED.contains(&rule.name);
        assert_eq!(rule.can_be_allowed, !is_refused, "{}", rule.name);
        assert_eq!(tested.contains_key(rule.name), !is_refused, "{}", rule.name);
        assert_eq!(
            rule.explanation.contains("cannot be silenced, as"),
            is_refused,
            "{}",
            rule.name
        );
    }
    assert!(OF_FILES.len() + OF_OTHER_FILES.len() + OF_MODELS.len() > 15);
}

//! Every rule is silenced once, by name and with a reason, and a dictionary can be generated then.

use std::collections::HashMap;

use super::{OF_FILES, OF_MODELS, OF_OTHER_FILES, all, cases, device};
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

/// A rule, and what becomes what in a data sheet that keeps it.
type Change = (&'static str, &'static [(&'static str, &'static str)]);

/// The rules that are checked while a data sheet is read.
const CHANGES: &[Change] = &[
    ("not-utf-8", &[("VendorName=Nobody", "VendorName=Nöbody")]),
    (
        "control-character",
        &[("VendorName=Nobody", "VendorName=No\u{1}body")],
    ),
    (
        "stray-line",
        &[("Granularity=8", "Granularity=8\nnonsense")],
    ),
    ("unclosed-section", &[("[DummyUsage]", "[DummyUsage] x")]),
    ("key-before-section", &[("[FileInfo]", "a=1\n[FileInfo]")]),
    (
        "trailing-comment",
        &[("Granularity=8", "Granularity=8 ; why")],
    ),
    (
        "repeated-section",
        &[("[2000]", "[FileInfo]\nFileName=other.eds\n\n[2000]")],
    ),
    (
        "repeated-key",
        &[("FileVersion=1", "FileVersion=1\nFileVersion=1")],
    ),
    (
        "contradicting-key",
        &[("FileVersion=1", "FileVersion=1\nFileVersion=2")],
    ),
    ("unknown-section", &[("[2000]", "[Maker]\na=1\n\n[2000]")]),
    (
        "unknown-key",
        &[("FileVersion=1", "FileVersion=1\nColour=blue")],
    ),
    (
        "key-of-a-dcf",
        &[("ParameterName=Type", "ParameterName=Type\nParameterValue=1")],
    ),
    (
        "allowance-without-reason",
        &[(
            "ParameterName=Type",
            ";od-gen: allow storage\nParameterName=Type",
        )],
    ),
    (
        "allowance-of-no-rule",
        &[(
            "ParameterName=Type",
            ";od-gen: allow it because so\nParameterName=Type",
        )],
    ),
    (
        "allowance-refused",
        &[(
            "ParameterName=Type",
            ";od-gen: allow not-xml because so\nParameterName=Type",
        )],
    ),
    (
        "unused-allowance",
        &[(
            "ParameterName=Type",
            ";od-gen: allow storage because so\nParameterName=Type",
        )],
    ),
    (
        "missing-section",
        &[(
            "[FileInfo]\nFileName=small.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n",
            "",
        )],
    ),
    ("list-numbering", &[("12=0x200B", "13=0x200B")]),
    (
        "list-count",
        &[("SupportedObjects=12", "SupportedObjects=11")],
    ),
    (
        "not-an-index",
        &[
            ("SupportedObjects=12", "SupportedObjects=13"),
            ("12=0x200B", "12=0x200B\n13=x"),
        ],
    ),
    (
        "listed-twice",
        &[
            ("SupportedObjects=12", "SupportedObjects=13"),
            ("12=0x200B", "12=0x200B\n13=0x200B"),
        ],
    ),
    (
        "wrong-list",
        &[
            ("SupportedObjects=6", "SupportedObjects=7"),
            ("6=0x1A00", "6=0x1A00\n7=0x200B"),
            ("SupportedObjects=12", "SupportedObjects=11"),
            ("\n12=0x200B", ""),
        ],
    ),
    (
        "listed-without-section",
        &[
            ("SupportedObjects=12", "SupportedObjects=13"),
            ("12=0x200B", "12=0x200B\n13=0x2010"),
        ],
    ),
    (
        "not-listed",
        &[
            ("SupportedObjects=12", "SupportedObjects=11"),
            ("\n12=0x200B", ""),
        ],
    ),
    ("object-type", &[("ObjectType=8", "ObjectType=ARRAY")]),
    (
        "type-definition",
        &[(
            "[200B]",
            "[0050]\nParameterName=Odd\nObjectType=7\nDataType=5\nAccessType=ro\n\n[200B]",
        )],
    ),
    (
        "sub-without-object",
        &[(
            "[200B]",
            "[2010sub1]\nParameterName=Odd\nDataType=5\nAccessType=ro\n\n[200B]",
        )],
    ),
    (
        "subs-of-a-variable",
        &[(
            "[200B]",
            "[2000sub1]\nParameterName=Odd\nDataType=5\nAccessType=ro\n\n[200B]",
        )],
    ),
    (
        "sub-number",
        &[("ObjectType=8\nSubNumber=3", "ObjectType=8\nSubNumber=4")],
    ),
    (
        "no-sub-number",
        &[("ObjectType=8\nSubNumber=3", "ObjectType=8")],
    ),
    (
        "no-sub-0",
        &[
            ("ObjectType=8\nSubNumber=3", "ObjectType=8\nSubNumber=2"),
            (
                "[200ASub0]\nParameterName=Highest sub-index supported\nDataType=0x0005\nAccessType=const\nDefaultValue=0x2\n",
                "",
            ),
        ],
    ),
    (
        "sub-0-type",
        &[(
            "0x0005\nAccessType=const\nDefaultValue=0x2\n",
            "0x0006\nAccessType=const\nDefaultValue=0x2\n",
        )],
    ),
    (
        "sub-0-value",
        &[("DefaultValue=0x2\n", "DefaultValue=0x3\n")],
    ),
    (
        "sub-ff",
        &[
            ("ObjectType=8\nSubNumber=3", "ObjectType=8\nSubNumber=4"),
            (
                "[200B]",
                "[200AsubFF]\nParameterName=Structure\nDataType=4\nAccessType=ro\n\n[200B]",
            ),
        ],
    ),
    (
        "sub-object-type",
        &[("[200AsUB2]\n", "[200AsUB2]\nObjectType=8\n")],
    ),
    (
        "array-of-many-types",
        &[(
            "[200AsUB2]\nParameterName=Element\nDataType=0x0004",
            "[200AsUB2]\nParameterName=Element\nDataType=3",
        )],
    ),
    (
        "compact-and-subs",
        &[(
            "ObjectType=8\nSubNumber=3",
            "ObjectType=8\nCompactSubObj=2\nDataType=4\nAccessType=rw",
        )],
    ),
    (
        "compact-list",
        &[("[200B]", "[200AName]\nNrOfEntries=0\n\n[200B]")],
    ),
    ("no-name", &[("ParameterName=Type\n", "")]),
    (
        "no-module",
        &[("[200B]", "[ConnectedModules]\nNrOfEntries=0\n1=5\n\n[200B]")],
    ),
    (
        "not-a-number",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=low\nDefaultValue=-1",
        )],
    ),
    (
        "not-a-number",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=none",
        )],
    ),
    (
        "not-a-number",
        &[(
            "ParameterName=Type\nDataType=0x0001",
            "ParameterName=Type\nDataType=BOOLEAN",
        )],
    ),
    (
        "not-a-number",
        &[(
            "ParameterName=Type\nDataType=0x0001",
            "ParameterName=Type\nDataType=some",
        )],
    ),
    (
        "not-a-number",
        &[(
            "Type\nDataType=0x0001\nAccessType=rw\nDefaultValue=1",
            "Type\nDataType=8\nAccessType=rw\nDefaultValue=1,5",
        )],
    ),
    (
        "not-a-number",
        &[(
            "ObjectType=8\nSubNumber=3",
            "ObjectType=8\nSubNumber=3\nObjFlags=no",
        )],
    ),
    ("out-of-range", &[("Granularity=8", "Granularity=99")]),
    (
        "no-data-type",
        &[(
            "ParameterName=Type\nDataType=0x0001\n",
            "ParameterName=Type\n",
        )],
    ),
    (
        "data-type",
        &[(
            "ParameterName=Type\nDataType=0x0001",
            "ParameterName=Type\nDataType=0x0020",
        )],
    ),
    (
        "data-type",
        &[(
            "[200AsUB2]\nParameterName=Element\nDataType=0x0004",
            "[200AsUB2]\nParameterName=Element\nDataType=0x40",
        )],
    ),
    (
        "data-type",
        &[(
            "[200B]\nParameterName=Flag\nDataType=0x0001",
            "[200B]\nParameterName=Flag\nObjectType=8\nCompactSubObj=2\nDataType=0x40",
        )],
    ),
    (
        "no-access",
        &[(
            "ParameterName=Type\nDataType=0x0001\nAccessType=rw\n",
            "ParameterName=Type\nDataType=0x0001\n",
        )],
    ),
    (
        "access-type",
        &[(
            "Type\nDataType=0x0001\nAccessType=rw",
            "Type\nDataType=0x0001\nAccessType=wr",
        )],
    ),
    (
        "mapping-of-variable-length",
        &[("ParameterName=Text", "ParameterName=Text\nPDOMapping=1")],
    ),
    (
        "default-type",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=256",
        )],
    ),
    (
        "limit-type",
        &[("HighLimit=200\nPDOMapping=1", "HighLimit=256\nPDOMapping=1")],
    ),
    (
        "limit-of-no-number",
        &[("ParameterName=Text", "ParameterName=Text\nLowLimit=1")],
    ),
    (
        "value-of-a-domain",
        &[(
            "Text\nDataType=0x0009\nAccessType=rw",
            "Text\nDataType=0x000F\nAccessType=rw\nDefaultValue=x",
        )],
    ),
    (
        "low-above-high",
        &[("LowLimit=-5\nHighLimit=200", "LowLimit=-5\nHighLimit=-6")],
    ),
    (
        "default-outside-limits",
        &[(
            "LowLimit=-5\nDefaultValue=-1",
            "LowLimit=-5\nDefaultValue=-6",
        )],
    ),
    (
        "const-without-default",
        &[("AccessType=const\nDefaultValue=1\n", "AccessType=const\n")],
    ),
    (
        "node-id-type",
        &[("LowLimit=-5\nDefaultValue=-1", "DefaultValue=$NODEID")],
    ),
    (
        "node-id-room",
        &[("DefaultValue=$NODEID\n", "DefaultValue=$NODEID+0xFFF0\n")],
    ),
    (
        "string-spelling",
        &[("DefaultValue=hello", "DefaultValue=hëll")],
    ),
    (
        "octet-string-spelling",
        &[("DefaultValue=01 aB ff", "DefaultValue=bytes!")],
    ),
    ("capacity", &[(";Capacity=5", ";Capacity=five")]),
    (
        "capacity-of-no-string",
        &[("ParameterName=Flag", ";Capacity=5\nParameterName=Flag")],
    ),
    ("capacity-too-small", &[(";Capacity=5", ";Capacity=4")]),
    (
        "value-too-large",
        &[
            (";Capacity=5\n", ""),
            ("DefaultValue=hello", "DefaultValue=LONG"),
        ],
    ),
    ("storage", &[(";Capacity=5", ";Capacity=5\n;Storage=there")]),
    (
        "storage-of-a-fixed-value",
        &[(
            "ParameterName=Flag",
            ";Storage=application\nParameterName=Flag",
        )],
    ),
    (
        "memory",
        &[(
            "ParameterName=Flag",
            ";Memory=application\nParameterName=Flag",
        )],
    ),
    (
        "dictionary-too-large",
        &[("DefaultValue=01 aB ff", "DefaultValue=BYTES")],
    ),
];

/// Rules of bindings with a file that breaks them.
const BINDINGS: &[(&str, &str)] = &[
    ("binding-syntax", "[[binding]]\nobject = 5\n"),
    (
        "binding-object",
        "[[binding]]\nobject = \"speed\"\nparameter = \"profile_velocity\"\n",
    ),
    (
        "binding-object-type",
        "[[binding]]\nobject = \"2010h\"\nparameter = \"profile_velocity\"\n",
    ),
    (
        "bound-twice",
        "[[binding]]\nobject = \"6083h\"\nparameter = \"profile_velocity\"\n",
    ),
    (
        "binding-parameter",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"speed\"\n",
    ),
    (
        "binding-access",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"statusword\"\n",
    ),
    (
        "binding-scale",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"profile_velocity\"\nscale = 0\n",
    ),
    (
        "binding-values",
        "[[binding]]\nobject = \"2000h\"\nparameter = \"modes_of_operation\"\nvalues = {}\n",
    ),
    (
        "binding-range",
        "[[binding]]\nobject = \"2006h\"\nparameter = \"profile_velocity\"\nvalues = { 1 = 1 }\n",
    ),
    (
        "binding-storage",
        "[storage]\nobjects = [\"all\", \"2000h-5FFFh\"]\n",
    ),
    ("unbound-object", ""),
];

/// Rules of the values of a configuration with a line that breaks them.
const VALUES: &[(&str, &str)] = &[
    ("value-line", "what is this\n"),
    ("value-of-nothing", "2FFF=1\n"),
    ("value-twice", "2001=1\n2001=2\n"),
];

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
        .chain(["missing-mandatory-object"])
    {
        *tested.entry(rule).or_default() += 1;
    }
    for rule in all() {
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

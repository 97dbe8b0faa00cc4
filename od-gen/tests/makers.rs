//! Excerpts with the traits of data sheets that makers ship: what is said about each, and that every tool works on it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use od_gen::diff::diff;
use od_gen::model::{Commissioning, FileKind};
use od_gen::{Report, Severity, dcf, doc, format, json, print};

fn files() -> Vec<PathBuf> {
    let folder = Path::new("tests/data/makers");
    let files = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn what_is_said_about_each_is_what_a_careful_reader_says() {
    let mut said = String::new();
    for file in files() {
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        let report = Report::of_bytes(&name, &std::fs::read(&file).unwrap());
        said += &format!("{name}\n");
        for finding in &report.findings {
            let line = finding.to_string();
            let (_, line) = line.split_once(':').unwrap();
            said += &format!("  {line}\n");
        }
    }
    insta::assert_snapshot!(said);
}

#[test]
fn every_tool_works_on_each() {
    let files = files();
    assert_eq!(files.len(), 36);
    for file in files {
        let report = Report::read(&file).unwrap();
        let name = file.display().to_string();
        let model = &report.model;
        assert!(report.has_model() && model.objects.len() >= 4, "{name}");
        assert!(doc::html(model).contains("<html"), "{name}");
        assert!(doc::markdown(model).contains("1018h"), "{name}");
        let _: serde_json::Value = serde_json::from_str(&json(model)).unwrap();
        assert!(diff(model, model).is_empty(), "{name}");

        // Formatting changes no meaning, and formatting again nothing at all.
        if model.kind != FileKind::Xdd {
            let formatted = format(&name, report.source.text()).unwrap();
            assert_eq!(format(&name, &formatted).unwrap(), formatted, "{name}");
            let again = Report::new(&name, &formatted).model;
            assert_eq!(diff(model, &again), [], "{name}");
            assert_eq!(&again, model, "{name}");
        }

        // A configuration has all that could be read.
        let mut configured = model.clone();
        let node = Commissioning {
            node_id: 7,
            bit_rate: 125,
            ..Commissioning::default()
        };
        dcf::commission(&mut configured, node, "node.dcf");
        let read = Report::new("node.dcf", &print(&configured)).model;
        assert_eq!(read.kind, FileKind::Dcf, "{name}");
        assert_eq!(diff(&configured, &read), [], "{name}");
    }
}

#[test]
fn values_whose_object_is_not_described_are_kept() {
    let text = "[DeviceInfo]\nVendorNumber=1\n[1200sub1]\nParameterName=Client\nDataType=0x0007\nAccessType=ro\nDefaultValue=$NODEID+0x600\n";
    let report = Report::new("part.eds", text);
    let errors: Vec<&str> = report
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Error)
        .map(|finding| finding.rule.name)
        .collect();
    // Nothing follows from what is not there but that it is not there.
    let missing = "missing-mandatory-object";
    let expected = [
        "missing-section",
        missing,
        missing,
        missing,
        "sub-without-object",
    ];
    assert_eq!(errors, expected);
    assert!(report.has_model());
    let client = report.model.entry(0x1200, 1).unwrap();
    assert_eq!(client.name, "Client");
    // A file that is made of it says the same.
    let again = Report::new("part.eds", &print(&report.model));
    assert_eq!(diff(&report.model, &again.model), []);
}

#[test]
fn what_is_allowed_beside_a_file_or_on_the_command_line_is_silent() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scanned.dcf");
    std::fs::copy("tests/data/makers/servo_scanned.dcf", &file).unwrap();
    let rules = |report: &Report| report.findings.len();
    assert_eq!(rules(&Report::read(&file).unwrap()), 8);
    let beside = od_gen::allowances_beside(&file);
    let allow = |objects: &str| {
        let because = "because = \"the maker's tool writes them\"\n";
        let text = format!("[[allow]]\nrules = [\"configured-read-only\"]\n{objects}{because}");
        std::fs::write(&beside, text).unwrap();
        Report::read(&file).unwrap()
    };
    let some = allow("objects = [\"2000h-2002h\", \"2007h\"]\n");
    assert_eq!((rules(&some), some.silenced.len()), (4, 4));
    assert_eq!(some.silenced[0].1, "the maker's tool writes them");
    assert_eq!(rules(&allow("")), 0);
    std::fs::write(
        &beside,
        "[[allow]]\nrules = [\"no-rule\"]\nbecause = \"x\"\n",
    )
    .unwrap();
    let refused = Report::read(&file).unwrap_err().to_string();
    assert!(refused.ends_with("there is no rule `no-rule`"), "{refused}");
    std::fs::remove_file(&beside).unwrap();
    let asked = od_gen::Exemption::of_rule("configured-read-only").unwrap();
    assert_eq!(rules(&Report::read_allowing(&file, &[asked]).unwrap()), 0);
}

fn od_gen(arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_od-gen"));
    program.args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn check_puts_right_what_is_plain() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("numbers.eds");
    std::fs::copy("tests/data/makers/numbers.eds", &file).unwrap();
    let name = file.to_str().unwrap();
    let output = od_gen(&["check", "--fix", name]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(0), ""));
    assert_eq!(text(&output.stderr), format!("{name}: 4 put right\n"));
    let now = std::fs::read_to_string(&file).unwrap();
    assert!(
        now.contains("DataType=0x0006\n") && now.contains("DefaultValue=8\n"),
        "{now}"
    );
    let again = od_gen(&["check", "--fix", name]);
    assert_eq!((again.status.code(), text(&again.stderr)), (Some(0), ""));
    // Either the number is wrong, or the names of the sections: nobody can tell.
    let counted = "tests/data/makers/counted_on.eds";
    let said = od_gen(&["check", counted]);
    let advice =
        "write DefaultValue=17, or name the sections in hexadecimal: [2000subB] is sub-index 11";
    assert!(text(&said.stdout).contains(advice), "{said:?}");
    std::fs::copy(counted, &file).unwrap();
    assert_eq!(od_gen(&["check", "--fix", name]).status.code(), Some(0));
    assert_eq!(
        std::fs::read(counted).unwrap(),
        std::fs::read(&file).unwrap()
    );
}

#[test]
fn what_a_drive_cannot_take_is_refused_at_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.eds");
    let sheet = std::fs::read_to_string("tests/data/drive.eds").unwrap();
    let old = "ParameterName=Target\nDataType=0x0004";
    assert!(sheet.contains(old));
    // No master could tell: the rule about the standard's types is silenced.
    let allow = ";od-gen: allow standard-type because a test asks for it\n";
    let wide = sheet.replace(old, "ParameterName=Target\nDataType=0x0015");
    std::fs::write(&file, format!("{allow}{wide}")).unwrap();
    let name = file.to_str().unwrap();
    let output = od_gen(&["rust", "--cia402", name]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), ""));
    let said = text(&output.stderr);
    assert!(
        said.contains("607Ah is INTEGER64, but target_position of the drive is i32"),
        "{said}"
    );
    assert_eq!(od_gen(&["rust", name]).status.code(), Some(0));
}

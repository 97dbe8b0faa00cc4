//! Excerpts with the traits of data sheets that makers ship: what is said about each, and that every tool works on it.

use std::path::{Path, PathBuf};

use od_gen::diff::diff;
use od_gen::model::{Commissioning, FileKind};
use od_gen::{Report, dcf, doc, format, json, print};

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
    assert_eq!(files.len(), 30);
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
        let formatted = format(&name, report.source.text()).unwrap();
        assert_eq!(format(&name, &formatted).unwrap(), formatted, "{name}");
        let again = Report::new(&name, &formatted).model;
        assert_eq!(diff(model, &again), [], "{name}");
        assert_eq!(&again, model, "{name}");

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

//! What is generated, and what is said, as a whole: compared with what it was when somebody last looked at it.

use std::path::{Path, PathBuf};

use od_gen::{Model, Options, ReadError, generate, parse, read};

fn model(file: &str) -> Model {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    read(&path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn small_device() {
    insta::assert_snapshot!(generate(&model("tests/data/small.eds"), Options::DEVICE));
}

#[test]
fn small_drive() {
    let generated = generate(&model("tests/data/drive.eds"), Options::DRIVE);
    let (_, objects) = generated.split_once("impl ::cia402::Objects").unwrap();
    insta::assert_snapshot!(objects.split_once("\n}\n").unwrap().0);
}

#[test]
fn broken_device() {
    let findings = parse("broken.eds", include_str!("data/broken.eds")).unwrap_err();
    insta::assert_snapshot!(ReadError::Findings(findings));
}

#[test]
fn o05_generating_twice_gives_identical_text() {
    for file in [
        "tests/data/small.eds",
        "../eds/axis402.eds",
        "../tests/eds/test-device.eds",
    ] {
        let first = generate(&model(file), Options::DEVICE);
        assert_eq!(first, generate(&model(file), Options::DEVICE));
        assert!(
            !first.contains(env!("CARGO_MANIFEST_DIR")),
            "no path of this machine"
        );
    }
}

#[test]
fn the_drive_has_every_object_that_the_firmware_asks_for() {
    let generated = generate(&model("../eds/axis402.eds"), Options::DRIVE);
    let (_, objects) = generated.split_once("impl ::cia402::Objects").unwrap();
    let (objects, _) = objects.split_once("\n}\n").unwrap();
    assert_eq!(objects.matches("fn ").count(), 19);
}

/// What is said about a file with these bytes, without the folder's name.
fn said_about(name: &str, bytes: &[u8]) -> Vec<String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    let text = read(&path).unwrap_err().to_string();
    let prefix = format!("{}:", path.display());
    let line = |line: &str| line.strip_prefix(&prefix).unwrap().to_owned();
    text.lines().map(line).collect()
}

const NOT_UTF_8: &str = "error: this is not UTF-8: save the file in that encoding";

#[test]
fn a_file_that_is_not_utf_8_is_refused_with_its_line() {
    let latin_1 =
        include_str!("data/small.eds").replacen("FileVersion", "Description=Gr?\nFileVersion", 1);
    let bytes: Vec<u8> = latin_1
        .bytes()
        .map(|byte| if byte == b'?' { 0xF6 } else { byte })
        .collect();
    assert_eq!(
        said_about("latin1.eds", &bytes),
        [format!("4: {NOT_UTF_8}")]
    );
}

#[test]
fn what_else_is_wrong_with_a_file_that_is_not_utf_8_is_said_too() {
    let broken = include_str!("data/broken.eds");
    let findings = parse("x", broken).unwrap_err();
    let findings = findings
        .iter()
        .map(|finding| format!("{}: error: {}", finding.line, finding.message));
    let expected: Vec<String> = [format!("1: {NOT_UTF_8}")]
        .into_iter()
        .chain(findings)
        .collect();
    // The first line is a comment.
    let bytes = [b";\xF6", broken.as_bytes()].concat();
    assert_eq!(said_about("latin1_broken.eds", &bytes), expected);
}

#[test]
fn utf_16_is_one_finding() {
    let text = include_str!("data/broken.eds");
    let little: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(text.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    assert_eq!(
        said_about("utf16.eds", &little),
        [format!("1: {NOT_UTF_8}")]
    );
}

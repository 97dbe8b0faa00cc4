//! What is generated, and what is said, as a whole: compared with what it was when somebody last looked at it.

use std::path::{Path, PathBuf};

use od_gen::model::DefaultValue;
use od_gen::{Colour, Figures, Model, Options, Report, generate, read};

fn model(file: &str) -> Model {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(file);
    read(&path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn small_device() {
    insta::assert_snapshot!(generate(&model("tests/data/small.eds"), Options::DEVICE));
}

/// `cargo run -p od-gen -- rust firmware/canopen/examples/io_device/io-device.eds -o firmware/canopen/examples/io_device/dictionary.rs` writes it anew.
#[test]
fn the_dictionary_of_the_example_is_what_is_generated() {
    let generated = generate(
        &model("../firmware/canopen/examples/io_device/io-device.eds"),
        Options::DEVICE,
    );
    let committed = include_str!("../../firmware/canopen/examples/io_device/dictionary.rs");
    assert!(generated == committed, "it is to be generated anew");
}

#[test]
fn small_drive() {
    let generated = generate(&model("tests/data/drive.eds"), Options::DRIVE);
    let (_, objects) = generated.split_once("impl ::cia402::Objects").unwrap();
    insta::assert_snapshot!(objects.split_once("\n}\n").unwrap().0);
}

#[test]
fn broken_device() {
    let report = Report::new("broken.eds", include_str!("data/broken.eds"));
    insta::assert_snapshot!(report.render(Colour::Never));
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
fn the_drives_and_the_products_have_every_object_that_the_firmware_asks_for() {
    let drives = ["../eds/axis402.eds", "../eds/servo.toml"].map(|file| {
        let generated = generate(&model(file), Options::DRIVE);
        let (_, objects) = generated.split_once("impl ::cia402::Objects").unwrap();
        objects.split_once("\n}\n").unwrap().0.to_owned()
    });
    let bindings = ["lmd", "nanotec", "s200"].map(|product| {
        let file = format!("../products/{product}/{product}.bind.toml");
        std::fs::read_to_string(file).unwrap()
    });
    for parameter in cia402_parameters::ALL {
        let name = parameter.name;
        let methods = [format!("fn {name}("), format!("fn set_{name}(")];
        let has_it = |objects: &String| methods.iter().any(|method| objects.contains(method));
        let is_bound = |binding: &String| binding.contains(&format!("parameter = \"{name}\""));
        assert!(
            drives.iter().any(has_it) || bindings.iter().any(is_bound),
            "{name}"
        );
    }
}

/// What is said about a file with these bytes, without the folder's name, and what the file means.
fn said_about(name: &str, bytes: &[u8]) -> (Vec<String>, Model) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    let report = Report::read(&path).unwrap();
    let prefix = format!("{}:", path.display());
    let line = |line: String| line.strip_prefix(&prefix).unwrap().to_owned();
    let findings = report.findings.iter().map(ToString::to_string);
    (findings.map(line).collect(), report.model)
}

const NOT_UTF_8: &str = "warning[not-utf-8]: this is not UTF-8: the file is read as Windows-1252";

#[test]
fn o04_a_file_in_latin_1_is_read_with_a_warning() {
    let text =
        include_str!("data/small.eds").replacen("FileVersion", "Description=Gr?\nFileVersion", 1);
    let bytes: Vec<u8> = text
        .bytes()
        .map(|byte| if byte == b'?' { 0xF6 } else { byte })
        .collect();
    let (said, model) = said_about("latin1.eds", &bytes);
    assert_eq!(said, [format!("4:15: {NOT_UTF_8}")]);
    assert_eq!(model.file_info.description, "Gr\u{f6}");
}

#[test]
fn what_else_is_wrong_with_a_file_in_latin_1_is_said_too() {
    let broken = include_str!("data/broken.eds");
    let report = Report::new("x", broken);
    let findings = report.findings.iter();
    let findings = findings.map(|finding| finding.to_string()[2..].to_string());
    let expected: Vec<String> = [format!("1:2: {NOT_UTF_8}")]
        .into_iter()
        .chain(findings)
        .collect();
    // The first line is a comment.
    let bytes = [b";\xF6", broken.as_bytes()].concat();
    assert_eq!(said_about("latin1_broken.eds", &bytes).0, expected);
}

#[test]
fn utf_16_is_read_with_a_warning() {
    let text = include_str!("data/small.eds");
    let same = Report::new("small.eds", text).model;
    let marked = format!("\u{feff}{text}");
    let little = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big = |text: &str| text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let files: [Vec<u8>; 4] = [little(&marked), big(&marked), little(text), big(text)];
    for bytes in files {
        let (said, model) = said_about("small.eds", &bytes);
        let warning = "1:1: warning[not-utf-8]: this is not UTF-8: the file is read as UTF-16";
        assert_eq!(said, [warning]);
        assert_eq!(model.objects, same.objects);
    }
}

#[test]
fn what_is_no_text_is_refused() {
    let (said, model) = said_about("program.eds", b"\x7FELF\x02\x01\0\0\0\0\0\0");
    assert!(model.file.ends_with("program.eds"), "{}", model.file);
    assert_eq!(
        said,
        ["1:1: error[not-text]: this is no text: 6 of its bytes are zero"]
    );
}

#[test]
fn findings_are_silenced_with_a_reason() {
    let text = include_str!("data/allowed.eds");
    let report = Report::new("allowed.eds", text);
    let silenced = report.silenced.iter();
    let silenced = silenced.map(|(finding, reason)| format!("{finding}\n  because {reason}\n"));
    let silenced: String = silenced.collect();
    insta::assert_snapshot!(format!(
        "{}\nsilenced:\n{silenced}",
        report.render(Colour::Never)
    ));
}

#[test]
fn the_data_sheets_of_this_repository_are_clean() {
    for folder in ["../eds", "../tests/eds"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for file in std::fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            if path.extension().is_some_and(|kind| kind == "eds") {
                let report = Report::read(&path).unwrap();
                assert!(
                    report.findings.is_empty(),
                    "{}",
                    report.render(Colour::Never)
                );
            }
        }
    }
}

#[test]
fn o04_a_data_sheet_as_vendors_ship_them_is_read() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/vendor.eds");
    let report = Report::read(&path).unwrap();
    assert_eq!(report.render(Colour::Never), "");
    let mut silenced: Vec<&str> = report
        .silenced
        .iter()
        .map(|(finding, _)| finding.rule.name)
        .collect();
    silenced.sort_unstable();
    let expected = [
        "list-numbering",
        "no-sub-0",
        "trailing-comment",
        "trailing-comment",
        "unknown-key",
        "unknown-section",
    ];
    assert_eq!(silenced, expected);
    let model = report.model;
    let default = |index, sub| model.entry(index, sub).unwrap().initial();
    assert_eq!(model.device.vendor_name, "Nobody & S\u{f6}hne");
    assert_eq!(model.device.product_number, Some(18));
    assert_eq!(default(0x2000, 0), DefaultValue::number(-1));
    assert_eq!(default(0x2001, 0), DefaultValue::number(u64::MAX.into()));
    assert_eq!(default(0x2002, 0), DefaultValue::number(i64::MIN.into()));
    assert_eq!(default(0x2003, 0), DefaultValue::number(10), "added");
    assert_eq!(default(0x2003, 1), DefaultValue::Real(-5.0));
    assert_eq!(default(0x2ABC, 0), DefaultValue::number(-128));
    assert_eq!(default(0x5FFF, 0), DefaultValue::Text(vec![0, 0xFF, 0xA0]));
    assert!(default(0x1200, 2).adds_node_id() && default(0x1014, 0).adds_node_id());
}

#[test]
fn descriptors_and_limits_of_a_data_sheet_take_some_twelve_bytes_an_entry() {
    for file in [
        "eds/axis402",
        "products/lmd/lmd",
        "products/nanotec/nanotec",
        "products/s200/s200",
        "products/tc1/tc1",
    ] {
        let figures = Figures::of(&model(&format!("../{file}.eds")));
        let (entries, bytes) = (figures.entries, figures.descriptors + figures.limits);
        assert!(entries > 100, "{file}");
        // Of a data sheet just behind a power of two of its buckets a little more.
        assert!(bytes * 10 <= 121 * entries, "{file}: {bytes} for {entries}");
    }
}

//! What is generated compiles, does what the data sheet says, and does not compile when it is used wrongly.
//!
//! Each file in `compile/` is a program with a dictionary beside it (`DICTIONARY.rs`). Those in `compile/wrong` have to fail, with
//! the message that lies beside them.

mod random;

use std::fs;
use std::path::{Path, PathBuf};

use od_gen::bind::Bindings;
use od_gen::{BindingReport, Figures, Model, Options, generate, parse};

/// A dictionary for the programs: its name, its data sheet with what is changed in it, and whether it is one of a drive.
const DICTIONARIES: [(&str, &str, (&str, &str), bool); 4] = [
    ("types", include_str!("../data/types.eds"), ("", ""), false),
    (
        "foreign",
        include_str!("../data/foreign.eds"),
        ("", ""),
        true,
    ),
    ("small", include_str!("../data/small.eds"), ("", ""), false),
    // 6040h is an UNSIGNED32, which it is not to the firmware.
    (
        "wide_controlword",
        include_str!("../data/foreign.eds"),
        (
            "ParameterName=Controlword\nDataType=0x0006",
            "ParameterName=Controlword\nDataType=0x0007",
        ),
        true,
    ),
];

/// Stands for the folder in messages of the compiler.
const FOLDER: &str = "$FOLDER";

/// The folder that the programs are compiled in, with all dictionaries and the programs of `from`. Tests run side by side: each has its own.
fn prepare(from: &str, into: &str) -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(from);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(into);
    // What an earlier run has left behind.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    for (name, text, (old, new), is_drive) in DICTIONARIES {
        assert!(text.contains(old), "{name}");
        let model = parse(name, &text.replace(old, new)).unwrap();
        let text = include_str!("../data/foreign.bind.toml");
        let report = BindingReport::new("foreign.bind.toml", text, &model);
        assert!(!is_drive || !report.has_errors());
        write(&folder, name, &model, is_drive.then_some(&report.bindings));
    }
    for (name, path) in data_sheets() {
        let model = od_gen::read(&path).unwrap();
        let report = BindingReport::beside(&path, &model).unwrap();
        let bindings = report.map(|report| report.bindings).unwrap_or_default();
        write(&folder, &name, &model, Some(&bindings));
    }
    for entry in fs::read_dir(own).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let text = fs::read_to_string(&path).unwrap();
            let text = text.replace(FOLDER, &folder.display().to_string());
            fs::write(folder.join(path.file_name().unwrap()), text).unwrap();
        }
    }
    folder
}

/// Writes a dictionary, with `cia402::Objects` where it has bindings.
fn write(folder: &Path, name: &str, model: &Model, bindings: Option<&Bindings>) {
    let options = Options {
        cia402: bindings.is_some(),
        bindings: bindings.unwrap_or(Bindings::NONE),
        names: true,
        ..Options::DEVICE
    };
    // In a folder of its own: what lies beside the programs is taken for one.
    let place = folder.join("dictionaries");
    fs::create_dir_all(&place).unwrap();
    fs::write(place.join(format!("{name}.rs")), generate(model, options)).unwrap();
}

/// The data sheets of the repository: name and path.
fn data_sheets() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../eds");
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|extension| extension == "eds"));
    let name = |path: &Path| {
        path.file_stem()
            .unwrap()
            .to_string_lossy()
            .replace('-', "_")
    };
    let mut named: Vec<(String, PathBuf)> = files.map(|path| (name(&path), path)).collect();
    named.sort();
    named
}

/// The programs that do, and those that do not. Together: on their own each half builds what they depend on in another way.
/// Run with `TRYBUILD=overwrite` to take over the messages.
#[test]
fn o01_right_use_does_what_the_data_sheet_says_and_wrong_use_does_not_compile() {
    let folder = prepare("compile", "programs");
    random::write(&folder);
    // All in one program: linking one takes longer than compiling a dictionary.
    let mut program = String::from(PROGRAM);
    for (name, path) in data_sheets() {
        let figures = Figures::of(&od_gen::read(&path).unwrap());
        program += &CHECK
            .replace("NAME", &name)
            .replace("FLASH", &figures.flash().to_string())
            .replace("RAM", &figures.ram.to_string());
    }
    fs::write(folder.join("data_sheets.rs"), program + "}\n").unwrap();
    let wrong = prepare("compile/wrong", "wrong");
    let cases = trybuild::TestCases::new();
    cases.pass(folder.join("*.rs"));
    cases.compile_fail(wrong.join("*.rs"));
    // This runs them.
    drop(cases);
    if std::env::var_os("TRYBUILD").is_some_and(|what| what == "overwrite") {
        take_over(&wrong);
    }
}

/// The data sheets of the repository: they compile without a warning, and take what is said of them.
const PROGRAM: &str = r"#![deny(warnings)]
#![forbid(unsafe_code)]

fn main() {
    use canopen::od::Dictionary as _;
";

/// One of them.
const CHECK: &str = r#"
    mod NAME {
        include!("dictionaries/NAME.rs");
    }
    let table = NAME::Dictionary::TABLE;
    let flash = size_of_val(table.entries)
        + size_of_val(table.buckets)
        + size_of_val(table.limits)
        + size_of_val(table.rom)
        + size_of_val(table.defaults);
    assert_eq!(flash, FLASH);
    assert_eq!(size_of::<NAME::Dictionary>(), RAM);
"#;

#[test]
fn generated_code_is_as_rustfmt_would_write_it() {
    let folder = prepare("compile", "formatting");
    random::write(&folder);
    for file in fs::read_dir(folder.join("dictionaries")).unwrap() {
        let file = file.unwrap().path();
        let check = std::process::Command::new("rustfmt")
            .args(["--edition", "2024", "--check"])
            .arg(&file)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&check.stdout);
        assert!(check.status.success(), "{}\n{said}", file.display());
    }
}

/// Puts the messages of a run beside their programs.
fn take_over(folder: &Path) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compile/wrong");
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|extension| extension == "stderr")
        {
            let text = fs::read_to_string(&path).unwrap();
            let text = text.replace(&folder.display().to_string(), FOLDER);
            fs::write(own.join(path.file_name().unwrap()), text).unwrap();
        }
    }
}

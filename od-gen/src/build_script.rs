//! Generating a dictionary while a crate is built.

use std::io::{self, Write};
use std::path::Path;
use std::{env, fs, process};

use crate::bind::{self, BindingReport, Bindings};
use crate::diagnostic::Colour;
use crate::generate::{Options, generate, misfits};
use crate::model::Model;
use crate::report::Report;

/// For a build script: reads the data sheet `eds` (a path from the package's folder), writes the dictionary to `output` in
/// `OUT_DIR`, and has cargo run the script again when the data sheet changes. The crate takes it in with
/// `include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));` inside of a module of its own.
///
/// For a drive the Rust module beside the data sheet (`NAME.rs`), if there is one, is its behaviour (`cia402::behaviour`).
/// The bindings beside the data sheet (`NAME.bind.toml`) are read too, unless `options` brings some.
///
/// What is wrong with the files is printed as a compiler would, then the build ends with exit code 1; warnings are passed on
/// to cargo.
pub fn build(eds: impl AsRef<Path>, output: &str, options: Options<'_>) {
    let eds = eds.as_ref();
    println!("cargo::rerun-if-changed={}", eds.display());
    let beside = crate::allowances_beside(eds);
    if beside.exists() {
        println!("cargo::rerun-if-changed={}", beside.display());
    }
    let report = Report::read_for_code(eds, &[])
        .unwrap_or_else(|error| fail(&format!("{}: error: {error}", eds.display())));
    for part in report.source.parts() {
        println!("cargo::rerun-if-changed={}", part.file);
    }
    for variable in &report.variables {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    if report.has_errors() {
        fail(&report.render(Colour::Never));
    }
    for warning in &report.findings {
        println!("cargo::warning={warning}");
    }
    let mut model = report.model;
    if let Err(problem) = options.identity.set(&mut model) {
        fail(&format!("{}: error: {problem}", eds.display()));
    }
    let Some(folder) = env::var_os("OUT_DIR") else {
        fail("error: od_gen::build is for build scripts: OUT_DIR is not set");
    };
    let bindings = if options.cia402 && *options.bindings == *Bindings::NONE {
        bindings(eds, &model)
    } else {
        options.bindings.clone()
    };
    if options.cia402 {
        let misfits = misfits(&model, &bindings);
        let shown = misfits.iter().map(ToString::to_string);
        if !misfits.is_empty() {
            fail(&shown.collect::<Vec<_>>().join("\n"));
        }
    }
    let module = behaviour(eds);
    let sheet = format!("{output}.eds");
    let sheet = holds_data_sheet(&model).then_some(sheet);
    if let Some(sheet) = &sheet {
        let path = Path::new(&folder).join(sheet);
        if let Err(error) = fs::write(&path, essence(report.source.text())) {
            fail(&format!("{}: error: {error}", path.display()));
        }
    }
    let options = Options {
        bindings: &bindings,
        behaviour: module.as_deref(),
        data_sheet: sheet.as_deref(),
        ..options
    };
    let path = Path::new(&folder).join(output);
    if let Err(error) = fs::write(&path, generate(&model, options)) {
        fail(&format!("{}: error: {error}", path.display()));
    }
}

/// Whether the device has 1021h for its data sheet.
fn holds_data_sheet(model: &Model) -> bool {
    const STORE_EDS: u16 = 0x1021;
    model.objects.iter().any(|object| object.index == STORE_EDS)
}

/// A data sheet without comments, and without what CiA 306 takes for granted: a variable, and no PDO.
fn essence(text: &str) -> String {
    let is_said = |line: &&str| {
        !(line.is_empty()
            || line.starts_with(';')
            || ["ObjectType=0x7", "PDOMapping=0"].contains(line))
    };
    let lines = text.lines().map(str::trim).filter(is_said);
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// The whole path of the Rust module beside the data sheet, with its name: what the drive does that is no data.
fn behaviour(eds: &Path) -> Option<String> {
    let Ok(path) = eds.with_extension("rs").canonicalize() else {
        // Should there be one some day, the folder changes.
        let folder = eds.parent().unwrap_or(eds);
        println!("cargo::rerun-if-changed={}", folder.display());
        return None;
    };
    println!("cargo::rerun-if-changed={}", path.display());
    Some(path.to_string_lossy().into_owned())
}

/// The bindings beside the data sheet.
fn bindings(eds: &Path, model: &Model) -> Bindings {
    let file = bind::file_beside(eds);
    let report = match BindingReport::beside(eds, model) {
        Ok(Some(report)) => report,
        Ok(None) => {
            // Should there be some one day, the folder changes.
            let folder = eds.parent().unwrap_or(eds);
            println!("cargo::rerun-if-changed={}", folder.display());
            return Bindings::default();
        }
        Err(error) => fail(&format!("{}: error: {error}", file.display())),
    };
    println!("cargo::rerun-if-changed={}", file.display());
    if report.has_errors() {
        fail(report.render(Colour::Never).trim_end());
    }
    for finding in &report.findings {
        println!("cargo::warning={finding}");
    }
    report.bindings
}

fn fail(message: &str) -> ! {
    // Whoever does not read it still has the exit code.
    let _ = writeln!(io::stderr(), "{message}");
    process::exit(1);
}

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
/// For a drive the bindings beside the data sheet (`NAME.bind.toml`) are read too, unless `options` brings some.
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
    let options = Options {
        bindings: &bindings,
        ..options
    };
    let path = Path::new(&folder).join(output);
    if let Err(error) = fs::write(&path, generate(&model, options)) {
        fail(&format!("{}: error: {error}", path.display()));
    }
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

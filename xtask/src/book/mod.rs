//! `cargo xtask book`: docs/ and the pages beside the crates as one site, made by mdBook.
//!
//! The chapters are those of docs/SUMMARY.md. They lie in the book where they lie in the repository, so a link leads to the same place in both;
//! what is a single file comes along, and a folder, which a site cannot show, is named without a link. The reference of the dictionary is made
//! by `od-gen`, that of the crates by rustdoc. In the end every link of the site is looked up.

mod links;
mod pages;
mod pictures;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, anyhow, bail};

use crate::words::say;
use crate::{place, process, setup};

/// The crates whose documentation a user reads, and what each is.
const CRATES: [(&str, &str); 9] = [
    ("canopen", "a CANopen device: CiA 301, 302, 303 and 305"),
    ("cia402", "the drive: state machine and modes"),
    ("motion", "profiles and pulses"),
    ("servo", "current loop, field and tuning of a motor"),
    ("runtime", "node and control tick as one firmware"),
    ("slcan", "SLCAN, for adapters"),
    ("store", "parameters in flash, safe against power cuts"),
    ("od_gen", "data sheets, findings, typed dictionaries"),
    ("master", "a CANopen master, its buses and its words"),
];

/// How the book is made.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Make the pictures in docs/ anew by their commands; those of the panel need the browser of the tests
    #[arg(long)]
    pictures: bool,

    /// Leave out the documentation of the crates, which takes longest
    #[arg(long)]
    without_api: bool,
}

/// Runs the command.
///
/// # Errors
/// When mdBook cannot be installed, a chapter is missing, or a link leads nowhere.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    if arguments.pictures {
        pictures::make()?;
    }
    let index = make(!arguments.without_api)?;
    say!("{}", index.display())?;
    Ok(ExitCode::SUCCESS)
}

/// Makes the book and looks up its links; gives its first page.
///
/// # Errors
/// When mdBook cannot be installed, a chapter is missing, or a link leads nowhere.
pub fn make(with_api: bool) -> Result<PathBuf> {
    let mdbook = setup::mdbook()?;
    let folder = place::target().join("book");
    let (source, site) = (folder.join("src"), folder.join("site"));
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    }
    fs::create_dir_all(source.join("docs"))?;
    fs::copy(
        place::root().join("docs/book.toml"),
        folder.join("book.toml"),
    )?;
    fs::write(source.join("docs/dictionary.md"), dictionary()?)?;
    fs::write(source.join("docs/crates.md"), crates(with_api))?;
    pages::gather(&place::root(), &source)?;

    let mut build = Command::new(mdbook);
    build.arg("build").arg(&folder);
    // It says what it does on the standard error, and nothing else there.
    run_well(&mut build)?;
    if with_api {
        run_well(&mut documentation())?;
        copy_folder(&place::target().join("doc"), &site.join("api"))?;
    }
    pictures::check()?;
    let wrong = links::check(&site)?;
    if !wrong.is_empty() {
        bail!("links of the book lead nowhere: {}", wrong.join("; "));
    }
    Ok(site.join("index.html"))
}

/// The reference of the dictionary, as a chapter.
fn dictionary() -> Result<String> {
    let mut command = place::cargo();
    command.args(["run", "--quiet", "--package", "od-gen", "--"]);
    command.args(["doc", "eds/axis402.eds", "--format", "markdown"]);
    process::ask(&mut command).ok_or_else(|| anyhow!("`{}` failed", process::line(&command)))
}

fn documentation() -> Command {
    let mut command = place::cargo();
    command.args(["doc", "--quiet", "--no-deps", "--lib"]);
    // As in the test run, which has made it already.
    command.env("RUSTDOCFLAGS", "-D warnings");
    for (name, _) in CRATES {
        command.args(["--package", &name.replace('_', "-")]);
    }
    command
}

/// The chapter that leads to the documentation of the crates.
fn crates(with_api: bool) -> String {
    let mut text =
        "# The crates\n\nWhat rustdoc says of each.\n\n| crate | |\n|---|---|\n".to_owned();
    for (name, subject) in CRATES {
        let cell = match with_api {
            true => format!("[{name}](../api/{name}/index.html)"),
            false => format!("`{name}`"),
        };
        text += &format!("| {cell} | {subject} |\n");
    }
    text
}

fn run_well(command: &mut Command) -> Result<()> {
    match process::run(command)?.success() {
        true => Ok(()),
        false => bail!("`{}` failed", process::line(command)),
    }
}

fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| format!("reading {}", from.display()))? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

//! What can be asked for.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Electronic data sheets (CiA 306) in, typed static object dictionaries in Rust out.
#[derive(Debug, Parser)]
#[command(version)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Print the dictionary as a Rust module
    Rust(Rust),
    /// List which objects stand for which parameters of the drive, and check the file beside the data sheet that says so
    Bindings(Bindings),
    /// Print the dictionary as a reference for people
    Doc(Doc),
    /// Print the dictionary as JSON for other programs
    Dump(Dump),
}

#[derive(Debug, Args)]
pub(crate) struct Rust {
    /// The electronic data sheet
    pub(crate) file: PathBuf,
    /// Implement `cia402::Objects` too
    #[arg(long)]
    pub(crate) cia402: bool,
    /// Write the names of all values too
    #[arg(long)]
    pub(crate) names: bool,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Bindings {
    /// The electronic data sheet; the bindings are in the same place, with the extension .bind.toml
    pub(crate) file: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct Doc {
    /// The electronic data sheet
    pub(crate) file: PathBuf,
    /// What to print
    #[arg(long, value_enum, default_value_t = DocFormat::Html)]
    pub(crate) format: DocFormat,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Dump {
    /// The electronic data sheet
    pub(crate) file: PathBuf,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DocFormat {
    /// One page that needs no other file
    Html,
    /// Markdown with tables
    Markdown,
}

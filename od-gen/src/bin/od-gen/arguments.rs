//! What can be asked for.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use od_gen::{Exemption, Identity};

/// Electronic data sheets (CiA 306) in, typed static object dictionaries in Rust out.
#[derive(Debug, Parser)]
#[command(version)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Say what is wrong with data sheets; exit code 1 when something is
    Check(Check),
    /// Print the dictionary as a Rust module
    Rust(Rust),
    /// List which objects stand for which parameters of the drive, and check the file beside the data sheet that says so
    Bindings(Bindings),
    /// Print the dictionary as a reference for people
    Doc(Doc),
    /// Print the dictionary as JSON for other programs
    Dump(Dump),
    /// Say what two data sheets mean differently; exit code 1 when something is different
    Diff(Diff),
    /// Write a data sheet in another format: EDS, DCF, XDD or XDC, by the extension
    Convert(Convert),
    /// Print the configuration of one device, made from a data sheet
    Dcf(Dcf),
    /// Write the configuration of each node of a network, and its master's, from a description of all; print the bus load
    Network(Network),
    /// Bring data sheets into their canonical form
    Fmt(Fmt),
    /// List the rules that data sheets are held to, or explain one
    Rules(Rules),
}

/// What is silenced from outside of the file, beside what stands in NAME.allow.toml.
#[derive(Debug, Args)]
pub(crate) struct Allow {
    /// Say nothing about this rule; can be given often
    #[arg(long = "allow", value_name = "RULE", value_parser = Exemption::of_rule)]
    pub(crate) rules: Vec<Exemption>,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Data sheets (EDS), device configurations (DCF) or device descriptions (XDD)
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// How to print what is found
    #[arg(long, value_enum, default_value_t = CheckFormat::Full)]
    pub(crate) format: CheckFormat,
    /// Write into the file what puts mistakes of spelling and structure right, where there is one reading; everything else stays
    #[arg(long)]
    pub(crate) fix: bool,
    /// Show every finding, also where many break one rule
    #[arg(long)]
    pub(crate) all: bool,
    /// Warnings are errors
    #[arg(long)]
    pub(crate) deny_warnings: bool,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CheckFormat {
    /// With the line and what to do
    Full,
    /// One line for each finding
    Short,
    /// For programs
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct Rust {
    /// The electronic data sheet
    pub(crate) file: PathBuf,
    /// Implement `cia402::Objects` too
    #[arg(long)]
    pub(crate) cia402: bool,
    /// Write the names of all values too, and what the data sheet says of them: access, type, unit, limits, default
    #[arg(long)]
    pub(crate) names: bool,
    /// Set a number of 1018h: vendor_id, product_code, revision_number or serial_number; can be given often
    #[arg(long, value_name = "NAME=NUMBER")]
    pub(crate) identity: Vec<Identity>,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Debug, Args)]
pub(crate) struct Bindings {
    /// The electronic data sheet; the bindings are in the same place, with the extension .bind.toml
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) allow: Allow,
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
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Debug, Args)]
pub(crate) struct Dump {
    /// The electronic data sheet
    pub(crate) file: PathBuf,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DocFormat {
    /// One page that needs no other file
    Html,
    /// Markdown with tables
    Markdown,
}

#[derive(Debug, Args)]
pub(crate) struct Diff {
    /// What was before
    pub(crate) before: PathBuf,
    /// What is now
    pub(crate) after: PathBuf,
    /// How to print what is different
    #[arg(long, value_enum, default_value_t = ListFormat::Text)]
    pub(crate) format: ListFormat,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ListFormat {
    /// For people
    Text,
    /// For programs
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct Convert {
    /// What there is: EDS, DCF, XDD or XDC
    pub(crate) input: PathBuf,
    /// What is to be: a file with the extension .eds, .dcf, .xdd or .xdc
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Debug, Args)]
pub(crate) struct Dcf {
    /// The electronic data sheet, or a configuration that is to be changed
    pub(crate) file: PathBuf,
    /// Node-ID; a configuration that is changed keeps this and all that follows when they are not given
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=127))]
    pub(crate) node_id: Option<u8>,
    /// Bit rate in kbit/s; 125 when nothing says another
    #[arg(long, value_parser = bit_rate)]
    pub(crate) bit_rate: Option<u16>,
    /// What the node is called
    #[arg(long, value_parser = one_line)]
    pub(crate) name: Option<String>,
    /// Number of the network
    #[arg(long)]
    pub(crate) network: Option<u32>,
    /// What the network is called
    #[arg(long, value_parser = one_line)]
    pub(crate) network_name: Option<String>,
    /// The node manages the network; `--manager=false` when it no longer does
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) manager: Option<bool>,
    /// Serial number, by which LSS finds the node
    #[arg(long)]
    pub(crate) serial_number: Option<u32>,
    /// A value: INDEX=VALUE or INDEX:SUB=VALUE, index and sub-index in hexadecimal; can be given often
    #[arg(long, value_name = "PLACE=VALUE", value_parser = one_line)]
    pub(crate) set: Vec<String>,
    /// Values from a file, one a line; those of --set come after them
    #[arg(long, value_name = "FILE")]
    pub(crate) values: Vec<PathBuf>,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Debug, Args)]
pub(crate) struct Network {
    /// The description (TOML, or YAML in .yaml and .yml): nodes with their data sheets, PDOs, heartbeats, SYNC and the master
    pub(crate) file: PathBuf,
    /// Write into this folder instead of the current one
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Write nothing: only say what is wrong, and the bus load
    #[arg(long)]
    pub(crate) check: bool,
}

/// What fits behind a key.
fn one_line(text: &str) -> Result<String, String> {
    if text.contains(char::is_control) {
        Err("more than one line".into())
    } else {
        Ok(text.to_owned())
    }
}

/// A bit rate that a DCF can have.
fn bit_rate(text: &str) -> Result<u16, String> {
    let rate = text.parse().map_err(|_| "not a number".to_owned())?;
    if [10, 20, 50, 125, 250, 500, 800, 1000].contains(&rate) {
        Ok(rate)
    } else {
        Err("not 10, 20, 50, 125, 250, 500, 800 or 1000".into())
    }
}

#[derive(Debug, Args)]
pub(crate) struct Fmt {
    /// Data sheets, written back where they change
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Change nothing: name the files that would change, with exit code 1
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) allow: Allow,
}

#[derive(Debug, Args)]
pub(crate) struct Rules {
    /// The rules to explain; all are listed without
    #[arg(value_name = "RULE")]
    pub(crate) names: Vec<String>,
    /// How to print them
    #[arg(long, value_enum, default_value_t = ListFormat::Text)]
    pub(crate) format: ListFormat,
}

//! `cargo xtask fuzz`: the targets of `fuzz/` under libFuzzer.
//!
//! The targets are built with coverage counters by flags that the stable compiler has, so neither a nightly compiler nor
//! cargo-fuzz is needed, only a C++ compiler for libFuzzer itself. Each begins with the cases of `fuzz/cases`. A run of
//! `cargo xtask test` has a fixed number of inputs from a fixed seed and keeps nothing; a run of this command takes its time
//! and keeps what it has found worth keeping in the build folder, where the next one goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use anyhow::{Context, Result, anyhow};

use crate::refusal::refuse;
use crate::suite::programs;
use crate::words::say;
use crate::{place, process, setup};

/// What makes a program report to libFuzzer where it has been and what it has compared.
const COVERAGE: &str = "--cfg fuzzing -Ccodegen-units=1 -Cpasses=sancov-module \
    -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
    -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares";

/// The longest input in bytes: about fifty frames.
const LONGEST: u32 = 600;

/// The longest data sheet in bytes.
const LONGEST_DATA_SHEET: u32 = 3000;

/// Inputs of a target in a test run. Of those with a bus on virtual time, sockets, or flash of which anybody has made anything, as many as
/// take a minute of one processor.
fn inputs(target: &str) -> u32 {
    match target {
        "slcan" => 16_000_000,
        "serve" => 110_000,
        "store" => 70_000,
        "master" => 15_000,
        "drive" => 5_000,
        _ => 30_000,
    }
}

/// How long and what to fuzz.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Fuzz only these targets (axis, data_sheet, drive, lss, master, node, plan, sdo, serve, slcan, store)
    pub targets: Vec<String>,

    /// Fuzz each target for so many seconds
    #[arg(long, default_value_t = 60, value_name = "SECONDS")]
    pub seconds: u32,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let all = targets()?;
    if let Some(unknown) = arguments
        .targets
        .iter()
        .find(|target| !all.contains(target))
    {
        return Err(refuse(format!(
            "no fuzz target `{unknown}` (there are: {})",
            all.join(", ")
        )));
    }
    setup::cxx_compiler()?;
    for mut command in build_commands()? {
        if !process::run(&mut command)?.success() {
            return Ok(ExitCode::FAILURE);
        }
    }
    let mut code = ExitCode::SUCCESS;
    let chosen = all
        .iter()
        .filter(|target| arguments.targets.is_empty() || arguments.targets.contains(target));
    for target in chosen {
        let corpus = folder().join("corpus").join(target);
        fs::create_dir_all(&corpus).with_context(|| format!("making {}", corpus.display()))?;
        let mut command = run_command(target, &corpus)?;
        command.arg(format!("-max_total_time={}", arguments.seconds));
        if !held(target, &format!("{} s", arguments.seconds), &mut command)? {
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

/// The commands that build the targets and write the cases they begin with.
pub fn build_commands() -> Result<[Command; 3]> {
    let mut build = place::cargo();
    build
        .args(["build", "--release", "--manifest-path"])
        .arg(manifest())
        .args(["--target", &host()?, "--target-dir"])
        .arg(folder())
        .env("RUSTFLAGS", COVERAGE);
    let mut seeds = Command::new(place::built("fuzz_seeds"));
    seeds.arg(folder().join("seeds")).current_dir(place::root());
    Ok([build, programs::build_command(), seeds])
}

/// A test run: the same inputs for each target every time. Tells which targets held.
///
/// # Errors
/// When a target cannot be started.
pub fn short_runs() -> Result<Vec<bool>> {
    // One after the other for each processor: a target is one thread.
    let targets = targets()?;
    let next = AtomicUsize::new(0);
    let runs = || {
        let mut held = Vec::new();
        while let Some(target) = targets.get(next.fetch_add(1, Ordering::Relaxed)) {
            held.push(short_run(target)?);
        }
        Ok(held)
    };
    let processors = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        let threads: Vec<_> = (0..processors).map(|_| scope.spawn(runs)).collect();
        let mut held = Vec::new();
        for thread in threads {
            let runs: Result<Vec<bool>> = thread
                .join()
                .map_err(|_| anyhow!("a thread of the fuzzer has panicked"))?;
            held.extend(runs?);
        }
        Ok(held)
    })
}

fn short_run(target: &str) -> Result<bool> {
    let corpus = folder().join("short").join(target);
    // What an earlier run has kept would change this one.
    if corpus.exists() {
        fs::remove_dir_all(&corpus).with_context(|| format!("removing {}", corpus.display()))?;
    }
    fs::create_dir_all(&corpus).with_context(|| format!("making {}", corpus.display()))?;
    let inputs = inputs(target);
    let mut command = run_command(target, &corpus)?;
    // What was compared has addresses in it, which differ from run to run: without it a run can be repeated.
    command.args([
        "-seed=1".to_owned(),
        "-use_cmp=0".to_owned(),
        format!("-runs={inputs}"),
    ]);
    held(target, &format!("{inputs} inputs"), &mut command)
}

/// Runs a target, and tells how many edges of its code it has been on, or what it has found.
fn held(target: &str, much: &str, command: &mut Command) -> Result<bool> {
    say!("{target}: {much}")?;
    let output = command
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("starting `{}`", process::line(command)))?;
    let told = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        say!("{target}: {} edges", edges(&told).unwrap_or("no"))?;
    } else {
        // libFuzzer is talkative; what it says is of interest only now.
        say!("{told}")?;
        say!("{target}: again by `{} FILE`", program(target)?.display())?;
    }
    Ok(output.status.success())
}

/// The last number of edges of which libFuzzer has told.
fn edges(told: &str) -> Option<&str> {
    told.rsplit_once(" cov: ")?.1.split_whitespace().next()
}

/// A target that keeps what is new in `corpus`.
fn run_command(target: &str, corpus: &Path) -> Result<Command> {
    let artifacts = folder().join("found");
    fs::create_dir_all(&artifacts).with_context(|| format!("making {}", artifacts.display()))?;
    let longest = match target {
        "data_sheet" => LONGEST_DATA_SHEET,
        _ => LONGEST,
    };
    let mut command = Command::new(program(target)?);
    // Some inputs of `master` took more than ten seconds of a PC that had ten times as much to do as it can.
    command
        .arg(corpus)
        .args([format!("-max_len={longest}")])
        .args(["-len_control=0", "-timeout=60"])
        .arg(format!(
            "-artifact_prefix={}",
            artifacts.join(format!("{target}-")).display()
        ));
    let seeds = folder().join("seeds").join(target);
    if seeds.is_dir() {
        command.arg(seeds);
    }
    Ok(command)
}

/// The names of the targets, each a file in `fuzz/fuzz_targets`.
fn targets() -> Result<Vec<String>> {
    let folder = place::root().join("fuzz/fuzz_targets");
    let files = fs::read_dir(&folder).with_context(|| format!("reading {}", folder.display()))?;
    let mut names: Vec<String> = files
        .filter_map(|file| Some(file.ok()?.path().file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    Ok(names)
}

fn manifest() -> PathBuf {
    place::root().join("fuzz/Cargo.toml")
}

/// Where the targets are built, apart from everything else, as their flags are their own.
fn folder() -> PathBuf {
    place::target().join("fuzz")
}

fn program(target: &str) -> Result<PathBuf> {
    Ok(folder().join(host()?).join("release").join(target))
}

/// The target triple of this PC.
fn host() -> Result<String> {
    let mut rustc = Command::new("rustc");
    rustc.arg("-vV").current_dir(place::root());
    process::ask(&mut rustc)
        .and_then(|text| {
            text.lines()
                .find_map(|line| line.strip_prefix("host: ").map(str::to_owned))
        })
        .ok_or_else(|| refuse("`rustc -vV` does not tell the host"))
}

#[cfg(test)]
mod tests {
    use super::edges;

    #[test]
    fn the_last_number_of_edges_counts() {
        let told = "#2\tINITED cov: 5 ft: 5 corp: 1/1b\n#9\tDONE   cov: 12 ft: 14 corp: 2/2b\n";
        assert_eq!(edges(told), Some("12"));
        assert_eq!(edges("Done 9 runs in 0 second(s)"), None);
    }
}

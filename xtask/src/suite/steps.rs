//! The steps of the test run, and what each of them needs.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};
use clap::ValueEnum;

use super::count::Count;
use super::programs;
use crate::firmware::{Image, PROFILE, TARGET};
use crate::product::{self, Product};
use crate::socketcan::{self, Socketcan};
use crate::words::{one_line, say};
use crate::{book, fuzz, place, process, setup};

/// A part of the test run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Step {
    /// Formatting
    Format,
    /// Clippy, on the PC and on the target
    Lint,
    /// Documentation without a warning
    Docs,
    /// Rust tests on the PC
    Host,
    /// The book, and every link in it
    Book,
    /// Fuzzing, for a short while
    Fuzz,
    /// The images for the target, and the proof that they contain no panic path
    Firmware,
    /// Python-canopen and node-canopen against the virtual drive, and the data sheets
    Python,
    /// Python-canopen against the image of the board, on a model of its chip
    Board,
    /// Python-canopen against the firmware in QEMU
    Qemu,
    /// Python-canopen against the virtual drive on a real SocketCAN
    Socketcan,
}

impl Step {
    /// In the order in which they are told: what is quick and fails often first.
    pub const ALL: [Self; 11] = [
        Self::Format,
        Self::Lint,
        Self::Docs,
        Self::Host,
        Self::Book,
        Self::Fuzz,
        Self::Firmware,
        Self::Python,
        Self::Board,
        Self::Qemu,
        Self::Socketcan,
    ];

    /// Does it look at the text only?
    pub fn is_lint(self) -> bool {
        matches!(self, Self::Format | Self::Lint | Self::Docs)
    }

    /// What the step is about, in a few words.
    pub fn subject(self) -> &'static str {
        match self {
            Self::Format => "is everything formatted",
            Self::Lint => "clippy on the PC and on the target",
            Self::Docs => "documentation without a warning",
            Self::Host => "Rust tests on the PC",
            Self::Book => "docs/ as one site, its links and drawings",
            Self::Fuzz => "devices, drive, master, server and readers under a fuzzer",
            Self::Firmware => "images for the target, no panic path",
            Self::Python => {
                "python-canopen, node-canopen and axis402 against the virtual drive, data sheets"
            }
            Self::Board => "the flashed image on a model of its chip, register by register",
            Self::Qemu => "python-canopen and axis402 against the firmware in QEMU",
            Self::Socketcan => "python-canopen and axis402 against the virtual drive on SocketCAN",
        }
    }

    /// Does it start programs and watch them, once they are built?
    pub fn is_played(self) -> bool {
        matches!(
            self,
            Self::Python | Self::Board | Self::Qemu | Self::Socketcan
        )
    }

    fn needs_target(self) -> bool {
        matches!(self, Self::Lint | Self::Firmware | Self::Board | Self::Qemu)
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            self.to_possible_value()
                .as_ref()
                .map_or("", |value| value.get_name()),
        )
    }
}

/// What was found or installed for the steps.
#[derive(Debug)]
pub struct Ready {
    /// The Python with everything that the tests need.
    python: PathBuf,
    /// The packages of Node.js.
    node: PathBuf,
    /// Where a real SocketCAN is, or why there is none.
    socketcan: Result<Socketcan, String>,
}

impl Ready {
    /// Installs what the steps need.
    ///
    /// # Errors
    /// When something is missing and may not be installed. A missing SocketCAN is no error.
    pub fn install(steps: &[Step]) -> Result<Self> {
        if steps.iter().any(|step| step.needs_target()) {
            setup::rust_target()?;
        }
        if steps.contains(&Step::Qemu) {
            setup::emulator()?;
        }
        if steps.contains(&Step::Book) {
            setup::mdbook()?;
        }
        if steps.contains(&Step::Fuzz) {
            setup::cxx_compiler()?;
        }
        let python = if steps.iter().any(|step| step.is_played()) {
            setup::python_environment()?
        } else {
            PathBuf::new()
        };
        if steps.contains(&Step::Python) || steps.contains(&Step::Qemu) {
            setup::browser()?;
        }
        let node = if steps.contains(&Step::Python) {
            setup::node_packages()?
        } else {
            PathBuf::new()
        };
        let socketcan = if steps.contains(&Step::Socketcan) {
            Socketcan::find().map_err(|error| one_line(&error))
        } else {
            Err("not asked for".to_owned())
        };
        Ok(Self {
            python,
            node,
            socketcan,
        })
    }
}

/// What became of a step in cargo's hands.
#[derive(Debug)]
pub enum Run {
    /// It ran.
    Done(Count),
    /// What it plays with is built.
    Built(Played),
    /// It could not run here, and why.
    Skipped(String),
}

/// A step that starts programs which are built, and watches what they do.
#[derive(Debug)]
pub struct Played {
    step: Step,
    command: Command,
}

impl Played {
    /// Which it is.
    pub fn step(&self) -> Step {
        self.step
    }

    /// Plays these tests from now on, one after the other, and no longer a whole folder.
    pub fn choose(&mut self, tests: &[String]) {
        let mut command = Command::new(self.command.get_program());
        let arguments = self.command.get_args();
        command
            .args(arguments.filter(|word| FOLDERS.iter().all(|folder| word != folder)))
            .args(["--numprocesses", "0"])
            .args(tests);
        for (name, value) in self.command.get_envs() {
            if let Some(value) = value {
                command.env(name, value);
            }
        }
        command.current_dir(place::root());
        self.command = command;
    }

    /// Plays it; before each line of its output stands its name.
    ///
    /// # Errors
    /// When a program cannot be started.
    pub fn play(&mut self, ready: &Ready) -> Result<Count> {
        let name = self.step.to_string();
        say!("{name:<9} $ {}", process::line(&self.command))?;
        let mut count = Count::default();
        let take = |line: &str| {
            count.watch(line);
            say!("{name:<9} | {line}")
        };
        let succeeded = match &ready.socketcan {
            Ok(socketcan) if self.step == Step::Socketcan => {
                socketcan::run(socketcan, &mut self.command, take)?
            }
            _ => process::stream(&mut self.command, take)?.success(),
        };
        Ok(count.close(succeeded))
    }
}

/// Runs what is cargo's of a step.
///
/// # Errors
/// When a program cannot be started.
pub fn run(step: Step, ready: &Ready) -> Result<Run> {
    let count = match step {
        Step::Format => checks([cargo(&["fmt", "--all", "--check"]), modules_formatted()])?,
        Step::Lint => checks(lints())?,
        Step::Docs => checks(documentation())?,
        Step::Host => {
            let workspace = ["test", "--workspace", "--exclude", "app", "--no-fail-fast"];
            let mut count = tests(&mut cargo(&workspace))?;
            // What is not built in by default.
            let limited_jerk = [
                "test",
                "-p",
                "cia402",
                "-p",
                "motion",
                "--lib",
                "--no-fail-fast",
            ];
            let feature = ["--features", "cia402/limited-jerk"];
            count += tests(cargo(&limited_jerk).args(feature))?;
            // What a small device leaves out: the bus sees the same.
            let small = [
                "test",
                "-p",
                "canopen",
                "--no-default-features",
                "--tests",
                "--no-fail-fast",
            ];
            count += tests(&mut cargo(&small))?;
            let linear = [
                "test",
                "-p",
                "motion",
                "--no-default-features",
                "--lib",
                "--no-fail-fast",
            ];
            count += tests(&mut cargo(&linear))?;
            count
        }
        Step::Book => match book::make(true) {
            Ok(_) => Count::of(1, 0),
            Err(error) => {
                say!("{}", one_line(&error))?;
                Count::of(0, 1)
            }
        },
        Step::Fuzz => {
            let built = checks(fuzz::build_commands()?)?;
            if built.failed > 0 {
                built
            } else {
                let held = fuzz::short_runs()?;
                let passed = held.iter().filter(|held| **held).count();
                Count::of(passed, held.len() - passed)
            }
        }
        Step::Firmware => images()?,
        Step::Python => {
            let mut command = against(&ready.python, "virtual");
            command.args(AT_ONCE).arg("--node-modules").arg(&ready.node);
            return played(step, [programs::build_command()], command);
        }
        Step::Board => {
            let mut command = pytest(&ready.python, FOLDERS[1]);
            command.arg("--image").arg(Image::Board.path());
            if let Err(error) = product::chips(&mut command) {
                say!("{}", one_line(&error))?;
                return Ok(Run::Done(Count::of(0, 1)));
            }
            command.arg("--plant").arg(place::kept("stepped_axis"));
            command.arg("--tuner").arg(place::kept("stepped_tune"));
            let builds = [Image::Board.build_command()?, programs::build_command()];
            return played(step, builds, command);
        }
        Step::Qemu => {
            let mut command = against(&ready.python, "firmware");
            command.args(AT_ONCE).arg("--image").arg(Image::Qemu.path());
            for product in Product::all() {
                if let Err(error) = Image::Qemu.build_as(Some(&product)) {
                    say!("{}", one_line(&error))?;
                    return Ok(Run::Done(Count::of(0, 1)));
                }
            }
            let builds = [Image::Qemu.build_command()?, programs::build_command()];
            return played(step, builds, command);
        }
        Step::Socketcan => match &ready.socketcan {
            Err(why) => return Ok(Run::Skipped(why.clone())),
            Ok(_) => {
                let command = against(&ready.python, "socketcan");
                return played(step, [programs::build_command()], command);
            }
        },
    };
    Ok(Run::Done(count))
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = place::cargo();
    command.args(arguments);
    command
}

/// `cargo fmt` does not reach the modules of products, which are taken in by generated code.
fn modules_formatted() -> Command {
    let modules = Product::all().into_iter().map(|product| product.module());
    let mut command = Command::new("rustfmt");
    command
        .args(["--edition", "2024", "--check"])
        .args(modules.filter(|module| module.exists()))
        .current_dir(place::root());
    command
}

/// Builds what a step plays with.
fn played(step: Step, builds: impl IntoIterator<Item = Command>, command: Command) -> Result<Run> {
    let built = checks(builds)?;
    if built.failed > 0 {
        return Ok(Run::Done(built));
    }
    match step {
        Step::Board => {
            Image::Board.keep()?;
            programs::keep()?;
        }
        Step::Qemu => {
            Image::Qemu.keep()?;
            programs::keep()?;
        }
        _ => programs::keep()?,
    }
    Ok(Run::Built(Played { step, command }))
}

fn lints() -> Vec<Command> {
    let strict = |mut command: Command| {
        command.args(["--", "-D", "warnings"]);
        command
    };
    // In the profile in which the images are built: the generator and the macros are then built once for both.
    let app = || {
        let mut command = cargo(&["clippy", "--profile", PROFILE, "--package", "app", "--bins"]);
        command.args(["--target", TARGET]);
        command
    };
    let with = |features| {
        let mut command = app();
        command.args(["--no-default-features", "--features", features]);
        command
    };
    let host = cargo(&["clippy", "--workspace", "--exclude", "app", "--all-targets"]);
    let boards = ["odrive36", "stepper405", "qemu"].map(with);
    let all = [host, app()].into_iter().chain(boards);
    all.map(strict).collect()
}

fn documentation() -> [Command; 1] {
    let mut host = cargo(&["doc", "--workspace", "--exclude", "app", "--no-deps"]);
    host.env("RUSTDOCFLAGS", "-D warnings");
    [host]
}

/// Builds every image of the drive, and the dictionaries of the other data sheets; each is one check. Those without a panic path link only
/// if none is left in the core, or in the module of a product.
fn images() -> Result<Count> {
    let mut dictionaries = cargo(&["build", "--profile", PROFILE, "--package", "products"]);
    dictionaries.args(["--target", TARGET]);
    let mut sum = checks([dictionaries])?;
    for product in Product::all() {
        let mut command = Image::NoPanicServo.build_command()?;
        product.choose(&mut command);
        sum += checks([command])?;
    }
    for image in [
        Image::NoPanic,
        Image::NoPanicServo,
        Image::Board,
        Image::Odrive,
        Image::Odrive40khz,
        Image::Stepper,
        Image::Compact,
        Image::Qemu,
    ] {
        let count = checks([image.build_command()?])?;
        if count.failed == 0 {
            image.keep()?;
        }
        sum += count;
    }
    Ok(sum)
}

/// Runs commands that are one check each.
fn checks(commands: impl IntoIterator<Item = Command>) -> Result<Count> {
    let mut sum = Count::default();
    for mut command in commands {
        say!("$ {}", process::line(&command))?;
        sum += Count::check(process::run(&mut command)?);
    }
    Ok(sum)
}

/// Runs a test runner and counts what it says.
fn tests(command: &mut Command) -> Result<Count> {
    say!("$ {}", process::line(command))?;
    let mut count = Count::default();
    let status = process::stream(command, |line| {
        count.watch(line);
        say!("{line}")
    })?;
    Ok(count.close(status.success()))
}

/// Each of these tests starts devices of its own on buses of their own, so two run at once. Those on SocketCAN share the only bus.
const AT_ONCE: [&str; 2] = ["--numprocesses", "2"];

/// Where the Python tests are: those against any device, and those on the model of the board.
const FOLDERS: [&str; 2] = ["tests/python", "tests/machine"];

/// The Python tests in one folder.
fn pytest(python: &Path, folder: &str) -> Command {
    let mut command = Command::new(python);
    // Python's own cache files stay out of the source tree.
    command
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(place::root());
    command.args(["-m", "pytest", "--color=no", folder]);
    command
}

/// The Python tests that are for several targets, against one of them.
fn against(python: &Path, target: &str) -> Command {
    let mut command = pytest(python, FOLDERS[0]);
    command.args(["--target", target]);
    command
        .arg("--sim")
        .arg(place::kept("sim"))
        .arg("--stepped")
        .arg(place::kept("stepped_drive"))
        .arg("--axis402")
        .arg(place::kept("axis402"))
        .arg("--od-gen")
        .arg(place::kept("od-gen"))
        .arg("--io-device")
        .arg(place::kept("io_device"))
        .arg("--plant-trace")
        .arg(place::kept("plant_trace"))
        .arg("--panel")
        .arg(place::kept("axis402-panel"))
        .arg("--xtask")
        .arg(place::kept("xtask"));
    command
}

/// The test that makes a picture of each page of the panel, and keeps them in `folder`.
///
/// # Errors
/// When what it needs is missing and may not be installed, or the panel cannot be built.
pub fn panel_pictures(folder: &Path) -> Result<Command> {
    let python = setup::python_environment()?;
    setup::browser()?;
    if !process::run(&mut programs::build_command())?.success() {
        bail!("the panel cannot be built");
    }
    programs::keep()?;
    let mut command = against(&python, "virtual");
    command.args(["-k", "picture", "--pictures"]).arg(folder);
    Ok(command)
}

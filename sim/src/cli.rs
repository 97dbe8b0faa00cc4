//! The command line. Every mistake in it is one line on standard error and exit code 2.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canopen::settings::{Switches, Wish};
use canopen::{BitTiming, Configuration, NodeId};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgGroup, Args, Parser, Subcommand};
use master::axis402::panel;
use master::command_line::{bit_rate, fail, note, refused};
use master::scope;
use master::system_error::plain;
use od_gen::{files, standard_output};

use crate::demo::{self, Demo};
use crate::drive::Setup;
use crate::flash::{Contents, Flash};
use crate::plan;
use crate::plant::{AXES, Axis, ServoAxisData};
use crate::products::{self, Product};
use crate::serve::{Service, serve};

/// The name in front of each message.
const PROGRAM: &str = "sim";

/// The virtual CANopen drive Axis402.
#[derive(Debug, Parser)]
#[command(name = "sim", version, about)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Watch a master commission an unconfigured drive and move it (the default)
    Demo(DemoArguments),
    /// Run a drive for masters of other programs until stopped
    Serve(ServeArguments),
    /// Plan a move, play its pulses and measure how well they follow the plan
    Plan(plan::Arguments),
    /// Record what a drive does, and show it
    Scope(scope::Arguments),
}

#[derive(Debug, Default, Args)]
struct DemoArguments {
    /// Write the picture of the move as SVG
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Instead, see a drive with a motor and move it yourself, in the browser
    #[arg(long, conflicts_with_all = ["plot", "node_id", "product"])]
    panel: bool,
    /// The node-ID that the master gives to the drive
    #[arg(long, value_name = "N", default_value_t = demo::NODE_ID, value_parser = clap::value_parser!(u8).range(1..=127))]
    node_id: u8,
    /// The drive of another maker
    #[arg(long, value_name = "NAME", value_parser = product())]
    product: Option<Product>,
    /// The drive on a ready axis whose motor is moved by its current
    #[arg(long, value_name = "NAME", value_parser = axis())]
    axis: Option<ServoAxisData>,
    /// The motor is moved by pulses, though the product has an axis of its own
    #[arg(long, conflicts_with = "axis")]
    pulses: bool,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("bus").required(true).multiple(true)))]
struct ServeArguments {
    /// Serve SLCAN on this TCP address, for several clients at once
    #[arg(long, value_name = "ADDRESS:PORT", group = "bus")]
    slcan: Option<String>,
    /// Join this CAN interface (Linux)
    #[arg(long, value_name = "INTERFACE", group = "bus")]
    socketcan: Option<String>,
    /// Be the drive of another maker
    #[arg(long, value_name = "NAME", value_parser = product())]
    product: Option<Product>,
    /// Start with this node-ID, whatever is stored
    #[arg(long, value_name = "N", conflicts_with = "unconfigured", value_parser = clap::value_parser!(u8).range(1..=127))]
    node_id: Option<u8>,
    /// Start without a node-ID, whatever is stored
    #[arg(long)]
    unconfigured: bool,
    /// Start with this bit rate in kbit/s, whatever is stored (1000, 800, 500, 250, 125, 50, 20, 10 or auto)
    #[arg(long, value_name = "KBIT", value_parser = bit_timing)]
    bitrate: Option<BitTiming>,
    /// What the two rotary switches of the board read, hexadecimal: 01 to 7F the node-ID, 80 more for 1 Mbit/s whatever is
    /// stored; 00 leaves both to what is stored
    #[arg(long, value_name = "HEX", value_parser = switch_reading)]
    switches: Option<u16>,
    /// Power up with the factory reset input held: what was stored is forgotten
    #[arg(long)]
    factory_reset: bool,
    /// Keep what LSS stores in this file
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,
    /// Give the drive the axis in this file: switches, end stops, motor or servo, load, supply (docs/plant.md; ready ones in sim/plants)
    #[arg(long, value_name = "FILE.toml")]
    plant: Option<PathBuf>,
    /// Be the drive on a ready axis whose motor is moved by its current: docs/servo.md
    #[arg(long, value_name = "NAME", value_parser = axis(), conflicts_with = "plant")]
    axis: Option<ServoAxisData>,
    /// The motor is moved by pulses, though the product has an axis of its own
    #[arg(long, conflicts_with = "axis")]
    pulses: bool,
    /// Serial number (1018h:4), decimal or 0x and hexadecimal
    #[arg(long, value_name = "N", default_value = "1", value_parser = serial_number)]
    serial: u32,
    /// Tell on standard error what the node does
    #[arg(long, short)]
    verbose: bool,
}

/// Runs the command line; returns the exit code.
pub fn run(arguments: impl IntoIterator<Item = std::ffi::OsString>) -> ExitCode {
    files::outlive_limit();
    let command_line = match CommandLine::try_parse_from(arguments) {
        Ok(command_line) => command_line,
        // Of `serve` nothing else is required.
        Err(error) if is_without_bus(&error) => {
            return fail(
                PROGRAM,
                "a bus is missing: --slcan ADDRESS:PORT or --socketcan INTERFACE",
            );
        }
        Err(error) => return refused::<CommandLine>(PROGRAM, &error),
    };
    match command_line.command {
        Some(Command::Serve(arguments)) => match service(arguments).and_then(serve) {
            Ok(()) => ExitCode::SUCCESS,
            Err(problem) => fail(PROGRAM, &problem),
        },
        Some(Command::Demo(arguments)) => run_demo(arguments),
        Some(Command::Plan(arguments)) => {
            conclude_plan(plan::show(&arguments, &mut standard_output::lock()))
        }
        Some(Command::Scope(arguments)) => match scope::run(&arguments) {
            Ok(()) => ExitCode::SUCCESS,
            Err(problem) => {
                if let Some(line) = problem.line() {
                    fail(PROGRAM, &line);
                }
                ExitCode::from(problem.code())
            }
        },
        None => run_demo(DemoArguments {
            node_id: demo::NODE_ID,
            ..DemoArguments::default()
        }),
    }
}

/// Whether `serve` has not been given a bus.
fn is_without_bus(error: &clap::Error) -> bool {
    let missing = error.get(ContextKind::InvalidArg);
    let is_bus = |missing: &String| missing.contains("--slcan");
    error.kind() == ErrorKind::MissingRequiredArgument
        && matches!(missing, Some(ContextValue::Strings(missing)) if missing.iter().any(is_bus))
}

fn run_demo(arguments: DemoArguments) -> ExitCode {
    if arguments.panel {
        let axis = arguments
            .axis
            .map(|axis| ["--axis".into(), axis.name.into()]);
        let arguments = ["--virtual".into()].into_iter();
        return panel(PROGRAM, arguments.chain(axis.into_iter().flatten()));
    }
    let demo = Demo {
        node_id: arguments.node_id,
        product: arguments.product,
        axis: chosen_axis(arguments.axis, arguments.pulses, arguments.product),
        plot: arguments.plot,
    };
    conclude(demo::show(&demo, &mut standard_output::lock()))
}

/// The exit code of a demonstration; a failure is told in one line.
pub(crate) fn conclude(result: Result<(), demo::Problem>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read the output has seen enough.
        Err(demo::Problem::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(problem @ (demo::Problem::Picture(..) | demo::Problem::Output(_))) => {
            fail(PROGRAM, &problem.to_string())
        }
        Err(problem) => {
            fail(PROGRAM, &problem.to_string());
            ExitCode::FAILURE
        }
    }
}

/// The exit code of a planned move: everything that can go wrong is in the command line.
fn conclude_plan(result: Result<(), plan::Problem>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read the output has seen enough.
        Err(plan::Problem::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            ExitCode::SUCCESS
        }
        Err(problem) => fail(PROGRAM, &problem.to_string()),
    }
}

/// The ready axis that was asked for, or that of the product.
fn chosen_axis(
    asked: Option<ServoAxisData>,
    pulses: bool,
    product: Option<Product>,
) -> Option<ServoAxisData> {
    let own = || product.filter(|_| !pulses).and_then(Product::axis);
    asked.or_else(own)
}

/// What `serve` is to run.
fn service(arguments: ServeArguments) -> Result<Service, String> {
    let flash = match &arguments.store {
        Some(path) => stored_in(path)?,
        None => Flash::in_memory(),
    };
    let mut store = flash.into_store();
    if arguments.factory_reset {
        store
            .forget()
            .map_err(|error| format!("cannot empty the store: {error}"))?;
    }
    let stored = store
        .load()
        .or_else(|error| match error {
            // This is told.
            store::Error::Damaged => Ok(None),
            error => Err(error),
        })
        .map_err(|error| format!("cannot read the store: {error}"))?
        .or(arguments.product.map(Product::factory))
        .unwrap_or_default();
    let node_id = match arguments.node_id {
        Some(number) => NodeId::new(number).unwrap_or(stored.node_id),
        None if arguments.unconfigured => NodeId::UNCONFIGURED,
        None => stored.node_id,
    };
    let axis = match arguments.plant.as_deref() {
        Some(plant) if arguments.product.is_some() => Some(Axis::read_bare(plant)?),
        Some(plant) => Some(Axis::read(plant)?),
        None => chosen_axis(arguments.axis, arguments.pulses, arguments.product).map(|servo| {
            if arguments.product.is_some() {
                Axis::bare_servo(&servo)
            } else {
                Axis::servo(&servo)
            }
        }),
    };
    Ok(Service {
        slcan: arguments.slcan,
        socketcan: arguments.socketcan,
        drive: products::drive(
            arguments.product,
            Setup {
                serial_number: arguments.serial,
                settings: Some(Configuration {
                    node_id,
                    bit_timing: arguments.bitrate.unwrap_or(stored.bit_timing),
                }),
                switches: arguments
                    .switches
                    .map_or(Wish::NOTHING, |reading| Switches::ROTARY.wish(reading)),
                build: Wish::NOTHING,
                store,
                axis,
            },
        ),
        verbose: arguments.verbose,
    })
}

/// The flash in a file. Tells if somebody else has written into it; the drive tells masters (6310h).
fn stored_in(path: &Path) -> Result<Flash, String> {
    let flash = Flash::in_file(path)
        .map_err(|error| format!("cannot use the store {}: {}", path.display(), plain(error)))?;
    match flash.contents() {
        Contents::Whole => {}
        Contents::Damaged => note(&format!(
            "the store {} is damaged: what is lost has the values of the data sheet until it is saved again",
            path.display()
        )),
        Contents::Foreign => note(&format!(
            "the store {} holds something else than parameters: nothing is taken from it, and nothing is saved to it",
            path.display()
        )),
    }
    Ok(flash)
}

/// Products by their names.
fn product() -> impl TypedValueParser<Value = Product> {
    PossibleValuesParser::new(Product::names()).try_map(|name| {
        let product = Product::named(&name);
        product.ok_or("there is no such product")
    })
}

/// Ready axes by their names, each with the machine behind its motor.
pub fn axis() -> impl TypedValueParser<Value = ServoAxisData> {
    PossibleValuesParser::new(AXES.map(|axis| axis.name)).try_map(|name| {
        let axis = ServoAxisData::named(&name).map(ServoAxisData::at_work);
        axis.ok_or("there is no such axis")
    })
}

fn bit_timing(text: &str) -> Result<BitTiming, String> {
    if text == "auto" {
        return Ok(BitTiming::Automatic);
    }
    let bit_rate = bit_rate(text).map_err(|problem| format!("{problem}, auto"))?;
    Ok(BitTiming::Fixed(bit_rate))
}

fn switch_reading(text: &str) -> Result<u16, String> {
    let digits = text.strip_prefix("0x").unwrap_or(text);
    match u16::from_str_radix(digits, 16) {
        Ok(reading) if reading <= 0xFF => Ok(reading),
        _ => Err("two hexadecimal digits, 00 to FF".to_owned()),
    }
}

fn serial_number(text: &str) -> Result<u32, String> {
    let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => text.parse(),
    };
    number.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The axis of what `serve` runs with these arguments: the counts of its encoder in a turn, if its motor is moved by its current.
    fn encoder(more: &[&str]) -> Option<u32> {
        let serve = ["sim", "serve", "--slcan", "127.0.0.1:0"];
        let line = CommandLine::try_parse_from(serve.iter().chain(more)).unwrap();
        let Some(Command::Serve(arguments)) = line.command else {
            panic!("{more:?}")
        };
        let mut drive = service(arguments).unwrap().drive;
        let servo = drive.plant_mut().servo_mut()?;
        Some(servo.loops().motor().counts)
    }

    #[test]
    fn a_product_is_served_on_the_axis_of_its_binding_unless_it_is_told_another() {
        let mut servos = 0;
        for name in Product::names() {
            let own = Product::named(name).unwrap().axis();
            assert_eq!(encoder(&["--product", name]).is_some(), own.is_some());
            assert_eq!(encoder(&["--product", name, "--pulses"]), None, "{name}");
            servos += usize::from(own.is_some());
        }
        assert_eq!(servos, 3, "all but the Nanotec, whose encoder is an option");
        assert_eq!(encoder(&["--product", "lmd"]), Some(51_200));
        assert_eq!(encoder(&[]), None);
        assert_eq!(encoder(&["--axis", "nema23"]), Some(4_096));
        let plant = concat!(env!("CARGO_MANIFEST_DIR"), "/plants/");
        let plant = std::fs::read_dir(plant).unwrap().next().unwrap().unwrap();
        let plant = plant.path().into_os_string().into_string().unwrap();
        assert_eq!(encoder(&["--product", "lmd", "--plant", &plant]), None);
    }
}

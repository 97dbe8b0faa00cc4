//! The program: command line, adapter, exit code.

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::thread;

use canopen::{BitRate, Duration};
use clap::Parser;
use od_gen::Report;
use od_gen::dcf;
use od_gen::files;
use od_gen::model::{Commissioning, FileKind};
use od_gen::standard_output;

use super::arguments::{Bus, Command, CommandLine, Lss, Od, Sheet};
use super::{BitRateSwitch, Console, Node, Numbering, Problem, Setting, Tuning, Watch};
use crate::bus::live::{Incoming, LiveBus};
use crate::bus::slcan_client::Place;
use crate::command_line;
use crate::data_sheet::DataSheet;
use crate::system_error::plain;
use crate::{Line, Master, Real};

/// How long a command may take, whatever devices send. Four megabytes in segments take twenty minutes at 125 kbit/s.
const LONGEST: Duration = Duration::from_ticks(3_600_000_000);

/// Runs the command line; returns the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    files::outlive_limit();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    // Its options are its own.
    if arguments.get(1).is_some_and(|word| word == "panel") {
        return super::panel("axis402", arguments.into_iter().skip(2));
    }
    let command_line = match CommandLine::try_parse_from(arguments) {
        Ok(command_line) => command_line,
        Err(error) => return command_line::refused::<CommandLine>("axis402", &error),
    };
    if matches!(command_line.command, Command::Panel { .. }) {
        let order = "`panel` stands before its options: axis402 panel --slcan ADDRESS:PORT";
        return command_line::fail("axis402", order);
    }
    let (mut output, mut progress) = (standard_output::lock(), io::stderr().lock());
    let is_terminal = progress.is_terminal();
    let mut console = Console::new(&mut output, &mut progress, is_terminal);
    let result = go_on_bus(&command_line.bus).and_then(|mut master| {
        // To watch has no end of its own.
        if !matches!(command_line.command, Command::Monitor { .. }) {
            master.set_time_limit(LONGEST);
        }
        let result = perform(&mut master, &command_line, &mut console);
        explain(result, master.line_mut())
    });
    drop(console);
    let Err(problem) = result else {
        return ExitCode::SUCCESS;
    };
    if let Some(line) = problem.line() {
        // Nobody may be reading.
        let _ = writeln!(progress, "axis402: {line}");
    }
    ExitCode::from(problem.code())
}

/// A master on the bus that the command line names. A signal to end the program stops it ([`crate::LineDown::stopped`]).
///
/// # Errors
/// [`Problem::Usage`] if no bus is named, more than one, or one that is not there.
pub fn go_on_bus(arguments: &Bus) -> Result<Master<Real>, Problem> {
    let mut bus = LiveBus::new();
    match (&arguments.slcan, &arguments.socketcan) {
        (Some(_), Some(_)) => {
            let both = "one bus at a time: --slcan or --socketcan";
            return Err(Problem::Usage(both.to_owned()));
        }
        (Some(slcan), None) => {
            let place = place(slcan, arguments.baud);
            bus.use_adapter(&place, Some(arguments.bitrate))
                .map_err(|error| {
                    let reason = plain(error);
                    Problem::Usage(format!("cannot use the SLCAN adapter {slcan}: {reason}"))
                })?;
        }
        (None, Some(interface)) => bus.join_socketcan(interface).map_err(|error| {
            let reason = plain(error);
            Problem::Usage(format!(
                "cannot open the CAN interface {interface}: {reason}"
            ))
        })?,
        (None, None) => {
            let missing =
                "a bus is missing: --slcan PORT, --slcan ADDRESS:PORT or --socketcan INTERFACE";
            return Err(Problem::Usage(missing.to_owned()));
        }
    }
    stop_by_signal(bus.stopper(), arguments.timeout.into());
    let mut master = Master::on(Real::new(bus));
    master.set_answer_time(milliseconds(arguments.timeout));
    Ok(master)
}

/// Lets a signal end the program. Whoever listens to the bus hears it and puts devices right first. Whoever waits for what
/// is piped in does not: a second signal ends the program at once, and so does a time in which any answer would be there.
fn stop_by_signal(stopper: SyncSender<Incoming>, timeout: u64) {
    const GRACE: std::time::Duration = std::time::Duration::from_secs(2);
    let end = || std::process::exit(Problem::Stopped.code().into());
    let mut is_first = true;
    // Without it a person still ends the program, but devices may be left in configuration state.
    let _ = ctrlc::set_handler(move || {
        let _ = stopper.try_send(Incoming::Stop);
        if !std::mem::take(&mut is_first) {
            end();
        }
        let grace = GRACE + std::time::Duration::from_millis(timeout);
        thread::spawn(move || {
            thread::sleep(grace);
            end();
        });
    });
}

/// A serial port, unless it is an address with the number of a port.
fn place(text: &str, baud_rate: u32) -> Place {
    let port = text.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
    match port {
        Some(Ok(_)) if !text.starts_with('/') => Place::Tcp(text.to_owned()),
        _ => Place::Serial(text.to_owned(), baud_rate),
    }
}

/// Silence has a reason when the adapter could not send.
pub(crate) fn explain(result: Result<(), Problem>, line: &Real) -> Result<(), Problem> {
    match result {
        Err(Problem::Failed(text)) if line.refused() > 0 => Err(Problem::Failed(format!(
            "{text} (the adapter refused {} frames: is it connected, and at the right bit rate?)",
            line.refused()
        ))),
        other => other,
    }
}

fn perform<L: Line>(
    master: &mut Master<L>,
    command_line: &CommandLine,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    match &command_line.command {
        Command::Scan => super::scan(master, console),
        Command::Lss(lss) => perform_lss(master, lss, &command_line.bus, console),
        Command::Od(od) => perform_od(master, od, &command_line.bus, console),
        Command::Save { node, group } => {
            let sheet = DataSheet::standard();
            super::save(master, &Node { id: *node, sheet }, *group, console)
        }
        Command::Nmt { command, node } => super::nmt(master, (*command).into(), *node),
        Command::Tune {
            node,
            current,
            bandwidth,
            no_response,
            write,
            plot,
            step,
            json,
            sheet,
        } => {
            let sheet = read_sheet(sheet, console)?;
            let node = Node::meet(master, *node, sheet)?;
            let wanted = Tuning {
                current: current.map(|percent| u16::from(percent) * 10),
                bandwidth: *bandwidth,
                is_short: *no_response,
                writes: *write,
                plot: plot.clone(),
                step: step.clone(),
                json: *json,
            };
            super::tune(master, &node, &wanted, console)
        }
        // It was run before there was a bus.
        Command::Panel { .. } => Ok(()),
        Command::Monitor {
            nodes,
            sheet,
            count,
        } => {
            let sheet = read_sheet(sheet, console)?;
            let nodes = nodes
                .iter()
                .map(|id| Node::meet(master, *id, sheet.clone()));
            let watch = Watch {
                nodes: nodes.collect::<Result<_, _>>()?,
                sheet: sheet.clone().unwrap_or_else(DataSheet::standard),
                count: *count,
            };
            super::monitor(master, &watch, console)
        }
    }
}

fn perform_lss<L: Line>(
    master: &mut Master<L>,
    lss: &Lss,
    bus: &Bus,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    match lss {
        Lss::Find(scan) => {
            master.set_scan_time(milliseconds(scan.step.into()));
            super::find(master, console)
        }
        Lss::Number { first, store, scan } => {
            master.set_scan_time(milliseconds(scan.step.into()));
            let numbering = Numbering {
                first: *first,
                store: !store.no_store,
            };
            super::number(master, numbering, console)
        }
        Lss::Set {
            node_id,
            rate,
            identity,
            store,
        } => {
            let setting = Setting {
                device: *identity,
                node_id: *node_id,
                bit_rate: *rate,
                store: !store.no_store,
            };
            super::set(master, setting, console)
        }
        Lss::Bitrate { rate, delay, store } => {
            let switch = BitRateSwitch {
                to: *rate,
                from: bus.slcan.as_ref().and_then(|_| {
                    let kbit = bus.bitrate.kbit_per_second();
                    BitRate::ALL
                        .into_iter()
                        .find(|rate| rate.kbit_per_second() == kbit)
                }),
                store: !store.no_store,
                delay: milliseconds((*delay).into()),
            };
            super::switch_bit_rate(master, switch, console)
        }
        Lss::Store => super::store_settings(master, console),
    }
}

fn perform_od<L: Line>(
    master: &mut Master<L>,
    od: &Od,
    bus: &Bus,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    match od {
        Od::Read {
            node,
            objects,
            data_type,
            bare,
            output,
            sheet,
        } => {
            let sheet = read_sheet(sheet, console)?;
            let node = Node::meet(master, *node, sheet)?;
            if let Some(file) = output {
                let [object] = objects.as_slice() else {
                    let many = "one object goes into one file";
                    return Err(Problem::Usage(many.to_owned()));
                };
                let bytes = super::fetch(master, &node, object)?;
                return write_file(file, &bytes);
            }
            super::read(master, &node, objects, *data_type, *bare, console)
        }
        Od::Write {
            node,
            object,
            value,
            file,
            data_type,
            sheet,
        } => {
            let sheet = read_sheet(sheet, console)?;
            let bytes = match file {
                Some(file) => Some(files::read(file).map_err(|error| unreadable(file, error))?),
                None => None,
            };
            let node = Node::meet(master, *node, sheet)?;
            match (bytes, value) {
                (Some(bytes), _) => super::put(master, &node, object, &bytes),
                (None, value) => {
                    let value = value.as_deref().unwrap_or_default();
                    super::write(master, &node, object, value, *data_type)
                }
            }
        }
        Od::Dump {
            node,
            output,
            sheet,
        } => {
            let sheet = read_sheet(sheet, console)?;
            let node = Node::meet(master, *node, sheet)?;
            let mut model = super::dump(master, &node, output.is_none(), console)?;
            let Some(file) = output else {
                return Ok(());
            };
            let commissioning = Commissioning {
                node_id: node.id,
                bit_rate: bus.bitrate.kbit_per_second() as u16,
                ..Commissioning::default()
            };
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            dcf::commission(&mut model, commissioning, &name);
            write_file(file, od_gen::print(&model).as_bytes())
        }
        Od::Load { node, file } => {
            let report = report(file, console)?;
            if report.model.kind != FileKind::Dcf {
                let file = file.display();
                return Err(Problem::Usage(format!(
                    "{file} is no DCF: it configures nothing"
                )));
            }
            let sheet = DataSheet::standard();
            super::load(master, &Node { id: *node, sheet }, &report.model, console)
        }
    }
}

pub(crate) fn read_sheet(
    sheet: &Sheet,
    console: &mut Console<'_>,
) -> Result<Option<Arc<DataSheet>>, Problem> {
    let Some(file) = &sheet.eds else {
        return Ok(None);
    };
    read_data_sheet(file, console).map(Some)
}

/// A data sheet. Mistakes in it are told, and the rest is used.
///
/// # Errors
/// [`Problem::Usage`] if it cannot be read, or is none.
pub fn read_data_sheet(file: &Path, console: &mut Console<'_>) -> Result<Arc<DataSheet>, Problem> {
    let report = report(file, console)?;
    Ok(Arc::new(report.model.into()))
}

/// What a file holds. Mistakes in it are no reason to leave a device alone, but they are told.
fn report(file: &Path, console: &mut Console<'_>) -> Result<Report, Problem> {
    let report = Report::read(file).map_err(|error| unreadable(file, error))?;
    if report.model.objects.is_empty() {
        let file = file.display();
        return Err(Problem::Usage(format!(
            "{file} is no data sheet: no objects in it"
        )));
    }
    if report.has_errors() {
        let file = file.display();
        console.remark(&format!(
            "{file} has mistakes (`od-gen check` tells them); the rest is used"
        ));
    }
    Ok(report)
}

fn unreadable(file: &Path, error: io::Error) -> Problem {
    Problem::Usage(format!("cannot read {}: {}", file.display(), plain(error)))
}

fn write_file(file: &Path, bytes: &[u8]) -> Result<(), Problem> {
    files::write(file, bytes).map_err(|error| {
        Problem::Usage(format!("cannot write {}: {}", file.display(), plain(error)))
    })
}

fn milliseconds(count: u32) -> Duration {
    Duration::from_ticks(u64::from(count) * 1_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapter_is_a_port_or_an_address() {
        for address in ["127.0.0.1:2402", "[::1]:2402", "pc:2402"] {
            assert_eq!(place(address, 1), Place::Tcp(address.to_owned()));
        }
        for port in [
            "/dev/ttyACM0",
            "COM3",
            "/dev/serial/by-path/pci-0:1",
            "ttyS0:fast",
        ] {
            assert_eq!(place(port, 9_600), Place::Serial(port.to_owned(), 9_600));
        }
    }
}

//! The program: command line, server, bus, exit code.

use std::ffi::OsString;
use std::io::{self, Write};
use std::net::TcpListener;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;

use clap::Parser;
use master::axis402::{Bus, Console, Problem, go_on_bus, read_data_sheet};
use master::command_line::{fail, note, refused};
use master::system_error::plain;

use crate::arguments::Arguments;
use crate::desk::Desk;
use crate::origin;
use crate::server::{Shared, serve};
use crate::session::{Outlet, Session, Setup};
use crate::virtual_drive::VirtualDrive;

/// The name in front of each message.
const PROGRAM: &str = "axis402 panel";

/// Orders that may wait for the session.
const ORDERS: usize = 32;

/// Runs the command line; returns the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => return refused::<Arguments>(PROGRAM, &error),
    };
    match show(arguments) {
        Ok(()) | Err(Problem::Stopped) => ExitCode::SUCCESS,
        Err(problem) => match problem.line() {
            Some(line) => {
                fail(PROGRAM, &line);
                ExitCode::from(problem.code())
            }
            None => ExitCode::from(problem.code()),
        },
    }
}

fn show(arguments: Arguments) -> Result<(), Problem> {
    let listen = &arguments.listen;
    let busy = |error| Problem::Usage(format!("cannot listen on {listen}: {}", plain(error)));
    let listener = TcpListener::bind(listen).map_err(busy)?;
    listener.set_nonblocking(true).map_err(busy)?;
    let address = listener.local_addr().map_err(busy)?;
    let mut greeting = String::new();
    let (sheets, notice) = data_sheets(&arguments)?;

    let drive = if arguments.is_virtual {
        let drive = VirtualDrive::start(arguments.plant.as_deref(), arguments.axis.as_ref());
        let drive = drive.map_err(Problem::Usage)?;
        greeting += &format!("virtual drive, SLCAN on {}\n", drive.address());
        Some(drive)
    } else {
        None
    };
    let bus = match &drive {
        Some(drive) => Bus::slcan(&drive.address().to_string()),
        None => arguments.bus,
    };
    let master = go_on_bus(&bus)?;

    let token = match address.ip().is_loopback() {
        true => None,
        false => Some(origin::new_token().map_err(Problem::Usage)?),
    };
    greeting += &match &token {
        Some(token) => format!("panel on http://{address}/?token={token}\n"),
        None => format!("panel on http://{address}/\n"),
    };
    let desk = Arc::new(Desk::default());
    let (tickets, orders) = sync_channel(ORDERS);
    let outlet = Outlet::new();
    let setup = Setup {
        title: if arguments.is_virtual {
            "virtual drive".to_owned()
        } else {
            bus.title()
        },
        is_virtual: arguments.is_virtual,
        bit_rate: bus.bit_rate(),
        read_only: arguments.read_only,
        own_node: arguments.own_node,
        sheets,
        notice,
    };
    let shared = Arc::new(Shared {
        desk: Arc::clone(&desk),
        tickets,
        outlet: outlet.clone(),
        read_only: arguments.read_only,
        listen: arguments.listen.clone(),
        token,
    });
    let (ended, end) = tokio::sync::oneshot::channel();
    let session = thread::spawn(move || {
        let mut session = Session::new(master, desk, orders, outlet, setup);
        let result = session.run();
        // The server may have ended before.
        let _ = ended.send(());
        result
    });
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| Problem::Usage(format!("cannot serve: {}", plain(error))))?;
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let mut output = io::stdout().lock();
        // Nobody may be reading; the panel runs all the same.
        let _ = writeln!(output, "{greeting}ready").and_then(|()| output.flush());
        drop(output);
        tokio::select! {
            served = serve(listener, shared) => served,
            _ = end => Ok(()),
        }
    });
    // The session ends when nobody can order anything any more, if it has not ended before.
    drop(runtime);
    let result = session.join();
    served.map_err(|error| Problem::Usage(format!("cannot serve: {}", plain(error))))?;
    match result {
        Ok(Ok(())) => Ok(()),
        Ok(Err(down)) => Err(Problem::Usage(down.to_string())),
        Err(_) => Err(Problem::Failed(
            "the session with the bus has broken down".to_owned(),
        )),
    }
}

/// The data sheets that were named, and what a person should know of them.
fn data_sheets(
    arguments: &Arguments,
) -> Result<(Vec<Arc<master::data_sheet::DataSheet>>, Option<String>), Problem> {
    let (mut output, mut remarks) = (io::sink(), Vec::new());
    let mut console = Console::new(&mut output, &mut remarks, false);
    let sheets = (arguments.eds.iter())
        .map(|file| read_data_sheet(file, &mut console))
        .collect::<Result<_, _>>()?;
    drop(console);
    let remarks = String::from_utf8_lossy(&remarks).trim().to_owned();
    if remarks.is_empty() {
        return Ok((sheets, None));
    }
    note(&remarks);
    Ok((sheets, Some(remarks)))
}

//! `cargo xtask qemu`: the firmware in the emulator, on the bus until it is stopped.

use std::fs;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::emulator::Emulator;
use crate::firmware::{self, Image};
use crate::product::Product;
use crate::refusal::refuse;
use crate::setup;
use crate::words::{plain, say};

/// How long the firmware may take to answer for the first time. It takes half a second on an idle PC.
const START_TIME: Duration = Duration::from_secs(60);

/// Between two looks at the emulator.
const GLANCE: Duration = Duration::from_millis(20);

/// Where and with what the emulator runs.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Serve the CAN bus as SLCAN on this TCP address, for example 127.0.0.1:4000 (one client at a time)
    #[arg(long, value_name = "ADDRESS:PORT")]
    slcan: String,

    /// Keep the parameter store in this folder from run to run; without it every run starts with an empty store
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,

    /// Run this ELF file instead of building the firmware
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,

    /// Be the drive of another maker: a folder of products/
    #[arg(long, value_name = "NAME", conflicts_with = "image")]
    product: Option<Product>,

    /// Input N (1 to 6) is high while the motor is from step FROM to step TO, counted from power-on, both included; without one of them, as far
    /// as it goes. May be given up to 16 times, several times for an input too
    #[arg(long = "input", value_name = "N=FROM..TO", value_parser = mark)]
    inputs: Vec<[u8; 12]>,
}

/// The most marks that the image takes.
const MARKS: usize = 16;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let address = free_address(&arguments.slcan)?;
    if let Some(store) = &arguments.store {
        make_store(store)?;
    }
    let given = arguments
        .image
        .as_deref()
        .map(firmware::given)
        .transpose()?;
    if arguments.inputs.len() > MARKS {
        return Err(refuse(format!("more than {MARKS} times --input")));
    }
    let stop = stop_signal()?;

    let qemu = setup::emulator()?;
    let image = match given {
        Some(image) => image,
        None => {
            setup::rust_target()?;
            Image::Qemu.build_as(arguments.product.as_ref())?
        }
    };
    // Removed at the end, the emulator's end included: it is declared first, so it is dropped last.
    let empty = tempfile::Builder::new()
        .prefix("axis402-")
        .tempdir()
        .context("making an empty parameter store")?;
    let store = arguments.store.as_deref().unwrap_or(empty.path());
    fs::write(store.join("inputs.bin"), arguments.inputs.concat())
        .context("writing what is along the axis")?;

    let mut emulator = Emulator::serve(&qemu, &image, address, store)?;
    let started = Instant::now();
    let mut ready = false;
    loop {
        match stop.recv_timeout(GLANCE) {
            Ok(()) | Err(RecvTimeoutError::Disconnected) => return Ok(ExitCode::SUCCESS),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Some(status) = emulator.ended()? {
            bail!("the emulator ended by itself: {status}");
        }
        if !ready && answers(address) {
            ready = true;
            say!("ready")?;
        }
        if !ready && started.elapsed() > START_TIME {
            bail!(
                "the firmware has not answered on {address} for {} s",
                START_TIME.as_secs()
            );
        }
    }
}

/// A mark along the axis as the image reads it: the input, the first step and the last, each four bytes.
fn mark(text: &str) -> Result<[u8; 12], String> {
    let form = || "not of the form N=FROM..TO".to_owned();
    let (input, range) = text.split_once('=').ok_or_else(form)?;
    let (from, to) = range.split_once("..").ok_or_else(form)?;
    let input: u32 = input.parse().map_err(|_| form())?;
    if !(1..=6).contains(&input) {
        return Err("there are inputs 1 to 6".to_owned());
    }
    let step = |text: &str, missing: i32| match text {
        "" => Ok(missing),
        text => text.parse::<i32>().map_err(|_| form()),
    };
    let mut bytes = [0; 12];
    let numbers = [
        input.to_le_bytes(),
        step(from, i32::MIN)?.to_le_bytes(),
        step(to, i32::MAX)?.to_le_bytes(),
    ];
    bytes.copy_from_slice(&numbers.concat());
    Ok(bytes)
}

/// The address with this name, if it can be served.
fn free_address(name: &str) -> Result<SocketAddr> {
    let cannot = |error| refuse(format!("cannot serve SLCAN on {name}: {}", plain(&error)));
    let addresses: Vec<_> = name.to_socket_addrs().map_err(cannot)?.collect();
    if addresses.iter().any(|address| address.port() == 0) {
        return Err(refuse("--slcan needs a port: 0 is none"));
    }
    // The port is free again when the listener is dropped at the end of the function; QEMU then takes it.
    let listener = TcpListener::bind(&*addresses).map_err(cannot)?;
    listener.local_addr().map_err(cannot)
}

/// Makes the folder of the store, if there is none, and sees whether a file can be written in it.
fn make_store(folder: &Path) -> Result<()> {
    let cannot = |why| refuse(format!("cannot use the store {}: {why}", folder.display()));
    if folder.exists() && !folder.is_dir() {
        return Err(cannot("not a folder".to_owned()));
    }
    fs::create_dir_all(folder).map_err(|error| cannot(plain(&error)))?;
    tempfile::tempfile_in(folder)
        .map(drop)
        .map_err(|error| cannot(plain(&error)))
}

/// Gets a message on SIGINT, SIGTERM and SIGHUP.
fn stop_signal() -> Result<Receiver<()>> {
    let (sender, receiver) = mpsc::channel();
    ctrlc::set_handler(move || {
        // The other end is gone when the program is ending anyway.
        let _ = sender.send(());
    })
    .context("catching the stop signals")?;
    Ok(receiver)
}

/// Does the firmware answer an empty SLCAN line? That something listens would not be enough: QEMU does that before the
/// firmware has started, and what comes in until then is lost. So it is asked a few times.
fn answers(address: SocketAddr) -> bool {
    let Ok(mut stream) = TcpStream::connect_timeout(&address, Duration::from_millis(500)) else {
        return false;
    };
    if stream
        .set_read_timeout(Some(Duration::from_millis(50)))
        .is_err()
    {
        return false;
    }
    (0..10).any(|_| {
        stream.write_all(b"\r").is_ok() && stream.read(&mut [0]).is_ok_and(|count| count > 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(result: Result<impl std::fmt::Debug>) -> String {
        let error = result.unwrap_err();
        assert!(error.is::<crate::refusal::Refusal>(), "{error:?}");
        error.to_string()
    }

    #[test]
    fn an_address_may_be_a_name() {
        let free = TcpListener::bind("localhost:0").unwrap();
        let address = free.local_addr().unwrap();
        drop(free);
        let name = format!("localhost:{}", address.port());
        assert_eq!(free_address(&name).unwrap(), address);
    }

    #[test]
    fn an_address_that_cannot_be_served_is_refused() {
        assert_eq!(
            refusal(free_address("nonsense")),
            "cannot serve SLCAN on nonsense: invalid socket address"
        );
        assert_eq!(
            refusal(free_address("127.0.0.1:0")),
            "--slcan needs a port: 0 is none"
        );
        let busy = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = busy.local_addr().unwrap().to_string();
        assert_eq!(
            refusal(free_address(&address)),
            format!("cannot serve SLCAN on {address}: address already in use")
        );
    }

    #[test]
    fn a_mark_along_the_axis_has_an_input_and_two_ends() {
        let bytes = |numbers: [i32; 3]| numbers.map(i32::to_le_bytes).concat();
        assert_eq!(mark("3=-5..70000").unwrap()[..], bytes([3, -5, 70_000]));
        assert_eq!(mark("1=..-1").unwrap()[..], bytes([1, i32::MIN, -1]));
        assert_eq!(mark("6=0..").unwrap()[..], bytes([6, 0, i32::MAX]));
        for wrong in [
            "",
            "3",
            "3=4",
            "0=1..2",
            "7=1..2",
            "3=a..2",
            "3=1..4000000000",
        ] {
            assert!(mark(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_store_is_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("new").join("store");
        make_store(&inner).unwrap();
        assert!(inner.is_dir());
        assert_eq!(fs::read_dir(&inner).unwrap().count(), 0);

        let file = folder.path().join("notes.txt");
        fs::write(&file, "important").unwrap();
        assert_eq!(
            refusal(make_store(&file)),
            format!("cannot use the store {}: not a folder", file.display())
        );
        assert!(refusal(make_store(&file.join("store"))).ends_with(": not a directory"));
        assert_eq!(fs::read_to_string(&file).unwrap(), "important");
    }
}

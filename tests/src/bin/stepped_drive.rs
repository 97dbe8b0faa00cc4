//! A virtual drive in virtual time for a master that is another program: `tests/python/stepped.py` runs python-canopen so.
//!
//! It reads lines. `604 [8] 40 00 10 00` gives a frame to the bus, in the notation of the cases. `+1000` lets so many microseconds pass,
//! fewer if the drive sends something: it answers with a frame of the drive, if there is one, and with `=` and the present time in
//! microseconds. Nothing else makes time pass. An axis is given as to `sim serve`, by
//! `--plant FILE.toml`; `--basic-device` is the device without a drive whose flash is measured.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use canopen::Duration;
use master::bus::Station;
use sim::drive::{Setup, VirtualDrive};
use sim::plant::Axis;
use tests::line::Line;
use tests::notation::{frame, show};
use tests::{DriveBench, basic};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("stepped_drive: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let axis = match arguments.as_slice() {
        [] => None,
        [option, file] if option == "--plant" => Some(Axis::read(file.as_ref())?),
        [option] if option == "--basic-device" => return step(basic::line()),
        _ => return Err("Usage: stepped_drive [--plant FILE.toml | --basic-device]".into()),
    };
    let device = VirtualDrive::new(Setup {
        axis,
        ..Setup::unconfigured(1)
    });
    // The master gives the node-ID.
    step(DriveBench::new(device, 0))
}

/// Does what the lines say.
fn step<S: Station>(mut device: Line<S>) -> Result<(), Box<dyn Error>> {
    let mut output = io::stdout().lock();
    for line in io::stdin().lines() {
        let line = line?;
        match line.strip_prefix('+') {
            Some(micros) => {
                let heard = device.next(Duration::micros(micros.parse()?));
                if let Some(heard) = heard {
                    writeln!(output, "{}", show(&heard))?;
                }
                writeln!(output, "={}", device.now().ticks())?;
                output.flush()?;
            }
            None => device.queue_frame(frame(&line)),
        }
    }
    Ok(())
}

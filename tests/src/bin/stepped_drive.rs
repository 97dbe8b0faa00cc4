//! A virtual drive in virtual time for a master that is another program: `tests/python/stepped.py` runs python-canopen so.
//!
//! It reads lines. `604 [8] 40 00 10 00` gives a frame to the bus, in the notation of the cases. `+1000` lets so many microseconds pass,
//! fewer if the drive sends something: it answers with a frame of the drive, if there is one, and with `=` and the present time in
//! microseconds. Nothing else makes time pass. An axis is given as to `sim serve`: `stepped_drive --plant FILE.toml`.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use canopen::Duration;
use sim::drive::{Setup, VirtualDrive};
use sim::plant::Axis;
use tests::DriveBench;
use tests::notation::{frame, show};

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
        _ => return Err("Usage: stepped_drive [--plant FILE.toml]".into()),
    };
    let device = VirtualDrive::new(Setup {
        axis,
        ..Setup::unconfigured(1)
    });
    // The master gives the node-ID.
    let mut drive = DriveBench::new(device, 0);
    let mut output = io::stdout().lock();
    for line in io::stdin().lines() {
        let line = line?;
        match line.strip_prefix('+') {
            Some(micros) => {
                let heard = drive.next(Duration::micros(micros.parse()?));
                if let Some(heard) = heard {
                    writeln!(output, "{}", show(&heard))?;
                }
                writeln!(output, "={}", drive.now().ticks())?;
                output.flush()?;
            }
            None => drive.queue_frame(frame(&line)),
        }
    }
    Ok(())
}

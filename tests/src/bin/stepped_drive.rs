//! A virtual drive in virtual time for a master that is another program: `tests/python/stepped.py` runs python-canopen so.
//!
//! It reads lines. `604 [8] 40 00 10 00` gives a frame to the bus, in the notation of the cases. `+1000` lets so many microseconds pass,
//! fewer if the drive sends something: it answers with a frame of the drive, if there is one, and with `=` and the present time in
//! microseconds. Nothing else makes time pass. An axis is given as to `sim serve`, by
//! `--plant FILE.toml` or `--axis NAME`; `--basic-device` is the device without a drive whose flash is measured.
//!
//! What happens to the motor of a servo is a line too ([`happen`]): `!brake 20` holds it with 20 N·m, `!cut-encoder` cuts its encoder.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use canopen::Duration;
use master::bus::Station;
use servo_plant::Short;
use sim::drive::{Setup, VirtualDrive};
use sim::plant::{Axis, ServoAxisData};
use tests::basic;
use tests::drive::ServoBench;
use tests::line::Line;
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
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    // The master gives the node-ID.
    let setup = |axis| Setup {
        axis,
        ..Setup::unconfigured(1)
    };
    let nothing = |event: &str| Err(format!("nothing knows {event}").into());
    match arguments.as_slice() {
        [] => step(generic(setup(None)), |_, event| nothing(event)),
        ["--plant", file] => {
            let axis = Axis::read(file.as_ref())?;
            step(generic(setup(Some(axis))), |_, event| nothing(event))
        }
        ["--axis", name] => {
            let data = ServoAxisData::named(name).ok_or("there is no such axis")?;
            let axis = Axis::servo(&data.at_work());
            let device = sim::ServoDrive::new(setup(Some(axis)));
            step(Line::new(device, 0), happen)
        }
        ["--basic-device"] => step(basic::line(), |_, event| nothing(event)),
        _ => Err("Usage: stepped_drive [--plant FILE.toml | --axis NAME | --basic-device]".into()),
    }
}

fn generic(setup: Setup) -> Line<sim::Axis402> {
    Line::new(VirtualDrive::new(setup), 0)
}

/// Something happens to the motor of a servo.
fn happen(drive: &mut ServoBench, event: &str) -> Result<(), Box<dyn Error>> {
    let words: Vec<&str> = event.split(' ').collect();
    let plant = drive.plant();
    match words.as_slice() {
        ["brake", torque] => plant.load_brake = torque.parse()?,
        ["load", torque] => plant.load_torque = torque.parse()?,
        ["lose-counts", counts] => plant.sensor_faults.lost_counts += counts.parse::<i64>()?,
        ["slip-index", counts] => plant.sensor_faults.slipped_index = counts.parse()?,
        ["cut-encoder"] => plant.sensor_faults.encoder_is_cut = true,
        ["cut-phase", phase] => plant.cut_phase = Some(phase.parse()?),
        ["short", phase] => plant.short = Some(Short::new(phase.parse()?, 0.05, 2e-6)),
        ["stuck-current", phase, amperes] => {
            plant.sensor_faults.stuck_current = Some((phase.parse()?, amperes.parse()?));
        }
        ["cut-supply"] => drive.set_supply(false),
        ["charge", volts] => plant.charge_bus(volts.parse()?),
        ["heat", tenths] => drive.axis().plant_mut().temperature = tenths.parse()?,
        ["mend"] => {
            plant.sensor_faults = servo_plant::SensorFaults::default();
            (plant.cut_phase, plant.short) = (None, None);
            (plant.load_brake, plant.load_torque) = (0.0, 0.0);
            drive.set_supply(true);
            drive.axis().plant_mut().temperature = 250;
        }
        _ => return Err(format!("nothing knows {event}").into()),
    }
    Ok(())
}

/// Does what the lines say.
fn step<S: Station>(
    mut device: Line<S>,
    mut happen: impl FnMut(&mut Line<S>, &str) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let mut output = io::stdout().lock();
    for line in io::stdin().lines() {
        let line = line?;
        if let Some(event) = line.strip_prefix('!') {
            happen(&mut device, event)?;
            continue;
        }
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

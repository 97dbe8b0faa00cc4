//! The plant on its wires, for a board that is another program: `tests/machine/plant.py` hangs it on the pins of the modelled chip.
//!
//! It reads lines, `20 1 1 - 480 1200`: so many microseconds pass, with current in the motor (1) or without (0), with the brake open (1) or closed (0),
//! and pulses of one direction begin so many ticks of 84 MHz behind the beginning. It answers with where the motor stands in steps along the
//! axis and with the levels of inputs 1 to 6, input 1 in bit 0: `11998 3`. `stepped_axis FILE.toml` reads an axis as `sim serve --plant` does.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use canopen::{Duration, Instant};
use motion::{Direction, PulseSink, Record};
use sim::plant::{Axis, Plant, STEP_CLOCK_HZ};

/// Ticks of the step clock in a microsecond.
const MICROSECOND: u32 = STEP_CLOCK_HZ / 1_000_000;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("stepped_axis: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let file = std::env::args()
        .nth(1)
        .ok_or("Usage: stepped_axis FILE.toml")?;
    let axis = Axis::read(file.as_ref())?;
    let mut now = Instant::from_ticks(0);
    let mut plant = Plant::new(now);
    plant.mount(&axis);
    let mut output = io::stdout().lock();
    for line in io::stdin().lines() {
        let line = line?;
        let mut words = line.split_whitespace();
        let mut word = || words.next().ok_or("a line is too short");
        let span: u32 = word()?.parse()?;
        plant.energise(word()? == "1");
        plant.open_brake(word()? == "1");
        let direction = if word()? == "-" {
            Direction::Reverse
        } else {
            Direction::Forward
        };
        let begins: Vec<u32> = words.map(str::parse).collect::<Result<_, _>>()?;
        for record in records(&begins, direction, span * MICROSECOND) {
            (plant.pulses_mut().push(record)).map_err(|_| "too many pulses in one line")?;
        }
        now += Duration::micros(span.into());
        plant.advance(now);
        let levels = plant.look();
        let levels =
            (levels.iter().enumerate()).fold(0, |all, (i, wire)| all | u8::from(wire.level) << i);
        writeln!(output, "{} {levels}", plant.rotor())?;
        output.flush()?;
    }
    Ok(())
}

/// Silence up to the first pulse, and each pulse up to the next one or to the end.
fn records(begins: &[u32], direction: Direction, end: u32) -> Vec<Record> {
    let record = |period, width| Record {
        period,
        repeat: 1,
        width,
        direction,
    };
    let first = begins.first().copied().unwrap_or(end);
    let silence = (first > 0).then(|| record(first, 0));
    let ends = begins.iter().skip(1).copied().chain([end]);
    let pulses = begins.iter().zip(ends);
    silence
        .into_iter()
        .chain(pulses.map(|(begin, end)| record(end.saturating_sub(*begin).max(1), 1)))
        .collect()
}

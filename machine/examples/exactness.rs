//! Prints the figures of `docs/benchmarks.md`, "Exactness", for `cargo xtask bench`: name, tab, whole number.

use std::error::Error;
use std::thread;

use canopen::Duration;
use machine::exactness::count::{long_moves, sequences};
use machine::exactness::reaction::{Mode, Order, Profile, Reaction, longest};
use machine::exactness::{STEEP, duration, position, rate};
use machine::timer_model::rig::HZ;
use master::Failure;

fn main() -> Result<(), Box<dyn Error>> {
    println!("# Exactness");
    // Each takes half a minute or so.
    let other = thread::spawn(|| sequences(1_000_000));
    let moves = long_moves(1_000_000_000);
    let random = other
        .join()
        .map_err(|_| "the sequences of commands failed")?;
    row("pulses too many or too few, of 10^9", moves.error);
    row(
        "pulses too many or too few, in 10^6 random sequences of commands",
        random.error,
    );

    // What is behind the point of a tick is from the last digits of the theory.
    let ticks = |ticks: f64| (ticks - 1e-3).ceil().max(0.0) as u64;
    row(
        "end of a move, moves T01 to T22, ticks of 6 ns",
        ticks(duration::linear().ticks),
    );

    for (name, velocity) in [
        ("position error at 100 kHz, thousandths of a step", 100_000),
        ("position error at 500 kHz, thousandths of a step", 500_000),
        // Periods of 336.5 and 168.3 ticks.
        (
            "position error at 499,259 Hz, thousandths of a step",
            499_259,
        ),
        ("position error at 998 kHz, thousandths of a step", 998_000),
        ("position error at 1 MHz, thousandths of a step", 1_000_000),
    ] {
        let steps = position::greatest_error(velocity, STEEP, motion::Ramps::Linear);
        row(name, (steps * 1_000.0).ceil() as u64);
    }

    let sustained = rate::at(1_000_000, 10)?;
    row("rate on a full bus, steps/s", sustained.rate);
    row(
        "rate on a full bus, pulses too many or too few",
        sustained.error,
    );
    // As fast as the driver bears: high and low take 34 ticks.
    let ceiling = rate::at(HZ / 34, 1)?;
    row("ceiling on a full bus, steps/s", ceiling.rate);
    row(
        "ceiling on a full bus, pulses too many or too few",
        ceiling.error,
    );

    for (name, order) in [
        ("halt", Order::Halt),
        ("quick stop", Order::QuickStop),
        ("disable operation", Order::DisableOperation),
    ] {
        for (ramps, profile) in [
            ("", Profile::Linear),
            (", sin² ramps", Profile::SinSquared),
            (", moving average", Profile::MovingAverage),
        ] {
            let worst = reaction(order, profile, Mode::ProfileVelocity)?;
            if profile == Profile::Linear {
                row(
                    &format!("{name} to the first slower step, from the control tick, µs"),
                    worst.from_tick,
                );
            }
            row(
                &format!("{name} to the first slower step, from its frame{ramps}, µs"),
                worst.from_frame,
            );
        }
        let worst = reaction(order, Profile::Linear, Mode::ProfilePosition)?;
        row(
            &format!("{name} to the first slower step, from its frame, in profile position, µs"),
            worst.from_frame,
        );
    }
    Ok(())
}

/// The longest of 1,100 reactions.
fn reaction(order: Order, profile: Profile, mode: Mode) -> Result<Reaction, Failure> {
    let mut worst = Reaction::default();
    for refill in (0..250).step_by(50) {
        // Ramps of 20 ms, a tenth of a time slice longer each.
        for tenth in 0..10 {
            let ramp = STEEP - STEEP / 800 * tenth;
            let refill = Duration::micros(refill);
            worst = worst.max(longest(order, profile, mode, refill, ramp)?);
        }
    }
    Ok(worst)
}

fn row(name: &str, figure: u64) {
    println!("{name}\t{figure}");
}

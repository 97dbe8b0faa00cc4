//! Pulses too many or too few: none, whatever is asked for.

use motion::advanced_timer::Ring;
use motion::{Limits, PlanError, Ramps};

use super::{FAST, Numbers, STEEP};
use crate::timer_model::Judge;
use crate::timer_model::rig::{HZ, Rig, TIME_SLICE};

/// What was counted on the pins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// The pulses.
    pub pulses: u64,
    /// The most by which the pins ever were off from what they had to be at rest, in steps.
    pub error: u64,
    /// How often the processor stood still.
    pub pauses: u64,
    /// How often the timers had nothing to play in motion, because it stood still, and told it.
    pub underruns: u64,
}

/// Of long moves in steps/s³: a twentieth of a second until a ramp is at [`STEEP`].
const JERK: u32 = 20 * STEEP;

fn limits(velocity: u32, ramp: u32) -> Limits {
    Limits {
        velocity: velocity.into(),
        acceleration: ramp,
        deceleration: ramp,
    }
}

/// Moves of four million steps to and fro at up to a million steps/s, with each kind of ramps in turn, until there have been so many pulses.
///
/// # Panics
/// If a motion does not end, or the pins do what no driver bears.
pub fn long_moves(pulses: u64) -> Counted {
    let ring = Ring::new();
    let mut rig = Rig::new(&ring, FAST, Judge::new(FAST));
    let (mut target, mut forth, mut error) = (0_i64, true, 0);
    let mut ramps = [Ramps::Linear, Ramps::SinSquared, Ramps::MovingAverage(JERK)]
        .into_iter()
        .cycle();
    while rig.model.judge().pulses < pulses {
        rig.axis.set_ramps(ramps.next().unwrap_or_default());
        let way: i64 = if forth { 4_000_037 } else { -3_999_949 };
        target += way;
        forth = !forth;
        let before = rig.model.judge().pulses;
        rig.axis
            .move_to(target, limits(1_000_000, STEEP))
            .expect("a move that can be");
        rig.finish(30_000);
        // Where it is, and that no pulse went to and fro.
        let made = rig.model.judge().pulses - before;
        error = error
            .max(off(&mut rig))
            .max(rig.model.judge().position.abs_diff(target))
            .max(made.abs_diff(way.unsigned_abs()));
    }
    counted(&rig, error, 0)
}

/// So many sequences of six commands each, at any moment and from any velocity: moves, velocities, stops, power off, with ramps of every
/// form, changed in motion too; and now and then the processor stands still for up to 5 ms.
///
/// # Panics
/// If a motion does not end, or the pins do what no driver bears.
pub fn sequences(number: u64) -> Counted {
    let ring = Ring::new();
    let mut rig = Rig::new(&ring, FAST, Judge::new(FAST));
    let mut numbers = Numbers::new(0x9E37_79B9_7F4A_7C15);
    let (mut error, mut pauses) = (0, 0);
    for sequence in 1..=number {
        for _ in 0..6 {
            // A command that is refused leaves the motion as it was.
            let _ = command(&mut rig, &mut numbers);
            for _ in 0..numbers.below(12) {
                rig.refill(TIME_SLICE.into());
            }
            if numbers.below(50) == 0 {
                let pause = numbers.below(u64::from(HZ) / 200);
                rig.refill(pause);
                pauses += 1;
            }
        }
        rig.axis.stop(200_000_000).expect("a stop that can be");
        rig.finish(40_000);
        error = error.max(off(&mut rig));
        // Now and then back to where the count began.
        if sequence % 64 == 0 {
            rig.axis
                .move_to(0, limits(1_000_000, 100_000_000))
                .expect("a move that can be");
            rig.finish(100_000);
            let position = rig.model.judge().position;
            error = error.max(off(&mut rig)).max(position.unsigned_abs());
        }
    }
    counted(&rig, error, pauses)
}

fn command(rig: &mut Rig<'_>, numbers: &mut Numbers) -> Result<(), PlanError> {
    let limits = Limits {
        velocity: (1 + numbers.below(1_000_000) as u32).into(),
        acceleration: 1 << (14 + numbers.below(13)),
        deceleration: 1 << (14 + numbers.below(13)),
    };
    if numbers.below(3) == 0 {
        // A jerk at which every ramp is over within seconds.
        let jerk = 1 << (26 + numbers.below(6));
        rig.axis.set_ramps(match numbers.below(5) {
            0 | 1 => Ramps::Linear,
            2 | 3 => Ramps::SinSquared,
            _ => Ramps::MovingAverage(jerk),
        });
    }
    match numbers.below(8) {
        0..=2 => {
            let target = numbers.below(8_000) as i64 - 4_000;
            rig.axis.move_to(target, limits)
        }
        3 | 4 => {
            let velocity = numbers.below(400_000) as i32 - 200_000;
            rig.axis.ramp_to(velocity.into(), limits)
        }
        5 | 6 => rig.axis.stop(limits.deceleration),
        _ => {
            rig.output.drop_all();
            rig.axis.abort();
            let position = rig.output.position();
            rig.axis.set_position(position);
            Ok(())
        }
    }
}

/// How far pins, counter and plan are apart, at rest.
fn off(rig: &mut Rig<'_>) -> u64 {
    let pins = rig.model.judge().position;
    let counter = rig.output.position();
    let plan = rig.axis.committed_position();
    counter
        .abs_diff(pins)
        .max(plan.abs_diff(i64::from(pins as i32)))
}

fn counted(rig: &Rig<'_>, error: u64, pauses: u64) -> Counted {
    Counted {
        pulses: rig.model.judge().pulses,
        error,
        pauses,
        underruns: rig.underruns,
    }
}

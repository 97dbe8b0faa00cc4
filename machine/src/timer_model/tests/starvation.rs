//! Plans are made at the priority of the refills, so none is committed meanwhile: there are always enough pulses left.
//!
//! A tick begins with a segment and a half at least: with less it tops up first. The run that is preloaded (up to 0.1 ms) cannot be
//! changed any more. An instruction takes a cycle and a half, and a cycle is a tick of the step timer.

use motion::{Limits, PulseSink, Ramps};

use super::super::rig::{Rig, SEGMENT};
use super::{FAST, HZ, rig};

/// The worst case of a control tick, with a linear plan (`docs/benchmarks.md`, "Control tick"), in instructions.
const TICK: u64 = 8_500;

/// The linear plan in it, at least.
const LINEAR: u64 = 4_100;

/// Other interrupts in 250 µs: three frames at full bus load, edges of inputs. In microseconds.
const INTERRUPTED: u64 = 18;

/// What a row of `docs/benchmarks.md` says.
fn instructions(row: &str) -> u64 {
    let page = include_str!("../../../../docs/benchmarks.md");
    let line = page.lines().find_map(|line| line.strip_prefix(row));
    let figure = line.and_then(|line| line.trim_start_matches(" | ").split(' ').next());
    let figure = figure.and_then(|figure| figure.parse().ok());
    figure.unwrap_or_else(|| panic!("no figure in the row {row}"))
}

/// The time of so many instructions, and of what interrupts them, in ticks.
fn time(instructions: u64) -> u64 {
    instructions * 3 / 2 + INTERRUPTED * u64::from(HZ) / 1_000_000
}

/// What a tick may take, in instructions: more than the worst of them does, with the worst plan that was found in place of a linear one.
const WORST_TICK: u64 = 20_000;

#[test]
fn the_worst_tick_that_was_found_is_not_the_worst_there_may_be() {
    for ramps in ["linear", "sin²"] {
        let row = format!("| motion: plan, worst case found, {ramps}");
        assert!(TICK - LINEAR + instructions(&row) < WORST_TICK, "{ramps}");
    }
}

fn limits(velocity: u32) -> Limits {
    Limits {
        velocity: velocity.into(),
        acceleration: 2_000_000,
        deceleration: 3_000_000,
    }
}

const JERK: u32 = 50_000_000;

const ALL: [Ramps; 3] = [Ramps::Linear, Ramps::SinSquared, Ramps::MovingAverage(JERK)];

/// Lets the axis move, until a refill is due.
fn go_on(rig: &mut Rig<'_>, segments: u32) {
    for _ in 0..segments {
        rig.refill(SEGMENT.into());
    }
}

/// What a tick begins with (`cia402::Drive::top_up`).
fn top_up(rig: &mut Rig<'_>) {
    rig.output.service();
    if rig.axis.runs_short(rig.output.pending()) {
        rig.axis.advance(&mut rig.output).unwrap();
    }
}

/// A motion with `first`, and every few segments another with ramps of `then` and of `first` in turn. Each tick that plans takes so many instructions. Returns
/// how often there were no pulses.
fn planned_anew((first, then): (Ramps, Ramps), velocity: u32, cost: u64) -> u64 {
    let mut rig = rig(FAST);
    let far = i64::from(velocity);
    rig.axis.set_ramps(first);
    rig.axis.move_to(far, limits(velocity)).unwrap();
    let mut target = far;
    for number in 0..24_u32 {
        go_on(&mut rig, 5 + number * 7 % 40);
        let ramps = if number % 2 == 0 { then } else { first };
        rig.axis.set_ramps(ramps);
        if number % 4 < 2 {
            // With a segment and a half left, none is committed before.
            rig.refill(u64::from(SEGMENT) / 2);
        }
        top_up(&mut rig);
        rig.model.run(time(cost));
        target = match number % 3 {
            2 => far / 4,
            _ => target + far / 50,
        };
        rig.axis.move_to(target, limits(velocity)).unwrap();
    }
    let starved = rig.underruns;
    rig.finish(100_000);
    rig.account();
    assert_eq!(rig.model.judge().position, target);
    starved
}

/// Whatever ramps take the place of whatever others, at any velocity, with all that the tick may do beside the plan.
#[test]
fn the_worst_plan_makes_no_pause() {
    for velocity in [3_000, 200_000, 1_000_000] {
        for first in ALL {
            for then in ALL {
                let starved = planned_anew((first, then), velocity, WORST_TICK);
                assert_eq!(starved, 0, "{first:?}, then {then:?}, {velocity} steps/s");
            }
        }
    }
}

#[test]
fn the_worst_stop_makes_no_pause() {
    for velocity in [3_000_u32, 200_000, 1_000_000] {
        for ramps in ALL {
            let mut rig = rig(FAST);
            for moment in 0..40 {
                rig.axis.set_ramps(ramps);
                let speed = velocity.cast_signed();
                rig.axis.ramp_to(speed.into(), limits(velocity)).unwrap();
                go_on(&mut rig, 40 + moment * 11 % 400);
                if moment % 2 == 0 {
                    // With a segment and a half left, none is committed before.
                    rig.refill(u64::from(SEGMENT) / 2);
                }
                let tick = time(WORST_TICK);
                if moment % 3 > 0 {
                    // An early tick, with the regular one behind it.
                    top_up(&mut rig);
                    rig.model.run(tick);
                    rig.axis.stop(3_000_000).unwrap();
                }
                top_up(&mut rig);
                rig.model.run(tick);
                rig.axis.stop(5_000_000).unwrap();
                go_on(&mut rig, 7 * moment);
            }
            assert_eq!(rig.underruns, 0, "{ramps:?}, {velocity} steps/s");
            rig.finish(100_000);
            rig.account();
        }
    }
}

/// With a segment and a half, ticks of more than 25,000 instructions would make pauses.
#[test]
fn a_tick_may_take_no_longer() {
    let linear = (Ramps::Linear, Ramps::Linear);
    for tick in (20_000..=45_000).step_by(5_000) {
        let starved = planned_anew(linear, 3_000, tick);
        assert_eq!(starved > 0, tick > 25_000, "{tick} instructions: {starved}");
    }
}

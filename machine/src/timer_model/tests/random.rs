//! Any sequence of commands, with a processor that comes late or not at all: every pulse is accounted for.

use motion::advanced_timer::{WORDS, on_break};
use motion::{Axis, DriverTiming, FollowError, Limits, Position, PulseSink, Ramps};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::super::rig::{HZ, Rig, TIME_SLICE};
use super::{FAST, SLOW, rig};

#[derive(Clone, Debug)]
enum Command {
    MoveTo(i32, Limits),
    RampTo(i32, Limits),
    /// On through a target, with the second number of steps/s.
    MoveThrough(i32, u32, Limits),
    /// A set-point so many ticks behind the one before, at so many steps/s.
    Follow(u32, i32),
    Stop(u32),
    /// Ramps for what comes from now on.
    Choose(Ramps),
    Drop,
    /// The stream is no longer served, or has ended with a bus error (`true`), so many ticks from now.
    StreamEnds(u32, bool),
    /// The break input is active for so many refills, so many ticks from now; its interrupt comes the second number of ticks later.
    Break(u32, u32, u8),
    /// Refills on time.
    Refill(u8),
    /// A refill that comes after so many ticks.
    Late(u32),
}

/// The longest time from a break to its interrupt, in ticks.
const LATENCY: u32 = HZ / 100_000;

/// The shortest period of the pulses, in ticks.
const PERIOD: u64 = HZ as u64 / 1_000_000;

fn limits() -> impl Strategy<Value = Limits> {
    (1..1_000_000u32, 14..27u32, 14..27u32).prop_map(|(velocity, a, d)| Limits {
        velocity: velocity.into(),
        acceleration: 1 << a,
        deceleration: 1 << d,
    })
}

/// Of every kind, at no less than a jerk of 2^`least` steps/s³.
pub(super) fn ramps(least: u32) -> impl Strategy<Value = Ramps> {
    let jerk = 1 << least..1_u32 << 31;
    prop_oneof![
        Just(Ramps::Linear),
        Just(Ramps::SinSquared),
        jerk.prop_map(Ramps::MovingAverage),
    ]
}

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        3 => (-20_000..20_000i32, limits()).prop_map(|(target, limits)| Command::MoveTo(target, limits)),
        2 => (-50..50i32, limits()).prop_map(|(target, limits)| Command::MoveTo(target, limits)),
        2 => (-900_000..900_000i32, limits()).prop_map(|(velocity, limits)| Command::RampTo(velocity, limits)),
        2 => (-20_000..20_000i32, 0..900_000u32, limits())
            .prop_map(|(target, end, limits)| Command::MoveThrough(target, end, limits)),
        2 => (1..20 * TIME_SLICE, -900_000..900_000i32).prop_map(|(ticks, velocity)| Command::Follow(ticks, velocity)),
        2 => (1..50_000_000u32).prop_map(Command::Stop),
        2 => ramps(20).prop_map(Command::Choose),
        1 => Just(Command::Drop),
        1 => (0..TIME_SLICE, any::<bool>()).prop_map(|(late, is_bus_error)| Command::StreamEnds(late, is_bus_error)),
        1 => (0..TIME_SLICE, 0..LATENCY, 0..9u8).prop_map(|(late, latency, refills)| Command::Break(late, latency, refills)),
        8 => any::<u8>().prop_map(Command::Refill),
        2 => (0..4 * TIME_SLICE).prop_map(Command::Late),
        1 => (0..400 * TIME_SLICE).prop_map(Command::Late),
    ]
}

/// A set-point on a straight line from where the path ends.
fn follow(axis: &mut Axis, ticks: u32, velocity: i32) -> Result<(), FollowError> {
    let (end, state) = axis.path_end();
    let way = (i128::from(velocity) << 32) * i128::from(ticks) / i128::from(HZ);
    let to = Position::from_bits(state.position.bits().wrapping_add(way as i64));
    axis.follow(end + u64::from(ticks), to)
}

/// What is left of the plan is given up, at rest.
fn go_on_from_here(rig: &mut Rig<'_>) {
    rig.axis.abort();
    let position = rig.output.position();
    rig.axis.set_position(position);
    rig.account();
}

/// The stream ends between two bursts. Whatever its last run has made is found and counted.
fn end_stream(rig: &mut Rig<'_>, is_bus_error: bool) {
    while !rig.model.words_left().is_multiple_of(WORDS as u32) {
        rig.model.run(1);
    }
    let is_on = rig.output.pending() > 0;
    if is_bus_error {
        rig.model.fail_stream();
    } else {
        rig.model.stall_stream(true);
    }
    for _ in 0..5 {
        rig.refill(TIME_SLICE.into());
    }
    // A bus error needs a stream that is on.
    let is_noticed = rig.output.has_failed() || rig.output.pending() == 0;
    assert!(is_noticed || is_bus_error && !is_on);
    rig.model.stall_stream(false);
    rig.output.drop_all();
    rig.output.mend();
    go_on_from_here(rig);
}

/// What was counted between a break and its interrupt has not left; everything else has.
fn break_off(rig: &mut Rig<'_>, latency: u32, refills: u8) {
    let began = rig.model.time();
    rig.model.set_break(true);
    rig.model.run(latency.into());
    let answer = |rig: &mut Rig<'_>| {
        if rig.model.is_break_interrupt() {
            on_break(&mut rig.model);
        }
    };
    answer(rig);
    let most = (rig.model.time() - began) / PERIOD + 1;
    for _ in 0..refills {
        rig.refill(TIME_SLICE.into());
        answer(rig);
    }
    assert!(!rig.output.has_failed());
    rig.output.drop_all();
    let position = rig.output.position();
    let off = position.abs_diff(rig.model.judge().position);
    assert!(off <= most, "{off} steps");
    rig.model.judge_mut().position = position;
    rig.model.set_break(false);
    rig.output.mend();
    assert!(!rig.output.is_broken());
    go_on_from_here(rig);
}

fn play(commands: &[Command], timing: DriverTiming, burst: u64, access: u64, count: u32) {
    let mut rig = rig(timing).with_count(count);
    rig.model.set_burst(burst);
    rig.model.set_access(access);
    rig.model.set_interrupts(50, u64::from(HZ) / 100_000);
    for command in commands {
        let _ = match *command {
            Command::MoveTo(target, limits) => rig.axis.move_to(target.into(), limits),
            Command::RampTo(velocity, limits) => rig.axis.ramp_to(velocity.into(), limits),
            Command::MoveThrough(target, end, limits) => {
                (rig.axis).move_through(target.into(), end.into(), limits)
            }
            Command::Follow(ticks, velocity) => {
                // What is refused leaves the motion as it was.
                let _ = follow(&mut rig.axis, ticks, velocity);
                Ok(())
            }
            Command::Stop(deceleration) => rig.axis.stop(deceleration),
            Command::Choose(ramps) => {
                rig.axis.set_ramps(ramps);
                Ok(())
            }
            Command::Drop => {
                rig.output.drop_all();
                go_on_from_here(&mut rig);
                Ok(())
            }
            Command::StreamEnds(late, is_bus_error) => {
                rig.model.run(late.into());
                end_stream(&mut rig, is_bus_error);
                Ok(())
            }
            Command::Break(late, latency, refills) => {
                rig.model.run(late.into());
                break_off(&mut rig, latency, refills);
                Ok(())
            }
            Command::Refill(times) => {
                for _ in 0..times {
                    rig.refill(TIME_SLICE.into());
                }
                Ok(())
            }
            Command::Late(ticks) => {
                rig.refill(ticks.into());
                Ok(())
            }
        };
    }
    rig.axis.stop(400_000_000).unwrap();
    rig.finish(200_000);
    rig.account();
    let home = Limits {
        velocity: 1_000_000.into(),
        acceleration: 100_000_000,
        deceleration: 100_000_000,
    };
    rig.axis.move_to(777, home).unwrap();
    rig.finish(200_000);
    rig.account();
    assert_eq!(rig.output.position() as i32, 777);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn every_pulse_that_leaves_is_accounted_for(
        commands in prop::collection::vec(command(), 1..25),
        fast: bool,
        burst in 5..84u64,
        access in 0..8u64,
        left in prop_oneof![Just(u32::MAX), 0..30_000u32],
    ) {
        // Near the end of the counter, or far from it.
        play(&commands, if fast { FAST } else { SLOW }, burst, access, !left);
    }
}

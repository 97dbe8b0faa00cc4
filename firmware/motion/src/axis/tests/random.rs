//! Any sequence of commands, at any moments: every pulse is accounted for.

use super::{FAST, HZ, Replay, SLOW, axis};
use crate::axis::{AdvanceError, Axis};
use crate::{Limits, Position, PulseSink, Ramps, SignedSpeed};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

#[derive(Debug, Clone)]
enum Command {
    MoveTo(i32, Limits),
    /// With the velocity at the target.
    Through(i32, u32, Limits),
    RampTo(i32, Limits),
    /// Set-points, each so many microseconds behind the last: at a velocity in thousandths of the highest up to 1 MHz, in a straight line, or with the velocity
    /// changing evenly, as it does to
    /// the first one; all in one direction.
    Follow(bool, Vec<(i16, u16, bool)>),
    Stop(u32),
    /// Ramps for what comes from now on.
    Choose(Ramps),
    Abort,
    /// Control ticks of a quarter time slice each.
    Advance(u16),
    /// The sink plays all it has before the axis is asked again.
    Starve,
}

fn limits() -> impl Strategy<Value = Limits> {
    (1u32..1_000_000, 14u32..27, 14u32..27, any::<u16>()).prop_map(|(velocity, a, d, noise)| {
        Limits {
            velocity: if noise % 7 == 0 {
                (u32::from(noise) % 50).into()
            } else {
                velocity.into()
            },
            acceleration: (1 << a) + u32::from(noise),
            deceleration: (1 << d) + u32::from(noise),
        }
    })
}

fn ramps() -> impl Strategy<Value = Ramps> {
    let jerk =
        || (20u32..32, any::<u16>()).prop_map(|(bits, noise)| (1 << bits) + u32::from(noise));
    prop_oneof![
        Just(Ramps::Linear),
        Just(Ramps::SinSquared),
        jerk().prop_map(|jerk| Ramps::limited(jerk).unwrap_or(Ramps::SinSquared)),
        jerk().prop_map(Ramps::MovingAverage),
    ]
}

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        4 => (-100_000i32..100_000, limits()).prop_map(|(target, limits)| Command::MoveTo(target, limits)),
        2 => (-50i32..50, limits()).prop_map(|(target, limits)| Command::MoveTo(target, limits)),
        2 => (-100_000i32..100_000, 0u32..400_000, limits()).prop_map(|(target, end, limits)| Command::Through(target, end, limits)),
        2 => (-400_000i32..400_000, limits()).prop_map(|(velocity, limits)| Command::RampTo(velocity, limits)),
        2 => (any::<bool>(), prop::collection::vec((0i16..900, 300u16..4_000, any::<bool>()), 1..10)).prop_map(|(reverse, points)| Command::Follow(reverse, points)),
        2 => (0u32..50_000_000).prop_map(Command::Stop),
        2 => ramps().prop_map(Command::Choose),
        1 => Just(Command::Abort),
        8 => (1u16..300).prop_map(Command::Advance),
        1 => Just(Command::Starve),
    ]
}

/// One control tick. What cannot be taken now is taken later.
fn advance(axis: &mut Axis, sink: &mut Replay, starved: bool) {
    let result = axis.advance(sink);
    let full = sink.free() == 0;
    match result {
        Ok(()) => {}
        Err(AdvanceError::SinkFull) => assert!(full),
        Err(AdvanceError::Internal) => panic!("a bound was reached"),
        Err(AdvanceError::Underrun) => assert!(starved),
    }
    sink.account(axis);
}

/// Set-points one by one, each when the axis comes to the one before it.
fn follow(axis: &mut Axis, sink: &mut Replay, reverse: bool, points: &[(i16, u16, bool)]) {
    let highest = i64::from(axis.max_velocity().whole().min(1_000_000));
    for (index, &(share, microseconds, is_straight)) in points.iter().enumerate() {
        let (from, state) = axis.path_end();
        let length = u64::from(microseconds) * u64::from(HZ) / 1_000_000;
        let share = i64::from(if reverse { -share } else { share });
        let velocity = highest * share / 1_000;
        let taken = if is_straight && index > 0 {
            let distance = ((i128::from(velocity) * i128::from(length)) << 32) / i128::from(HZ);
            let to = state.position.bits().wrapping_add(distance as i64);
            axis.follow(from + length, Position::from_bits(to))
        } else {
            axis.follow_velocity(from + length, SignedSpeed::from(velocity as i32))
        };
        assert_eq!(taken, Ok(()), "{length} ticks behind {from}");
        sink.follow(axis);
        while axis.horizon() < from {
            advance(axis, sink, true);
            sink.play(u64::from(axis.stepper.time_slice() / 4));
        }
    }
}

/// Steps between pulses and plan at most. A pulse is half a step off on either side; a chord curves a quarter of a step away from its phase; the
/// period before eight pulses or more may be one of theirs if it is as long but for an eighth; and pulses, n in T ticks as two runs, stand
/// n²/(4·T) away from their even places. What is left is roundings at the highest rate of the driver, where nothing is caught up.
fn tolerance(axis: &Axis) -> f64 {
    let time_slice = f64::from(axis.stepper.time_slice());
    let fastest = axis.max_velocity().whole().min(1_000_000);
    let pulses = f64::from(fastest) * time_slice / f64::from(HZ);
    0.5 + 0.25 + 0.125 + pulses.powi(2) / 4.0 / time_slice + 0.01
}

fn play(ramps: Ramps, commands: &[Command], timing: crate::DriverTiming, capacity: usize) {
    let (mut axis, mut sink) = axis(timing);
    sink.capacity = capacity;
    // A small sink delays commands, never pulses of the stream, so the plan is followed all the same.
    sink.tolerance = tolerance(&axis);
    let quarter = u64::from(axis.stepper.time_slice() / 4);
    let mut starved = false;
    axis.set_ramps(ramps);
    for command in commands {
        let moved = match *command {
            Command::MoveTo(target, limits) => axis.move_to(target.into(), limits),
            Command::Through(target, end, limits) => {
                axis.move_through(target.into(), end.into(), limits)
            }
            Command::Follow(reverse, ref points) => {
                follow(&mut axis, &mut sink, reverse, points);
                starved = sink.pending() == 0;
                continue;
            }
            Command::RampTo(velocity, limits) => axis.ramp_to(velocity.into(), limits),
            Command::Stop(deceleration) => axis.stop(deceleration),
            Command::Choose(ramps) => {
                axis.set_ramps(ramps);
                Ok(())
            }
            Command::Abort => {
                assert_eq!(axis.abort(), axis.committed_position());
                assert!(axis.is_at_rest());
                sink.clear();
                Ok(())
            }
            Command::Advance(ticks) => {
                for _ in 0..ticks {
                    advance(&mut axis, &mut sink, starved);
                    starved = false;
                    sink.play(quarter);
                    starved |= sink.pending() == 0;
                }
                Ok(())
            }
            Command::Starve => {
                sink.play_out();
                starved = true;
                Ok(())
            }
        };
        if moved.is_ok() {
            sink.follow(&axis);
        }
    }
    axis.set_ramps(ramps);
    axis.stop(400_000_000).unwrap();
    sink.follow(&axis);
    while !axis.is_at_rest() {
        advance(&mut axis, &mut sink, true);
        sink.play(quarter);
    }
    assert_eq!(axis.target(), sink.position);
    axis.move_to(
        777,
        Limits {
            velocity: 1_000_000.into(),
            acceleration: 100_000_000,
            deceleration: 100_000_000,
        },
    )
    .unwrap();
    sink.follow(&axis);
    while !axis.is_at_rest() {
        advance(&mut axis, &mut sink, true);
        sink.play(quarter);
    }
    assert_eq!(sink.position, 777);
    assert_eq!(axis.committed_position(), 777);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn every_pulse_is_accounted_for(
        commands in proptest::collection::vec(command(), 1..40),
        fast: bool,
        capacity in prop_oneof![Just(256usize), 2usize..16],
        ramps in ramps(),
    ) {
        play(ramps, &commands, if fast { FAST } else { SLOW }, capacity);
    }
}

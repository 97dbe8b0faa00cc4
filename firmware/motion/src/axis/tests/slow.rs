//! From one step in an hour up: every pulse at the tick where a fraction of whole numbers has it. Nothing here knows the plan.

use super::{FAST, HZ};
use crate::axis::{Axis, AxisConfig};
use crate::{Clock, Limits, Plan, PulseSink, Record, SignedSpeed, Speed, State, Ticks};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

/// One step in an hour, as near as it gets.
pub(super) const HOURLY: Speed = Speed::from_bits(((1 << 32) + 1_800) / 3_600);

/// Notes the tick of every pulse.
#[derive(Debug, Default)]
struct Ticker {
    ticks: Ticks,
    pending: Ticks,
    pulses: Vec<Ticks>,
    longest: u32,
}

impl PulseSink for Ticker {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if record.width > 0 {
            let pulses = 0..u64::from(record.repeat);
            let begin = self.ticks;
            self.pulses
                .extend(pulses.map(|pulse| begin + pulse * u64::from(record.period)));
        }
        self.longest = self.longest.max(record.period);
        self.ticks += record.ticks();
        self.pending += record.ticks();
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        256
    }
}

fn slow_axis(time_slice: u32) -> Axis {
    Axis::new(AxisConfig {
        clock: Clock::new(HZ).unwrap(),
        time_slice,
        timing: FAST,
    })
}

fn limits(velocity: Speed, acceleration: u32) -> Limits {
    Limits {
        velocity,
        acceleration,
        deceleration: acceleration,
    }
}

/// Advances until so many pulses are there.
fn play(axis: &mut Axis, sink: &mut Ticker, pulses: usize) {
    let time_slice = Ticks::from(axis.stepper.time_slice());
    while sink.pulses.len() < pulses {
        axis.advance(sink).unwrap();
        sink.pending = sink.pending.saturating_sub(time_slice);
    }
}

/// When a motion from rest at 0 crosses the middle in front of a step, in ticks, rounded down: the time to go k − ½ steps at the
/// velocity, and half of the time of the ramp. 0 for a step in the ramp.
fn due(step: u64, velocity: Speed, acceleration: u32) -> Ticks {
    let bits = u128::from(velocity.bits());
    // hz · (2k − 1) · 2³¹ / bits + hz · bits / (2³³ · a)
    let (d1, d2) = (bits, u128::from(acceleration) << 33);
    let n1 = (u128::from(step) * 2 - 1) << 31;
    let ramp = u128::from(HZ) * bits / d2 * 2;
    let due = u128::from(HZ) * (n1 * d2 + bits * d1) / (d1 * d2);
    if due < ramp { 0 } else { due as Ticks }
}

#[test]
fn a_step_in_an_hour_comes_every_hour() {
    // Long time slices, as there are many hours.
    let mut axis = slow_axis(HZ / 40);
    let mut sink = Ticker::default();
    axis.ramp_to(HOURLY.signed(false), limits(HOURLY, 1))
        .unwrap();
    play(&mut axis, &mut sink, 12);
    for (pulse, &tick) in sink.pulses.iter().enumerate() {
        let due = due(pulse as u64 + 1, HOURLY, 1);
        assert!(tick.abs_diff(due) <= 1, "pulse {pulse}: {tick} for {due}");
    }
    // An hour to 4·10⁻⁷ of itself, which is what HOURLY is.
    let gap = sink.pulses[11] - sink.pulses[10];
    let hour = 3_600 * u64::from(HZ);
    assert!(gap.abs_diff(hour) < hour / 2_500_000, "{gap} ticks");
    assert!(sink.longest <= HZ / 40 * 2, "silence comes in pieces");
}

#[test]
fn a_step_in_an_hour_is_at_its_tick_with_time_slices_of_a_quarter_of_a_millisecond() {
    // Three seconds of the distance lie in front of the first pulse.
    let clock = Clock::new(HZ).unwrap();
    for sign in [1, -1] {
        let distance = i64::try_from(HOURLY.bits()).unwrap() * 3;
        let from = State {
            position: crate::Position::from_bits(((1 << 31) - distance) * sign),
            velocity: crate::Velocity::ZERO,
        };
        let velocity = HOURLY.signed(sign < 0);
        let plan = Plan::velocity(clock, 0, from, velocity, limits(HOURLY, 1)).unwrap();
        let mut axis = Axis::on_plan(super::config(FAST), plan);
        let mut sink = Ticker::default();
        play(&mut axis, &mut sink, 1);
        // Half of the time of the ramp is lost.
        let due = 3 * u64::from(HZ) + ((u128::from(HOURLY.bits()) * u128::from(HZ)) >> 33) as u64;
        assert!(
            sink.pulses[0].abs_diff(due) <= 1,
            "{:?} for {due}",
            sink.pulses
        );
    }
}

#[test]
fn from_a_step_in_an_hour_to_a_million_in_a_second_and_back() {
    let mut axis = slow_axis(HZ / 4000);
    let mut sink = Ticker::default();
    let fast = Speed::per_second(1_000_000);
    let all = |velocity| limits(velocity, 1_000_000_000);
    let tick = |axis: &mut Axis, sink: &mut Ticker, ticks: u32| {
        for _ in 0..ticks {
            axis.advance(sink).unwrap();
            sink.pending = sink.pending.saturating_sub((HZ / 4000).into());
        }
    };
    axis.ramp_to(HOURLY.signed(false), all(HOURLY)).unwrap();
    tick(&mut axis, &mut sink, 40);
    assert!(sink.pulses.is_empty());
    let ordered = sink.ticks;
    axis.ramp_to(fast.signed(true), all(fast)).unwrap();
    tick(&mut axis, &mut sink, 40);
    let first = sink.pulses[0] - ordered;
    assert!(
        first < u64::from(HZ / 1000),
        "{first} ticks to the first pulse"
    );
    let [.., before, last] = sink.pulses[..] else {
        panic!("no pulses");
    };
    assert_eq!(last - before, 168);
    axis.ramp_to(HOURLY.signed(false), all(HOURLY)).unwrap();
    tick(&mut axis, &mut sink, 40);
    let pulses = sink.pulses.len();
    assert!(axis.committed_velocity().is_close_to(HOURLY.signed(false)));
    tick(&mut axis, &mut sink, 4_000);
    assert_eq!(sink.pulses.len(), pulses, "a second is no hour");
}

#[test]
fn a_halt_within_the_gap_of_an_hour_is_felt_at_once() {
    let mut axis = slow_axis(HZ / 4000);
    let mut sink = Ticker::default();
    axis.ramp_to(HOURLY.signed(false), limits(HOURLY, 1))
        .unwrap();
    for _ in 0..4_000 {
        axis.advance(&mut sink).unwrap();
        sink.pending = sink.pending.saturating_sub((HZ / 4000).into());
        // Two time slices ahead, and not the whole gap.
        assert!(sink.pending <= u64::from(HZ / 4000 * 3), "{sink:?}");
    }
    assert!(!axis.is_at_rest());
    let ordered = sink.ticks;
    axis.stop(1_000).unwrap();
    while !axis.is_at_rest() {
        axis.advance(&mut sink).unwrap();
        sink.pending = sink.pending.saturating_sub((HZ / 4000).into());
    }
    assert!(sink.ticks - ordered < u64::from(HZ / 1000), "{sink:?}");
    assert!(sink.pulses.is_empty());
    assert_eq!(axis.demand(0).velocity, SignedSpeed::ZERO);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(96)))]

    #[test]
    fn every_pulse_of_a_slow_velocity_is_at_its_tick(
        bits in prop_oneof![
            HOURLY.bits()..HOURLY.bits() * 10,
            1u64 << 22..1 << 32,
            // Four in a time slice: of many, those in the middle are off by some ticks.
            1u64 << 32..1 << 36,
        ],
        acceleration in prop_oneof![1u32..10, 1u32..1_000_000],
        reverse: bool,
    ) {
        let velocity = Speed::from_bits(bits);
        let mut axis = slow_axis(HZ / 4);
        let mut sink = Ticker::default();
        axis.ramp_to(velocity.signed(reverse), limits(velocity, acceleration)).unwrap();
        play(&mut axis, &mut sink, 8);
        for (pulse, &tick) in sink.pulses.iter().enumerate().take(8) {
            let due = due(pulse as u64 + 1, velocity, acceleration);
            prop_assert!(due == 0 || tick.abs_diff(due) <= 2, "pulse {}: {} for {}", pulse, tick, due);
        }
        let steps = if reverse { -1 } else { 1 };
        prop_assert_eq!(axis.committed_position().signum(), steps);
    }

    #[test]
    fn a_slow_move_lands_when_and_where_it_should(
        bits in prop_oneof![HOURLY.bits()..1 << 26, 1u64 << 26..1 << 34],
        target in 1i64..4,
        acceleration in 1u32..1_000_000,
    ) {
        let velocity = Speed::from_bits(bits);
        let clock = Clock::new(HZ).unwrap();
        let plan = Plan::move_to(clock, 0, State::default(), target, limits(velocity, acceleration)).unwrap();
        // target / v + v / a, if the velocity is reached.
        let (v, a) = (u128::from(bits), u128::from(acceleration));
        let is_reached = v * v < (a * target as u128) << 64;
        let time = (((target as u128) << 32) * (a << 32) + v * v) * u128::from(HZ) / (v * (a << 32));
        let end = plan.end().unwrap();
        prop_assert!(!is_reached || u128::from(end).abs_diff(time) <= 1, "{} for {}", end, time);
        prop_assert_eq!(plan.state_at(end).position.whole_steps(), target);
        // Never faster than asked for.
        let top = crate::Velocity::from_speed(clock, velocity.signed(false));
        for t in [0, end / 3, end / 2, end - 1] {
            prop_assert!(plan.state_at(t).velocity <= top);
        }
    }
}

#[test]
fn a_way_of_ages_ends_never_and_goes_on_all_the_same() {
    let clock = Clock::new(HZ).unwrap();
    for velocity in [Speed::LEAST, HOURLY] {
        let from = State {
            position: crate::Position::from_steps(i32::MIN.into()),
            ..State::default()
        };
        let limits = limits(velocity, u32::MAX);
        let plan = Plan::move_to(clock, 0, from, i32::MAX.into(), limits).unwrap();
        // Half a million years.
        assert!(plan.end().unwrap() >= Ticks::MAX - 1);
        let day = 86_400 * u64::from(HZ);
        let before = plan.state_at(1_000 * day);
        let distance = plan.state_at(1_001 * day).position.bits() - before.position.bits();
        let expected = 86_400 * velocity.bits();
        assert!(
            distance.unsigned_abs().abs_diff(expected) <= 1,
            "{distance}"
        );
    }
}

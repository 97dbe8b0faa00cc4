//! Motions that come to rest before they go on: when the second leg is planned, and that nobody sees it.

use super::behaviour::{T01, fly, ms};
use super::{FAST, HZ, Replay, axis};
use crate::axis::Axis;
use crate::{Direction, Goal, Limits, PulseSink, Ramps, Record, Ticks};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

const JERK: Ramps = Ramps::JerkLimited(20_000_000);

/// Plays at a clock of its own, and keeps what it was given.
#[derive(Debug, Default)]
struct Tape {
    records: Vec<Record>,
    given: Ticks,
    now: Ticks,
}

impl PulseSink for Tape {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.given = self.given.max(self.now) + record.ticks();
        self.records.push(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.given.saturating_sub(self.now)
    }

    fn free(&self) -> usize {
        64
    }
}

/// Committed position, heading, target, and whether it is ending.
type Said = (i64, Option<Direction>, i64, bool);

/// When the second leg is planned.
#[derive(Debug, Clone, Copy, PartialEq)]
enum When {
    /// With the first.
    AtOnce,
    /// In a control tick behind it, every fourth refill.
    InATick,
    /// Where the motion comes to it.
    AtLast,
}

/// Orders one behind the other, each so many refills after the one before. Returns what was made of them, and what the axis said at each refill.
fn made(ramps: Ramps, orders: &[(Goal, Limits, u32)], when: When) -> (Vec<Record>, Vec<Said>) {
    let mut axis = axis(FAST).0;
    let mut tape = Tape::default();
    let mut said = Vec::new();
    axis.set_ramps(ramps);
    let mut number = 0;
    for &(goal, limits, refills) in orders {
        // A refused order leaves the motion as it is.
        let _ = axis.redirect(goal, limits);
        if when == When::AtOnce {
            axis.plan.complete();
        }
        for _ in 0..refills {
            number += 1;
            if when == When::InATick && number % 4 == 0 {
                let _ = axis.plan_on(&mut tape);
            }
            let _ = axis.advance(&mut tape);
            said.push((
                axis.committed_position(),
                axis.heading(),
                axis.target(),
                axis.is_ending() || axis.is_at_rest(),
            ));
            tape.now += Ticks::from(HZ / 4_000);
        }
    }
    (tape.records, said)
}

fn limits() -> impl Strategy<Value = Limits> {
    (10u32..500_000, 12u32..29, 12u32..29).prop_map(|(velocity, a, d)| Limits {
        velocity: velocity.into(),
        acceleration: 1 << a,
        deceleration: 1 << d,
    })
}

fn goal() -> impl Strategy<Value = Goal> {
    prop_oneof![
        3 => (-2_000i64..2_000).prop_map(Goal::Rest),
        3 => (-100_000i64..100_000).prop_map(Goal::Rest),
        1 => (-2_000i64..2_000, 0u32..20_000).prop_map(|(target, end)| Goal::Pass(target, end.into())),
        1 => (-100_000i32..100_000).prop_map(|velocity| Goal::Velocity(velocity.into())),
    ]
}

fn ramps() -> impl Strategy<Value = Ramps> {
    prop_oneof![
        Just(Ramps::SinSquared),
        (15u32..32).prop_map(|bits| Ramps::JerkLimited(1 << bits)),
    ]
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() }))]

    /// To the tick, whatever comes when.
    #[test]
    fn pulses_are_the_same_whenever_a_second_leg_is_planned(
        ramps in ramps(),
        orders in prop::collection::vec((goal(), limits(), 1u32..300), 2..8),
    ) {
        let whole = made(ramps, &orders, When::AtOnce);
        prop_assert_eq!(&made(ramps, &orders, When::InATick), &whole);
        prop_assert_eq!(&made(ramps, &orders, When::AtLast), &whole);
    }
}

/// On its way, 100 ms behind the begin.
fn under_way() -> (Axis, Replay) {
    let (mut axis, mut sink) = axis(FAST);
    axis.set_ramps(JERK);
    axis.move_to(50_000, T01).unwrap();
    sink.follow(&axis);
    fly(&mut axis, &mut sink, ms(100));
    (axis, sink)
}

/// One tick, four refills.
fn tick(axis: &mut Axis, sink: &mut Replay) {
    axis.plan_on(sink).unwrap();
    for _ in 0..4 {
        axis.advance(sink).unwrap();
        sink.play(axis.stepper.segment().into());
    }
}

#[test]
fn a_second_leg_is_planned_in_the_tick_behind_that_of_its_order() {
    let (mut axis, mut sink) = under_way();
    for target in [-20_000, -30_000] {
        axis.move_to(target, T01).unwrap();
        sink.follow(&axis);
        assert!(axis.plan.waits_from().is_some());
        assert_eq!(axis.target(), target);
        tick(&mut axis, &mut sink);
        assert!(axis.plan.waits_from().is_some());
    }
    let segment = u64::from(axis.stepper.segment());
    axis.plan_on(&mut sink).unwrap();
    assert_eq!(axis.plan.waits_from(), None);
    // With as much to play as a plan may need.
    assert!(sink.pending() >= 2 * segment);
    super::run(&mut axis, &mut sink);
    assert_eq!(sink.position, -30_000);
}

/// A refill plans nothing as long as there is a tick that may.
#[test]
fn a_refill_plans_a_second_leg_only_where_it_begins() {
    let (mut axis, mut sink) = under_way();
    axis.move_to(-20_000, T01).unwrap();
    sink.follow(&axis);
    let turn = axis.plan.waits_from().unwrap();
    while axis.horizon() < turn {
        assert_eq!(axis.plan.waits_from(), Some(turn));
        let left = axis.horizon();
        axis.advance(&mut sink).unwrap();
        sink.account(&axis);
        sink.play(u64::from(axis.stepper.segment()) / 4);
        assert!(axis.horizon() < turn || turn - left <= 3 * u64::from(axis.stepper.segment()));
    }
    assert_eq!(axis.plan.waits_from(), None);
    super::run(&mut axis, &mut sink);
    assert_eq!(sink.position, -20_000);
}

/// The axis is not at rest where it turns.
#[test]
fn a_stop_in_place_of_what_is_left_is_a_stop() {
    let (mut axis, mut sink) = under_way();
    axis.move_to(-20_000, T01).unwrap();
    tick(&mut axis, &mut sink);
    assert!(axis.plan.waits_from().is_some());
    axis.stop(T01.deceleration).unwrap();
    sink.follow(&axis);
    let rest = axis.target();
    for _ in 0..3 {
        tick(&mut axis, &mut sink);
    }
    super::run(&mut axis, &mut sink);
    assert_eq!(sink.position, rest);
    assert!(rest > 0);
}

/// Set-points that are followed take the place of what is left.
#[test]
fn a_path_in_place_of_what_is_left_is_the_path() {
    let (mut axis, mut sink) = under_way();
    // It is no plan that is followed.
    sink.tolerance = f64::INFINITY;
    axis.move_to(-20_000, T01).unwrap();
    let (begin, here) = axis.course_end();
    let place = crate::Position::from_steps(here.position.whole_steps() + 100);
    axis.follow(begin + ms(20), place).unwrap();
    for _ in 0..40 {
        tick(&mut axis, &mut sink);
    }
    assert!(axis.is_at_rest());
    assert!(axis.committed_position() > 0);
}

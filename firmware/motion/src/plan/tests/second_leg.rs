//! Motions that come to rest before they go on: what is planned at once, and what is left.

use super::properties::{any_clock, magnitude, usual_limits};
use super::smooth::{all_over, goal, smooth};
use super::{Goal, Limits, Plan, Ramps, clock};
use crate::{Clock, PlanError, State, Ticks, Velocity};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// A motion under way, with these ramps.
fn under_way(clock: Clock, goal: Goal, limits: Limits, ramps: Ramps, cut: u64) -> (Plan, Ticks) {
    let mut plan = Plan::at_rest(0, 7);
    plan.redirect(clock, 7, goal, limits, ramps).unwrap();
    let last = plan.phases().last().map_or(7, |phase| phase.start());
    let length = plan.end().unwrap_or(last + u64::from(clock.hz()) / 4) - 7;
    (
        plan,
        7 + ((u128::from(length) * u128::from(cut)) >> 32) as Ticks,
    )
}

/// Where a plan goes on from rest: the same place, no velocity.
fn at_rest(plan: &Plan, t: Ticks) -> State {
    State {
        velocity: Velocity::ZERO,
        ..plan.state_at(t)
    }
}

/// When a plan has come to where nothing changes any more.
fn settled(plan: &Plan) -> Ticks {
    let last = plan
        .phases()
        .last()
        .map_or(plan.start(), |phase| phase.start());
    plan.end().unwrap_or(last)
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Up to the second leg nothing hangs on whether that is planned; and it is the same whenever that is done, and whatever has been looked at
    /// before.
    #[test]
    fn i06_a_second_leg_is_the_same_whenever_it_is_planned(
        clock in any_clock(),
        first in goal(),
        then in goal(),
        limits in (usual_limits(), usual_limits()),
        ramps in smooth(),
        cut in 0u64..=1 << 32,
        looked_at in 0u64..=1 << 33,
    ) {
        let (mut step, at) = under_way(clock, first, limits.0, ramps, cut);
        let before = step;
        if step.leave_for(clock, at, then, limits.1, ramps).is_err() {
            prop_assert_eq!(step.waits_from(), before.waits_from());
            return Ok(());
        }
        let mut whole = before;
        whole.redirect(clock, at, then, limits.1, ramps).unwrap();
        prop_assert_eq!(whole.waits_from(), None);
        prop_assert_eq!(step.destination(), whole.destination());
        let Some(turn) = step.waits_from() else {
            prop_assert_eq!(step.end(), whole.end());
            return Ok(());
        };
        prop_assert_eq!(step.end(), None);
        prop_assert!(turn >= at && settled(&whole) >= turn);
        let times = all_over(&whole, clock, 60);
        for t in times.iter().copied().filter(|t| *t < turn) {
            prop_assert_eq!(step.state_at(t), whole.state_at(t));
        }
        // It stands there.
        let rest = step.state_at(turn);
        prop_assert_eq!(rest.velocity, Velocity::ZERO);
        prop_assert_eq!(step.state_at(Ticks::MAX - 1), rest);
        prop_assert!(rest.position.bits().abs_diff(whole.state_at(turn).position.bits()) < 1 << 22);

        let when = at + ((u128::from(settled(&whole) - at) * u128::from(looked_at)) >> 32) as Ticks;
        step.enter(when);
        step.complete();
        step.complete();
        prop_assert_eq!(step.end(), whole.end());
        prop_assert_eq!(step.last_ramp(), whole.last_ramp());
        for t in times {
            step.enter(t);
            prop_assert_eq!(step.exact_at(t), whole.exact_at(t));
        }
    }

    /// A second leg is the motion from rest: it takes as long as one that begins there.
    #[test]
    fn i03_a_second_leg_takes_no_longer_than_from_rest(
        clock in any_clock(),
        first in goal(),
        then in goal(),
        limits in usual_limits(),
        ramps in smooth(),
        cut in 0u64..=1 << 32,
        other_jerk in magnitude(1_000, u32::MAX),
    ) {
        let (mut plan, at) = under_way(clock, first, limits, ramps, cut);
        prop_assume!(plan.leave_for(clock, at, then, limits, ramps).is_ok());
        let Some(turn) = plan.waits_from() else { return Ok(()) };
        // Beyond half the span the number of a place says another way.
        prop_assume!(plan.left.is_some_and(|leg| leg.way < 1 << 127));
        plan.complete();
        let from_rest = |ramps| Plan::new(clock, turn, at_rest(&plan, turn), then, limits, ramps).unwrap();
        let takes = |plan: &Plan| settled(plan) - turn;
        // The place where it begins is rounded, and the tick; which a creeping motion makes more of.
        let rounded = |time: Ticks| 4 + time / 100_000;
        let like_it = takes(&from_rest(ramps));
        prop_assert!(takes(&plan).abs_diff(like_it) <= rounded(like_it), "{} for {like_it}", takes(&plan));
        if ramps == Ramps::SinSquared {
            let jerk_limited = takes(&from_rest(Ramps::JerkLimited(other_jerk)));
            prop_assert!(takes(&plan) <= jerk_limited + rounded(jerk_limited));
        }
    }

    /// From rest there is a velocity for every way, so that nothing can be wrong with a second leg.
    #[test]
    fn i10_a_smooth_move_from_rest_is_never_out_of_range(
        clock in any_clock(),
        target in -4_294_967_295i64..=4_294_967_295,
        bits in 0u32..32,
        velocity in 1u64..=1 << 53,
        rates in any::<(u32, u32, u32)>(),
    ) {
        let limits = Limits {
            velocity: crate::Speed::from_bits(velocity >> bits).max(crate::Speed::from_bits(1)),
            acceleration: (rates.0 >> bits).max(1),
            deceleration: (rates.1 >> bits).max(1),
        };
        let rest = Plan::at_rest(0, 0);
        for target in [target, target >> bits, 1, -1] {
            for ramps in [Ramps::JerkLimited((rates.2 >> bits).max(1)), Ramps::SinSquared] {
                let mut plan = rest;
                let made = plan.leave_for(clock, 0, Goal::Rest(target), limits, ramps);
                prop_assert!(made.is_ok(), "{target}: {made:?}");
                prop_assert_eq!(plan.waits_from(), None);
            }
        }
    }
}

const LIMITS: Limits = Limits {
    velocity: crate::Speed::per_second(100_000),
    acceleration: 500_000,
    deceleration: 400_000,
};

/// Whatever turns round leaves a leg, and nothing else does.
#[test]
fn i06_only_what_comes_to_rest_first_is_left_for_later() {
    let clock = clock(168_000_000);
    for ramps in [Ramps::SinSquared, Ramps::JerkLimited(5_000_000)] {
        let (plan, at) = under_way(clock, Goal::Rest(100_000), LIMITS, ramps, 1 << 28);
        let waits = |goal| {
            let mut plan = plan;
            plan.leave_for(clock, at, goal, LIMITS, ramps).unwrap();
            plan.waits_from().is_some()
        };
        assert!(waits(Goal::Rest(-2_000)));
        assert!(waits(Goal::Pass(-2_000, 10_000.into())));
        assert!(waits(Goal::Velocity((-3_000).into())));
        assert!(!waits(Goal::Rest(120_000)));
        assert!(!waits(Goal::Pass(120_000, 10_000.into())));
        assert!(!waits(Goal::Velocity(3_000.into())));
        assert!(!waits(Goal::Velocity(0.into())));
    }
    let (mut plan, at) = under_way(clock, Goal::Rest(100_000), LIMITS, Ramps::Linear, 1 << 28);
    plan.leave_for(clock, at, Goal::Rest(-2_000), LIMITS, Ramps::Linear)
        .unwrap();
    assert_eq!(plan.waits_from(), None);
}

/// The same order again changes nothing; another one takes the place of what is left; one that cannot be leaves it.
#[test]
fn i06_what_is_left_goes_with_its_order() {
    let clock = clock(168_000_000);
    let ramps = Ramps::JerkLimited(5_000_000);
    let (mut plan, at) = under_way(clock, Goal::Rest(100_000), LIMITS, ramps, 1 << 28);
    let back = Goal::Rest(-2_000);
    plan.leave_for(clock, at, back, LIMITS, ramps).unwrap();
    let turn = plan.waits_from();
    assert!(turn.is_some());
    plan.leave_for(clock, at + 5, back, LIMITS, ramps).unwrap();
    assert_eq!(plan.waits_from(), turn);
    let too_far = plan.leave_for(clock, at + 5, Goal::Rest(1 << 40), LIMITS, ramps);
    assert_eq!(too_far, Err(PlanError::OutOfRange));
    assert_eq!(plan.waits_from(), turn);
    let mut stopped = plan;
    let stop = Goal::Velocity(0.into());
    stopped
        .leave_for(clock, at + 9, stop, LIMITS, ramps)
        .unwrap();
    assert_eq!(stopped.waits_from(), None);
    let end = stopped.end();
    stopped.complete();
    assert_eq!(stopped.end(), end);
    plan.complete();
    assert_eq!(
        plan.state_at(Ticks::MAX).position,
        crate::Position::from_steps(-2_000)
    );
}

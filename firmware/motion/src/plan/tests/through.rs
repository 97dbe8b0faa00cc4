//! Moves through a target: where and with which velocity they pass it, and what follows.

use proptest::prelude::*;

use super::{Goal, Limits, Plan, Ramps, clock, per_second, state, steps};
use crate::{PlanError, Ticks};

const HZ: u32 = 84_000_000;

fn limits(velocity: u32, acceleration: u32, deceleration: u32) -> Limits {
    Limits {
        velocity: velocity.into(),
        acceleration,
        deceleration,
    }
}

/// A plan through `target` from `from` steps at `velocity`.
fn through(from: i64, velocity: i32, target: i64, end: u32, limits: Limits) -> Plan {
    let clock = clock(HZ);
    let plan = Plan::velocity(
        clock,
        0,
        state(clock, from, velocity),
        velocity.max(1).into(),
        limits,
    );
    plan.unwrap()
        .then_move_through(clock, 0, target, end.into(), limits)
        .unwrap()
}

/// The first tick at which the plan has come to `target` from below or above.
fn passing(plan: &Plan, target: i64, upwards: bool) -> Ticks {
    let is_past = |t: Ticks| {
        let way = steps(plan.state_at(t)) - target as f64;
        if upwards { way >= 0.0 } else { way <= 0.0 }
    };
    let (mut low, mut high) = (0, 1_000 * u64::from(HZ));
    assert!(is_past(high));
    while low < high {
        let middle = u64::midpoint(low, high);
        if is_past(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

#[test]
fn the_end_velocity_is_there_at_the_target_and_stays() {
    let plan = through(0, 0, 100_000, 20_000, limits(100_000, 500_000, 250_000));
    let at = passing(&plan, 100_000, true);
    let velocity = |t| per_second(clock(HZ), plan.state_at(t));
    assert!((velocity(at) - 20_000.0).abs() < 1.0, "{}", velocity(at));
    assert!((velocity(at + 100_000_000) - 20_000.0).abs() < 0.01);
    assert_eq!(plan.end(), None);
    // 0.2 s up, 0.32 s down, and the rest of the way at full speed.
    let seconds = 0.2 + 0.32 + (100_000.0 - 10_000.0 - 19_200.0) / 100_000.0;
    assert!((at as f64 / f64::from(HZ) - seconds).abs() < 1e-6);
}

#[test]
fn a_way_too_short_ends_behind_the_target() {
    let plan = through(0, 0, 100, 20_000, limits(100_000, 500_000, 250_000));
    let at = passing(&plan, 100, true);
    let velocity = per_second(clock(HZ), plan.state_at(at));
    assert!((velocity - 10_000.0).abs() < 1.0, "{velocity}");
    let later = per_second(clock(HZ), plan.state_at(u64::from(HZ)));
    assert!((later - 20_000.0).abs() < 0.01);
}

#[test]
fn too_fast_for_the_end_velocity_it_is_braked_behind_the_target() {
    let plan = through(0, 50_000, 100, 1_000, limits(100_000, 500_000, 500_000));
    assert_eq!(plan.phases().count(), 2);
    let later = per_second(clock(HZ), plan.state_at(u64::from(HZ)));
    assert!((later - 1_000.0).abs() < 0.01);
}

#[test]
fn without_an_end_velocity_it_is_an_ordinary_move() {
    let plan = through(0, 0, 5_000, 0, limits(10_000, 100_000, 100_000));
    assert_eq!(
        plan.state_at(plan.end().unwrap()),
        state(clock(HZ), 5_000, 0)
    );
    let plan = through(0, 0, 0, 700, limits(10_000, 100_000, 100_000));
    assert_eq!(plan.end(), Some(0));
}

proptest! {
    /// From rest, and from any velocity in either direction: no limit is broken, and the target is passed with no more than the
    /// greatest of the velocities involved.
    #[test]
    fn the_target_is_passed_and_the_end_velocity_kept(
        from in -100_000_i64..100_000,
        velocity in -50_000..50_000,
        target in -100_000_i64..100_000,
        end in 1_u32..80_000,
        top in 1_000_u32..80_000,
        acceleration in 10_000_u32..1_000_000,
        deceleration in 10_000_u32..1_000_000,
    ) {
        prop_assume!(from != target);
        let limits = limits(top, acceleration, deceleration);
        let clock = clock(HZ);
        let start = state(clock, from, velocity);
        let plan = Plan::velocity(clock, 0, start, velocity.into(), limits).unwrap();
        let plan = plan.then_move_through(clock, 0, target, end.into(), limits).unwrap();
        // The longest way takes 200 s, and as much again of braking from the wrong direction and coming back.
        let kept = per_second(clock, plan.state_at(1_000 * u64::from(HZ)));
        let expected = f64::from(end.min(top)) * (target - from).signum() as f64;
        prop_assert!((kept - expected).abs() < 0.01, "{} instead of {}", kept, expected);
        let at = passing(&plan, target, target > from);
        let passed = per_second(clock, plan.state_at(at)).abs();
        let most = f64::from(end.min(top)).max(f64::from(velocity).abs());
        prop_assert!(passed <= most + 1.0, "{} of {}", passed, most);
        let mut before = plan.state_at(0);
        for sample in 1..400_u64 {
            let t = sample * u64::from(HZ) / 100;
            let now = plan.state_at(t);
            let change = (per_second(clock, now) - per_second(clock, before)).abs() * 100.0;
            prop_assert!(change <= f64::from(acceleration.max(deceleration)) * 1.001 + 1.0);
            before = now;
        }
    }
}

/// Braking from the end velocity is the measure of the distance: one that leads round all positions is none.
#[test]
fn an_end_velocity_that_brakes_beyond_the_span_is_refused() {
    let clock = clock(HZ);
    let pass = |end: u32| {
        let rest = Plan::at_rest(0, 0);
        let limits = limits(200_000, 500_000, 1);
        rest.then_move_through(clock, 0, 100_000, end.into(), limits)
    };
    // 92,000² / 2 is 4.232e9 steps, and 2^32 are 4.295e9.
    assert!(pass(92_000).is_ok());
    for end in [93_000, 100_000, 131_000, 200_000] {
        assert_eq!(pass(end).err(), Some(PlanError::OutOfRange), "{end}");
    }
}

/// A smooth plan from a steady velocity through a target `gap` steps ahead.
fn smoothly(velocity: i32, gap: i64, end: u32, limits: Limits, ramps: Ramps) -> Plan {
    let clock = clock(HZ);
    let mut plan = Plan::new(
        clock,
        0,
        state(clock, -gap, velocity),
        Goal::Velocity(velocity.into()),
        limits,
        ramps,
    )
    .unwrap();
    let target = Goal::Pass(0, end.into());
    plan.replan(clock, 0, target, limits, ramps).unwrap();
    plan
}

/// Whoever is too fast for a stop before the target, or for the end velocity there, need not turn round for it.
#[test]
fn a_smooth_motion_passes_a_target_that_is_near() {
    let limits = limits(50_000, 500_000, 500_000);
    let velocity = |plan: &Plan, t| per_second(clock(HZ), plan.state_at(t));
    let limited = Ramps::limited(50_000_000);
    for ramps in [Ramps::SinSquared].into_iter().chain(limited) {
        // A stop takes 2,500 steps and more; braking to 40,000 steps/s takes 2,000 at most, and to 1,000 more than 100.
        for (gap, end) in [(2_400, 40_000), (100, 1_000), (100, 49_999)] {
            let plan = smoothly(50_000, gap, end, limits, ramps);
            let lowest = (0..1_000)
                .map(|part| velocity(&plan, part * u64::from(HZ) / 1_000))
                .fold(f64::MAX, f64::min);
            let expected = f64::from(end);
            assert!(lowest > expected - 0.01, "{lowest} {gap} {end} {ramps:?}");
            let kept = velocity(&plan, 10 * u64::from(HZ));
            assert!((kept - expected).abs() < 0.01, "{kept} {gap} {end}");
        }
        let plan = smoothly(50_000, 2_400, 40_000, limits, ramps);
        let passed = velocity(&plan, passing(&plan, 0, true));
        assert!((passed - 40_000.0).abs() < 1.0, "{passed} {ramps:?}");
    }
}

proptest! {
    /// From any moment of a smooth motion to rest at the target: it passes it in its own direction, and never turns round.
    #[test]
    fn a_smooth_motion_to_rest_may_pass_its_target_after_all(
        target in 1_000_i64..100_000,
        end in 1_u32..80_000,
        top in 1_000_u32..80_000,
        acceleration in 10_000_u32..1_000_000,
        deceleration in 10_000_u32..1_000_000,
        jerk in 1_000_000_u32..1_000_000_000,
        is_sine: bool,
        part in 1_u64..1_000,
    ) {
        let clock = clock(HZ);
        let limits = limits(top, acceleration, deceleration);
        let limited = Ramps::limited(jerk).filter(|_| !is_sine);
        let ramps = limited.unwrap_or(Ramps::SinSquared);
        let rest = Goal::Rest(target);
        let mut plan = Plan::new(clock, 0, state(clock, 0, 0), rest, limits, ramps).unwrap();
        let at = plan.end().unwrap() / 1_000 * part;
        let before = per_second(clock, plan.state_at(at));
        plan.replan(clock, at, Goal::Pass(target, end.into()), limits, ramps).unwrap();
        let expected = f64::from(end.min(top));
        let kept = per_second(clock, plan.state_at(at + 1_000 * u64::from(HZ)));
        prop_assert!((kept - expected).abs() < 0.01, "{kept} instead of {expected}");
        let last = plan.phases().last().unwrap().start();
        for sample in 0..=400 {
            let now = per_second(clock, plan.state_at(at + (last - at) / 400 * sample));
            prop_assert!(now > -0.01, "{now} behind {before}");
        }
    }
}

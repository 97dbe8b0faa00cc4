//! What holds for every plan: limits, landing, direction, duration, symmetry, planning again. The numbers are those of the
//! invariants; i07 is in the tests of units in `cia402`, i11 in those of profile velocity there; smooth ramps and i12 are in `smooth`.

use super::{Goal, Limits, Plan, Ramps, amount, clock, corners, per_second, state, steps};
use crate::{Clock, PlanError, Position, Speed, State, Ticks, Velocity};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

/// Numbers of all magnitudes, from `least` to `most`.
pub(super) fn magnitude(least: u32, most: u32) -> impl Strategy<Value = u32> {
    (0..=most.ilog2(), any::<u32>()).prop_map(move |(bits, noise)| {
        let top = 1u64 << (bits + 1);
        (u64::from(noise) % top).clamp(least.into(), most.into()) as u32
    })
}

/// The same with a sign.
pub(super) fn signed(most: u32) -> impl Strategy<Value = i32> {
    (magnitude(0, most), any::<bool>()).prop_map(|(value, negative)| {
        if negative {
            -(value as i32)
        } else {
            value as i32
        }
    })
}

pub(super) fn any_clock() -> impl Strategy<Value = Clock> {
    prop_oneof![
        Just(84_000_000),
        Just(168_000_000),
        Just(1_000_000_000),
        Just(1_000_000)
    ]
    .prop_map(clock)
}

/// Half of them no whole numbers. Slower ones, whose ways are not so long, are in the tests of the axis.
fn speed(most: u32) -> impl Strategy<Value = Speed> {
    (magnitude(1, most), any::<u32>(), any::<bool>()).prop_map(|(whole, part, is_whole)| {
        let part = if is_whole { 0 } else { part };
        Speed::from_bits(u64::from(whole) << 32 | u64::from(part))
    })
}

pub(super) fn any_limits() -> impl Strategy<Value = Limits> {
    let rate = || magnitude(1, u32::MAX);
    (speed(u32::MAX - 1), rate(), rate()).prop_map(|(velocity, acceleration, deceleration)| {
        Limits {
            velocity,
            acceleration,
            deceleration,
        }
    })
}

/// Limits of real machines.
pub(super) fn usual_limits() -> impl Strategy<Value = Limits> {
    (
        speed(4_000_000),
        magnitude(10, 100_000_000),
        magnitude(10, 100_000_000),
    )
        .prop_map(|(velocity, acceleration, deceleration)| Limits {
            velocity,
            acceleration,
            deceleration,
        })
}

pub(super) fn any_start(clock: Clock) -> impl Strategy<Value = State> {
    (any::<i64>(), signed(4_000_000)).prop_map(move |(bits, velocity)| State {
        position: Position::from_bits(bits),
        velocity: Velocity::from_speed(clock, velocity.into()),
    })
}

/// Whether a stop from `v0` ends before the span of positions does, where they would wrap.
pub(super) fn within_span(v0: i32, limits: Limits) -> bool {
    f64::from(v0).powi(2) / 2.0 / f64::from(limits.deceleration) < 2e9
}

/// Ticks all over a plan, its corners among them.
pub(super) fn samples(plan: &Plan, count: u64) -> Vec<Ticks> {
    let end = plan.end().unwrap();
    let length = u128::from(end - plan.start());
    let mut ticks: Vec<Ticks> = (0..=count)
        .map(|i| plan.start() + (length * u128::from(i) / u128::from(count)) as Ticks)
        .chain(corners(plan))
        .collect();
    ticks.sort_unstable();
    ticks.dedup();
    ticks
}

/// The duration in seconds, by the formulas in floating point.
fn ideal(distance: f64, v0: f64, limits: Limits) -> f64 {
    let (v, a, d) = (
        amount(limits.velocity),
        f64::from(limits.acceleration),
        f64::from(limits.deceleration),
    );
    let side = if distance - v0 * v0.abs() / (2.0 * d) < 0.0 {
        -1.0
    } else {
        1.0
    };
    let (mut s, mut v0, mut time) = (distance * side, v0 * side, 0.0);
    if v0 < 0.0 {
        time += -v0 / d;
        s += v0 * v0 / (2.0 * d);
        v0 = 0.0;
    }
    if v0 > v {
        time += (v0 - v) / d;
        s -= (v0 * v0 - v * v) / (2.0 * d);
        v0 = v;
    }
    let peak = ((2.0 * a * d * s + d * v0 * v0) / (a + d))
        .max(0.0)
        .sqrt()
        .min(v)
        .max(v0);
    let left = s - (peak * peak - v0 * v0) / (2.0 * a) - peak * peak / (2.0 * d);
    time + (peak - v0) / a
        + peak / d
        + if peak > 0.0 {
            left.max(0.0) / peak
        } else {
            0.0
        }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Limits hold at all times, and the deceleration rules whenever the speed falls.
    #[test]
    fn i01_limits_are_never_exceeded(
        (clock, from) in any_clock().prop_flat_map(|c| (Just(c), any_start(c))),
        target: i32,
        limits in any_limits(),
    ) {
        let Ok(plan) = Plan::move_to(clock, 9, from, target.into(), limits) else { return Ok(()) };
        let top = per_second(clock, from).abs().max(amount(limits.velocity));
        let rate = f64::from(clock.hz());
        for t in samples(&plan, 50) {
            let now = per_second(clock, plan.state_at(t));
            // One unit in the last place of a Q56 velocity.
            let ulp = rate / 2f64.powi(55);
            prop_assert!(now.abs() <= top * (1.0 + 1e-12) + ulp, "{now} > {top}");
            for step in [1u64, 1000] {
                let next = per_second(clock, plan.state_at(t + step));
                let change = (next - now) / (step as f64) * rate;
                let slack = 1e-9 * top.max(1.0) * rate / step as f64 * 1e-6 + ulp * rate;
                let (a, d) = (f64::from(limits.acceleration), f64::from(limits.deceleration));
                let growing = next.abs() > now.abs() && next * now >= 0.0;
                let same_side = next * now > 0.0;
                let limit = if growing { a } else if same_side { d } else { a.max(d) };
                // A chord over the peak of a triangle belongs to both ramps.
                let limit = if step > 1 { a.max(d) } else { limit };
                prop_assert!(change.abs() <= limit * (1.0 + 1e-9) + slack, "{change} at {t}, limits {limits:?}");
            }
        }
    }

    /// The end is the target, exactly, and the axis stands.
    #[test]
    fn i02_a_move_lands_on_its_target(
        (clock, from) in any_clock().prop_flat_map(|c| (Just(c), any_start(c))),
        target: i32,
        limits in any_limits(),
    ) {
        match Plan::move_to(clock, 5, from, target.into(), limits) {
            Ok(plan) => {
                let end = plan.end().unwrap();
                let there = State { position: Position::from_steps(target.into()), velocity: Velocity::ZERO };
                prop_assert_eq!(plan.state_at(end), there);
                prop_assert_eq!(plan.state_at(Ticks::MAX), there);
                prop_assert_eq!(plan.state_at(0), plan.state_at(5), "before its start it waits");
                // It arrives there, and does not jump there: one tick before, a landing is a fraction of a step away.
                let before = steps(plan.state_at(end - 1)) - f64::from(target);
                prop_assert!(before.abs() <= 0.5 || end == 5, "{before} steps away");
            }
            Err(error) => prop_assert_eq!(error, PlanError::OutOfRange),
        }
    }

    /// The position is continuous over corners, monotone between turns, and turns at most once.
    #[test]
    fn i03_a_plan_turns_at_most_once(
        from_steps in -1_000_000i64..1_000_000,
        v0 in signed(1_000_000),
        target in -1_000_000i64..1_000_000,
        limits in usual_limits(),
    ) {
        let clock = clock(168_000_000);
        prop_assume!(within_span(v0, limits));
        let plan = Plan::move_to(clock, 0, state(clock, from_steps, v0), target, limits).unwrap();
        let mut turns = 0;
        let mut heading = 0i64;
        let mut last = plan.state_at(0);
        for t in samples(&plan, 200) {
            let now = plan.state_at(t);
            let change = now.position.bits() - last.position.bits();
            // Where a phase was anchored anew, positions may differ by a few units in the last place.
            if change.abs() > 64 {
                turns += i32::from(heading != 0 && heading != change.signum());
                heading = change.signum();
            }
            // The side of the velocity is the side of the change.
            prop_assert!(change.signum() * now.velocity.bits().signum() >= 0 || change.abs() <= 64
                || last.velocity.bits().signum() != now.velocity.bits().signum());
            last = now;
        }
        prop_assert!(turns <= 1, "{turns} turns");
        for t in corners(&plan) {
            let (a, b) = (plan.state_at(t.saturating_sub(1)), plan.state_at(t));
            let jump = (b.position.bits() - a.position.bits()).unsigned_abs() as f64 / 2f64.powi(32);
            let speed = a.velocity.bits().unsigned_abs().max(b.velocity.bits().unsigned_abs()) as f64 / 2f64.powi(56);
            let ramp = f64::from(limits.acceleration.max(limits.deceleration)) / 168e6 / 168e6;
            prop_assert!(jump <= speed + ramp + 1e-8, "jump of {jump} at {t}");
        }
    }

    /// Beyond its ends a move goes only as far as it takes to stop.
    #[test]
    fn i02_a_move_overshoots_only_as_far_as_it_must(
        v0 in signed(1_000_000),
        target in -1_000_000i64..1_000_000,
        limits in usual_limits(),
    ) {
        let clock = clock(168_000_000);
        prop_assume!(within_span(v0, limits));
        let plan = Plan::move_to(clock, 0, state(clock, 0, v0), target, limits).unwrap();
        let stop = f64::from(v0) * f64::from(v0.abs()) / (2.0 * f64::from(limits.deceleration));
        let low = stop.min(0.0).min(target as f64);
        let high = stop.max(0.0).max(target as f64);
        let slack = 1e-6 + 1e-9 * stop.abs();
        for t in samples(&plan, 100) {
            let x = steps(plan.state_at(t));
            prop_assert!(x >= low - slack && x <= high + slack, "{x} outside {low}..{high}");
        }
    }

    /// No earlier than ideal, no later than a tick, but for the rounding of what went in.
    #[test]
    fn i04_the_duration_is_ideal(
        clock in any_clock(),
        v0 in signed(400_000),
        target in -2_000_000_000i64..2_000_000_000,
        limits in usual_limits(),
    ) {
        let limits = Limits { velocity: limits.velocity.min((clock.hz() / 2).into()), ..limits };
        let from = state(clock, 0, v0);
        let Ok(plan) = Plan::move_to(clock, 3, from, target, limits) else { return Ok(()) };
        let ideal = ideal(target as f64, per_second(clock, from), limits) * f64::from(clock.hz());
        let real = (plan.end().unwrap() - 3) as f64;
        // An overshoot of almost nothing is no overshoot: that is the only time a plan may save.
        prop_assert!(real >= ideal * (1.0 - 1e-6) - 1.0, "{real} of {ideal}");
        prop_assert!(real <= ideal * (1.0 + 2f64.powi(-16)) + 1.0, "{real} of {ideal}");
    }

    /// The mirror image of a move is a mirror image, bit by bit.
    #[test]
    fn i05_a_mirrored_move_is_the_mirror_image(
        (clock, from) in any_clock().prop_flat_map(|c| (Just(c), any_start(c))),
        target in -i32::MAX..=i32::MAX,
        limits in any_limits(),
    ) {
        let mirror = |s: State| State {
            position: Position::from_bits(s.position.bits().wrapping_neg()),
            velocity: Velocity::from_bits(-s.velocity.bits()),
        };
        let one = Plan::move_to(clock, 0, from, target.into(), limits);
        let other = Plan::move_to(clock, 0, mirror(from), -i64::from(target), limits);
        prop_assume!(from.position.bits() != i64::MIN);
        match (one, other) {
            (Ok(one), Ok(other)) => {
                prop_assert_eq!(one.end(), other.end());
                for t in samples(&one, 50) {
                    prop_assert_eq!(mirror(one.state_at(t)), other.state_at(t), "at {}", t);
                }
            }
            (one, other) => prop_assert_eq!(one.err(), other.err()),
        }
    }

    /// Planning again to the same target, at any ticks, changes nothing.
    #[test]
    fn i06_planning_again_does_not_change_the_end(
        clock in any_clock(),
        v0 in signed(400_000),
        target in -2_000_000_000i64..2_000_000_000,
        limits in usual_limits(),
        mut cuts in proptest::collection::vec(0u64..=1 << 32, 1..8),
    ) {
        let from = state(clock, 0, v0);
        prop_assume!(within_span(v0, limits));
        let Ok(first) = Plan::move_to(clock, 3, from, target, limits) else { return Ok(()) };
        let end = first.end().unwrap();
        cuts.sort_unstable();
        let mut plan = first;
        for (replans, cut) in (1u64..).zip(cuts) {
            let at = 3 + ((u128::from(end - 3) * u128::from(cut)) >> 32) as Ticks;
            let before = plan.state_at(at);
            plan = plan.then_move_to(clock, at, target, limits).unwrap();
            prop_assert_eq!(plan.state_at(at), before);
            let moved = plan.end().unwrap().abs_diff(end);
            prop_assert!(moved <= replans, "{moved} ticks after {replans}, cut at {at} of {end}");
        }
    }

    /// A stop is never longer than v²/2d.
    #[test]
    fn i08_a_stop_takes_its_distance_and_no_more(
        clock in any_clock(),
        v0 in signed(4_000_000),
        deceleration in magnitude(100, u32::MAX),
    ) {
        let from = state(clock, 0, v0);
        let limits = Limits { velocity: 0.into(), acceleration: 0, deceleration };
        let plan = Plan::velocity(clock, 0, from, 0.into(), limits).unwrap();
        let v = per_second(clock, from);
        let way = v * v.abs() / (2.0 * f64::from(deceleration));
        prop_assume!(way.abs() < 2e9);
        let real = steps(plan.state_at(plan.end().unwrap()));
        prop_assert!((real - way).abs() <= 1e-6 + way.abs() * 1e-8, "{real} for {way}");
        let time = v.abs() / f64::from(deceleration) * f64::from(clock.hz());
        let ticks = plan.end().unwrap() as f64;
        prop_assert!(ticks >= time - 1e-3 - time * 1e-8 && ticks <= time + 1.001 + time * 1e-8);
    }

    /// Overspeed is braked; it never grows first.
    #[test]
    fn i09_a_lowered_limit_never_accelerates_first(
        v0 in magnitude(1000, 1_000_000),
        part in 1u32..1000,
        target in 0i64..2_000_000_000,
        limits in usual_limits(),
    ) {
        let clock = clock(168_000_000);
        let limits = Limits { velocity: ((u64::from(v0) * u64::from(part) / 1000).max(1) as u32).into(), ..limits };
        let from = state(clock, 0, v0 as i32);
        prop_assume!(within_span(v0 as i32, limits));
        let plan = Plan::move_to(clock, 0, from, target, limits).unwrap();
        let mut last = from.velocity;
        for t in samples(&plan, 100) {
            let now = plan.state_at(t).velocity;
            if last.bits() > Velocity::from_speed(clock, limits.velocity.signed(false)).bits() {
                prop_assert!(now <= last, "speeds up at {t}");
            }
            last = now;
        }
    }

    /// Anything at all gives a plan or an error.
    #[test]
    fn i10_no_input_breaks_a_plan(
        clock in any_clock(),
        start: Ticks,
        bits: (i64, i64),
        target: i64,
        speed: i32,
        (velocity, acceleration, deceleration) in any::<(u32, u32, u32)>(),
        zero in 0..6,
        when: Ticks,
    ) {
        let limits = Limits {
            velocity: if zero == 0 { 0.into() } else { velocity.into() },
            acceleration: if zero == 1 { 0 } else { acceleration },
            deceleration: if zero == 2 { 0 } else { deceleration },
        };
        let from = State { position: Position::from_bits(bits.0), velocity: Velocity::from_bits(bits.1) };
        for plan in [
            Plan::move_to(clock, start, from, target, limits),
            Plan::move_to(clock, start, from, target >> 32, limits),
            Plan::velocity(clock, start, from, speed.into(), limits),
        ].into_iter().flatten() {
            plan.state_at(when);
            prop_assert!(plan.end().is_none_or(|end| end >= start));
            prop_assert!(plan.next_corner(when).is_none_or(|corner| corner > when));
        }
    }
}

#[test]
fn i10_extreme_inputs_are_planned_or_refused() {
    let extremes = [0u32, 1, 2, 1 << 31, u32::MAX - 1, u32::MAX];
    let places = [i64::from(i32::MIN), -1, 0, 1, i64::from(i32::MAX)];
    for hz in [1_000_000, 168_000_000, 1_000_000_000] {
        let clock = clock(hz);
        for velocity in extremes {
            for acceleration in extremes {
                for deceleration in extremes {
                    let limits = Limits {
                        velocity: velocity.into(),
                        acceleration,
                        deceleration,
                    };
                    for from in places {
                        for target in places {
                            check_extreme(clock, from, target, limits);
                        }
                    }
                }
            }
        }
    }
}

fn check_extreme(clock: Clock, from: i64, target: i64, limits: Limits) {
    let plan = Plan::move_to(clock, 1, state(clock, from, 0), target, limits);
    let zero = match limits {
        Limits {
            velocity: Speed::ZERO,
            ..
        } => Some(PlanError::ZeroVelocity),
        Limits {
            acceleration: 0, ..
        } => Some(PlanError::ZeroAcceleration),
        Limits {
            deceleration: 0, ..
        } => Some(PlanError::ZeroDeceleration),
        _ => None,
    };
    assert_eq!(plan.as_ref().err().copied(), zero);
    if let Ok(plan) = plan {
        let end = plan.end().unwrap();
        assert_eq!(plan.state_at(end).position, Position::from_steps(target));
        assert_eq!(end == 1, from == target);
        // No stall: on its way, it moves.
        let middle = plan.state_at(1 + end / 2);
        assert!(
            from == target || middle.velocity != Velocity::ZERO || end < 8,
            "{limits:?}"
        );
    }
}

#[test]
fn i11_a_velocity_crosses_the_span_without_a_jump() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 4_000_000.into(),
        acceleration: 1_000_000,
        deceleration: 1_000_000,
    };
    let plan = Plan::velocity(clock, 0, state(clock, 0, 0), 4_000_000.into(), limits).unwrap();
    assert_eq!(plan.end(), None);
    let hour = 3600 * 168_000_000u64;
    let mut last = plan.state_at(hour).position.bits();
    // Every millisecond for three seconds, hours later: always the same 4000 steps.
    for millisecond in 1..3000u64 {
        let now = plan
            .state_at(1_000_000 * hour + millisecond * 168_000)
            .position
            .bits();
        if millisecond > 1 {
            assert!((now.wrapping_sub(last) - (4000i64 << 32)).abs() <= 1 << 10);
        }
        last = now;
    }
    // A second is 4 000 000 steps, however often that wrapped.
    let second = plan
        .state_at(hour + 168_000_000)
        .position
        .bits()
        .wrapping_sub(plan.state_at(hour).position.bits());
    assert!((second - (4_000_000i64 << 32)).abs() <= 4);
}

#[test]
fn i03_a_move_over_most_of_the_span_keeps_its_direction() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 1_000_000.into(),
        acceleration: 1_000_000,
        deceleration: 1_000_000,
    };
    let from = state(clock, i32::MIN.into(), 1000);
    let smooth = Ramps::limited(1_000_000);
    for ramps in [Ramps::Linear, Ramps::SinSquared].into_iter().chain(smooth) {
        let goal = Goal::Rest(i32::MAX.into());
        let plan = Plan::new(clock, 0, from, goal, limits, ramps).unwrap();
        for t in samples(&plan, 100) {
            assert!(
                plan.state_at(t).velocity >= Velocity::ZERO,
                "{ramps:?} at {t}"
            );
        }
        assert!(plan.end().unwrap() < 4300 * 168_000_000);
    }
}

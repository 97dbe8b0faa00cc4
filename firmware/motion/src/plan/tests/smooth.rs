//! The invariants for smooth ramps: sin² and limited jerk.

use super::properties::{
    any_clock, any_start, magnitude, samples, signed, usual_limits, within_span,
};
use super::{Goal, Limits, Plan, Ramps, amount, clock, per_second, state, steps};
use crate::{Clock, PlanError, Position, State, Ticks, Velocity};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

/// sin² ramps, and more often those of limited jerk if they are built in.
pub(super) fn smooth() -> impl Strategy<Value = Ramps> {
    (magnitude(1_000, u32::MAX), 0..4).prop_map(|(jerk, number)| {
        let limited = Ramps::limited(jerk).filter(|_| number > 0);
        limited.unwrap_or(Ramps::SinSquared)
    })
}

pub(super) fn goal() -> impl Strategy<Value = Goal> {
    prop_oneof![
        3 => (-1_000_000i64..1_000_000).prop_map(Goal::Rest),
        1 => (-1_000_000i64..1_000_000, 0u32..100_000).prop_map(|(target, end)| Goal::Pass(target, end.into())),
        1 => (-1_000_000i32..1_000_000).prop_map(|velocity| Goal::Velocity(velocity.into())),
        1 => Just(Goal::Velocity(0.into())),
    ]
}

/// The acceleration at a tick in steps/s².
fn acceleration(plan: &Plan, clock: Clock, t: Ticks) -> f64 {
    if plan.end().is_some_and(|end| t >= end) {
        return 0.0;
    }
    let phase = plan.phase_at(t);
    phase.map_or(0.0, |phase| phase.acceleration_at(clock, t) as f64)
}

/// How long a jerk-limited ramp over a change of velocity takes.
fn ramp_time(change: f64, most: f64, jerk: f64) -> f64 {
    if change >= most * most / jerk {
        change / most + most / jerk
    } else {
        2.0 * (change / jerk).sqrt()
    }
}

/// The fastest jerk-limited move from rest to rest, in seconds.
pub(super) fn double_s(distance: f64, limits: Limits, jerk: f64) -> f64 {
    let (a, d) = (
        f64::from(limits.acceleration),
        f64::from(limits.deceleration),
    );
    let time = |v: f64| ramp_time(v, a, jerk) + ramp_time(v, d, jerk);
    let way = |v: f64| v / 2.0 * time(v);
    let top = amount(limits.velocity);
    if way(top) <= distance {
        return time(top) + (distance - way(top)) / top;
    }
    let (mut low, mut high) = (0.0, top);
    for _ in 0..200 {
        let middle = (low + high) / 2.0;
        if way(middle) <= distance {
            low = middle;
        } else {
            high = middle;
        }
    }
    time(low)
}

/// The end of a plan, or a second after its last corner.
pub(super) fn last(plan: &Plan, clock: Clock) -> Ticks {
    let corner = plan
        .phases()
        .last()
        .map_or(plan.start(), |phase| phase.start());
    plan.end().unwrap_or(corner + u64::from(clock.hz()))
}

/// Ticks all over a plan.
pub(super) fn all_over(plan: &Plan, clock: Clock, count: u64) -> Vec<Ticks> {
    let length = u128::from(last(plan, clock) - plan.start());
    (0..=count)
        .map(|i| plan.start() + (length * u128::from(i) / u128::from(count)) as Ticks)
        .collect()
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Velocity, acceleration and jerk stay within their limits, and acceleration does not jump, for any sequence of goals at any ticks.
    #[test]
    fn i01_smooth_limits_are_never_exceeded(
        clock in any_clock(),
        limits in usual_limits(),
        ramps in smooth(),
        orders in proptest::collection::vec((goal(), 0u64..=1 << 32), 1..6),
    ) {
        let (a, d) = (f64::from(limits.acceleration), f64::from(limits.deceleration));
        let top = amount(limits.velocity);
        let most = match ramps {
            Ramps::SinSquared => a.max(d) * core::f64::consts::FRAC_PI_2,
            _ => a.max(d),
        };
        // That of sin² is that of its steepest ramp, which may be much shorter than the one to the profile velocity.
        let jerk = ramps.jerk().map_or(1e300, f64::from);
        let rate = f64::from(clock.hz());
        let mut plan = Plan::at_rest(0, 7);
        let mut at = 7;
        for (goal, cut) in orders {
            // Of all magnitudes, as the limit is: most changes of velocity are shorter than that from rest to the limit.
            let goal = match goal {
                Goal::Velocity(velocity) if cut & 1 == 0 => {
                    Goal::Velocity(((f64::from(velocity.whole()) * 1e-6 * top) as i32).into())
                }
                goal => goal,
            };
            let (before, before_it) = (plan.state_at(at), acceleration(&plan, clock, at));
            if plan.replan(clock, at, goal, limits, ramps).is_err() {
                continue;
            }
            let slack = 4.0 + most * 1e-5;
            let begun = acceleration(&plan, clock, at.max(plan.start()));
            prop_assert!((begun - before_it).abs() <= slack + jerk.min(1e30) / rate, "{goal:?}: from {before_it} to {begun}");
            let now = plan.state_at(at);
            prop_assert!((now.position.bits() - before.position.bits()).abs() < 1 << 16, "position jumps");
            prop_assert!((per_second(clock, now) - per_second(clock, before)).abs() < 1e-3 + 1e-6 * top, "velocity jumps");
            let ticks = all_over(&plan, clock, 64);
            for pair in ticks.windows(2) {
                let seconds = (pair[1] - pair[0]) as f64 / rate;
                let (v, w) = (per_second(clock, plan.state_at(pair[0])), per_second(clock, plan.state_at(pair[1])));
                prop_assert!(v.abs() <= top * (1.0 + 1e-6) + 1e-3, "{v} of {top}");
                prop_assert!((w - v).abs() <= most * seconds * (1.0 + 1e-6) + 1e-3 + 1e-6 * top, "{v} to {w} in {seconds}");
                let (p, q) = (acceleration(&plan, clock, pair[0]), acceleration(&plan, clock, pair[1]));
                prop_assert!(p.abs() <= most + slack, "{p} of {most}");
                prop_assert!((p - q).abs() <= jerk * seconds * (1.0 + 1e-6) + slack, "{p} to {q} in {seconds}");
            }
            at += ((u128::from(last(&plan, clock).saturating_sub(at)) * u128::from(cut)) >> 32) as Ticks;
        }
    }

    #[test]
    fn i01_a_gentle_ramp_that_is_left_does_not_go_beyond_its_velocity(
        velocity in 1u32..1_000,
        acceleration in 1u32..100,
        cut in 0u64..=1 << 32,
    ) {
        let clock = clock(84_000_000);
        let limits = Limits { velocity: velocity.into(), acceleration, deceleration: acceleration };
        let mut plan = Plan::at_rest(0, 0);
        let keep = Goal::Velocity(limits.velocity.signed(false));
        plan.replan(clock, 0, keep, limits, Ramps::SinSquared).unwrap();
        let at = ((u128::from(last(&plan, clock)) * u128::from(cut)) >> 32) as Ticks;
        plan.replan(clock, at, Goal::Velocity(0.into()), limits, Ramps::SinSquared).unwrap();
        for t in all_over(&plan, clock, 64) {
            let now = per_second(clock, plan.state_at(t));
            prop_assert!(now <= f64::from(velocity) + 1e-6, "{now} of {velocity}");
        }
    }

    /// The end is the target, exactly, from any velocity, and again from anywhere on the way to another.
    #[test]
    fn i02_a_smooth_move_lands_on_its_target(
        (clock, from) in any_clock().prop_flat_map(|c| (Just(c), any_start(c))),
        targets: (i32, i32),
        limits in usual_limits(),
        ramps in smooth(),
        cut in 0u64..=1 << 32,
    ) {
        let mut plan = match Plan::new(clock, 5, from, Goal::Rest(targets.0.into()), limits, ramps) {
            Ok(plan) => plan,
            Err(error) => {
                prop_assert_eq!(error, PlanError::OutOfRange);
                return Ok(());
            }
        };
        let at = 5 + ((u128::from(plan.end().unwrap() - 5) * u128::from(cut)) >> 32) as Ticks;
        for target in [targets.0, targets.1] {
            if target != targets.0 && plan.replan(clock, at, Goal::Rest(target.into()), limits, ramps).is_err() {
                break;
            }
            let end = plan.end().unwrap();
            let there = State { position: Position::from_steps(target.into()), velocity: Velocity::ZERO };
            prop_assert_eq!(plan.state_at(end), there);
            prop_assert_eq!(plan.state_at(Ticks::MAX), there);
            let before = steps(plan.state_at(end.saturating_sub(1).max(plan.start()))) - f64::from(target);
            prop_assert!(before.abs() <= 0.5 || end <= plan.start() + 1, "{before} steps away");
        }
    }

    /// From rest or with no acceleration a motion turns at most once, and has no jump.
    #[test]
    fn i03_a_smooth_plan_turns_at_most_once(
        v0 in signed(1_000_000),
        target in -1_000_000i64..1_000_000,
        limits in usual_limits(),
        ramps in smooth(),
    ) {
        let clock = clock(168_000_000);
        prop_assume!(within_span(v0, limits));
        let Ok(plan) = Plan::new(clock, 0, state(clock, 0, v0), Goal::Rest(target), limits, ramps) else { return Ok(()) };
        let (mut turns, mut heading) = (0, 0i64);
        let mut last = plan.state_at(0);
        for t in samples(&plan, 200) {
            let now = plan.state_at(t);
            let change = now.position.bits().wrapping_sub(last.position.bits());
            if change.abs() > 1 << 12 {
                turns += i32::from(heading != 0 && heading != change.signum());
                heading = change.signum();
            }
            last = now;
        }
        prop_assert!(turns <= 1, "{turns} turns");
        for phase in plan.phases() {
            let (a, b) = (plan.state_at(phase.start().saturating_sub(1)), plan.state_at(phase.start()));
            let jump = b.position.bits().wrapping_sub(a.position.bits()).unsigned_abs() as f64 / 2f64.powi(32);
            let speed = a.velocity.bits().unsigned_abs().max(b.velocity.bits().unsigned_abs()) as f64 / 2f64.powi(56);
            prop_assert!(jump <= speed * 1.01 + 1e-5, "jump of {jump}");
        }
    }

    /// From rest to rest in the time of the fastest move there is; sin² takes exactly as long as the trapezoid.
    #[test]
    fn i04_the_smooth_duration_is_ideal(
        clock in any_clock(),
        target in 1i64..2_000_000_000,
        limits in usual_limits(),
        jerk in magnitude(1_000, u32::MAX),
    ) {
        let limits = Limits { velocity: limits.velocity.min((clock.hz() / 2).into()), ..limits };
        // With a slow clock the highest jerks are cut.
        let jerk = jerk.min(if clock.hz() == 1_000_000 { 200_000_000 } else { u32::MAX });
        let rest = state(clock, 0, 0);
        let goal = Goal::Rest(target);
        if let Some(ramps) = Ramps::limited(jerk) {
            let plan = Plan::new(clock, 0, rest, goal, limits, ramps).unwrap();
            let ideal = double_s(target as f64, limits, jerk.into()) * f64::from(clock.hz());
            let real = plan.end().unwrap() as f64;
            prop_assert!(real >= ideal * (1.0 - 1e-6) - 1.0, "{real} of {ideal}");
            prop_assert!(real <= ideal * (1.0 + 2f64.powi(-16)) + 7.0, "{real} of {ideal}");
        }

        let sine = Plan::new(clock, 0, rest, goal, limits, Ramps::SinSquared).unwrap();
        let linear = Plan::move_to(clock, 0, rest, target, limits).unwrap();
        prop_assert_eq!(sine.end(), linear.end());
    }

    /// The mirror image of a move is a mirror image, bit by bit.
    #[test]
    fn i05_a_mirrored_smooth_move_is_the_mirror_image(
        clock in any_clock(),
        v0 in signed(400_000),
        target in -1_000_000i64..=1_000_000,
        limits in usual_limits(),
        ramps in smooth(),
    ) {
        let mirror = |s: State| State {
            position: Position::from_bits(s.position.bits().wrapping_neg()),
            velocity: Velocity::from_bits(-s.velocity.bits()),
        };
        prop_assume!(target != 0);
        let from = state(clock, 0, v0);
        let one = Plan::new(clock, 0, from, Goal::Rest(target), limits, ramps);
        let other = Plan::new(clock, 0, mirror(from), Goal::Rest(-target), limits, ramps);
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

    /// The same order again changes nothing; other orders with the same motion are in `sequences`.
    #[test]
    fn i06_planning_a_smooth_move_again_does_not_change_the_end(
        clock in any_clock(),
        target in -2_000_000_000i64..2_000_000_000,
        limits in usual_limits(),
        ramps in smooth(),
        cut in 0u64..=1 << 32,
    ) {
        let first = Plan::new(clock, 3, state(clock, 0, 0), Goal::Rest(target), limits, ramps).unwrap();
        let end = first.end().unwrap();
        let at = 3 + ((u128::from(end - 3) * u128::from(cut)) >> 32) as Ticks;
        let mut again = first.clone();
        again.replan(clock, at, Goal::Rest(target), limits, ramps).unwrap();
        prop_assert_eq!(again.end(), Some(end));
        prop_assert_eq!(again.state_at(at), first.state_at(at));
        // A stop within the ramp to rest is that ramp.
        let mut stopped = first.clone();
        let braking = first.last_ramp() + (end - first.last_ramp()) / 3;
        stopped.replan(clock, braking, Goal::Velocity(0.into()), limits, ramps).unwrap();
        let rest = steps(stopped.state_at(stopped.end().unwrap()));
        prop_assert!((rest - target as f64).abs() < 1e-3, "{rest} for {target}");
    }

    /// A stop goes as far as its ramps say.
    #[test]
    fn i08_a_smooth_stop_takes_its_distance_and_no_more(
        clock in any_clock(),
        v0 in signed(4_000_000),
        deceleration in magnitude(100, 100_000_000),
        jerk in magnitude(1_000, 200_000_000),
    ) {
        let from = state(clock, 0, v0);
        let limits = Limits { velocity: 0.into(), acceleration: 0, deceleration };
        let v = per_second(clock, from);
        for ramps in [Ramps::SinSquared].into_iter().chain(Ramps::limited(jerk)) {
            let time = match ramps.jerk() {
                Some(jerk) => ramp_time(v.abs(), deceleration.into(), jerk.into()),
                None => v.abs() / f64::from(deceleration),
            };
            let way = v / 2.0 * time;
            if way.abs() > 2e9 {
                continue;
            }
            let plan = Plan::new(clock, 0, from, Goal::Velocity(0.into()), limits, ramps).unwrap();
            let real = steps(plan.state_at(plan.end().unwrap()));
            prop_assert!((real - way).abs() <= 1e-6 + way.abs() * 1e-6, "{real} for {way}");
        }
    }

    /// Overspeed is braked; it never grows first.
    #[test]
    fn i09_a_lowered_limit_never_accelerates_first(
        v0 in magnitude(1000, 1_000_000),
        part in 1u32..1000,
        target in 0i64..2_000_000_000,
        limits in usual_limits(),
        ramps in smooth(),
    ) {
        let clock = clock(168_000_000);
        let limits = Limits { velocity: ((u64::from(v0) * u64::from(part) / 1000).max(1) as u32).into(), ..limits };
        let from = state(clock, 0, v0 as i32);
        prop_assume!(within_span(v0 as i32, limits));
        let Ok(plan) = Plan::new(clock, 0, from, Goal::Rest(target), limits, ramps) else { return Ok(()) };
        let mut last = from.velocity;
        for t in samples(&plan, 100) {
            let now = plan.state_at(t).velocity;
            if last.bits() > Velocity::from_speed(clock, limits.velocity.signed(false)).bits() + (1 << 20) {
                prop_assert!(now.bits() <= last.bits() + 1024, "speeds up at {t}");
            }
            last = now;
        }
    }

    /// Anything at all gives a plan or an error.
    #[test]
    fn i10_no_input_breaks_a_smooth_plan(
        clock in any_clock(),
        start: Ticks,
        bits: (i64, i64),
        target: i64,
        speed: i32,
        rates in any::<(u32, u32, u32, u32)>(),
        more in any::<(u32, u32, u32, u32)>(),
        zero in 0..7,
        when: Ticks,
    ) {
        let limits = |(velocity, acceleration, deceleration, _): (u32, u32, u32, u32)| Limits {
            velocity: if zero == 0 { 0.into() } else { velocity.into() },
            acceleration: if zero == 1 { 0 } else { acceleration },
            deceleration: if zero == 2 { 0 } else { deceleration },
        };
        let from = State { position: Position::from_bits(bits.0), velocity: Velocity::from_bits(bits.1) };
        let jerk = if zero == 3 { 0 } else { rates.3 };
        for ramps in [Ramps::SinSquared].into_iter().chain(Ramps::limited(jerk)) {
            for goal in [Goal::Rest(target >> 32), Goal::Rest(target), Goal::Pass(target >> 32, rates.1.into()), Goal::Velocity(speed.into())] {
                let plan = Plan::new(clock, start, from, goal, limits(rates), ramps);
                prop_assert!(jerk != 0 || ramps == Ramps::SinSquared || plan.is_err());
                let Ok(mut plan) = plan else { continue };
                plan.state_at(when);
                prop_assert!(plan.end().is_none_or(|end| end >= start));
                prop_assert!(plan.next_corner(when).is_none_or(|corner| corner > when));
                let _ = plan.replan(clock, when.max(start), Goal::Rest(-(target >> 33)), limits(more), ramps);
                let _ = plan.replan(clock, when.max(start), Goal::Velocity(0.into()), limits(more), Ramps::limited(more.3).unwrap_or(Ramps::SinSquared));
                plan.state_at(when);
            }
        }
    }

    #[cfg(feature = "limited-jerk")]
    /// Never later than the moving average over the trapezoid would be, whose jerk is (a + d)/T; and the way is the same.
    #[test]
    fn i12_a_jerk_limited_move_is_no_later_than_the_moving_average(
        clock in any_clock(),
        target in 1i64..2_000_000_000,
        limits in usual_limits(),
        jerk in magnitude(1_000, 200_000_000),
    ) {
        let rest = state(clock, 0, 0);
        let plan = Plan::new(clock, 0, rest, Goal::Rest(target), limits, Ramps::JerkLimited(jerk)).unwrap();
        let trapezoid = Plan::move_to(clock, 0, rest, target, limits).unwrap();
        let width = (f64::from(limits.acceleration) + f64::from(limits.deceleration)) / f64::from(jerk);
        let average = trapezoid.end().unwrap() as f64 + width * f64::from(clock.hz());
        prop_assert!(plan.end().unwrap() as f64 <= average * (1.0 + 1e-6) + 7.0);
        let way = plan.state_at(Ticks::MAX).position.bits() - plan.state_at(0).position.bits();
        prop_assert_eq!(way, target << 32);
    }
}

/// No phase begins elsewhere than where the one before it ends.
pub(super) fn assert_no_jump(plan: &Plan) {
    let corners = plan.phases().map(|phase| phase.start());
    for corner in corners.chain(plan.end()).filter(|t| *t > plan.start()) {
        let (a, b) = (plan.state_at(corner - 1), plan.state_at(corner));
        let jump = b.position.bits().wrapping_sub(a.position.bits());
        assert!(
            jump.abs() <= 1 << 31,
            "{} steps at {corner}",
            jump as f64 / 2f64.powi(32)
        );
    }
}

#[cfg(feature = "limited-jerk")]
#[test]
fn i01_an_acceleration_that_its_jerk_would_never_reach_is_no_limit() {
    // It would come about at a velocity that no number of a plan can hold.
    let clock = clock(1_000_000);
    let limits = Limits {
        velocity: 10_000.into(),
        acceleration: 108_747_104,
        deceleration: 108_747_104,
    };
    for goal in [Goal::Velocity(1.into()), Goal::Rest(2)] {
        let from = state(clock, 0, 0);
        let plan = Plan::new(clock, 0, from, goal, limits, Ramps::JerkLimited(1)).unwrap();
        // Up to 1 step/s at 1 step/s³, and back.
        let corner = plan.phases().last().unwrap().start();
        assert!((1_000_000..=3_000_001).contains(&corner), "{corner}");
    }
}
#[test]
fn i11_a_smooth_velocity_crosses_the_span_without_a_jump() {
    let clock = clock(168_000_000);
    let limits = Limits {
        velocity: 4_000_000.into(),
        acceleration: 1_000_000,
        deceleration: 1_000_000,
    };
    let limited = Ramps::limited(10_000_000);
    for ramps in [Ramps::SinSquared].into_iter().chain(limited) {
        let goal = Goal::Velocity((-4_000_000).into());
        let plan = Plan::new(clock, 0, state(clock, 0, 0), goal, limits, ramps).unwrap();
        assert_eq!(plan.end(), None);
        let hour = 3600 * 168_000_000u64;
        let mut last = plan.state_at(10 * hour).position.bits();
        // Every 100 ms for more than one round of 2³² steps.
        for part in 1..12_000u64 {
            let now = plan.state_at(10 * hour + part * 16_800_000).position.bits();
            assert!((now.wrapping_sub(last) + (400_000i64 << 32)).abs() <= 1 << 10);
            last = now;
        }
    }
}

/// Even if it is refused when the stop that comes first is known, and the plan itself begins with one.
#[test]
fn an_order_that_is_refused_leaves_a_smooth_plan_as_it_was() {
    let clock = clock(84_000_000);
    let limits = Limits {
        velocity: 100_000.into(),
        acceleration: 500_000,
        deceleration: 500_000,
    };
    let limited = Ramps::limited(5_000_000);
    for ramps in [Ramps::SinSquared].into_iter().chain(limited) {
        let mut plan = Plan::at_rest(0, 0);
        let orders = [
            (0, 100_000),
            (8_400_000, -2_000),
            (10_000_000, -4_000),
            (11_000_000, -3_000),
        ];
        for (at, target) in orders {
            plan.replan(clock, at, Goal::Rest(target), limits, ramps)
                .unwrap();
            let before = plan.clone();
            let begin = at + 500_000;
            let here = plan.state_at(begin);
            assert!(here.velocity > Velocity::ZERO);
            // As far behind as a target may be, but the stop leads further away.
            let behind = here.position.whole_steps() - (1 << 32) + 2;
            let refused = plan.replan(clock, begin, Goal::Rest(behind), limits, ramps);
            assert_eq!(refused, Err(PlanError::OutOfRange));
            assert_eq!(plan.end(), before.end());
            for t in (begin..before.end().unwrap()).step_by(10_007) {
                assert_eq!(plan.state_at(t), before.state_at(t), "{ramps:?} at {t}");
            }
        }
    }
}

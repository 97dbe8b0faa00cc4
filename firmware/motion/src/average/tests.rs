//! The mean against one that is worked out from the plans themselves.

use super::{Average, Window};
use crate::exact::{PositionQ96, Q96};
use crate::fixed::Exact;
use crate::plan::InitialState;
use crate::plan::phase::Phase;
use crate::{Clock, Goal, Limits, Plan, Ramps, State, Ticks};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use std::vec::Vec;

const HZ: u32 = 168_000_000;
const TIME_SLICE: u32 = HZ / 4000;

fn clock() -> Clock {
    Clock::new(HZ).unwrap()
}

/// In steps, from a position in the middle of the span.
fn steps(position: PositionQ96) -> f64 {
    (position.bits() >> 48) as f64 / 2f64.powi(48)
}

/// Steps/s from steps per tick, and so with accelerations.
fn per_second(velocity: Q96) -> f64 {
    velocity.bits() as f64 / 2f64.powi(96) * f64::from(HZ)
}

/// A mean, its curve so far, and the plans that it was made of.
struct Followed {
    window: Window,
    begin: Ticks,
    average: Average,
    plans: Vec<(Ticks, Plan)>,
    pieces: Vec<(Ticks, Phase)>,
}

impl Followed {
    /// Begins in a state of the plan, and before it in a line.
    fn new(window: Window, begin: Ticks, goal: Goal, limits: Limits, velocity: i32) -> Self {
        let from = State {
            velocity: crate::Velocity::from_speed(clock(), velocity.into()),
            ..State::default()
        };
        let ahead = Average::ahead(window, from.into());
        let mut plan = Plan::at_rest(0, begin);
        let start = InitialState::steady(begin, ahead);
        let _ = plan.make(clock(), &start, goal, limits, Ramps::Linear);
        let mut average = Average::new();
        average.begin(window, begin, from.into());
        Self {
            window,
            begin,
            average,
            plans: [(begin, plan)].into(),
            pieces: Vec::new(),
        }
    }

    /// Goes on until tick `t` at least, or until it is over.
    fn run(&mut self, t: Ticks) {
        while self.average.until() < t && !self.average.is_over(self.average.until()) {
            let until = self.average.until();
            self.average
                .polynomial_at(&self.plans.last().unwrap().1, until);
            self.pieces
                .push((self.average.until(), self.average.phase()));
        }
    }

    /// Another plan, in place of the last one.
    fn redirect(&mut self, horizon: Ticks, goal: Goal, limits: Limits) {
        // No mean is followed where it is over.
        let horizon = horizon.min(self.average.until());
        let mut plan = self.plans.last().unwrap().1.clone();
        if plan
            .replan(clock(), horizon, goal, limits, Ramps::Linear)
            .is_ok()
        {
            self.average.rejoin(horizon);
            self.plans.push((horizon, plan));
            if let Some(last) = self.pieces.last_mut() {
                last.0 = last.0.min(horizon);
            }
        }
    }

    fn planned(&self, t: Ticks) -> f64 {
        if t < self.begin {
            let first = self.plans[0].1.exact_at(self.begin);
            let back = (self.begin - t) as f64;
            return steps(first.position) - back * first.velocity.bits() as f64 / 2f64.powi(96);
        }
        let plan = self.plans.iter().rev().find(|plan| plan.0 <= t).unwrap();
        steps(plan.1.exact_at(t).position)
    }

    /// The mean of the plans over the window before tick `t`.
    fn mean(&self, t: Ticks) -> f64 {
        let ticks = u64::from(self.window.ticks());
        let parts = 2000;
        let at = |part: u64| {
            // Before tick 0 there is a line, too.
            self.planned((t + ticks * part / parts).saturating_sub(ticks))
        };
        let inner: f64 = (1..parts).map(at).sum();
        (inner + (at(0) + at(parts)) / 2.0) / parts as f64
    }

    fn at(&self, t: Ticks) -> Exact {
        let piece = self.pieces.iter().find(|piece| t < piece.0);
        piece.map_or(self.average.exact_at(t), |piece| piece.1.at(t))
    }
}

fn limits() -> impl Strategy<Value = Limits> {
    (1u32..400_000, 17u32..25, 16u32..25).prop_map(|(velocity, a, d)| Limits {
        velocity: velocity.into(),
        acceleration: 1 << a,
        deceleration: 3 << d,
    })
}

fn goal() -> impl Strategy<Value = Goal> {
    prop_oneof![
        3 => (-100_000i64..100_000).prop_map(Goal::Rest),
        1 => (-20i64..20).prop_map(Goal::Rest),
        1 => (-100_000i64..100_000, 0u32..50_000).prop_map(|(target, end)| Goal::Pass(target, end.into())),
        2 => (-300_000i32..300_000).prop_map(|velocity| Goal::Velocity(velocity.into())),
        1 => Just(Goal::Velocity(0.into())),
    ]
}

fn window() -> impl Strategy<Value = Window> {
    prop_oneof![
        (1u32..2 * TIME_SLICE).prop_map(|ticks| Window::of(ticks, TIME_SLICE)),
        (TIME_SLICE..600 * TIME_SLICE).prop_map(|ticks| Window::of(ticks, TIME_SLICE)),
        (500 * TIME_SLICE..6000 * TIME_SLICE).prop_map(|ticks| Window::of(ticks, TIME_SLICE)),
    ]
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() }))]

    /// Invariant 12 and what else makes a mean, whatever happens in what order.
    #[test]
    fn i12_whatever_is_planned_its_mean_is_followed_at_limited_jerk(
        window in window(),
        orders in prop::collection::vec((goal(), limits(), 0u64..HZ.into()), 1..8),
        velocity in prop_oneof![Just(0), -300_000i32..300_000],
    ) {
        let begin = 1 << 40;
        let (first, limits, _) = orders[0];
        let mut followed = Followed::new(window, begin, first, limits, velocity);
        let mut now = begin;
        for ((_, _, wait), (goal, limits, _)) in orders.iter().zip(&orders[1..]) {
            now += wait;
            followed.run(now);
            followed.redirect(now, *goal, *limits);
        }
        let stop = Limits { velocity: 1.into(), acceleration: 1, deceleration: 1 << 20 };
        let now = now + u64::from(HZ);
        followed.run(now);
        followed.redirect(now, Goal::Velocity(0.into()), stop);
        followed.run(Ticks::MAX);

        // In its end it is where the last plan is, one window later than that.
        let (junction, plan) = followed.plans.last().unwrap().clone();
        let end = plan.end().unwrap();
        let until = followed.average.until();
        prop_assert!(followed.average.is_over(until));
        let has_moved = until < Ticks::MAX;
        let late = until.wrapping_sub(end);
        prop_assert!(!has_moved || end <= junction || late == u64::from(window.ticks()), "{late} ticks behind the plan");
        prop_assert!(!has_moved || until <= junction.max(end) + u64::from(window.ticks()));
        let off = steps(followed.average.exact_at(until).position - plan.exact_at(end).position);
        prop_assert!(off.abs() < 1e-9, "{off} steps off in its end");

        let hardest = orders.iter().map(|(_, limits, _)| f64::from(limits.acceleration.max(limits.deceleration)));
        let hardest = hardest.fold(f64::from(stop.deceleration), f64::max);
        let fastest = orders.iter().map(|(_, limits, _)| limits.velocity.whole()).max().unwrap();
        let fastest = f64::from(fastest.max(velocity.unsigned_abs()));
        let seconds = f64::from(window.ticks()) / f64::from(HZ);
        // A corner of a plan lies up to a tick before that at which its next phase begins.
        let rounding = 4.0 * hardest / f64::from(window.ticks()) + 1e-3;
        let mut before: Option<Phase> = None;
        for (until, phase) in &followed.pieces {
            let start = phase.start();
            let acceleration = |t: Ticks| per_second(phase.acceleration_exact(t)) * f64::from(HZ);
            if let Some(last) = before {
                // It joins in position, velocity and acceleration.
                let (here, there) = (phase.at(start), last.at(start));
                let apart = steps(here.position) - steps(there.position);
                prop_assert!(apart.abs() < 1e-9, "{apart} steps apart");
                let apart = per_second(here.velocity) - per_second(there.velocity);
                prop_assert!(apart.abs() < rounding / f64::from(HZ) + 1e-6, "{apart} steps/s apart");
                let was = per_second(last.acceleration_exact(start)) * f64::from(HZ);
                prop_assert!((acceleration(start) - was).abs() <= rounding, "{was} steps/s² become {}", acceleration(start));
            }
            before = Some(*phase);
            let until = *until;
            if until == Ticks::MAX || until <= start {
                continue;
            }
            for t in [start, until] {
                prop_assert!(acceleration(t).abs() <= hardest * 1.000_001 + rounding);
                prop_assert!(per_second(phase.at(t).velocity).abs() <= fastest * 1.000_001 + 1e-3);
            }
            let taken = (until - start) as f64 / f64::from(HZ);
            let change = (acceleration(until) - acceleration(start)).abs();
            let most = 2.0 * hardest / seconds;
            prop_assert!(change <= most * taken * 1.000_001 + rounding, "{} steps/s³ instead of {most}", change / taken);
        }
        // A mean of so many points is not quite the mean.
        let slack = hardest * (seconds / 2000.0).powi(2) + fastest * 2.0 / f64::from(HZ) + 1e-4;
        let last = if has_moved { until } else { begin };
        for part in 0..20 {
            let t = begin + (last - begin) * part / 20;
            let off = steps(followed.at(t).position) - followed.mean(t);
            prop_assert!(off.abs() <= slack, "{off} steps off at {t}, {slack} allowed");
        }
    }

    /// Changed more often than its parabolas are kept, the mean is nearly that of the plans, and no jump comes of it.
    #[test]
    fn a_plan_that_is_changed_in_each_millisecond_has_its_mean(
        milliseconds in 50u32..400,
        velocities in prop::collection::vec(-100_000i32..100_000, 300..500),
    ) {
        let limits = Limits { velocity: 100_000.into(), acceleration: 2_000_000, deceleration: 3_000_000 };
        let window = Window::of(milliseconds * (HZ / 1000), TIME_SLICE);
        let to = |velocity: i32| Goal::Velocity(velocity.into());
        let begin = 1 << 40;
        let mut followed = Followed::new(window, begin, to(velocities[0]), limits, 0);
        let mut now = begin;
        for velocity in &velocities {
            now += u64::from(HZ) / 1000;
            followed.run(now);
            followed.redirect(now, to(*velocity), limits);
        }
        followed.run(now + u64::from(HZ) / 1000);
        followed.redirect(now + u64::from(HZ) / 1000, to(0), limits);
        followed.run(Ticks::MAX);
        let until = followed.average.until();
        let end = followed.plans.last().unwrap().1.end().unwrap();
        prop_assert_eq!(until, end + u64::from(window.ticks()));
        let rest = followed.plans.last().unwrap().1.exact_at(end);
        let off = steps(followed.average.exact_at(until).position - rest.position);
        prop_assert!(off.abs() < 1e-9, "{off} steps off in its end");
        for pair in followed.pieces.windows(2) {
            let start = pair[1].1.start();
            let off = steps(pair[0].1.at(start).position - pair[1].1.at(start).position);
            prop_assert!(off.abs() < 1e-9, "{off} steps apart");
        }
        for part in 0..20 {
            let t = begin + (until - begin) * part / 20;
            let off = steps(followed.at(t).position) - followed.mean(t);
            prop_assert!(off.abs() <= 0.5, "{off} steps off at {t}");
        }
    }

    #[test]
    fn windows_are_no_shorter_than_the_jerk_asks(
        hz in Clock::SLOWEST..=Clock::FASTEST,
        time_slice in 1u32..1 << 28,
        accelerations in (any::<u32>(), any::<u32>()),
        jerk in 1u32..,
    ) {
        let clock = Clock::new(hz).unwrap();
        let limits = Limits { velocity: 1.into(), acceleration: accelerations.0, deceleration: accelerations.1 };
        let cut = Window::within(clock, limits, jerk);
        let change = u64::from(cut.acceleration) + u64::from(cut.deceleration);
        let window = Window::new(clock, change, jerk, time_slice);
        let (ticks, least) = (u64::from(window.ticks()), u64::from(time_slice));
        prop_assert!(u128::from(ticks) * u128::from(jerk) >= u128::from(change) * u128::from(hz));
        prop_assert!(ticks >= least);
        prop_assert!(ticks <= 1 << 30);
        // And hardly longer, and nothing is cut without need.
        let exact = (u128::from(change) * u128::from(hz)).div_ceil(jerk.into());
        prop_assert!(u128::from(ticks) == exact.max(time_slice.into()));
        let needed = (u128::from(limits.acceleration.max(limits.deceleration)) * 2 * u128::from(hz)).div_ceil(jerk.into());
        prop_assert!(cut == limits || needed > 1 << 30);
    }
}

#[test]
fn a_creeping_plan_is_followed_to_the_tick() {
    // One step in an hour, and a window of 100 ms.
    let slow = crate::Speed::from_bits((1 << 32) / 3600);
    let limits = Limits {
        velocity: slow,
        acceleration: 1,
        deceleration: 1,
    };
    let goal = Goal::Velocity(crate::SignedSpeed::from_bits(slow.bits() as i64));
    let window = Window::of(400 * TIME_SLICE, TIME_SLICE);
    let mut followed = Followed::new(window, 0, goal, limits, 0);
    followed.run(u64::from(HZ));
    let (until, line) = *followed.pieces.last().unwrap();
    assert_eq!(until, Ticks::MAX);
    assert!(followed.pieces.len() <= 4, "{}", followed.pieces.len());
    let plan = followed.plans[0].1.clone();
    let hour = 3600 * u64::from(HZ);
    let half = u64::from(window.ticks()) / 2;
    assert_eq!(line.at(hour), plan.exact_at(hour - half));
}

//! Motion: planning a move.
//!
//! Each plan is made as an axis makes it, over the plan that was; smooth ones by an axis, which is in the ramp that it leaves. Beside moves that are known, very many are tried with limits from all
//! that there are, from rest and from any moment of the motion before: what matters is the worst case.

use core::hint::black_box;

use motion::{
    Axis, AxisConfig, Clock, DriverTiming, Goal, Limits, Plan, Position, PulseSink, Ramps, Record,
    SignedSpeed, State, Ticks, Velocity,
};

use crate::{count, row};

const HZ: u32 = 84_000_000;

/// So many plans are tried for each kind of ramp.
const TRIED: u32 = 1_500;

#[inline(never)]
fn plan(clock: Clock, plan: &mut Plan, at: Ticks, goal: Goal) {
    plan.replan(clock, at, goal, usual(), Ramps::Linear)
        .unwrap();
}

fn limits(velocity: u32, acceleration: u32, deceleration: u32) -> Limits {
    Limits {
        velocity: velocity.into(),
        acceleration,
        deceleration,
    }
}

/// Those of most reference vectors.
fn usual() -> Limits {
    limits(100_000, 500_000, 500_000)
}

/// All plans.
pub fn run() {
    reference();
    linear();
    smooth();
    averaged();
    worst_case();
}

/// The reference vectors T01, a long trapezoid, and T14, a target inside the stopping distance: overshoot and return.
fn reference() {
    let clock = Clock::new(HZ).unwrap();
    let t01 = cost(Plan::at_rest(0, 0), 0, Goal::Rest(100_000));
    row("motion: plan T01, from rest", t01);

    let moving = State {
        position: Position::from_steps(0),
        velocity: Velocity::from_speed(clock, 50_000.into()),
    };
    let planned = Plan::velocity(clock, 0, moving, 50_000.into(), usual()).unwrap();
    let t14 = cost(planned, 0, Goal::Rest(1_000));
    row("motion: plan T14, overshoot and return", t14);
}

/// Profile velocity and stop, with linear ramps.
fn linear() {
    for (name, first, then) in [
        ("motion: plan a velocity, from rest", None, 100_000),
        ("motion: plan a velocity, reversing", Some(100_000), -80_000),
        ("motion: plan a stop, cruising", Some(100_000), 0),
    ] {
        let planned = first.map_or(Plan::at_rest(0, 0), running);
        let goal = Goal::Velocity(SignedSpeed::per_second(then));
        row(name, cost(planned, CRUISE, goal));
    }
}

/// Half a second: a motion at 100,000 steps/s cruises, whatever its ramps.
const CRUISE: Ticks = (HZ / 2) as Ticks;

/// A tenth of a second: it is in the middle of its ramp.
const RAMP: Ticks = (HZ / 10) as Ticks;

/// sin² ramps.
fn smooth() {
    let ramps = Ramps::SinSquared;
    let target = |axis: &mut Axis, steps| axis.move_to(steps, usual()).unwrap();
    let ramp = || leaving(100_000, RAMP, ramps);
    for (name, cost) in [
        (
            "motion: plan with sin², from rest",
            ordered(standing(ramps), |axis| target(axis, 100_000)),
        ),
        (
            "motion: plan with sin², from rest, a short way",
            ordered(standing(ramps), |axis| target(axis, 1_000)),
        ),
        (
            "motion: plan with sin², in a ramp, further",
            ordered(ramp(), |axis| target(axis, 120_000)),
        ),
        (
            "motion: plan with sin², in a ramp, back",
            ordered(ramp(), |axis| target(axis, -2_000)),
        ),
        (
            "motion: plan with sin², a velocity, from rest",
            ordered(standing(ramps), cruise),
        ),
        (
            "motion: plan with sin², a stop, in a ramp",
            ordered(ramp(), |axis| axis.stop(500_000).unwrap()),
        ),
    ] {
        row(name, cost);
    }
}

/// The moving average, of the moves that are known.
fn averaged() {
    let ramps = Ramps::MovingAverage(5_000_000);
    let target = |axis: &mut Axis, steps| axis.move_to(steps, usual()).unwrap();
    let ramp = || leaving(100_000, RAMP, ramps);
    let stop = |axis: &mut Axis| axis.stop(500_000).unwrap();
    let costs = [
        ordered(standing(ramps), |axis| target(axis, 100_000)),
        ordered(ramp(), |axis| target(axis, 120_000)),
        ordered(ramp(), |axis| target(axis, -2_000)),
        ordered(standing(ramps), cruise),
        ordered(ramp(), stop),
        ordered(leaving(200_000, CRUISE, ramps), stop),
    ];
    let names = [
        "motion: plan with moving average, from rest",
        "motion: plan with moving average, in a ramp, further",
        "motion: plan with moving average, in a ramp, back",
        "motion: plan with moving average, a velocity, from rest",
        "motion: plan with moving average, a stop, in a ramp",
        "motion: plan with moving average, a stop, cruising",
    ];
    for (name, cost) in names.into_iter().zip(costs) {
        row(name, cost);
    }
}

/// To 100,000 steps/s.
fn cruise(axis: &mut Axis) {
    axis.ramp_to(100_000.into(), usual()).unwrap();
}

/// Takes all records and plays them at once.
struct Gone;

impl PulseSink for Gone {
    fn push(&mut self, _record: Record) -> Result<(), Record> {
        Ok(())
    }

    fn pending(&self) -> Ticks {
        0
    }

    fn free(&self) -> usize {
        64
    }
}

/// An axis at rest.
fn standing(ramps: Ramps) -> Axis {
    let mut axis = Axis::new(AxisConfig {
        clock: Clock::new(HZ).unwrap(),
        time_slice: HZ / 4_000,
        timing: DriverTiming {
            pulse_high: 9,
            pulse_low: 9,
            direction_setup: 2,
            direction_hold: 2,
        },
    });
    axis.set_ramps(ramps);
    axis
}

/// An axis so many ticks after it has left for a target.
fn leaving(target: i64, after: Ticks, ramps: Ramps) -> Axis {
    let mut axis = standing(ramps);
    axis.move_to(target, usual()).unwrap();
    while axis.played(0) < after {
        // It never has anything left to play, and says so.
        let _ = axis.advance(&mut Gone);
    }
    axis
}

/// What an order costs an axis.
fn ordered(mut axis: Axis, order: impl FnOnce(&mut Axis)) -> u32 {
    let (cost, ()) = count(|| order(black_box(&mut axis)));
    assert!(!axis.is_at_rest());
    cost
}

/// The worst case of very many.
fn worst_case() {
    row(
        "motion: plan, worst case found, linear",
        search(Ramps::Linear),
    );
    row(
        "motion: plan, worst case found, sin²",
        search(Ramps::SinSquared),
    );
}

/// A motion from rest to a velocity.
fn running(velocity: i32) -> Plan {
    let mut planned = Plan::at_rest(0, 0);
    let clock = Clock::new(HZ).unwrap();
    let goal = Goal::Velocity(velocity.into());
    plan(clock, &mut planned, 0, goal);
    planned
}

/// What it costs to leave for a goal.
fn cost(mut planned: Plan, at: Ticks, goal: Goal) -> u32 {
    let clock = Clock::new(HZ).unwrap();
    let (cost, ()) = count(|| plan(clock, black_box(&mut planned), at, goal));
    check(&planned, goal);
    cost
}

/// A plan leads to its goal.
fn check(planned: &Plan, goal: Goal) {
    let end = planned.state_at(Ticks::MAX);
    match goal {
        Goal::Rest(target) => assert_eq!(end.position, Position::from_steps(target)),
        Goal::Velocity(SignedSpeed::ZERO) => assert_eq!(end.velocity, Velocity::ZERO),
        _ => assert_eq!(planned.end(), None),
    }
}

/// Numbers that look random (an xorshift generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    /// Of so many binary digits at most, as often of few as of many; at least 1.
    fn digits(&mut self, most: u64) -> u32 {
        let digits = 1 + self.below(most);
        (1 << (digits - 1) | self.below(1 << (digits - 1))) as u32
    }

    /// The same, forwards or backwards.
    fn way(&mut self, most: u64) -> i32 {
        let way = self.digits(most).cast_signed();
        if self.below(2) == 0 {
            way
        } else {
            -way
        }
    }

    /// Most often a target, as that takes longest.
    fn goal(&mut self) -> Goal {
        match self.below(8) {
            0 => Goal::Velocity(self.way(22).into()),
            1 => Goal::Velocity(SignedSpeed::ZERO),
            2 => Goal::Pass(self.way(28).into(), self.digits(22).into()),
            _ => Goal::Rest(self.way(28).into()),
        }
    }
}

/// The worst case of plans with these ramps.
fn search(ramps: Ramps) -> u32 {
    let clock = Clock::new(HZ).unwrap();
    let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15);
    let mut planned = Plan::at_rest(0, 0);
    let mut now = 0;
    let mut most = 0;
    for _ in 0..TRIED {
        let rule = limits(numbers.digits(22), numbers.digits(27), numbers.digits(27));
        let goal = numbers.goal();
        let (cost, made) =
            count(|| attempt(clock, black_box(&mut planned), now, goal, rule, ramps));
        most = most.max(cost);
        // What braking leads too far away is refused, and so is all that follows: on from rest.
        if !made || numbers.below(4) == 0 {
            planned = Plan::at_rest(0, now);
            continue;
        }
        if let Goal::Rest(_) | Goal::Velocity(SignedSpeed::ZERO) = goal {
            check(&planned, goal);
        }
        // Somewhere in the motion, or in the second that follows if it has no end.
        let end = planned.end().unwrap_or(now + Ticks::from(HZ));
        now += numbers.below((end - now).max(1));
    }
    most
}

#[inline(never)]
fn attempt(
    clock: Clock,
    plan: &mut Plan,
    at: Ticks,
    goal: Goal,
    limits: Limits,
    ramps: Ramps,
) -> bool {
    plan.replan(clock, at, goal, limits, ramps).is_ok()
}

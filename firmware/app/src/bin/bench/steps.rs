//! Motion: planning a move, turning a segment into records, playing one step.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

use motion::step_interrupt::{self, Edge, StepTimer};
use motion::{
    Axis, AxisConfig, Clock, Direction, DriverTiming, Goal, Limits, Plan, Position, PulseSink,
    Ramps, Record, State, Ticks, Velocity,
};

use crate::{count, row};

const HZ: u32 = 84_000_000;
/// A segment, and a control tick: a millisecond.
const SEGMENT: u32 = HZ / 1_000;

/// What the driver needs: 2.5 µs high and low, 5 µs around a change of direction.
const TIMING: DriverTiming = DriverTiming {
    pulse_high: 210,
    pulse_low: 210,
    direction_setup: 420,
    direction_hold: 420,
};

/// A sink that counts what it is given and plays it when it is told.
#[derive(Default)]
struct Played {
    pending: Ticks,
    steps: i64,
}

impl PulseSink for Played {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.pending += record.ticks();
        self.steps += i64::from(record.steps());
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        64
    }
}

/// Plans as an axis does, over the plan that was.
#[inline(never)]
fn plan(clock: Clock, plan: &mut Plan, target: i64, limits: Limits) {
    let goal = Goal::Rest(target);
    plan.redirect(clock, 0, goal, limits, Ramps::Linear)
        .unwrap();
}

#[inline(never)]
fn advance(axis: &mut Axis, sink: &mut Played) {
    sink.pending = sink.pending.saturating_sub(SEGMENT.into());
    axis.advance(sink).unwrap();
}

/// All workloads of motion.
pub fn run() {
    let clock = Clock::new(HZ).unwrap();
    // The reference vectors T01, a long trapezoid, and T14, a target inside the stopping distance: overshoot and return.
    let limits = Limits {
        velocity: 100_000,
        acceleration: 500_000,
        deceleration: 500_000,
    };
    let mut planned = Plan::at_rest(0, 0);
    let (t01, ()) = count(|| plan(clock, black_box(&mut planned), 100_000, limits));
    assert_eq!(
        planned.state_at(Ticks::MAX).position,
        Position::from_steps(100_000)
    );
    row("motion: plan T01, from rest", t01);

    let moving = State {
        position: Position::from_steps(0),
        velocity: Velocity::from_steps_per_second(clock, 50_000),
    };
    let mut planned = Plan::velocity(clock, 0, moving, 50_000, limits).unwrap();
    let (t14, ()) = count(|| plan(clock, black_box(&mut planned), 1_000, limits));
    assert_eq!(
        planned.state_at(Ticks::MAX).position,
        Position::from_steps(1_000)
    );
    row("motion: plan T14, overshoot and return", t14);

    segments(clock);
    step();
}

fn segments(clock: Clock) {
    let mut axis = Axis::new(AxisConfig {
        clock,
        segment: SEGMENT,
        timing: TIMING,
    });
    let mut sink = Played::default();
    let limits = Limits {
        velocity: 20_000,
        acceleration: 100_000,
        deceleration: 100_000,
    };
    axis.move_to(20_000, limits).unwrap();
    // The ramp takes 200 ms, the cruise 800 ms.
    let mut accelerating = 0;
    let mut cruising = 0;
    let mut ticks = 0;
    while !axis.is_at_rest() {
        let (count, ()) = count(|| advance(&mut axis, &mut sink));
        match ticks {
            100 => accelerating = count,
            500 => cruising = count,
            _ => {}
        }
        ticks += 1;
    }
    assert_eq!(sink.steps, 20_000);
    row(
        "motion: segment of 1 ms, accelerating at 10 kHz",
        accelerating,
    );
    row("motion: segment of 1 ms, cruising at 20 kHz", cruising);
}

/// A timer that is always on time.
struct Punctual;

/// What its counter shows.
static NOW: AtomicU32 = AtomicU32::new(0);

impl StepTimer for Punctual {
    const FALLING_EDGES: bool = true;

    #[inline(always)]
    fn now() -> u32 {
        NOW.load(Ordering::Relaxed)
    }

    #[inline(always)]
    fn schedule(&mut self, time: u32, _edge: Edge) -> u32 {
        NOW.store(time, Ordering::Relaxed);
        time
    }

    fn stop(&mut self) -> bool {
        true
    }

    fn set_direction(&mut self, _direction: Direction) {}

    fn interrupt() {}
}

fn step() {
    let mut shared = step_interrupt::Shared::new();
    let (mut queue, mut player) = step_interrupt::split(&mut shared, Punctual, TIMING);
    let record = Record {
        period: 4_200,
        repeat: 10,
        width: 210,
        direction: Direction::Forward,
    };
    queue.push(record).unwrap();
    player.on_interrupt();
    // One step is two interrupts, at its rising and at its falling edge.
    let (count, ()) = count(|| {
        player.on_interrupt();
        player.on_interrupt();
    });
    assert_eq!(queue.position(), 1);
    row("motion: step interrupts, both edges of a step", count);
}

//! Pulses: a time slice into records, records into the ring of an advanced timer, a step by interrupt.
//!
//! The clock is that of TIM1 on the board, 168 MHz, and a time slice lasts 250 µs.

use core::sync::atomic::{AtomicU32, Ordering};

use motion::advanced_timer::{bits, Output, Register, Registers, Ring, SLOTS, WORDS};
use motion::step_interrupt::{self, Edge, StepTimer};
use motion::{
    Axis, AxisConfig, Clock, Direction, DriverTiming, Limits, PulseSink, Ramps, Record, Ticks,
};

use crate::{count, row};

const HZ: u32 = 168_000_000;
const TIME_SLICE: u32 = HZ / 4_000;

/// What a TMC2209 needs: 100 ns high and low, 20 ns around a change of direction.
const TIMING: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

/// A sink that counts what it is given and plays it when it is told.
#[derive(Default)]
struct Played {
    pending: Ticks,
    steps: i64,
}

impl PulseSink for Played {
    #[inline(always)]
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.pending += record.ticks();
        self.steps += i64::from(record.steps());
        Ok(())
    }

    #[inline(always)]
    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        64
    }
}

#[inline(never)]
fn advance<S: PulseSink>(axis: &mut Axis, sink: &mut S) {
    axis.advance(sink).unwrap();
}

fn axis() -> Axis {
    Axis::new(AxisConfig {
        clock: Clock::new(HZ).unwrap(),
        time_slice: TIME_SLICE,
        timing: TIMING,
    })
}

fn limits(velocity: u32) -> Limits {
    Limits {
        velocity: velocity.into(),
        acceleration: 500_000,
        deceleration: 500_000,
    }
}

/// All workloads.
pub fn run() {
    let accelerating = time_slice(400_000, 800, Ramps::Linear);
    let slow = time_slice(100_000, 2_000, Ramps::Linear);
    let fast = time_slice(1_000_000, 8_500, Ramps::Linear);
    // A window of 100 ms: a sample in each time slice.
    let average = Ramps::MovingAverage(10_000_000);
    let meaning = time_slice(400_000, 1_000, average);
    let steady = time_slice(100_000, 2_000, average);
    // In the first part of the ramp, where the acceleration grows.
    let sine = time_slice(400_000, 1_067, Ramps::SinSquared);
    row(
        "steps: time slice of 250 µs, accelerating at 100 kHz",
        accelerating,
    );
    row(
        "steps: time slice of 250 µs, moving average, accelerating at 100 kHz",
        meaning,
    );
    row(
        "steps: time slice of 250 µs, sin², accelerating at 100 kHz",
        sine,
    );
    row("steps: time slice of 250 µs, cruising at 100 kHz", slow);
    row(
        "steps: time slice of 250 µs, moving average, cruising at 100 kHz",
        steady,
    );
    row("steps: time slice of 250 µs, cruising at 1 MHz", fast);
    row(
        "steps: time slice and ring of the timer, cruising at 1 MHz",
        refill(1_000_000),
    );
    // A period of half a tick more than a whole one: the most runs.
    row(
        "steps: time slice and ring of the timer, cruising at 2 MHz",
        refill(1_988_165),
    );
    row(
        "steps: time slice and ring of the timer, cruising at 4.9 MHz",
        refill(4_869_565),
    );
    row(
        "steps: interrupt, a step whose pulse the timer ends",
        step::<false>(),
    );
    row("steps: interrupts, both edges of a step", step::<true>());
}

/// The share of the CPU for stepping, in thousandths.
pub fn share() {
    for (name, velocity) in [
        ("pulses at 10 kHz, by the timer", 10_000),
        // The worst case below 3.5 MHz: runs of two slots, and three of them.
        ("pulses at 999 kHz, by the timer", 999_000),
        ("pulses at 1 MHz, by the timer", 1_000_000),
        ("pulses at 2 MHz, by the timer", 1_988_165),
        ("pulses at 4.9 MHz, by the timer", 4_869_565),
    ] {
        row(name, thousandths(refills(velocity, CRUISE, 4_000)));
    }
    // The second in the middle of the two that the ramp takes. Slow ones are the worst case.
    for (name, velocity) in [
        ("pulses in a ramp to 20 kHz, by the timer", 20_000),
        ("pulses in a ramp to 500 kHz, by the timer", 500_000),
    ] {
        row(name, thousandths(refills(velocity, 2_000, 4_000)));
    }
    let each = step::<false>();
    row(
        "pulses at 100 kHz, by interrupts",
        each * 100_000 / 1_000 * 3 / 2 / (HZ / 1_000_000),
    );
}

/// Of the instructions of a second, a cycle and a half for each.
fn thousandths(instructions: u32) -> u32 {
    instructions / 2 * 3 / (HZ / 1_000)
}

/// One refill of a time slice, so many refills after the start.
fn time_slice(velocity: u32, refills: u32, ramps: Ramps) -> u32 {
    let mut axis = axis();
    axis.set_ramps(ramps);
    let mut sink = Played::default();
    axis.ramp_to(velocity.cast_signed().into(), limits(velocity))
        .unwrap();
    for _ in 0..refills {
        advance(&mut axis, &mut sink);
        sink.pending = sink.pending.saturating_sub(TIME_SLICE.into());
    }
    let before = sink.steps;
    let (count, ()) = count(|| advance(&mut axis, &mut sink));
    assert!(sink.steps > before);
    count
}

/// What the registers of [`Still`] show: the time, the words left in the round of the stream, when the timer was started, and whether the stream is on.
static NOW: AtomicU32 = AtomicU32::new(0);
static LEFT: AtomicU32 = AtomicU32::new(ALL);
static STARTED: AtomicU32 = AtomicU32::new(0);
static STREAM: AtomicU32 = AtomicU32::new(0);
static RING: Ring = Ring::new();
const ALL: u32 = (SLOTS * WORDS) as u32;

/// Timers that do nothing by themselves.
struct Still;

impl Registers for Still {
    #[inline(always)]
    fn write(&mut self, register: Register, value: u32) {
        match register {
            Register::Egr => STARTED.store(self.now(), Ordering::Relaxed),
            Register::StreamNdtr => LEFT.store(value, Ordering::Relaxed),
            Register::StreamCr => STREAM.store(value, Ordering::Relaxed),
            _ => {}
        }
    }

    #[inline(always)]
    fn read(&self, register: Register) -> u32 {
        match register {
            Register::StreamNdtr => LEFT.load(Ordering::Relaxed),
            Register::StreamCr => STREAM.load(Ordering::Relaxed),
            // No break.
            Register::Bdtr => bits::MOE,
            _ => 0,
        }
    }

    #[inline(always)]
    fn now(&self) -> u32 {
        NOW.load(Ordering::Relaxed)
    }

    fn reset(&mut self) {}
}

#[inline(never)]
fn commit(axis: &mut Axis, output: &mut Output<'_, Still>) {
    output.service();
    axis.advance(output).unwrap();
}

/// Refills until a motion cruises.
const CRUISE: u32 = 8_500;

/// One refill of the ring at this velocity.
fn refill(velocity: u32) -> u32 {
    refills(velocity, CRUISE, 1)
}

/// So many refills of the ring, so many after the start: what they cost together. The velocity is reached in two seconds.
fn refills(velocity: u32, before: u32, number: u32) -> u32 {
    let mut axis = axis();
    let mut output = Output::new(Still, &RING);
    let limits = Limits {
        acceleration: velocity / 2,
        ..limits(velocity)
    };
    axis.ramp_to(velocity.cast_signed().into(), limits).unwrap();
    let mut fetched = 0_u32;
    let mut end = None;
    // The silence in front.
    let mut under_way = 1 << 12;
    let mut sum = 0;
    for turn in 0..before + number {
        let (count, ()) = count(|| commit(&mut axis, &mut output));
        if turn >= before {
            sum += count;
        }
        let now = NOW.load(Ordering::Relaxed).wrapping_add(TIME_SLICE);
        NOW.store(now, Ordering::Relaxed);
        // The slots that have been fetched when the next refill comes.
        let mut next = end.unwrap_or(STARTED.load(Ordering::Relaxed).wrapping_add(1 << 12));
        while now.wrapping_sub(next).cast_signed() >= 0 {
            next = next.wrapping_add(under_way);
            under_way = ticks(RING.words(fetched));
            fetched += 1;
        }
        end = Some(next);
        LEFT.store(
            ALL - fetched % SLOTS as u32 * WORDS as u32,
            Ordering::Relaxed,
        );
    }
    output.drop_all();
    sum
}

fn ticks([_, reload, repetitions, ..]: [u32; WORDS]) -> u32 {
    (reload + 1) * (repetitions + 1)
}

/// A timer that is always on time.
struct Punctual<const FALLS: bool>;

impl<const FALLS: bool> StepTimer for Punctual<FALLS> {
    const FALLING_EDGES: bool = FALLS;

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

#[inline(never)]
fn interrupt<const FALLS: bool>(player: &mut step_interrupt::Player<'_, Punctual<FALLS>>) {
    player.on_interrupt();
}

/// A step in the middle of a run: one interrupt, or one at each of its edges.
fn step<const FALLS: bool>() -> u32 {
    let mut shared = step_interrupt::Shared::new();
    let (mut queue, mut player) = step_interrupt::split(&mut shared, Punctual::<FALLS>, TIMING);
    let record = Record {
        period: 4_200,
        repeat: 10,
        width: 210,
        direction: Direction::Forward,
    };
    queue.push(record).unwrap();
    interrupt(&mut player);
    let (count, ()) = count(|| {
        interrupt(&mut player);
        if FALLS {
            interrupt(&mut player);
        }
    });
    assert_eq!(queue.position(), 1);
    count
}

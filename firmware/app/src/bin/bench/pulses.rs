//! Pulses: a segment into records, records into the ring of an advanced timer, a step by interrupt.
//!
//! The clock is that of TIM1 on the board, 168 MHz, and a segment lasts 250 µs.

use core::sync::atomic::{AtomicU32, Ordering};

use motion::advanced_timer::{Output, Register, Registers, Ring, SLOTS, WORDS};
use motion::step_interrupt::{self, Edge, StepTimer};
use motion::{Axis, AxisConfig, Clock, Direction, DriverTiming, Limits, PulseSink, Record, Ticks};

use crate::{count, row};

const HZ: u32 = 168_000_000;
const SEGMENT: u32 = HZ / 4_000;

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
    slowest: u32,
}

impl PulseSink for Played {
    #[inline(always)]
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.pending += record.ticks();
        self.steps += i64::from(record.steps());
        self.slowest = self.slowest.max(record.period);
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
        segment: SEGMENT,
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
    let accelerating = segment(400_000, 800);
    let slow = segment(100_000, 2_000);
    let fast = segment(1_000_000, 8_500);
    row(
        "steps: segment of 250 µs, accelerating at 100 kHz",
        accelerating,
    );
    row("steps: segment of 250 µs, cruising at 100 kHz", slow);
    row("steps: segment of 250 µs, cruising at 1 MHz", fast);
    row(
        "steps: segment and ring of the timer, cruising at 1 MHz",
        refill(1_000_000),
    );
    // A period of half a tick more than a whole one: the most runs.
    row(
        "steps: segment and ring of the timer, cruising at 2 MHz",
        refill(1_988_165),
    );
    row(
        "steps: segment and ring of the timer, cruising at 4.9 MHz",
        refill(4_869_565),
    );
    row(
        "steps: interrupt, a step whose pulse the timer ends",
        step::<false>(),
    );
    row("steps: interrupts, both edges of a step", step::<true>());
}

/// The share of the CPU for stepping at 1 MHz, in thousandths, and how fast a stop is felt.
pub fn share() {
    // 4,000 refills in a second, a cycle and a half for each instruction.
    let share = |velocity| refill(velocity) * 4_000 * 3 / 2 / (HZ / 1_000);
    row("pulses at 1 MHz, by the timer", share(1_000_000));
    row("pulses at 2 MHz, by the timer", share(1_988_165));
    row("pulses at 4.9 MHz, by the timer", share(4_869_565));
    let each = step::<false>();
    row(
        "pulses at 100 kHz, by interrupts",
        each * 100_000 / 1_000 * 3 / 2 / (HZ / 1_000_000),
    );
}

/// From the order to stop to the end of the first slower step, in µs: what was handed out is played before.
pub fn stop() {
    let mut axis = axis();
    let mut sink = Played::default();
    axis.ramp_to(100_000.into(), limits(100_000)).unwrap();
    let mut longest = 0;
    for turn in 0..2_000 {
        advance(&mut axis, &mut sink);
        if turn > 1_000 && turn % 50 == 0 {
            // Right after a refill, when the most has been handed out.
            let mut stopped = axis.clone();
            stopped.stop(50_000_000).unwrap();
            let mut felt = Felt {
                pending: sink.pending,
                total: sink.pending,
                slower: None,
            };
            while felt.slower.is_none() {
                felt.pending = felt.pending.saturating_sub(SEGMENT.into());
                advance(&mut stopped, &mut felt);
            }
            longest = longest.max(felt.slower.unwrap_or(0));
        }
        sink.pending = sink.pending.saturating_sub(SEGMENT.into());
    }
    row(
        "quick stop to the first slower step",
        (longest / 168) as u32,
    );
}

/// A sink that waits for a slower step than those of 100 kHz.
struct Felt {
    pending: Ticks,
    total: Ticks,
    slower: Option<Ticks>,
}

impl PulseSink for Felt {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if self.slower.is_none() && record.period > 1_690 {
            self.slower = Some(self.total + Ticks::from(record.period));
        }
        self.pending += record.ticks();
        self.total += record.ticks();
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        64
    }
}

/// One refill of a segment, so many refills after the start.
fn segment(velocity: u32, refills: u32) -> u32 {
    let mut axis = axis();
    let mut sink = Played::default();
    axis.ramp_to(velocity.cast_signed().into(), limits(velocity))
        .unwrap();
    for _ in 0..refills {
        advance(&mut axis, &mut sink);
        sink.pending = sink.pending.saturating_sub(SEGMENT.into());
    }
    let before = sink.steps;
    let (count, ()) = count(|| advance(&mut axis, &mut sink));
    assert!(sink.steps > before);
    count
}

/// What the registers of [`Still`] show: the time, the words left in the round of the stream, and when the timer was started.
static NOW: AtomicU32 = AtomicU32::new(0);
static LEFT: AtomicU32 = AtomicU32::new(ALL);
static STARTED: AtomicU32 = AtomicU32::new(0);
static RING: Ring = Ring::new();
const ALL: u32 = (SLOTS * WORDS) as u32;

/// Timers that do nothing by themselves.
struct Still;

impl Registers for Still {
    #[inline(always)]
    fn write(&mut self, register: Register, _value: u32) {
        if register == Register::Egr {
            STARTED.store(self.now(), Ordering::Relaxed);
            LEFT.store(ALL, Ordering::Relaxed);
        }
    }

    #[inline(always)]
    fn read(&self, register: Register) -> u32 {
        match register {
            Register::StreamNdtr => LEFT.load(Ordering::Relaxed),
            _ => 0,
        }
    }

    #[inline(always)]
    fn now(&self) -> u32 {
        NOW.load(Ordering::Relaxed)
    }
}

#[inline(never)]
fn hand_out(axis: &mut Axis, output: &mut Output<'_, Still>) {
    output.service();
    axis.advance(output).unwrap();
}

/// One refill of the ring at this velocity, which it takes two seconds to reach.
fn refill(velocity: u32) -> u32 {
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
    for _ in 0..8_500 {
        hand_out(&mut axis, &mut output);
        let now = NOW.load(Ordering::Relaxed).wrapping_add(SEGMENT);
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
    let (count, ()) = count(|| hand_out(&mut axis, &mut output));
    output.drop_all();
    count
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

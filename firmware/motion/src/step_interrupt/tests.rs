//! The player on a timer that writes down every edge, and an interrupt with latency.

mod lateness;
mod pending;

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::thread_local;
use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::{Edge, Player, RecordQueue, Shared, StepTimer, split};
use crate::Direction::{Forward, Reverse};
use crate::{Direction, DriverTiming, PulseSink, Record};

thread_local! {
    /// The interrupt was raised by software.
    static RAISED: Cell<bool> = const { Cell::new(false) };
    /// The counter.
    static NOW: Cell<u32> = const { Cell::new(0) };
}

/// A timer whose time is moved by the test.
#[derive(Clone, Debug, Default)]
struct Model(Rc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    alarm: Cell<Option<(u32, Option<Edge>)>>,
    /// Ticks between the call and the moment the edge is scheduled.
    slowness: Cell<u32>,
    /// Ticks that `stop` takes before and after it takes effect.
    stopping: Cell<(u32, u32)>,
    high: Cell<bool>,
    direction: Cell<Option<Direction>>,
    log: RefCell<Vec<(u32, What)>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Rise,
    Fall,
    Turn(Direction),
}

impl Model {
    fn log(&self, what: What) {
        self.0.log.borrow_mut().push((NOW.get(), what));
    }

    fn apply(&self, edge: Edge) {
        match edge {
            Edge::Rise if !self.0.high.replace(true) => self.log(What::Rise),
            Edge::Fall if self.0.high.replace(false) => self.log(What::Fall),
            _ => {}
        }
    }

    fn rises(&self) -> Vec<u32> {
        let log = self.0.log.borrow();
        log.iter()
            .filter(|(_, what)| *what == What::Rise)
            .map(|(at, _)| *at)
            .collect()
    }
}

impl StepTimer for Model {
    const FALLING_EDGES: bool = true;

    fn now() -> u32 {
        NOW.get()
    }

    fn schedule(&mut self, time: u32, edge: Edge) -> u32 {
        pass(self.0.slowness.get());
        self.0.alarm.set(Some((time, Some(edge))));
        if NOW.get().wrapping_sub(time) > u32::MAX / 2 {
            return time;
        }
        // Exactly on time is a match.
        let at = NOW.get();
        self.apply(edge);
        self.0.alarm.set(Some((at, None)));
        at
    }

    fn stop(&mut self) -> bool {
        let (before, after) = self.0.stopping.get();
        pass(before);
        let alarm = self.0.alarm.take();
        let has_happened = alarm.filter(|(time, _)| NOW.get().wrapping_sub(*time) <= u32::MAX / 2);
        if let Some((_, Some(edge))) = has_happened {
            self.apply(edge);
        }
        pass(after);
        self.apply(Edge::Fall);
        has_happened.is_some()
    }

    fn set_direction(&mut self, direction: Direction) {
        if self.0.direction.replace(Some(direction)) != Some(direction) {
            self.log(What::Turn(direction));
        }
    }

    fn interrupt() {
        RAISED.set(true);
    }
}

/// Lets time pass in which no interrupt comes.
fn pass(ticks: u32) {
    NOW.set(NOW.get().wrapping_add(ticks));
}

/// What the driver of these tests needs.
const TIMING: DriverTiming = DriverTiming {
    pulse_high: 1,
    pulse_low: 1,
    direction_setup: 50,
    direction_hold: 1,
};

/// A processor with a queue, a player and an interrupt that takes a while to begin.
struct Bench {
    timer: Model,
    queue: RecordQueue<'static, Model>,
    player: Player<'static, Model>,
}

impl Bench {
    fn starting_at(now: u32) -> Self {
        Self::with(now, TIMING)
    }

    fn with(now: u32, timing: DriverTiming) -> Self {
        RAISED.set(false);
        let timer = Model::default();
        NOW.set(now);
        // A test is short; its memory may stay.
        let shared = std::boxed::Box::leak(std::boxed::Box::new(Shared::new()));
        let (queue, player) = split(shared, timer.clone(), timing);
        Self {
            timer,
            queue,
            player,
        }
    }

    fn new() -> Self {
        Self::starting_at(0)
    }

    fn push(&mut self, record: Record) {
        self.queue.push(record).unwrap();
        self.serve_raised();
    }

    fn serve_raised(&mut self) {
        if RAISED.replace(false) {
            self.player.on_interrupt();
        }
    }

    /// Lets time pass up to the next alarm, which the interrupt serves `latency` ticks later. False: no alarm is set.
    fn step(&mut self, latency: u32) -> bool {
        let Some((time, edge)) = self.timer.0.alarm.take() else {
            return false;
        };
        NOW.set(time);
        if let Some(edge) = edge {
            self.timer.apply(edge);
        }
        pass(latency);
        self.player.on_interrupt();
        true
    }

    fn play(&mut self, latency: u32) {
        while self.step(latency) {}
    }
}

fn record(period: u32, repeat: u16, width: u16, direction: Direction) -> Record {
    Record {
        period,
        repeat,
        width,
        direction,
    }
}

#[test]
fn pulses_rise_at_the_times_of_the_records() {
    let mut bench = Bench::new();
    bench.push(record(100, 1, 0, Forward));
    bench.push(record(50, 3, 10, Forward));
    bench.push(record(70, 2, 10, Forward));
    bench.play(3);
    let rises = bench.timer.rises();
    let gaps: Vec<_> = rises.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert_eq!(gaps, [50, 50, 50, 70]);
    assert_eq!(bench.queue.position(), 5);
    assert_eq!(bench.queue.pending(), 0);
}

#[test]
fn each_pulse_is_as_wide_as_its_record_says() {
    let mut bench = Bench::new();
    bench.push(record(100, 2, 30, Forward));
    bench.push(record(100, 1, 40, Forward));
    bench.play(2);
    let log = bench.timer.0.log.borrow().clone();
    let edges: Vec<_> = log
        .iter()
        .map(|(at, what)| (at - log[0].0, *what))
        .collect();
    use What::{Fall, Rise};
    assert_eq!(
        edges,
        [
            (0, Rise),
            (30, Fall),
            (100, Rise),
            (130, Fall),
            (200, Rise),
            (240, Fall)
        ]
    );
}

#[test]
fn the_direction_turns_when_its_silent_record_begins() {
    let mut bench = Bench::new();
    bench.push(record(100, 1, 0, Forward));
    bench.push(record(100, 2, 10, Forward));
    bench.push(record(500, 1, 0, Reverse));
    bench.push(record(100, 3, 10, Reverse));
    bench.play(0);
    let log = bench.timer.0.log.borrow().clone();
    let turn = log
        .iter()
        .position(|(_, what)| *what == What::Turn(Reverse))
        .unwrap();
    assert_eq!(log[turn - 1].1, What::Fall);
    assert_eq!(
        log[turn].0 - log[turn - 1].0,
        90,
        "the last forward period is played out"
    );
    assert_eq!(log[turn + 1], (log[turn].0 + 500, What::Rise));
    assert_eq!(bench.queue.position(), -1);
}

#[test]
fn a_queue_that_ran_dry_starts_again_by_itself() {
    let mut bench = Bench::new();
    bench.push(record(100, 1, 10, Forward));
    bench.play(5);
    assert!(bench.timer.0.alarm.get().is_none(), "nothing is scheduled");
    bench.push(record(100, 2, 10, Forward));
    bench.play(5);
    assert_eq!(bench.queue.position(), 3);
    assert_eq!(bench.queue.pending(), 0);
}

#[test]
fn dropping_stops_the_train_and_keeps_the_count_of_pulses_that_left() {
    for steps in 0..12 {
        let mut bench = Bench::new();
        bench.push(record(100, 3, 10, Forward));
        bench.push(record(100, 5, 10, Forward));
        for _ in 0..steps {
            bench.step(1);
        }
        bench.queue.drop_all();
        bench.serve_raised();
        assert!(bench.timer.0.alarm.get().is_none());
        assert!(!bench.timer.0.high.get(), "the step signal is low");
        assert_eq!(
            bench.queue.position(),
            bench.timer.rises().len() as i64,
            "after {steps} interrupts"
        );
        assert_eq!(bench.queue.pending(), 0, "after {steps} interrupts");

        bench.push(record(100, 2, 10, Reverse));
        bench.play(1);
        assert_eq!(bench.queue.pending(), 0);
        // The last two went backwards.
        assert_eq!(bench.queue.position(), bench.timer.rises().len() as i64 - 4);
    }
}

#[test]
fn a_pulse_that_rises_while_the_drop_is_on_its_way_counts() {
    let mut bench = Bench::new();
    bench.push(record(100, 3, 10, Forward));
    bench.step(0);
    bench.step(0);
    // The edge comes, but the interrupt finds the order to drop first.
    let (time, edge) = bench.timer.0.alarm.get().unwrap();
    NOW.set(time);
    bench.timer.apply(edge.unwrap());
    bench.queue.drop_all();
    bench.serve_raised();
    assert_eq!(bench.queue.position(), bench.timer.rises().len() as i64);
}

#[test]
fn a_position_is_kept_beyond_32_bits() {
    let mut bench = Bench::new();
    let mut expected = 0i64;
    for _ in 0..6 {
        bench
            .queue
            .shared
            .position
            .fetch_add(i32::MAX, core::sync::atomic::Ordering::Relaxed);
        expected += i64::from(i32::MAX);
        assert_eq!(bench.queue.position(), expected);
    }
}

#[test]
fn a_full_queue_gives_the_record_back() {
    let mut bench = Bench::new();
    let silent = record(1_000, 1, 0, Forward);
    while bench.queue.free() > 0 {
        bench.queue.push(silent).unwrap();
    }
    assert_eq!(bench.queue.push(silent), Err(silent));
}

fn any_record() -> impl Strategy<Value = Record> {
    (20..2_000u32, 1..5u16, prop_oneof![Just(0), 1..10u16])
        .prop_map(|(period, repeat, width)| record(period, repeat, width, Forward))
}

proptest! {
    #[test]
    fn no_pulse_is_lost_and_none_comes_early(
        records in prop::collection::vec(any_record(), 1..60),
        latencies in prop::collection::vec(0..8u32, 1..20),
        start in prop_oneof![Just(0), Just(u32::MAX - 500), any::<u32>()],
        spurious in prop::collection::vec(any::<bool>(), 1..20),
    ) {
        let mut bench = Bench::starting_at(start);
        // The direction is set before the first pulse.
        bench.push(record(2_000, 1, 0, Forward));
        for record in &records {
            bench.push(*record);
        }
        let mut latency = latencies.iter().cycle();
        let mut spurious = spurious.iter().cycle();
        while bench.step(*latency.next().unwrap()) {
            if *spurious.next().unwrap() {
                bench.player.on_interrupt();
            }
        }
        let pulses: u32 = records.iter().filter(|record| record.width > 0).map(|record| u32::from(record.repeat)).sum();
        prop_assert_eq!(bench.queue.position(), i64::from(pulses));
        prop_assert_eq!(bench.queue.pending(), 0);

        // With a latency below the shortest period, every rise is where the records put it.
        let mut expected = vec![];
        let mut at = 0u32;
        for record in &records {
            for _ in 0..record.repeat {
                if record.width > 0 {
                    expected.push(at);
                }
                at += record.period;
            }
        }
        let rises = bench.timer.rises();
        let first = rises.first().copied().unwrap_or(0);
        let seen: Vec<_> = rises.iter().map(|rise| rise.wrapping_sub(first)).collect();
        let base = expected.first().copied().unwrap_or(0);
        let wanted: Vec<_> = expected.iter().map(|rise| rise - base).collect();
        prop_assert_eq!(seen, wanted);
    }

    #[test]
    fn a_late_interrupt_never_pushes_pulses_together(
        records in prop::collection::vec(any_record(), 1..40),
        latencies in prop::collection::vec(prop_oneof![0..8u32, 0..5_000u32], 1..20),
    ) {
        let mut bench = Bench::new();
        for record in &records {
            bench.push(*record);
        }
        let mut latency = latencies.iter().cycle();
        while bench.step(*latency.next().unwrap()) {}
        let shortest = records.iter().map(|record| record.period).min().unwrap();
        for pair in bench.timer.rises().windows(2) {
            prop_assert!(pair[1] - pair[0] >= shortest, "{} after {}", pair[1], pair[0]);
        }
        let pulses: u32 = records.iter().filter(|record| record.width > 0).map(|record| u32::from(record.repeat)).sum();
        prop_assert_eq!(bench.queue.position(), i64::from(pulses));
    }
}

//! The same records through both backends: the same pulses at the same ticks.

use std::cell::RefCell;

use motion::step_interrupt::{self, Edge, Shared, StepTimer};
use motion::{Axis, AxisConfig, Clock, Direction, Limits, PulseSink, Record, Speed, Ticks};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::random::ramps;
use super::slow::{HOURLY, limits};
use super::{FAST, ring};
use crate::timer_model::rig::{HZ, TIME_SLICE};
use crate::timer_model::{Judge, TimerModel};
use motion::advanced_timer::Output;

thread_local! {
    static ALARM: RefCell<Alarm> = const { RefCell::new(Alarm::NEW) };
}

/// An ideal timer with one alarm.
struct Alarm {
    now: u32,
    alarm: Option<(u32, Edge)>,
    raised: bool,
    forward: bool,
    log: Vec<(u64, i8)>,
}

impl Alarm {
    const NEW: Self = Self {
        now: 0,
        alarm: None,
        raised: false,
        forward: true,
        log: Vec::new(),
    };
}

fn with<R>(look: impl FnOnce(&mut Alarm) -> R) -> R {
    ALARM.with_borrow_mut(look)
}

struct Ideal<const FALLS: bool>;

impl<const FALLS: bool> StepTimer for Ideal<FALLS> {
    const FALLING_EDGES: bool = FALLS;

    fn now() -> u32 {
        with(|alarm| alarm.now)
    }

    fn schedule(&mut self, time: u32, edge: Edge) -> u32 {
        with(|alarm| alarm.alarm = Some((time, edge)));
        time
    }

    fn stop(&mut self) -> bool {
        with(|alarm| alarm.alarm.take()).is_none()
    }

    fn set_direction(&mut self, direction: Direction) {
        with(|alarm| alarm.forward = direction == Direction::Forward);
    }

    fn interrupt() {
        with(|alarm| alarm.raised = true);
    }
}

/// What the interrupts make of the records.
fn by_interrupts<const FALLS: bool>(records: &[Record]) -> Vec<(u64, i8)> {
    with(|alarm| *alarm = Alarm::NEW);
    let mut shared = Shared::new();
    let (mut queue, mut player) = step_interrupt::split(&mut shared, Ideal::<FALLS>, FAST);
    let mut records = records.iter();
    let mut next = records.next();
    loop {
        while let Some(record) = next.filter(|_| queue.free() > 0) {
            queue.push(*record).unwrap();
            next = records.next();
        }
        if with(|alarm| std::mem::take(&mut alarm.raised)) {
            player.on_interrupt();
        }
        let Some((time, edge)) = with(|alarm| alarm.alarm.take()) else {
            break;
        };
        with(|alarm| {
            alarm.now = time;
            if edge == Edge::Rise {
                let sign = if alarm.forward { 1 } else { -1 };
                alarm.log.push((time.into(), sign));
            }
        });
        player.on_interrupt();
    }
    assert_eq!(queue.pending(), 0);
    let log = with(|alarm| std::mem::take(&mut alarm.log));
    assert_eq!(
        queue.position(),
        log.iter().map(|(_, sign)| i64::from(*sign)).sum::<i64>()
    );
    log
}

/// What the advanced timer makes of them.
fn by_timer(records: &[Record]) -> Vec<(u64, i8)> {
    let ring = ring();
    let model = TimerModel::new(ring, Judge::new(FAST).logging());
    let mut output = Output::new(model.clone(), ring);
    let mut records = records.iter();
    let mut next = records.next();
    while next.is_some() || output.pending() > 0 {
        output.service();
        while let Some(record) = next {
            if output.push(*record).is_err() {
                break;
            }
            next = records.next();
        }
        // Not until the ring runs dry.
        model.run(4_000);
    }
    let position = model.judge().position;
    assert_eq!(output.position(), position);
    let log = model.judge().log.clone().unwrap();
    assert_eq!(
        position,
        log.iter().map(|(_, sign)| i64::from(*sign)).sum::<i64>()
    );
    log
}

/// A stream as a train makes it: the direction changes in silence, and nothing is shorter than a driver or a burst needs.
fn any_stream() -> impl Strategy<Value = Vec<Record>> {
    let part = (
        prop_oneof![84..400u32, 84..40_000u32, 60_000..200_000u32],
        1..700u16,
        any::<bool>(),
        any::<bool>(),
    );
    prop::collection::vec(part, 1..40).prop_map(|parts| {
        let mut direction = Direction::Forward;
        let mut records = vec![Record {
            period: 30_000,
            repeat: 1,
            width: 0,
            direction,
        }];
        for (period, repeat, pulses, turns) in parts {
            if turns {
                direction = direction.reversed();
                records.push(Record {
                    period: 5_000,
                    repeat: 1,
                    width: 0,
                    direction,
                });
            }
            records.push(Record {
                period,
                repeat: if period > 1_000 {
                    repeat % 8 + 1
                } else {
                    repeat
                },
                width: if pulses { 17 } else { 0 },
                direction,
            });
        }
        // The ring is filled while this is played.
        records.push(Record {
            period: 60_000,
            repeat: 1,
            width: 0,
            direction,
        });
        records
    })
}

fn from_the_first(log: Vec<(u64, i8)>) -> Vec<(u64, i8)> {
    let first = log.first().map_or(0, |(at, _)| *at);
    log.into_iter()
        .map(|(at, sign)| (at - first, sign))
        .collect()
}

/// Keeps the records of an axis.
#[derive(Default)]
struct Kept {
    records: Vec<Record>,
    pending: Ticks,
}

impl Kept {
    /// So many refills, each a time slice behind the other.
    fn play(&mut self, axis: &mut Axis, refills: u32) {
        for _ in 0..refills {
            axis.advance(self).unwrap();
            self.pending = self.pending.saturating_sub(TIME_SLICE.into());
        }
    }

    /// All there is until the axis rests.
    fn play_out(&mut self, axis: &mut Axis) {
        while !axis.is_at_rest() {
            self.pending = 0;
            let _ = axis.advance(self);
        }
    }
}

fn still() -> Axis {
    Axis::new(AxisConfig {
        clock: Clock::new(HZ).unwrap(),
        time_slice: TIME_SLICE,
        timing: FAST,
    })
}

impl PulseSink for Kept {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.pending += record.ticks();
        self.records.push(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        usize::MAX
    }
}

#[test]
fn both_backends_play_a_step_in_an_hour_and_a_megahertz_alike() {
    let mut axis = still();
    let mut kept = Kept::default();
    let fast = Speed::per_second(1_000_000);
    let orders = [
        (HOURLY, false, 400),
        (fast, false, 40),
        (HOURLY, false, 400),
        (fast, true, 40),
        (HOURLY, true, 40),
    ];
    for (speed, reverse, refills) in orders {
        axis.ramp_to(speed.signed(reverse), limits(speed)).unwrap();
        kept.play(&mut axis, refills);
    }
    axis.stop(1_000_000).unwrap();
    kept.play_out(&mut axis);
    let by_timer = from_the_first(by_timer(&kept.records));
    assert!(by_timer.len() > 15_000);
    assert_eq!(
        from_the_first(by_interrupts::<false>(&kept.records)),
        by_timer
    );
    assert_eq!(
        from_the_first(by_interrupts::<true>(&kept.records)),
        by_timer
    );
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() }))]

    /// What an axis makes of velocities and stops, with every kind of ramps.
    #[test]
    fn both_backends_play_every_kind_of_ramps_alike(
        orders in prop::collection::vec((ramps(25), -400_000..400_000i32, 18..27u32, 1..80u32), 1..8),
    ) {
        let mut axis = still();
        let mut kept = Kept::default();
        for (ramps, velocity, acceleration, refills) in orders {
            axis.set_ramps(ramps);
            let limits = Limits { acceleration: 1 << acceleration, deceleration: 1 << acceleration, velocity: 400_000.into() };
            // A velocity that is refused leaves the motion as it was.
            let _ = axis.ramp_to(velocity.into(), limits);
            kept.play(&mut axis, refills);
        }
        axis.stop(100_000_000).unwrap();
        kept.play_out(&mut axis);
        let by_timer = from_the_first(by_timer(&kept.records));
        prop_assert_eq!(&from_the_first(by_interrupts::<false>(&kept.records)), &by_timer);
        prop_assert_eq!(&from_the_first(by_interrupts::<true>(&kept.records)), &by_timer);
    }

    #[test]
    fn both_backends_make_the_same_pulses_at_the_same_ticks(records in any_stream()) {
        let by_timer = from_the_first(by_timer(&records));
        prop_assert_eq!(&from_the_first(by_interrupts::<false>(&records)), &by_timer);
        prop_assert_eq!(&from_the_first(by_interrupts::<true>(&records)), &by_timer);
    }
}

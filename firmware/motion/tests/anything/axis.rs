//! An axis under any orders, refills that come late, and sinks of any size: no panic, every pulse accounted for, and an end.

use std::collections::VecDeque;

use motion::{
    AdvanceError, Axis, AxisConfig, Clock, Direction, DriverTiming, Goal, Limits, Position,
    PulseSink, Ramps, Record, Ticks, Velocity,
};

use crate::bytes::Bytes;

/// Orders of a sequence at most, and refills between all of them.
const ORDERS: usize = 60;
const REFILLS: u32 = 3_000;

/// What a stop and a short move may take at the end.
const PATIENCE: u32 = 400_000;

/// A TMC2209 and a DRV8825 at 168 MHz.
const DRIVERS: [DriverTiming; 2] = [
    DriverTiming {
        pulse_high: 17,
        pulse_low: 17,
        direction_setup: 4,
        direction_hold: 4,
    },
    DriverTiming {
        pulse_high: 320,
        pulse_low: 320,
        direction_setup: 110,
        direction_hold: 110,
    },
];

/// What plays the records: it counts, and holds them to what a driver needs.
#[derive(Debug)]
struct Sink {
    records: VecDeque<Record>,
    room: usize,
    played: Ticks,
    direction: Option<Direction>,
    shortest: u32,
    position: i32,
}

impl Sink {
    fn play(&mut self, mut ticks: Ticks) {
        while let Some(front) = self.records.front() {
            let left = front.ticks() - self.played;
            if left > ticks {
                self.played += ticks;
                return;
            }
            ticks -= left;
            self.played = 0;
            self.records.pop_front();
        }
    }

    fn clear(&mut self) {
        self.records.clear();
        self.played = 0;
        self.direction = None;
    }
}

impl PulseSink for Sink {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if self.free() == 0 {
            return Err(record);
        }
        assert!(
            record.repeat > 0 && record.period >= self.shortest,
            "{record:?}"
        );
        let turns = self.direction.replace(record.direction) != Some(record.direction);
        assert!(
            !turns || record.width == 0,
            "a pulse that turns: {record:?}"
        );
        self.position = self.position.wrapping_add(record.steps());
        self.records.push_back(record);
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.records.iter().map(Record::ticks).sum::<Ticks>() - self.played
    }

    fn free(&self) -> usize {
        self.room.saturating_sub(self.records.len())
    }
}

struct Bench {
    axis: Axis,
    sink: Sink,
    clock: Clock,
    time_slice: Ticks,
}

impl Bench {
    fn new(bytes: &mut Bytes<'_>) -> Self {
        let hz = [84_000_000, 168_000_000, 1_000_000_000][usize::from(bytes.byte() % 3)];
        let timing = match bytes.byte() {
            0..100 => DRIVERS[0],
            100..200 => DRIVERS[1],
            _ => timing(bytes),
        };
        let time_slice = hz / [4_000, 1_000, 10_000][usize::from(bytes.byte() % 3)];
        let clock = Clock::new(hz).expect("a clock that motion can use");
        Self {
            axis: Axis::new(AxisConfig {
                clock,
                time_slice,
                timing,
            }),
            sink: Sink {
                records: VecDeque::new(),
                room: 256,
                played: 0,
                direction: None,
                shortest: timing.shortest_period(),
                position: 0,
            },
            clock,
            time_slice: time_slice.into(),
        }
    }

    /// A refill behind so many ticks. What cannot be taken now is taken later.
    fn refill(&mut self, ticks: Ticks) {
        self.sink.play(ticks);
        let was_empty = self.sink.pending() == 0;
        match self.axis.advance(&mut self.sink) {
            Ok(()) => {}
            Err(AdvanceError::SinkFull) => assert_eq!(self.sink.free(), 0),
            Err(AdvanceError::Internal) => panic!("a bound was reached"),
            Err(AdvanceError::Underrun) => assert!(was_empty),
        }
        self.account();
    }

    fn account(&self) {
        assert_eq!(
            self.sink.position,
            self.axis.committed_position() as i32,
            "pulses and position"
        );
        let _ = (self.axis.demand(self.sink.pending()), self.axis.heading());
        let _ = (self.axis.target(), self.axis.committed_velocity());
    }

    /// The power goes: what is not played is gone, and the axis is told where it is.
    fn drop_all(&mut self) {
        self.sink.clear();
        assert_eq!(self.axis.abort(), self.axis.committed_position());
        assert!(self.axis.is_at_rest());
    }

    fn finish(&mut self) {
        for _ in 0..PATIENCE {
            self.refill(self.time_slice);
            if self.axis.is_at_rest() {
                return;
            }
        }
        panic!("the motion does not end: {:?}", self.axis);
    }
}

fn timing(bytes: &mut Bytes<'_>) -> DriverTiming {
    DriverTiming {
        pulse_high: bytes.number(12) as u32,
        pulse_low: bytes.number(12) as u32,
        direction_setup: bytes.number(16) as u32,
        direction_hold: bytes.number(16) as u32,
    }
}

/// Plays the orders that these bytes say.
///
/// # Panics
/// If a pulse is too many or too few, or the motion does not end.
pub fn check(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let mut bench = Bench::new(&mut bytes);
    let mut refills = REFILLS;
    for _ in 0..ORDERS {
        if bytes.is_empty() {
            break;
        }
        order(&mut bench, &mut bytes);
        let count = u32::from(bytes.byte()).min(refills);
        refills -= count;
        // On time, or late by any part of four time slices.
        let late = match bytes.byte() {
            0..200 => bench.time_slice,
            late => bench.time_slice * u64::from(late - 200) / 16,
        };
        for _ in 0..count {
            bench.refill(late);
        }
    }
    // From anywhere it comes to rest, and moves again.
    bench.sink.room = 256;
    bench.axis.set_ramps(Ramps::Linear);
    bench.axis.stop(400_000_000).expect("a stop that can be");
    bench.finish();
    let limits = Limits {
        velocity: 1_000_000.into(),
        acceleration: 100_000_000,
        deceleration: 100_000_000,
    };
    let target = bench.axis.committed_position() + 777;
    bench.axis.move_to(target, limits).expect("a short move");
    bench.finish();
    assert_eq!(bench.sink.position, target as i32);
}

/// One order. What is refused leaves the motion as it was.
fn order(bench: &mut Bench, bytes: &mut Bytes<'_>) {
    let axis = &mut bench.axis;
    match bytes.byte() % 16 {
        0..=5 => {
            let limits = bytes.limits();
            let _ = match bytes.goal() {
                Goal::Rest(target) => axis.move_to(target, limits),
                Goal::Pass(target, velocity) => axis.move_through(target, velocity, limits),
                Goal::Velocity(velocity) => axis.ramp_to(velocity, limits),
            };
        }
        6 => {
            let target = axis.committed_position() + bytes.signed(12);
            let _ = axis.move_to(target, bytes.limits());
        }
        7 => {
            let _ = axis.stop(bytes.rate());
        }
        8 | 9 => axis.set_ramps(bytes.ramps()),
        10 | 11 => {
            // Up to 100 ms behind the set-point before, and no further than pulses go: nobody else holds set-points to that.
            let (start, state) = axis.path_end();
            let length = bytes.number(24);
            let end = start.saturating_add(length);
            let most = axis.max_velocity();
            let [velocity, last] = [(); 2].map(|()| bytes.signed_speed().within(most));
            let distance =
                i128::from(velocity.bits()) * i128::from(length) / i128::from(bench.clock.hz());
            let to = state.position.bits().wrapping_add(distance as i64);
            let to = Position::from_bits(to);
            let _ = match bytes.byte() % 3 {
                0 => axis.follow(end, to),
                1 => axis.follow_smoothly(end, to, Velocity::from_speed(bench.clock, last)),
                _ => axis.follow_velocity(end, velocity),
            };
        }
        12 => bench.sink.room = usize::from(bytes.byte()).max(1),
        13 => bench.sink.play(Ticks::MAX),
        14 => bench.drop_all(),
        _ => {
            bench.drop_all();
            let position = bytes.signed(33);
            bench.axis.set_position(position);
            bench.sink.position = position as i32;
        }
    }
}

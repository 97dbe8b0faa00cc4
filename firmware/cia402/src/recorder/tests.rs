//! The recorder against a list of everything that was published.

use core::sync::atomic::AtomicU32;
use std::vec::Vec;

use canopen::Instant;
use canopen::cia301::sdo::AbortCode;
use proptest::prelude::*;

use super::values::bits;
use super::{CHANNELS, Edge, HEADER, Memory, Orders, Recorder, Setup, Signal, State, Trigger};
use crate::exchange::{Actuals, Exchange};
use crate::testing::Rig;

const WORDS: usize = 64;

/// A recorder that is shown actual values of one's own making.
struct Bench<'a> {
    recorder: Recorder<&'a Memory>,
    memory: &'a Memory,
    exchange: Exchange,
    rig: Rig,
    shown: Vec<Actuals>,
}

impl<'a> Bench<'a> {
    fn new(memory: &'a Memory) -> Self {
        let mut bench = Self {
            recorder: Recorder::new(memory, Rig::TICK),
            memory,
            exchange: Exchange::new(),
            rig: Rig::new(),
            shown: Vec::new(),
        };
        bench.recorder.tick(&bench.rig.drive, &mut bench.exchange);
        bench
    }

    fn order(&mut self, orders: Orders) {
        self.exchange.order(orders);
    }

    fn arm(&mut self, setup: Setup) {
        self.order(Orders {
            arm: Some(setup),
            ..Orders::default()
        });
        self.shown.clear();
    }

    /// A tick that publishes this position.
    fn show(&mut self, position: i32) -> State {
        let number = self.shown.len() as u64;
        let actuals = Actuals {
            at: Instant::from_ticks(number * 1_000),
            position_actual: position,
            position_demand: position.wrapping_mul(3),
            statusword: number as u16,
            mode_display: number as i8,
            velocity_actual: position.wrapping_neg(),
            digital_inputs: position as u32 & 0xFF,
            ..Actuals::NONE
        };
        self.exchange.publish(&actuals);
        self.shown.push(actuals);
        self.recorder.tick(&self.rig.drive, &mut self.exchange);
        self.exchange.scope().state
    }

    /// What 20D3h has.
    fn read(&self) -> Option<Read> {
        self.memory.whole()?;
        let length = self.memory.length();
        let bytes: Vec<u8> = (0..length.div_ceil(4))
            .flat_map(|word| self.memory.word(word).to_le_bytes())
            .collect();
        let u16_at = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let stride = usize::from(u16_at(12));
        let samples = bytes[HEADER as usize..length as usize].chunks(stride);
        Some(Read {
            before: usize::from(u16_at(20)),
            late: usize::from(u16_at(14)),
            triggered: u64::from_le_bytes(bytes[24..32].try_into().unwrap()),
            samples: samples.map(<[u8]>::to_vec).collect(),
        })
    }
}

#[derive(Debug, PartialEq, Eq)]
struct Read {
    before: usize,
    late: usize,
    triggered: u64,
    samples: Vec<Vec<u8>>,
}

fn channels(signals: &[Signal]) -> [Option<Signal>; CHANNELS] {
    let mut channels = [None; CHANNELS];
    for (channel, signal) in channels.iter_mut().zip(signals) {
        *channel = Some(*signal);
    }
    channels
}

/// The bytes of a sample as `docs/scope.md` has them.
fn packed(setup: &Setup, bench: &Bench<'_>, actuals: &Actuals) -> Vec<u8> {
    let mut bytes = Vec::new();
    for signal in setup.channels.iter().flatten() {
        let bits = bits(*signal, &bench.rig.drive.result(actuals));
        bytes.extend_from_slice(&bits.to_le_bytes()[..signal.length() as usize / 8]);
    }
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// What is to be there, from all that was shown.
fn expected(setup: &Setup, bench: &Bench<'_>) -> Option<Read> {
    let level = |actuals: &Actuals| actuals.position_actual >= setup.trigger.level;
    let trigger = (1..bench.shown.len()).find(|tick| {
        let (was, is) = (level(&bench.shown[tick - 1]), level(&bench.shown[*tick]));
        match setup.trigger.edge {
            Edge::Rising => !was && is,
            Edge::Falling => was && !is,
            Edge::Either => was != is,
        }
    })?;
    let divider = usize::from(setup.divider);
    let sampled: Vec<usize> = (0..bench.shown.len()).step_by(divider).collect();
    let first_behind = trigger.div_ceil(divider);
    let capacity = usize::from(setup.capacity(WORDS as u32));
    let before = usize::from(setup.before).min(first_behind);
    let end = first_behind + capacity - usize::from(setup.before);
    let taken = sampled.get(first_behind - before..end)?;
    Some(Read {
        before,
        late: first_behind * divider - trigger,
        triggered: bench.shown[trigger].at.ticks(),
        samples: taken
            .iter()
            .map(|tick| packed(setup, bench, &bench.shown[*tick]))
            .collect(),
    })
}

fn any_setup() -> impl Strategy<Value = Setup> {
    let signals = prop::collection::vec(prop::sample::select(Signal::ALL), 1..=CHANNELS);
    let edge = prop::sample::select(&[Edge::Rising, Edge::Falling, Edge::Either][..]);
    (signals, 1..5_u16, 0..9_u16, 0..8_u16, edge, -3..4_i32).prop_map(
        |(signals, divider, samples, before, edge, level)| Setup {
            channels: channels(&signals),
            divider,
            samples,
            before,
            trigger: Trigger {
                signal: Some(Signal::PositionActualValue),
                edge,
                level,
                mask: 0,
            },
            is_repeated: false,
        },
    )
}

proptest! {
    #[test]
    fn a_recording_is_a_piece_of_what_was_published(
        setup in any_setup(),
        positions in prop::collection::vec(-5..6_i32, 1..120),
    ) {
        let memory = Memory::<[AtomicU32; WORDS]>::new();
        let mut bench = Bench::new(&memory);
        bench.arm(setup);
        for position in positions {
            bench.show(position);
        }
        if setup.check(WORDS as u32).is_err() {
            prop_assert_eq!(bench.read(), None);
        } else {
            prop_assert_eq!(bench.read(), expected(&setup, &bench));
        }
    }

    #[test]
    fn what_a_mapping_names_has_that_mapping(mapping in any::<u32>()) {
        prop_assert!(Signal::mapped(mapping).is_none_or(|signal| signal.mapping() == mapping));
    }
}

#[test]
fn every_value_is_found_by_its_mapping() {
    for signal in Signal::ALL {
        assert_eq!(Signal::mapped(signal.mapping()), Some(*signal));
        assert!(matches!(signal.length(), 8 | 16 | 32));
    }
    let homes: Vec<u32> = Signal::ALL.iter().map(|signal| signal.mapping()).collect();
    assert!(homes.is_sorted());
}

const POSITION: Setup = Setup {
    channels: [
        Some(Signal::PositionActualValue),
        None,
        None,
        None,
        None,
        None,
        None,
        None,
    ],
    samples: 4,
    before: 2,
    ..Setup::NONE
};

#[test]
fn an_order_is_a_trigger() {
    let memory = Memory::<[AtomicU32; WORDS]>::new();
    let mut bench = Bench::new(&memory);
    bench.arm(POSITION);
    for position in 0..10 {
        assert_eq!(bench.show(position), State::Armed);
    }
    bench.order(Orders {
        trigger: true,
        ..Orders::default()
    });
    assert_eq!(bench.show(10), State::Triggered);
    assert_eq!(bench.show(11), State::Full);
    let read = bench.read().unwrap();
    let positions: Vec<_> = read.samples.iter().map(|sample| sample[0]).collect();
    assert_eq!((read.before, positions), (2, [8, 9, 10, 11].into()));
    bench.show(12);
    assert_eq!(bench.read().unwrap(), read, "it is not overwritten");
}

#[test]
fn bits_are_a_trigger() {
    let memory = Memory::<[AtomicU32; WORDS]>::new();
    let mut bench = Bench::new(&memory);
    bench.arm(Setup {
        trigger: Trigger {
            signal: Some(Signal::DigitalInputs),
            edge: Edge::Falling,
            level: 99,
            mask: 0b0110,
        },
        ..POSITION
    });
    for (position, state) in [
        (0b0001, State::Armed),
        (0b0010, State::Armed),
        (0b0100, State::Armed),
        (0b1000, State::Triggered),
        (0b0000, State::Full),
    ] {
        assert_eq!(bench.show(position), state, "{position:04b}");
    }
}

#[test]
fn a_stop_ends_what_goes_on_and_keeps_what_is_there() {
    let memory = Memory::<[AtomicU32; WORDS]>::new();
    let mut bench = Bench::new(&memory);
    let stop = Orders {
        stop: true,
        ..Orders::default()
    };
    bench.arm(POSITION);
    bench.show(0);
    bench.order(stop);
    assert_eq!(bench.exchange.scope().state, State::Idle, "at once");
    assert_eq!(bench.show(1), State::Idle);
    assert_eq!(bench.read(), None);

    bench.arm(POSITION);
    bench.order(Orders {
        trigger: true,
        ..Orders::default()
    });
    bench.show(0);
    assert_eq!(bench.show(1), State::Full);
    bench.order(stop);
    assert_eq!(bench.show(2), State::Full);
    assert!(bench.read().is_some());
}

#[test]
fn a_recording_that_repeats_itself_waits_for_its_reader() {
    let memory = Memory::<[AtomicU32; WORDS]>::new();
    let mut bench = Bench::new(&memory);
    bench.arm(Setup {
        is_repeated: true,
        ..POSITION
    });
    bench.order(Orders {
        trigger: true,
        ..Orders::default()
    });
    for _ in 0..500 {
        bench.show(1);
    }
    assert_eq!(bench.show(1), State::Full, "nobody has read it");
    let run = bench.memory.whole().unwrap();
    bench.memory.read(run, true);
    for _ in 0..90 {
        assert_eq!(bench.show(2), State::Full);
    }
    bench.memory.read(run, false);
    for _ in 0..90 {
        assert_eq!(bench.show(3), State::Full, "a segment was asked for again");
    }
    for _ in 0..20 {
        bench.show(4);
    }
    assert_eq!(bench.show(5), State::Armed);
    assert_eq!(bench.memory.whole(), None);
}

#[test]
fn what_does_not_fit_is_refused() {
    assert_eq!(Setup::NONE.check(64), Err(AbortCode::DeviceState));
    assert_eq!(POSITION.check(3), Err(AbortCode::OutOfMemory));
    assert_eq!(POSITION.check(4), Ok(()));
    let late = Setup {
        before: 4,
        ..POSITION
    };
    assert_eq!(late.check(64), Err(AbortCode::ParameterIncompatible));
    let all = Setup {
        samples: 0,
        before: 63,
        ..POSITION
    };
    assert_eq!((all.check(64), all.capacity(64)), (Ok(()), 64));
    assert_eq!(all.check(0), Err(AbortCode::OutOfMemory));
}

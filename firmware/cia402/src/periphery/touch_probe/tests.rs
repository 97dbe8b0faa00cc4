//! The probes against a model that takes every edge by itself.

use proptest::prelude::*;

use super::*;
use crate::inputs::InputConfiguration;
use crate::inputs::probe_functions;
use crate::inputs::{self, Captured};

/// Probe 1 on input 5, probe 2 on input 6, index on input 4.
fn configuration() -> Configuration {
    Configuration {
        inputs: InputConfiguration {
            index: 1 << 3,
            touch_probes: [1 << 4, 1 << 5],
            ..InputConfiguration::NONE
        },
        ..Configuration::NONE
    }
}

const BOTH: u8 = 3 << 4;

/// Probes, a millisecond at a time. The master's count is 1,000 beyond the board's.
struct Bench {
    probes: TouchProbes,
    configuration: Configuration,
    commands: Commands,
    inputs: DigitalInputs,
    position: i64,
    now: Instant,
    seen: Latched,
}

impl Bench {
    fn new(function: u16) -> Self {
        let mut bench = Self {
            probes: TouchProbes::new(),
            configuration: configuration(),
            commands: Commands {
                touch_probe_function: function,
                ..Commands::NONE
            },
            inputs: DigitalInputs::NONE,
            position: 0,
            now: Instant::from_ticks(0),
            seen: Latched::NONE,
        };
        bench.tick();
        bench
    }

    /// An edge of an input (4 to 6) where the board counts `position`, at a nanosecond.
    fn edge(&mut self, input: usize, rises: bool, position: i32, time: u32) {
        let edge = Edge { position, time };
        let captured = &mut self.inputs.captured[input - 1];
        let edges = if rises {
            &mut captured.rose
        } else {
            &mut captured.fell
        };
        match edges {
            Some(edges) => edges.add(edge),
            None => *edges = Some(Edges::one(edge)),
        }
        let bit = 1 << (input - 1);
        self.inputs.changed |= bit;
        self.inputs.levels = self.inputs.levels & !bit | if rises { bit } else { 0 };
    }

    /// The input rises and falls again.
    fn pulse(&mut self, input: usize, up: i32, down: i32) {
        self.edge(input, true, up, up.cast_unsigned());
        self.edge(input, false, down, down.cast_unsigned());
    }

    fn tick(&mut self) -> Latched {
        self.now += canopen::Duration::from_ticks(1_000);
        let count = Count {
            position: self.position,
            shift: 1_000,
            is_reversed: false,
        };
        self.probes.observe(
            self.now,
            &self.inputs,
            &self.commands,
            &self.configuration,
            count,
        );
        self.commands.touch_probes_off = 0;
        self.inputs.changed = 0;
        self.inputs.captured = [Captured::default(); inputs::COUNT];
        if let Some(latched) = self.probes.take_news(|position| position as i32) {
            self.seen = latched;
        }
        self.seen
    }

    /// The master writes 60B8h.
    fn write(&mut self, function: u16) {
        self.commands.touch_probe_function = function;
        self.commands.touch_probes_off |= !function;
    }
}

#[test]
fn m70_the_first_edge_of_each_kind_is_kept() {
    let mut bench = Bench::new(u16::from(ENABLE | BOTH));
    assert_eq!(bench.seen.status, 0x0001);
    bench.pulse(5, 10, 20);
    bench.pulse(5, 30, 40);
    let latched = bench.tick();
    assert_eq!(latched.status, 0x0007);
    assert_eq!(latched.positions, [1_010, 1_020, 0, 0]);
    assert_eq!(latched.times, [10, 20, 0, 0]);
    assert_eq!(latched.counters, [2, 2, 0, 0]);
    bench.pulse(5, 50, 60);
    let latched = bench.tick();
    assert_eq!(latched.positions, [1_010, 1_020, 0, 0]);
    assert_eq!(latched.counters, [3, 3, 0, 0], "counted all the same");
}

#[test]
fn m70_continuous_sampling_keeps_the_last_edge() {
    let mut bench = Bench::new(u16::from(ENABLE | CONTINUOUS | BOTH) << 8);
    assert_eq!(bench.seen.status, 0x0100);
    bench.pulse(6, 10, 20);
    bench.pulse(6, 30, 40);
    let latched = bench.tick();
    assert_eq!(latched.status, 0x0700);
    assert_eq!(latched.positions, [0, 0, 1_030, 1_040]);
    bench.pulse(6, 50, 60);
    assert_eq!(bench.tick().positions, [0, 0, 1_050, 1_060]);
}

#[test]
fn m70_only_the_edges_that_are_sampled_count() {
    for (bits, status, positions) in [
        (POSITIVE, 0x0003, [1_010, 0, 0, 0]),
        (POSITIVE << 1, 0x0005, [0, 1_020, 0, 0]),
        (0, 0x0001, [0, 0, 0, 0]),
    ] {
        let mut bench = Bench::new(u16::from(ENABLE | bits));
        bench.pulse(5, 10, 20);
        let latched = bench.tick();
        assert_eq!((latched.status, latched.positions), (status, positions));
    }
}

#[test]
fn m70_the_source_may_be_the_index_or_what_60d0h_says() {
    let mut bench = Bench::new(u16::from(ENABLE | SOURCE_INDEX | POSITIVE));
    bench.pulse(5, 1, 2);
    bench.pulse(4, 10, 20);
    assert_eq!(bench.tick().positions[0], 1_010);
    for (source, input) in [
        (Source::Probe2, 6),
        (Source::Index, 4),
        (Source::Input(1 << 2), 3),
    ] {
        let mut bench = Bench::new(0);
        bench.configuration.touch_probe_sources[0] = source;
        bench.write(u16::from(ENABLE | SOURCE_SELECTED | POSITIVE));
        bench.tick();
        bench.pulse(5, 1, 2);
        bench.pulse(input, 10, 20);
        assert_eq!(bench.tick().positions[0], 1_010, "{source:?}");
    }
}

#[test]
fn m70_an_inverted_input_rises_where_its_level_falls() {
    let mut bench = Bench::new(0);
    bench.configuration.inputs.inverted = 1 << 4;
    bench.write(u16::from(ENABLE | POSITIVE));
    bench.tick();
    bench.pulse(5, 10, 20);
    let latched = bench.tick();
    assert_eq!((latched.status, latched.positions[0]), (0x0003, 1_020));
}

#[test]
fn m70_another_2032h_is_no_edge_and_starts_the_probe_anew() {
    let mut bench = Bench::new(u16::from(ENABLE | BOTH));
    bench.configuration.inputs.inverted = 1 << 4;
    let latched = bench.tick();
    assert_eq!((latched.status, latched.counters[0]), (0x0001, 0));
    bench.edge(5, false, 10, 10);
    assert_eq!(bench.tick().status, 0x0003, "low is active");
    bench.configuration.inputs.inverted = 1 << 4 | 1;
    assert_eq!(bench.tick().status, 0x0003, "an input of others");
    bench.configuration.inputs.inverted = 0;
    let latched = bench.tick();
    assert_eq!((latched.status, latched.counters), (0x0001, [1, 0, 0, 0]));
}

#[test]
fn m70_switched_off_and_on_a_probe_starts_anew() {
    let function = u16::from(ENABLE | POSITIVE);
    let mut bench = Bench::new(function);
    bench.pulse(5, 10, 20);
    assert_eq!(bench.tick().status, 0x0003);
    bench.write(0);
    assert_eq!(bench.tick().status, 0);
    bench.pulse(5, 30, 40);
    bench.tick();
    bench.write(function);
    let latched = bench.tick();
    assert_eq!((latched.status, latched.positions[0]), (0x0001, 1_010));
    bench.pulse(5, 50, 60);
    let latched = bench.tick();
    assert_eq!((latched.status, latched.positions[0]), (0x0003, 1_050));
    // Both between two ticks.
    bench.write(0);
    bench.write(function);
    assert_eq!(bench.tick().status, 0x0001);
    // The same value again is nothing new.
    bench.pulse(5, 70, 80);
    bench.tick();
    bench.write(function);
    assert_eq!(bench.tick().status, 0x0003);
}

#[test]
fn m70_an_edge_from_before_the_probe_was_on_does_not_count() {
    let mut bench = Bench::new(0);
    bench.write(u16::from(ENABLE | POSITIVE));
    bench.pulse(5, 10, 20);
    let latched = bench.tick();
    assert_eq!((latched.status, latched.counters[0]), (0x0001, 0));
    bench.pulse(5, 30, 40);
    assert_eq!(bench.tick().positions[0], 1_030);
}

#[test]
fn m70_one_edge_can_be_sampled_anew_alone() {
    let mut bench = Bench::new(u16::from(ENABLE | BOTH));
    bench.pulse(5, 10, 20);
    assert_eq!(bench.tick().status, 0x0007);
    bench.write(u16::from(ENABLE | POSITIVE << 1));
    assert_eq!(bench.tick().status, 0x0005);
    bench.write(u16::from(ENABLE | BOTH));
    bench.tick();
    bench.pulse(5, 30, 40);
    let latched = bench.tick();
    assert_eq!(latched.positions, [1_030, 1_020, 0, 0]);
}

#[test]
fn a_source_without_an_input_leaves_the_probe_off() {
    let mut bench = Bench::new(0);
    bench.configuration.inputs.touch_probes[0] = 0;
    bench.write(u16::from(ENABLE | POSITIVE));
    assert_eq!(bench.tick().status, 0);
    bench.configuration.inputs.touch_probes[0] = 1 << 4;
    assert_eq!(bench.tick().status, 0x0001, "it has got one");
}

#[test]
fn an_edge_that_was_not_captured_counts_where_the_motor_is() {
    let mut bench = Bench::new(u16::from(ENABLE | BOTH));
    bench.position = -77;
    bench.inputs.levels = 1 << 4;
    let latched = bench.tick();
    assert_eq!((latched.status, latched.positions[0]), (0x0003, -77));
    assert_eq!(u64::from(latched.times[0]), bench.now.ticks() * 1_000);
}

#[test]
fn of_two_inputs_of_a_probe_the_edges_are_in_the_order_of_time() {
    // The tick is at 3 ms; an edge may come while it measures.
    for (first, second) in [(1_000_010, 1_000_030), (2_999_990, 3_000_010)] {
        let mut bench = Bench::new(0);
        bench.configuration.inputs.touch_probes[0] = 0b1_1000;
        bench.write(u16::from(ENABLE | POSITIVE));
        bench.tick();
        bench.edge(4, true, 30, second);
        bench.edge(5, true, 10, first);
        let latched = bench.tick();
        assert_eq!((latched.positions[0], latched.counters[0]), (1_010, 2));
    }
}

#[test]
fn reserved_sources_are_no_function() {
    for function in [0x0000, 0x0031, 0xC0F3, 0x3BFB] {
        assert!(probe_functions(function).is_some(), "{function:04X}");
    }
    for function in [0x000C, 0x0C00, 0x0D31] {
        assert!(probe_functions(function).is_none(), "{function:04X}");
    }
    for code in [0, 3, 4, 6, -7, i16::MIN] {
        assert_eq!(Source::from_code(code), None);
    }
    assert_eq!(Source::from_code(-6), Some(Source::Input(1 << 5)));
}

/// A probe that takes each edge by itself.
#[derive(Default)]
struct Model {
    stored: [bool; 2],
    positions: [i32; 2],
    counters: [u16; 2],
}

proptest! {
    #[test]
    fn m70_whatever_happens_a_latched_position_is_that_of_its_edge(
        ticks in prop::collection::vec(
            (prop::option::weighted(0.2, 0u8..16), prop::collection::vec(any::<i32>(), 0..5)),
            1..100,
        ),
    ) {
        let mut bench = Bench::new(0);
        let mut model = Model::default();
        let (mut level, mut function) = (false, 0);
        for (write, edges) in ticks {
            for position in edges {
                level = !level;
                bench.edge(5, level, position, 0);
                let kind = usize::from(!level);
                if function & ENABLE != 0 && function & POSITIVE << kind != 0 {
                    model.counters[kind] += 1;
                    if function & CONTINUOUS != 0 || !model.stored[kind] {
                        model.stored[kind] = true;
                        model.positions[kind] = position.wrapping_add(1_000);
                    }
                }
            }
            if let Some(bits) = write {
                let new = bits & 3 | (bits >> 2) << 4;
                let anew = new & ENABLE == 0 || function & ENABLE == 0;
                for (kind, stored) in model.stored.iter_mut().enumerate() {
                    *stored &= !anew && new & POSITIVE << kind != 0;
                }
                function = new;
                bench.write(new.into());
            }
            let latched = bench.tick();
            prop_assert_eq!(&latched.positions[..2], model.positions);
            prop_assert_eq!(&latched.counters[..2], model.counters);
            let stored = [latched.status & 2 != 0, latched.status & 4 != 0];
            prop_assert_eq!(stored, model.stored);
        }
    }
}

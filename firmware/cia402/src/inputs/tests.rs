//! The filter of the inputs.

use super::*;

const HOME: InputConfiguration = InputConfiguration {
    home: 0b0100,
    index: 0b1000,
    debounce: 3,
    ..InputConfiguration::NONE
};

/// The filter, a millisecond at a time.
#[derive(Default)]
struct Bench {
    switches: Switches,
    configuration: Option<InputConfiguration>,
    position: i32,
}

impl Bench {
    /// The master's count is 1,000 beyond the board's.
    fn count(&self) -> Count {
        Count {
            position: self.position.into(),
            shift: 1_000,
            is_reversed: false,
        }
    }

    /// A tick with input 3 at this level, and what was captured of it.
    fn see(&mut self, level: bool, rose: Option<i32>, fell: Option<i32>) -> SwitchState {
        let mut inputs = DigitalInputs {
            levels: u8::from(level) << 2,
            changed: u8::from(rose.is_some() || fell.is_some()) << 2,
            ..DigitalInputs::NONE
        };
        let one = |position| Edges::one(Edge { position, time: 0 });
        inputs.captured[2] = Captured {
            rose: rose.map(one),
            fell: fell.map(one),
        };
        let configuration = self.configuration.unwrap_or(HOME);
        self.switches
            .observe(&inputs, &configuration, self.count(), 1_000);
        self.position += 10;
        SwitchState {
            pending: None,
            ..self.switches.home.state
        }
    }
}

/// The master counts as the board does.
fn at(position: i64) -> Count {
    Count {
        position,
        ..Count::default()
    }
}

const INACTIVE: SwitchState = SwitchState {
    active: false,
    edge: None,
    pending: None,
};

const ACTIVE: SwitchState = SwitchState {
    active: true,
    edge: None,
    pending: None,
};

#[test]
fn m61_a_change_counts_after_the_debounce_time_and_where_it_was_captured() {
    let mut bench = Bench::default();
    assert_eq!(bench.see(false, None, None), INACTIVE);
    // 1,007 is 7 of the board's count.
    assert_eq!(bench.see(true, Some(7), None), INACTIVE);
    assert_eq!(bench.see(true, None, None), INACTIVE);
    assert_eq!(bench.see(true, None, None), INACTIVE);
    let edge = Some(1_007);
    assert_eq!(bench.see(true, None, None), SwitchState { edge, ..ACTIVE });
    assert_eq!(bench.see(true, None, None), ACTIVE);
}

#[test]
fn m61_an_edge_is_pending_until_it_counts_or_is_dropped() {
    let mut bench = Bench::default();
    let pending = |bench: &Bench| bench.switches.home.state.pending;
    bench.see(true, Some(7), None);
    assert_eq!(pending(&bench), Some(1_007));
    bench.see(true, None, None);
    bench.see(true, None, None);
    assert_eq!(pending(&bench), Some(1_007));
    assert_eq!(bench.see(true, None, None).edge, Some(1_007));
    assert_eq!(pending(&bench), None);
    // A glitch is one as long as it may still be bouncing.
    bench.see(false, None, Some(20));
    bench.see(true, Some(21), None);
    assert_eq!(pending(&bench), Some(1_020));
    for _ in 0..3 {
        bench.see(true, None, None);
    }
    assert_eq!(pending(&bench), None);
}

#[test]
fn m61_a_contact_that_never_rests_keeps_no_edge_pending_for_ever() {
    for debounce in [0, 3, 20, 255] {
        for protects in [false, true] {
            let mask = 0b0100;
            let mut bench = Bench {
                configuration: Some(InputConfiguration {
                    home: if protects { 0 } else { mask },
                    positive_limit: if protects { mask } else { 0 },
                    debounce,
                    ..InputConfiguration::NONE
                }),
                ..Bench::default()
            };
            let mut longest = 0;
            let mut since = 0;
            for tick in 0..5_000 {
                bench.see(tick % 2 == 0, Some(1), Some(2));
                let Switches {
                    home,
                    positive_limit,
                    ..
                } = &bench.switches;
                let switch = if protects { positive_limit } else { home };
                since = if switch.state.pending.is_some() {
                    since + 1
                } else {
                    0
                };
                longest = longest.max(since);
            }
            let bound = 5 * i32::from(debounce) + 5;
            assert!(longest <= bound, "{debounce}, {protects}: {longest} ms");
        }
    }
}

#[test]
fn m61_a_glitch_of_a_tick_is_no_change() {
    let mut bench = Bench::default();
    for _ in 0..50 {
        assert_eq!(bench.see(true, Some(1), None), INACTIVE);
        assert_eq!(bench.see(false, None, Some(2)), INACTIVE);
        assert_eq!(bench.see(false, None, None), INACTIVE);
    }
    // When it has been quiet, the next real edge is not that of a glitch.
    for _ in 0..3 {
        assert_eq!(bench.see(false, None, None), INACTIVE);
    }
    assert_eq!(bench.see(true, Some(500), None), INACTIVE);
    for _ in 0..2 {
        assert_eq!(bench.see(true, None, None), INACTIVE);
    }
    assert_eq!(bench.see(true, None, None).edge, Some(1_500));
}

#[test]
fn m61_the_first_edge_of_a_bouncing_contact_counts() {
    let mut bench = Bench::default();
    // The bouncing begins between two ticks.
    assert_eq!(bench.see(false, Some(100), Some(100)), INACTIVE);
    assert_eq!(bench.see(true, Some(101), None), INACTIVE);
    assert_eq!(bench.see(true, Some(102), Some(102)), INACTIVE);
    assert_eq!(bench.see(false, None, Some(103)), INACTIVE);
    for _ in 0..8 {
        if bench.see(true, Some(104), None).active {
            break;
        }
    }
    assert_eq!(bench.switches.home.state.edge, Some(1_100));
}

#[test]
fn m61_noise_that_never_ends_does_not_keep_an_old_edge() {
    let mut bench = Bench::default();
    let mut edge = None;
    for count in 0..1_010 {
        let level = count % 2 == 0 || count >= 1_000;
        edge = edge.or(bench.see(level, level.then_some(count), None).edge);
    }
    assert!((1_980..2_010).contains(&edge.unwrap()), "{edge:?}");
}

/// A limit switch that is active in `active` of `of` ticks, in turn `active` and not, `long` ticks at a time; debounced for 3 ms.
fn chattering(active: i32, of: i32, long: i32) -> impl Iterator<Item = bool> {
    const LIMIT: InputConfiguration = InputConfiguration {
        positive_limit: 0b0100,
        debounce: 3,
        ..InputConfiguration::NONE
    };
    let mut bench = Bench {
        configuration: Some(LIMIT),
        ..Bench::default()
    };
    (0..1_000).map(move |tick| {
        let level = tick / long * active % of < active;
        bench.see(level, None, None);
        bench.switches.active_limits().forward
    })
}

#[test]
fn m61_a_limit_switch_that_is_active_for_half_of_the_time_bars_within_four_debounce_times() {
    for (active, of) in [(1, 2), (5, 9), (3, 5), (2, 3), (9, 10)] {
        for long in 1..=3 {
            let mut bars = chattering(active, of, long);
            // It may begin inactive, and there is the tick that sees it first.
            let ticks = bars.position(|bars| bars).unwrap();
            assert!(ticks <= 12 + 4, "{active}/{of}, {long}: {ticks} ms");
            assert!(
                bars.all(|bars| bars),
                "{active}/{of}, {long}: it is free again"
            );
        }
    }
}

#[test]
fn m61_glitches_of_a_limit_switch_do_not_add_up() {
    assert!(chattering(1, 3, 1).all(|bars| !bars));
    assert!(chattering(1, 4, 2).all(|bars| !bars));
}

#[test]
fn m61_a_home_switch_that_is_active_most_of_the_time_counts() {
    let mut bench = Bench {
        configuration: Some(InputConfiguration {
            debounce: 20,
            ..HOME
        }),
        ..Bench::default()
    };
    let mut counts = (0..1_000).map(|tick| bench.see(tick % 5 < 3, None, None).active);
    // A fifth of the time is left.
    let ticks = counts.position(|active| active).unwrap();
    assert!((80..=110).contains(&ticks), "{ticks}");
}

#[test]
fn m61_a_limit_switch_is_left_where_its_contact_first_opened() {
    let mut bench = Bench {
        configuration: Some(InputConfiguration {
            positive_limit: 0b0100,
            debounce: 3,
            ..InputConfiguration::NONE
        }),
        ..Bench::default()
    };
    for _ in 0..10 {
        bench.see(true, None, None);
    }
    bench.see(false, None, Some(500));
    bench.see(true, Some(510), None);
    bench.see(false, None, Some(520));
    let mut ticks = 0;
    while bench.switches.positive_limit.state.active {
        bench.see(false, None, None);
        ticks += 1;
    }
    assert_eq!(ticks, 3);
    assert_eq!(bench.switches.positive_limit.state.edge, Some(1_500));
}

#[test]
fn an_edge_that_was_not_captured_is_where_the_motor_was() {
    let mut bench = Bench {
        configuration: Some(InputConfiguration {
            debounce: 0,
            ..HOME
        }),
        ..Bench::default()
    };
    bench.see(false, None, None);
    assert_eq!(bench.see(true, None, None).edge, Some(10));
    assert_eq!(
        bench.see(false, None, None),
        SwitchState {
            edge: Some(20),
            ..INACTIVE
        }
    );
}

#[test]
fn an_inverted_input_is_active_while_it_is_low() {
    let mut bench = Bench {
        configuration: Some(InputConfiguration {
            inverted: 0b0100,
            debounce: 0,
            ..HOME
        }),
        ..Bench::default()
    };
    assert!(bench.see(false, None, None).active);
    assert_eq!(bench.switches.word(), 0b100);
    assert_eq!(
        bench.see(true, Some(4), None),
        SwitchState {
            edge: Some(1_004),
            ..INACTIVE
        }
    );
    assert_eq!(bench.switches.word(), 0b100 << 16, "levels are shown bare");
    assert_eq!(bench.see(false, None, Some(6)).edge, Some(1_006));
}

#[test]
fn index_pulses_are_not_debounced() {
    let mut switches = Switches::default();
    let mut inputs = DigitalInputs {
        changed: 0b1000,
        ..DigitalInputs::NONE
    };
    inputs.captured[3].rose = Some(Edges::one(Edge {
        position: -5,
        time: 0,
    }));
    switches.observe(&inputs, &HOME, Count::default(), 1_000);
    assert_eq!(switches.index, Some(-5));
    switches.observe(&DigitalInputs::NONE, &HOME, Count::default(), 1_000);
    assert_eq!(switches.index, None);
    // Without a capture, the tick in which it rises.
    let high = DigitalInputs {
        levels: 0b1000,
        ..DigitalInputs::NONE
    };
    switches.observe(&high, &HOME, at(77), 1_000);
    assert_eq!(switches.index, Some(77));
    switches.observe(&high, &HOME, at(78), 1_000);
    assert_eq!(switches.index, None);
}

#[test]
fn another_2032h_is_no_index_pulse() {
    let mut switches = Switches::default();
    let inverted = InputConfiguration {
        inverted: 0b1000,
        ..HOME
    };
    switches.observe(&DigitalInputs::NONE, &HOME, at(70), 1_000);
    switches.observe(&DigitalInputs::NONE, &inverted, at(77), 1_000);
    assert_eq!(switches.index, None);
}

#[test]
fn functions_become_masks() {
    let configuration = InputConfiguration::new([3, 1, 2, 4, 3, 9], 0x15, 7);
    assert_eq!(
        configuration,
        InputConfiguration {
            negative_limit: 0b00_0010,
            positive_limit: 0b00_0100,
            home: 0b01_0001,
            index: 0b00_1000,
            touch_probes: [0; 2],
            inverted: 0x15,
            debounce: 7,
        }
    );
}

#[test]
fn touch_probes_are_functions_of_inputs() {
    let configuration = InputConfiguration::new([0, 6, 5, 5, 0, 0], 0, 0);
    assert_eq!(configuration.touch_probes, [0b00_1100, 0b00_0010]);
}

#[test]
fn a_count_is_the_nearest_to_where_the_motor_is() {
    let far = Count {
        position: (5 << 32) + 7,
        shift: 3,
        is_reversed: false,
    };
    assert_eq!(far.board_position(), 4);
    assert_eq!(far.of(4), (5 << 32) + 7);
    assert_eq!(far.of(-10), (5 << 32) - 7);
    let reversed = Count {
        is_reversed: true,
        ..far
    };
    assert_eq!(reversed.board_position(), -4);
    assert_eq!(reversed.of(-14), (5 << 32) + 17);
}

#[test]
fn m61_a_limit_switch_that_touches_between_two_ticks_is_not_left() {
    let mut bench = Bench {
        configuration: Some(InputConfiguration {
            positive_limit: 0b0100,
            debounce: 3,
            ..InputConfiguration::NONE
        }),
        ..Bench::default()
    };
    for _ in 0..5 {
        bench.see(true, None, None);
    }
    assert!(bench.switches.active_limits().forward);
    // Every tick finds it open, but it closes for a moment in between.
    for tick in 0..20 {
        bench.see(false, Some(tick), Some(tick));
        assert!(bench.switches.active_limits().forward);
    }
    // The break counts from the last touch.
    for _ in 0..2 {
        bench.see(false, None, None);
        assert!(bench.switches.active_limits().forward);
    }
    bench.see(false, None, None);
    assert!(!bench.switches.active_limits().forward);
    let edge = bench.switches.positive_limit.state.edge.unwrap();
    assert!((1_006..1_020).contains(&edge), "{edge}");
}

use canopen::{Duration, Instant};
use cia402::inputs::Edges;
use motion::Direction::{Forward, Reverse};
use motion::{Direction, PulseSink, Record};
use proptest::prelude::*;

use super::*;

fn record(period: u32, repeat: u16, width: u16, direction: Direction) -> Record {
    Record {
        period,
        repeat,
        width,
        direction,
    }
}

#[test]
fn each_pulse_is_a_step_and_silence_is_none() {
    let mut plant = Plant::new(Instant::from_ticks(0));
    let pulses = plant.pulses_mut();
    pulses.push(record(840, 5, 100, Forward)).unwrap();
    pulses.push(record(8_400, 1, 0, Reverse)).unwrap();
    pulses.push(record(840, 2, 100, Reverse)).unwrap();
    assert_eq!(pulses.pending(), 5 * 840 + 8_400 + 2 * 840);
    let positions: Vec<i64> = (0..=180)
        .step_by(10)
        .map(|microseconds| {
            plant.advance(Instant::from_ticks(microseconds));
            plant.position()
        })
        .collect();
    assert_eq!(
        positions,
        [0, 1, 2, 3, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 4, 3, 3]
    );
    assert_eq!(plant.pulses().pending(), 0);
}

#[test]
fn a_pulse_counts_when_it_begins() {
    let mut player = PulsePlayer::default();
    player.push(record(1000, 2, 10, Forward)).unwrap();
    player.play(1, |_| {});
    assert_eq!(player.position(), 1);
    player.play(999, |_| {});
    assert_eq!(player.position(), 1);
    player.play(1, |_| {});
    assert_eq!(player.position(), 2);
    player.drop_all();
    player.play(5000, |_| {});
    assert_eq!((player.position(), player.pending()), (2, 0));
}

#[test]
fn a_full_queue_gives_the_record_back() {
    let mut player = PulsePlayer::default();
    let one = record(10, 1, 1, Forward);
    for _ in 0..motion::step_interrupt::CAPACITY {
        player.push(one).unwrap();
    }
    assert_eq!(player.push(one), Err(one));
}

/// Counts and switches after each of these moves, at 1 MHz.
fn run(plant: &mut Plant, moves: &[(Direction, u16)]) -> Vec<(i64, bool, bool, bool)> {
    let mut now = plant.now.ticks();
    moves
        .iter()
        .map(|(direction, pulses)| {
            plant
                .pulses_mut()
                .push(record(84, *pulses, 10, *direction))
                .unwrap();
            now += u64::from(*pulses) + 1;
            plant.advance(Instant::from_ticks(now));
            let state = plant.switch_states();
            (
                plant.position(),
                state.negative_limit,
                state.home,
                state.positive_limit,
            )
        })
        .collect()
}

fn on_axis(axis: &Axis) -> Plant {
    let mut plant = Plant::new(Instant::from_ticks(0));
    plant.mount(axis);
    plant.power_on(Instant::from_ticks(0));
    plant
}

#[test]
fn the_motor_runs_into_its_switches_and_out_again() {
    let mut plant = on_axis(&Axis {
        track: Track {
            negative_limit: Some(Switch::up_to(-3)),
            positive_limit: Some(Switch::from(3)),
            home: Some(Switch::within(0..=1)),
            ..Track::default()
        },
        ..Axis::default()
    });
    assert_eq!(
        run(
            &mut plant,
            &[(Forward, 1), (Forward, 2), (Reverse, 1), (Reverse, 5)]
        ),
        [
            (1, false, true, false),
            (3, false, false, true),
            (2, false, false, false),
            (-3, true, false, false),
        ]
    );
    plant.displace(3);
    assert!(plant.switch_states().home, "turned by hand");
}

/// First, last and number of the edges of one kind.
type Passed = Option<(i32, i32, u16)>;

/// The level, the rising and the falling edges.
fn seen(wire: Sensed) -> (bool, Passed, Passed) {
    let passed = |edges: Edges| (edges.first.position, edges.last.position, edges.count);
    (wire.level, wire.rose.map(passed), wire.fell.map(passed))
}

#[test]
fn edges_are_caught_at_their_step_with_hysteresis() {
    let mut plant = on_axis(&Axis {
        track: Track {
            home: Some(Switch::within(100..=200).with_hysteresis(10)),
            ..Track::default()
        },
        ..Axis::default()
    });
    run(&mut plant, &[(Forward, 150)]);
    let [_, _, home, ..] = plant.look();
    assert_eq!(seen(home), (true, Some((110, 110, 1)), None));
    run(&mut plant, &[(Forward, 150), (Reverse, 250)]);
    let [_, _, home, ..] = plant.look();
    assert_eq!(
        seen(home),
        (false, Some((190, 190, 1)), Some((211, 89, 2))),
        "first and last edge of each kind"
    );
    // A step each microsecond, and a microsecond of rest after each move: 302 microseconds until the way back begins.
    let fell = home.fell.unwrap();
    let times = [fell.first.time, fell.last.time];
    assert_eq!(times.map(|time| time / 1_000), [211, 302 + 300 - 90]);
    let [_, _, home, ..] = plant.look();
    assert_eq!(home, Sensed::default(), "edges are told once");
}

#[test]
fn a_normally_closed_switch_is_low_where_it_is_active() {
    let mut plant = on_axis(&Axis {
        track: Track {
            negative_limit: Some(Switch::up_to(-5).normally_closed()),
            ..Track::default()
        },
        ..Axis::default()
    });
    assert!(plant.look()[0].level);
    run(&mut plant, &[(Reverse, 8)]);
    assert_eq!(seen(plant.look()[0]), (false, None, Some((-5, -5, 1))));
}

#[test]
fn a_contact_bounces_for_its_time_and_as_its_seed_says() {
    let edges = |seed| {
        let mut plant = on_axis(&Axis {
            seed,
            track: Track {
                positive_limit: Some(Switch::from(5).bouncing(Duration::from_ticks(900))),
                ..Track::default()
            },
            ..Axis::default()
        });
        run(&mut plant, &[(Forward, 8)]);
        plant.advance(Instant::from_ticks(1_000));
        let [_, limit, ..] = plant.look();
        plant.advance(Instant::from_ticks(100_000));
        let [_, later, ..] = plant.look();
        assert_eq!((later.level, later.rose, later.fell), (true, None, None));
        (limit.rose.unwrap(), limit.fell.unwrap())
    };
    for seed in 0..100 {
        let (rose, fell) = edges(seed);
        assert_eq!((rose.first.position, rose.first.time / 1_000), (5, 4));
        assert_eq!(rose.count, fell.count + 1, "it ends as it began");
        assert!(fell.count >= 1 && rose.last.time <= 904_001);
        assert!(fell.last.time < rose.last.time && fell.first.time > rose.first.time);
    }
    assert_eq!(edges(7), edges(7));
    assert_ne!(edges(7), edges(8));
}

#[test]
fn index_pulses_lie_a_turn_apart_on_both_sides() {
    let mut plant = on_axis(&Axis {
        track: Track {
            index: Some(Index::new(400, 3_200)),
            ..Track::default()
        },
        start: 390,
        ..Axis::default()
    });
    run(&mut plant, &[(Forward, 20)]);
    let [_, _, _, index, ..] = plant.look();
    let expected = (false, Some((10, 10, 1)), Some((11, 11, 1)));
    assert_eq!(seen(index), expected);
    run(&mut plant, &[(Reverse, 3_250)]);
    let [_, _, _, index, ..] = plant.look();
    assert_eq!(seen(index).1, Some((10, 10 - 3_200, 2)), "two");
    run(&mut plant, &[(Reverse, 3_200)]);
    let [_, _, _, index, ..] = plant.look();
    let third = 10 - 2 * 3_200;
    assert_eq!(seen(index).1, Some((third, third, 1)));
}

#[test]
fn an_index_pulse_may_be_wide() {
    let mut plant = on_axis(&Axis {
        track: Track {
            index: Some(Index {
                width: 4,
                ..Index::new(400, 3_200)
            }),
            ..Track::default()
        },
        start: 390,
        ..Axis::default()
    });
    run(&mut plant, &[(Forward, 20)]);
    let [_, _, _, index, ..] = plant.look();
    let expected = (false, Some((10, 10, 1)), Some((14, 14, 1)));
    assert_eq!(seen(index), expected);
}

/// A motor that plays so many pulses, looked at each time so many microseconds have gone by.
fn turned(cuts: &[u64]) -> (i64, i64, u64) {
    let mut plant = on_axis(&Axis {
        motor: Some(MotorData::default()),
        encoder: true,
        ..Axis::default()
    });
    plant.energise(true);
    plant
        .pulses_mut()
        .push(record(1_000, 5_000, 100, Forward))
        .unwrap();
    let mut now = 0;
    for cut in cuts.iter().cycle() {
        now = (now + cut).min(60_000);
        plant.advance(Instant::from_ticks(now));
        if now == 60_000 {
            break;
        }
    }
    (plant.rotor(), plant.position(), now)
}

#[test]
fn however_often_it_is_looked_at_a_motor_does_the_same() {
    let expected = turned(&[1_000]);
    for cuts in [&[1][..], &[7, 300, 19], &[60_000], &[999, 2]] {
        assert_eq!(turned(cuts), expected);
    }
}

#[test]
fn behind_an_end_stop_pulses_are_lost() {
    let mut axis = Axis {
        track: Track {
            stops: Some(-10..=10),
            ..Track::default()
        },
        ..Axis::default()
    };
    let mut plant = on_axis(&axis);
    run(&mut plant, &[(Forward, 15), (Reverse, 4)]);
    assert_eq!((plant.rotor(), plant.position()), (6, 11));
    assert!(plant.take_blocked() && !plant.take_blocked());
    axis.encoder = true;
    let mut plant = on_axis(&axis);
    run(&mut plant, &[(Forward, 15), (Reverse, 4)]);
    assert_eq!((plant.rotor(), plant.position()), (6, 6));
}

#[test]
fn on_a_round_axis_a_switch_comes_again_each_turn() {
    let mut plant = on_axis(&Axis {
        track: Track {
            home: Some(Switch::within(0..=9)),
            turn: Some(100),
            ..Track::default()
        },
        start: 50,
        ..Axis::default()
    });
    let home = |plant: &Plant| plant.switch_states().home;
    run(&mut plant, &[(Reverse, 45)]);
    assert!(home(&plant));
    run(&mut plant, &[(Forward, 50)]);
    assert!(!home(&plant));
    run(&mut plant, &[(Forward, 50)]);
    assert!(home(&plant));
}

proptest! {
    #[test]
    fn however_time_is_cut_every_pulse_is_counted_once(
        records in prop::collection::vec((1u32..2000, 1u16..50, 0u16..2, any::<bool>()), 1..60),
        cuts in prop::collection::vec(0u64..50_000, 0..100),
    ) {
        let mut player = PulsePlayer::default();
        player.record();
        let mut expected = 0;
        let mut ends = 0;
        let mut times = Vec::new();
        for (period, repeat, width, forward) in records {
            let direction = if forward { Forward } else { Reverse };
            player.push(record(period, repeat, width, direction)).unwrap();
            let starts = (0..repeat).map(|n| ends + u64::from(n) * u64::from(period));
            times.extend(starts.filter(|_| width > 0));
            ends += u64::from(repeat) * u64::from(period);
            if width > 0 {
                expected += i64::from(repeat) * if forward { 1 } else { -1 };
            }
        }
        for cut in cuts {
            let before = player.pending();
            player.play(cut, |_| {});
            prop_assert_eq!(player.pending(), before.saturating_sub(cut));
        }
        player.play(player.pending(), |_| {});
        prop_assert_eq!(player.position(), expected);
        prop_assert_eq!(player.recorded(), times);
        prop_assert_eq!(player.free(), PulsePlayer::default().free());
    }
}

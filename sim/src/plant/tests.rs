use canopen::Instant;
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
    pulses
        .push(record(840, 5, 100, Direction::Forward))
        .unwrap();
    pulses
        .push(record(8_400, 1, 0, Direction::Reverse))
        .unwrap();
    pulses
        .push(record(840, 2, 100, Direction::Reverse))
        .unwrap();
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
    player
        .push(record(1000, 2, 10, Direction::Forward))
        .unwrap();
    player.play(1);
    assert_eq!(player.position(), 1);
    player.play(999);
    assert_eq!(player.position(), 1);
    player.play(1);
    assert_eq!(player.position(), 2);
    player.drop_all();
    player.play(5000);
    assert_eq!((player.position(), player.pending()), (2, 0));
}

#[test]
fn a_full_queue_gives_the_record_back() {
    let mut player = PulsePlayer::default();
    let one = record(10, 1, 1, Direction::Forward);
    for _ in 0..motion::step_interrupt::CAPACITY {
        player.push(one).unwrap();
    }
    assert_eq!(player.push(one), Err(one));
}

#[test]
fn switches_follow_the_position() {
    let switches = Switches {
        negative_limit: Some(-10),
        positive_limit: Some(10),
        home: Some(-1..=1),
    };
    assert!(switches.at(-10).negative_limit && !switches.at(-9).negative_limit);
    assert!(switches.at(10).positive_limit && !switches.at(9).positive_limit);
    assert!(switches.at(1).home && !switches.at(2).home);
    assert_eq!(Switches::default().at(0), SwitchStates::default());
}

#[test]
fn the_motor_runs_into_its_switches_and_out_again() {
    let mut plant = Plant::new(Instant::from_ticks(0));
    plant.switches = Switches {
        negative_limit: Some(-3),
        positive_limit: Some(3),
        home: Some(0..=1),
    };
    let mut states = Vec::new();
    let mut now = 0;
    for (direction, pulses) in [
        (Direction::Forward, 1),
        (Direction::Forward, 2),
        (Direction::Reverse, 1),
        (Direction::Reverse, 5),
    ] {
        let pulses = record(84, pulses, 10, direction);
        plant.pulses_mut().push(pulses).unwrap();
        now += 10;
        plant.advance(Instant::from_ticks(now));
        let state = plant.switch_states();
        states.push((
            plant.position(),
            state.negative_limit,
            state.home,
            state.positive_limit,
        ));
    }
    assert_eq!(
        states,
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

proptest! {
    #[test]
    fn however_time_is_cut_every_pulse_is_counted_once(
        records in prop::collection::vec((1u32..2000, 1u16..50, 0u16..2, any::<bool>()), 1..60),
        cuts in prop::collection::vec(0u64..50_000, 0..100),
    ) {
        let mut player = PulsePlayer::default();
        let mut expected = 0;
        for (period, repeat, width, forward) in records {
            let direction = if forward { Direction::Forward } else { Direction::Reverse };
            player.push(record(period, repeat, width, direction)).unwrap();
            if width > 0 {
                expected += i64::from(repeat) * if forward { 1 } else { -1 };
            }
        }
        for cut in cuts {
            let before = player.pending();
            player.play(cut);
            prop_assert_eq!(player.pending(), before.saturating_sub(cut));
        }
        player.play(player.pending());
        prop_assert_eq!(player.position(), expected);
        prop_assert_eq!(player.free(), PulsePlayer::default().free());
    }
}

//! What a train may leave of a burst when it ends, and a stream that ends before its train.

use motion::{Direction, Limits, PulseSink, Record};

use super::super::rig::{HZ, Rig, TIME_SLICE};
use super::{FAST, rig};

/// A burst takes so many ticks.
const BURST: u64 = 84;

/// Cruising at a million steps a second.
fn cruising() -> Rig<'static> {
    let mut rig = rig(FAST);
    rig.model.set_burst(BURST);
    let limits = Limits {
        velocity: 1_000_000.into(),
        acceleration: 400_000_000,
        deceleration: 400_000_000,
    };
    rig.axis.ramp_to(1_000_000.into(), limits).unwrap();
    for _ in 0..20 {
        rig.refill(TIME_SLICE.into());
    }
    rig
}

fn goes_on(rig: &mut Rig<'_>) {
    let limits = Limits {
        velocity: 100_000.into(),
        acceleration: 400_000_000,
        deceleration: 400_000_000,
    };
    let position = rig.output.position();
    rig.axis.abort();
    rig.axis.set_position(position);
    assert_eq!(position, rig.model.judge().position);
    rig.axis.move_to(position - 50, limits).unwrap();
    rig.finish(1_000);
    rig.account();
    assert!(!rig.output.has_failed());
    assert_eq!(rig.model.judge().position, position - 50);
}

/// The timer is stopped at each tick around an update event: a burst has been asked for, or not, and has begun, or not.
#[test]
fn a_train_that_is_dropped_leaves_nothing_to_the_next() {
    let first = cruising();
    let left = first.model.words_left();
    let mut event = 0;
    while first.model.words_left() == left {
        first.model.run(1);
        event += 1;
    }
    for late in event - 60..event + 140 {
        let mut rig = cruising();
        rig.model.run(late);
        rig.output.drop_all();
        goes_on(&mut rig);
    }
}

/// A transfer error at each tick of a burst, and before it: the pulses end with the next refill, and the next train has what is its own.
#[test]
fn a_stream_that_is_switched_off_is_noticed_in_the_next_refill() {
    for late in (0..200).chain([1_000, 5_000]) {
        let mut rig = cruising();
        let left = rig.model.words_left();
        while rig.model.words_left() == left {
            rig.model.run(1);
        }
        rig.model.run(late);
        rig.model.fail_stream();
        rig.model.run(100);
        rig.output.service();
        assert!(rig.output.has_failed(), "{late} ticks");
        let pulses = rig.model.judge().pulses;
        rig.model.run(HZ.into());
        assert_eq!(rig.model.judge().pulses, pulses);
        rig.output.mend();
        goes_on(&mut rig);
    }
}

/// A train is dropped while the stream does not serve it: what TIM1 still wants comes when the next train has its stream, and not at once.
#[test]
fn a_word_that_comes_late_is_not_taken_for_the_next_train() {
    for late in [0, 20, 40, 60, 1_000] {
        for access in [1, 2, 4, 8] {
            let mut rig = cruising();
            let left = rig.model.words_left();
            while rig.model.words_left() == left {
                rig.model.run(1);
            }
            rig.model.run(late);
            rig.model.stall_stream(true);
            rig.model.run(20_000);
            rig.output.drop_all();
            rig.model.stall_stream(false);
            rig.model.set_access(access);
            let position = rig.output.position();
            rig.axis.abort();
            rig.axis.set_position(position);
            assert_eq!(position, rig.model.judge().position);
            let limits = Limits {
                velocity: 100_000.into(),
                acceleration: 400_000_000,
                deceleration: 400_000_000,
            };
            rig.axis.move_to(position - 50, limits).unwrap();
            rig.finish(1_000);
            rig.account();
            assert_eq!(
                rig.model.judge().position,
                position - 50,
                "{late}, {access}"
            );
        }
    }
}

/// A transfer error at any moment around a turn, where pulses have turned before: what left is counted as it went.
#[test]
fn an_error_of_the_stream_before_a_turn_is_counted_as_it_went() {
    use Direction::{Forward, Reverse};
    for late in 0..360 {
        let mut rig = rig(FAST);
        for direction in [Reverse, Forward, Reverse, Forward] {
            for (repeat, width) in [(2, 0), (10, 17)] {
                let record = Record {
                    period: 1_000,
                    repeat,
                    width,
                    direction,
                };
                rig.output.push(record).unwrap();
            }
        }
        rig.model.run(late * 150);
        rig.model.fail_stream();
        rig.model.run(TIME_SLICE.into());
        if late % 2 == 0 {
            rig.output.service();
        } else {
            rig.output.drop_all();
        }
        assert!(rig.output.has_failed(), "{late}");
        let position = rig.model.judge().position;
        assert_eq!(rig.output.position(), position, "{late}");
    }
}

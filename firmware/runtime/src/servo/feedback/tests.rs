//! Where positions begin with each kind of feedback.

extern crate std;

use servo::Motor;
use servo::feedback::absolute::NO_ERROR;

use crate::servo::tests::DATA;
use crate::servo::{Current, Feedback, Loops, ServoData, ServoSettings};

const BITS: u8 = 17;

/// The word at so many turns.
fn word(turns: f64) -> u32 {
    (turns.rem_euclid(1.0) * f64::from(1_u32 << BITS)) as u32
}

fn absolute(counts: u32) -> Current {
    Current::new(&data(counts), 0, None).unwrap()
}

fn data(counts: u32) -> ServoData {
    ServoData {
        feedback: Feedback::Absolute {
            bits: BITS,
            table: &NO_ERROR,
            offset: servo::Angle::ZERO,
        },
        motor: Motor {
            counts,
            ..DATA.motor
        },
        // What the words are turned into are the counts of the motor, whatever else an encoder has.
        encoder: 4_000,
        ..DATA
    }
}

/// With the power off.
fn set_up(current: &mut Current, settings: &ServoSettings) {
    let mut loops = Loops::new(&data(current.motor.counts)).unwrap();
    loops.set_up(current, settings);
}

/// The counts of so many turns, as near as a word and a count can tell.
fn is_at(current: &Current, turns: f64) -> bool {
    let counts = turns * f64::from(current.motor.counts);
    let word = f64::from(current.motor.counts) / f64::from(1_u32 << BITS);
    (current.position() as f64 - counts).abs() <= word + 1.0
}

#[test]
fn an_absolute_encoder_begins_where_it_is_in_its_turn() {
    for counts in [4_096, 10_000, 65_536, 1_000_000] {
        for turns in [0.0, 0.1, 0.499, 0.6, 0.9999] {
            let mut current = absolute(counts);
            assert_eq!((current.position(), current.absolute_turn()), (0, 0));
            current.word(Some(word(turns)));
            assert_eq!(current.absolute_turn(), counts);
            assert!(
                is_at(&current, turns),
                "{counts}, {turns}: {}",
                current.position()
            );
            // On over the end of the turn and back over its beginning, and with what the timer would show.
            for step in (0..70).chain((-40..70).rev()) {
                let turns = turns + f64::from(step) * 0.02;
                let timer = current.word(Some(word(turns)));
                current.interrupt.encoder.look(timer);
                assert!(
                    is_at(&current, turns),
                    "{counts}, {turns}: {}",
                    current.position()
                );
            }
        }
    }
}

#[test]
fn an_encoder_that_is_turned_begins_at_the_same_angle_the_other_way() {
    for turns in [0.1, 0.7] {
        let mut current = absolute(10_000);
        current.word(Some(word(turns)));
        let settings = ServoSettings {
            is_turned: true,
            ..ServoSettings::NONE
        };
        set_up(&mut current, &settings);
        assert_eq!(current.absolute_turn(), 0, "until the next word");
        current.word(Some(word(turns)));
        assert!(is_at(&current, -turns), "{turns}: {}", current.position());
    }
}

#[test]
fn other_counts_of_an_encoder_leave_an_absolute_one_where_it_is() {
    let mut current = absolute(65_536);
    current.word(Some(word(0.7)));
    let position = current.position();
    let settings = ServoSettings {
        encoder: 4_000,
        ..ServoSettings::NONE
    };
    set_up(&mut current, &settings);
    current.word(Some(word(0.7)));
    assert_eq!(current.position(), position);
    assert!(is_at(&current, 0.7));
}

#[test]
fn before_the_first_word_nothing_is_known() {
    let mut current = absolute(10_000);
    current.word(None);
    assert_eq!((current.position(), current.absolute_turn()), (0, 0));
    current.word(Some(word(0.25)));
    assert_eq!(
        (current.position(), current.absolute_turn()),
        (2_500, 10_000)
    );
    // One that does not come leaves it.
    current.word(None);
    assert_eq!(
        (current.position(), current.absolute_turn()),
        (2_500, 10_000)
    );
}

#[test]
fn any_other_encoder_begins_at_0() {
    for feedback in [Feedback::Incremental, Feedback::Hall] {
        let data = ServoData { feedback, ..DATA };
        let mut current = Current::new(&data, 7_500, None).unwrap();
        current.hall(0b001);
        current.word(Some(1_000));
        assert_eq!((current.position(), current.absolute_turn()), (0, 0));
    }
}

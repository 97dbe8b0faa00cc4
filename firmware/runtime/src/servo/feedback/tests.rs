//! Where positions begin with each kind of feedback.

extern crate std;

use servo::Motor;
use servo::feedback::absolute::NO_ERROR;

use crate::servo::tests::DATA;
use crate::servo::{Feedback, Loops, ServoData, ServoSettings};

const BITS: u8 = 17;

/// The word at so many turns.
fn word(turns: f64) -> u32 {
    (turns.rem_euclid(1.0) * f64::from(1_u32 << BITS)) as u32
}

fn absolute(counts: u32) -> Loops {
    let data = ServoData {
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
    };
    Loops::new(&data, 0, None).unwrap()
}

/// The counts of so many turns, as near as a word and a count can tell.
fn is_at(loops: &Loops, turns: f64) -> bool {
    let counts = turns * f64::from(loops.motor().counts);
    let word = f64::from(loops.motor().counts) / f64::from(1_u32 << BITS);
    (loops.position() as f64 - counts).abs() <= word + 1.0
}

#[test]
fn an_absolute_encoder_begins_where_it_is_in_its_turn() {
    for counts in [4_096, 10_000, 65_536, 1_000_000] {
        for turns in [0.0, 0.1, 0.499, 0.6, 0.9999] {
            let mut loops = absolute(counts);
            assert_eq!((loops.position(), loops.absolute_turn()), (0, 0));
            loops.word(Some(word(turns)));
            assert_eq!(loops.absolute_turn(), counts);
            assert!(
                is_at(&loops, turns),
                "{counts}, {turns}: {}",
                loops.position()
            );
            // On over the end of the turn and back over its beginning, and with what the timer would show.
            for step in (0..70).chain((-40..70).rev()) {
                let turns = turns + f64::from(step) * 0.02;
                let timer = loops.word(Some(word(turns)));
                loops.interrupt.encoder.look(timer);
                assert!(
                    is_at(&loops, turns),
                    "{counts}, {turns}: {}",
                    loops.position()
                );
            }
        }
    }
}

#[test]
fn an_encoder_that_is_turned_begins_at_the_same_angle_the_other_way() {
    for turns in [0.1, 0.7] {
        let mut loops = absolute(10_000);
        loops.word(Some(word(turns)));
        let settings = ServoSettings {
            is_turned: true,
            ..ServoSettings::NONE
        };
        loops.set_up(&settings);
        assert_eq!(loops.absolute_turn(), 0, "until the next word");
        loops.word(Some(word(turns)));
        assert!(is_at(&loops, -turns), "{turns}: {}", loops.position());
    }
}

#[test]
fn other_counts_of_an_encoder_leave_an_absolute_one_where_it_is() {
    let mut loops = absolute(65_536);
    loops.word(Some(word(0.7)));
    let position = loops.position();
    let settings = ServoSettings {
        encoder: 4_000,
        ..ServoSettings::NONE
    };
    loops.set_up(&settings);
    loops.word(Some(word(0.7)));
    assert_eq!(loops.position(), position);
    assert!(is_at(&loops, 0.7));
}

#[test]
fn before_the_first_word_nothing_is_known() {
    let mut loops = absolute(10_000);
    loops.word(None);
    assert_eq!((loops.position(), loops.absolute_turn()), (0, 0));
    loops.word(Some(word(0.25)));
    assert_eq!((loops.position(), loops.absolute_turn()), (2_500, 10_000));
    // One that does not come leaves it.
    loops.word(None);
    assert_eq!((loops.position(), loops.absolute_turn()), (2_500, 10_000));
}

#[test]
fn any_other_encoder_begins_at_0() {
    for feedback in [Feedback::Incremental, Feedback::Hall] {
        let data = ServoData { feedback, ..DATA };
        let mut loops = Loops::new(&data, 7_500, None).unwrap();
        loops.hall(0b001);
        loops.word(Some(1_000));
        assert_eq!((loops.position(), loops.absolute_turn()), (0, 0));
    }
}

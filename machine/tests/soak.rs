//! Very many pulses through planner, train and the timers of the board: none too many, none too few.
//!
//! The ordinary run makes thirteen million pulses, which are four moves, one with each kind of ramps, and a few hundred sequences of commands.
//! `cargo xtask soak` makes a thousand million and a million of them; it sets the two variables below.

use std::env;

use machine::exactness::count::{Counted, long_moves, sequences};

fn setting(name: &str, ordinary: u64) -> u64 {
    env::var(name).map_or(ordinary, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("{name} is no number: {text}"))
    })
}

#[test]
fn every_pulse_of_long_moves_is_there() {
    let wanted = setting("AXIS402_SOAK_PULSES", 13_000_000);
    let Counted {
        pulses,
        error,
        underruns,
        ..
    } = long_moves(wanted);
    assert!(pulses >= wanted);
    assert_eq!((error, underruns), (0, 0));
    println!("{pulses} pulses, count error {error}");
}

#[test]
fn no_sequence_of_commands_makes_a_pulse_too_many() {
    let wanted = setting("AXIS402_SOAK_SEQUENCES", 300);
    let Counted {
        pulses,
        error,
        pauses,
        underruns,
    } = sequences(wanted);
    assert!(pulses > 10 * wanted);
    assert_eq!(error, 0);
    assert!(underruns <= pauses, "{underruns} of {pauses} pauses");
    println!(
        "{wanted} sequences, {pulses} pulses, {underruns} underruns told, count error {error}"
    );
}

//! An interrupt and a control tick, in every order that a board may have.

use super::*;

/// An interrupt for the inputs in `changed`, with position and time.
fn note(capture: &Capture, changed: u8, levels: u8, at: u32) {
    capture.note(changed, levels, |_| at, at);
}

fn take(capture: &Capture, levels: u8) -> DigitalInputs {
    let mut inputs = DigitalInputs::NONE;
    capture.take(levels, &mut inputs, |ticks| ticks, |count| count as i32);
    inputs
}

/// One edge there.
fn once(at: u32) -> Option<Edges> {
    Some(Edges::one(Edge {
        position: at as i32,
        time: at,
    }))
}

#[test]
fn an_edge_comes_with_its_position_and_time_and_once() {
    let capture = Capture::new();
    note(&capture, 0b10, 0b10, 7);
    let inputs = take(&capture, 0b10);
    assert_eq!((inputs.levels, inputs.changed), (0b10, 0b10));
    let [_, second, ..] = inputs.captured;
    assert_eq!((second.rose, second.fell), (once(7), None));
    assert_eq!(take(&capture, 0b10).changed, 0);
}

#[test]
fn a_pulse_between_two_interrupts_is_both_edges() {
    let capture = Capture::new();
    note(&capture, 1, 0, 7);
    let [first, ..] = take(&capture, 0).captured;
    assert_eq!((first.rose, first.fell), (once(7), once(7)));
}

#[test]
fn an_input_that_was_high_from_the_start_only_falls() {
    let capture = Capture::new();
    capture.begin(1);
    note(&capture, 1, 0, 7);
    let [first, ..] = take(&capture, 0).captured;
    assert_eq!((first.rose, first.fell), (None, once(7)));
}

#[test]
fn an_edge_behind_the_look_at_the_lines_waits_for_its_own_interrupt() {
    let capture = Capture::new();
    note(&capture, 0b01, 0b11, 7);
    note(&capture, 0b10, 0b11, 8);
    let [first, second, ..] = take(&capture, 0b11).captured;
    assert_eq!((first.rose, first.fell), (once(7), None));
    assert_eq!((second.rose, second.fell), (once(8), None));
}

#[test]
fn an_edge_that_comes_while_the_tick_measures_is_a_little_after_it() {
    let now = Instant::from_ticks(1_000_000_000);
    let at = |counts: i32| time_of_edge(now, counts.cast_unsigned(), 84);
    let tick = (now.ticks() * 1_000) as u32;
    assert_eq!(at(0), tick);
    assert_eq!(
        at(84_000),
        tick.wrapping_sub(1_000_000),
        "a millisecond ago"
    );
    assert_eq!(at(-84), tick.wrapping_add(1_000), "a microsecond later");
}

//! An interrupt and a control tick, in every order that a board may have.

use proptest::prelude::*;

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

#[test]
fn an_edge_behind_the_look_at_the_levels_brings_its_level_along() {
    let capture = Capture::new();
    note(&capture, 1, 1, 7);
    let inputs = take(&capture, 0);
    assert_eq!((inputs.levels, inputs.changed), (1, 1));
    let inputs = take(&capture, 1);
    assert_eq!((inputs.levels, inputs.changed), (1, 0));
}

#[test]
fn a_level_does_not_go_before_its_edge() {
    let capture = Capture::new();
    let inputs = take(&capture, 1);
    assert_eq!((inputs.levels, inputs.changed), (0, 0), "on its way");
    note(&capture, 1, 1, 7);
    let inputs = take(&capture, 1);
    assert_eq!((inputs.levels, inputs.changed), (1, 1));
}

#[test]
fn a_level_whose_edge_does_not_come_counts_in_the_second_tick() {
    let capture = Capture::new();
    let levels = [1, 1, 1, 0, 1, 0, 0].map(|level| take(&capture, level).levels);
    assert_eq!(levels, [0, 1, 1, 1, 1, 1, 0]);
}

proptest! {
    /// An input that moves and interrupts that come at once, but the tick looks at the levels earlier than at the edges.
    #[test]
    fn levels_and_edges_tell_the_same(
        moves in prop::collection::vec((0..3_usize, 0..3_usize), 1..100),
    ) {
        let capture = Capture::new();
        let (mut level, mut before, mut time) = (0, 0, 0);
        for (early, late) in moves {
            let mut seen = level;
            for edge in 0..early + late {
                level ^= 1;
                time += 1;
                note(&capture, 1, level, time);
                if edge < early {
                    seen = level;
                }
            }
            let inputs = take(&capture, seen);
            let [first, ..] = inputs.captured;
            let count = |edges: Option<Edges>| edges.map_or(0, |edges| i32::from(edges.count));
            let rises = count(first.rose) - count(first.fell);
            prop_assert_eq!(i32::from(inputs.levels) - before, rises);
            prop_assert_eq!(count(first.rose) + count(first.fell), (early + late) as i32);
            before = i32::from(inputs.levels);
        }
    }
}

//! Slots add up to the records they come from, and no run is too short for the burst behind it.

use std::vec::Vec;

use proptest::prelude::*;

use super::count::PulseCount;
use super::ring::{Ring, SLOTS};
use super::slots::{LONGEST_PERIOD, LONGEST_RUN, MAX_PERIODS, Place, Remainder, Runs, Words};
use crate::Direction::{Forward, Reverse};
use crate::Record;
use crate::record::SHORTEST_RECORD;

fn slots_of(record: Record) -> Vec<Words> {
    let mut left = Remainder::of(&record);
    let mut slots = Vec::new();
    while !left.is_empty() {
        assert!(slots.len() < 70_000 * 3, "{record:?} does not end");
        slots.push(left.next());
    }
    slots
}

/// A record as a train makes it: period, repeat, width; for a driver that wants `low` ticks between pulses.
fn any_record() -> impl Strategy<Value = Record> {
    let period = prop_oneof![
        34..2_000u32,
        2_000..200_000u32,
        16_000..17_000u32,
        65_000..66_000u32,
        1..1u32 << 20
    ];
    let repeat = prop_oneof![1..4u16, 1..600u16];
    let width = prop_oneof![Just(0), 17..600u16, 1..32_767u16];
    (period, repeat, width).prop_map(|(period, repeat, width)| {
        let width = width.min((period / 2).min(32_767) as u16);
        let least = SHORTEST_RECORD.div_ceil(repeat.into());
        Record {
            period: period.max(least).max(2 * u32::from(width)),
            repeat,
            width,
            direction: Forward,
        }
    })
}

proptest! {
    #[test]
    fn slots_add_up_to_their_record(record in any_record()) {
        let mut rises = Vec::new();
        let mut ticks = 0u64;
        for words in slots_of(record) {
            let [reload, repetitions, width, level] = words.0;
            prop_assert!(reload < LONGEST_PERIOD && repetitions < MAX_PERIODS);
            prop_assert_eq!(level, LONGEST_PERIOD);
            prop_assert!(words.ticks() >= SHORTEST_RECORD, "{:?} of {:?}", words, record);
            let longest = LONGEST_RUN.max(u32::from(record.width) + 2 * SHORTEST_RECORD);
            prop_assert!(words.ticks() <= longest, "{:?} of {:?}", words, record);
            for _ in 0..=repetitions {
                if width > 0 {
                    prop_assert_eq!(width, u32::from(record.width));
                    prop_assert!(width <= reload);
                    rises.push(ticks);
                }
                ticks += u64::from(reload) + 1;
            }
        }
        prop_assert_eq!(ticks, record.ticks());
        let pulses = if record.width > 0 { record.repeat } else { 0 };
        let expected: Vec<_> = (0..pulses).map(|pulse| u64::from(pulse) * u64::from(record.period)).collect();
        prop_assert_eq!(rises, expected);
    }
}

/// Each run has a period of its own, and all periods are in one: with none at all the repetition counter would wrap.
#[test]
fn runs_share_out_their_periods() {
    let periods = [1, 2, 3, 255, 256, 257, 511, 512, 513, 1024, 65_535];
    for period in (84..=LONGEST_RUN).step_by(4).chain([LONGEST_RUN]) {
        for periods in periods {
            let mut runs = Runs::of(period, periods).unwrap();
            let mut left = periods;
            while left > 0 {
                let share = runs.next();
                assert!(
                    (1..=MAX_PERIODS.min(left)).contains(&share),
                    "{periods} of {period}"
                );
                left -= share;
            }
        }
    }
}

proptest! {
    /// Written at once it is the same pulses at the same ticks as part by part, and no slot beside its own is touched.
    #[test]
    fn slots_written_at_once_add_up_to_their_record(record in any_record(), first in 0u32..1_000, max in 0usize..64) {
        let ring = Ring::new();
        ring.silence(0, SLOTS as u32, 0);
        let slots = ring.from(first);
        let slots = slots.get(..max).unwrap_or(slots);
        let mut place = Place::new(slots, LONGEST_PERIOD);
        let is_written = place.put(&record).is_some();
        let number = (slots.len() - place.free.len()) as u32;
        prop_assert_eq!(is_written, number > 0);
        let (behind, mut last) = (first + number, place.last);
        let silent = [0, LONGEST_PERIOD - 1, MAX_PERIODS - 1, 0, 0];
        prop_assert_eq!(ring.words(behind), silent);
        prop_assert_eq!(ring.words(first.wrapping_sub(1)), silent);
        // What is left is a tick for each part of a period.
        let more = if record.period <= LONGEST_RUN { 0 } else { 64 };
        let (mut ticks, mut rises) = (0u64, Vec::new());
        for slot in first..behind {
            let [_, reload, repetitions, width, level] = ring.words(slot);
            prop_assert!(reload < LONGEST_PERIOD && repetitions < MAX_PERIODS);
            prop_assert_eq!(level, LONGEST_PERIOD);
            let run = (reload + 1) * (repetitions + 1);
            prop_assert!((SHORTEST_RECORD..=LONGEST_RUN + more).contains(&run), "{} of {:?}", run, record);
            for _ in 0..=repetitions {
                if width > 0 {
                    prop_assert!(width == u32::from(record.width) && width <= reload);
                    rises.push(ticks);
                }
                ticks += u64::from(reload) + 1;
            }
            last ^= if slot + 1 == behind { run } else { 0 };
        }
        if is_written {
            prop_assert_eq!(last, 0);
            prop_assert_eq!(ticks, record.ticks());
            let pulses = if record.width > 0 { record.repeat } else { 0 };
            let expected: Vec<_> = (0..pulses).map(|pulse| u64::from(pulse) * u64::from(record.period)).collect();
            prop_assert_eq!(rises, expected);
        }
    }
}

#[test]
fn a_short_train_is_one_slot() {
    let record = Record {
        period: 168,
        repeat: 97,
        width: 17,
        direction: Reverse,
    };
    assert_eq!(slots_of(record).len(), 1);
    assert_eq!(slots_of(record)[0].0, [167, 96, 17, 0]);
}

#[test]
fn a_count_is_read_by_the_direction_that_its_pulses_had() {
    let mut counted = PulseCount::new(u32::MAX - 9, -100);
    // Ten forward, four back, then forward again: what is still to come is known too.
    counted.turn(0, Reverse, 3);
    counted.turn(4, Forward, 5);
    for (count, position) in [
        (u32::MAX - 9, -100),
        (0, -90),
        (3, -93),
        (4, -94),
        (10, -88),
        (u32::MAX, -91),
    ] {
        assert_eq!(counted.position_at(count), position, "at {count}");
    }
    // A capture of a while ago is still read rightly.
    counted.go_on(1 << 20);
    assert_eq!(counted.position_at(u32::MAX - 4), -95);
}

#[test]
fn a_velocity_that_is_kept_counts_beyond_32_bits() {
    let mut counted = PulseCount::new(0, 0);
    let mut count = 0u64;
    while count < 20 << 30 {
        count += 1 << 20;
        counted.go_on(count as u32);
        assert_eq!(counted.position_at(count as u32), count as i64);
    }
}

#[test]
fn so_many_turns_are_remembered_and_no_more() {
    let mut counted = PulseCount::new(0, 0);
    let mut turns = 0;
    while counted.has_room(0) {
        turns += 1;
        counted.turn(turns, if turns % 2 == 0 { Forward } else { Reverse }, turns);
    }
    assert_eq!(turns, 16);
    // When the motor has come there, there is room again.
    assert!(counted.has_room(2));
    assert_eq!(counted.position_at(2), 0);
    assert_eq!(counted.position_at(1), 1);
}

//! Runs of periods, judged one by one.

use std::vec::Vec;

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::{MANY, Train};
use crate::record::SHORTEST_RECORD;
use crate::{Direction, DriverTiming, Record};

/// 17 ticks high and low at least.
const TIMING: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

/// So many periods in so many ticks.
fn spaced(gaps: u32, span: u32) -> Vec<Record> {
    let mut train = Train::new(TIMING, 42_000, 0, 0);
    train.space((gaps, span / gaps), span, true, Direction::Forward);
    let records = train.waiting().to_vec();
    let ticks: u64 = records.iter().map(Record::ticks).sum();
    assert_eq!(ticks, train.recorded);
    records
}

/// The furthest that a pulse is from where it would be if all were evenly spaced, in steps.
fn furthest(records: &[Record], gaps: u32, span: u32) -> f64 {
    let pace = f64::from(gaps) / f64::from(span);
    let (mut ticks, mut pulses, mut worst) = (0.0, 0.0, 0.0_f64);
    for record in records {
        pulses += f64::from(record.repeat);
        ticks += f64::from(record.period) * f64::from(record.repeat);
        // Where a run ends they are furthest.
        worst = worst.max((ticks * pace - pulses).abs());
    }
    worst
}

#[test]
fn a_few_dense_periods_make_no_run_that_is_too_short() {
    let records = spaced(8, 276);
    assert!(
        records.iter().all(|record| record.ticks() >= 84),
        "{records:?}"
    );
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(4096)))]

    #[test]
    fn periods_in_a_chord_are_even_and_no_run_is_short(base in 34u32..200, gaps in 1u32..1_300, part in 0.0..1.0) {
        let gaps = gaps.min(47_000 / base);
        let span = base * gaps + (f64::from(gaps) * part) as u32;
        let records = spaced(gaps, span);
        let pulses: u32 = records.iter().map(|record| u32::from(record.repeat)).sum();
        prop_assert_eq!(pulses, gaps);
        for record in &records {
            prop_assert!(record.ticks() >= SHORTEST_RECORD.into(), "{:?}", record);
            prop_assert!(record.period >= base);
        }
        // A gap alone may be too short for a record.
        let ticks = records.iter().map(Record::ticks).sum::<u64>() as i64;
        let off = ticks - i64::from(span);
        prop_assert!(off.abs() < 3 || gaps < 3, "{} ticks", off);
        let worst = furthest(&records, gaps, span);
        // A microsecond at 168 MHz.
        let ticks = worst * f64::from(span) / f64::from(gaps);
        prop_assert!(ticks <= 168.0 || gaps < MANY, "{} ticks: {:?}", ticks, records);
        // Up to 1 MHz at 168 MHz.
        prop_assert!(base < 168 || worst <= 0.25, "{} steps: {:?}", worst, records);
    }
}

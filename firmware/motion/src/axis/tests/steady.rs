//! Velocities that stay: few records, and each pulse at its tick.

use super::{Axis, FAST, HZ, SLOW, axis, config};
use crate::{Limits, PulseSink, Speed};

/// From pulses that are seconds apart to the fastest.
const VELOCITIES: [u32; 20] = [
    1, 100, 650, 2_563, 3_999, 4_001, 5_000, 8_800, 9_999, 10_000, 18_000, 31_999, 123_457,
    500_000, 654_321, 999_000, 1_000_000, 1_234_567, 3_027_027, 4_869_565,
];

/// In a time slice there are one or two runs, and where pulses are as far apart as that, a silence more; where they are crowded, three.
#[test]
fn a_velocity_that_stays_takes_few_records_and_each_pulse_is_at_its_tick() {
    for velocity in VELOCITIES {
        for sign in [1, -1] {
            let (mut axis, mut sink) = axis(FAST);
            let time_slice = u64::from(axis.stepper.time_slice());
            let limits = Limits {
                velocity: velocity.into(),
                acceleration: velocity * 50,
                deceleration: velocity,
            };
            let speed = Speed::per_second(velocity).signed(sign < 0);
            axis.ramp_to(speed, limits).unwrap();
            sink.follow(&axis);
            // The ramp is as steep as no motor's.
            sink.tolerance = 6.0;
            // Half a step is what a step is wide. Evenly spaced with the last period of the stretch before, pulses are off by a sixteenth or by
            // n² / 8T; above 1 MHz by a microsecond.
            let pulses = f64::from(velocity) / f64::from(HZ);
            let stretch = time_slice as f64 + 1.0 / pulses;
            let off = if velocity > 1_000_000 {
                pulses * 168.0
            } else {
                (pulses * pulses * stretch / 8.0).max(1.0 / 16.0)
            };
            let tick = 2.0 * pulses;
            let mut before = 0;
            for refill in 0..4_000 {
                if refill == 200 {
                    before = sink.records;
                    sink.worst = 0.0;
                    sink.tolerance = 0.5 + off + tick;
                }
                axis.advance(&mut sink).unwrap();
                sink.account(&axis);
                sink.play(time_slice);
            }
            let records = sink.records - before;
            let most = match velocity {
                4_000..400_000 => 2,
                _ => 3,
            };
            assert!(
                records <= 3_801 * most,
                "{velocity}: {records} records, {} steps off",
                sink.worst
            );
            assert!(sink.pending() <= 2 * time_slice);
        }
    }
}

/// A tick may commit pulses right behind a refill: one or two are due then, and no record is as short as that.
#[test]
fn a_refill_right_behind_another_costs_no_rate() {
    for velocity in [2_100_000, 3_333_333, 4_444_444, 4_900_000, 4_941_176] {
        for behind in [0, 1, 20, 34, 50, 68, 84, 100, 130, 168, 200] {
            let (mut axis, mut sink) = axis(FAST);
            let time_slice = u64::from(axis.stepper.time_slice());
            let limits = Limits {
                velocity: velocity.into(),
                acceleration: velocity * 20,
                deceleration: velocity,
            };
            axis.ramp_to(Speed::per_second(velocity).signed(false), limits)
                .unwrap();
            sink.follow(&axis);
            sink.tolerance = 6.0;
            let mut before = (0, 0);
            for refill in 0..400 {
                if refill == 300 {
                    before = (sink.ticks, sink.pulses);
                }
                axis.advance(&mut sink).unwrap();
                sink.play(behind);
                axis.advance(&mut sink).unwrap();
                sink.account(&axis);
                sink.play(time_slice - behind);
            }
            let (ticks, pulses) = (sink.ticks - before.0, sink.pulses - before.1);
            let due = u128::from(ticks) * u128::from(velocity) / u128::from(HZ);
            let missing = due as i64 - pulses as i64;
            // Between two pulses at either end, and at the highest rate a period is a tick more than a step here and there.
            assert!(
                missing.abs() <= 2,
                "{velocity}, {behind} ticks behind: {missing} of {due}"
            );
        }
    }
}

#[test]
fn a_new_axis_is_one_that_has_come_to_stand_at_0() {
    for timing in [FAST, SLOW] {
        let new = Axis::new(config(timing));
        let mut standing = new.clone();
        assert_eq!(standing.abort(), 0);
        assert_eq!(std::format!("{standing:?}"), std::format!("{new:?}"));
    }
}

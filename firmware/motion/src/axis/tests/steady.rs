//! Velocities that stay: few records, and each pulse at its tick.

use super::{FAST, HZ, axis};
use crate::{Limits, PulseSink, Speed};

/// From pulses that are seconds apart to the fastest.
const VELOCITIES: [u32; 18] = [
    1, 100, 650, 2_563, 3_999, 4_001, 5_000, 8_800, 9_999, 10_000, 18_000, 31_999, 123_457,
    500_000, 654_321, 999_000, 1_000_000, 4_869_565,
];

/// In a segment there are one or two runs, and where pulses are as far apart as that, a silence more; where they are crowded, up to 16.
#[test]
fn a_velocity_that_stays_takes_few_records_and_each_pulse_is_at_its_tick() {
    for velocity in VELOCITIES {
        for sign in [1, -1] {
            let (mut axis, mut sink) = axis(FAST);
            let segment = u64::from(axis.train.segment());
            let limits = Limits {
                velocity: velocity.into(),
                acceleration: velocity * 50,
                deceleration: velocity,
            };
            let speed = Speed::per_second(velocity).signed(sign < 0);
            axis.ramp_to(speed, limits).unwrap();
            sink.follow(&axis);
            // The ramp is as steep as no motor's.
            sink.tolerance = 2.0;
            // Half a step is what a step is wide. Evenly spaced in a chord with its last period, pulses are off by n² / 4T or n² / 8T.
            let pulses = f64::from(velocity) / f64::from(HZ);
            let segments = 1.0 + (1.0 / (pulses * segment as f64)).min(1.0);
            let off = pulses * pulses * segment as f64 * segments / 4.0;
            let off = if velocity < 400_000 { off } else { off / 2.0 };
            let tick = 2.0 * pulses;
            let mut before = 0;
            for refill in 0..4_000 {
                if refill == 200 {
                    before = sink.records;
                    sink.worst = 0.0;
                    sink.tolerance = 0.5 + off.min(0.8) + tick;
                }
                axis.advance(&mut sink).unwrap();
                sink.account(&axis);
                sink.play(segment);
            }
            let records = sink.records - before;
            let most = match velocity {
                0..4_000 => 3,
                4_000..400_000 => 2,
                400_000..=1_000_000 => 3,
                _ => 16,
            };
            assert!(
                records <= 3_801 * most,
                "{velocity}: {records} records, {} steps off",
                sink.worst
            );
            assert!(sink.pending() <= 2 * segment);
        }
    }
}

//! Velocities that stay: few records, and each pulse at its tick.

use super::{FAST, HZ, axis};
use crate::{Limits, PulseSink, Speed};

/// From pulses that are seconds apart to the fastest.
const VELOCITIES: [u32; 20] = [
    1, 100, 650, 2_563, 3_999, 4_001, 5_000, 8_800, 9_999, 10_000, 18_000, 31_999, 123_457,
    500_000, 654_321, 999_000, 1_000_000, 1_234_567, 3_027_027, 4_869_565,
];

/// In a segment there are one or two runs, and where pulses are as far apart as that, a silence more; where they are crowded, three.
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
            sink.tolerance = 6.0;
            // Half a step is what a step is wide. Evenly spaced with the last period of the stretch before, pulses are off by a sixteenth or by
            // n² / 8T; above 1 MHz by a microsecond.
            let pulses = f64::from(velocity) / f64::from(HZ);
            let stretch = segment as f64 + 1.0 / pulses;
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
                sink.play(segment);
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
            assert!(sink.pending() <= 2 * segment);
        }
    }
}

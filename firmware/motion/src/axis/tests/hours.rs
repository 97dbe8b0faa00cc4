//! A velocity that is kept for hours, by its pulses alone: nothing here knows the plan.

use super::{FAST, HZ};
use crate::axis::{Axis, AxisConfig};
use crate::{Clock, Limits, PulseSink, Record, Ticks};

/// Holds pulses to a steady velocity in steps/s.
#[derive(Debug)]
struct Steady {
    velocity: u32,
    /// Ticks of all records, and of those not played yet.
    ticks: Ticks,
    pending: Ticks,
    /// The axis has reached its velocity: the next pulse is the first that counts.
    is_steady: bool,
    first: Option<Ticks>,
    last: Ticks,
    /// Pulses behind the first one, and steps of all.
    pulses: u64,
    position: i64,
}

impl Steady {
    /// Pulses of one record, `period` apart.
    fn pulses(&mut self, period: u64, repeat: u64) {
        let end = self.ticks + period * (repeat - 1);
        if self.first.is_some() {
            // Neither a pulse too many nor one too few: each is as far from the last as the velocity wants, up to a tick.
            let wanted = u64::from(HZ / self.velocity);
            let gaps = [self.ticks - self.last, period];
            for gap in &gaps[..if repeat > 1 { 2 } else { 1 }] {
                assert!((wanted..=wanted + 1).contains(gap), "{gap} ticks at {end}");
            }
            self.pulses += repeat;
        } else if self.is_steady {
            self.first = Some(end);
        }
        self.last = end;
    }

    /// At the end of a time slice there are as many pulses as the time since the first one wants, however long ago that was.
    fn account(&self) {
        let Some(first) = self.first else {
            return;
        };
        let wanted = u128::from(self.ticks - first) * u128::from(self.velocity);
        let off = wanted.abs_diff(u128::from(self.pulses) * u128::from(HZ));
        assert!(off <= 2 * u128::from(HZ), "{self:?}");
    }
}

impl PulseSink for Steady {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if record.width > 0 {
            self.pulses(record.period.into(), record.repeat.into());
            self.position += i64::from(record.repeat) * i64::from(record.direction.sign());
        }
        self.ticks += record.ticks();
        self.pending += record.ticks();
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        256
    }
}

#[test]
fn i11_hours_of_velocity_cross_the_span_without_a_jump() {
    // Long time slices, as there are many hours. In three of them the span is crossed more than twice.
    let time_slice = HZ / 40;
    let velocity = 1_234_567;
    for sign in [1, -1] {
        let mut axis = Axis::new(AxisConfig {
            clock: Clock::new(HZ).unwrap(),
            time_slice,
            timing: FAST,
        });
        // Two seconds before the end of the span.
        let begin = (i64::from(i32::MAX) - 2 * i64::from(velocity)) * i64::from(sign);
        axis.set_position(begin);
        let mut sink = Steady {
            velocity,
            ticks: 0,
            pending: 0,
            is_steady: false,
            first: None,
            last: 0,
            pulses: 0,
            position: begin,
        };
        let limits = Limits {
            velocity: velocity.into(),
            acceleration: 5_000_000,
            deceleration: 5_000_000,
        };
        axis.ramp_to((velocity as i32 * sign).into(), limits)
            .unwrap();
        let hours = 3 * 3_600 * u64::from(HZ);
        while sink.ticks < hours {
            axis.advance(&mut sink).unwrap();
            assert_eq!(axis.committed_position(), i64::from(sink.position as i32));
            sink.account();
            sink.pending = sink.pending.saturating_sub(time_slice.into());
            sink.is_steady = sink.ticks > u64::from(HZ);
        }
        assert!(sink.position.abs_diff(begin) > 2 << 32);
    }
}

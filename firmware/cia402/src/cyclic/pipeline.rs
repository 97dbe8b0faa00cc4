//! The delays between a sync event and the motor: how far ahead a set-point has to be known.

use super::MicrosQ16;

/// What lies between a sync event and the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pipeline {
    /// From a control tick to the next, plus what is committed ahead of the motor.
    depth: MicrosQ16,
    /// How long before a sync event a control tick comes.
    sync_lead: MicrosQ16,
    /// From a control tick to the next, and a quarter of that as they come now and then late.
    tick: MicrosQ16,
    /// A period, and its latency.
    known: (MicrosQ16, MicrosQ16),
}

impl Pipeline {
    /// Of an actuator that commits so far `ahead` of the motor in every `tick`, one of which comes `sync_lead` before each sync event.
    pub(crate) const fn new(ahead: MicrosQ16, tick: MicrosQ16, sync_lead: MicrosQ16) -> Self {
        Self {
            depth: tick.saturating_add(ahead),
            sync_lead,
            tick: tick.saturating_add(tick / 4),
            known: (0, 0),
        }
    }

    /// What is not done in this control tick is done by then.
    pub(crate) const fn next_tick(&self) -> MicrosQ16 {
        self.tick
    }

    /// From a sync event to the moment at which the motor is at its set-point: whole periods, less the time by which the control tick
    /// is ahead of SYNC. So the transmit PDOs of a SYNC show a position that is exactly a set-point.
    ///
    /// A period that is measured is never quite the nominal one; a sixteenth of it is allowed for, so that the number of periods does
    /// not hang on that. That is never more than an eighth of the depth: of a long period, the rest of the depth would not be there
    /// when the motor is to set out for a set-point.
    pub(crate) fn latency(&self, period: MicrosQ16) -> MicrosQ16 {
        let (known, latency) = self.known;
        if known == period && period != 0 {
            latency
        } else {
            self.worked_out(period)
        }
    }

    /// This is the period that is asked for from now on: as long as it stays the same, its latency is worked out once.
    pub(crate) fn expect(&mut self, period: MicrosQ16) {
        if self.known.0 != period {
            self.known = (period, self.worked_out(period));
        }
    }

    #[inline(never)]
    fn worked_out(&self, period: MicrosQ16) -> MicrosQ16 {
        let allowed = (period / 16).min(self.depth / 8);
        let periods = self
            .depth
            .saturating_add(period.saturating_sub(allowed))
            .saturating_sub(1)
            .checked_div(period)
            .unwrap_or(1)
            .saturating_add(1);
        periods
            .saturating_mul(period)
            .saturating_sub(self.sync_lead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cyclic::POINT;

    const fn micros(time: u64) -> MicrosQ16 {
        time << POINT
    }

    #[test]
    fn m63_of_any_period_the_motor_sets_out_after_its_set_point_is_known() {
        for time_slice in [250, 1_000] {
            let ahead = micros(2 * time_slice);
            let pipeline = Pipeline::new(ahead, micros(1_000), micros(250));
            for period in [1, 2, 3, 10, 23, 24, 25, 50, 100, 250, 2_000] {
                let period = micros(period * 1_000);
                let mut expecting = pipeline;
                expecting.expect(period);
                for other in [period, period + 1] {
                    assert_eq!(expecting.latency(other), pipeline.latency(other));
                }
                let latency = pipeline.latency(period) + pipeline.sync_lead;
                assert_eq!(latency % period, 0);
                let known = pipeline.depth - pipeline.depth / 8;
                assert!(latency - period >= known, "{} us", period >> POINT);
                assert!(latency - period < pipeline.depth + period);
            }
        }
    }
}

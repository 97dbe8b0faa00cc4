//! How far ahead of the motor the drive has to know where it is to go.

use motion::AxisConfig;

use super::{Fine, POINT};

/// What lies between a beat and the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pipeline {
    /// From a control tick to the next, plus what is handed out ahead of the motor.
    depth: Fine,
    /// How long before a beat a control tick comes.
    lead: Fine,
}

impl Pipeline {
    /// Of an axis that is given pulses in every `tick`, one of which comes `lead` before each beat.
    pub(crate) fn new(axis: &AxisConfig, tick: Fine, lead: Fine) -> Self {
        let hz = u64::from(axis.clock.hz());
        let ahead = (u64::from(axis.segment).saturating_mul(2_000_000) << POINT)
            .checked_div(hz)
            .unwrap_or(0);
        Self {
            depth: tick.saturating_add(ahead),
            lead,
        }
    }

    /// From a beat to the moment at which the motor is at its set-point: whole periods, less the time by which the control tick
    /// is ahead of SYNC. So the transmit PDOs of a SYNC show a position that is exactly a set-point.
    ///
    /// A period that is measured is never quite the nominal one; a sixteenth of it is allowed for, so that the number of periods does
    /// not hang on that.
    pub(crate) fn latency(&self, period: Fine) -> Fine {
        let periods = self
            .depth
            .saturating_add(period.saturating_sub(period / 16))
            .saturating_sub(1)
            .checked_div(period)
            .unwrap_or(1)
            .saturating_add(1);
        periods.saturating_mul(period).saturating_sub(self.lead)
    }
}

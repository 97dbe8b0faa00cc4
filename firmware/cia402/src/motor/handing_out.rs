//! When pulses are handed out, and how many.

use motion::{AdvanceError, PulseSink, Ramps};

use super::Motor;
use super::directed::Directed;

impl Motor {
    /// A motion with these ramps is to be planned in place of the one under way, which may take the processor long: hands out pulses up to
    /// the commit horizon first. What begins in this tick begins behind them. See [`Axis::prepare`](motion::Axis::prepare).
    pub(crate) fn prepare(&mut self, ramps: Ramps, mut pulses: &mut dyn PulseSink) {
        if self.at_rest {
            return;
        }
        let mut pulses = Directed {
            pulses: &mut pulses,
            is_reversed: self.is_reversed,
        };
        let result = self.axis.prepare(ramps, &mut pulses);
        self.is_late |= result == Err(AdvanceError::Underrun);
        self.committed = self.near(self.axis.committed_position());
    }

    /// The orders of this regular tick have been given: what the ones before have left to be planned is. See
    /// [`Axis::plan_on`](motion::Axis::plan_on).
    pub(crate) fn plan_on<S: PulseSink>(&mut self, pulses: &mut S) {
        let result = self.axis.plan_on(&mut Directed {
            pulses,
            is_reversed: self.is_reversed,
        });
        self.is_late |= result == Err(AdvanceError::Underrun);
    }

    /// Hands out the pulses of the next segments.
    pub(crate) fn advance<S: PulseSink>(&mut self, pulses: &mut S) {
        let result = self.axis.advance(&mut Directed {
            pulses,
            is_reversed: self.is_reversed,
        });
        self.committed = self.near(self.axis.committed_position());
        self.at_rest = self.axis.is_at_rest();
        if self.at_rest {
            self.stopped();
            self.planned_with(0);
            self.stopping_at_limit = None;
        }
        self.is_late |= result == Err(AdvanceError::Underrun);
    }

    /// Whether pulses came too late since the last call, and the motor had none for a moment. All of them are sent, but it may not have
    /// followed.
    pub(crate) const fn take_late(&mut self) -> bool {
        core::mem::replace(&mut self.is_late, false)
    }

    /// Whether a tick that plans may make a pause, with so few pulses left. See [`Axis::runs_short`](motion::Axis::runs_short).
    pub(crate) fn runs_short<S: PulseSink>(&self, pulses: &S) -> bool {
        self.axis.runs_short(pulses.pending())
    }
}

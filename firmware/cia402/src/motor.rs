//! The axis as the drive uses it: it moves, stops on a ramp, or is cut off, and always knows where it is.

use motion::{AdvanceError, Axis, AxisConfig, Demand, Limits, PlanError, PulseSink};

/// An axis, and what has become of its pulses.
#[derive(Debug)]
pub(crate) struct Motor {
    axis: Axis,
    /// Nothing is planned, and every pulse has been handed out.
    at_rest: bool,
    /// At rest, and every pulse had left at the start of this tick.
    standstill: bool,
    /// What was being played at the start of this tick.
    demand: Demand,
    /// Pulses have been cut off: the axis does not know where the motor is until it is told.
    cut: bool,
}

impl Motor {
    /// A motor that stands at position 0.
    pub(crate) fn new(config: AxisConfig) -> Self {
        Self {
            axis: Axis::new(config),
            at_rest: true,
            standstill: true,
            demand: Demand::default(),
            cut: false,
        }
    }

    /// Looks at the motor at the start of a tick. `position` is where it really is; the axis takes it over while the motor
    /// has no power, and after its pulses have been cut off.
    pub(crate) fn observe<S: PulseSink>(&mut self, position: i64, power: bool, pulses: &S) {
        if self.cut || !power && self.is_displaced(position) {
            self.axis.set_position(position);
            self.cut = false;
        }
        let pending = pulses.pending();
        self.standstill = self.at_rest && pending == 0;
        self.demand = self.axis.demand(pending);
    }

    /// Whether the pulses handed out so far lead to another position than this one (in steps, modulo 2³²).
    pub(crate) fn is_displaced(&self, position: i64) -> bool {
        self.axis.committed_position() != i64::from(position as i32)
    }

    /// Whether the motor stood still at the start of this tick: nothing planned, and every pulse has left.
    pub(crate) const fn standstill(&self) -> bool {
        self.standstill
    }

    /// Whether the motor has nothing left to do at the end of this tick.
    pub(crate) fn is_settled<S: PulseSink>(&self, pulses: &S) -> bool {
        self.at_rest && pulses.pending() == 0
    }

    /// What was being played at the start of this tick.
    pub(crate) const fn demand(&self) -> Demand {
        self.demand
    }

    /// Where the present motion ends, in steps; at rest, where the motor stands.
    pub(crate) fn destination(&self) -> i64 {
        self.axis.target()
    }

    /// The fastest the pulses can be sent, in steps/s.
    pub(crate) fn max_velocity(&self) -> u32 {
        self.axis.max_velocity()
    }

    /// Moves to a position, from whatever the motor does now. On an error nothing changes.
    pub(crate) fn move_to(&mut self, target: i64, limits: Limits) -> Result<(), PlanError> {
        self.axis.move_to(target, limits)
    }

    /// Moves through a position with an end velocity in steps/s and keeps that. On an error nothing changes.
    pub(crate) fn move_through(
        &mut self,
        target: i64,
        end_velocity: u32,
        limits: Limits,
    ) -> Result<(), PlanError> {
        self.axis.move_through(target, end_velocity, limits)
    }

    /// The position from which the next command begins, in steps.
    pub(crate) fn committed_position(&self) -> i64 {
        self.axis.committed_position()
    }

    /// Ramps to a velocity in steps/s and keeps it, from whatever the motor does now. On an error nothing changes.
    pub(crate) fn ramp_to(&mut self, velocity: i32, limits: Limits) -> Result<(), PlanError> {
        self.axis.ramp_to(velocity, limits)
    }

    /// The velocity from which the next command begins, in steps/s.
    pub(crate) fn committed_velocity(&self) -> i32 {
        self.axis.committed_velocity()
    }

    /// Whether the motor is on the last ramp of its motion, or has come to rest.
    pub(crate) fn is_ending(&self) -> bool {
        self.axis.is_ending()
    }

    /// Slows down to a standstill. A deceleration that gives no ramp, such as 0, stops the pulses at once: a drive that is
    /// told to stop never goes on.
    pub(crate) fn stop(&mut self, deceleration: u32) {
        if self.axis.stop(deceleration).is_err() {
            self.cut_off();
        }
    }

    /// Drops every pulse that has not left yet. The board does so at the end of the tick.
    pub(crate) fn cut_off(&mut self) {
        self.axis.abort();
        self.at_rest = true;
        self.cut = true;
    }

    /// Whether pulses were cut off in this tick.
    pub(crate) const fn is_cut(&self) -> bool {
        self.cut
    }

    /// Hands out the pulses of the next segments. False when they came too late and the motor had none for a moment; no
    /// pulse is lost by that.
    pub(crate) fn advance<S: PulseSink>(&mut self, pulses: &mut S) -> bool {
        let result = self.axis.advance(pulses);
        self.at_rest = self.axis.is_at_rest();
        result != Err(AdvanceError::Underrun)
    }
}

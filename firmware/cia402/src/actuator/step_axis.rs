//! The step axis: demands become pulses, which are committed a little ahead of the time they are sent.

mod directed;

use motion::{
    AdvanceError, Axis, AxisConfig, Demand, Direction, FollowError, Limits, PlanError, Position,
    PulseSink, Ramps, SignedSpeed, Speed, Ticks, Velocity,
};

use super::{Actuator, CourseEnd, Refused, near};
use crate::cyclic::{Fine, Timescale};
use crate::pulse_timing::PulseTiming;

pub(crate) use directed::Directed;

/// An axis, and what has become of its pulses.
#[derive(Debug)]
pub(crate) struct StepAxis {
    axis: Axis,
    built: AxisConfig,
    /// What the driver of the motor needs.
    timing: PulseTiming,
    /// Where the committed pulses lead. The axis counts modulo 2³²; this goes on.
    committed: i64,
    at_rest: bool,
    standstill: bool,
    demand: Demand,
    /// The tick of the axis' time at the start of this tick.
    played: Ticks,
    /// The axis' time in comparison with that of the control tick.
    timescale: Timescale,
    /// Pulses came too late, and nobody has asked for it yet.
    is_late: bool,
    /// The planner or the axis has failed, and nobody has asked for it yet.
    is_broken: bool,
}

impl StepAxis {
    /// An axis that stands at position 0.
    #[inline(never)]
    pub(crate) fn new(config: AxisConfig) -> Self {
        Self {
            built: config,
            timing: PulseTiming::AsBuilt,
            committed: 0,
            at_rest: true,
            standstill: true,
            demand: Demand::default(),
            played: 0,
            timescale: Timescale::new(config.clock.hz()),
            is_late: false,
            is_broken: false,
            // Last, as it is large: so it is made where it stays.
            axis: Axis::new(config),
        }
    }

    /// What the driver of the motor needs. The motor has no power and stands.
    pub(crate) fn set_timing(&mut self, timing: PulseTiming) {
        if timing != self.timing {
            self.timing = timing;
            let ticks = timing.in_ticks(self.built.clock, self.built.timing);
            self.axis.set_timing(ticks);
        }
    }

    /// Looks at what has become of the pulses, at the start of a tick: so many ticks of them are still to be sent.
    pub(crate) fn observe(&mut self, pending: Ticks) {
        self.look_again(pending);
        self.demand = self.demand_of(pending);
        self.played = self.axis.played(pending);
    }

    /// The same at the end of a tick, for whether the motor stands.
    pub(crate) fn look_again(&mut self, pending: Ticks) {
        self.standstill = self.at_rest && pending == 0;
    }

    /// The tick that has just observed runs at `now`: what is followed goes by that.
    pub(crate) fn set_time(&mut self, now: Fine) {
        if self.at_rest {
            self.timescale.stop();
        }
        self.timescale.compare(now, self.played);
    }

    /// Commits the pulses of the next segments.
    pub(crate) fn advance(&mut self, pulses: &mut impl PulseSink) {
        let result = self.axis.advance(pulses);
        self.look_at(result);
        self.committed = near(self.axis.committed_position(), self.committed);
        self.at_rest = self.axis.is_at_rest();
    }

    /// After either the motor may not be where the pulses say.
    pub(crate) fn look_at(&mut self, result: Result<(), AdvanceError>) {
        self.is_late |= result == Err(AdvanceError::Underrun);
        self.is_broken |= result == Err(AdvanceError::Internal);
    }

    /// Whether pulses came too late since the last call, and the motor had none for a moment. All of them are sent, but it may not have
    /// followed.
    pub(crate) const fn take_late(&mut self) -> bool {
        core::mem::replace(&mut self.is_late, false)
    }

    /// Whether the planner or the axis has failed since the last call, which cannot be: pulses may be
    /// missing, and where the motor goes is not known.
    pub(crate) const fn take_broken(&mut self) -> bool {
        core::mem::replace(&mut self.is_broken, false)
    }

    fn planned(&mut self, result: Result<(), PlanError>) -> Result<(), Refused> {
        self.is_broken |= result == Err(PlanError::Internal);
        result.map_err(|_| Refused)
    }

    /// Whether a tick that plans may make a pause, with so few pulses left. See [`Axis::runs_short`].
    pub(crate) fn runs_short(&self, pulses: &impl PulseSink) -> bool {
        self.axis.runs_short(pulses.pending())
    }

    fn demand_of(&self, pending: Ticks) -> Demand {
        let demand = self.axis.demand(pending);
        Demand {
            position: near(demand.position, self.committed),
            ..demand
        }
    }

    /// The position in the count of the axis. One that is too far away stays so.
    fn on_axis(&self, target: i64) -> i64 {
        let distance = target.saturating_sub(self.committed);
        self.axis.committed_position().saturating_add(distance)
    }
}

impl Actuator for StepAxis {
    fn demand(&self) -> Demand {
        self.demand
    }

    fn standstill(&self) -> bool {
        self.standstill
    }

    fn is_at_rest(&self) -> bool {
        self.at_rest
    }

    fn committed_position(&self) -> i64 {
        self.committed
    }

    fn committed_velocity(&self) -> SignedSpeed {
        self.axis.committed_velocity()
    }

    fn destination(&self) -> i64 {
        near(self.axis.target(), self.committed)
    }

    fn heading(&self) -> Option<Direction> {
        self.axis.heading()
    }

    fn is_ending(&self) -> bool {
        self.axis.is_ending()
    }

    fn max_velocity(&self) -> Speed {
        self.axis.max_velocity()
    }

    fn window(&self) -> u64 {
        let ticks = u64::from(self.axis.window()).wrapping_mul(1_000_000);
        let microseconds = ticks.checked_div(self.built.clock.hz().into());
        microseconds.map_or(0, |whole| whole.saturating_add(1))
    }

    fn move_to(&mut self, target: i64, limits: Limits, ramps: Ramps) -> Result<(), Refused> {
        let target = self.on_axis(target);
        self.axis.set_ramps(ramps);
        let result = self.axis.move_to(target, limits);
        self.planned(result)
    }

    fn move_through(
        &mut self,
        target: i64,
        end_velocity: Speed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused> {
        let target = self.on_axis(target);
        self.axis.set_ramps(ramps);
        let result = self.axis.move_through(target, end_velocity, limits);
        self.planned(result)
    }

    fn ramp_to(
        &mut self,
        velocity: SignedSpeed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused> {
        self.axis.set_ramps(ramps);
        let result = self.axis.ramp_to(velocity, limits);
        self.planned(result)
    }

    fn stop(&mut self, deceleration: u32, ramps: Ramps) -> Result<(), Refused> {
        self.axis.set_ramps(ramps);
        let result = self.axis.stop(deceleration);
        self.planned(result)
    }

    fn stop_preview(&self, deceleration: u32, ramps: Ramps, leaves: bool) -> i64 {
        let rest = self.axis.stop_preview(deceleration, ramps, leaves);
        rest.map_or(self.committed, |rest| near(rest, self.committed))
    }

    fn cut_off(&mut self) {
        self.axis.abort();
        self.at_rest = true;
    }

    fn stand_at(&mut self, position: i64) {
        self.axis.set_position(position);
        self.committed = position;
        self.demand = self.demand_of(0);
    }

    fn follow(
        &mut self,
        end: Fine,
        to: Position,
        velocity: Option<(Position, Fine)>,
    ) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        match velocity {
            None => self.axis.follow(tick, to),
            Some((distance, time)) => {
                let ticks = self.timescale.ticks(time);
                let velocity = Velocity::over(distance, ticks);
                self.axis.follow_smoothly(tick, to, velocity)
            }
        }
    }

    fn follow_velocity(&mut self, end: Fine, velocity: SignedSpeed) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        self.axis.follow_velocity(tick, velocity)
    }

    fn course_end(&self) -> Demand {
        let end = self.axis.course_end_demand();
        Demand {
            position: near(end.position, self.committed),
            ..end
        }
    }

    fn course_to(&self, end: Fine) -> CourseEnd {
        let (tick, state) = self.axis.course_end();
        let left = self.timescale.tick_at(end).wrapping_sub(tick);
        let left = u32::try_from(left.cast_signed().max(0)).unwrap_or(u32::MAX);
        CourseEnd {
            left: self.timescale.span(left),
            position: state.position,
            distance: state.velocity.way(left),
        }
    }

    fn is_following(&self) -> bool {
        !self.at_rest && self.axis.is_following()
    }

    fn is_running_out(&self, time: Fine) -> bool {
        let ticks = self.timescale.ticks(time);
        self.axis.is_running_out(ticks.into())
    }

    fn expect_acceleration(&mut self, acceleration: u32) {
        self.axis.expect_acceleration(acceleration);
    }
}

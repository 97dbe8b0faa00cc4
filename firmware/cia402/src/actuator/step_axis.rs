//! The step axis: demands become pulses, which are committed a little ahead of the time they are sent.

mod directed;

use motion::{
    AdvanceError, Axis, AxisConfig, Demand, Direction, FollowError, Limits, PlanError, Position,
    PulseSink, Ramps, SignedSpeed, Speed, Ticks, Velocity,
};

use super::{Actuator, AtPort, CourseEnd, NotSupported, Refused, TORQUE_MODES, Trouble, near};
use crate::configuration::Configuration;
use crate::cyclic::{Fine, POINT, Timescale};
use crate::pulse_timing::PulseTiming;

use directed::Directed;

/// An axis, and what has become of its pulses.
#[derive(Debug)]
pub struct StepAxis {
    axis: Axis,
    built: AxisConfig,
    /// What the driver of the motor needs.
    timing: PulseTiming,
    /// Where the committed pulses lead. The axis counts modulo 2³²; this goes on.
    committed: i64,
    at_rest: bool,
    standstill: bool,
    demand: Demand,
    /// The axis' time in comparison with that of the control tick.
    timescale: Timescale,
    /// Late are pulses, and all of them are sent; broken are planner or axis, and some may be missing.
    trouble: Trouble,
}

impl StepAxis {
    /// An axis that stands at position 0.
    #[inline(never)]
    pub fn new(config: AxisConfig) -> Self {
        Self {
            built: config,
            timing: PulseTiming::AsBuilt,
            committed: 0,
            at_rest: true,
            standstill: true,
            demand: Demand::default(),
            timescale: Timescale::new(config.clock.hz()),
            trouble: Trouble::default(),
            // Last, as it is large: so it is made where it stays.
            axis: Axis::new(config),
        }
    }

    /// How long ahead of the motor an axis commits its pulses: two segments.
    pub(crate) fn lead(config: &AxisConfig) -> Fine {
        let hz = u64::from(config.clock.hz());
        let ahead = u64::from(config.segment).saturating_mul(2_000_000) << POINT;
        ahead.checked_div(hz).unwrap_or(0)
    }

    /// After either the motor may not be where the pulses say.
    pub(crate) fn look_at(&mut self, result: Result<(), AdvanceError>) {
        self.trouble.is_late |= result == Err(AdvanceError::Underrun);
        self.trouble.is_broken |= result == Err(AdvanceError::Internal);
    }

    fn planned(&mut self, result: Result<(), PlanError>) -> Result<(), Refused> {
        self.trouble.is_broken |= result == Err(PlanError::Internal);
        result.map_err(|_| Refused)
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

impl<S: PulseSink> AtPort<S> for StepAxis {
    /// Nothing measures the current.
    const MODES: u32 = !TORQUE_MODES;

    fn set_up(&mut self, configuration: &Configuration) {
        let timing = configuration.pulse_timing;
        if timing != self.timing {
            self.timing = timing;
            let ticks = timing.in_ticks(self.built.clock, self.built.timing);
            self.axis.set_timing(ticks);
        }
    }

    fn observe(&mut self, now: Fine, pulses: &S) {
        let pending = pulses.pending();
        self.standstill = self.at_rest && pending == 0;
        self.demand = self.demand_of(pending);
        if self.at_rest {
            self.timescale.stop();
        }
        self.timescale.compare(now, self.axis.played(pending));
    }

    fn look_again(&mut self, pulses: &S) {
        self.standstill = self.at_rest && pulses.pending() == 0;
    }

    fn advance(&mut self, pulses: &mut S, is_reversed: bool) {
        let mut directed = Directed {
            pulses,
            is_reversed,
        };
        let result = self.axis.advance(&mut directed);
        self.look_at(result);
        self.committed = near(self.axis.committed_position(), self.committed);
        self.at_rest = self.axis.is_at_rest();
    }

    fn runs_short(&self, pulses: &S) -> bool {
        self.axis.runs_short(pulses.pending())
    }
}

impl Actuator for StepAxis {
    fn torque(&self) -> Option<i16> {
        None
    }

    fn take_trouble(&mut self) -> Trouble {
        core::mem::take(&mut self.trouble)
    }

    fn hold_torque(&mut self, _: i16) -> Result<(), NotSupported> {
        Err(NotSupported)
    }

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
            distance: state.velocity.distance(left),
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

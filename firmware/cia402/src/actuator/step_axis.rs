//! The step axis: demands become pulses, which are committed a little ahead of the time they are sent.

mod directed;
mod emitter;

use core::cell::Cell;

use motion::{
    Axis, AxisConfig, Demand, Direction, FollowError, Goal, Limits, Plan, PlanError, Position,
    PulseSink, Ramps, Reference, SignedSpeed, Speed, Ticks, Velocity,
};

use super::{
    Actuator, ActuatorErrors, AtPort, NotSupported, PathEnd, Refused, TORQUE_MODES, unwrapped,
};
use crate::board::{DriveConfig, outlast_tick};
use crate::configuration::Configuration;
use crate::cyclic::{MicrosQ16, POINT, Timescale};
use crate::pulse_timing::PulseTiming;

pub use emitter::{Emitter, EmitterLock};

/// An axis behind the lock `L`, and what has become of its pulses.
#[derive(Debug)]
pub struct StepAxis<L = Emitter> {
    built: AxisConfig,
    /// What the driver of the motor needs.
    timing: PulseTiming,
    /// Where the committed pulses lead, as of the start of the tick or its end. The axis counts modulo 2³²; this goes on.
    committed: i64,
    at_rest: bool,
    standstill: bool,
    demand: Demand,
    /// The axis' time in comparison with that of the control tick.
    timescale: Timescale,
    /// From which tick on the next set-point was asked about in this control tick.
    path_begin: Cell<Ticks>,
    /// A planner has failed.
    is_broken: bool,
    /// Refills come between the ticks, and commit the pulses of a motor that moves.
    is_refilled: bool,
    /// There is something to do since the last commitment of a tick.
    is_ordered: bool,
    emitter: L,
}

impl<L: EmitterLock> StepAxis<L> {
    /// With an emitter that stands at position 0.
    #[inline(never)]
    pub fn new(config: DriveConfig, emitter: impl FnOnce() -> L) -> Self {
        let built = outlast_tick(config);
        Self {
            built,
            timing: PulseTiming::AsBuilt,
            committed: 0,
            at_rest: true,
            standstill: true,
            demand: Demand::default(),
            timescale: Timescale::new(built.clock.hz()),
            path_begin: Cell::new(Ticks::MAX),
            is_broken: false,
            is_refilled: config.refills > 1,
            is_ordered: false,
            // Last, as it is large: so it is made where it stays.
            emitter: emitter(),
        }
    }

    /// How long ahead of the motor an axis commits its pulses: two time slices.
    pub(crate) fn commit_ahead(config: DriveConfig) -> MicrosQ16 {
        let axis = outlast_tick(config);
        let hz = u64::from(axis.clock.hz());
        let ahead = u64::from(axis.time_slice).saturating_mul(2_000_000) << POINT;
        ahead.checked_div(hz).unwrap_or(0)
    }

    /// Where the motor is to be while the port still has so many ticks to play, in the count that goes on.
    pub(super) fn reference(&self, pending: Ticks) -> Reference {
        self.emitter.look(|emitter| emitter.axis.reference(pending))
    }

    /// Goes on from where something else has moved the motor to, with the velocity that it has.
    pub(super) fn take_up(&mut self, position: i64, velocity: SignedSpeed) {
        self.committed = position;
        let (demand, at_rest) = self.emitter.lock(|emitter| {
            emitter.axis.take_up(position, velocity);
            (emitter.axis.demand(0), emitter.axis.is_at_rest())
        });
        self.demand = self.counted(demand);
        self.at_rest = at_rest;
        self.standstill = at_rest;
    }

    /// For a test: what a refill has found.
    #[cfg(test)]
    pub(crate) fn look_at(&mut self, result: Result<(), motion::AdvanceError>) {
        self.emitter.lock(|emitter| emitter.look_at(result));
    }

    /// The same position in the count that goes on.
    fn counted(&self, demand: Demand) -> Demand {
        Demand {
            position: unwrapped(demand.position, self.committed),
            ..demand
        }
    }

    /// Follows a set-point, unless a refill has gone beyond where it was to begin.
    fn go_on(
        &mut self,
        follow: impl FnOnce(&mut Axis) -> Result<(), FollowError>,
    ) -> Result<(), FollowError> {
        let begin = self.path_begin.get();
        self.is_ordered = true;
        self.emitter.lock(|emitter| {
            if emitter.axis.begins_beyond(begin) {
                return Err(FollowError::TooLate);
            }
            follow(&mut emitter.axis)
        })
    }

    /// Plans a motion while the one before is played, and goes on with it. A target that is too far away stays so.
    fn plan(&mut self, goal: Goal, limits: Limits, ramps: Ramps) -> Result<(), Refused> {
        self.is_ordered = true;
        let mut result = self.plan_ahead(goal, limits, ramps);
        if result == Ok(false) {
            // A refill was in between; so the next one is far, and can wait for a plan.
            result = self.plan_anew(goal, limits, ramps);
        }
        self.is_broken |= result == Err(PlanError::Internal);
        result.map(|_| ()).map_err(|_| Refused)
    }

    /// Makes a plan from the commit horizon on. Returns false if a refill has moved the horizon meanwhile.
    // Out of line, as the next one is: only one of the two has a plan on the stack.
    #[inline(never)]
    fn plan_ahead(&mut self, goal: Goal, limits: Limits, ramps: Ramps) -> Result<bool, PlanError> {
        let mut draft = self.emitter.look(|emitter| emitter.axis.draft(ramps));
        let goal = seen_from(goal, draft.committed_position(), self.committed);
        let mut plan = Plan::at_rest(0, 0);
        draft.plan(&mut plan, goal, limits)?;
        Ok(self
            .emitter
            .lock(|emitter| emitter.axis.install(&draft, &plan)))
    }

    /// [`Self::plan`] of a move with a start speed.
    #[inline(never)]
    fn plan_from_start_speed(
        &mut self,
        (target, speed): (i64, Speed),
        limits: Limits,
        ramps: Ramps,
    ) -> Result<bool, PlanError> {
        let committed = self.committed;
        let mut draft = self.emitter.look(|emitter| emitter.axis.draft(ramps));
        let shift = |here: i64| here.wrapping_sub(unwrapped(here, committed));
        let seen = target.saturating_add(shift(draft.committed_position()));
        let mut plan = Plan::at_rest(0, 0);
        draft.plan_from_start_speed(&mut plan, (seen, speed), limits)?;
        self.emitter.lock(|emitter| {
            if emitter.axis.install(&draft, &plan) {
                return Ok(true);
            }
            let seen = target.saturating_add(shift(emitter.axis.committed_position()));
            let goal = (seen, speed);
            emitter
                .axis
                .order_from_start_speed(goal, limits, ramps)
                .map(|()| true)
        })
    }

    /// Makes a plan with the emitter held, so that no refill comes.
    #[cold]
    #[inline(never)]
    fn plan_anew(&mut self, goal: Goal, limits: Limits, ramps: Ramps) -> Result<bool, PlanError> {
        let committed = self.committed;
        self.emitter.lock(|emitter| {
            let goal = seen_from(goal, emitter.axis.committed_position(), committed);
            emitter.axis.order(goal, limits, ramps).map(|()| true)
        })
    }
}

/// A goal as the axis counts, which stands at `here` where the drive counts `committed`.
fn seen_from(goal: Goal, here: i64, committed: i64) -> Goal {
    goal.shifted(here.wrapping_sub(unwrapped(here, committed)))
}

impl<L: EmitterLock, S: PulseSink> AtPort<S> for StepAxis<L> {
    /// Nothing measures the current.
    fn set_up(&mut self, configuration: &Configuration) {
        let timing = configuration.pulse_timing;
        if timing != self.timing {
            self.timing = timing;
            let ticks = timing.in_ticks(self.built.clock, self.built.timing);
            self.emitter.lock(|emitter| emitter.axis.set_timing(ticks));
        }
    }

    fn observe(&mut self, now: MicrosQ16, pulses: &S) {
        self.path_begin.set(Ticks::MAX);
        let (pending, played, demand) = self.emitter.look(|emitter| {
            let (pending, axis) = (pulses.pending(), &emitter.axis);
            self.committed = unwrapped(axis.committed_position(), self.committed);
            self.at_rest = axis.is_at_rest();
            let played = axis.played(pending);
            (pending, played, axis.demand_at(played))
        });
        self.standstill = self.at_rest && pending == 0;
        self.demand = self.counted(demand);
        if self.at_rest {
            self.timescale.stop();
        }
        self.timescale.compare(now, played);
    }

    fn look_again(&mut self, pulses: &S) {
        self.standstill = self.at_rest && pulses.pending() == 0;
    }

    fn advance(&mut self, pulses: &mut S, is_reversed: bool) {
        let begins = core::mem::take(&mut self.is_ordered) && self.at_rest;
        if self.is_refilled && !begins {
            // The next refill is near enough. A motor that stands need not wait for it.
            return;
        }
        self.emitter.lock(|emitter| {
            emitter.is_reversed = is_reversed;
            emitter.refill(pulses);
            self.committed = unwrapped(emitter.axis.committed_position(), self.committed);
            self.at_rest = emitter.axis.is_at_rest();
        });
    }

    fn refill(&mut self, pulses: &mut S) {
        self.emitter.lock(|emitter| emitter.refill(pulses));
    }
}

impl<L: EmitterLock> Actuator for StepAxis<L> {
    const MODES: u32 = !TORQUE_MODES;

    fn take_errors(&mut self) -> ActuatorErrors {
        let mut errors = self.emitter.lock(Emitter::take_errors);
        errors.is_broken |= core::mem::take(&mut self.is_broken);
        errors
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
        self.emitter
            .look(|emitter| emitter.axis.committed_velocity())
    }

    fn destination(&self) -> i64 {
        let target = self.emitter.look(|emitter| emitter.axis.target());
        unwrapped(target, self.committed)
    }

    fn heading(&self) -> Option<Direction> {
        self.emitter.look(|emitter| emitter.axis.heading())
    }

    fn is_ending(&self) -> bool {
        self.emitter.look(|emitter| emitter.axis.is_ending())
    }

    fn max_velocity(&self) -> Speed {
        self.emitter.look(|emitter| emitter.axis.max_velocity())
    }

    fn window(&self) -> u64 {
        let window = self.emitter.look(|emitter| emitter.axis.window());
        let ticks = u64::from(window).wrapping_mul(1_000_000);
        let microseconds = ticks.checked_div(self.built.clock.hz().into());
        microseconds.map_or(0, |whole| whole.saturating_add(1))
    }

    fn move_to(&mut self, target: i64, limits: Limits, ramps: Ramps) -> Result<(), Refused> {
        self.plan(Goal::Rest(target), limits, ramps)
    }

    fn move_from_start_speed(
        &mut self,
        target: i64,
        start_speed: Speed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused> {
        self.is_ordered = true;
        let result = self.plan_from_start_speed((target, start_speed), limits, ramps);
        self.is_broken |= result == Err(PlanError::Internal);
        result.map(|_| ()).map_err(|_| Refused)
    }

    fn move_through(
        &mut self,
        target: i64,
        end_velocity: Speed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused> {
        self.plan(Goal::Pass(target, end_velocity), limits, ramps)
    }

    fn ramp_to(
        &mut self,
        velocity: SignedSpeed,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), Refused> {
        self.plan(Goal::Velocity(velocity), limits, ramps)
    }

    fn stop(&mut self, deceleration: u32, ramps: Ramps) -> Result<(), Refused> {
        let (goal, limits) = Goal::stop(deceleration);
        self.plan(goal, limits, ramps)
    }

    fn stop_preview(&self, deceleration: u32, ramps: Ramps, leaves: Option<&Limits>) -> i64 {
        let mut draft = self.emitter.look(|emitter| emitter.axis.draft(ramps));
        let rest = draft.stop_preview(deceleration, leaves);
        rest.map_or(self.committed, |rest| unwrapped(rest, self.committed))
    }

    fn cut_off(&mut self) {
        self.emitter.lock(|emitter| emitter.axis.abort());
        self.at_rest = true;
    }

    fn stand_at(&mut self, position: i64) {
        self.committed = position;
        let demand = self.emitter.lock(|emitter| {
            emitter.axis.set_position(position);
            emitter.axis.demand(0)
        });
        self.demand = self.counted(demand);
    }

    fn follow(&mut self, end: MicrosQ16, to: Position) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        self.go_on(|axis| axis.follow(tick, to))
    }

    fn follow_smoothly(
        &mut self,
        end: MicrosQ16,
        to: Position,
        (distance, time): (Position, MicrosQ16),
    ) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        let ticks = self.timescale.ticks(time);
        let velocity = Velocity::over(distance, ticks);
        self.go_on(|axis| axis.follow_smoothly(tick, to, velocity))
    }

    fn follow_velocity(
        &mut self,
        end: MicrosQ16,
        velocity: SignedSpeed,
    ) -> Result<(), FollowError> {
        let tick = self.timescale.tick_at(end);
        self.go_on(|axis| axis.follow_velocity(tick, velocity))
    }

    fn path_end(&self) -> Demand {
        let end = self.emitter.look(|emitter| emitter.axis.path_end_demand());
        self.counted(end)
    }

    fn path_to(&self, end: MicrosQ16) -> PathEnd {
        let (tick, state) = self.emitter.look(|emitter| emitter.axis.path_end());
        self.path_begin.set(tick);
        let left = self.timescale.tick_at(end).wrapping_sub(tick);
        let left = u32::try_from(left.cast_signed().max(0)).unwrap_or(u32::MAX);
        PathEnd {
            left: self.timescale.span(left),
            position: state.position,
            distance: state.velocity.distance(left),
        }
    }

    fn is_following(&self) -> bool {
        !self.at_rest && self.emitter.look(|emitter| emitter.axis.is_following())
    }

    fn is_running_out(&self, time: MicrosQ16) -> bool {
        let ticks = self.timescale.ticks(time);
        self.emitter
            .look(|emitter| emitter.axis.is_running_out(ticks.into()))
    }

    fn expect_acceleration(&mut self, acceleration: u32) {
        self.emitter
            .lock(|emitter| emitter.axis.expect_acceleration(acceleration));
    }
}

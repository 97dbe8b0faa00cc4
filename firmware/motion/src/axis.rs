//! An axis: one plan at a time, and the pulses that follow it.
//!
//! The axis keeps a time of its own, in ticks of the step timer, which runs while it moves. Up to the *commit horizon* the
//! plan has become records; these are sent and stay. A new command plans from the state at the horizon, which is at most some three
//! time slices ahead of the motor, so it takes effect there, whatever the axis was doing.
//!
//! In place of a plan the axis can follow a path of set-points ([`Axis::follow`]), each with its tick of that time: on that tick it
//! is exactly there. Any other order ends the path and begins where it has led to.
//!
//! Every pulse is accounted for: [`Axis::committed_position`] is always the sum of the pulses committed to the sink.

mod draft;
mod following;
mod reference;
mod trace;

use crate::average::{Average, Mean};
use crate::clock::{Clock, Ticks};
use crate::fixed::{Exact, State, Velocity};
use crate::low;
use crate::path::Path;
use crate::plan::{Goal, Limits, Plan, PlanError, Ramps};
use crate::record::{Direction, DriverTiming, PulseSink};
use crate::speed::{SignedSpeed, Speed};
use crate::stepper::polynomial::Polynomial;
use crate::stepper::{CHORDS_PER_SLICE, Stepper};
pub use draft::Draft;
pub use reference::Reference;
use trace::Trace;

/// Chords that [`Axis::advance`] makes at most: those of four time slices, and one for each polynomial of the shortest.
const MOST_CHORDS: u32 = 4 * CHORDS_PER_SLICE + 32;

/// What an axis is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisConfig {
    /// The step timer's clock.
    pub clock: Clock,
    /// Ticks per time slice, for example a quarter of a millisecond; two of them must outlast a control tick. Short time slices are
    /// brought up to what `timing` needs, long ones cut to 2²⁸.
    pub time_slice: u32,
    /// What the stepper driver needs.
    pub timing: DriverTiming,
}

/// Where the plan wants the motor to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Demand {
    /// Position demand value (6062h) in whole steps, −2³¹ ..= 2³¹−1.
    pub position: i64,
    /// Velocity demand value (606Bh).
    pub velocity: SignedSpeed,
}

/// Why [`Axis::advance`] has something to report. Nothing is lost but where it says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdvanceError {
    /// The sink took no more before two time slices were committed. The rest is offered at the next call.
    SinkFull,
    /// The sink had nothing left to play while the axis was moving: the pulses went on late, with a pause.
    Underrun,
    /// A bound that the axis keeps by construction was reached: pulses may be missing, and it is not known where the motor is.
    Internal,
}

impl core::fmt::Display for AdvanceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::SinkFull => "pulse sink is full",
            Self::Underrun => "pulse sink ran empty in motion",
            Self::Internal => "internal fault of the axis",
        })
    }
}

impl core::error::Error for AdvanceError {}

/// A stepper axis.
///
/// The fields lie in memory in this order: first what a refill uses, last what is large, so that one instruction reaches each.
#[derive(Debug, Clone)]
#[repr(C)]
pub struct Axis {
    /// Up to here records have been committed.
    committed: Ticks,
    /// The sum of the committed pulses, modulo 2³².
    steps: i32,
    /// Whether records of the present motion have been committed.
    moving: bool,
    is_averaged: bool,
    /// The time slice as it was configured; the driver may need a longer one.
    time_slice: u32,
    stepper: Stepper,
    clock: Clock,
    /// How the velocity changes in what is planned from now on.
    ramps: Ramps,
    /// The jerk for which the window of the mean was chosen, or that of harder ramps since, in steps/s³.
    mean_jerk: u32,
    /// The acceleration of the last order that had one, in steps/s²: the motion behind a stop is expected to have it.
    acceleration: u32,
    /// The remainder below 2⁻³² steps of the last distance of [`Axis::follow_velocity`], in units of 2⁻⁵⁶ steps.
    carry: u32,
    trace: Trace,
    plan: Plan,
    /// The set-points that are followed; in their place the plan stands still.
    path: Option<Path>,
    /// The mean of the plan, if it is that which is followed.
    average: Average,
}

impl Axis {
    /// An axis that stands at 0.
    // Out of line, and what is large last: so it is made where it stays, and not on the stack.
    #[inline(never)]
    pub fn new(config: AxisConfig) -> Self {
        Self {
            clock: config.clock,
            plan: Plan::at_rest(0, 0),
            ramps: Ramps::Linear,
            path: None,
            is_averaged: false,
            mean_jerk: 0,
            acceleration: 0,
            carry: 0,
            stepper: Stepper::new(config.timing, config.time_slice, 0, 0),
            time_slice: config.time_slice,
            committed: 0,
            steps: 0,
            moving: false,
            trace: Trace::new(),
            average: Average::new(),
        }
    }

    /// An axis that begins with `plan`, at its first tick: in motion, or standing somewhere.
    pub fn on_plan(config: AxisConfig, plan: Plan) -> Self {
        let mut axis = Self::new(config);
        let begin = plan.start();
        axis.committed = begin;
        axis.set_position(plan.state_at(begin).position.whole_steps());
        axis.plan = plan;
        axis
    }

    /// Says how the velocity is to change (6086h, 60A4h), from the next command on; linear ramps before.
    pub const fn set_ramps(&mut self, ramps: Ramps) {
        self.ramps = ramps;
    }

    /// Says with which acceleration, in steps/s², the motion may go on behind the next stop: a stop on a moving average is as long as that takes.
    /// That of the last order if nothing is said.
    pub const fn expect_acceleration(&mut self, acceleration: u32) {
        self.acceleration = acceleration;
    }

    /// Moves to the absolute position `target`, in whole steps. At any moment and from any velocity. A target beyond −2³¹ ..= 2³¹−1 lies
    /// behind the end of that span, where positions wrap: it is as far from [`Axis::committed_position`] as the numbers say, less than 2³² steps.
    ///
    /// # Errors
    /// [`PlanError`]; the motion goes on as it was.
    pub fn move_to(&mut self, target: i64, limits: Limits) -> Result<(), PlanError> {
        self.order(Goal::Rest(target), limits, self.ramps)
    }

    /// Moves through `target` with `end_velocity` and keeps that; see [`Plan::then_move_through`].
    ///
    /// # Errors
    /// [`PlanError`]; the motion goes on as it was.
    pub fn move_through(
        &mut self,
        target: i64,
        end_velocity: Speed,
        limits: Limits,
    ) -> Result<(), PlanError> {
        self.order(Goal::Pass(target, end_velocity), limits, self.ramps)
    }

    /// Ramps to `velocity` and keeps it.
    ///
    /// # Errors
    /// [`PlanError`]; the motion goes on as it was.
    pub fn ramp_to(&mut self, velocity: SignedSpeed, limits: Limits) -> Result<(), PlanError> {
        self.order(Goal::Velocity(velocity), limits, self.ramps)
    }

    /// Ramps to rest at `deceleration` steps/s²: halt and quick stop. The axis comes to rest on a whole step.
    ///
    /// # Errors
    /// [`PlanError::ZeroDeceleration`]; the motion goes on as it was.
    pub fn stop(&mut self, deceleration: u32) -> Result<(), PlanError> {
        let (goal, limits) = Goal::stop(deceleration);
        self.order(goal, limits, self.ramps)
    }

    /// The tick of the axis' time that is being played now, if the sink still has `pending` ticks to play. It stands
    /// while the axis is at rest.
    pub const fn played(&self, pending: Ticks) -> Ticks {
        self.committed.saturating_sub(pending)
    }

    /// Another driver, or another configuration of it. A motion is forgotten as by [`Axis::abort`].
    pub fn set_timing(&mut self, timing: DriverTiming) {
        self.stepper = Stepper::new(timing, self.time_slice, self.steps, self.committed);
        self.stand_at(self.steps);
    }

    /// The power is off: drops the motion and stands, with no ramp, at [`Axis::committed_position`], which is returned.
    ///
    /// The caller clears the sink. If that held records not yet played, the motor is not there: the caller says where it is with
    /// [`Axis::set_position`].
    pub fn abort(&mut self) -> i64 {
        self.stand_at(self.steps);
        self.committed_position()
    }

    /// Says where the axis is, in whole steps (modulo 2³²). A motion is forgotten as by [`Axis::abort`].
    pub fn set_position(&mut self, steps: i64) {
        self.stand_at(low::i32(steps));
    }

    /// Commits records until the sink has two time slices to play, or the motion ends. To be called in every control tick and refill. It makes no more
    /// than 160 chords: four time slices of 32, and 32 more.
    ///
    /// # Errors
    /// [`AdvanceError`]: the sink is full, or ran empty.
    pub fn advance<S: PulseSink>(&mut self, sink: &mut S) -> Result<(), AdvanceError> {
        let pending = sink.pending();
        let starved = self.moving && pending == 0;
        let pending = u32::try_from(pending).unwrap_or(u32::MAX);
        let missing = (self.stepper.time_slice() * 2).saturating_sub(pending);
        let enough = self.committed.saturating_add(missing.into());
        let mut is_done = false;
        for _ in 0..MOST_CHORDS {
            self.commit(sink)?;
            is_done = self.committed >= enough;
            if is_done {
                break;
            }
            if self.stepper.is_on_polynomial() || self.enter_polynomial() {
                self.stepper.emit(low::u32(enough));
            } else if self.stepper.is_closed() {
                is_done = true;
                break;
            } else {
                self.stepper.close();
            }
            self.mark();
        }
        if !self.stepper.is_on_polynomial() && self.moving && self.is_at_rest() {
            self.settle();
        }
        if !is_done || self.stepper.take_overrun() {
            Err(AdvanceError::Internal)
        } else if starved {
            Err(AdvanceError::Underrun)
        } else {
            Ok(())
        }
    }

    /// What is being played now, if the sink still has `pending` ticks to play.
    pub fn demand(&self, pending: Ticks) -> Demand {
        self.demand_at(self.played(pending))
    }

    /// What is played at this tick of the axis' time, as far back as three time slices.
    pub fn demand_at(&self, played: Ticks) -> Demand {
        self.demand_of(self.trace.at(played))
    }

    /// Something else has moved the motor: takes over its position in whole steps (modulo 2³²) and its velocity, which the axis keeps. A
    /// motion is forgotten as by [`Axis::abort`].
    pub fn take_up(&mut self, steps: i64, velocity: SignedSpeed) {
        self.set_position(steps);
        let horizon = self.horizon();
        let most = self.max_velocity();
        let velocity = velocity.within(most);
        let from = State {
            velocity: Velocity::from_speed(self.clock, velocity),
            ..self.plan.state_at(horizon)
        };
        // It keeps what it has, so the ramps do not matter.
        let limits = Limits {
            velocity: most,
            acceleration: u32::MAX,
            deceleration: u32::MAX,
        };
        let goal = Goal::Velocity(velocity);
        if let Ok(plan) = Plan::new(self.clock, horizon, from, goal, limits, Ramps::Linear) {
            self.plan = plan;
            self.trace.restart(horizon, from);
        }
    }

    /// Whole steps committed to the sink so far: the sum of its pulses, −2³¹ ..= 2³¹−1.
    pub fn committed_position(&self) -> i64 {
        self.steps.into()
    }

    /// Whether the motion has ended and all its records have been committed. The sink may still be playing them.
    #[inline]
    pub fn is_at_rest(&self) -> bool {
        !self.stepper.is_on_polynomial() && self.has_ended()
    }

    #[inline(never)]
    fn has_ended(&self) -> bool {
        self.end().is_some_and(|end| end <= self.horizon())
            && self.stepper.is_closed()
            && self.stepper.due(self.exact_at(self.horizon())) == 0
    }

    /// The velocity at the commit horizon: that from which the next command begins.
    pub fn committed_velocity(&self) -> SignedSpeed {
        self.demand_of(self.state_at(self.horizon())).velocity
    }

    /// Whether the commit horizon has reached the last phase of the motion, the ramp to rest, or its end.
    pub fn is_ending(&self) -> bool {
        if let Some(path) = &self.path {
            return path.end().0 <= self.horizon();
        }
        self.plan.end().is_some() && self.plan.last_ramp() <= self.horizon()
    }

    /// The direction in which the axis moves at the commit horizon; `None` if it stands there.
    pub fn heading(&self) -> Option<Direction> {
        match self.state_at(self.horizon()).velocity.bits() {
            0 => None,
            1.. => Some(Direction::Forward),
            _ => Some(Direction::Reverse),
        }
    }

    /// Where the motion ends, in whole steps: the target, or where a stop comes to rest. For a velocity that is kept, the position
    /// at the commit horizon.
    pub fn target(&self) -> i64 {
        let rest = match (&self.path, self.plan.destination()) {
            (None, Some(rest)) => rest,
            _ => self.exact_at(self.end().unwrap_or(self.horizon())),
        };
        rest.floor().whole_steps()
    }

    /// The highest velocity that driver and clock allow, a whole number of steps/s. Limits above it are cut to it.
    pub fn max_velocity(&self) -> Speed {
        let hz = self.clock.hz().checked_div(self.stepper.shortest_period());
        hz.map_or(Speed::ZERO, Speed::per_second)
    }

    /// The mean that it follows from the commit horizon on; `None` if it follows none.
    pub fn mean(&self) -> Option<Mean> {
        self.is_averaged
            .then(|| Mean::new(self.average.clone(), self.plan.clone()))
    }

    /// The window of the mean that it follows, in ticks; 0 if it follows none.
    pub fn window(&self) -> u32 {
        if self.is_averaged {
            self.average.window().ticks()
        } else {
            0
        }
    }

    /// Where plan, path or mean are at tick `t`.
    fn exact_at(&self, t: Ticks) -> Exact {
        match &self.path {
            Some(path) => path.exact_at(t),
            None if self.is_averaged => self.average.exact_at(t),
            None => self.plan.exact_at(t),
        }
    }

    /// The same, rounded.
    fn state_at(&self, t: Ticks) -> State {
        self.exact_at(t).rounded()
    }

    /// The tick from which the axis stands; `None` if it never does, or as long as it follows the mean of a plan.
    fn end(&self) -> Option<Ticks> {
        match &self.path {
            None if self.is_averaged => None,
            None => self.plan.end(),
            Some(path) => Some(path.rest()),
        }
    }

    /// The commit horizon: up to here the motion has become records, but for one open period.
    #[inline]
    const fn horizon(&self) -> Ticks {
        self.stepper.horizon()
    }

    /// Commits the records made.
    #[inline]
    fn commit<S: PulseSink>(&mut self, sink: &mut S) -> Result<(), AdvanceError> {
        let waiting = self.stepper.waiting();
        if waiting.is_empty() {
            return Ok(());
        }
        let taken = sink.push_all(waiting);
        if taken < waiting.len() {
            self.drop_committed(taken);
            return Err(AdvanceError::SinkFull);
        }
        self.moving = true;
        self.stepper.take_all();
        (self.committed, self.steps) = self.stepper.made();
        Ok(())
    }

    /// The sink has taken only so many of the records made.
    #[cold]
    fn drop_committed(&mut self, taken: usize) {
        for record in self.stepper.waiting().iter().take(taken) {
            self.committed = self.committed.wrapping_add(record.ticks());
            self.steps = self.steps.wrapping_add(record.steps());
            self.moving = true;
        }
        self.stepper.drop_committed(taken);
    }

    /// Enters the polynomial of the motion that begins at the horizon, if it has not ended there.
    #[inline(never)]
    fn enter_polynomial(&mut self) -> bool {
        let begin = self.horizon();
        let polynomial = match &self.path {
            Some(path) => path.polynomial_at(begin),
            None if self.is_averaged => Some(self.average.polynomial_at(&self.plan, begin)),
            None => self.plan.polynomial_at(begin),
        };
        let polynomial = polynomial.or_else(|| {
            // Pulses that were held back by the driver's times are due all the same.
            let stands = self.exact_at(begin);
            let is_due = self.stepper.due(stands) != 0;
            is_due.then(|| Polynomial::line(begin + u64::from(self.stepper.longest()), stands))
        });
        if let Some(polynomial) = polynomial {
            self.stepper.enter(polynomial);
        }
        polynomial.is_some()
    }

    /// The commit horizon is here now. Points that lie close together are thinned out.
    #[inline]
    fn mark(&mut self) {
        let horizon = self.horizon();
        let mut state = self.stepper.state();
        if !self.stepper.is_on_polynomial() {
            // Where the mean stands it is where the plan stands, and the plan is followed.
            self.is_averaged &= !self.average.is_over(horizon);
            if self.end().is_some_and(|end| end <= horizon) {
                let stands = self.exact_at(horizon);
                state = State {
                    position: stands.floor(),
                    ..stands.rounded()
                };
            }
        }
        let least = self.stepper.time_slice() / 4;
        self.trace.mark(horizon, state, least);
    }

    /// The motion has ended: from now on the axis stands on the whole step that the pulses have reached.
    #[inline(never)]
    fn settle(&mut self) {
        self.stepper.leave();
        self.plan = Plan::at_rest(self.steps.into(), self.horizon());
        self.path = None;
        self.is_averaged = false;
        self.acceleration = 0;
        self.moving = false;
    }

    /// Stands at `steps`, with nothing more to commit.
    fn stand_at(&mut self, steps: i32) {
        self.steps = steps;
        self.stepper.reset(steps, self.committed);
        self.settle();
        let standing = self.plan.state_at(self.horizon());
        self.trace.restart(self.horizon(), standing);
    }

    fn demand_of(&self, state: State) -> Demand {
        Demand {
            position: state.position.whole_steps(),
            velocity: state.velocity.speed(self.clock),
        }
    }
}

#[cfg(test)]
mod tests;

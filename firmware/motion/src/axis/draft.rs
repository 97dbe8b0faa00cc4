//! A motion that is planned while the one before is played.
//!
//! A [`Draft`] is what a plan begins with, as it was at the commit horizon; making a plan of it takes nothing from the axis. The axis
//! takes it if its horizon is where it was ([`Axis::install`]). So a refill may commit pulses while a draft is planned. A draft that a refill
//! has made too old is planned again at once, without a draft ([`Axis::order`]): the next refill is far then.

use super::Axis;
use crate::average::{Average, Window};
use crate::clock::{Clock, Ticks};
use crate::exact::PositionQ96;
use crate::fixed::Exact;
use crate::plan::{Goal, InitialState, Limits, Plan, PlanError, Ramps};
use crate::speed::Speed;

/// What another motion is planned from.
#[derive(Debug, Clone)]
pub struct Draft {
    clock: Clock,
    max_velocity: Speed,
    /// The longest chord, in ticks.
    longest: u32,
    /// The commit horizon, and the sum of the pulses committed up to there.
    horizon: Ticks,
    steps: i32,
    acceleration: u32,
    mean_jerk: u32,
    ramps: Ramps,
    /// The motion at the commit horizon; that of the plan, if its mean goes on along another one.
    start: InitialState,
    /// The window of that mean.
    kept: Option<Window>,
    /// Where the plan comes to rest that is followed.
    destination: Option<Exact>,
    next: Next,
}

/// What the axis follows from there on.
#[derive(Debug, Clone, Copy)]
enum Next {
    /// The plan that it follows already.
    Same,
    Plan,
    /// The mean, that goes on along another plan.
    SameMean,
    /// A mean that begins here.
    Mean(Window, Exact),
}

impl Draft {
    /// The sum of the pulses committed, −2³¹ ..= 2³¹−1.
    pub fn committed_position(&self) -> i64 {
        self.steps.into()
    }

    /// Plans a motion from where the axis is at the commit horizon, and writes it over `plan`.
    ///
    /// # Errors
    /// [`PlanError`]; draft and plan are as they were.
    pub fn plan(&mut self, plan: &mut Plan, goal: Goal, limits: Limits) -> Result<(), PlanError> {
        let limits = Limits {
            velocity: limits.velocity.min(self.max_velocity),
            ..limits
        };
        self.next = if let Ramps::MovingAverage(jerk) = self.ramps {
            self.plan_averaged(plan, goal, limits, jerk)?
        } else {
            let goal = self.seen_from(goal, self.start.from);
            self.plan_itself(plan, goal, limits)?
        };
        if limits.acceleration > 0 {
            self.acceleration = limits.acceleration;
        }
        Ok(())
    }

    /// Plans a move with a start speed: the motor takes that speed at once from rest, and stops from it at once at the target. A motion away
    /// from the target, or with too short a distance to slow down to the start speed, is planned without one; so is one along a mean.
    ///
    /// # Errors
    /// [`PlanError`]; the draft is as it was.
    pub fn plan_from_start_speed(
        &mut self,
        plan: &mut Plan,
        (target, speed): (i64, Speed),
        limits: Limits,
    ) -> Result<(), PlanError> {
        let limits = Limits {
            velocity: limits.velocity.min(self.max_velocity),
            ..limits
        };
        let speed = speed.min(limits.velocity);
        let begin = self.seen_from(Goal::Pass(target, speed), self.start.from);
        let Goal::Pass(seen, _) = begin else {
            return self.plan(plan, Goal::Rest(target), limits);
        };
        if self.is_averaged() || speed == Speed::ZERO {
            return self.plan(plan, Goal::Rest(target), limits);
        }
        self.next = if self.start.is_for(begin, limits, self.ramps) {
            Next::Same
        } else {
            // A jump changes nothing else, and the draft stays as it was.
            let velocity = self.start.from.velocity;
            self.start.jump(self.clock.speed(speed), seen);
            let made = plan.make(self.clock, &self.start, begin, limits, self.ramps);
            self.start.from.velocity = velocity;
            made?;
            if !plan.stop_at(seen) {
                return self.plan(plan, Goal::Rest(target), limits);
            }
            Next::Plan
        };
        self.acceleration = limits.acceleration;
        Ok(())
    }

    /// Where the axis would come to rest, in whole steps, if it were told now to stop at `deceleration` steps/s² with these ramps. A sin² ramp
    /// under way is finished if the stop is no harder than it. With `leaves`, it is broken off as a move with these limits to another target
    /// would break it off. The draft is used up.
    ///
    /// # Errors
    /// As [`Axis::stop`].
    pub fn stop_preview(
        &mut self,
        deceleration: u32,
        leaves: Option<&Limits>,
    ) -> Result<i64, PlanError> {
        let (goal, limits) = Goal::stop(deceleration);
        let mut plan = Plan::at_rest(0, 0);
        match leaves {
            Some(order) if !self.is_averaged() => {
                // They decide how soon the acceleration of now is brought to zero.
                let limits = Limits {
                    velocity: order.velocity.min(self.max_velocity),
                    deceleration,
                    ..*order
                };
                self.start.leave_ramp();
                plan.make(self.clock, &self.start, goal, limits, self.ramps)?;
                self.next = Next::Plan;
            }
            _ => self.plan(&mut plan, goal, limits)?,
        }
        let rest = match self.next {
            Next::Same => self.destination,
            _ => plan.destination(),
        };
        Ok(rest.unwrap_or(self.start.from).floor().whole_steps())
    }

    const fn is_averaged(&self) -> bool {
        matches!(self.ramps, Ramps::MovingAverage(_))
    }

    /// The plan itself is followed.
    fn plan_itself(&self, plan: &mut Plan, goal: Goal, limits: Limits) -> Result<Next, PlanError> {
        if self.start.is_for(goal, limits, self.ramps) {
            return Ok(Next::Same);
        }
        plan.make(self.clock, &self.start, goal, limits, self.ramps)?;
        Ok(Next::Plan)
    }

    /// The window is chosen where the mean begins, and stays until the axis is at rest; while nothing has come of it yet, another order chooses
    /// it anew. From rest to rest it is as short as the jerk allows if
    /// the two ramps are further apart than that; otherwise one acceleration may come behind the other at once.
    fn plan_averaged(
        &mut self,
        plan: &mut Plan,
        goal: Goal,
        limits: Limits,
        jerk: u32,
    ) -> Result<Next, PlanError> {
        let limits = Window::within(self.clock, limits, jerk);
        if let Some(window) = self.kept {
            let goal = self.seen_from(goal, self.start.from);
            plan.make(self.clock, &self.start, goal, limits, self.ramps)?;
            // The window stays, so harder ramps have a higher jerk.
            let jerk = window.jerk(self.clock, limits.acceleration, limits.deceleration);
            self.mean_jerk = self.mean_jerk.max(jerk);
            return Ok(Next::SameMean);
        }
        let mean = self.start.from;
        let (a, d) = self.expected(limits, jerk);
        let long = self.window_for(a + d, jerk);
        let from = if !mean.velocity.is_zero() {
            Average::ahead(long, mean)
        } else {
            mean
        };
        let goal = self.seen_from(goal, from);
        let start = InitialState::steady(self.horizon, from);
        plan.make(self.clock, &start, goal, limits, self.ramps)?;
        self.mean_jerk = jerk;
        if !mean.velocity.is_zero() {
            return Ok(Next::Mean(long, mean));
        }
        if plan.end().is_some_and(|end| end <= self.horizon) {
            // Nothing need be waited for where nothing moves.
            return Ok(Next::Plan);
        }
        let cruise = match goal {
            Goal::Rest(_) => plan.cruise(),
            Goal::Pass(..) | Goal::Velocity(_) => 0,
        };
        let short = self.window_for(a.max(d), jerk);
        let is_far = cruise >= short.ticks().into();
        Ok(Next::Mean(if is_far { short } else { long }, mean))
    }

    /// A target is as far from the pulses committed as its number says. What is planned begins ahead of these, by half a step or by half a
    /// window's distance and more, and may have wrapped before them, or they before it: the number for the same distance from there.
    fn seen_from(&self, goal: Goal, from: Exact) -> Goal {
        let here = from.position.steps();
        let ahead = here.wrapping_sub(self.steps);
        let unwrapped = i64::from(self.steps) + i64::from(ahead);
        let shift = i64::from(here) - unwrapped;
        goal.shifted(shift)
    }

    /// The acceleration and the deceleration for which the window is chosen: a stop has no acceleration, but one may come behind it.
    fn expected(&self, limits: Limits, jerk: u32) -> (u64, u64) {
        let acceleration = match limits.acceleration {
            0 => self.acceleration,
            acceleration => acceleration,
        };
        let expected = Limits {
            acceleration,
            ..limits
        };
        let expected = Window::within(self.clock, expected, jerk);
        (expected.acceleration.into(), expected.deceleration.into())
    }

    /// The window in which the acceleration changes by `change` steps/s².
    fn window_for(&self, change: u64, jerk: u32) -> Window {
        Window::new(self.clock, change, jerk, self.longest)
    }
}

impl Axis {
    /// What another motion with these ramps is planned from.
    // Made where it is wanted: a copy takes as long as a quarter of a plan.
    #[inline]
    pub fn draft(&self, ramps: Ramps) -> Draft {
        let mut draft = self.steady_draft(ramps);
        self.leave(&mut draft);
        draft
    }

    /// What is planned from a standstill.
    #[inline(never)]
    fn steady_draft(&self, ramps: Ramps) -> Draft {
        let horizon = self.horizon();
        Draft {
            clock: self.clock,
            max_velocity: self.max_velocity(),
            longest: self.stepper.longest(),
            horizon,
            steps: self.steps,
            acceleration: self.acceleration,
            mean_jerk: self.mean_jerk,
            ramps,
            kept: None,
            destination: self.plan.destination(),
            next: Next::Same,
            start: InitialState::steady(horizon, Exact::at_rest(PositionQ96::ZERO)),
        }
    }

    /// The same from the motion at the commit horizon.
    #[inline(never)]
    fn leave(&self, draft: &mut Draft) {
        let goes_on = draft.is_averaged() && self.is_averaged;
        let fresh = self.average.fresh();
        draft.kept = (goes_on && fresh.is_none()).then(|| self.average.window());
        let start = &mut draft.start;
        let horizon = start.tick;
        match (&self.path, fresh) {
            (Some(path), _) => start.from = path.exact_at(horizon),
            (None, _) if !self.is_averaged => self.plan.leave(start),
            (None, _) if !goes_on => {
                // The mean is left for another trajectory.
                let mean = &self.average;
                start.from = mean.exact_at(horizon);
                start.accelerate(
                    mean.phase().acceleration_exact(horizon),
                    self.clock.sixth_jerk(self.mean_jerk),
                );
            }
            (None, Some(begin)) => start.from = begin,
            (None, None) => start.from = self.plan.exact_at(horizon),
        }
    }

    /// Goes on as planned, from the commit horizon on. Returns whether the draft was in time: if pulses have been committed since it was taken, the
    /// motion goes on as it was. No other order may have come in between.
    #[must_use]
    #[inline(never)]
    pub fn install(&mut self, draft: &Draft, plan: &Plan) -> bool {
        let horizon = self.horizon();
        if draft.horizon != horizon || draft.kept.is_some() && !self.is_averaged {
            return false;
        }
        if !matches!(draft.next, Next::Same) {
            self.plan.assign(plan);
        }
        self.go_on_with(draft);
        true
    }

    /// The plan is that of a draft.
    fn go_on_with(&mut self, draft: &Draft) {
        self.stepper.leave();
        match draft.next {
            Next::Same | Next::Plan => {}
            Next::SameMean => self.average.rejoin(draft.horizon),
            Next::Mean(window, mean) => self.average.begin(window, draft.horizon, mean),
        }
        self.is_averaged = matches!(draft.next, Next::SameMean | Next::Mean(..));
        self.mean_jerk = draft.mean_jerk;
        self.acceleration = draft.acceleration;
        self.path = None;
    }

    /// Leaves for another goal with these ramps, from where the axis is at the commit horizon.
    ///
    /// # Errors
    /// [`PlanError`]; the motion goes on as it was.
    pub fn order(&mut self, goal: Goal, limits: Limits, ramps: Ramps) -> Result<(), PlanError> {
        let mut draft = self.draft(ramps);
        draft.plan(&mut self.plan, goal, limits)?;
        self.go_on_with(&draft);
        Ok(())
    }

    /// A move with a start speed ([`Draft::plan_from_start_speed`]) from where the axis is at the commit horizon.
    ///
    /// # Errors
    /// [`PlanError`]; the motion goes on as it was.
    pub fn order_from_start_speed(
        &mut self,
        goal: (i64, Speed),
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), PlanError> {
        let mut draft = self.draft(ramps);
        let mut plan = Plan::at_rest(0, 0);
        draft.plan_from_start_speed(&mut plan, goal, limits)?;
        if !matches!(draft.next, Next::Same) {
            self.plan.assign(&plan);
        }
        self.go_on_with(&draft);
        Ok(())
    }

    /// [`Draft::stop_preview`] from where the axis is now.
    ///
    /// # Errors
    /// As [`Axis::stop`].
    pub fn stop_preview(
        &self,
        deceleration: u32,
        ramps: Ramps,
        leaves: Option<&Limits>,
    ) -> Result<i64, PlanError> {
        self.draft(ramps).stop_preview(deceleration, leaves)
    }
}

//! A motion that is planned while the one before is played.
//!
//! A [`Draft`] is a copy of all that a plan begins with, as it was at the commit horizon; making a plan of it takes nothing from the axis. The axis
//! takes it if its horizon is where it was ([`Axis::install`]). So pulses may be committed while somebody plans: who was overtaken by them takes
//! another draft, and the next refill is far then.

use super::Axis;
use crate::average::{Average, Window};
use crate::clock::{Clock, Ticks};
use crate::fixed::Exact;
use crate::plan::{Goal, Limits, Plan, PlanError, Ramps, Start};
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
    followed: Followed,
    next: Next,
    plan: Plan,
}

/// What the axis follows at the commit horizon.
#[derive(Debug, Clone, Copy)]
enum Followed {
    Plan,
    /// A path, which is here.
    Path(Exact),
    Mean(MeanThere),
}

/// The mean of a plan at the commit horizon.
#[derive(Debug, Clone, Copy)]
struct MeanThere {
    at: Exact,
    /// Q96 steps per tick².
    acceleration: i128,
    /// Where it began, if nothing has come of it yet.
    fresh: Option<Exact>,
    /// Up to here its plan has been looked at.
    joint: Ticks,
    window: Window,
}

/// What the axis follows from there on.
#[derive(Debug, Clone, Copy)]
enum Next {
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

    /// Plans a motion, from where the axis is at the commit horizon.
    ///
    /// # Errors
    /// [`PlanError`]; the draft is as it was.
    pub fn plan(&mut self, goal: Goal, limits: Limits, ramps: Ramps) -> Result<(), PlanError> {
        let limits = Limits {
            velocity: limits.velocity.min(self.max_velocity),
            ..limits
        };
        if let Ramps::MovingAverage(jerk) = ramps {
            self.plan_averaged(goal, limits, jerk)?;
        } else {
            self.plan_itself(goal, limits, ramps)?;
        }
        if limits.acceleration > 0 {
            self.acceleration = limits.acceleration;
        }
        Ok(())
    }

    /// Where the axis would come to rest, in whole steps, if it were told now to stop at `deceleration` steps/s² with these ramps. A sin² ramp under
    /// way is finished if a stop is no harder than that; with `leaves` it is left, as it is for a target elsewhere.
    ///
    /// # Errors
    /// As [`Axis::stop`].
    pub fn stop_preview(
        mut self,
        deceleration: u32,
        ramps: Ramps,
        leaves: bool,
    ) -> Result<i64, PlanError> {
        let (goal, limits) = Goal::stop(deceleration);
        let here = self.here();
        if leaves && matches!(self.followed, Followed::Plan) && !is_averaged(ramps) {
            let (clock, horizon) = (self.clock, self.horizon);
            self.plan.leave_ramp(clock, horizon, goal, limits, ramps)?;
        } else {
            self.plan(goal, limits, ramps)?;
        }
        let rest = self.plan.destination().unwrap_or(here);
        Ok(rest.floor().whole_steps())
    }

    /// The plan itself is followed.
    fn plan_itself(&mut self, goal: Goal, limits: Limits, ramps: Ramps) -> Result<(), PlanError> {
        let (clock, horizon) = (self.clock, self.horizon);
        if let Followed::Plan = self.followed {
            let goal = self.across(goal, horizon);
            self.plan.replan(clock, horizon, goal, limits, ramps)?;
        } else {
            let start = self.start();
            let goal = self.seen_from(goal, start.from);
            self.plan.make(clock, &start, goal, limits, ramps)?;
        }
        self.next = Next::Plan;
        Ok(())
    }

    /// The window is chosen where the mean begins, and stays until the axis is at rest; while nothing has come of it yet, another order chooses
    /// it anew. From rest to rest it is as short as the jerk allows if
    /// the two ramps are further apart than that; otherwise one acceleration may come behind the other at once.
    fn plan_averaged(&mut self, goal: Goal, limits: Limits, jerk: u32) -> Result<(), PlanError> {
        let (clock, horizon, ramps) = (self.clock, self.horizon, Ramps::MovingAverage(jerk));
        let limits = Window::within(clock, limits, jerk);
        let mean = match self.followed {
            Followed::Mean(MeanThere {
                fresh: None,
                joint,
                window,
                ..
            }) => {
                self.plan.enter(joint);
                let goal = self.across(goal, joint);
                self.plan.replan(clock, joint, goal, limits, ramps)?;
                self.next = Next::SameMean;
                // The window stays, so harder ramps have a higher jerk.
                let jerk = window.jerk(clock, limits.acceleration, limits.deceleration);
                self.mean_jerk = self.mean_jerk.max(jerk);
                return Ok(());
            }
            Followed::Mean(MeanThere {
                fresh: Some(mean), ..
            }) => mean,
            _ => self.here(),
        };
        let (a, d) = self.expected(limits, jerk);
        let long = self.window_for(a + d, jerk);
        let from = if mean.velocity != 0 {
            Average::ahead(long, mean)
        } else {
            mean
        };
        let goal = self.seen_from(goal, from);
        let start = Start::steady(horizon, from);
        self.plan.make(clock, &start, goal, limits, ramps)?;
        self.next = if mean.velocity != 0 {
            Next::Mean(long, mean)
        } else if self.plan.end().is_some_and(|end| end <= horizon) {
            // Nothing need be waited for where nothing moves.
            Next::Plan
        } else {
            let cruise = match goal {
                Goal::Rest(_) => self.plan.cruise(),
                Goal::Pass(..) | Goal::Velocity(_) => 0,
            };
            let short = self.window_for(a.max(d), jerk);
            let is_far = cruise >= short.ticks().into();
            Next::Mean(if is_far { short } else { long }, mean)
        };
        self.mean_jerk = jerk;
        Ok(())
    }

    /// As [`Draft::seen_from`], from where the plan is at tick `at`.
    fn across(&self, goal: Goal, at: Ticks) -> Goal {
        if matches!(goal, Goal::Velocity(_)) {
            goal
        } else {
            self.seen_from(goal, self.plan.exact_at(at))
        }
    }

    /// A target is as far from the pulses committed as its number says. What is planned begins ahead of these, by half a step or by half a
    /// window's way and more, and may have wrapped before them, or they before it: the number for the same way from there.
    fn seen_from(&self, goal: Goal, from: Exact) -> Goal {
        let here = (from.position >> 96) as i32;
        let ahead = here.wrapping_sub(self.steps);
        let unwrapped = i64::from(self.steps).wrapping_add(ahead.into());
        let shift = i64::from(here).wrapping_sub(unwrapped);
        goal.shifted(shift)
    }

    /// Where the axis is at the commit horizon.
    fn here(&self) -> Exact {
        match self.followed {
            Followed::Plan => self.plan.exact_at(self.horizon),
            Followed::Path(at) | Followed::Mean(MeanThere { at, .. }) => at,
        }
    }

    /// The motion at the commit horizon of a path or a mean, as a plan begins with it.
    fn start(&self) -> Start {
        let mut start = Start::steady(self.horizon, self.here());
        if let Followed::Mean(mean) = self.followed {
            start.acceleration = mean.acceleration;
            start.sixth_jerk = self.clock.sixth_jerk(self.mean_jerk);
        }
        start
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
    /// What another motion is planned from.
    // Out of line, and made where it is wanted.
    #[inline(never)]
    pub fn draft(&self) -> Draft {
        let horizon = self.horizon();
        let followed = if let Some(path) = &self.path {
            Followed::Path(path.exact_at(horizon))
        } else if self.is_averaged {
            let mean = &self.average;
            Followed::Mean(MeanThere {
                at: mean.exact_at(horizon),
                acceleration: mean.phase().acceleration_exact(horizon),
                fresh: mean.fresh(),
                joint: mean.joint(horizon),
                window: mean.window(),
            })
        } else {
            Followed::Plan
        };
        Draft {
            clock: self.clock,
            max_velocity: self.max_velocity(),
            longest: self.stepper.longest(),
            horizon,
            steps: self.steps,
            acceleration: self.acceleration,
            mean_jerk: self.mean_jerk,
            followed,
            next: Next::Plan,
            plan: self.plan,
        }
    }

    /// Goes on as planned, from the commit horizon on. Returns whether the draft was in time: if pulses have been committed since it was taken, the
    /// motion goes on as it was. No other order may have come in between.
    #[must_use]
    #[inline(never)]
    pub fn install(&mut self, draft: &Draft) -> bool {
        let horizon = self.horizon();
        let is_joint = match draft.followed {
            Followed::Mean(mean) => self.is_averaged && self.average.joint(horizon) == mean.joint,
            Followed::Plan | Followed::Path(_) => true,
        };
        if draft.horizon != horizon || !is_joint {
            return false;
        }
        self.stepper.leave();
        self.plan = draft.plan;
        match draft.next {
            Next::Plan => {}
            Next::SameMean => self.average.rejoin(&mut self.plan),
            Next::Mean(window, mean) => self.average.begin(window, horizon, mean),
        }
        self.is_averaged = !matches!(draft.next, Next::Plan);
        self.mean_jerk = draft.mean_jerk;
        self.acceleration = draft.acceleration;
        self.path = None;
        true
    }

    /// Plans another motion, from where the axis is at the commit horizon. On an error the motion goes on as it was.
    pub(super) fn replan(&mut self, goal: Goal, limits: Limits) -> Result<(), PlanError> {
        let mut draft = self.draft();
        draft.plan(goal, limits, self.ramps)?;
        // Nothing is committed meanwhile.
        let _ = self.install(&draft);
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
        leaves: bool,
    ) -> Result<i64, PlanError> {
        self.draft().stop_preview(deceleration, ramps, leaves)
    }
}

const fn is_averaged(ramps: Ramps) -> bool {
    matches!(ramps, Ramps::MovingAverage(_))
}

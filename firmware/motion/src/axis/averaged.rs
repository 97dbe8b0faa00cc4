//! How an axis leaves for another goal, and how it follows the mean of its plan.

use super::Axis;
use crate::average::{Average, Mean, Window};
use crate::clock::Ticks;
use crate::fixed::Exact;
use crate::plan::{Goal, Limits, Plan, PlanError, Ramps, Start};

impl Axis {
    /// What it goes on with if it follows the mean of a plan; `None` if it does not.
    pub fn mean(&self) -> Option<Mean> {
        self.is_averaged
            .then(|| Mean::new(self.average.clone(), self.plan))
    }

    /// The window of the mean that it follows, in ticks; 0 if it follows none.
    pub fn window(&self) -> u32 {
        if self.is_averaged {
            self.average.window().ticks()
        } else {
            0
        }
    }

    /// Whether it moves and has less than a segment and a half left, of `pending` ticks that the sink still plays: what takes long may then make a
    /// pause, so [`Axis::advance`] comes first.
    pub const fn runs_short(&self, pending: Ticks) -> bool {
        let segment = self.stepper.segment() as Ticks;
        self.moving && pending < segment + segment / 2
    }

    /// Plans another motion, from where the axis is at the commit horizon. On an error the motion goes on as it was.
    pub(super) fn replan(&mut self, goal: Goal, limits: Limits) -> Result<(), PlanError> {
        let limits = Limits {
            velocity: limits.velocity.min(self.max_velocity()),
            ..limits
        };
        let ramps = self.ramps;
        self.stepper.leave();
        let result = if let Ramps::MovingAverage(jerk) = ramps {
            self.replan_averaged(goal, limits, jerk)
        } else {
            self.replan_plan(goal, limits)
        };
        if result.is_ok() && limits.acceleration > 0 {
            self.acceleration = limits.acceleration;
        }
        result
    }

    /// The plan itself is followed.
    fn replan_plan(&mut self, goal: Goal, limits: Limits) -> Result<(), PlanError> {
        let (clock, horizon, ramps) = (self.clock, self.horizon(), self.ramps);
        if self.path.is_none() && !self.is_averaged {
            let goal = self.across(goal, &self.plan, horizon);
            return self.plan.replan(clock, horizon, goal, limits, ramps);
        }
        let start = self.start();
        let goal = self.seen_from(goal, start.from);
        self.plan.make(clock, &start, goal, limits, ramps)?;
        self.path = None;
        self.is_averaged = false;
        Ok(())
    }

    /// As [`Axis::seen_from`], from where a plan is at tick `at`.
    fn across(&self, goal: Goal, plan: &Plan, at: Ticks) -> Goal {
        if matches!(goal, Goal::Velocity(_)) {
            goal
        } else {
            self.seen_from(goal, plan.exact_at(at))
        }
    }

    /// A target is as far from the pulses committed as its number says. What is planned begins ahead of these, by half a step or by half a
    /// window's way and more, and may have wrapped before them, or they before it: the number for the same way from there.
    fn seen_from(&self, goal: Goal, from: Exact) -> Goal {
        let here = (from.position >> 96) as i32;
        let ahead = here.wrapping_sub(self.steps);
        let unwrapped = i64::from(self.steps).wrapping_add(ahead.into());
        let shift = i64::from(here).wrapping_sub(unwrapped);
        match goal {
            Goal::Rest(target) => Goal::Rest(target.saturating_add(shift)),
            Goal::Pass(target, end) => Goal::Pass(target.saturating_add(shift), end),
            Goal::Velocity(_) => goal,
        }
    }

    /// The window is chosen where the mean begins, and stays until the axis is at rest; while nothing has come of it yet, another order chooses
    /// it anew. From rest to rest it is as short as the jerk allows if
    /// the two ramps are further apart than that; otherwise one acceleration may come behind the other at once.
    fn replan_averaged(&mut self, goal: Goal, limits: Limits, jerk: u32) -> Result<(), PlanError> {
        let (clock, horizon, ramps) = (self.clock, self.horizon(), self.ramps);
        let limits = Window::within(clock, limits, jerk);
        let fresh = self.average.fresh().filter(|_| self.is_averaged);
        if self.is_averaged && fresh.is_none() {
            let joint = self.average.joint(horizon);
            self.plan.enter(joint);
            let goal = self.across(goal, &self.plan, joint);
            self.plan.replan(clock, joint, goal, limits, ramps)?;
            self.average.rejoin(&mut self.plan);
            // The window stays, so harder ramps have a higher jerk.
            let window = self.average.window();
            let jerk = window.jerk(clock, limits.acceleration, limits.deceleration);
            self.mean_jerk = self.mean_jerk.max(jerk);
            return Ok(());
        }
        let (a, d) = self.expected(limits, jerk);
        let (long, short) = (
            self.window_for(a + d, jerk),
            self.window_for(a.max(d), jerk),
        );
        let mean = fresh.unwrap_or_else(|| self.exact_at(horizon));
        if mean.velocity != 0 {
            let ahead = Average::ahead(long, mean);
            let goal = self.seen_from(goal, ahead);
            let start = Start::steady(horizon, ahead);
            self.plan.make(clock, &start, goal, limits, ramps)?;
            self.average.begin(long, horizon, mean);
            self.is_averaged = true;
        } else {
            let goal = self.seen_from(goal, mean);
            let start = Start::steady(horizon, mean);
            self.plan.make(clock, &start, goal, limits, ramps)?;
            // Nothing need be waited for where nothing moves.
            self.is_averaged = self.plan.end().is_none_or(|end| end > horizon);
            if self.is_averaged {
                let cruise = match goal {
                    Goal::Rest(_) => self.plan.cruise(),
                    Goal::Pass(..) | Goal::Velocity(_) => 0,
                };
                let window = if cruise >= short.ticks().into() {
                    short
                } else {
                    long
                };
                self.average.begin(window, horizon, mean);
            }
        }
        self.mean_jerk = jerk;
        self.path = None;
        Ok(())
    }

    /// The acceleration and the deceleration for which the window is chosen: a stop has no acceleration, but one may come behind it.
    pub(super) fn expected(&self, limits: Limits, jerk: u32) -> (u64, u64) {
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
    pub(super) fn window_for(&self, change: u64, jerk: u32) -> Window {
        Window::new(self.clock, change, jerk, self.stepper.longest())
    }

    /// Where plan, path or mean are at tick `t`.
    pub(super) fn exact_at(&self, t: Ticks) -> Exact {
        match &self.path {
            Some(path) => path.exact_at(t),
            None if self.is_averaged => self.average.exact_at(t),
            None => self.plan.exact_at(t),
        }
    }
}

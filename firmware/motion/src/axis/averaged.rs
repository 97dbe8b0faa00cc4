//! How an axis leaves for another goal, and how it follows the mean of its plan.

use super::{AdvanceError, Axis};
use crate::average::{Average, Mean, Window};
use crate::clock::Ticks;
use crate::fixed::Exact;
use crate::plan::{Goal, Limits, Plan, PlanError, Ramps};
use crate::record::PulseSink;

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

    /// As [`Axis::advance`], if a plan with these `ramps` may be a dear one: where a smooth motion is under way, or ramps of limited jerk take
    /// the place of whatever it is. While it is made there are no records; behind this there are two segments of them, whenever the last
    /// refill was. To be called before it.
    ///
    /// # Errors
    /// [`AdvanceError`]: the sink is full, or ran empty.
    pub fn prepare<S: PulseSink>(
        &mut self,
        ramps: Ramps,
        sink: &mut S,
    ) -> Result<(), AdvanceError> {
        let becomes_jerk_limited = matches!(ramps, Ramps::JerkLimited(_));
        let is_smooth = self.path.is_none() && self.plan.is_smooth();
        if becomes_jerk_limited || is_smooth {
            self.advance(sink)
        } else {
            Ok(())
        }
    }

    /// Whether it moves and has less than a segment and a half left, of `pending` ticks that the sink still plays: what takes long may then make a
    /// pause, so [`Axis::advance`] comes first.
    pub const fn runs_short(&self, pending: Ticks) -> bool {
        let segment = self.stepper.segment() as Ticks;
        self.moving && pending < segment + segment / 2
    }

    /// Plans another motion, from where the axis is at the commit horizon. On an error the motion goes on as it was.
    pub(super) fn redirect(&mut self, goal: Goal, limits: Limits) -> Result<(), PlanError> {
        let limits = Limits {
            velocity: limits.velocity.min(self.max_velocity()),
            ..limits
        };
        let ramps = self.ramps;
        self.stepper.leave();
        let result = if let Ramps::MovingAverage(jerk) = ramps {
            self.redirect_averaged(goal, limits, jerk)
        } else {
            self.redirect_plan(goal, limits)
        };
        self.is_new |= result.is_ok();
        if result.is_ok() && limits.acceleration > 0 {
            self.acceleration = limits.acceleration;
        }
        result
    }

    /// The plan itself is followed.
    fn redirect_plan(&mut self, goal: Goal, limits: Limits) -> Result<(), PlanError> {
        let (clock, horizon, ramps) = (self.clock, self.horizon(), self.ramps);
        if self.path.is_none() && !self.is_averaged {
            let goal = self.across(goal, &self.plan, horizon);
            return self.plan.leave_for(clock, horizon, goal, limits, ramps);
        }
        // A jerk-limited ramp can go on with the acceleration of the mean.
        let (pull, ramps) = match ramps {
            // It is left at no less than the jerk with which it was entered, or the velocity would go on beyond its limit.
            Ramps::JerkLimited(jerk) if self.is_averaged && jerk > 0 => (
                self.average.phase().pull(horizon),
                Ramps::JerkLimited(jerk.max(self.mean_jerk)),
            ),
            _ => (0, ramps),
        };
        let from = self.exact_at(horizon);
        let goal = self.seen_from(goal, from);
        let from = (from, pull);
        self.plan.make(clock, horizon, from, goal, limits, ramps)?;
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

    /// A target is as far from the pulses handed out as its number says. What is planned begins ahead of these, by half a step or by half a
    /// window's way and more, and may have wrapped before them, or they before it: the number for the same way from there.
    fn seen_from(&self, goal: Goal, from: Exact) -> Goal {
        let here = (from.position >> 96) as i32;
        let ahead = here.wrapping_sub(self.committed);
        let unwrapped = i64::from(self.committed).wrapping_add(ahead.into());
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
    fn redirect_averaged(
        &mut self,
        goal: Goal,
        limits: Limits,
        jerk: u32,
    ) -> Result<(), PlanError> {
        let (clock, horizon, ramps) = (self.clock, self.horizon(), self.ramps);
        let limits = Window::within(clock, limits, jerk);
        let fresh = self.average.fresh().filter(|_| self.is_averaged);
        if self.is_averaged && fresh.is_none() {
            let joint = self.average.joint(horizon);
            self.plan.enter(joint);
            let goal = self.across(goal, &self.plan, joint);
            self.plan.redirect(clock, joint, goal, limits, ramps)?;
            self.average.rejoin(&mut self.plan);
            // The window stays, so harder ramps have a higher jerk.
            let window = self.average.window();
            let jerk = window.jerk(clock, limits.acceleration, limits.deceleration);
            self.mean_jerk = self.mean_jerk.max(jerk);
            return Ok(());
        }
        let segment = self.stepper.longest();
        let window = |change: u64| Window::new(clock, change, jerk, segment);
        // A stop has no acceleration, but one may come behind it.
        let expected = Limits {
            acceleration: match limits.acceleration {
                0 => self.acceleration,
                acceleration => acceleration,
            },
            ..limits
        };
        let expected = Window::within(clock, expected, jerk);
        let (a, d) = (expected.acceleration.into(), expected.deceleration.into());
        let long = || window(u64::wrapping_add(a, d));
        let mean = fresh.unwrap_or_else(|| self.exact_at(horizon));
        if mean.velocity != 0 {
            let window = long();
            let ahead = Average::ahead(window, mean);
            let goal = self.seen_from(goal, ahead);
            let from = (ahead, 0);
            self.plan.make(clock, horizon, from, goal, limits, ramps)?;
            self.average.begin(window, horizon, mean);
            self.is_averaged = true;
        } else {
            let goal = self.seen_from(goal, mean);
            let from = (mean, 0);
            self.plan.make(clock, horizon, from, goal, limits, ramps)?;
            // Nothing need be waited for where nothing moves.
            self.is_averaged = self.plan.end().is_none_or(|end| end > horizon);
            if self.is_averaged {
                let cruise = match goal {
                    Goal::Rest(_) => self.plan.cruise(),
                    Goal::Pass(..) | Goal::Velocity(_) => 0,
                };
                let short = Some(window(a.max(d))).filter(|short| cruise >= short.ticks().into());
                let window = short.unwrap_or_else(long);
                self.average.begin(window, horizon, mean);
            }
        }
        self.mean_jerk = jerk;
        self.path = None;
        Ok(())
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

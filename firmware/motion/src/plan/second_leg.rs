//! The second leg of a smooth motion that has to come to rest before it goes on: from there to its goal.
//!
//! Such a motion is planned in two steps. The first one plans the stop: where and when that ends is known from then on, and
//! whatever may be wrong with the order. The second one begins there, whenever it is worked out: nothing of it depends on that.
//!
//! It is a motion from rest. So sin² ramps are real ones, though the stop before them is jerk-limited: they take as long as linear ones
//! do, and within the same limits there are no faster ones.

use super::jerk_limited::with_rules;
use super::ramp::{Jerk, Motion};
use super::{Course, Goal, Limits, Plan, PlanError, Ramps, move_to, velocity};
use crate::clock::{Clock, Ticks};
use crate::fixed::{Exact, State};

/// What is left to be planned, from where a plan waits, in its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct SecondLeg {
    pub(super) clock: Clock,
    /// Q96 steps; of no account where a velocity is what the motion is after.
    pub(super) way: u128,
    /// Where that leads.
    pub(super) goal: i128,
    /// The speed there, Q96 steps per tick.
    pub(super) end: i128,
}

impl Plan {
    /// As [`Plan::redirect`], but of a smooth motion that has to come to rest before it goes on only the stop is planned, as if the axis
    /// stood for ever from its end on. The rest is for [`Plan::complete`]. This is the way an axis takes; and a plan is large, copies of
    /// it are dear.
    ///
    /// # Errors
    /// As [`Plan::move_to`]. With what is left nothing can be wrong.
    pub fn leave_for(
        &mut self,
        clock: Clock,
        at: Ticks,
        goal: Goal,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), PlanError> {
        self.enter(at);
        let is_smooth = matches!(ramps, Ramps::SinSquared | Ramps::JerkLimited(_));
        let goes_on = is_smooth && self.jerk.is_some();
        if goes_on && at < self.end && self.does(at, goal, limits, ramps) {
            return Ok(());
        }
        let from = match self.entered(at) {
            Some(phase) if goes_on => phase.motion_at(at),
            _ => (self.exact_at(at), 0),
        };
        self.make(clock, at, from, goal, limits, ramps)
    }

    /// Plans what [`Plan::leave_for`] has left, if anything: from the end of the stop on, whenever that is asked for. The motion is the same
    /// as if all of it had been planned at once.
    pub fn complete(&mut self) {
        let Some(leg) = self.left else {
            return;
        };
        self.left = None;
        if let (Some(order), Some(jerk)) = (self.order, self.jerk) {
            plan(self, &leg, order, &jerk);
        }
    }

    /// The tick from which the plan only stands because the rest of the motion is not planned yet; `None` if all of it is.
    pub fn waits_from(&self) -> Option<Ticks> {
        self.left.as_ref()?;
        self.drafts().last().map(|draft| draft.start())
    }

    /// Where the motion comes to rest, planned or not; `None` if it never does.
    pub(crate) fn destination(&self) -> Option<State> {
        let rests = match &self.left {
            Some(leg) => leg.end == 0,
            None => self.end != Ticks::MAX,
        };
        let rest = Exact {
            position: self.rest,
            velocity: 0,
        };
        rests.then(|| rest.rounded())
    }
}

/// Goes on from where the plan waits, as it was ordered, with this jerk.
fn plan(
    plan: &mut Plan,
    leg: &SecondLeg,
    (goal, limits, ramps): (Goal, Limits, Ramps),
    jerk: &Jerk,
) {
    let &SecondLeg {
        clock,
        way,
        goal: to,
        end,
    } = leg;
    let is_sine = ramps == Ramps::SinSquared;
    let keeps = matches!(goal, Goal::Velocity(_));
    plan.is_sine = is_sine;
    let Some(course) = Course::resume(plan) else {
        return;
    };
    let speed = end.unsigned_abs();
    let course = if !is_sine {
        course
    } else if keeps {
        return velocity::from_rest(course, clock, speed, limits);
    } else if let Some(course) = move_to::from_rest(course, clock, (way, speed, to), limits) {
        course
    } else {
        return;
    };
    with_rules(clock, limits, jerk, |rules| {
        if keeps {
            course.ramp_to(&Motion::REST, end, rules);
        } else {
            course.leave_rest((way, end, to), rules);
        }
    });
    plan.is_sine = false;
}

//! Plans: where the axis is at every tick, in closed form.
//!
//! A plan is a list of phases of constant acceleration, at most five; where the jerk is limited, of constant jerk, at most
//! eleven. It is made once, from a state, a goal and limits, and then
//! only evaluated. Two rules make it exact: the braking phase of a move is anchored at its target, so that it lands there whatever
//! was rounded on the way; and limits are rounded down, so that they are never exceeded. What that costs in speed is paid
//! by the cruise.
//!
//! A smooth motion that has to come to rest before it goes on is two legs, and these may be planned one by one
//! ([`Plan::leave_for`], [`Plan::complete`]), so that no step is longer than a plan from rest.
//!
//! A plan keeps drafts of its phases, as they are found, a jerk-limited ramp as one; and a phase is worked out when it is asked for.
//! Whoever follows a plan enters each phase once; most plans are left before their last.
//!
//! After CiA 402-2, the profile deceleration (6084h) rules whenever the speed falls and the profile acceleration (6083h)
//! whenever it grows, in either direction.

mod course;
mod cruise;
mod draft;
mod jerk_limited;
mod move_to;
mod number;
pub(crate) mod phase;
mod ramp;
mod rough;
mod second_leg;
mod sine;
mod velocity;

use core::fmt;

use crate::clock::{Clock, Ticks};
use crate::fixed::{Exact, State};
use crate::speed::{SignedSpeed, Speed};
use crate::stepper::piece::Piece;
use course::Course;
use draft::{Draft, MOST_RAMPS};
use phase::{Frame, Phase};
use ramp::{Jerk, Ramp};
use rough::{Kind, Rough};
use second_leg::SecondLeg;

/// What a motion may ask of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Profile velocity (6081h), more than 0. More than half a step per tick is cut to that.
    pub velocity: Speed,
    /// Profile acceleration (6083h) in steps/s², at least 1: rules while the speed grows.
    pub acceleration: u32,
    /// Profile deceleration (6084h) in steps/s², at least 1: rules while the speed falls.
    pub deceleration: u32,
}

/// How the velocity changes (motion profile type, 6086h).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ramps {
    /// At constant acceleration: the trapezoid.
    #[default]
    Linear,
    /// As sin², within the time that the linear ramp takes and over the same way; the acceleration reaches π/2 times its limit. A
    /// motion that begins within such a ramp is jerk-limited, at the jerk at which that ramp began, or at which one from rest to the profile
    /// velocity begins if that is higher; with harder limits than before, at theirs. If it has to come to rest before it goes on, the ramps
    /// from there on are sin² again, and to leave these takes no less than the jerk of that stop.
    SinSquared,
    /// With this jerk (60A4h) in steps/s³, at least 1: the double-S.
    JerkLimited(u32),
    /// As the moving average of linear ramps, at this jerk (60A4h) in steps/s³, at least 1. The plan is that of linear ramps; the axis
    /// takes the mean, and comes to rest a window later than the plan.
    MovingAverage(u32),
}

/// What a motion is after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// To stand at this position, in whole steps.
    Rest(i64),
    /// To pass this position, in whole steps, with this velocity (6082h), and keep it; see [`Plan::then_move_through`].
    Pass(i64, Speed),
    /// To keep this velocity; 0 is a stop.
    Velocity(SignedSpeed),
}

/// Why there is no plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanError {
    /// The velocity limit is 0: the target would never be reached.
    ZeroVelocity,
    /// The acceleration limit is 0.
    ZeroAcceleration,
    /// The deceleration limit is 0: the axis would never stop.
    ZeroDeceleration,
    /// The jerk is 0: no ramp would begin.
    ZeroJerk,
    /// The target is 2³² steps or more away, or braking takes the axis that far from it. With limited jerk, an axis that cannot reach
    /// the target without coming to rest first may take less than 2³¹ steps for that.
    OutOfRange,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ZeroVelocity => "velocity limit is zero",
            Self::ZeroAcceleration => "acceleration limit is zero",
            Self::ZeroDeceleration => "deceleration limit is zero",
            Self::ZeroJerk => "jerk is zero",
            Self::OutOfRange => "target out of range",
        })
    }
}

impl core::error::Error for PlanError {}

/// Jerks that differ by less than that factor are one: sin² ramps are left at more than they need.
const ALIKE: Rough = Rough::ONE.more(-8);

/// The wrong direction is left; then acceleration, cruise, braking, and the velocity that is kept.
const MOST_DRAFTS: usize = 5;

/// A jerk-limited ramp is three phases.
const MOST_PHASES: usize = 11;

/// A motion in closed form.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    frame: Frame,
    /// `Ticks::MAX` if it never ends.
    end: Ticks,
    drafts: [Draft; MOST_DRAFTS],
    /// The jerk-limited ramps of the drafts.
    ramps: [Ramp; MOST_RAMPS],
    count: u8,
    /// The phase that was entered, and the first tick behind it; 0 if there is none.
    entered: Phase,
    entered_until: Ticks,
    /// The position from `end` on, Q96 steps.
    rest: i128,
    /// The first tick of the ramp to rest, or of the last ramp there is.
    last_ramp: Ticks,
    /// The leg that is still to be planned: the plan stands where that begins.
    left: Option<SecondLeg>,
    /// What the plan was made for, if its ramps are not linear.
    order: Option<(Goal, Limits, Ramps)>,
    /// With which jerk a ramp under way is left; none where ramps are linear.
    jerk: Option<Jerk>,
    /// The linear ramps of the plan that is made next are to be drawn as sin².
    is_sine: bool,
}

impl Plan {
    /// Standing at a whole step (modulo 2³²) from tick `start` on.
    pub const fn at_rest(position_steps: i64, start: Ticks) -> Self {
        let rest = Exact::at_rest(position_steps).position;
        Self {
            frame: Frame {
                start,
                origin: rest,
                reverse: false,
            },
            end: start,
            drafts: [Draft::NONE; MOST_DRAFTS],
            ramps: [Ramp::NONE; MOST_RAMPS],
            count: 0,
            entered: Phase::NONE,
            entered_until: 0,
            rest,
            last_ramp: start,
            left: None,
            order: None,
            jerk: None,
            is_sine: false,
        }
    }

    /// Profile position: moves to `target_steps` and stops there, in the shortest time that `limits` allow. A target beyond
    /// −2³¹ ..= 2³¹−1 lies behind the end of that span, where positions wrap.
    ///
    /// Starts at any velocity: if the axis moves away from the target, or too fast to stop before it, it brakes, turns and
    /// comes back.
    ///
    /// # Errors
    /// [`PlanError`] for a zero limit or a target out of range.
    pub fn move_to(
        clock: Clock,
        start: Ticks,
        from: State,
        target_steps: i64,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        Self::new(
            clock,
            start,
            from,
            Goal::Rest(target_steps),
            limits,
            Ramps::Linear,
        )
    }

    /// Profile velocity: ramps to `velocity` and keeps it; 0 is a stop, the ramp of halt and quick stop.
    ///
    /// The velocity is cut to `limits.velocity`. A stop needs no limit but the deceleration. The position may wrap.
    ///
    /// # Errors
    /// [`PlanError`] for a zero limit.
    pub fn velocity(
        clock: Clock,
        start: Ticks,
        from: State,
        velocity: SignedSpeed,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        Self::new(
            clock,
            start,
            from,
            Goal::Velocity(velocity),
            limits,
            Ramps::Linear,
        )
    }

    /// A plan from `from` at tick `start` to any goal.
    ///
    /// # Errors
    /// As [`Plan::move_to`].
    pub fn new(
        clock: Clock,
        start: Ticks,
        from: State,
        goal: Goal,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<Self, PlanError> {
        let mut plan = Self::at_rest(0, start);
        plan.make(clock, start, (from.into(), 0), goal, limits, ramps)?;
        plan.complete();
        Ok(plan)
    }

    /// [`Plan::move_to`] from the state that this plan has at tick `at`, without rounding it first: planning a move again to the
    /// same target does not change when it ends.
    ///
    /// # Errors
    /// As [`Plan::move_to`].
    pub fn then_move_to(
        &self,
        clock: Clock,
        at: Ticks,
        target_steps: i64,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        self.then_move_through(clock, at, target_steps, Speed::ZERO, limits)
    }

    /// Moves through `target_steps` with `end_velocity` (6082h), cut to that of `limits`, from the state that this plan
    /// has at tick `at`, and keeps that velocity. Where the way is too short for it, it comes about behind the target. The
    /// axis stops on the target if the end velocity is 0 or the axis is there already.
    ///
    /// # Errors
    /// As [`Plan::move_to`].
    pub fn then_move_through(
        &self,
        clock: Clock,
        at: Ticks,
        target_steps: i64,
        end_velocity: Speed,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        let mut next = *self;
        next.redirect(
            clock,
            at,
            Goal::Pass(target_steps, end_velocity),
            limits,
            Ramps::Linear,
        )?;
        Ok(next)
    }

    /// [`Plan::velocity`] from the state that this plan has at tick `at`, without rounding it first.
    ///
    /// # Errors
    /// As [`Plan::velocity`].
    pub fn then_velocity(
        &self,
        clock: Clock,
        at: Ticks,
        velocity: SignedSpeed,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        let mut next = *self;
        next.redirect(clock, at, Goal::Velocity(velocity), limits, Ramps::Linear)?;
        Ok(next)
    }

    /// Leaves for another goal at tick `at`, from the state that this plan has there, without rounding it first. On an error the
    /// plan stays as it was.
    ///
    /// Smooth ramps go on smoothly; what a smooth plan does already is not planned again. From linear ramps a smooth one begins
    /// with no acceleration.
    ///
    /// # Errors
    /// As [`Plan::move_to`].
    pub fn redirect(
        &mut self,
        clock: Clock,
        at: Ticks,
        goal: Goal,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), PlanError> {
        self.leave_for(clock, at, goal, limits, ramps)?;
        self.complete();
        Ok(())
    }

    /// Whether there is nothing to change for a goal: it is what the plan is after; or sin² braking is under way to it, and that is
    /// as short as it can be: but a stop that is harder than that braking is obeyed.
    fn does(&self, at: Ticks, goal: Goal, limits: Limits, ramps: Ramps) -> bool {
        if at < self.frame.start {
            return false;
        }
        if self.order == Some((goal, limits, ramps)) {
            return true;
        }
        let is_braking = ramps == Ramps::SinSquared && self.is_sine && at >= self.last_ramp;
        let to_rest = match goal {
            Goal::Rest(target) => Exact::at_rest(target).position == self.rest,
            Goal::Pass(..) => false,
            Goal::Velocity(velocity) => {
                let is_harder = self
                    .order
                    .is_none_or(|(_, before, _)| limits.deceleration > before.deceleration);
                velocity == SignedSpeed::ZERO && !is_harder
            }
        };
        is_braking && to_rest && self.end != Ticks::MAX && limits.deceleration != 0
    }

    /// Makes a plan from a state and an acceleration, Q96, which linear ramps do not care for.
    pub(crate) fn make(
        &mut self,
        clock: Clock,
        start: Ticks,
        (from, pull): (Exact, i128),
        goal: Goal,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), PlanError> {
        let jerk = match ramps {
            Ramps::MovingAverage(0) => return Err(PlanError::ZeroJerk),
            Ramps::Linear | Ramps::MovingAverage(_) => None,
            Ramps::SinSquared if pull != 0 => self.leaving_jerk(clock, start, from, limits),
            Ramps::SinSquared => Some(sine_jerk(clock, from, limits)),
            Ramps::JerkLimited(0) => return Err(PlanError::ZeroJerk),
            Ramps::JerkLimited(jerk) => {
                let sixth = clock.sixth_jerk(jerk);
                // A ramp under way is left at no less than the jerk with which it was entered.
                let entered = self.jerk.filter(|_| pull != 0);
                let entered = entered.map_or(0, |jerk| self.entry_jerk(start, jerk).sixth);
                let sixth = sixth.max(entered);
                let known = self.jerk.filter(|jerk| jerk.sixth == sixth);
                Some(known.unwrap_or_else(|| Jerk::new(sixth)))
            }
        };
        let is_sine = ramps == Ramps::SinSquared && pull == 0;
        match jerk {
            Some(jerk) if !is_sine => {
                jerk_limited::plan(self, clock, start, (from, pull), goal, limits, &jerk)?;
            }
            _ => {
                let was_sine = self.is_sine;
                self.is_sine = is_sine;
                let made = match goal {
                    Goal::Rest(target) => {
                        move_to::plan(self, clock, start, from, (target, Speed::ZERO), limits)
                    }
                    Goal::Pass(target, end) => {
                        move_to::plan(self, clock, start, from, (target, end), limits)
                    }
                    Goal::Velocity(velocity) => {
                        velocity::plan(self, clock, start, from, velocity, limits)
                    }
                };
                if made.is_err() {
                    self.is_sine = was_sine;
                    return made;
                }
            }
        }
        self.is_sine = is_sine;
        self.jerk = jerk;
        self.order = jerk.map(|_| (goal, limits, ramps));
        Ok(())
    }

    /// With which jerk the ramp at tick `at` was entered, if it is `jerk` that the plan was made with: that of a sin² ramp between two
    /// velocities which lie closer together is higher.
    fn entry_jerk(&self, at: Ticks, jerk: Jerk) -> Jerk {
        let steepness = self.entered(at).and_then(Phase::steepness_of_sine);
        let entered = steepness.map_or(Rough::ZERO, |steepness| steepness.times(Jerk::OF_SINE));
        // Most often it is the same, but for what is rounded.
        if entered > jerk.rough.times(ALIKE) {
            steepness.map_or(jerk, Jerk::of_sine)
        } else {
            jerk
        }
    }

    /// The jerk with which a ramp under way is left for sin² ones: no less than that with which it was entered, and where the new limits are
    /// harder, theirs. A quick stop must not last as long as the gentle ramp that it ends.
    fn leaving_jerk(&self, clock: Clock, at: Ticks, from: Exact, limits: Limits) -> Option<Jerk> {
        let hardest = |limits: Limits| limits.acceleration.max(limits.deceleration);
        let entered = self.entry_jerk(at, self.jerk?);
        let is_harder = self
            .order
            .is_none_or(|(_, before, _)| hardest(limits) > hardest(before));
        if !is_harder {
            return Some(entered);
        }
        let jerk = sine_jerk(clock, from, limits);
        Some(if jerk.sixth > entered.sixth {
            jerk
        } else {
            entered
        })
    }

    /// Whether its ramps are not linear: another smooth plan in motion begins with the acceleration of this one.
    pub(crate) const fn is_smooth(&self) -> bool {
        self.jerk.is_some()
    }

    /// The first tick of the ramp to rest; the end, if the axis stands.
    pub(crate) const fn last_ramp(&self) -> Ticks {
        self.last_ramp
    }

    /// The state at tick `t`: before the start that at the start, after the end that at the end.
    pub fn state_at(&self, t: Ticks) -> State {
        self.exact_at(t).rounded()
    }

    /// The first tick of the plan.
    pub const fn start(&self) -> Ticks {
        self.frame.start
    }

    /// The tick from which the axis stands still; `None` if it never does.
    pub const fn end(&self) -> Option<Ticks> {
        if self.end == Ticks::MAX {
            None
        } else {
            Some(self.end)
        }
    }

    /// The phases in order; none if the axis stands.
    pub fn phases(&self) -> impl DoubleEndedIterator<Item = Phase> + ExactSizeIterator {
        let mut phases = [Phase::NONE; MOST_PHASES];
        let mut count = 0;
        let mut corner = Some(self.frame.start);
        while let Some(phase) = corner.and_then(|corner| self.phase_at(corner))
            && let Some(next) = phases.get_mut(count)
        {
            corner = self.next_corner(phase.start());
            *next = phase;
            count = count.wrapping_add(1);
        }
        phases.into_iter().take(count)
    }

    fn drafts(&self) -> &[Draft] {
        self.drafts
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    /// The next tick after `after` at which another phase begins or the plan ends; `None` if nothing changes any more.
    pub fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        self.drafts()
            .iter()
            .flat_map(|draft| draft.corners(&self.ramps))
            .chain(self.end())
            .find(|corner| *corner > after)
    }

    /// How long it keeps its velocity between its two ramps, if it is one from rest to rest; in ticks.
    pub(crate) fn cruise(&self) -> Ticks {
        let line = self.drafts().iter().find(|draft| draft.is_line());
        line.map_or(0, |line| {
            let start = line.start();
            let end = self.next_corner(start).unwrap_or(start);
            end.saturating_sub(start)
        })
    }

    /// The plan must be known up to tick `t`.
    pub(crate) fn complete_up_to(&mut self, t: Ticks) {
        if self.waits_from().is_some_and(|from| from <= t) {
            self.complete();
        }
    }

    /// How the plan goes on from tick `t`; `None` where it stands. The phase there is entered.
    pub(crate) fn piece_at(&mut self, t: Ticks) -> Option<Piece> {
        self.complete_up_to(t);
        self.enter(t);
        let end = self.entered_until;
        self.entered(t).map(|phase| phase.piece(t, end))
    }

    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        let t = t.max(self.frame.start);
        if let Some(phase) = self.entered(t) {
            return phase.at(t);
        }
        match self.phase_at(t) {
            Some(phase) => phase.at(t),
            None => Exact {
                position: self.rest,
                velocity: 0,
            },
        }
    }

    pub(crate) fn phase_at(&self, t: Ticks) -> Option<Phase> {
        let (draft, until) = draft_at(self.drafts(), self.end, t)?;
        let mut phase = Phase::NONE;
        draft.work_out(&self.ramps, (t, until), &self.frame, &mut phase);
        Some(phase)
    }

    /// The phase at tick `t`, if it is the one that was entered.
    #[inline]
    pub(crate) fn entered(&self, t: Ticks) -> Option<&Phase> {
        (t < self.entered_until && t >= self.entered.start()).then_some(&self.entered)
    }

    /// Enters the phase at tick `t`: it need not be worked out again while the axis is in it.
    pub(crate) fn enter(&mut self, t: Ticks) {
        if self.entered(t).is_some() {
            return;
        }
        let drafts = self.drafts.get(..usize::from(self.count));
        if let Some((draft, until)) = draft_at(drafts.unwrap_or_default(), self.end, t) {
            self.entered_until =
                draft.work_out(&self.ramps, (t, until), &self.frame, &mut self.entered);
        }
    }
}

/// The draft of the phase at tick `t`, and the first tick behind it.
fn draft_at(drafts: &[Draft], end: Ticks, t: Ticks) -> Option<(&Draft, Ticks)> {
    let mut until = end;
    if t >= until {
        return None;
    }
    for draft in drafts.iter().rev() {
        if draft.start() <= t {
            return Some((draft, until));
        }
        until = draft.start();
    }
    None
}

/// The jerk at the ends of a sin² ramp between rest and the profile velocity v: Δv·π²/2T² = π²·a²/2v.
fn sine_jerk(clock: Clock, from: Exact, limits: Limits) -> Jerk {
    let unit = Rough::power(24).over(Rough::whole(clock.hz()));
    let bits = limits.velocity.bits();
    let part = Rough::whole(bits as u32).times(Rough::power(-32));
    let limit = Rough::whole((bits >> 32) as u32).plus(part).times(unit);
    let speed = Rough::of(from.velocity.unsigned_abs(), Kind::Velocity);
    let mut velocity = limit.max(speed);
    if velocity == Rough::ZERO {
        // A stop from rest, where there is no ramp.
        velocity = unit;
    }
    let ramp = Rough::whole(limits.acceleration.max(limits.deceleration));
    let ramp = ramp.times(unit).times(unit);
    // A step/s³ more, so that the slowest are left within a time that can be told.
    let more = unit.times(unit).times(unit);
    Jerk::of_sine(ramp.times(ramp).over(velocity).plus(more))
}

#[cfg(test)]
mod tests;

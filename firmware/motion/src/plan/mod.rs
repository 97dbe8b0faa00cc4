//! Plans: where the axis is at every tick, in closed form.
//!
//! A plan is a list of at most five phases of constant acceleration. It is made once, from a state, a goal and limits, and then
//! only evaluated. Two rules make it exact: the braking phase of a move is anchored at its target, so that it lands there whatever
//! was rounded on the way; and limits are rounded down, so that they are never exceeded. What that costs in speed is paid
//! by the cruise.
//!
//! After CiA 402-2, the profile deceleration (6084h) rules whenever the speed falls and the profile acceleration (6083h)
//! whenever it grows, in either direction.

mod move_to;
pub(crate) mod phase;
mod velocity;

use core::fmt;

use crate::clock::{Clock, Ticks};
use crate::fixed::{Exact, State};
use phase::{Offset, Parabola, Phase, ramp_way, ticks_up};

/// What a motion may ask of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Profile velocity (6081h) in steps/s, at least 1. More than half a step per tick is cut to that.
    pub velocity: u32,
    /// Profile acceleration (6083h) in steps/s², at least 1: rules while the speed grows.
    pub acceleration: u32,
    /// Profile deceleration (6084h) in steps/s², at least 1: rules while the speed falls.
    pub deceleration: u32,
}

/// What a motion is after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// To stand at this position, in whole steps.
    Rest(i64),
    /// To pass this position, in whole steps, with this velocity in steps/s (6082h), and keep it; see [`Plan::then_move_through`].
    Pass(i64, u32),
    /// To keep this velocity in steps/s; 0 is a stop.
    Velocity(i32),
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
    /// The target is 2³² steps or more away, or braking takes the axis that far from it.
    OutOfRange,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ZeroVelocity => "velocity limit is zero",
            Self::ZeroAcceleration => "acceleration limit is zero",
            Self::ZeroDeceleration => "deceleration limit is zero",
            Self::OutOfRange => "target out of range",
        })
    }
}

impl core::error::Error for PlanError {}

/// Overspeed is braked or the wrong direction is left; then acceleration, cruise, braking, and the velocity that is kept.
const MOST_PHASES: usize = 5;

/// A motion in closed form.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    start: Ticks,
    /// `Ticks::MAX` if it never ends.
    end: Ticks,
    phases: [Phase; MOST_PHASES],
    count: u8,
    /// The position from `end` on, Q96 steps.
    rest: i128,
}

impl Plan {
    /// Standing at a whole step (modulo 2³²) from tick `start` on.
    pub const fn at_rest(position_steps: i64, start: Ticks) -> Self {
        Self {
            start,
            end: start,
            phases: [Phase::NONE; MOST_PHASES],
            count: 0,
            rest: Exact::at_rest(position_steps).position,
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
        Self::new(clock, start, from, Goal::Rest(target_steps), limits)
    }

    /// Profile velocity: ramps to `steps_per_second` and keeps it; 0 is a stop, the ramp of halt and quick stop.
    ///
    /// The velocity is cut to `limits.velocity`. A stop needs no limit but the deceleration. The position may wrap.
    ///
    /// # Errors
    /// [`PlanError`] for a zero limit.
    pub fn velocity(
        clock: Clock,
        start: Ticks,
        from: State,
        steps_per_second: i32,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        Self::new(clock, start, from, Goal::Velocity(steps_per_second), limits)
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
    ) -> Result<Self, PlanError> {
        let mut plan = Self::at_rest(0, start);
        plan.make(clock, start, from.into(), goal, limits)?;
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
        self.then_move_through(clock, at, target_steps, 0, limits)
    }

    /// Moves through `target_steps` with `end_velocity` in steps/s (6082h), cut to that of `limits`, from the state that this plan
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
        end_velocity: u32,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        let mut next = *self;
        next.redirect(clock, at, Goal::Pass(target_steps, end_velocity), limits)?;
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
        steps_per_second: i32,
        limits: Limits,
    ) -> Result<Self, PlanError> {
        let mut next = *self;
        next.redirect(clock, at, Goal::Velocity(steps_per_second), limits)?;
        Ok(next)
    }

    /// Leaves for another goal at tick `at`, from the state that this plan has there, without rounding it first. On an error the
    /// plan stays as it was. This is the way an axis takes: a plan is large, and copies of it are dear.
    ///
    /// # Errors
    /// As [`Plan::move_to`].
    pub fn redirect(
        &mut self,
        clock: Clock,
        at: Ticks,
        goal: Goal,
        limits: Limits,
    ) -> Result<(), PlanError> {
        let from = self.exact_at(at);
        self.make(clock, at, from, goal, limits)
    }

    /// Becomes the plan from this state at tick `start`, whatever it was. On an error it stays as it was.
    pub(crate) fn make(
        &mut self,
        clock: Clock,
        start: Ticks,
        from: Exact,
        goal: Goal,
        limits: Limits,
    ) -> Result<(), PlanError> {
        match goal {
            Goal::Rest(target) => move_to::plan(self, clock, start, from, (target, 0), limits),
            Goal::Pass(target, end_velocity) => {
                move_to::plan(self, clock, start, from, (target, end_velocity), limits)
            }
            Goal::Velocity(velocity) => velocity::plan(self, clock, start, from, velocity, limits),
        }
    }

    /// The state at tick `t`: before the start that at the start, after the end that at the end.
    pub fn state_at(&self, t: Ticks) -> State {
        self.exact_at(t).rounded()
    }

    /// The first tick of the plan.
    pub const fn start(&self) -> Ticks {
        self.start
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
    pub fn phases(&self) -> &[Phase] {
        self.phases
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    /// The next tick after `after` at which another phase begins or the plan ends; `None` if nothing changes any more.
    pub fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        self.phases()
            .iter()
            .map(Phase::start)
            .chain(self.end())
            .find(|corner| *corner > after)
    }

    /// The longest chord from tick `t` that stays within a quarter of a step of the phase there, in ticks.
    pub(crate) fn longest_chord(&self, t: Ticks) -> u64 {
        self.phase_at(t).map_or(u64::MAX, Phase::longest_chord)
    }

    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        let t = t.max(self.start);
        match self.phase_at(t) {
            Some(phase) => phase.at(t),
            None => Exact {
                position: self.rest,
                velocity: 0,
            },
        }
    }

    fn phase_at(&self, t: Ticks) -> Option<&Phase> {
        if t >= self.end {
            return None;
        }
        self.phases().iter().rev().find(|phase| phase.start() <= t)
    }
}

/// Strings phases together, in a frame whose zero is the start and whose positive direction is that of the motion.
///
/// Working in this frame makes a mirrored motion the exact mirror image, bit by bit.
struct Course<'a> {
    plan: &'a mut Plan,
    origin: i128,
    reverse: bool,
    elapsed: Offset,
    travelled: i128,
}

impl<'a> Course<'a> {
    /// Begins to write over `plan`: from now on nothing may fail.
    fn new(plan: &'a mut Plan, start: Ticks, from: Exact, reverse: bool) -> Self {
        plan.start = start;
        plan.count = 0;
        Self {
            plan,
            origin: from.position,
            reverse,
            elapsed: 0,
            travelled: 0,
        }
    }

    /// Brakes from `speed` against the direction of the motion to standstill, which takes `time` and `way`.
    fn turn_back(&mut self, speed: u128, half_deceleration: u128, time: Offset, way: u128) {
        let curve = self.curve(
            speed.cast_signed().wrapping_neg(),
            half_deceleration.cast_signed(),
        );
        self.append(curve, time, way.cast_signed().wrapping_neg());
    }

    /// Brakes from `speed`, to less or to standstill. Returns the way.
    #[inline(never)]
    fn brake(&mut self, speed: u128, half_deceleration: u128, time: Offset) -> u128 {
        let way = ramp_way(speed, half_deceleration, time, true);
        let curve = self.curve(
            speed.cast_signed(),
            half_deceleration.cast_signed().wrapping_neg(),
        );
        self.append(curve, time, way.cast_signed());
        way
    }

    /// Accelerates from `speed`. Returns the way.
    fn accelerate(&mut self, speed: u128, half_acceleration: u128, time: Offset) -> u128 {
        let way = ramp_way(speed, half_acceleration, time, false);
        let curve = self.curve(speed.cast_signed(), half_acceleration.cast_signed());
        self.append(curve, time, way.cast_signed());
        way
    }

    /// Keeps `speed` over `way`.
    fn cruise(&mut self, speed: u128, time: Offset, way: u128) {
        let curve = self.curve(speed.cast_signed(), 0);
        self.append(curve, time, way.cast_signed());
    }

    /// Brakes to standstill exactly at `target`, in the frame.
    fn land(mut self, target: i128, half_deceleration: u128, time: Offset) {
        let begin = self.elapsed;
        self.elapsed = begin.saturating_add(time);
        let curve = Parabola {
            position: target,
            velocity: 0,
            half_acceleration: half_deceleration.cast_signed().wrapping_neg(),
        };
        self.push(curve, begin, self.elapsed);
        self.rest_at(target);
    }

    /// Ends the plan here, standing at `position` in the frame.
    fn rest_at(self, position: i128) {
        let end = self
            .plan
            .start
            .saturating_add(ticks_up(self.elapsed))
            .min(Ticks::MAX - 1);
        let turned = if self.reverse {
            position.wrapping_neg()
        } else {
            position
        };
        self.plan.end = end;
        self.plan.rest = self.origin.wrapping_add(turned);
    }

    /// Keeps `speed` for ever.
    fn never_end(mut self, speed: u128) {
        self.cruise(speed, 0, 0);
        self.plan.end = Ticks::MAX;
        self.plan.rest = self.origin;
    }

    /// A curve that begins here.
    fn curve(&self, velocity: i128, half_acceleration: i128) -> Parabola {
        Parabola {
            position: self.travelled,
            velocity,
            half_acceleration,
        }
    }

    /// Adds a phase that is anchored at its beginning.
    #[inline(never)]
    fn append(&mut self, curve: Parabola, time: Offset, way: i128) {
        self.push(curve, self.elapsed, self.elapsed);
        self.elapsed = self.elapsed.saturating_add(time);
        self.travelled = self.travelled.wrapping_add(way);
    }

    #[inline(never)]
    fn push(&mut self, curve: Parabola, begin: Offset, anchor: Offset) {
        let plan = &mut *self.plan;
        let start = plan.start.saturating_add(ticks_up(begin));
        // A phase that ended before its first tick came is written over.
        let last = usize::from(plan.count).checked_sub(1);
        let last = last.and_then(|last| plan.phases.get(last));
        if last.is_none_or(|last| last.start() != start) {
            plan.count = plan.count.saturating_add(1);
        }
        let place = usize::from(plan.count).wrapping_sub(1);
        if let Some(place) = plan.phases.get_mut(place) {
            *place = curve.phase(plan.start, start, anchor, self.origin, self.reverse);
        }
    }
}

#[cfg(test)]
mod tests;

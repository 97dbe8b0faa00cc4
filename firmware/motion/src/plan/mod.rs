//! Plans: where the axis is at every tick, in closed form.
//!
//! A plan is a list of phases, each a polynomial of degree 3 at most. It is made once, from a state, a goal and limits, and then only evaluated.
//! Two rules make it exact: the braking phase of a move is anchored at its target, so that it lands there whatever
//! was rounded before; and limits are rounded down, so that they are never exceeded. What that costs in speed is paid
//! by the cruise.
//!
//! A plan keeps pieces: ramps and cruises, at most [`MOST_PIECES`]. A phase is worked out of them when it is asked for. Whoever follows a plan
//! enters each phase once; most plans are left before their last.
//!
//! After CiA 402-2, the profile deceleration (6084h) rules whenever the speed falls and the profile acceleration (6083h)
//! whenever it grows, in either direction.

mod builder;
mod goal;
#[cfg(feature = "limited-jerk")]
mod jerk_limited;
mod lead;
mod move_to;
pub(crate) mod phase;
mod piece;
mod sine;
mod smooth;
mod velocity;

use crate::clock::{Clock, Ticks};
use crate::exact::{PositionQ96, Q96, Q128};
use crate::fixed::{Exact, State};
use crate::speed::{SignedSpeed, Speed};
use crate::stepper::polynomial::Polynomial;
use builder::Origin;
pub use goal::{Goal, Limits, PlanError, Ramps, SIN_SQUARED};
use heapless::Vec;
pub(crate) use lead::InitialState;
use phase::Phase;
use piece::{Frame, Piece};
use smooth::{SMOOTH, Smooth};

/// A lead, leaving the wrong direction; then acceleration, cruise, braking, and the velocity that is kept. Linear ramps have no lead; a jerk-limited ramp
/// is three pieces.
pub const MOST_PIECES: usize = if cfg!(feature = "limited-jerk") {
    11
} else if SMOOTH {
    6
} else {
    5
};

/// What a plan was made for.
type Order = (Goal, Limits, Ramps);

/// A motion in closed form.
#[derive(Debug, Clone)]
pub struct Plan {
    frame: Frame,
    /// `Ticks::MAX` if it never ends.
    end: Ticks,
    pieces: Vec<Piece, MOST_PIECES>,
    /// The phase that was entered, and the first tick behind it.
    entered: Option<(Phase, Ticks)>,
    /// The position from `end` on.
    rest: PositionQ96,
    /// The first tick of the ramp to rest, or of the last ramp there is.
    last_ramp: Ticks,
    /// What the plan was made for, if its ramps are smooth.
    order: Smooth<Option<Order>>,
    /// A sixth of the jerk of its ramps; 0 if it is not limited.
    sixth_jerk: Smooth<Q128>,
}

impl Plan {
    /// Standing at a whole step (modulo 2³²) from tick `start` on.
    pub const fn at_rest(position_steps: i64, start: Ticks) -> Self {
        let rest = PositionQ96::from_steps(position_steps);
        Self {
            frame: Frame {
                start,
                origin: rest,
                reverse: false,
            },
            end: start,
            pieces: Vec::new(),
            entered: None,
            rest,
            last_ramp: start,
            order: Smooth::new(None),
            sixth_jerk: Smooth::new(Q128::ZERO),
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
        let start = InitialState::steady(start, from.into());
        plan.make(clock, &start, goal, limits, ramps)?;
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
    /// has at tick `at`, and keeps that velocity. Where the distance is too short for it, it comes about behind the target. The
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
        let mut next = self.clone();
        next.replan(
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
        let mut next = self.clone();
        next.replan(clock, at, Goal::Velocity(velocity), limits, Ramps::Linear)?;
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
    pub fn replan(
        &mut self,
        clock: Clock,
        at: Ticks,
        goal: Goal,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), PlanError> {
        let mut start = InitialState::steady(at, Exact::at_rest(PositionQ96::ZERO));
        self.leave(&mut start);
        if !start.is_for(goal, limits, ramps) {
            self.make(clock, &start, goal, limits, ramps)?;
        }
        Ok(())
    }

    /// Makes a plan from a motion. On an error the plan stays as it was.
    pub(crate) fn make(
        &mut self,
        clock: Clock,
        start: &InitialState,
        goal: Goal,
        limits: Limits,
        ramps: Ramps,
    ) -> Result<(), PlanError> {
        let mut origin = Origin::steady(start.tick, start.from);
        match ramps {
            Ramps::MovingAverage(0) => return Err(PlanError::ZeroJerk),
            Ramps::SinSquared if SIN_SQUARED => {
                start.begin_smoothly(clock, goal, limits, &mut origin);
            }
            Ramps::Linear | Ramps::SinSquared | Ramps::MovingAverage(_) => {}
            #[cfg(feature = "limited-jerk")]
            Ramps::JerkLimited(0) => return Err(PlanError::ZeroJerk),
            #[cfg(feature = "limited-jerk")]
            Ramps::JerkLimited(jerk) => {
                let jerk = clock.sixth_jerk(jerk).max(start.sixth_jerk());
                jerk_limited::plan(self, clock, start, goal, limits, jerk)?;
                self.sixth_jerk = Smooth::new(jerk);
                self.order = Smooth::new(Some((goal, limits, ramps)));
                return Ok(());
            }
        }
        self.build(clock, &origin, (goal, limits))
    }

    /// Makes a plan with linear or sin² ramps, as its origin says.
    fn build(
        &mut self,
        clock: Clock,
        origin: &Origin,
        (goal, limits): (Goal, Limits),
    ) -> Result<(), PlanError> {
        match goal {
            Goal::Rest(target) => {
                move_to::plan(self, clock, origin, (target, Speed::ZERO), limits)?;
            }
            // A target that is passed before anything new begins: the end velocity comes about behind it.
            Goal::Pass(target, end) if end != Speed::ZERO && origin.passes(target) => {
                let velocity = end.signed(origin.from.velocity < Q96::ZERO);
                velocity::plan(self, clock, origin, velocity, limits)?;
            }
            Goal::Pass(target, end) => move_to::plan(self, clock, origin, (target, end), limits)?,
            Goal::Velocity(velocity) => velocity::plan(self, clock, origin, velocity, limits)?,
        }
        self.sixth_jerk = Smooth::new(Q128::ZERO);
        let is_sine = *origin.is_sine.get();
        self.order = Smooth::new(is_sine.then_some((goal, limits, Ramps::SinSquared)));
        Ok(())
    }

    /// Takes over all of another plan, part by part: a copy of the whole would be on the stack as well. No phase of it is entered yet.
    pub(crate) fn assign(&mut self, from: &Self) {
        self.frame = from.frame;
        self.end = from.end;
        self.pieces.clear();
        // Both have the same room.
        let _ = self.pieces.extend_from_slice(&from.pieces);
        self.entered = None;
        self.rest = from.rest;
        self.last_ramp = from.last_ramp;
        self.order = from.order;
        self.sixth_jerk = from.sixth_jerk;
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
    pub fn phases(&self) -> impl Iterator<Item = Phase> {
        let mut corner = Some(self.frame.start);
        core::iter::from_fn(move || {
            let at = corner?;
            corner = self.next_corner(at);
            self.phase_at(at)
        })
    }

    /// The piece at tick `t`, and the first tick behind it.
    fn find_piece(&self, t: Ticks) -> Option<(&Piece, Ticks)> {
        let mut until = self.end;
        if t >= until {
            return None;
        }
        for piece in self.pieces.iter().rev() {
            if piece.start <= t {
                return Some((piece, until));
            }
            until = piece.start;
        }
        None
    }

    /// The next tick after `after` at which another phase begins or the plan ends; `None` if nothing changes any more.
    pub fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        if after < self.frame.start {
            return Some(self.frame.start);
        }
        let (piece, until) = self.find_piece(after)?;
        let corner = piece.next_corner((after, until));
        Some(corner).filter(|corner| *corner < Ticks::MAX)
    }

    /// How long it keeps its velocity between its two ramps, if it is one from rest to rest; in ticks.
    pub(crate) fn cruise(&self) -> Ticks {
        let line = self.pieces.iter().find(|piece| piece.is_line());
        line.map_or(0, |line| {
            let end = self.next_corner(line.start).unwrap_or(line.start);
            end - line.start
        })
    }

    /// How the plan goes on from tick `t`; `None` where it stands. The phase there is entered.
    pub(crate) fn polynomial_at(&mut self, t: Ticks) -> Option<Polynomial> {
        self.enter(t);
        let (phase, end) = self.entered.as_ref()?;
        Some(phase.polynomial(t, *end))
    }

    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        let t = t.max(self.frame.start);
        if let Some(phase) = self.entered(t) {
            return phase.at(t);
        }
        match self.phase_at(t) {
            Some(phase) => phase.at(t),
            None => Exact::at_rest(self.rest),
        }
    }

    /// The exact state, and the acceleration there.
    fn motion_at(&self, t: Ticks) -> (Exact, Q96) {
        let t = t.max(self.frame.start);
        let phase = self.entered(t).copied().or_else(|| self.phase_at(t));
        match phase {
            Some(phase) => (phase.at(t), phase.acceleration_exact(t)),
            None => (self.exact_at(t), Q96::ZERO),
        }
    }

    pub(crate) fn phase_at(&self, t: Ticks) -> Option<Phase> {
        let (piece, until) = self.find_piece(t)?;
        Some(piece.work_out((t, until), &self.frame).0)
    }

    /// The phase at tick `t`, if it is the one that was entered.
    #[inline]
    pub(crate) fn entered(&self, t: Ticks) -> Option<&Phase> {
        let (phase, until) = self.entered.as_ref()?;
        (t < *until && t >= phase.start()).then_some(phase)
    }

    /// Enters the phase at tick `t`: it need not be worked out again while the axis is in it.
    pub(crate) fn enter(&mut self, t: Ticks) {
        if self.entered(t).is_some() {
            return;
        }
        let found = self.find_piece(t);
        self.entered = found.map(|(piece, until)| piece.work_out((t, until), &self.frame));
    }

    /// Stands on the target from where it passes it on, and keeps no velocity there. Not true, and nothing changes, if it does not pass the target as
    /// it was asked to: the velocity comes about behind it.
    pub(crate) fn stop_at(&mut self, target_steps: i64) -> bool {
        let target = PositionQ96::from_steps(target_steps);
        if self.end != Ticks::MAX {
            return self.rest == target;
        }
        let passed = self
            .pieces
            .last()
            .filter(|piece| piece.is_line() && self.frame.place(piece.position) == target);
        let Some(passed) = passed.map(|piece| piece.start) else {
            return false;
        };
        self.end = passed.min(Ticks::MAX - 1);
        self.rest = target;
        self.pieces.pop();
        true
    }

    /// Where the motion comes to rest; `None` if it never does.
    pub(crate) fn destination(&self) -> Option<Exact> {
        self.end().map(|_| Exact::at_rest(self.rest))
    }
}

#[cfg(test)]
mod tests;

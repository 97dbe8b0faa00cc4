//! How pieces become a plan: one behind the other, from where the axis is.

use super::Plan;
use super::goal::{PlanError, SIN_SQUARED};
use super::move_to::distance_to;
use super::piece::{Frame, Instant, Piece, Shape, ramp_distance};
use super::sine::SHORTEST;
use super::smooth::Smooth;
use crate::clock::Ticks;
use crate::exact::{DistanceQ96, PositionQ96, Q96, Q128, TicksQ32, Uq96};
use crate::fixed::Exact;

/// Where a motion is planned from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Origin {
    /// The first tick of the plan.
    pub(super) start: Ticks,
    /// The lead: the end of a ramp under way, or the piece that brings its acceleration to zero. Its positions have the direction of the
    /// axis, and count from where it ends.
    pub(super) lead: Smooth<Option<Piece>>,
    /// The position at the start: of use for a goal that is passed.
    pub(super) begin: PositionQ96,
    /// When the lead ends, and where; without one, at the start.
    pub(super) end: Instant,
    pub(super) from: Exact,
    /// The ramps behind it are sin².
    pub(super) is_sine: Smooth<bool>,
}

impl Origin {
    /// With no acceleration.
    pub(super) const fn steady(start: Ticks, from: Exact) -> Self {
        Self {
            start,
            lead: Smooth::new(None),
            begin: from.position,
            end: Instant::from(start),
            from,
            is_sine: Smooth::new(false),
        }
    }

    /// Whether the lead passes this target.
    pub(super) fn passes(&self, target_steps: i64) -> bool {
        let is_back = |from| distance_to(target_steps, from).map(|(_, is_back)| is_back);
        self.lead.get().is_some() && is_back(self.begin) != is_back(self.from.position)
    }
}

/// Strings pieces together, in a frame whose zero is where the lead ends and whose positive direction is that of the motion.
pub(super) struct PlanBuilder<'a> {
    plan: &'a mut Plan,
    /// When the next piece begins, and its first tick.
    now: Instant,
    tick: Ticks,
    pub(super) travelled: PositionQ96,
    is_sine: Smooth<bool>,
    /// Pieces that are complete; the next one is written behind them.
    count: usize,
    /// A piece had no room.
    is_full: bool,
}

impl<'a> PlanBuilder<'a> {
    /// Begins to write over `plan`: from now on nothing may fail.
    pub(super) fn new(plan: &'a mut Plan, origin: &Origin, reverse: bool) -> Self {
        plan.frame = Frame {
            start: origin.start,
            origin: origin.from.position,
            reverse,
        };
        plan.pieces.clear();
        plan.last_ramp = origin.start;
        plan.entered = None;
        let mut builder = Self {
            plan,
            now: origin.end,
            tick: origin.end.tick_up(),
            travelled: PositionQ96::ZERO,
            is_sine: origin.is_sine,
            count: 0,
            is_full: false,
        };
        if let Some(lead) = *origin.lead.get()
            && builder.tick != origin.start
        {
            let lead = lead.seen_from(&builder.plan.frame);
            builder.write(lead);
            builder.count += 1;
        }
        builder
    }

    /// Brakes from `speed` against the direction of the motion to standstill, which takes `time` and `distance`.
    pub(super) fn brake_to_standstill(
        &mut self,
        speed: Uq96,
        half_deceleration: Uq96,
        time: TicksQ32,
        distance: DistanceQ96,
    ) {
        self.ramp(-speed.forwards(), half_deceleration.forwards(), time);
        self.go_on(time, -distance.forwards());
    }

    /// Brakes from `speed`, to less or to standstill. Returns the distance.
    #[inline(never)]
    pub(super) fn brake(
        &mut self,
        speed: Uq96,
        half_deceleration: Uq96,
        time: TicksQ32,
    ) -> DistanceQ96 {
        let distance = ramp_distance(speed, half_deceleration, time, true);
        self.ramp(speed.forwards(), -half_deceleration.forwards(), time);
        self.go_on(time, distance.forwards());
        distance
    }

    /// Accelerates from `speed`. Returns the distance.
    pub(super) fn accelerate(
        &mut self,
        speed: Uq96,
        half_acceleration: Uq96,
        time: TicksQ32,
    ) -> DistanceQ96 {
        let distance = ramp_distance(speed, half_acceleration, time, false);
        self.ramp(speed.forwards(), half_acceleration.forwards(), time);
        self.go_on(time, distance.forwards());
        distance
    }

    /// A ramp begins here.
    fn ramp(&mut self, velocity: Q96, half_acceleration: Q96, time: TicksQ32) {
        self.mark_ramp();
        let shape = self.shape(time);
        self.write(Piece {
            start: self.tick,
            anchor: self.now,
            position: self.travelled,
            velocity,
            half_acceleration,
            shape: Smooth::new(shape),
        });
    }

    /// When the next piece begins.
    #[cfg(feature = "limited-jerk")]
    pub(super) const fn now(&self) -> Instant {
        self.now
    }

    /// Another piece, which lasts so long, wherever it is anchored.
    #[cfg(feature = "limited-jerk")]
    pub(super) fn add(&mut self, piece: Piece, time: TicksQ32) {
        self.write(Piece {
            start: self.tick,
            ..piece
        });
        self.go_on(time, PositionQ96::ZERO);
    }

    /// Keeps `speed` over `distance`.
    pub(super) fn cruise(&mut self, speed: Uq96, time: TicksQ32, distance: DistanceQ96) {
        self.write(Piece {
            start: self.tick,
            anchor: self.now,
            position: self.travelled,
            velocity: speed.forwards(),
            half_acceleration: Q96::ZERO,
            shape: Smooth::new(Shape::Cubic(Q128::ZERO)),
        });
        self.go_on(time, distance.forwards());
    }

    /// Brakes to standstill exactly at `target`, in the frame.
    pub(super) fn brake_to_rest_at(
        mut self,
        target: PositionQ96,
        half_deceleration: Uq96,
        time: TicksQ32,
    ) -> Result<(), PlanError> {
        self.brake_to((target, Uq96::ZERO), half_deceleration, time);
        self.rest_at(target)
    }

    /// Brakes for `time`, passes `target` at `speed`, and keeps that.
    pub(super) fn brake_through(
        mut self,
        target: PositionQ96,
        half_deceleration: Uq96,
        time: TicksQ32,
        speed: Uq96,
    ) -> Result<(), PlanError> {
        self.brake_to((target, speed), half_deceleration, time);
        self.travelled = target;
        self.keep(speed)
    }

    /// Brakes for `time`, to a speed at a position: the ramp is anchored there.
    fn brake_to(
        &mut self,
        (position, speed): (PositionQ96, Uq96),
        half_deceleration: Uq96,
        time: TicksQ32,
    ) {
        self.mark_ramp();
        let shape = self.shape(time);
        let half = half_deceleration.forwards();
        self.write(Piece {
            start: self.tick,
            anchor: self.now.after(time),
            position,
            velocity: speed.forwards(),
            half_acceleration: match shape {
                Shape::Cubic(_) => -half,
                // The velocity at the other end is greater.
                Shape::Sine(_) => half,
            },
            shape: Smooth::new(shape),
        });
        self.go_on(time, PositionQ96::ZERO);
    }

    /// The last ramp begins, as far as is known.
    pub(super) fn mark_ramp(&mut self) {
        self.plan.last_ramp = self.tick;
    }

    /// Ends the plan here, standing at `position` in the frame.
    pub(super) fn rest_at(self, position: PositionQ96) -> Result<(), PlanError> {
        self.plan.end = self.tick.min(Ticks::MAX - 1);
        self.plan.rest = self.plan.frame.place(position);
        self.finish()
    }

    /// Keeps `speed`; the plan has no end.
    pub(super) fn keep(mut self, speed: Uq96) -> Result<(), PlanError> {
        self.cruise(speed, TicksQ32::ZERO, DistanceQ96::ZERO);
        self.count += 1;
        self.plan.end = Ticks::MAX;
        self.plan.rest = self.plan.frame.origin;
        self.finish()
    }

    /// A plan that lacks a piece goes on with its last one; the error makes the caller stop it.
    fn finish(self) -> Result<(), PlanError> {
        if self.is_full {
            self.plan.end = Ticks::MAX;
            self.plan.order = Smooth::new(None);
            return Err(PlanError::Internal);
        }
        self.plan.pieces.truncate(self.count);
        Ok(())
    }

    /// The shape of a ramp that lasts so long.
    fn shape(&self, time: TicksQ32) -> Shape {
        if SIN_SQUARED && *self.is_sine.get() && time >= SHORTEST {
            Shape::Sine(time)
        } else {
            Shape::Cubic(Q128::ZERO)
        }
    }

    /// The piece lasts so long and goes so far. If it has ended before its first tick comes, the next one is written over it.
    fn go_on(&mut self, time: TicksQ32, distance: PositionQ96) {
        self.now = self.now.after(time);
        let tick = self.now.tick_up();
        if tick != self.tick {
            self.count += 1;
            self.tick = tick;
        }
        self.travelled = self.travelled + distance;
    }

    /// Writes the piece that comes next, or writes over it.
    fn write(&mut self, piece: Piece) {
        self.plan.pieces.truncate(self.count);
        self.is_full |= self.plan.pieces.push(piece).is_err();
    }
}

//! How jerk-limited ramps become pieces of a plan.
//!
//! The first piece begins with what the ramp begins with, and the last one is anchored at its end; the one at constant acceleration between
//! them is led back from there.

use super::Rules;
use super::number::Number;
use super::ramp::{Motion, Ramp, VirtualStart, third};
use super::rough::Kind;
use crate::exact::{DistanceQ96, PositionQ96, Q96, Q128, TicksQ32, with_sign};
use crate::plan::PlanError;
use crate::plan::builder::PlanBuilder;
use crate::plan::piece::{Piece, Shape};
use crate::plan::smooth::Smooth;

impl PlanBuilder<'_> {
    /// Moves from rest over `distance` to `goal` in the frame, with the velocity `end` there. Where the distance is too short for that, it comes
    /// about behind the target. Velocity zero never covers a distance: the lowest has to do then.
    pub(super) fn move_from_rest(
        self,
        (distance, end, goal): (DistanceQ96, Q96, PositionQ96),
        rules: &Rules<'_>,
    ) -> Result<(), PlanError> {
        let mut virtual_start = VirtualStart::steady(Q96::ZERO, false);
        let cruise = rules.fastest(&Motion::REST, end, distance, &mut virtual_start);
        if cruise.is_some() || end.is_zero() {
            let cruise = cruise.unwrap_or(Q96::LEAST);
            self.append_move(
                (&Motion::REST, &virtual_start),
                cruise,
                (distance, end, goal),
                rules,
            )
        } else {
            self.ramp_to(&Motion::REST, end, rules)
        }
    }

    /// Ramps from a motion to the velocity `end`, and keeps it.
    pub(super) fn ramp_to(
        mut self,
        from: &Motion,
        end: Q96,
        rules: &Rules<'_>,
    ) -> Result<(), PlanError> {
        self.append_ramp(&rules.ramp(from, end));
        self.keep(end.amount())
    }

    /// Follows a ramp to the velocity `cruise`, and another one to `end`, over `distance`, to `goal` in the frame.
    pub(super) fn append_move(
        mut self,
        (from, virtual_start): (&Motion, &VirtualStart),
        cruise: Q96,
        (distance, end, goal): (DistanceQ96, Q96, PositionQ96),
        rules: &Rules<'_>,
    ) -> Result<(), PlanError> {
        let limit = if virtual_start.falls {
            rules.deceleration
        } else {
            rules.acceleration
        };
        let (mut first, mut last) = (Ramp::NONE, Ramp::NONE);
        first.become_of((from, virtual_start), cruise, limit, rules.jerk);
        last.become_steady((cruise, true), end, rules.deceleration, rules.jerk);
        let ramps = (first.distance + last.distance).bits().cast_unsigned();
        let left = distance.bits().wrapping_sub(ramps);
        // The ramps may be longer than the distance by what is rounded; two of 2³¹ steps are.
        let is_longer = left > distance.bits() || first.distance.bits() & last.distance.bits() < 0;
        let left = if is_longer { 0 } else { left };
        let speed = Number::of(cruise.bits(), Kind::Velocity);
        let time = Number::of((left >> 1).cast_signed(), Kind::Distance)
            .times(speed.reciprocal())
            .doubled()
            .fixed(Kind::Time)
            .max(0);
        let time = TicksQ32::from_bits(time.cast_unsigned());
        self.append_ramp(&first);
        self.cruise(cruise.amount(), time, DistanceQ96::from_bits(left));
        self.append_ramp_ending_at(&last, goal);
        if end.is_zero() {
            self.rest_at(goal)
        } else {
            self.keep(end.amount())
        }
    }

    /// Follows a ramp from here.
    pub(super) fn append_ramp(&mut self, ramp: &Ramp) {
        self.append_ramp_ending_at(ramp, self.travelled + ramp.distance);
    }

    /// Follows a ramp so that it ends exactly at `target`, in the frame.
    pub(super) fn append_ramp_ending_at(&mut self, ramp: &Ramp, target: PositionQ96) {
        let jerk = with_sign(ramp.sixth_jerk, ramp.falls);
        let begin = self.now();
        let held = begin.after(ramp.entry).after(ramp.hold);
        self.mark_ramp();
        let entry = Piece {
            start: 0,
            anchor: begin,
            position: self.travelled,
            velocity: ramp.velocity,
            half_acceleration: ramp.acceleration.halved(),
            shape: Smooth::new(Shape::Cubic(with_sign(jerk, ramp.is_easing))),
        };
        self.add(entry, ramp.entry);
        // It ends with the state in which the last one begins: v − a·t/2 and x − v·t + a·t²/6.
        let gain = ramp.most.amount().gain(ramp.exit).halved();
        let mean = ramp.end - with_sign(third(gain).forwards(), ramp.falls);
        let hold = Piece {
            anchor: held,
            position: target - mean.distance(ramp.exit),
            velocity: ramp.end - with_sign(gain.forwards(), ramp.falls),
            half_acceleration: with_sign(ramp.most, ramp.falls).halved(),
            shape: Smooth::new(Shape::Cubic(Q128::ZERO)),
            ..entry
        };
        self.add(hold, ramp.hold);
        let exit = Piece {
            anchor: held.after(ramp.exit),
            position: target,
            velocity: ramp.end,
            half_acceleration: Q96::ZERO,
            shape: Smooth::new(Shape::Cubic(-jerk)),
            ..entry
        };
        self.add(exit, ramp.exit);
        self.travelled = target;
    }
}

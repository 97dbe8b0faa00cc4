//! How jerk-limited ramps become pieces of a plan.
//!
//! The first piece begins with what the ramp begins with, and the last one is anchored at its end; the one at constant acceleration between
//! them is led back from there.

use super::Rules;
use super::number::Number;
use super::ramp::{Motion, Ramp, VirtualStart, third};
use super::rough::Kind;
use crate::plan::PlanError;
use crate::plan::builder::PlanBuilder;
use crate::plan::piece::{Piece, Shape, distance_at, over_time};
use crate::plan::smooth::Smooth;

impl PlanBuilder<'_> {
    /// Moves from rest over `distance` to `goal` in the frame, with the velocity `end` there. Where the distance is too short for that, it comes
    /// about behind the target. Velocity zero never covers a distance: the lowest has to do then.
    pub(super) fn move_from_rest(
        self,
        (distance, end, goal): (u128, i128, i128),
        rules: &Rules<'_>,
    ) -> Result<(), PlanError> {
        let mut virtual_start = VirtualStart::steady(0, false);
        let cruise = rules.fastest(&Motion::REST, end, distance, &mut virtual_start);
        if cruise.is_some() || end == 0 {
            let cruise = cruise.unwrap_or(1);
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
        end: i128,
        rules: &Rules<'_>,
    ) -> Result<(), PlanError> {
        self.append_ramp(&rules.ramp(from, end));
        self.keep(end.unsigned_abs())
    }

    /// Follows a ramp to the velocity `cruise`, and another one to `end`, over `distance`, to `goal` in the frame.
    pub(super) fn append_move(
        mut self,
        (from, virtual_start): (&Motion, &VirtualStart),
        cruise: i128,
        (distance, end, goal): (u128, i128, i128),
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
        let ramps = first.distance.wrapping_add(last.distance).cast_unsigned();
        let left = distance.wrapping_sub(ramps);
        // The ramps may be longer than the distance by what is rounded; two of 2³¹ steps are.
        let is_longer = left > distance || first.distance & last.distance < 0;
        let left = if is_longer { 0 } else { left };
        let speed = Number::of(cruise, Kind::Velocity);
        let time = Number::of((left >> 1).cast_signed(), Kind::Distance)
            .times(speed.reciprocal())
            .doubled()
            .fixed(Kind::Time)
            .max(0)
            .cast_unsigned();
        self.append_ramp(&first);
        self.cruise(cruise.unsigned_abs(), time, left);
        self.append_ramp_ending_at(&last, goal);
        if end == 0 {
            self.rest_at(goal)
        } else {
            self.keep(end.unsigned_abs())
        }
    }

    /// Follows a ramp from here.
    pub(super) fn append_ramp(&mut self, ramp: &Ramp) {
        self.append_ramp_ending_at(ramp, self.travelled.wrapping_add(ramp.distance));
    }

    /// Follows a ramp so that it ends exactly at `target`, in the frame.
    pub(super) fn append_ramp_ending_at(&mut self, ramp: &Ramp, target: i128) {
        let turned = |value: i128| if ramp.falls { -value } else { value };
        let jerk = turned(ramp.sixth_jerk);
        let begin = self.now();
        let held = begin.after(ramp.entry).after(ramp.hold);
        self.mark_ramp();
        let entry = Piece {
            start: 0,
            anchor: begin,
            position: self.travelled,
            velocity: ramp.velocity,
            half_acceleration: ramp.acceleration >> 1,
            shape: Smooth::new(Shape::Cubic(if ramp.is_easing { -jerk } else { jerk })),
        };
        self.add(entry, ramp.entry);
        // It ends with the state in which the last one begins: v − a·t/2 and x − v·t + a·t²/6.
        let gain = over_time(ramp.most.cast_unsigned(), ramp.exit) >> 1;
        let mean = ramp.end - turned(third(gain).cast_signed());
        let hold = Piece {
            anchor: held,
            position: target.wrapping_sub(distance_at(mean, ramp.exit)),
            velocity: ramp.end - turned(gain.cast_signed()),
            half_acceleration: turned(ramp.most) >> 1,
            shape: Smooth::NONE,
            ..entry
        };
        self.add(hold, ramp.hold);
        let exit = Piece {
            anchor: held.after(ramp.exit),
            position: target,
            velocity: ramp.end,
            half_acceleration: 0,
            shape: Smooth::new(Shape::Cubic(-jerk)),
            ..entry
        };
        self.add(exit, ramp.exit);
        self.travelled = target;
    }
}

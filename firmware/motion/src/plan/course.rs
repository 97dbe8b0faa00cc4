//! How phases become a plan: one behind the other, from where the axis is.

use super::Plan;
use super::phase::{Curve, Offset, Shape, ramp_way, ticks_up};
use super::ramp::Ramp;
use super::sine::Sine;
use crate::clock::Ticks;
use crate::fixed::Exact;

/// Strings phases together, in a frame whose zero is the start and whose positive direction is that of the motion.
///
/// Working in this frame makes a mirrored motion the exact mirror image, bit by bit.
pub(super) struct Course<'a> {
    plan: &'a mut Plan,
    origin: i128,
    reverse: bool,
    pub(super) elapsed: Offset,
    pub(super) travelled: i128,
    /// Ramps are drawn as sin².
    is_sine: bool,
}

impl<'a> Course<'a> {
    /// Begins to write over `plan`: from now on nothing may fail.
    pub(super) fn new(plan: &'a mut Plan, start: Ticks, from: Exact, reverse: bool) -> Self {
        plan.start = start;
        plan.count = 0;
        plan.last_ramp = start;
        Self {
            is_sine: plan.is_sine,
            plan,
            origin: from.position,
            reverse,
            elapsed: 0,
            travelled: 0,
        }
    }

    /// Brakes from `speed` against the direction of the motion to standstill, which takes `time` and `way`.
    pub(super) fn turn_back(
        &mut self,
        speed: u128,
        half_deceleration: u128,
        time: Offset,
        way: u128,
    ) {
        let speed = speed.cast_signed().wrapping_neg();
        let curve = self.changing(speed, half_deceleration.cast_signed(), time);
        self.append(&curve, time, way.cast_signed().wrapping_neg());
    }

    /// Brakes from `speed`, to less or to standstill. Returns the way.
    #[inline(never)]
    pub(super) fn brake(&mut self, speed: u128, half_deceleration: u128, time: Offset) -> u128 {
        let way = ramp_way(speed, half_deceleration, time, true);
        let falling = half_deceleration.cast_signed().wrapping_neg();
        let curve = self.changing(speed.cast_signed(), falling, time);
        self.append(&curve, time, way.cast_signed());
        way
    }

    /// Accelerates from `speed`. Returns the way.
    pub(super) fn accelerate(
        &mut self,
        speed: u128,
        half_acceleration: u128,
        time: Offset,
    ) -> u128 {
        let way = ramp_way(speed, half_acceleration, time, false);
        let curve = self.changing(speed.cast_signed(), half_acceleration.cast_signed(), time);
        self.append(&curve, time, way.cast_signed());
        way
    }

    /// Keeps `speed` over `way`.
    pub(super) fn cruise(&mut self, speed: u128, time: Offset, way: u128) {
        let shape = Shape {
            position: self.travelled,
            velocity: speed.cast_signed(),
            half_acceleration: 0,
            curve: Curve::Parabola,
        };
        self.append(&shape, time, way.cast_signed());
    }

    /// Brakes to standstill exactly at `target`, in the frame.
    pub(super) fn land(mut self, target: i128, half_deceleration: u128, time: Offset) {
        let begin = self.elapsed;
        self.elapsed = begin.saturating_add(time);
        self.mark_ramp(begin);
        let rising = half_deceleration.cast_signed();
        let shape = match self.sine(rising, time) {
            Some(sine) => Shape {
                position: target,
                velocity: 0,
                half_acceleration: half_peak(rising),
                curve: Curve::Sine(sine),
            },
            None => Shape {
                position: target,
                velocity: 0,
                half_acceleration: rising.wrapping_neg(),
                curve: Curve::Parabola,
            },
        };
        self.push(&shape, begin, self.elapsed);
        self.rest_at(target);
    }

    /// Follows a jerk-limited ramp.
    pub(super) fn ramp(&mut self, ramp: &Ramp) {
        self.mark_ramp(self.elapsed);
        for piece in ramp.pieces.iter().filter(|piece| piece.time != 0) {
            self.append(&piece.shape(self.travelled), piece.time, piece.shift());
        }
    }

    /// Follows a jerk-limited ramp to standstill exactly at `target`, in the frame: its last piece is anchored there.
    pub(super) fn land_on(mut self, ramp: &Ramp, target: i128) {
        self.mark_ramp(self.elapsed);
        let [first, second, last] = &ramp.pieces;
        for piece in [first, second].into_iter().filter(|piece| piece.time != 0) {
            self.append(&piece.shape(self.travelled), piece.time, piece.shift());
        }
        if last.time != 0 {
            let begin = self.elapsed;
            self.elapsed = begin.saturating_add(last.time);
            let shape = Shape {
                position: target,
                velocity: 0,
                half_acceleration: 0,
                curve: Curve::Cubic(last.sixth_jerk),
            };
            self.push(&shape, begin, self.elapsed);
        }
        self.rest_at(target);
    }

    /// The last ramp begins, as far as is known.
    pub(super) fn mark_ramp(&mut self, begin: Offset) {
        self.plan.last_ramp = self.plan.start.saturating_add(ticks_up(begin));
    }

    /// Ends the plan here, standing at `position` in the frame.
    pub(super) fn rest_at(self, position: i128) {
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
    pub(super) fn never_end(mut self, speed: u128) {
        self.cruise(speed, 0, 0);
        self.plan.end = Ticks::MAX;
        self.plan.rest = self.origin;
    }

    /// A ramp that begins here.
    pub(super) fn changing(
        &mut self,
        velocity: i128,
        half_acceleration: i128,
        time: Offset,
    ) -> Shape {
        self.mark_ramp(self.elapsed);
        let (half_acceleration, curve) = match self.sine(half_acceleration, time) {
            Some(sine) => (half_peak(half_acceleration), Curve::Sine(sine)),
            None => (half_acceleration, Curve::Parabola),
        };
        Shape {
            position: self.travelled,
            velocity,
            half_acceleration,
            curve,
        }
    }

    /// The sin² ramp that takes the place of a linear one, if ramps are sin².
    pub(super) fn sine(&self, half_acceleration: i128, time: Offset) -> Option<Sine> {
        if !self.is_sine || time == 0 {
            return None;
        }
        let change = half_acceleration.unsigned_abs().wrapping_mul(time) >> 31;
        let change = change.cast_signed();
        let change = if half_acceleration < 0 {
            change.wrapping_neg()
        } else {
            change
        };
        Some(Sine::new(change, time))
    }

    /// Adds a phase that is anchored at its beginning.
    #[inline]
    pub(super) fn append(&mut self, curve: &Shape, time: Offset, way: i128) {
        self.push(curve, self.elapsed, self.elapsed);
        self.elapsed = self.elapsed.saturating_add(time);
        self.travelled = self.travelled.wrapping_add(way);
    }

    #[inline(never)]
    pub(super) fn push(&mut self, curve: &Shape, begin: Offset, anchor: Offset) {
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
            curve.write(
                place,
                (plan.start, start),
                anchor,
                self.origin,
                self.reverse,
            );
        }
    }
}

/// The greatest acceleration of a sin² ramp, from that of the linear one in its place, both halved: π/2 times as much, and a little more
/// rather than less.
pub(super) const fn half_peak(half_acceleration: i128) -> i128 {
    let half = half_acceleration.unsigned_abs().cast_signed();
    (half.wrapping_mul(13) >> 3).wrapping_add(1)
}

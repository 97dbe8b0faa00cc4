//! How phases become a plan: one behind the other, from where the axis is.

use super::Plan;
use super::draft::{Draft, Follow};
use super::phase::{Bend, Frame, Instant, Offset, Piece, ramp_way};
use super::ramp::Ramp;
use super::second_leg::SecondLeg;
use crate::clock::{Clock, Ticks};
use crate::fixed::Exact;

/// Strings phases together, in a frame whose zero is the start and whose positive direction is that of the motion.
///
/// Working in this frame makes a mirrored motion the exact mirror image, bit by bit.
pub(super) struct Course<'a> {
    plan: &'a mut Plan,
    /// When the next phase begins, and its first tick.
    now: Instant,
    tick: Ticks,
    pub(super) travelled: i128,
    /// Ramps are drawn as sin².
    is_sine: bool,
}

impl<'a> Course<'a> {
    /// Begins to write over `plan`: from now on nothing may fail.
    pub(super) fn new(plan: &'a mut Plan, start: Ticks, from: Exact, reverse: bool) -> Self {
        plan.frame = Frame {
            start,
            origin: from.position,
            reverse,
        };
        plan.count = 0;
        plan.left = None;
        plan.last_ramp = start;
        plan.entered_until = 0;
        Self {
            is_sine: plan.is_sine,
            plan,
            now: Instant::from(start),
            tick: start,
            travelled: 0,
        }
    }

    /// Goes on where a plan waits.
    pub(super) fn resume(plan: &'a mut Plan) -> Option<Self> {
        let count = plan.count.checked_sub(1)?;
        let &Piece {
            start,
            anchor,
            position,
            ..
        } = &plan.drafts.get(usize::from(count))?.piece;
        plan.count = count;
        if plan.entered.start() >= start {
            plan.entered_until = 0;
        }
        Some(Self {
            is_sine: plan.is_sine,
            plan,
            now: anchor,
            tick: start,
            travelled: position,
        })
    }

    /// Stands here until the second leg is planned: so far, with that speed at the end, to there in the frame. Without a way it keeps the speed.
    pub(super) fn wait(self, clock: Clock, (way, end, goal): (u128, i128, i128)) {
        let plan = self.never_ending(0);
        plan.rest = plan.frame.place(goal);
        plan.left = Some(SecondLeg {
            clock,
            way,
            goal,
            end,
        });
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
        self.change(speed, half_deceleration.cast_signed(), time);
        self.go_on(time, way.cast_signed().wrapping_neg());
    }

    /// Brakes from `speed`, to less or to standstill. Returns the way.
    #[inline(never)]
    pub(super) fn brake(&mut self, speed: u128, half_deceleration: u128, time: Offset) -> u128 {
        let way = ramp_way(speed, half_deceleration, time, true);
        let falling = half_deceleration.cast_signed().wrapping_neg();
        self.change(speed.cast_signed(), falling, time);
        self.go_on(time, way.cast_signed());
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
        self.change(speed.cast_signed(), half_acceleration.cast_signed(), time);
        self.go_on(time, way.cast_signed());
        way
    }

    /// A linear ramp begins here, or the one that is drawn in its place.
    fn change(&mut self, velocity: i128, half_acceleration: i128, time: Offset) {
        self.mark_ramp();
        let bend = self.bend(time);
        if let Some(draft) = next(self.plan) {
            draft.ramp = None;
            draft.piece = Piece {
                start: self.tick,
                anchor: self.now,
                position: self.travelled,
                velocity,
                half_acceleration,
                bend,
            };
        }
    }

    /// Keeps `speed` over `way`.
    pub(super) fn cruise(&mut self, speed: u128, time: Offset, way: u128) {
        if let Some(draft) = next(self.plan) {
            draft.ramp = None;
            draft.piece = Piece {
                start: self.tick,
                anchor: self.now,
                position: self.travelled,
                velocity: speed.cast_signed(),
                half_acceleration: 0,
                bend: Bend::None,
            };
        }
        self.go_on(time, way.cast_signed());
    }

    /// Brakes to standstill exactly at `target`, in the frame.
    pub(super) fn land(mut self, target: i128, half_deceleration: u128, time: Offset) {
        self.mark_ramp();
        let bend = self.bend(time);
        let rising = half_deceleration.cast_signed();
        if let Some(draft) = next(self.plan) {
            draft.ramp = None;
            draft.piece = Piece {
                start: self.tick,
                anchor: self.now.after(time),
                position: target,
                velocity: 0,
                half_acceleration: match bend {
                    Bend::None => rising.wrapping_neg(),
                    _ => rising,
                },
                bend,
            };
        }
        self.go_on(time, 0);
        self.rest_at(target);
    }

    /// Brakes from a speed that takes `time` to rest, passes `target` at a speed that takes `end_time` and `end_way`, and keeps that.
    pub(super) fn pass(
        mut self,
        target: i128,
        half_deceleration: u128,
        time: Offset,
        (end_speed, end_time, end_way): (u128, Offset, u128),
    ) {
        self.mark_ramp();
        let braking = time.saturating_sub(end_time);
        let bend = self.bend(braking);
        let rising = half_deceleration.cast_signed();
        if let Some(draft) = next(self.plan) {
            draft.ramp = None;
            draft.piece = match bend {
                Bend::None => Piece {
                    start: self.tick,
                    anchor: self.now.after(time),
                    position: target.wrapping_add(end_way.cast_signed()),
                    velocity: 0,
                    half_acceleration: rising.wrapping_neg(),
                    bend,
                },
                _ => Piece {
                    start: self.tick,
                    anchor: self.now.after(braking),
                    position: target,
                    velocity: end_speed.cast_signed(),
                    half_acceleration: rising,
                    bend,
                },
            };
        }
        self.go_on(braking, 0);
        self.travelled = target;
        self.never_end(end_speed);
    }

    /// Another jerk-limited ramp of the plan, to be made and then followed.
    pub(super) fn ramp(&mut self, number: u8) -> &mut Ramp {
        self.plan.ramp_mut(number)
    }

    /// Follows a jerk-limited ramp of the plan.
    pub(super) fn follow(&mut self, number: u8) {
        let way = self.ramp(number).way;
        self.follow_to(number, false, self.travelled.wrapping_add(way));
    }

    /// Follows a jerk-limited ramp of the plan so that it ends exactly at `target`, in the frame; with `is_back` backwards in time.
    #[inline(never)]
    pub(super) fn follow_to(&mut self, number: u8, is_back: bool, target: i128) {
        self.mark_ramp();
        if let Some(draft) = next(self.plan) {
            draft.piece.start = self.tick;
            draft.piece.anchor = self.now;
            draft.piece.position = self.travelled;
            draft.ramp = Some(Follow {
                number,
                is_back,
                position: target,
            });
        }
        let time = self.ramp(number).time();
        self.go_on_to(time, target);
    }

    /// The last ramp begins, as far as is known.
    fn mark_ramp(&mut self) {
        self.plan.last_ramp = self.tick;
    }

    /// Ends the plan here, standing at `position` in the frame.
    pub(super) fn rest_at(self, position: i128) {
        self.plan.end = self.tick.min(Ticks::MAX - 1);
        self.plan.rest = self.plan.frame.place(position);
    }

    /// Keeps `speed` for ever.
    pub(super) fn never_end(self, speed: u128) {
        self.never_ending(speed);
    }

    fn never_ending(mut self, speed: u128) -> &'a mut Plan {
        self.cruise(speed, 0, 0);
        self.plan.count = self.plan.count.wrapping_add(1);
        self.plan.end = Ticks::MAX;
        self.plan.rest = self.plan.frame.origin;
        self.plan
    }

    /// How a ramp is drawn that lasts so long.
    fn bend(&self, time: Offset) -> Bend {
        if self.is_sine && time != 0 {
            Bend::Sine(time)
        } else {
            Bend::None
        }
    }

    /// The phase lasts so long and goes so far. If it has ended before its first tick comes, the next one is written over it.
    fn go_on(&mut self, time: Offset, way: i128) {
        self.go_on_to(time, self.travelled.wrapping_add(way));
    }

    /// The same to a place in the frame.
    fn go_on_to(&mut self, time: Offset, position: i128) {
        self.now = self.now.after(time);
        let tick = self.now.tick_up();
        if tick != self.tick {
            self.plan.count = self.plan.count.wrapping_add(1);
            self.tick = tick;
        }
        self.travelled = position;
    }
}

/// Where the next phase is written.
#[inline]
fn next(plan: &mut Plan) -> Option<&mut Draft> {
    plan.drafts.get_mut(usize::from(plan.count))
}

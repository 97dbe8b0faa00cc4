//! What a plan keeps of its phases until they are entered: most of a plan may never be reached.
//!
//! A jerk-limited ramp is one draft, whose pieces are worked out one by one. The first begins with what the ramp begins with, and the last
//! is anchored at its end; the one at constant acceleration between them is led back from there. So planning needs of all three no more
//! than how long they take.

use super::Plan;
use super::phase::{Bend, Frame, Instant, Phase, Piece, over_time};
use super::ramp::{Ramp, third, way_at};
use crate::clock::Ticks;

/// The most ramps of a plan: to rest, to a velocity, and to another one. There is one more, so that coming to rest can be looked into
/// while the plan still is the one before.
pub(super) const MOST_RAMPS: usize = 4;

/// A phase, or all those of a jerk-limited ramp.
#[derive(Debug, Clone, Copy)]
pub(super) struct Draft {
    /// The phase. Of a ramp only when and where it begins.
    pub(super) piece: Piece,
    pub(super) ramp: Option<Follow>,
}

/// A ramp is followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Follow {
    /// Which one of the plan's.
    pub(super) number: u8,
    /// It leads from rest to a velocity, and is followed backwards in time.
    pub(super) is_back: bool,
    /// Where it ends.
    pub(super) position: i128,
}

impl Draft {
    pub(super) const NONE: Self = Self {
        piece: Piece::NONE,
        ramp: None,
    };

    /// Its first tick.
    pub(super) const fn start(&self) -> Ticks {
        self.piece.start
    }

    /// Whether its velocity stays.
    pub(super) const fn is_line(&self) -> bool {
        self.ramp.is_none() && self.piece.is_line()
    }

    /// The ticks at which its phases begin, some of them at the same.
    pub(super) fn corners(&self, ramps: &[Ramp]) -> impl Iterator<Item = Ticks> {
        let ramp = self.ramp.as_ref().and_then(|follow| follow.ramp(ramps));
        let [entered, held] = ramp.map_or([self.start(); 2], |ramp| {
            let entered = self.piece.anchor.after(ramp.entry);
            [entered.tick_up(), entered.after(ramp.hold).tick_up()]
        });
        [self.start(), entered, held].into_iter()
    }

    /// Writes the phase at tick `t`, which lies within the draft. Returns the first tick behind it; `until` is that behind the draft.
    pub(super) fn work_out(
        &self,
        ramps: &[Ramp],
        (t, until): (Ticks, Ticks),
        frame: &Frame,
        phase: &mut Phase,
    ) -> Ticks {
        let Some(follow) = &self.ramp else {
            self.piece.work_out(frame, phase);
            return until;
        };
        let Some(ramp) = follow.ramp(ramps) else {
            return until;
        };
        let entered = self.piece.anchor.after(ramp.entry);
        let corner = entered.tick_up();
        if t < corner {
            follow.entry(ramp, &self.piece).work_out(frame, phase);
            return corner.min(until);
        }
        let held = entered.after(ramp.hold);
        let end = held.tick_up();
        if t < end {
            follow.hold(ramp, (corner, held)).work_out(frame, phase);
            return end.min(until);
        }
        let over = held.after(ramp.exit);
        follow.exit(ramp, (end, over)).work_out(frame, phase);
        until
    }
}

impl Follow {
    #[inline]
    fn ramp<'a>(&self, ramps: &'a [Ramp]) -> Option<&'a Ramp> {
        ramps.get(usize::from(self.number))
    }

    /// The velocity at the end.
    fn velocity(&self, ramp: &Ramp) -> i128 {
        if self.is_back { 0 } else { ramp.end }
    }

    /// What is positive in the direction of the change.
    fn turned(&self, ramp: &Ramp, value: i128) -> i128 {
        if ramp.falls == self.is_back {
            value
        } else {
            value.wrapping_neg()
        }
    }

    /// The piece in which the acceleration goes to its greatest value.
    fn entry(&self, ramp: &Ramp, begin: &Piece) -> Piece {
        let sixth_jerk = self.turned(ramp, ramp.sixth_jerk);
        Piece {
            velocity: if self.is_back {
                ramp.end
            } else {
                ramp.velocity
            },
            half_acceleration: ramp.acceleration >> 1,
            bend: Bend::Jerk(if ramp.is_easing {
                sixth_jerk.wrapping_neg()
            } else {
                sixth_jerk
            }),
            ..*begin
        }
    }

    /// The piece at constant acceleration. It ends with the state in which the last one begins: v − a·t/2 and x − v·t + a·t²/6.
    fn hold(&self, ramp: &Ramp, (start, held): (Ticks, Instant)) -> Piece {
        let gain = over_time(ramp.most.cast_unsigned(), ramp.exit) >> 1;
        let velocity = self.velocity(ramp);
        let third = third(gain).cast_signed();
        let mean = velocity.wrapping_sub(self.turned(ramp, third));
        Piece {
            start,
            anchor: held,
            position: self.position.wrapping_sub(way_at(mean, ramp.exit)),
            velocity: velocity.wrapping_sub(self.turned(ramp, gain.cast_signed())),
            half_acceleration: self.turned(ramp, ramp.most) >> 1,
            bend: Bend::None,
        }
    }

    /// The piece in which the acceleration goes to nothing.
    fn exit(&self, ramp: &Ramp, (start, over): (Ticks, Instant)) -> Piece {
        Piece {
            start,
            anchor: over,
            position: self.position,
            velocity: self.velocity(ramp),
            half_acceleration: 0,
            bend: Bend::Jerk(self.turned(ramp, ramp.sixth_jerk).wrapping_neg()),
        }
    }
}

impl Plan {
    /// One of the ramps: 1 and 2 are those to velocities.
    pub(super) fn ramp_mut(&mut self, number: u8) -> &mut Ramp {
        let [first, second, third, fourth] = &mut self.ramps;
        match number {
            0 => first,
            1 => second,
            2 => third,
            _ => fourth,
        }
    }

    /// The ramp to rest that the plan does not follow.
    pub(super) fn spare_ramp(&self) -> u8 {
        let [first, ..] = &self.drafts;
        match &first.ramp {
            Some(Follow { number: 0, .. }) => 3,
            _ => 0,
        }
    }
}

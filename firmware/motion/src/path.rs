//! A path through set-points that come one by one: where the axis is to be between them.
//!
//! A piece leads from one set-point to the next, in a straight line or as a cubic whose velocity is given at both ends. At its
//! last tick it is exactly on its set-point, so nothing adds up however many there are.
//!
//! A path whose next piece is late coasts: it goes on at its last velocity for a short while, then it stands.

use crate::clock::Ticks;
use crate::divide::fraction;
use crate::fixed::{Exact, Position, State, Velocity};

/// Pieces that are kept: the one that is becoming pulses, and those behind it.
const MOST_PIECES: usize = 4;

/// Why a set-point is not taken. The motion goes on as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FollowError {
    /// Its time is over, or nearly so.
    TooLate,
    /// More set-points lie ahead than are kept, or this one lies too far ahead.
    TooFarAhead,
}

impl core::fmt::Display for FollowError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TooLate => "the set-point comes too late",
            Self::TooFarAhead => "the set-point lies too far ahead",
        })
    }
}

impl core::error::Error for FollowError {}

/// How the axis goes from one set-point to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Manner {
    /// In a straight line.
    Straight,
    /// In a straight line at this velocity, which leads there but for what positions cannot tell.
    Steady(Velocity),
    /// On a cubic that ends with this velocity.
    Bent(Velocity),
}

/// From one set-point to the next.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: Ticks,
    /// In ticks, at least 1.
    length: u32,
    /// Of a cubic: ⌊2⁶⁴ / length⌋, or nearly so.
    inverse: u64,
    from: Position,
    to: Position,
    /// The velocity at the end, and all along a straight line, Q96.
    velocity: i128,
    /// Of a cubic: what belongs to u, u² and u³, where u goes from 0 to 1. Q32 steps.
    curve: Option<[i64; 3]>,
    /// The longest chord that stays within a quarter of a step.
    chord: u64,
}

impl Piece {
    /// The first tick behind it.
    const fn end(&self) -> Ticks {
        self.start.saturating_add(self.length as u64)
    }

    fn straight(start: Ticks, length: u32, from: Position, to: Position) -> Self {
        let way = to.bits().wrapping_sub(from.bits());
        Self {
            start,
            length,
            inverse: 0,
            from,
            to,
            velocity: rate(way, length),
            curve: None,
            chord: u64::MAX,
        }
    }

    /// The velocity is not worked out: rounded ways would make it another one, and in each piece.
    fn steady(start: Ticks, length: u32, from: Position, to: Position, velocity: Velocity) -> Self {
        Self {
            start,
            length,
            inverse: 0,
            from,
            to,
            velocity: velocity.exact(),
            curve: None,
            chord: u64::MAX,
        }
    }

    fn cubic(
        start: Ticks,
        length: u32,
        from: Position,
        to: Position,
        ends: (Velocity, Velocity),
    ) -> Self {
        let way = to.bits().wrapping_sub(from.bits());
        let (first, last) = (ends.0.way(length), ends.1.way(length));
        // x = from + a·u + b·u² + c·u³ with the way and both velocities given.
        let b = way
            .wrapping_mul(3)
            .wrapping_sub(first.wrapping_mul(2))
            .wrapping_sub(last);
        let c = first.wrapping_add(last).wrapping_sub(way.wrapping_mul(2));
        let bend = |at_end: i64| {
            let second = b.wrapping_add(c.wrapping_mul(3).wrapping_mul(at_end));
            second.wrapping_mul(2).unsigned_abs()
        };
        // ½·a·chord²/4 ≤ ¼ step, with a = bend / length².
        let bits = 64u32.wrapping_sub(bend(0).max(bend(1)).leading_zeros());
        let shorter = bits.saturating_sub(32).div_ceil(2);
        Self {
            inverse: u64::MAX.checked_div(length.into()).unwrap_or(0),
            curve: Some([first, b, c]),
            chord: u64::from(length).wrapping_shr(shorter).max(1),
            ..Self::steady(start, length, from, to, ends.1)
        }
    }

    /// The state at a tick within the piece.
    fn at(&self, t: Ticks) -> Exact {
        let n = t.saturating_sub(self.start);
        let Some([a, b, c]) = self.curve else {
            return Exact {
                position: exact(self.from).wrapping_add(self.velocity.wrapping_mul(n.into())),
                velocity: self.velocity,
            };
        };
        // u in Q32, below 1.
        let u = i128::from((u128::from(n).wrapping_mul(self.inverse.into()) >> 32) as u32);
        let of_u = |factor: i128| factor.wrapping_mul(u) >> 32;
        let (a, b, c) = (i128::from(a), i128::from(b), i128::from(c));
        let way = of_u(of_u(of_u(c).wrapping_add(b)).wrapping_add(a));
        let slope = of_u(of_u(c.wrapping_mul(3)).wrapping_add(b.wrapping_mul(2))).wrapping_add(a);
        Exact {
            position: exact(self.from).wrapping_add(way << 64),
            velocity: slope.wrapping_mul(self.inverse.into()),
        }
    }
}

/// Whole and broken steps in the resolution of plans.
const fn exact(position: Position) -> i128 {
    (position.bits() as i128) << 64
}

/// Q32 steps in so many ticks, as Q96 steps/tick.
fn rate(way: i64, length: u32) -> i128 {
    let rate = fraction(way.unsigned_abs(), length).cast_signed();
    if way < 0 { rate.wrapping_neg() } else { rate }
}

/// The set-points that are known.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    pieces: [Piece; MOST_PIECES],
    count: u8,
    /// How long it goes on behind the last set-point, in ticks.
    grace: u64,
}

impl Path {
    /// A path that stands in `at`, to be gone on with at tick `start`.
    pub(crate) fn new(start: Ticks, at: State, grace: u64) -> Self {
        // A piece without length: the path is at its end.
        let begin = Piece {
            velocity: at.velocity.exact(),
            length: 0,
            ..Piece::straight(start, 0, at.position, at.position)
        };
        Self {
            pieces: [begin; MOST_PIECES],
            count: 1,
            grace,
        }
    }

    fn last(&self) -> Option<&Piece> {
        self.pieces().last()
    }

    fn pieces(&self) -> &[Piece] {
        self.pieces
            .get(..usize::from(self.count))
            .unwrap_or_default()
    }

    /// Where the last set-point is, and when: the next piece begins there.
    pub(crate) fn end(&self) -> (Ticks, State) {
        self.last().map_or((0, State::default()), |last| {
            let state = State {
                position: last.to,
                velocity: Velocity::from_exact(last.velocity),
            };
            (last.end(), state)
        })
    }

    /// The tick from which the axis stands if nothing more comes.
    pub(crate) fn rest(&self) -> Ticks {
        self.last().map_or(0, |last| {
            let grace = if last.velocity == 0 { 0 } else { self.grace };
            last.end().saturating_add(grace)
        })
    }

    /// Whether the last set-point is passed in motion.
    pub(crate) fn ends_in_motion(&self) -> bool {
        self.last().is_some_and(|last| last.velocity != 0)
    }

    /// Goes on from where the path is at `horizon`, or from its end if that is later, to `to` at tick `end`.
    pub(crate) fn go_on(
        &mut self,
        horizon: Ticks,
        end: Ticks,
        to: Position,
        manner: Manner,
    ) -> Result<(), FollowError> {
        let (last, at_last) = self.end();
        let (start, from) = if last >= horizon {
            (last, at_last)
        } else {
            (horizon, self.exact_at(horizon).rounded())
        };
        let length = end.checked_sub(start).filter(|length| *length > 0);
        let length = length.ok_or(FollowError::TooLate)?;
        let length = u32::try_from(length).map_err(|_| FollowError::TooFarAhead)?;
        let piece = match manner {
            Manner::Straight => Piece::straight(start, length, from.position, to),
            Manner::Steady(velocity) => Piece::steady(start, length, from.position, to, velocity),
            Manner::Bent(velocity) => {
                let ends = (from.velocity, velocity);
                Piece::cubic(start, length, from.position, to, ends)
            }
        };
        self.forget(horizon);
        let free = self.pieces.get_mut(usize::from(self.count));
        *free.ok_or(FollowError::TooFarAhead)? = piece;
        self.count = self.count.saturating_add(1);
        Ok(())
    }

    /// Drops the pieces that end before `horizon`.
    fn forget(&mut self, horizon: Ticks) {
        let over = |piece: &&Piece| piece.end() <= horizon;
        let gone = self.pieces().iter().take_while(over).count();
        if gone == 0 {
            return;
        }
        // Behind the count nothing counts: only what stays is moved.
        let stay = self.pieces().len().saturating_sub(gone);
        for place in 0..stay {
            let from = place.saturating_add(gone);
            if let (Some(piece), Some(to)) =
                (self.pieces.get(from).copied(), self.pieces.get_mut(place))
            {
                *to = piece;
            }
        }
        self.count = self.count.saturating_sub(gone as u8);
    }

    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        let within = self.pieces().iter().find(|piece| t < piece.end());
        if let Some(piece) = within {
            return piece.at(t);
        }
        let Some(last) = self.last() else {
            return Exact::at_rest(0);
        };
        let rest = self.rest();
        let beyond = t.min(rest).saturating_sub(last.end());
        Exact {
            position: exact(last.to).wrapping_add(last.velocity.wrapping_mul(beyond.into())),
            velocity: if t < rest { last.velocity } else { 0 },
        }
    }

    /// The next tick after `after` at which another piece begins, or the path stands.
    pub(crate) fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        self.pieces()
            .iter()
            .map(Piece::end)
            .chain([self.rest()])
            .find(|corner| *corner > after)
    }

    /// The longest chord from tick `t` that stays within a quarter of a step of the path, in ticks.
    pub(crate) fn longest_chord(&self, t: Ticks) -> u64 {
        let within = self.pieces().iter().find(|piece| t < piece.end());
        within.map_or(u64::MAX, |piece| piece.chord)
    }
}

#[cfg(test)]
mod tests;

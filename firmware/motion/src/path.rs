//! A path through set-points that come one by one: where the axis is to be between them.
//!
//! A piece leads from one set-point to the next, in a straight line or as a cubic whose velocity is given at both ends. At its
//! last tick it is exactly on its set-point, so nothing adds up however many there are.
//!
//! A path whose next piece is late coasts: it goes on at its last velocity for a short while, then it stands.

use crate::clock::Ticks;
use crate::divide::fraction;
use crate::fixed::{Exact, Position, State, Velocity};

/// Pieces that are kept: the one that is becoming pulses, and those behind it. A power of two.
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
    /// The first tick behind it.
    end: Ticks,
    /// In ticks, at least 1.
    length: u32,
    /// Of a cubic: ⌊2⁶⁴ / length⌋, or nearly so.
    inverse: u64,
    from: Position,
    to: Position,
    /// The velocity at the end, and all along a straight line, Q96; and rounded.
    velocity: i128,
    rounded: Velocity,
    /// Of a cubic: what belongs to u, u² and u³, where u goes from 0 to 1. Q32 steps.
    curve: Option<[i64; 3]>,
    /// The velocity of a straight line is its way over its length, and no other one.
    is_mean: bool,
    /// The longest chord that stays within a quarter of a step.
    chord: u64,
}

impl Piece {
    /// In a straight line, with a velocity Q96 and the same rounded.
    #[inline]
    const fn line(
        start: Ticks,
        length: u32,
        (from, to): (Position, Position),
        (velocity, rounded): (i128, Velocity),
    ) -> Self {
        Self {
            start,
            end: start.saturating_add(length as u64),
            length,
            inverse: 0,
            from,
            to,
            velocity,
            rounded,
            curve: None,
            is_mean: false,
            chord: u64::MAX,
        }
    }

    /// The same behind another piece. As long and as far as that it is as fast, and there is nothing to divide.
    fn straight(
        start: Ticks,
        length: u32,
        from: Position,
        to: Position,
        before: Option<&Self>,
    ) -> Self {
        let way = to.bits().wrapping_sub(from.bits());
        let alike = before.filter(|before| before.is_mean && before.goes(way, length));
        let velocity = match alike {
            Some(before) => (before.velocity, before.rounded),
            None => {
                let velocity = rate(way, length);
                (velocity, Velocity::from_exact(velocity))
            }
        };
        Self {
            is_mean: true,
            ..Self::line(start, length, (from, to), velocity)
        }
    }

    /// Whether it leads so far in so many ticks.
    const fn goes(&self, way: i64, length: u32) -> bool {
        self.length == length && self.to.bits().wrapping_sub(self.from.bits()) == way
    }

    /// The velocity is not worked out: rounded ways would make it another one, and in each piece.
    const fn steady(
        start: Ticks,
        length: u32,
        from: Position,
        to: Position,
        velocity: Velocity,
    ) -> Self {
        Self::line(start, length, (from, to), (velocity.exact(), velocity))
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

    /// The state at its first tick.
    #[inline]
    fn begin(&self) -> State {
        if self.curve.is_some() {
            return self.at(self.start).rounded();
        }
        State {
            position: self.from,
            velocity: self.rounded,
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

/// A stretch of a straight line, from a tick on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// The state at that tick.
    pub(crate) begin: State,
    /// The tick behind the line.
    pub(crate) end: Ticks,
    /// The piece that it is a part of, counted as they are kept.
    piece: u8,
}

/// The set-points that are known.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    /// Kept round and round.
    pieces: [Piece; MOST_PIECES],
    /// The place of the first piece, and how many there are: at least one.
    first: u8,
    count: u8,
    /// How long it goes on behind the last set-point, in ticks.
    grace: u64,
    /// Where the last set-point is, and when, and the tick from which the axis stands if nothing more comes.
    end: (Ticks, State),
    rest: Ticks,
}

impl Path {
    /// A path that stands in `at`, to be gone on with at tick `start`.
    pub(crate) fn new(start: Ticks, at: State, grace: u64) -> Self {
        // A piece without length: the path is at its end.
        let begin = Piece::steady(start, 0, at.position, at.position, at.velocity);
        let mut path = Self {
            pieces: [begin; MOST_PIECES],
            first: 0,
            count: 1,
            grace,
            end: (start, at),
            rest: start,
        };
        path.ends_with(&begin);
        path
    }

    /// This is the last piece from now on.
    fn ends_with(&mut self, last: &Piece) {
        let grace = if last.velocity == 0 { 0 } else { self.grace };
        self.rest = last.end.saturating_add(grace);
        self.end.0 = last.end;
        self.end.1 = State {
            position: last.to,
            velocity: last.rounded,
        };
    }

    /// A piece, counted from the first one.
    #[inline]
    fn piece(&self, number: u8) -> Option<&Piece> {
        let place = usize::from(self.first.wrapping_add(number)) % MOST_PIECES;
        self.pieces.get(place).filter(|_| number < self.count)
    }

    fn last(&self) -> Option<&Piece> {
        self.piece(self.count.wrapping_sub(1))
    }

    /// The piece in which tick `t` lies, and its number; none behind the last one.
    #[inline]
    fn piece_at(&self, t: Ticks) -> Option<(u8, &Piece)> {
        let mut number = 0;
        loop {
            let piece = self.piece(number)?;
            if t < piece.end {
                return Some((number, piece));
            }
            number = number.wrapping_add(1);
        }
    }

    /// Where the last set-point is, and when: the next piece begins there.
    #[inline]
    pub(crate) const fn end(&self) -> (Ticks, State) {
        self.end
    }

    /// The tick from which the axis stands if nothing more comes.
    #[inline]
    pub(crate) const fn rest(&self) -> Ticks {
        self.rest
    }

    /// Whether the last set-point is passed in motion.
    pub(crate) const fn ends_in_motion(&self) -> bool {
        self.rest != self.end.0
    }

    /// Goes on from where the path is at `horizon`, or from its end if that is later, to `to` at tick `end`.
    pub(crate) fn go_on(
        &mut self,
        horizon: Ticks,
        end: Ticks,
        to: Position,
        manner: Manner,
    ) -> Result<(), FollowError> {
        let (last, at_last) = self.end;
        let (start, from) = if last >= horizon {
            (last, at_last)
        } else {
            (horizon, self.exact_at(horizon).rounded())
        };
        let length = end.checked_sub(start).filter(|length| *length > 0);
        let length = length.ok_or(FollowError::TooLate)?;
        let length = u32::try_from(length).map_err(|_| FollowError::TooFarAhead)?;
        let gone = self.gone(horizon);
        let count = self.count.wrapping_sub(gone);
        if usize::from(count) >= MOST_PIECES {
            return Err(FollowError::TooFarAhead);
        }
        let piece = match manner {
            Manner::Straight => Piece::straight(start, length, from.position, to, self.last()),
            Manner::Steady(velocity) => Piece::steady(start, length, from.position, to, velocity),
            Manner::Bent(velocity) => {
                let ends = (from.velocity, velocity);
                Piece::cubic(start, length, from.position, to, ends)
            }
        };
        self.ends_with(&piece);
        self.first = self.first.wrapping_add(gone);
        let free = usize::from(self.first.wrapping_add(count)) % MOST_PIECES;
        if let Some(free) = self.pieces.get_mut(free) {
            *free = piece;
        }
        self.count = count.wrapping_add(1);
        Ok(())
    }

    /// How many pieces end before `horizon`.
    #[inline]
    fn gone(&self, horizon: Ticks) -> u8 {
        self.piece_at(horizon)
            .map_or(self.count, |(number, _)| number)
    }

    /// The straight line on which the path is at tick `t`, if it is on one.
    #[inline]
    pub(crate) fn line_at(&self, t: Ticks) -> Option<Line> {
        let (number, piece) = self.piece_at(t)?;
        if piece.curve.is_some() {
            return None;
        }
        let begin = if t == piece.start {
            piece.begin()
        } else {
            piece.at(t).rounded()
        };
        Some(Line {
            begin,
            end: piece.end,
            piece: number,
        })
    }

    /// The state at the end of a line.
    #[inline]
    pub(crate) fn behind_line(&self, line: &Line) -> State {
        let next = self.piece(line.piece.wrapping_add(1));
        next.map_or(self.end.1, Piece::begin)
    }

    /// The state at a tick of a line, up to its end.
    pub(crate) fn exact_on_line(&self, line: &Line, t: Ticks) -> Exact {
        self.piece(line.piece)
            .map_or(Exact::at_rest(0), |piece| piece.at(t))
    }

    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        if let Some((_, piece)) = self.piece_at(t) {
            return piece.at(t);
        }
        let Some(last) = self.last() else {
            return Exact::at_rest(0);
        };
        let beyond = t.min(self.rest).saturating_sub(last.end);
        Exact {
            position: exact(last.to).wrapping_add(last.velocity.wrapping_mul(beyond.into())),
            velocity: if t < self.rest { last.velocity } else { 0 },
        }
    }

    /// The next tick after `after` at which another piece begins, or the path stands.
    pub(crate) fn next_corner(&self, after: Ticks) -> Option<Ticks> {
        match self.piece_at(after) {
            Some((_, piece)) => Some(piece.end),
            None => Some(self.rest).filter(|rest| *rest > after),
        }
    }

    /// The longest chord from tick `t` that stays within a quarter of a step of the path, in ticks.
    pub(crate) fn longest_chord(&self, t: Ticks) -> u64 {
        self.piece_at(t).map_or(u64::MAX, |(_, piece)| piece.chord)
    }
}

#[cfg(test)]
mod tests;

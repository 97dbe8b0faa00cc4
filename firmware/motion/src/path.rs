//! A path through set-points that come one by one: where the axis is to be between them.
//!
//! A path segment leads from one set-point to the next, in a straight line or as a cubic whose velocity is given at both ends. The next one
//! begins exactly on its set-point, so nothing adds up however many there are.
//!
//! A path whose next segment is late coasts: it goes on at its last velocity for a short while, then it stands.

use crate::clock::Ticks;
use crate::divide::fraction;
use crate::exact::{Q96, with_sign};
use crate::fixed::{Exact, Position, State, Velocity};
use crate::iterations::Iterations;
use crate::low;
use crate::stepper::polynomial::Polynomial;

/// Path segments that are kept: the one that is becoming pulses, and those behind it. A power of two.
const MOST_SEGMENTS: usize = 4;

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
pub(crate) enum Interpolation {
    /// In a straight line.
    Linear,
    /// In a straight line at this velocity, which leads there to within the resolution of positions.
    Steady(Velocity),
    /// On a cubic that ends with this velocity.
    Cubic(Velocity),
}

/// From one set-point to the next.
#[derive(Debug, Clone, Copy)]
struct PathSegment {
    start: Ticks,
    /// In ticks, at least 1.
    length: u32,
    polynomial: Polynomial,
    /// The set-point at its end.
    to: State,
    /// The velocity of a straight line is its distance over its time, and was not given.
    is_mean: bool,
}

impl PathSegment {
    /// In a straight line, with a velocity and the same rounded.
    #[inline]
    const fn line(
        start: Ticks,
        length: u32,
        (from, to): (Position, Position),
        (velocity, rounded): (Q96, Velocity),
    ) -> Self {
        let from = Exact {
            position: from.exact(),
            velocity,
        };
        Self {
            start,
            length,
            polynomial: Polynomial::line(start.saturating_add(length as u64), from),
            to: State {
                position: to,
                velocity: rounded,
            },
            is_mean: false,
        }
    }

    /// The same behind another segment. If time and distance are those of the other one, so is the velocity, and no division is needed.
    fn straight(
        start: Ticks,
        length: u32,
        from: Position,
        to: Position,
        before: Option<&Self>,
    ) -> Self {
        let distance = to.bits().wrapping_sub(from.bits());
        let alike = before.filter(|before| before.is_mean && before.goes(distance, length));
        let velocity = match alike {
            Some(before) => (before.polynomial.velocity, before.to.velocity),
            None => {
                let velocity = rate(distance, length);
                (velocity, Velocity::from_exact(velocity))
            }
        };
        Self {
            is_mean: true,
            ..Self::line(start, length, (from, to), velocity)
        }
    }

    /// Whether it leads so far in so many ticks.
    const fn goes(&self, distance: i64, length: u32) -> bool {
        let from = self.polynomial.position.floor();
        self.length == length && self.to.position.bits().wrapping_sub(from) == distance
    }

    /// At a given velocity: one computed from rounded distances would differ from segment to segment.
    const fn steady(
        start: Ticks,
        length: u32,
        from: Position,
        to: Position,
        velocity: Velocity,
    ) -> Self {
        Self::line(start, length, (from, to), (velocity.exact(), velocity))
    }

    fn cubic(start: Ticks, length: u32, from: State, to: State) -> Self {
        let end = start.saturating_add(length.into());
        let state = |state: State| Exact {
            position: state.position.exact(),
            velocity: state.velocity.exact(),
        };
        Self {
            start,
            length,
            polynomial: Polynomial::between(state(from), (end, state(to)), length),
            to,
            is_mean: false,
        }
    }

    /// The velocity at its end.
    const fn velocity(&self) -> Q96 {
        if self.polynomial.is_line() {
            self.polynomial.velocity
        } else {
            self.to.velocity.exact()
        }
    }

    /// The polynomial from tick `t` on.
    fn at(&self, t: Ticks) -> Polynomial {
        let mut polynomial = self.polynomial;
        // It is within the segment, which is shorter than 2³² ticks.
        polynomial.advance_by(low::u32(t.saturating_sub(self.start)));
        polynomial
    }
}

/// The velocity at which a distance, Q32 steps, takes so many ticks.
fn rate(distance: i64, length: u32) -> Q96 {
    let rate = fraction(distance.unsigned_abs(), length).cast_signed();
    with_sign(Q96::from_bits(rate), distance < 0)
}

/// The set-points that are known.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    /// A ring.
    segments: [PathSegment; MOST_SEGMENTS],
    /// The place of the first segment, and how many there are: at least one.
    first: u8,
    count: u8,
    /// How long it goes on behind the last set-point, in ticks.
    coasting: u32,
    /// When and where the last set-point is, and the tick from which the axis stands if nothing more comes.
    end: (Ticks, State),
    rest: Ticks,
}

impl Path {
    /// A path that stands in `at`, to be gone on with at tick `start`.
    pub(crate) fn new(start: Ticks, at: State, coasting: u32) -> Self {
        // A segment without length: the path is at its end.
        let begin = PathSegment::steady(start, 0, at.position, at.position, at.velocity);
        let mut path = Self {
            segments: [begin; MOST_SEGMENTS],
            first: 0,
            count: 1,
            coasting,
            end: (start, at),
            rest: start,
        };
        path.end_with(&begin);
        path
    }

    /// This is the last segment from now on.
    fn end_with(&mut self, last: &PathSegment) {
        let coasting = if last.velocity().is_zero() {
            0
        } else {
            self.coasting
        };
        self.rest = last.polynomial.end.saturating_add(coasting.into());
        self.end = (last.polynomial.end, last.to);
    }

    /// A segment, counted from the first one.
    #[inline]
    fn segment(&self, number: u8) -> Option<&PathSegment> {
        let place = usize::from(self.first.wrapping_add(number)) % MOST_SEGMENTS;
        self.segments.get(place).filter(|_| number < self.count)
    }

    fn last(&self) -> Option<&PathSegment> {
        self.segment(self.count.wrapping_sub(1))
    }

    /// How many segments end before tick `t`: the number of the one in which it lies, if there is one.
    #[inline]
    fn passed(&self, t: Ticks) -> u8 {
        let mut number = 0;
        let mut iterations = Iterations::at_most(low::word(MOST_SEGMENTS));
        while self
            .segment(number)
            .is_some_and(|segment| segment.polynomial.end <= t)
        {
            iterations.count();
            number += 1;
        }
        number
    }

    /// When and where the last set-point is: the next segment begins there.
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
        interpolation: Interpolation,
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
        let passed = self.passed(horizon);
        let count = self.count - passed;
        if usize::from(count) >= MOST_SEGMENTS {
            return Err(FollowError::TooFarAhead);
        }
        let segment = match interpolation {
            Interpolation::Linear => {
                PathSegment::straight(start, length, from.position, to, self.last())
            }
            Interpolation::Steady(velocity) => {
                PathSegment::steady(start, length, from.position, to, velocity)
            }
            Interpolation::Cubic(velocity) => {
                let to = State {
                    position: to,
                    velocity,
                };
                PathSegment::cubic(start, length, from, to)
            }
        };
        self.end_with(&segment);
        self.first = self.first.wrapping_add(passed);
        let free = usize::from(self.first.wrapping_add(count)) % MOST_SEGMENTS;
        if let Some(free) = self.segments.get_mut(free) {
            *free = segment;
        }
        self.count = count + 1;
        Ok(())
    }

    /// How the path goes on from tick `t`; `None` where it stands.
    pub(crate) fn polynomial_at(&self, t: Ticks) -> Option<Polynomial> {
        if let Some(segment) = self.segment(self.passed(t)) {
            return Some(segment.at(t));
        }
        let last = self.last().filter(|_| t < self.rest)?;
        let from = Exact {
            position: last.to.position.exact(),
            velocity: last.velocity(),
        };
        let mut polynomial = Polynomial::line(self.rest, from);
        // The time for which it goes on is two time slices.
        polynomial.advance_by(low::u32(t.saturating_sub(last.polynomial.end)));
        Some(polynomial)
    }

    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        if let Some(polynomial) = self.polynomial_at(t) {
            return polynomial.exact();
        }
        let last = self
            .rest
            .checked_sub(1)
            .and_then(|last| self.polynomial_at(last));
        let mut there = Exact::at_rest(self.end.1.position.exact());
        if self.ends_in_motion()
            && let Some(mut last) = last
        {
            last.advance_by(1);
            there.position = last.position;
        }
        there
    }
}

#[cfg(test)]
mod tests;

//! Where the commit horizon has been lately: what is being played lies there.

use crate::clock::Ticks;
use crate::divide::div_rem;
use crate::fixed::{Position, State, Velocity};
use crate::low;

/// Points that are kept. A power of two.
const POINTS: usize = 32;

/// A tick, and the state there.
type Point = (Ticks, State);

const NOWHERE: Point = (
    0,
    State {
        position: Position::from_bits(0),
        velocity: Velocity::ZERO,
    },
);

/// The last points of the commit horizon. At first they are all the same.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    points: [Point; POINTS],
    /// The index of the newest point; counts on beyond the ring.
    newest: u32,
    /// From the point before the newest to the newest, in ticks.
    gap: u32,
    /// The tick of the newest point, modulo 2³².
    at: u32,
}

impl Trace {
    pub(super) const fn new() -> Self {
        Self {
            points: [NOWHERE; POINTS],
            newest: 0,
            gap: u32::MAX,
            at: 0,
        }
    }

    /// Begins anew at a point.
    pub(super) fn restart(&mut self, t: Ticks, state: State) {
        self.points = [(t, state); POINTS];
        self.gap = u32::MAX;
        self.at = low::u32(t);
    }

    /// The horizon has come to a point. The last one is forgotten if it lies closer than `least` ticks to the one before.
    #[inline]
    pub(super) fn mark(&mut self, t: Ticks, state: State, least: u32) {
        // All points lie less than 2³¹ ticks apart.
        let passed = low::u32(t).wrapping_sub(self.at);
        self.at = low::u32(t);
        if self.gap < least {
            self.gap = self.gap.saturating_add(passed);
        } else {
            self.gap = passed;
            self.newest = self.newest.wrapping_add(1);
        }
        if let Some(place) = self.points.get_mut(self.newest as usize % POINTS) {
            *place = (t, state);
        }
    }

    /// The state at tick `t`, as far as it is kept.
    pub(super) fn at(&self, t: Ticks) -> State {
        let mut after = self.point(0);
        if after.0 <= t {
            return after.1;
        }
        for age in 1..low::word(POINTS) {
            let point = self.point(age);
            if point.0 <= t {
                return between(point, after, t);
            }
            after = point;
        }
        after.1
    }

    /// The newest point, or one before.
    #[inline]
    fn point(&self, age: u32) -> &Point {
        let place = self.newest.wrapping_sub(age) as usize % POINTS;
        self.points.get(place).unwrap_or(&NOWHERE)
    }
}

/// The state at tick `t` between two points.
fn between(before: &Point, after: &Point, t: Ticks) -> State {
    // Points lie less than 2³⁰ ticks apart.
    let length = low::u32(after.0.wrapping_sub(before.0));
    let passed = t.wrapping_sub(before.0);
    // Q16 of the distance.
    let (part, _) = div_rem(passed << 16, length);
    let blend = |from: i64, to: i64| {
        // So it is with the velocity in a cruise, where most of the time is spent.
        if from == to {
            return from;
        }
        let change = i128::from(to.wrapping_sub(from)).wrapping_mul(part.into()) >> 16;
        from.wrapping_add(low::i64(change))
    };
    State {
        position: Position::from_bits(blend(before.1.position.bits(), after.1.position.bits())),
        velocity: Velocity::from_bits(blend(before.1.velocity.bits(), after.1.velocity.bits())),
    }
}

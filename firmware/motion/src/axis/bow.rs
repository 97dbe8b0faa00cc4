//! A stretch of the plan whose acceleration changes, walked along in chords of one length: limited jerk, or sin².
//!
//! What a chord adds to the position grows from chord to chord, and what it grows by does, too: by as much each time where the jerk is constant.
//! Where the acceleration is a sine, so is that growth, and its second difference is a constant part of it. So a chord is a few additions, and a
//! product with sin². The plan is looked at anew before anything that was rounded can add up.

use super::Axis;
use crate::average::part;
use crate::clock::Ticks;
use crate::fixed::{Position, State, Velocity};
use crate::plan::phase::Phase;
use crate::train::Chord;

/// Chords that are gone before the plan is looked at again.
const MOST_CHORDS: u64 = 64;

/// In fewer chords before a corner it is not begun.
const FEW: u64 = 4;

/// Q64 steps, modulo 2³²: three digits, so that nothing need be shifted to have it in Q32.
#[derive(Debug, Clone, Copy)]
struct Digits {
    /// Q32, and what is behind that.
    steps: i64,
    rest: u32,
}

impl Digits {
    const NONE: Self = Self { steps: 0, rest: 0 };

    #[inline]
    const fn of(value: i128) -> Self {
        Self {
            steps: (value >> 32) as i64,
            rest: value as u32,
        }
    }

    #[inline]
    fn all(self) -> i128 {
        i128::from(self.steps) << 32 | i128::from(self.rest)
    }

    #[inline]
    fn plus(self, way: i128) -> Self {
        Self::of(self.all().wrapping_add(way))
    }
}

/// How the axis goes on from the commit horizon.
#[derive(Debug, Clone)]
pub(super) struct Bow {
    /// Chords that are left, and how long each is, in ticks.
    left: u32,
    length: u32,
    /// By which part of it, Q64, the growth bends back; 0 where the jerk is constant.
    bend: u64,
    /// Where it is, and what that grows by in the next chord.
    position: Digits,
    way: Digits,
    /// Q61 steps: what the way grows by, and what that grows by.
    growth: i64,
    third: i64,
    /// The same of the velocity, Q56.
    velocity: i64,
    gain: i64,
    rise: i64,
}

impl Bow {
    pub(super) const NONE: Self = Self {
        left: 0,
        length: 0,
        bend: 0,
        position: Digits::NONE,
        way: Digits::NONE,
        growth: 0,
        third: 0,
        velocity: 0,
        gain: 0,
        rise: 0,
    };

    /// From tick `t` of a phase, in chords of `length` ticks, which are short enough there, to the next corner; it is not begun in its last chords.
    pub(super) fn new(phase: &Phase, t: Ticks, corner: Ticks, length: u32) -> Option<Self> {
        let before = corner.wrapping_sub(t).wrapping_sub(1);
        let chords = before.checked_div(length.into())?.min(MOST_CHORDS);
        if chords < FEW {
            return None;
        }
        let bend = phase.bend(length)?;
        let mut ends = [t; 4].map(|_| phase.at(t));
        for (end, number) in ends.iter_mut().zip(0u64..) {
            *end = phase.at(t.wrapping_add(number.wrapping_mul(length.into())));
        }
        let [a, b, c, d] = ends;
        let between = |from: i128, to: i128| to.wrapping_sub(from);
        let ways = [(a, b), (b, c), (c, d)].map(|(a, b)| between(a.position, b.position));
        let [way, second, last] = ways;
        let (growth, next) = (between(way, second), between(second, last));
        let (gain, next_gain) = (
            between(a.velocity, b.velocity),
            between(b.velocity, c.velocity),
        );
        Some(Self {
            left: chords as u32,
            length,
            bend,
            position: Digits::of(a.position >> 32),
            way: Digits::of(way >> 32),
            growth: i64::try_from(growth >> 35).ok()?,
            third: i64::try_from(between(growth, next) >> 35).ok()?,
            velocity: (a.velocity >> 40) as i64,
            gain: (gain >> 40) as i64,
            rise: (between(gain, next_gain) >> 40) as i64,
        })
    }

    /// Whether it goes on.
    #[inline]
    pub(super) const fn is_left(&self) -> bool {
        self.left != 0
    }

    /// Goes on by a chord from tick `begin`, the commit horizon. Gives the chord and the state at its end; `None` if it would be off by more than
    /// a quarter of a step.
    #[inline]
    fn go_on(&mut self, begin: Ticks) -> Option<(Chord, State)> {
        // Off by an eighth of the growth.
        let steps = (self.growth >> 61) as u32;
        if steps.wrapping_add(2) >= 4 {
            return None;
        }
        self.left = self.left.wrapping_sub(1);
        let from = self.position.steps;
        let gain = self.gain;
        self.position = self.position.plus(self.way.all());
        self.way = self.way.plus(i128::from(self.growth) << 3);
        self.growth = self.growth.wrapping_add(self.third);
        self.velocity = self.velocity.wrapping_add(self.gain);
        self.gain = self.gain.wrapping_add(self.rise);
        if self.bend != 0 {
            self.third = self.third.wrapping_sub(part(self.growth, self.bend));
            self.rise = self.rise.wrapping_sub(part(self.gain, self.bend));
        }
        let to = State {
            position: Position::from_bits(self.position.steps),
            velocity: Velocity::from_bits(self.velocity),
        };
        let chord = Chord {
            begin,
            length: self.length,
            from: Position::from_bits(from),
            to: to.position,
            speeding_up: (gain ^ self.velocity) >= 0,
            steady: false,
        };
        Some((chord, to))
    }
}

impl Axis {
    /// Makes the records of the next chord of a bow; whether it did.
    #[inline(never)]
    pub(super) fn go_on_bow(&mut self) -> bool {
        let next = self.bow.go_on(self.horizon);
        let Some((chord, to)) = next.filter(|(_, to)| self.train.is_easy(to.velocity)) else {
            self.bow.left = 0;
            return false;
        };
        self.train.draw(&chord);
        self.go_to(chord.begin.wrapping_add(chord.length.into()), to);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::Bow;
    use crate::{Clock, Goal, Limits, Plan, Ramps, State, Ticks};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn chords_of_a_bow_end_where_the_phase_says(
            target in -2_000_000i64..2_000_000,
            velocity in 1u32..1_000_000,
            acceleration in 1u32..10_000_000,
            deceleration in 1u32..10_000_000,
            jerk in prop_oneof![Just(0), 1u32..1 << 30],
            length in 2_000u32..42_000,
        ) {
            let clock = Clock::new(168_000_000).unwrap();
            let limits = Limits { velocity: velocity.into(), acceleration, deceleration };
            let ramps = if jerk == 0 { Ramps::SinSquared } else { Ramps::JerkLimited(jerk) };
            let plan = Plan::new(clock, 77, State::default(), Goal::Rest(target), limits, ramps).unwrap();
            for phase in plan.phases().filter(|phase| !phase.is_parabola()) {
                let mut t = phase.start();
                let corner = plan.next_corner(t).unwrap_or(Ticks::MAX);
                let Some(mut bow) = Bow::new(&phase, t, corner, length) else { continue };
                while bow.is_left() {
                    let Some((chord, to)) = bow.go_on(t) else { break };
                    prop_assert!(chord.from.bits().abs_diff(phase.at(t).rounded().position.bits()) < 1 << 12);
                    t += Ticks::from(length);
                    prop_assert!(t < corner);
                    let exact = phase.at(t).rounded();
                    let off = to.position.bits().abs_diff(exact.position.bits());
                    prop_assert!(off < 1 << 12, "{off} Q32 steps");
                    let off = to.velocity.bits().abs_diff(exact.velocity.bits());
                    prop_assert!(off < 1 << 20, "{off} Q56");
                }
            }
        }
    }
}

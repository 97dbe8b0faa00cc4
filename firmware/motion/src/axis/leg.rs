//! A stretch of the plan that is one parabola, walked along in chords.

use super::slope::Slope;
use crate::clock::Ticks;
use crate::divide::estimate;
use crate::fixed::{Exact, Position, State, Velocity};
use crate::plan::phase::{Phase, product};
use crate::train::{Chord, Train};

/// Where the axis is on a parabola, and how it goes on. A chord of the same length as the one before is a few additions: what the position
/// grows by in it has grown by the same amount again. Integers, modulo 2³² steps: it is what the phase says, to the last bit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    /// The next corner.
    until: Ticks,
    /// The longest chord in it, in ticks.
    longest: u32,
    /// At the commit horizon, and rounded.
    exact: Exact,
    state: State,
    /// Steps per tick², Q96, and whether there are any.
    half_acceleration: i128,
    bends: bool,
    /// How it is gone from pulse to pulse where it bends.
    slope: Slope,
    /// Steady, and so slow that a tick is less than the positions of a chord tell.
    creeps: bool,
    /// Steady: the ticks for a step, Q32; 0 as long as nobody has asked.
    pace: u64,
    /// The longest chord at that.
    pub(super) reach: u32,
    /// The chord that was gone last, in ticks; 0 for none.
    length: u32,
    /// What position and velocity grew by, and what that of the position grows by with every chord; all of them Q96.
    way: i128,
    gain: i128,
    growth: i128,
}

impl Leg {
    /// From tick `t` of a phase to the next corner.
    pub(super) fn new(
        phase: &Phase,
        (t, until): (Ticks, Ticks),
        longest: u32,
        train: &Train,
    ) -> Self {
        let half_acceleration = phase.half_acceleration();
        let mut leg = Self::from(phase.at(t), half_acceleration, until, longest);
        if leg.bends {
            leg.slope = Slope::new(half_acceleration, longest, train);
        }
        leg
    }

    /// Along a straight line up to its end, from here.
    pub(super) fn on_line(exact: Exact, until: Ticks) -> Self {
        Self::from(exact, 0, until, u32::MAX)
    }

    #[inline]
    fn from(exact: Exact, half_acceleration: i128, until: Ticks, longest: u32) -> Self {
        let bends = half_acceleration != 0;
        Self {
            until,
            longest,
            exact,
            state: exact.rounded(),
            half_acceleration,
            bends,
            slope: Slope::NONE,
            creeps: !bends && Velocity::from_exact(exact.velocity).creeps(),
            pace: 0,
            reach: 0,
            length: 0,
            way: 0,
            gain: 0,
            growth: 0,
        }
    }

    /// Goes on by a chord from tick `begin`, the commit horizon. Gives the chord and the state at its end; `None` if it would reach the next
    /// corner, or if it has a pulse whose tick must be looked for.
    #[inline]
    pub(super) fn go_on(&mut self, begin: Ticks, train: &Train) -> Option<(Chord, State)> {
        let length = if self.bends || self.length == 0 {
            train.chord(self.state.velocity, self.longest)
        } else {
            self.length
        };
        if u64::from(length) >= self.until.wrapping_sub(begin) {
            return None;
        }
        let from = self.state.position;
        self.walk(length);
        if self.creeps && train.due(self.state.position) != 0 {
            return None;
        }
        let chord = Chord {
            begin,
            length,
            from,
            to: self.state.position,
            // Both have the same sign.
            speeding_up: !self.bends || (self.gain ^ self.exact.velocity) >= 0,
            steady: !self.bends,
        };
        Some((chord, self.state))
    }

    /// Where it is if its velocity stays, the ticks for a step, Q32, less than 2³¹, and those from `begin`, the commit horizon, to the next
    /// corner.
    #[inline]
    pub(super) fn steady(&mut self, begin: Ticks, train: &Train) -> Option<(Position, u64, Ticks)> {
        if self.pace == 0 {
            if self.bends || self.creeps {
                return None;
            }
            self.pace = pace(self.exact.velocity)?;
            self.reach = train.chord(self.state.velocity, u32::MAX);
        }
        Some((
            self.state.position,
            self.pace,
            self.until.wrapping_sub(begin),
        ))
    }

    /// Whether it can be gone from pulse to pulse although it bends, from tick `begin`, the commit horizon, if the records have to lead to
    /// `enough`.
    #[inline]
    pub(super) const fn is_slope(&self, begin: Ticks, enough: Ticks) -> bool {
        self.bends && self.slope.is_fast(self.state.velocity) && begin <= enough
    }

    /// Goes on from pulse to pulse from tick `begin`, the commit horizon, for `wanted` ticks or a little more. Gives how many, and the state there;
    /// `None` if nothing is made.
    #[inline]
    pub(super) fn go_from_pulse_to_pulse(
        &mut self,
        begin: Ticks,
        wanted: Ticks,
        train: &mut Train,
    ) -> Option<(u32, State)> {
        let left = self.until.wrapping_sub(begin);
        let position = self.state.position;
        if !self.slope.is_under_way() {
            self.slope.begin(self.exact.velocity);
        }
        let (length, state) = self.slope.go_on(begin, position, wanted, left, train)?;
        self.state = state;
        Some((length, state))
    }

    /// Whether what was rounded on the way from pulse to pulse would begin to show.
    #[inline]
    pub(super) const fn is_worn(&self) -> bool {
        self.slope.is_worn()
    }

    /// Whether it is known more exactly where it is, once it has been gone from pulse to pulse.
    pub(super) const fn is_rounded(&self) -> bool {
        self.slope.is_under_way()
    }

    /// It is exactly here.
    pub(super) fn renew(&mut self, exact: Exact) {
        self.exact = exact;
        self.state = exact.rounded();
        self.length = 0;
        self.slope.end();
    }

    /// Goes on for so many ticks at the velocity that stays. Gives the state there.
    #[inline]
    pub(super) fn coast(&mut self, ticks: u32) -> State {
        let way = product(self.exact.velocity, ticks);
        self.exact.position = self.exact.position.wrapping_add(way);
        self.state.position = self.exact.rounded_position();
        self.state
    }

    #[inline]
    fn walk(&mut self, length: u32) {
        if length != self.length {
            self.stride(length);
        } else if self.bends {
            self.way = self.way.wrapping_add(self.growth);
        }
        self.exact.position = self.exact.position.wrapping_add(self.way);
        if self.bends {
            self.exact.velocity = self.exact.velocity.wrapping_add(self.gain);
            self.state = self.exact.rounded();
        } else {
            self.state.position = self.exact.rounded_position();
        }
    }

    /// What a chord of so many ticks grows by, here.
    #[inline(never)]
    fn stride(&mut self, length: u32) {
        let half = product(self.half_acceleration, length);
        self.length = length;
        self.way = product(self.exact.velocity.wrapping_add(half), length);
        self.gain = half.wrapping_mul(2);
        self.growth = product(self.gain, length);
    }
}

/// Ticks for a step, Q32, at a velocity, Q96 steps per tick; `None` if they are 2³⁰ or more.
#[inline(never)]
fn pace(velocity: i128) -> Option<u64> {
    let speed = velocity.unsigned_abs();
    let up = speed.leading_zeros();
    if !(33..=61).contains(&up) {
        return None;
    }
    let leading = (speed.wrapping_shl(up) >> 96) as u32;
    Some(u64::from(estimate(1 << 63, leading)) << (up.wrapping_sub(31) & 31))
}

#[cfg(test)]
mod tests {
    use super::Leg;
    use crate::train::Train;
    use crate::{Clock, DriverTiming, Limits, Plan, State, Ticks};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn chords_of_a_leg_end_where_the_phase_says(
            target in -2_000_000i64..2_000_000,
            velocity in 1u32..2_000_000,
            acceleration in 1u32..100_000_000,
            deceleration in 1u32..100_000_000,
            usual in 1u32..100_000,
            lengths in prop::collection::vec((0u8..8, 1u32..100_000), 1..60),
        ) {
            let clock = Clock::new(168_000_000).unwrap();
            let limits = Limits { velocity: velocity.into(), acceleration, deceleration };
            let plan = Plan::move_to(clock, 77, State::default(), target, limits).unwrap();
            let timing = DriverTiming { pulse_high: 17, pulse_low: 17, direction_setup: 4, direction_hold: 4 };
            let train = Train::new(timing, 42_000, 0, 0);
            for phase in plan.phases() {
                let mut t = phase.start();
                let mut leg = Leg::new(&phase, (t, Ticks::MAX), u32::MAX, &train);
                prop_assert_eq!(leg.state, phase.at(t).rounded());
                for &(unusual, length) in &lengths {
                    let length = if unusual == 0 { length } else { usual };
                    t += Ticks::from(length);
                    leg.walk(length);
                    prop_assert_eq!(leg.exact, phase.at(t));
                    prop_assert_eq!(leg.state, phase.at(t).rounded());
                }
            }
        }
    }
}

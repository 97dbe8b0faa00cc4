//! Along a velocity that changes evenly, from pulse to pulse: what most of a linear ramp is.
//!
//! A stretch leads from the pulse that is open to the first one that is far enough. The pulses between them are evenly spaced, as in a
//! chord, but nothing is left open, and the only crossing that must be known is the last one: one division of 32 bits, from where the ramp is when it
//! is far enough. Where a pulse really lies the ramp is looked at again, so no tick that is rounded adds up.

use super::Axis;
use crate::clock::Ticks;
use crate::fixed::{Position, State, Velocity};
use crate::record::Direction;
use crate::train::Train;
use crate::train::slope::Stretch;

/// Stretches until the plan is looked at again. What is rounded in them stays below 2⁻²⁰ steps.
const MOST_STRETCHES: u32 = 64;

/// A period is shorter than so many parts of the longest chord: within one the velocity may be taken for constant, and a stretch is as good as a
/// chord.
const PERIODS_PER_CHORD: u32 = 16;

/// This part of a segment is handed out beyond what is asked for.
const SPARE: u32 = 16;

/// How a parabola is gone from pulse to pulse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    /// Half of the acceleration, Q64 steps per tick².
    half_acceleration: i32,
    /// The slowest that it is gone so, Q32 steps per tick.
    slowest: u32,
    /// The longest chord, in ticks.
    longest: u32,
    /// Q64 steps per tick.
    velocity: i64,
    /// Stretches gone since the plan was looked at; 0 if the velocity is not known.
    stretches: u32,
}

impl Slope {
    /// None.
    pub(super) const NONE: Self = Self {
        half_acceleration: 0,
        slowest: u32::MAX,
        longest: 0,
        velocity: 0,
        stretches: 0,
    };

    /// Of half an acceleration, Q96 steps per tick², whose chords are no longer than so many ticks.
    pub(super) fn new(half_acceleration: i128, longest: u32, train: &Train) -> Self {
        let slowest = (u64::from(PERIODS_PER_CHORD) << 32).checked_div(longest.into());
        match (
            i32::try_from(half_acceleration >> 32),
            slowest.map(u32::try_from),
        ) {
            // The opposite of the least number is none.
            (Ok(half_acceleration), Some(Ok(slowest))) if half_acceleration != i32::MIN => Self {
                half_acceleration,
                slowest: slowest.max(train.slowest()),
                longest: longest.min(train.longest()),
                ..Self::NONE
            },
            _ => Self::NONE,
        }
    }

    /// Whether a velocity is high enough.
    #[inline]
    pub(super) const fn is_fast(&self, velocity: Velocity) -> bool {
        (velocity.bits().unsigned_abs() >> 24) >= self.slowest as u64
    }

    /// Whether a stretch was gone since the plan was looked at.
    #[inline]
    pub(super) const fn is_under_way(&self) -> bool {
        self.stretches != 0
    }

    /// Whether the plan should be looked at.
    #[inline]
    pub(super) const fn is_worn(&self) -> bool {
        self.stretches >= MOST_STRETCHES
    }

    /// From a velocity on, Q96 steps per tick.
    pub(super) const fn begin(&mut self, velocity: i128) {
        self.velocity = (velocity >> 32) as i64;
    }

    /// The plan is looked at.
    pub(super) const fn end(&mut self) {
        self.stretches = 0;
    }

    /// Goes on from tick `begin` and from `position` to the first pulse `wanted` ticks later, or more, which is less than `left`. Gives the ticks
    /// that it took, and the state there; `None` and nothing is made if it is too slow or too fast for that.
    #[inline]
    pub(super) fn go_on(
        &mut self,
        begin: Ticks,
        position: Position,
        wanted: Ticks,
        left: Ticks,
        train: &mut Train,
    ) -> Option<(u32, State)> {
        let direction = if self.velocity < 0 {
            Direction::Reverse
        } else {
            Direction::Forward
        };
        // As if it went forward.
        let turn = |value: i64| match direction {
            Direction::Forward => value,
            Direction::Reverse => value.wrapping_neg(),
        };
        let velocity = turn(self.velocity);
        let half = turn(self.half_acceleration.into()) as i32;
        let wanted = wanted.min(self.longest.into()) as u32;
        let (way, after) = moved(velocity, half, wanted);
        // Less than 2³¹ as a number without a sign, if it has not turned back.
        let rate = (after >> 32) as u32;
        if rate.cast_signed() < self.slowest.cast_signed() || rate >> 8 >= train.easy() {
            return None;
        }
        let length = train.climb(&Stretch {
            begin,
            direction,
            ahead: turn(train.ahead(position)),
            way,
            first_rate: (velocity >> 32) as u32,
            rate,
            wanted,
            left,
            speeding_up: half >= 0,
        })?;
        let (way, after) = moved(velocity, half, length);
        self.stretches = self.stretches.wrapping_add(1);
        self.velocity = turn(after);
        let way = turn(way.cast_signed());
        let state = State {
            position: Position::from_bits(position.bits().wrapping_add(way)),
            velocity: Velocity::from_bits(self.velocity >> 8),
        };
        Some((length, state))
    }
}

/// The way, Q32, in so many ticks, less than 2³¹, and the velocity after them, Q64. Half of the acceleration is Q64, too.
#[inline]
fn moved(velocity: i64, half_acceleration: i32, ticks: u32) -> (u64, i64) {
    let gain = i64::from(half_acceleration).wrapping_mul(ticks.cast_signed().into());
    let mean = velocity.wrapping_add(gain);
    let (high, low) = ((mean >> 32) as u32, mean as u32);
    let low = u64::from(low).wrapping_mul(ticks.into()) >> 32;
    let way = u64::from(high).wrapping_mul(ticks.into()).wrapping_add(low);
    (way, mean.wrapping_add(gain))
}

impl Axis {
    /// Makes the records of a stretch of a linear ramp; whether it did.
    #[inline(never)]
    pub(super) fn go_along_slope(&mut self, enough: Ticks) -> bool {
        let begin = self.horizon;
        let Some(leg) = &mut self.leg else {
            return false;
        };
        // A little more than two segments are left then, as behind most chords: the last run may have to be waited for.
        let spare = self.train.segment() / SPARE;
        let wanted = enough.saturating_sub(begin).wrapping_add(spare.into());
        let gone = leg.go_from_pulse_to_pulse(begin, wanted, &mut self.train);
        let Some((length, state)) = gone else {
            return false;
        };
        let is_worn = leg.is_worn();
        self.go_to(begin.wrapping_add(length.into()), state);
        if is_worn {
            self.renew_leg();
        }
        true
    }

    /// Looks where the plan exactly is.
    #[inline(never)]
    pub(super) fn renew_leg(&mut self) {
        let exact = self.exact_at(self.horizon);
        if let Some(leg) = &mut self.leg {
            leg.renew(exact);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::leg::Leg;
    use crate::fixed::Position;
    use crate::train::Train;
    use crate::{Clock, DriverTiming, Limits, Plan, SignedSpeed, State, Ticks, Velocity};
    use proptest::prelude::*;

    const TIMING: DriverTiming = DriverTiming {
        pulse_high: 17,
        pulse_low: 17,
        direction_setup: 4,
        direction_hold: 4,
    };

    /// Goes along a ramp from one velocity to another, in stretches of about `wanted` ticks; gives how many there were.
    fn stretches(from: i32, to: i32, acceleration: u32, wanted: Ticks) -> usize {
        let clock = Clock::new(168_000_000).unwrap();
        let limits = Limits {
            velocity: to.unsigned_abs().into(),
            acceleration,
            deceleration: acceleration,
        };
        let state = State {
            position: Position::from_steps(7),
            velocity: Velocity::from_speed(clock, from.into()),
        };
        let to = SignedSpeed::per_second(to);
        let plan = Plan::velocity(clock, 77, state, to, limits).unwrap();
        let phase = plan.phases().next().unwrap();
        let until = plan.next_corner(77).unwrap();
        if until <= 77 + 42_000 {
            return 0;
        }
        let mut train = Train::new(TIMING, 42_000, 7, 77);
        train.draw(&crate::train::Chord {
            begin: 77,
            length: 42_000,
            from: state.position,
            to: phase.at(77 + 42_000).rounded().position,
            speeding_up: true,
            steady: false,
        });
        train.handed_out();
        let longest = u32::try_from(phase.longest_chord(77)).unwrap_or(u32::MAX);
        let mut t = 77 + 42_000;
        let mut leg = Leg::new(&phase, (t, until), longest, &train);
        let mut count = 0;
        while leg.is_slope(t, t) && !leg.is_worn() {
            let gone = leg.go_from_pulse_to_pulse(t, wanted, &mut train);
            let Some((length, there)) = gone else { break };
            let least = wanted.min(longest.into()).min(42_000);
            assert!(Ticks::from(length) + 168 >= least, "{length} ticks");
            t += Ticks::from(length);
            assert!(t < until);
            assert_eq!(train.pen(), t);
            let exact = phase.at(t).rounded();
            let off = there.position.bits().abs_diff(exact.position.bits());
            assert!(off < 1 << 12, "{off} Q32 steps");
            let off = there.velocity.bits().abs_diff(exact.velocity.bits());
            assert!(off < 1 << 20, "{off} Q56");
            // The last pulse is in the middle before its step, but for two ticks and what the velocity changes in a period.
            let off = train.ahead(exact.position).unsigned_abs().abs_diff(1 << 31);
            let allowed = (1 << 24) + (exact.velocity.bits().unsigned_abs() >> 23);
            assert!(off < allowed, "{off} Q32 steps, not {allowed}");
            train.handed_out();
            count += 1;
        }
        count
    }

    #[test]
    fn most_of_a_ramp_is_gone_from_pulse_to_pulse() {
        for (from, to) in [
            (6_000, 200_000),
            (-6_000, -200_000),
            (200_000, 6_000),
            (-200_000, -6_000),
        ] {
            assert_eq!(stretches(from, to, 100_000, 42_000), 64, "{from} to {to}");
        }
        // Too slow for a pulse in each segment, and too hard for an even period.
        assert_eq!(stretches(1_000, 3_000, 100, 42_000), 0);
        assert_eq!(stretches(10_000, 20_000, 10_000_000, 42_000), 0);
    }

    proptest! {
        #[test]
        fn stretches_end_where_the_phase_says(
            from in 1i32..3_000_000,
            to in 1i32..3_000_000,
            reverse: bool,
            acceleration in 1u32..10_000_000,
            wanted in 0u64..100_000,
        ) {
            let sign = if reverse { -1 } else { 1 };
            prop_assume!(from != to);
            stretches(from * sign, to * sign, acceleration, wanted);
        }
    }
}

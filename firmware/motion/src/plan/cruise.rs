//! The velocity between the two ramps of a jerk-limited move: the greatest for which both fit into the way.
//!
//! A ramp that begins with an acceleration is part of one that begins without, or goes on from where the acceleration has gone to
//! nothing; either way the length of the whole way is a constant and two ramps without acceleration at their ends. Its root is
//! looked for with rough numbers by Newton's method, within bounds, and then brought to the last bits with exact ones. The
//! velocity is rounded down: the cruise takes up what that leaves, a quarter of a tick at most.

use super::jerk_limited::Rules;
use super::ramp::{Jerk, LONGEST, Piece, coasting, steady_way};
use super::rough::{Kind, Rough};
use crate::clock::Fine;

/// Looking with rough numbers takes some six steps, and with exact ones two. This bounds both; where a few exact steps do not come to
/// the end, the bounds are halved.
const MOST_ROUGH: u32 = 24;
const MOST_STRAIGHT: u32 = 4;
const MOST_EXACT: u32 = 24;

/// So small a step is within what rough numbers can tell.
const ROUGH_BITS: u32 = 18;

/// A part of a way of which rough numbers are sure: 2⁻¹⁶.
const DOUBT: Rough = Rough::power(-16);

/// A way of 2³⁰ steps. Within a longer one a ramp may be so long that its way saturates, of which rough numbers know nothing.
const LONG: Rough = Rough::power(30);

/// The beginning of a motion: the velocity of the ramp without acceleration that stands for it, and how far the motion is ahead of that.
struct Entrance {
    velocity: i128,
    way: i128,
    /// The greatest acceleration of the ramp.
    most: Fine,
}

impl Entrance {
    /// Of a ramp upwards, to a velocity that is not below that of coasting.
    fn upwards(velocity: i128, acceleration: i128, most: Fine, jerk: Jerk) -> Self {
        let (mut velocity, mut way, mut acceleration) = (velocity, 0, acceleration);
        let sixth = jerk.sixth.cast_signed();
        let limit = most.cast_signed();
        if acceleration < 0 || acceleration > limit {
            // First of all to no acceleration, or to the greatest.
            let goes_to = if acceleration < 0 { 0 } else { limit };
            let piece = Piece {
                time: jerk.time(acceleration.abs_diff(goes_to)),
                velocity,
                acceleration,
                sixth_jerk: if acceleration < 0 {
                    sixth
                } else {
                    sixth.wrapping_neg()
                },
                way: 0,
            };
            way = piece.goes();
            velocity = piece.end_velocity();
            acceleration = goes_to;
        }
        if acceleration > 0 {
            // As if it had begun earlier.
            let time = jerk.time(acceleration.unsigned_abs());
            let mut piece = Piece {
                time,
                velocity: 0,
                acceleration: 0,
                sixth_jerk: sixth,
                way: 0,
            };
            piece.velocity = velocity.saturating_sub(piece.end_velocity());
            way = way.saturating_sub(piece.goes());
            velocity = piece.velocity;
        }
        Self {
            velocity,
            way,
            most,
        }
    }

    /// Of a ramp downwards.
    fn downwards(velocity: i128, acceleration: i128, most: Fine, jerk: Jerk) -> Self {
        let mirrored = Self::upwards(
            velocity.wrapping_neg(),
            acceleration.wrapping_neg(),
            most,
            jerk,
        );
        Self {
            velocity: mirrored.velocity.wrapping_neg(),
            way: mirrored.way.saturating_neg(),
            most,
        }
    }
}

/// What rules the motion, in rough numbers: its jerk, and of each ramp the greatest acceleration and how long a change of velocity takes at it.
struct RoughRules {
    jerk: Rough,
    first: (Rough, Rough),
    last: (Rough, Rough),
}

/// The moves with one entrance and one end.
struct Moves<'a> {
    rules: &'a Rules,
    entrance: Entrance,
    end: i128,
    way: u128,
    rough: RoughRules,
    /// The way that both ramps are to take, without the constant.
    goal: Rough,
}

impl<'a> Moves<'a> {
    fn new(rules: &'a Rules, entrance: Entrance, end: i128, way: u128) -> Self {
        let limit = |most: Fine| {
            let most = Rough::of(most, Kind::Acceleration);
            (most, Rough::ONE.over(most))
        };
        let goal = if entrance.way < 0 {
            way.saturating_add(entrance.way.unsigned_abs())
        } else {
            way.saturating_sub(entrance.way.unsigned_abs())
        };
        Self {
            rough: RoughRules {
                jerk: Rough::of(rules.jerk.whole(), Kind::Jerk),
                first: limit(entrance.most),
                last: limit(rules.deceleration),
            },
            rules,
            entrance,
            end,
            way,
            goal: Rough::of(goal, Kind::Way),
        }
    }

    /// How far both ramps go with a velocity between them, exactly but for roundings. A ramp whose way saturates fits into no way: the
    /// velocity is then the greatest with ramps below 2³¹ steps.
    fn span(&self, cruise: i128) -> u128 {
        let jerk = self.rules.jerk;
        let first = steady_way(self.entrance.velocity, cruise, self.entrance.most, jerk);
        let is_alike =
            self.entrance.velocity == self.end && self.entrance.most == self.rules.deceleration;
        let last = if is_alike {
            first
        } else {
            steady_way(cruise, self.end, self.rules.deceleration, jerk)
        };
        let longest = first.saturating_add(self.entrance.way.max(0)).max(last);
        if longest.max(0).unsigned_abs() >= LONGEST {
            return u128::MAX;
        }
        let last = last.unsigned_abs();
        let (first, ahead) = (first.max(0).unsigned_abs(), self.entrance.way);
        if ahead < 0 {
            last.saturating_add(first)
                .saturating_sub(ahead.unsigned_abs())
        } else {
            last.saturating_add(first)
                .saturating_add(ahead.unsigned_abs())
        }
    }

    /// The same in rough numbers and without the constant, and how much longer it gets with the velocity: 0 where it does not.
    fn rough_span(&self, cruise: i128) -> (Rough, Rough) {
        let ramp = |from: i128, (most, slowness): (Rough, Rough)| {
            let gain = Rough::of(cruise.abs_diff(from), Kind::Velocity);
            let sum = cruise.saturating_add(from).max(0).unsigned_abs();
            let mean = Rough::of(sum, Kind::Velocity).halved();
            let peak = self.rough.jerk.times(gain).root();
            let (time, growth) = if peak < most {
                let growth = Rough::ONE.over(peak);
                (gain.times(growth).doubled(), growth)
            } else {
                let entry = most.over(self.rough.jerk);
                (gain.times(slowness).plus(entry), slowness)
            };
            (mean.times(time), time.halved(), mean.times(growth))
        };
        let (first, last) = (
            ramp(self.entrance.velocity, self.rough.first),
            ramp(self.end, self.rough.last),
        );
        let mut slope = first.1.plus(last.1).plus(last.2);
        if cruise >= self.entrance.velocity {
            slope = slope.plus(first.2);
        } else if slope > first.2 {
            // The faster the cruise, the shorter is the ramp down to it.
            slope = slope.distance(first.2);
        } else {
            slope = Rough::ZERO;
        }
        (first.0.plus(last.0), slope)
    }

    /// Whether both ramps fit into the way.
    fn fit(&self, cruise: i128) -> bool {
        let (span, _) = self.rough_span(cruise);
        let doubt = self.goal.times(DOUBT);
        if span.distance(self.goal) > doubt && self.goal > Rough::ZERO {
            if span > self.goal {
                return false;
            }
            if self.goal < LONG {
                return true;
            }
        }
        self.span(cruise) <= self.way
    }

    /// The greatest velocity for which they fit, rounded down. They do at `low`, and do not at `high`.
    fn greatest(&self, mut low: i128, mut high: i128) -> i128 {
        let bounds = (low, high);
        let (mut cruise, mut slope) = self.guess(low, high);
        for _ in 0..MOST_ROUGH {
            let (span, grows) = self.rough_span(cruise);
            slope = grows;
            let step = span.distance(self.goal).over(slope).fixed(Kind::Velocity);
            let step = i128::try_from(step).unwrap_or(i128::MAX);
            let next = if span <= self.goal {
                low = cruise;
                cruise.saturating_add(step)
            } else {
                high = cruise;
                cruise.saturating_sub(step)
            };
            let is_steep = slope > Rough::ZERO;
            let is_within = is_steep && low < next && next < high;
            if is_steep && step <= cruise >> ROUGH_BITS {
                if is_within {
                    cruise = next;
                }
                break;
            }
            cruise = if is_within { next } else { low.midpoint(high) };
            if high.wrapping_sub(low) <= cruise >> (ROUGH_BITS + 2) {
                break;
            }
        }
        self.settle(bounds, cruise, slope)
    }

    /// Where to begin to look: far from the root the way grows with a power of the velocity between 1.5 and 2.
    fn guess(&self, low: i128, high: i128) -> (i128, Rough) {
        let (least, slope) = self.rough_span(low);
        let (most, _) = self.rough_span(high);
        let part = self.goal.distance(least).over(most.distance(least)).root();
        let room = high.wrapping_sub(low).unsigned_abs();
        let ahead = Rough::of(room, Kind::Velocity)
            .times(part)
            .fixed(Kind::Velocity)
            .min(room >> 1 | room >> 2);
        (low.wrapping_add(ahead.cast_signed()), slope)
    }

    /// From a good guess to the last bits: the cruise is over within a quarter of a tick.
    fn settle(&self, (mut low, mut high): (i128, i128), guess: i128, slope: Rough) -> i128 {
        let mut cruise = guess;
        for tried in 0..MOST_EXACT {
            let span = self.span(cruise);
            let off = span.abs_diff(self.way);
            let is_short = span <= self.way;
            // Aims at a sixteenth of a tick.
            let aim = cruise.unsigned_abs() >> 4;
            let lacks = if is_short {
                low = cruise;
                if off <= cruise.unsigned_abs() >> 2 {
                    break;
                }
                off.saturating_sub(aim)
            } else {
                high = cruise;
                off.saturating_add(aim)
            };
            if high.wrapping_sub(low) <= 1 << 8 {
                break;
            }
            let step = Rough::of(lacks, Kind::Way)
                .over(slope)
                .fixed(Kind::Velocity);
            let step = i128::try_from(step).unwrap_or(i128::MAX);
            let next = if is_short {
                cruise.saturating_add(step)
            } else {
                cruise.saturating_sub(step)
            };
            let is_within = tried < MOST_STRAIGHT && low < next && next < high;
            cruise = if is_within { next } else { low.midpoint(high) };
        }
        low
    }
}

impl Rules {
    /// The greatest velocity between a ramp from a state and one to the velocity `end`, within `way`; `None` if there is none.
    pub(super) fn cruise(
        &self,
        velocity: i128,
        acceleration: i128,
        end: i128,
        way: u128,
    ) -> Option<i128> {
        let jerk = self.jerk;
        let coasting = coasting(velocity, acceleration, jerk);
        let mut most = self.top;
        if coasting <= self.top {
            let rising = Entrance::upwards(velocity, acceleration, self.acceleration, jerk);
            let moves = Moves::new(self, rising, end, way);
            if moves.fit(self.top) {
                return Some(self.top);
            }
            let least = coasting.max(end);
            if moves.fit(least) {
                return Some(moves.greatest(least, self.top));
            }
            if least == end {
                return None;
            }
            most = least;
        }
        let falling = Entrance::downwards(velocity, acceleration, self.deceleration, jerk);
        let moves = Moves::new(self, falling, end, way);
        if most == self.top && moves.fit(self.top) {
            return Some(self.top);
        }
        moves.fit(end).then(|| moves.greatest(end, most))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::contextualize_config;

    use super::*;
    use crate::clock::Clock;
    use crate::plan::Limits;

    /// Limits that a drive may have, in steps and seconds.
    fn rules() -> impl Strategy<Value = Rules> {
        (1u32..4_000_000, 1u32..50_000_000, 1u32..50_000_000, 1u32..).prop_map(
            |(velocity, acceleration, deceleration, jerk)| {
                let clock = Clock::new(168_000_000).unwrap();
                let limits = Limits {
                    velocity: velocity.into(),
                    acceleration,
                    deceleration,
                };
                let jerk = Jerk::new(clock.sixth_jerk(jerk));
                Rules::new(clock, limits, jerk)
            },
        )
    }

    /// A part of a number, in thousandths of its root: small ones are frequent.
    fn part(number: i128, thousandths: i128) -> i128 {
        (number >> 20) * thousandths * thousandths * (1 << 20) / 1_000_000
    }

    proptest! {
        #![proptest_config(contextualize_config(ProptestConfig::with_cases(4096)))]

        /// The ramps fit into the way, and what they leave of it is over within a tick, or the velocity is the greatest allowed.
        #[test]
        fn the_velocity_found_is_the_greatest(
            rules in rules(),
            (speed, pull, end) in (0i128..1200, -1000i128..=1000, 0i128..=1000),
            way in (1u128 << 60)..,
            shift in 0u32..64,
        ) {
            let way = way >> shift;
            let velocity = part(rules.top, speed);
            let limit = if pull < 0 { rules.deceleration } else { rules.acceleration };
            let acceleration = part(limit.cast_signed(), pull) * pull.signum();
            let end = part(rules.top, end);
            if coasting(velocity, acceleration, rules.jerk) < 0 {
                return Ok(());
            }
            let Some(cruise) = rules.cruise(velocity, acceleration, end, way) else {
                return Ok(());
            };
            prop_assert!(end <= cruise && cruise <= rules.top);
            let ways = rules.over(velocity, acceleration, cruise, end).way();
            let rounded = (ways >> 40) + (1 << 40);
            prop_assert!(ways <= way + rounded, "{ways} of {way}");
            let left = way.saturating_sub(ways);
            prop_assert!(
                cruise == rules.top || left <= (cruise.unsigned_abs() >> 1) + rounded,
                "{left} of {way} left at {cruise} of {}, down to {end}", rules.top
            );
        }
    }
}

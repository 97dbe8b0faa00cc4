//! The velocity between the two ramps of a jerk-limited move: the greatest for which both fit into the distance.
//!
//! A ramp that begins with an acceleration is part of one that begins without, or goes on from where the acceleration has gone to
//! zero; in both the length of the whole distance is a constant and two ramps without acceleration at their ends. Its root is
//! looked for with rough numbers by Newton's method, within bounds, and then brought to the last bits by one step with exact ones.
//! The velocity is rounded down: the cruise takes up what that leaves.

use super::Rules;
use super::ramp::{Limit, Motion, RoughLimit, VirtualStart, steady_distance};
use super::rough::{Kind, Rough};
use crate::exact::{DistanceQ96, PositionQ96, Q96, Uq96};

/// The most iterations: of the search in rough numbers, which takes some four; of Newton's method with exact ones, which takes one,
/// before the bounds are halved instead; and of both with exact ones.
const MOST_ROUGH: u32 = 24;
const MOST_NEWTON: u32 = 4;
const MOST_EXACT: u32 = 24;

/// From rest they are halved until a velocity fits: each of them above zero is one at which the target is reached.
const MOST_HALVINGS: u32 = 128;

/// A step, as a part of the velocity, so small that the next one is below the resolution of rough numbers. After an exact step of that
/// size no other is needed.
const SMALL_STEP: Rough = Rough::power(-13);

/// The search ends where the bounds are no further apart than this part of the velocity.
const CLOSE_BOUNDS: Rough = Rough::power(-20);

/// The error of a distance in rough numbers is below this part of it.
const ROUGH_ERROR: Rough = Rough::power(-16);

/// The same where a velocity is the difference of others.
const ROUGH_ERROR_OF_DIFFERENCE: Rough = Rough::power(-10);

/// An exact step is made shorter by this part, so that it does not pass the root: the slope is not known better.
const STEP_MARGIN: Rough = Rough::power(-12);

/// A sixteenth of a tick, by which an exact step is made shorter too.
const TIME_MARGIN: Rough = Rough::power(-24 - 4);

/// An eighth of a tick: the last step may be made shorter by as much.
const LAST_STEP_TOLERANCE: Rough = Rough::power(-24 - 3);

/// A distance of 2³⁰ steps. Within a longer one a ramp may be so long that its distance saturates, which rough numbers cannot tell.
const LONG: Rough = Rough::power(30);

/// Distances of 2³¹ steps and more saturate. From here on, a few steps below that, a distance counts as saturated.
const LONGEST: i128 = i128::MAX - (1 << 100);

/// What does not fit into any distance.
const TOO_FAR: DistanceQ96 = DistanceQ96::from_bits(u128::MAX);

/// A ramp in rough numbers.
struct Side {
    /// The change of velocity, and the mean velocity, with the lowest possible cruise velocity.
    gain: Rough,
    mean: Rough,
    limit: RoughLimit,
}

impl Side {
    fn new(velocity: Q96, least: Q96, limit: &Limit) -> Self {
        let gain = (least - velocity).amount();
        let sum = least + velocity;
        let mean = speed(sum).halved();
        Self {
            gain: Rough::of(gain.bits(), Kind::Velocity),
            mean: if sum < Q96::ZERO {
                mean.negated()
            } else {
                mean
            },
            limit: limit.rough,
        }
    }

    /// Its distance with a cruise that is faster by `more`, what its time and its mean velocity add to the slope of that, and which side of it
    /// grows.
    #[inline(always)]
    fn distance(&self, gain: Rough, more: Rough, jerk: Rough) -> (Rough, Rough, Rough) {
        let RoughLimit {
            square: limit,
            slowness,
            entry,
        } = self.limit;
        let mean = self.mean.plus(more.halved());
        let square = jerk.times(gain);
        let (half_time, growth) = if square < limit {
            let growth = square.reciprocal_root();
            (gain.times(growth), growth)
        } else {
            (gain.times(slowness).plus(entry).halved(), slowness)
        };
        (
            mean.times(half_time).doubled(),
            half_time,
            mean.times(growth),
        )
    }
}

/// The moves with one virtual start and one end.
struct Moves<'a> {
    rules: &'a Rules<'a>,
    virtual_start: &'a VirtualStart,
    limit: &'a Limit,
    end: Q96,
    distance: DistanceQ96,
    /// The lowest cruise that comes into question.
    least: Q96,
    jerk: Rough,
    is_from_rest: bool,
    first: Side,
    last: Side,
    /// The distance that both ramps are to take, without the constant, and by how much that may be off.
    goal: Rough,
    error_bound: Rough,
}

/// What rough numbers tell of the ramps with one cruise: how far they go, and how much longer that gets with the velocity: 0 or less where
/// it does not.
#[derive(Clone, Copy)]
struct Probe {
    span: Rough,
    slope: Rough,
}

impl Probe {
    const NOTHING: Self = Self {
        span: Rough::ZERO,
        slope: Rough::ZERO,
    };
}

impl<'a> Moves<'a> {
    fn new(
        rules: &'a Rules<'a>,
        virtual_start: &'a VirtualStart,
        end: Q96,
        distance: DistanceQ96,
        least: Q96,
    ) -> Self {
        let limit = if virtual_start.falls {
            rules.deceleration
        } else {
            rules.acceleration
        };
        let ahead = virtual_start.ahead.bits();
        let amount = ahead.unsigned_abs();
        let goal = if ahead < 0 {
            distance.bits().saturating_add(amount)
        } else {
            distance.bits().saturating_sub(amount)
        };
        let goal = Rough::of(goal, Kind::Distance);
        let sure = if ahead > 0 {
            Rough::of(distance.bits(), Kind::Distance).max(goal)
        } else {
            goal
        };
        Self {
            rules,
            virtual_start,
            limit,
            end,
            distance,
            least,
            jerk: rules.jerk.rough,
            is_from_rest: virtual_start.velocity.is_zero() && end.is_zero() && least.is_zero(),
            first: Side::new(virtual_start.velocity, least, limit),
            last: Side::new(end, least, rules.deceleration),
            goal,
            error_bound: sure.times(if virtual_start.falls {
                ROUGH_ERROR_OF_DIFFERENCE
            } else {
                ROUGH_ERROR
            }),
        }
    }

    /// How far both ramps go with a velocity between them, exactly but for roundings. A ramp whose distance saturates fits into no distance: the
    /// velocity is then the greatest with ramps below 2³¹ steps.
    fn span(&self, cruise: Q96) -> DistanceQ96 {
        let jerk = self.rules.jerk;
        let first = steady_distance(self.virtual_start.velocity, cruise, self.limit, jerk).bits();
        let is_alike = self.virtual_start.velocity == self.end
            && self.limit.most == self.rules.deceleration.most;
        let last = if is_alike {
            first
        } else {
            steady_distance(cruise, self.end, self.rules.deceleration, jerk).bits()
        };
        let steady = first.max(last);
        let first = first.saturating_add(self.virtual_start.ahead.bits());
        if steady.max(first) >= LONGEST {
            return TOO_FAR;
        }
        DistanceQ96::from_bits(if first < 0 {
            last.saturating_add(first).max(0).unsigned_abs()
        } else {
            last.unsigned_abs() + first.unsigned_abs()
        })
    }

    /// With a cruise that is faster than the lowest by `more`.
    #[inline(never)]
    fn probe(&self, more: Rough) -> Probe {
        let gain = if self.virtual_start.falls {
            self.first.gain.minus(more).max(Rough::ZERO)
        } else {
            self.first.gain.plus(more)
        };
        let first = self.first.distance(gain, more, self.jerk);
        let last = self
            .last
            .distance(self.last.gain.plus(more), more, self.jerk);
        let slope = first.1.plus(last.1).plus(last.2);
        Probe {
            span: first.0.plus(last.0),
            // The faster the cruise, the shorter is the ramp down to it.
            slope: if self.virtual_start.falls {
                slope.minus(first.2)
            } else {
                slope.plus(first.2)
            },
        }
    }

    /// Whether both ramps fit into the distance.
    fn fit(&self, cruise: Q96, probe: Probe) -> bool {
        let span = probe.span;
        if span.distance(self.goal) > self.error_bound && self.goal > Rough::ZERO {
            if span > self.goal {
                return false;
            }
            if self.goal < LONG {
                return true;
            }
        }
        self.span(cruise) <= self.distance
    }

    /// The velocity of a move from rest to rest, if neither ramp comes to its limit, or both do; where only the slower one does, that with no
    /// other, which is too high: from there on the steps are short, as the distance curves upwards.
    fn guess_from_rest(&self) -> Rough {
        // v³ = j·distance²/4
        let short = self.goal.times(self.goal).times(self.jerk);
        let velocity = short.halved().halved().cube_root();
        let (first, last) = (self.first.limit, self.last.limit);
        let (slow, quick) = if last.square < first.square {
            (last, first)
        } else {
            (first, last)
        };
        if velocity.times(self.jerk) <= slow.square {
            return velocity;
        }
        // v² · (1/a + 1/d)/2 + v · (a + d)/2j = distance
        let held = |slowness: Rough, entry: Rough| {
            let half = entry.halved();
            let square = half.times(half).plus(slowness.times(self.goal).doubled());
            self.goal.doubled().over(square.root().plus(half))
        };
        let both = held(
            slow.slowness.plus(quick.slowness),
            slow.entry.plus(quick.entry),
        );
        if both.times(self.jerk) >= quick.square {
            return both;
        }
        held(slow.slowness, slow.entry).min(velocity)
    }

    /// The velocity beyond the lowest of any other move: as if the distance were a parabola with what is known of it at both ends. It is where both
    /// ramps are at their limits with the lowest velocity, too.
    fn guess(&self, low: Probe, range: Rough, top: Probe) -> Rough {
        let all = top.span.minus(low.span);
        let part = self.goal.minus(low.span).over(all);
        let rise = top.slope.times(range).over(all);
        let curvature = rise.minus(Rough::ONE).min(Rough::ONE);
        let line = Rough::ONE.minus(curvature);
        let square = line
            .times(line)
            .plus(curvature.times(part).doubled().doubled());
        range.times(part.doubled().over(square.root().plus(line)))
    }

    /// The greatest velocity for which they fit, rounded down. They do at the lowest, and do not at `high`.
    fn greatest(&self, low: Probe, high: Q96, range: Rough, top: Probe) -> Q96 {
        let (goal, mut below, mut above) = (self.goal, Rough::ZERO, range);
        let guess = if self.is_from_rest {
            self.guess_from_rest()
        } else {
            self.guess(low, range, top)
        };
        let mut more = guess.min(range.halved().plus(range.halved().halved()));
        let mut slope = low.slope;
        for _ in 0..MOST_ROUGH {
            let probe = self.probe(more);
            slope = probe.slope;
            let short = goal.minus(probe.span);
            if short < Rough::ZERO {
                above = more;
            } else {
                below = more;
            }
            let step = short.over(slope);
            let next = more.plus(step);
            let is_straight = slope > Rough::ZERO;
            let is_within = is_straight && below < next && next < above;
            if is_straight && step.magnitude() <= more.times(SMALL_STEP) {
                if is_within {
                    more = next;
                }
                break;
            }
            more = if is_within {
                next
            } else {
                below.plus(above).halved()
            };
            if above.minus(below) <= more.times(CLOSE_BOUNDS) {
                break;
            }
        }
        self.refine(high, more, slope)
    }

    /// Refines a good first guess to the last bits.
    fn refine(&self, mut high: Q96, more: Rough, slope: Rough) -> Q96 {
        let mut low = self.least;
        let mut cruise = (low + exact(more)).min(high);
        for tried in 0..MOST_HALVINGS {
            let span = self.span(cruise);
            let mut off = span.abs_diff(self.distance);
            let is_short = span <= self.distance;
            if is_short {
                low = cruise;
                if off.bits() <= cruise.bits().unsigned_abs() >> 2 {
                    break;
                }
            } else {
                high = cruise;
                if span == TOO_FAR {
                    // How much too long is not known: a step that is too large to be the last, and more than rough numbers miss.
                    off = off.max(DistanceQ96::from_bits(self.distance.bits() >> 8));
                }
            }
            let is_enough = tried >= MOST_EXACT && (low > Q96::ZERO || !self.is_from_rest);
            if is_enough || (high - low).bits() <= 1 << 8 {
                break;
            }
            let off = Rough::of(off.bits(), Kind::Distance);
            let speed = speed(cruise);
            let spare = off.times(STEP_MARGIN).plus(speed.times(TIME_MARGIN));
            let next = if is_short {
                let step = off.minus(spare).max(Rough::ZERO).over(slope);
                cruise + exact(step)
            } else {
                cruise - exact(off.plus(spare).over(slope))
            };
            let is_within = slope > Rough::ZERO && tried < MOST_NEWTON && low < next && next < high;
            let is_last = off <= slope.times(more).times(SMALL_STEP)
                && off.times(STEP_MARGIN) <= speed.times(LAST_STEP_TOLERANCE);
            if is_within && is_last {
                return next;
            }
            cruise = if is_within {
                next
            } else {
                (low + high).halved()
            };
        }
        low
    }
}

/// The exact velocity, cut to 2³⁰ steps per tick, far beyond all that are looked for.
fn exact(velocity: Rough) -> Q96 {
    Uq96::from_bits(velocity.fixed(Kind::Velocity).min(1 << 126)).forwards()
}

/// The amount of a velocity.
fn speed(velocity: Q96) -> Rough {
    Rough::of(velocity.amount().bits(), Kind::Velocity)
}

impl Rules<'_> {
    /// The greatest velocity between a ramp from a motion and one to the velocity `end`, within `distance`; `None` if there is none. `virtual_start`
    /// becomes that of the first ramp.
    pub(super) fn fastest(
        &self,
        from: &Motion,
        end: Q96,
        distance: DistanceQ96,
        virtual_start: &mut VirtualStart,
    ) -> Option<Q96> {
        let coasting = from.coasting();
        let mut most = self.top;
        if coasting <= self.top {
            virtual_start.renew(from, false, self.acceleration);
            let least = coasting.max(end);
            let cruise = self.chosen(virtual_start, end, distance, (least, self.top), true);
            if cruise.is_some() || least == end {
                return cruise.filter(|cruise| *cruise > Q96::ZERO);
            }
            most = least;
        }
        virtual_start.renew(from, true, self.deceleration);
        let is_top = most == self.top;
        let cruise = self.chosen(virtual_start, end, distance, (end, most), is_top);
        cruise.filter(|cruise| *cruise > Q96::ZERO)
    }

    /// The same with one virtual start, between a velocity and another, which may fit only if it is the greatest there is.
    #[inline(never)]
    fn chosen(
        &self,
        virtual_start: &VirtualStart,
        end: Q96,
        distance: DistanceQ96,
        (least, most): (Q96, Q96),
        is_top: bool,
    ) -> Option<Q96> {
        if virtual_start.is_far {
            return None;
        }
        let moves = Moves::new(self, virtual_start, end, distance, least);
        let range = speed(most - least);
        let high = moves.probe(range);
        if is_top && moves.fit(most, high) {
            return Some(most);
        }
        // Without a cruise there are no ramps.
        if moves.is_from_rest && virtual_start.ahead == PositionQ96::ZERO {
            return Some(moves.greatest(Probe::NOTHING, most, range, high));
        }
        let low = moves.probe(Rough::ZERO);
        moves
            .fit(least, low)
            .then(|| moves.greatest(low, most, range, high))
    }
}

#[cfg(test)]
mod tests;

//! Whether set-points keep to 60C5h and 60C6h, as far as whole numbers let it be known.
//!
//! Set-points are whole units of the user, so a steady motion has distances that differ by a unit from one period to the next, and that may be
//! many times what the limits allow. Over longer spans it counts for less. Of two spans of N periods T next to each other the distances differ
//! by no more than a·(N·T)², and by two units because of the four ends that are rounded. So spans of 1, 2, 4, 8 and 16 periods are
//! looked at: what keeps to the limits never breaks this, and what breaks it does not keep to them.

/// The longest span, in periods.
const LONGEST: usize = 16;
/// How many set-points are kept: two of the longest spans end with the one to come.
const KEPT: usize = 2 * LONGEST;

/// By how much the distance of a period may differ from that of the one before, in increments × 2¹⁶.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaxChange {
    /// While the speed grows: 60C5h.
    pub(super) up: i64,
    /// While it falls: 60C6h.
    pub(super) down: i64,
    /// What rounding makes of it.
    pub(super) rounding: i64,
}

impl MaxChange {
    /// Nothing but what rounding makes of a steady motion.
    pub(super) const fn rounding(rounding: i64) -> Self {
        Self {
            up: 0,
            down: 0,
            rounding,
        }
    }
}

/// The last set-points, in whole increments modulo 2³².
#[derive(Debug)]
pub(super) struct SetPoints {
    kept: [i32; KEPT],
    /// How many of them there are.
    count: usize,
    /// Where the next one goes.
    next: usize,
    /// The distance to the last one, and how many in a row before it were the same.
    distance: i32,
    alike: u8,
}

impl SetPoints {
    pub(super) const fn new() -> Self {
        Self {
            kept: [0; KEPT],
            count: 0,
            next: 0,
            distance: 0,
            alike: 0,
        }
    }

    /// The motor did not go by the set-points, but as from here to there in a period.
    pub(super) fn begin(&mut self, from: i32, to: i32) {
        self.count = 0;
        self.keep(from);
        self.keep(to);
        self.alike = 0;
    }

    /// The motor goes to this one.
    #[inline(never)]
    pub(super) fn keep(&mut self, at: i32) {
        let distance = at.wrapping_sub(self.before(1));
        self.alike = if distance == self.distance {
            self.alike.saturating_add(1)
        } else {
            0
        };
        self.distance = distance;
        if let Some(place) = self.kept.get_mut(self.next % KEPT) {
            *place = at;
        }
        self.next = self.next.wrapping_add(1) % KEPT;
        self.count = self.count.saturating_add(1).min(KEPT);
    }

    /// Whether all of them are as far apart.
    const fn are_even(&self) -> bool {
        self.alike as usize >= KEPT
    }

    /// Whether all of them are the same.
    pub(super) const fn stand(&self) -> bool {
        self.are_even() && self.distance == 0
    }

    /// Whether `at`, one period behind the last set-point, keeps to the limits.
    pub(super) fn may_be_followed_by(&self, at: i32, max: MaxChange) -> bool {
        let mut middle = self.before(1);
        if self.are_even() && at.wrapping_sub(middle) == self.distance {
            return true;
        }
        for doublings in 0..=LONGEST.ilog2() {
            let span = 2 << doublings;
            if span > self.count {
                break;
            }
            let distance = at.wrapping_sub(middle);
            let start = self.before(span);
            let before = middle.wrapping_sub(start);
            if !may_change(before, distance, doublings, max) {
                return false;
            }
            middle = start;
        }
        true
    }

    /// The set-point so many periods before the one to come, 1 to [`KEPT`].
    fn before(&self, periods: usize) -> i32 {
        let place = self.next.wrapping_add(KEPT).wrapping_sub(periods) % KEPT;
        self.kept.get(place).copied().unwrap_or(0)
    }
}

/// Whether the distance of 2ⁿ periods may become another, in increments.
fn may_change(before: i32, distance: i32, doublings: u32, max: MaxChange) -> bool {
    // More than distances of 32 bits differ by; so nothing here is too large for its number.
    const LARGEST: i64 = 1 << 50;
    let change = i64::from(distance.abs_diff(before)) << super::POINT;
    let rounding = max.rounding.min(LARGEST);
    // So it is in a steady motion.
    if change <= rounding {
        return true;
    }
    let turns = (before < 0) != (distance < 0) && before != 0 && distance != 0;
    let gain = if turns {
        max.up.max(max.down)
    } else if distance.unsigned_abs() > before.unsigned_abs() {
        max.up
    } else {
        max.down
    };
    let squares = gain.min(LARGEST).wrapping_shl(2 * doublings);
    change <= squares.wrapping_add(rounding)
}

#[cfg(test)]
mod tests {
    use super::super::POINT;
    use super::*;
    use proptest::prelude::*;
    use std::vec;

    /// 1 increment a period, each period.
    const ONE: i64 = 1 << POINT;

    fn max(up: i64, down: i64, unit: i64) -> MaxChange {
        MaxChange {
            up,
            down,
            rounding: 2 * unit * ONE,
        }
    }

    /// After how many set-points it is found out that they do not keep to the limits.
    fn found(positions: impl IntoIterator<Item = i32>, max: MaxChange) -> Option<usize> {
        let mut set_points = SetPoints::new();
        positions.into_iter().position(|at| {
            let is_found = !set_points.may_be_followed_by(at, max);
            set_points.keep(at);
            is_found
        })
    }

    proptest! {
        /// Ramps of whatever acceleration is allowed, in whole units.
        #[test]
        fn m39_set_points_that_keep_to_the_limits_are_followed(
            ramps in prop::collection::vec((-100..=100_i64, 1..60_usize), 1..12),
            gain in 1..20 * ONE,
            unit in 1..50_i64,
            begin in any::<i32>(),
        ) {
            let (mut at, mut distance) = (0, 0);
            let mut positions = vec![begin; 5];
            for (percent, periods) in ramps {
                for _ in 0..periods {
                    let next = distance + gain * percent / 100;
                    at += (distance + next) / 2;
                    distance = next;
                    let units = (at + unit * ONE / 2).div_euclid(unit * ONE);
                    positions.push(begin.wrapping_add((units * unit) as i32));
                }
            }
            prop_assert_eq!(found(positions, max(gain, gain, unit)), None);
        }

        /// From rest to a velocity that is more than rounding can explain.
        #[test]
        fn m39_a_velocity_out_of_nothing_is_found_out(
            gain in 1..ONE / 10,
            distance in 5..1_000_000_i32,
        ) {
            let jump = (0..40).map(|_| 0).chain((1..=3).map(|k| k * distance));
            let found = found(jump, max(gain, gain, 1));
            prop_assert!(found.is_some_and(|at| at <= 42), "{:?}", found);
        }
    }

    #[test]
    fn m39_a_steady_ramp_that_is_too_hard_is_found_out_within_16_periods() {
        // Twice and four times 0.1 increments a period in each.
        for (hardness, within) in [(2, 32), (4, 14), (20, 6)] {
            let ramp = (0..100).map(|k: i32| hardness * k * k / 20);
            let rest = std::iter::repeat_n(0, 40);
            let at = found(rest.chain(ramp), max(ONE / 10, ONE / 10, 1));
            let after = at.map(|at| at - 40);
            assert!(after.is_some_and(|k| k <= within), "{hardness}: {after:?}");
        }
    }

    #[test]
    fn m39_60c5h_counts_while_the_speed_grows_and_60c6h_while_it_falls() {
        let ramp = |up: i32, down: i32, sign: i32| {
            let distances = (0..50).map(move |k| k * up);
            let back = (0..)
                .map(move |k| 50 * up - k * down)
                .take_while(|distance| *distance >= 0);
            distances.chain(back).scan(0, move |at, distance| {
                *at += sign * distance;
                Some(*at)
            })
        };
        for sign in [1, -1] {
            let limits = max(10 * ONE, 40 * ONE, 1);
            assert_eq!(found(ramp(10, 40, sign), limits), None);
            assert!(found(ramp(40, 40, sign), limits).is_some());
            let limits = max(40 * ONE, 10 * ONE, 1);
            assert_eq!(found(ramp(40, 10, sign), limits), None);
            assert!(found(ramp(40, 40, sign), limits).is_some());
        }
    }
}

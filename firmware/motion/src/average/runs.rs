//! What a plan has done within the window: one parabola behind the other.

use crate::clock::Ticks;
use crate::divide::{div_rem, fraction};
use crate::exact::{PositionQ96, Q96};
use crate::fixed::Exact;
use crate::iterations::Iterations;
use crate::low;
use crate::plan::phase::Phase;

/// Parabolas that are kept. With those of a plan they are fewer than the polynomials that a call of [`Axis::advance`](crate::Axis::advance) may meet.
pub(super) const RUNS: usize = 24;

/// A parabola of the plan, up to where the next one begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    /// Its first tick. It may lie before tick 0, which wraps.
    pub(super) start: Ticks,
    pub(super) from: Exact,
    /// Half of the acceleration.
    pub(super) half: Q96,
}

impl Run {
    pub(super) const NONE: Self = Self {
        start: 0,
        from: Exact::at_rest(PositionQ96::ZERO),
        half: Q96::ZERO,
    };

    pub(super) fn at(&self, t: Ticks) -> Exact {
        Phase::parabola(self.start, self.from, self.half).at(t)
    }

    /// From where it begins to a later tick, in ticks. A run that ends is no longer than a window and a motion before it, which 32 bits hold.
    fn length(&self, end: Ticks) -> u32 {
        u32::try_from(end.wrapping_sub(self.start)).unwrap_or(u32::MAX)
    }

    /// How far its mean over its first ticks lies from where it begins.
    fn mean(&self, length: u32) -> PositionQ96 {
        // ½·v·n + ⅓·h·n²
        let curved = self.half.gain(length).distance(length).part(THIRD);
        self.from.velocity.distance(length).halved() + curved
    }
}

/// 2⁶⁴ / 3
pub(super) const THIRD: u64 = u64::MAX / 3;

/// The runs of a plan, the oldest first. There is always one.
#[derive(Debug, Clone)]
pub(super) struct Runs {
    /// The place of the oldest one, and how many there are.
    first: usize,
    count: usize,
    /// A ring.
    runs: [Run; RUNS],
}

impl Runs {
    pub(super) const fn new() -> Self {
        Self {
            first: 0,
            count: 1,
            runs: [Run::NONE; RUNS],
        }
    }

    /// Begins anew with one run.
    pub(super) fn begin(&mut self, run: Run) {
        self.count = 0;
        self.put(run);
    }

    fn get(&self, number: usize) -> Option<&Run> {
        let place = self.first.wrapping_add(number) % RUNS;
        self.runs.get(place).filter(|_| number < self.count)
    }

    fn get_mut(&mut self, number: usize) -> Option<&mut Run> {
        let place = self.first.wrapping_add(number) % RUNS;
        self.runs.get_mut(place)
    }

    /// The one that was there at tick `t`, and when the next one begins. What is older is forgotten.
    pub(super) fn since(&mut self, t: Ticks) -> (Run, Option<Ticks>) {
        let mut next = self.get(1).map(|run| run.start);
        let mut iterations = Iterations::at_most(low::word(RUNS));
        while next.is_some_and(|next| t.wrapping_sub(next).cast_signed() >= 0) {
            iterations.count();
            self.first = self.first.wrapping_add(1) % RUNS;
            self.count -= 1;
            next = self.get(1).map(|run| run.start);
        }
        (self.get(0).copied().unwrap_or(Run::NONE), next)
    }

    /// The one that the plan is on.
    pub(super) fn last(&self) -> Run {
        let last = self.get(self.count.wrapping_sub(1));
        last.copied().unwrap_or(Run::NONE)
    }

    /// The plan goes on with another one, unless it is the same parabola.
    pub(super) fn add(&mut self, run: Run) {
        let last = self.last();
        if last.start == run.start {
            self.count -= 1;
        } else if last.half == run.half && last.at(run.start) == run.from {
            return;
        } else if self.count >= RUNS {
            self.join();
        }
        self.put(run);
    }

    fn put(&mut self, run: Run) {
        let number = self.count;
        self.count += 1;
        if let Some(place) = self.get_mut(number) {
            *place = run;
        }
    }

    /// Makes one of the two runs that are the shortest together. The first one has begun to leave the window, and the last one has not ended.
    #[cold]
    fn join(&mut self) {
        let mut shortest = u32::MAX;
        let mut place = 1;
        for number in 1..RUNS - 2 {
            if let (Some(first), Some(third)) = (self.get(number), self.get(number + 2))
                && first.length(third.start) < shortest
            {
                shortest = first.length(third.start);
                place = number;
            }
        }
        if let (Some(first), Some(second), Some(third)) =
            (self.get(place), self.get(place + 1), self.get(place + 2))
        {
            let mut run = joined(first, second, third);
            for number in place..RUNS - 1 {
                let next = self.get(number + 2).copied();
                if let Some(place) = self.get_mut(number) {
                    *place = run;
                }
                run = next.unwrap_or(Run::NONE);
            }
            self.count -= 1;
        }
    }
}

/// One parabola in place of two, up to where the third begins. It has the ends and the mean of the two, so that nothing is lost of the mean over a
/// window when they leave it.
fn joined(first: &Run, second: &Run, third: &Run) -> Run {
    let length = first.length(third.start).max(1);
    let (one, two) = (first.length(second.start), second.length(third.start));
    let away = |run: &Run| run.from.position - first.from.position;
    let share = |part: u32| u64::try_from(fraction(part.into(), length)).unwrap_or(u64::MAX);
    let mean = first.mean(one).part(share(one));
    let mean = mean + (second.mean(two) + away(second)).part(share(two));
    // x = v·n + h·n² with x(n) = distance and ½·v·n + ⅓·h·n² = mean.
    let distance = away(third);
    let bent = distance - mean - mean;
    let curved = bent + bent + bent;
    let (inverse, _) = div_rem(u64::MAX, length);
    Run {
        from: Exact {
            velocity: (distance - curved).per_tick(inverse),
            ..first.from
        },
        half: curved.per_tick(inverse).part(inverse),
        ..*first
    }
}

#[cfg(test)]
mod tests {
    use super::{RUNS, Run, Runs};
    use crate::clock::Ticks;
    use crate::exact::{PositionQ96, Q96};
    use crate::fixed::Exact;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    fn steps(position: PositionQ96) -> f64 {
        position.bits() as f64 / 2f64.powi(96)
    }

    /// The mean of runs that follow each other, up to a tick, in steps.
    fn mean(runs: &[Run], end: Ticks) -> f64 {
        let ends = runs.iter().skip(1).map(|run| run.start).chain([end]);
        let area = runs.iter().zip(ends).map(|(run, end)| {
            let length = (end - run.start) as f64;
            let middle = steps(run.at(run.start).position + run.at(end).position) / 2.0;
            length * (middle - run.half.bits() as f64 / 2f64.powi(96) * length * length / 6.0)
        });
        area.sum::<f64>() / (end - runs[0].start) as f64
    }

    proptest! {
        /// However many there are: the plan ends where it does, and its mean over all of them is what it was.
        #[test]
        fn runs_that_are_joined_keep_their_ends_and_their_mean(
            pieces in prop::collection::vec((1u32..200_000, -1i128 << 56..1 << 56), 30..200),
        ) {
            let mut run = Run { start: 1000, from: Exact::at_rest(PositionQ96::ZERO), half: Q96::from_bits(1 << 50) };
            let mut runs = Runs::new();
            runs.begin(run);
            let mut all = vec![run];
            for (length, half) in pieces {
                let start = run.start + Ticks::from(length);
                run = Run { start, from: run.at(start), half: Q96::from_bits(half) };
                runs.add(run);
                all.push(run);
            }
            let known: Vec<_> = (0..RUNS).filter_map(|number| runs.get(number).copied()).collect();
            prop_assert_eq!(known.len(), RUNS);
            prop_assert_eq!(known.last().unwrap().from, run.from);
            for pair in known.windows(2) {
                let off = steps(pair[0].at(pair[1].start).position - pair[1].from.position);
                prop_assert!(off.abs() < 1e-9, "{off} steps");
            }
            let off = mean(&known, run.start) - mean(&all, run.start);
            prop_assert!(off.abs() < 1e-6, "{off} steps");
        }
    }
}

//! The moving average of a plan: ramps of limited jerk, whatever the plan does.
//!
//! A plan of linear ramps, cheap to make and to change, runs ahead; the axis is where the mean of its positions over a *window* of time is.
//! Where the plan changes its acceleration at once, the mean does so evenly over the window: at a jerk of (a + d) / window at most, whichever ramp
//! follows which. Velocity and acceleration are means too, so no limit of the plan is exceeded, nor is the span of its positions. The price is
//! time: the mean comes to rest one window behind the plan.
//!
//! The plan is one parabola behind the other, and so the mean is one cubic behind the other: another one begins where the plan comes to a corner, and a
//! window later, where the corner leaves the window. Its velocity is the distance of the plan over the window, its acceleration the change of the
//! plan's velocity, its jerk that of its acceleration, each by the length of the window. Nothing is worked out in between.
//!
//! Where the plan has kept its velocity all over the window, the mean is that line, half a window late, exactly; and where the plan has
//! stood, it is where the plan is. What was before a window begins is such a line, too.

mod mean;
mod runs;
mod window;

use crate::clock::Ticks;
use crate::divide::fraction;
use crate::exact::{Q96, Q128};
use crate::fixed::Exact;
use crate::plan::Plan;
use crate::plan::phase::Phase;
use crate::stepper::polynomial::Polynomial;
pub use mean::Mean;
use runs::{Run, Runs, THIRD};
pub(crate) use window::Window;

/// The mean of a plan: its state, and the runs that it is made of.
///
/// The fields lie in memory in this order, as in [`Axis`](crate::Axis): what is large last, so that one instruction reaches each.
#[derive(Debug, Clone)]
#[repr(C)]
pub(crate) struct Average {
    /// Up to here the mean is `phase`.
    until: Ticks,
    /// The tick at which the plan goes on otherwise than its last run.
    corner: Ticks,
    window: Window,
    /// 2⁶⁴⁺ˢ / window, and s: the greatest for which it has 64 bits.
    per_window: u64,
    shift: u32,
    /// The plan stands since its last run began.
    stands: bool,
    /// The mean has not gone on from where it began.
    is_fresh: bool,
    phase: Phase,
    runs: Runs,
}

impl Average {
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub(crate) const fn new() -> Self {
        Self {
            until: 0,
            corner: 0,
            window: Window::SHORTEST,
            per_window: u64::MAX,
            shift: 0,
            stands: false,
            is_fresh: false,
            phase: Phase::NONE,
            runs: Runs::new(),
        }
    }

    /// Where the plan is ahead, if the mean is at `mean` and has kept its velocity for a window.
    pub(crate) fn ahead(window: Window, mean: Exact) -> Exact {
        let distance = mean.velocity.distance(window.ticks());
        Exact {
            position: mean.position + distance.halved(),
            ..mean
        }
    }

    /// Begins with a mean that is at `mean` at tick `at`, where the plan is [ahead](Self::ahead) of it and has kept its velocity for a
    /// window's time.
    pub(crate) fn begin(&mut self, window: Window, at: Ticks, mean: Exact) {
        let ticks = window.ticks();
        self.window = window;
        self.shift = 31_u32.wrapping_sub(ticks.leading_zeros()) & 31;
        let per_window = fraction(1 << self.shift, ticks);
        self.per_window = u64::try_from(per_window).unwrap_or(u64::MAX);
        let distance = mean.velocity.distance(ticks);
        let ahead = Self::ahead(window, mean).position;
        self.runs.begin(Run {
            start: at.wrapping_sub(ticks.into()),
            from: Exact {
                position: ahead - distance,
                ..mean
            },
            half: Q96::ZERO,
        });
        self.phase = Phase::parabola(at, mean, Q96::ZERO);
        self.is_fresh = true;
        self.rejoin(at);
    }

    /// The exact state in which the mean began, as long as it has not advanced: until then its window may be replaced.
    pub(crate) fn fresh(&self) -> Option<Exact> {
        self.is_fresh.then(|| self.exact_at(self.until))
    }

    /// The plan has been changed, to begin at tick `at`, where the mean is.
    pub(crate) const fn rejoin(&mut self, at: Ticks) {
        self.corner = at;
        self.until = at;
        self.stands = false;
    }

    /// Over how much time the mean is taken.
    pub(crate) const fn window(&self) -> Window {
        self.window
    }

    /// Up to which tick the mean is known.
    #[cfg(test)]
    pub(crate) const fn until(&self) -> Ticks {
        self.until
    }

    /// Whether the plan has stood all over the window at tick `t`, so that the mean stands where the plan does.
    pub(crate) fn is_over(&self, t: Ticks) -> bool {
        let since = t.wrapping_sub(self.runs.last().start);
        self.stands && since >= self.window.ticks().into()
    }

    /// The mean from tick `t` on, which is not before its present curve, up to the next corner.
    pub(crate) fn polynomial_at(&mut self, plan: &Plan, t: Ticks) -> Polynomial {
        if self.until <= t {
            self.is_fresh = false;
            if self.corner <= t {
                self.look(plan, t);
            }
            self.turn(t);
        }
        self.phase.polynomial(t, self.until)
    }

    /// The curve of the mean.
    pub(crate) const fn phase(&self) -> Phase {
        self.phase
    }

    /// The mean at tick `t`, from where its curve begins up to `until`.
    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        self.phase.at(t)
    }

    /// The plan is at a corner.
    fn look(&mut self, plan: &Plan, at: Ticks) {
        let phase = plan.phase_at(at);
        self.stands = phase.is_none();
        self.corner = plan.next_corner(at).unwrap_or(Ticks::MAX);
        let (from, half) = match phase {
            Some(phase) => (phase.at(at), phase.half_acceleration()),
            None => (plan.exact_at(at), Q96::ZERO),
        };
        let start = at;
        self.runs.add(Run { start, from, half });
    }

    /// Goes on with the curve that begins at tick `at`.
    fn turn(&mut self, at: Ticks) {
        let mean = self.exact_at(at);
        let ticks = self.window.ticks();
        let begin = at.wrapping_sub(ticks.into());
        let (oldest, next) = self.runs.since(begin);
        let newest = self.runs.last();
        let new = newest.at(at);
        let leaves = next.map_or(Ticks::MAX, |next| next.wrapping_add(ticks.into()));
        self.until = self.corner.min(leaves);
        if next.is_none() && newest.half.is_zero() {
            let late = new.velocity.distance(ticks).halved();
            let line = Exact {
                position: new.position - late,
                ..new
            };
            self.phase = Phase::parabola(at, line, Q96::ZERO);
            return;
        }
        let old = oldest.at(begin);
        // By the length of the window.
        let (per_window, shift) = (self.per_window, self.shift);
        let velocity = (new.position - old.position).per_tick(per_window) >> shift;
        let acceleration = (new.velocity - old.velocity).part(per_window) >> shift;
        let half_jerk = Q128::from(newest.half - oldest.half).part(per_window) >> shift;
        self.phase = Phase::cubic(
            (at, at),
            mean.position,
            velocity,
            (acceleration >> 1, half_jerk.part(THIRD)),
        );
    }
}

#[cfg(test)]
mod tests;

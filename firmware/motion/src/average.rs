//! The moving average of a plan: ramps of limited jerk, whatever the plan does.
//!
//! A plan of linear ramps, cheap to make and to change, runs ahead; the axis is where the mean of its positions over a *window* of time is.
//! Where the plan changes its acceleration at once, the mean does so evenly over the window: at a jerk of (a + d) / window at most, whichever ramp
//! follows which. Velocity and acceleration are means too, so no limit of the plan is exceeded, nor is the span of its positions. The price is
//! time: the mean comes to rest one window behind the plan.
//!
//! The plan is looked at on a grid. Between two samples its position counts as a straight line, so that the mean is a parabola
//! from one point of the grid to the next, and both position and velocity join. A sample added and one taken away make the next
//! one. Everything that is carried on is an integer, so that the mean of a plan at rest is exactly where the plan is.
//!
//! Where the plan has kept its velocity all over the window, the mean is that line, half a window late; it is followed as it is, until the plan
//! comes to a corner. What was before a window begins is such a line, too, and takes no memory.

mod mean;
mod window;

use crate::clock::Ticks;
use crate::divide::div_rem;
use crate::exact::{PositionQ96, Q96, product};
use crate::fixed::{Exact, Position, State, Velocity};
use crate::low;
use crate::plan::Plan;
use crate::plan::phase::Phase;
use crate::stepper::polynomial::Polynomial;
pub use mean::Mean;
use window::SAMPLES;
pub(crate) use window::Window;

/// The greatest factor of [`part`] and [`rate`].
const MOST: u64 = u64::MAX >> 1;

/// Half of what a sample can tell.
const HALF_OF_SAMPLE: PositionQ96 = PositionQ96::from_bits(1 << 63);

/// The most samples taken of a parabola before the plan is evaluated again.
const MOST_SAMPLED: u32 = 1 << 16;

/// The mean of a plan: its state, and the samples that it is made of.
///
/// The fields lie in memory in this order, as in [`Axis`](crate::Axis): what is large last, so that one instruction reaches each.
#[derive(Debug, Clone)]
#[repr(C)]
pub(crate) struct Average {
    window: Window,
    /// ⌊2⁶³ / window⌋, ⌊2⁶³ / grid⌋ and ⌊2⁶³ / count⌋.
    per_window: u64,
    per_grid: u64,
    per_count: u64,
    /// The index of the oldest sample in the ring.
    place: u32,
    /// Samples from before the ring's first one, at a constant velocity: how many of them are still in the window, the next one, and the
    /// distance from one to the next.
    before: u32,
    old: i64,
    stride: i64,
    /// From the oldest sample to the newest, Q32 steps.
    window_distance: i64,
    /// The remainder of the mean's position, in units of 2⁻³² steps / (2·count).
    left: i32,
    /// The last sample of the plan, and how the next ones follow.
    sampler: Sampler,
    /// For how many intervals of the grid the plan has kept `line_velocity`, or stood, when the sampler's parabola ends.
    straight: u32,
    line_velocity: Q96,
    stands: bool,
    /// The state `to` of the mean at tick `until`, up to which the plan has been sampled, and by how much position and velocity have
    /// changed since the sample before.
    until: Ticks,
    to: State,
    /// How long ago the sample before was: an interval of the grid, or nothing where the mean begins.
    since: u32,
    distance: i64,
    gain: i64,
    /// Set while the mean is the plan's own straight line, half a window late: when that begins, and where.
    line: Option<(Ticks, Exact)>,
    /// The state of the mean at its beginning; `None` once it has advanced.
    fresh: Option<Exact>,
    /// Positions of the plan, Q32 steps, round and round; the oldest is at `place`.
    ring: [i64; SAMPLES],
}

/// Samples of a plan at the points of the grid, by forward differences, as long as it is one parabola.
#[derive(Debug, Clone)]
struct Sampler {
    /// Samples that are left.
    left: u32,
    /// The position, with [`HALF_OF_SAMPLE`] added to round it.
    position: PositionQ96,
    /// What the position grows by in the next interval, and what that grows by.
    distance: PositionQ96,
    growth: PositionQ96,
}

impl Sampler {
    /// Nothing is known of the plan.
    const NONE: Self = Self {
        left: 0,
        position: PositionQ96::ZERO,
        distance: PositionQ96::ZERO,
        growth: PositionQ96::ZERO,
    };

    /// The sample: Q32 steps, to the nearest.
    #[inline]
    const fn sample(&self) -> i64 {
        self.position.floor()
    }
}

impl Average {
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub(crate) const fn new() -> Self {
        Self {
            window: Window { count: 1, grid: 1 },
            per_window: MOST,
            per_grid: MOST,
            per_count: MOST,
            ring: [0; SAMPLES],
            place: 0,
            before: 0,
            old: 0,
            stride: 0,
            window_distance: 0,
            left: 0,
            sampler: Sampler::NONE,
            straight: 0,
            line_velocity: Q96::ZERO,
            stands: false,
            until: 0,
            to: State {
                position: Position::from_bits(0),
                velocity: Velocity::ZERO,
            },
            since: 0,
            distance: 0,
            gain: 0,
            line: None,
            fresh: None,
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
        let per = |number: u64, divisor: u32| div_rem(number, divisor).0;
        self.window = window;
        self.per_window = per(MOST, window.ticks());
        self.per_grid = per(MOST, window.grid);
        self.per_count = per(MOST, window.count.into());
        self.anchor(at, Self::ahead(window, mean));
        self.fresh = Some(mean);
    }

    /// The exact state in which the mean began, as long as it has not advanced: until then its window may be replaced.
    pub(crate) const fn fresh(&self) -> Option<Exact> {
        self.fresh
    }

    /// Begins again with the present window, where the plan is at `state` and has kept its velocity for a window.
    fn anchor(&mut self, at: Ticks, state: Exact) {
        let count = i64::from(self.window.count);
        let newest = sample(state.position);
        self.stride = sample(state.velocity.distance(self.window.grid));
        self.window_distance = self.stride.wrapping_mul(count);
        self.before = self.window.count.into();
        self.old = newest
            .wrapping_sub(self.window_distance)
            .wrapping_add(self.stride);
        self.place = 0;
        // The mean is half a window behind.
        let mean = newest.wrapping_sub(self.window_distance >> 1);
        self.left = low::i32(count.wrapping_mul(self.window_distance & 1)).wrapping_neg();
        self.sampler = Sampler::NONE;
        self.straight = self.window.count.into();
        self.line_velocity = state.velocity;
        self.stands = false;
        self.until = at;
        self.to.position = Position::from_bits(mean);
        self.to.velocity = Velocity::from_bits(rate(self.window_distance, self.per_window));
        (self.since, self.distance, self.gain) = (0, 0, 0);
        self.line = None;
    }

    /// The plan's own line has been followed up to tick `at`. A corner lies up to a tick before, so the velocity may not be the plan's.
    fn anchor_to(&mut self, plan: &Plan, at: Ticks) {
        let state = Exact {
            velocity: self.line_velocity,
            ..plan.exact_at(at)
        };
        self.anchor(at, state);
    }

    /// The plan has been changed, to begin at [`Average::junction`].
    pub(crate) fn rejoin(&mut self, plan: &mut Plan) {
        self.straight = self.straight();
        self.sampler = Sampler::NONE;
        self.stands = false;
        if self.line.is_some() {
            plan.enter(plan.start());
            self.anchor_to(plan, plan.start());
        }
    }

    /// The first tick at which the plan may still change, if the mean is at `horizon`: up to there it has been sampled.
    pub(crate) const fn junction(&self, horizon: Ticks) -> Ticks {
        if self.line.is_some() {
            horizon
        } else {
            self.until
        }
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

    /// Whether the plan has stood all over the window, so that the mean stands where the plan does.
    pub(crate) fn is_over(&self) -> bool {
        self.stands && self.is_straight()
    }

    /// For how many intervals of the grid the plan has kept its velocity.
    const fn straight(&self) -> u32 {
        self.straight.saturating_sub(self.sampler.left)
    }

    /// Whether it has kept it for the whole window.
    fn is_straight(&self) -> bool {
        self.straight() >= self.window.count.into()
    }

    /// The mean from tick `t` on, which is not before its present curve: a parabola up to the next sample, or a line for as long as the
    /// plan's is one.
    pub(crate) fn polynomial_at(&mut self, plan: &Plan, t: Ticks) -> Polynomial {
        if self.until <= t {
            self.fresh = None;
            if self.sampler.left == 0 {
                self.look_on(plan);
            } else {
                self.step();
            }
        }
        let (start, mut polynomial) = self.polynomial();
        if t > start {
            let there = self.exact_at(t);
            (polynomial.position, polynomial.velocity) = (there.position, there.velocity);
        }
        polynomial
    }

    /// The curve of the mean, and when it begins.
    #[inline]
    fn polynomial(&self) -> (Ticks, Polynomial) {
        if let Some((start, line)) = self.line {
            return (start, Polynomial::line(self.until, line));
        }
        let velocity = self.to.velocity.bits().wrapping_sub(self.gain);
        let from = State {
            position: Position::from_bits(self.to.position.bits().wrapping_sub(self.distance)),
            velocity: Velocity::from_bits(velocity),
        };
        // What it gains in an interval, Q56, over twice its ticks: 2³⁹ · gain / grid.
        let gain = i128::from(self.gain) << 8;
        let (high, low) = ((self.per_grid >> 32) as u32, low::u32(self.per_grid));
        let half = product(gain, high) + (product(gain, low) >> 32);
        let polynomial = Polynomial {
            half: Q96::from_bits(half),
            ..Polynomial::line(self.until, from.into())
        };
        (self.until.saturating_sub(self.since.into()), polynomial)
    }

    /// The same as a phase of a plan.
    pub(crate) fn phase(&self) -> Phase {
        let (start, polynomial) = self.polynomial();
        Phase::parabola(start, polynomial.exact(), polynomial.half)
    }

    /// The mean at tick `t`, from where its curve begins up to `until`.
    pub(crate) fn exact_at(&self, t: Ticks) -> Exact {
        if t < self.until || self.line.is_some() {
            self.phase().at(t.min(self.until))
        } else {
            self.to.into()
        }
    }

    /// Advances to the next sample of the same parabola.
    #[inline]
    fn step(&mut self) {
        let sampler = &mut self.sampler;
        sampler.left -= 1;
        sampler.position = sampler.position + sampler.distance;
        sampler.distance = sampler.distance + sampler.growth;
        self.take();
    }

    /// Advances by a sample beyond `until`.
    #[inline(never)]
    fn look_on(&mut self, plan: &Plan) {
        let at = self.until;
        if self.line.is_some() {
            self.anchor_to(plan, at);
        }
        if self.is_straight() && self.follow(plan, at) {
            return;
        }
        self.look(plan, at);
        self.take();
        self.since = self.window.grid;
        if self.is_over() {
            // It is there, but for the remainder.
            self.to.position = Position::from_bits(self.sampler.sample());
            self.left = 0;
        }
    }

    /// The plan has kept its velocity all over the window: its own line is followed if it goes on for longer than one interval.
    #[inline(never)]
    fn follow(&mut self, plan: &Plan, at: Ticks) -> bool {
        let Some(line) = plan.phase_at(at) else {
            return false;
        };
        let from = line.at(at);
        let corner = plan.next_corner(at).unwrap_or(Ticks::MAX);
        let is_long = corner.saturating_sub(at) > self.window.grid.into();
        if !is_long || !line.is_line() || from.velocity != self.line_velocity {
            return false;
        }
        let late = self.line_velocity.distance(self.window.ticks()).halved();
        self.straight = self.straight();
        self.sampler = Sampler::NONE;
        self.until = corner;
        let line = Exact {
            position: from.position - late,
            ..from
        };
        self.line = Some((at, line));
        true
    }

    /// Takes the sampler's present sample into the mean.
    #[inline(never)]
    fn take(&mut self) {
        let newest = self.sampler.sample();
        let mut oldest = newest;
        if let Some(place) = self.ring.get_mut(self.place as usize % SAMPLES) {
            oldest = core::mem::replace(place, newest);
        }
        self.place += 1;
        if self.place >= self.window.count.into() {
            self.place = 0;
        }
        if self.before > 0 {
            self.before -= 1;
            oldest = self.old;
            self.old = oldest.wrapping_add(self.stride);
        }

        let window_distance = newest.wrapping_sub(oldest);
        // The sum of the samples grows by half of what the distance over the window was and half of what it is.
        let sum = self.window_distance.wrapping_add(window_distance);
        let sum = sum.wrapping_add(self.left.into());
        let distance = part(sum, self.per_count);
        let shared = low::u32(distance.cast_unsigned()).wrapping_mul(self.window.count.into()) << 1;
        // Next to nothing, so that 32 bits hold it.
        self.left = low::u32(sum.cast_unsigned())
            .wrapping_sub(shared)
            .cast_signed();
        self.window_distance = window_distance;
        self.distance = distance;
        let position = self.to.position.bits().wrapping_add(distance);
        let velocity = rate(window_distance, self.per_window);
        self.gain = velocity.wrapping_sub(self.to.velocity.bits());
        self.to.position = Position::from_bits(position);
        self.to.velocity = Velocity::from_bits(velocity);
        self.until = self.until.saturating_add(self.window.grid.into());
    }

    /// Samples the plan one interval after tick `at`: whether it has kept its velocity since, and how many samples its parabola has.
    fn look(&mut self, plan: &Plan, at: Ticks) {
        let straight = self.straight();
        let next = at.saturating_add(self.window.grid.into());
        // Evaluated once for all uses below.
        let phase = plan.phase_at(next);
        let ahead = match &phase {
            Some(phase) => phase.at(next),
            None => plan.exact_at(next),
        };
        let end = plan.end().unwrap_or(Ticks::MAX);
        let rest = plan.exact_at(end).position;
        // An end that is rounded up may be a tick behind the sample that is at the target already.
        let stands = end <= next
            || end - next < self.window.grid.into() && sample(ahead.position) == sample(rest);
        let (keeps, line_velocity, half) = if stands {
            (self.stands || end <= at, Q96::ZERO, Q96::ZERO)
        } else {
            let half = phase.as_ref().map_or(Q96::ZERO, Phase::half_acceleration);
            let is_one = phase.as_ref().is_some_and(|phase| phase.start() <= at);
            let keeps = is_one && half.is_zero() && ahead.velocity == self.line_velocity;
            (keeps, ahead.velocity, half)
        };
        self.straight = if keeps { straight.saturating_add(1) } else { 0 };
        self.stands = stands;
        self.line_velocity = line_velocity;
        let grid = self.window.grid;
        let gain = half.gain(grid);
        let growth = gain.distance(grid);
        let growth = growth + growth;
        let corner = if stands {
            Ticks::MAX
        } else {
            plan.next_corner(next).unwrap_or(Ticks::MAX)
        };
        let before = corner.saturating_sub(next).saturating_sub(1);
        let (intervals, _) = div_rem(before, grid);
        let mut left = low::u32(intervals.min(MOST_SAMPLED.into()));
        if growth.is_zero() {
            // The sampler stops where the plan will have kept its velocity for the whole window: from there its line is followed.
            let count = u32::from(self.window.count) - 1;
            left = left.min(count.saturating_sub(self.straight));
            self.straight = self.straight.saturating_add(left);
        }
        let position = if stands { rest } else { ahead.position };
        self.sampler = Sampler {
            left,
            position: position + HALF_OF_SAMPLE,
            distance: (line_velocity + gain).distance(grid),
            growth,
        };
    }
}

/// A position, Q32 steps, to the nearest.
const fn sample(position: PositionQ96) -> i64 {
    Position::nearest(position).bits()
}

/// value · factor / 2⁶⁴, less 5 at most, for a factor below 2⁶³.
#[inline]
fn part(value: i64, factor: u64) -> i64 {
    let (above, below) = ((value >> 32) as i32, low::u32(value.cast_unsigned()));
    let (high, low) = ((factor >> 32) as i32, low::u32(factor));
    let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
    // Half of the products in the middle: so they have a sign of their own.
    let middle =
        product(above, (low >> 1).cast_signed()) + product((below >> 1).cast_signed(), high);
    product(above, high) + (middle >> 31)
}

/// ⌊value · factor / 2³⁹⌋, as far as 57 bits hold it, for a factor below 2⁶³.
#[inline]
fn rate(value: i64, factor: u64) -> i64 {
    let (above, below) = ((value >> 32) as i32, low::u32(value.cast_unsigned()));
    let (high, low) = ((factor >> 32) as u32, low::u32(factor));
    let product = |a: u32, b: u32| u64::from(a) * u64::from(b);
    let lowest = product(below, low) >> 32;
    let middle = (product(below, high) + lowest).cast_signed();
    let crossed = i64::from(above) * i64::from(low);
    let highest = i64::from(above.wrapping_mul(high.cast_signed())) << 32;
    highest.wrapping_add(crossed).wrapping_add(middle) >> 7
}

#[cfg(test)]
mod tests;

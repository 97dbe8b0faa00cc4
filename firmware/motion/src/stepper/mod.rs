//! The stepper: from polynomials of a trajectory to pulses.
//!
//! Every motion, a ramp, a mean or a path, comes as polynomials of degree 3 at most; the stepper alone makes records of these. It advances
//! along its polynomial by *chords* of some ticks each, in integers and without rounding, counts the steps in a chord, and finds the ticks
//! of its first and its last pulse. Between these the pulses are evenly spaced.
//!
//! At a high pulse rate a pulse's tick is found from the velocity there, by one division of 32 bits, and a chord goes on with the period
//! of the one before. At a low rate the position counts as a straight line over the chord, which is short enough for that to be right
//! within a quarter of a step. Where a tick covers less than 2⁻³² steps, a pulse's tick is found from all bits of the position.

pub(crate) mod polynomial;
mod train;

use crate::clock::Ticks;
use crate::divide::div_rem;
use crate::exact::Q96;
use crate::fixed::{Exact, State, Velocity};
use crate::low;
use crate::record::{Direction, DriverTiming, Record};
use polynomial::Polynomial;
use train::{CROWDED, MAX_IN_CHORD, Pulses, Train};

/// Chords per time slice at most, however hard the acceleration: it bounds the work of a control tick.
pub(crate) const CHORDS_PER_SLICE: u32 = 32;

/// Pulses of a chord at most: in three runs they are off by an eighth of that in ticks.
const MAX_PULSES: u32 = 8 * CROWDED;

/// The pulse rate counts as high where so many periods or more are in the longest chord: within one the velocity counts as constant.
const PERIODS_PER_CHORD: u32 = 16;

/// From this velocity on, Q32 steps per tick, the ticks of a part of a period are a division by 32 bits, to within a tick.
const FAST: u32 = 1 << 17;

/// Advances along a polynomial, and makes records of it.
#[derive(Debug, Clone)]
pub(crate) struct Stepper {
    /// Up to here the motion has become records, but for one open period.
    horizon: Ticks,
    /// The motion from there on.
    polynomial: Polynomial,
    /// The longest chord of the polynomial, in ticks.
    reach: u32,
    /// From this velocity on the pulse rate counts as high, Q32 steps per tick.
    fast: u32,
    /// Whether the velocity of the polynomial is constant: then `max_chord`, `beyond` and `spare` are computed once.
    is_line: bool,
    /// The longest chord at the present velocity, in ticks.
    max_chord: u32,
    /// How far a chord should lead beyond the tick that is wanted.
    beyond: u32,
    /// By how much a chord may be longer than `max_chord` for that.
    spare: u32,
    /// The longest chord of all, in ticks.
    longest: u32,
    /// The velocity up to which a chord may be so long, Q32 steps per tick.
    longest_up_to: u32,
    /// The longest chord of a polynomial is no shorter than this, however curved it is.
    least: u32,
    train: Train,
}

impl Stepper {
    /// A stepper that stands at `steps` at tick `now`. `time_slice` is brought into a range that `timing` allows.
    pub(crate) fn new(timing: DriverTiming, time_slice: u32, steps: i32, now: Ticks) -> Self {
        let train = Train::new(timing, time_slice, steps, now);
        let time_slice = train.time_slice;
        // With the open period in front of it, it is one run.
        let longest = time_slice.min(train.shortest.saturating_mul(MAX_IN_CHORD));
        Self {
            horizon: now,
            polynomial: Polynomial::NONE,
            reach: longest,
            fast: FAST,
            is_line: true,
            max_chord: longest,
            beyond: 0,
            spare: 0,
            longest,
            longest_up_to: (u64::from(MAX_PULSES) << 32)
                .checked_div(longest.into())
                .map_or(u32::MAX, |rate| rate.min(1 << 31) as u32),
            least: longest.min(time_slice / CHORDS_PER_SLICE),
            train,
        }
    }

    /// Starts anew at `steps` and `now`: what was open or not committed is dropped.
    pub(crate) fn reset(&mut self, steps: i32, now: Ticks) {
        self.horizon = now;
        self.leave();
        self.train.reset(steps, now);
    }

    /// The commit horizon: up to here the motion has become records, but for one open period.
    #[inline]
    pub(crate) const fn horizon(&self) -> Ticks {
        self.horizon
    }

    /// The length of a time slice in ticks. No record is longer, but for a run that begins with the last pulse before its chord.
    #[inline]
    pub(crate) const fn time_slice(&self) -> u32 {
        self.train.time_slice
    }

    /// The longest chord, in ticks.
    pub(crate) const fn longest(&self) -> u32 {
        self.longest
    }

    /// The shortest period between two pulses, in ticks.
    pub(crate) const fn shortest_period(&self) -> u32 {
        self.train.shortest
    }

    /// The tick up to which there are records, and the steps up to there, modulo 2³².
    #[inline]
    pub(crate) const fn made(&self) -> (Ticks, i32) {
        (self.train.recorded, self.train.recorded_steps())
    }

    /// The records to commit.
    #[inline]
    pub(crate) fn waiting(&self) -> &[Record] {
        self.train.waiting()
    }

    /// All of them have been committed.
    #[inline]
    pub(crate) const fn take_all(&mut self) {
        self.train.take_all();
    }

    /// Only the first `records` of them have been committed.
    pub(crate) fn drop_committed(&mut self, records: usize) {
        self.train.drop_committed(records);
    }

    /// Whether a record was lost since this was asked last: there is room for all that a chord can make.
    #[inline]
    pub(crate) const fn take_overrun(&mut self) -> bool {
        self.train.take_overrun()
    }

    /// Steps due when the axis is there, with their sign.
    pub(crate) const fn due(&self, at: Exact) -> i32 {
        // Positions wrap at 2³² steps, and so does the difference.
        low::i32(at.floor().whole_steps()).wrapping_sub(self.train.steps)
    }

    /// Whether all that was made has been committed, and nothing is open at the horizon.
    pub(crate) fn is_closed(&self) -> bool {
        self.train.waiting().is_empty() && self.train.is_closed(self.horizon)
    }

    /// Closes the open period at the horizon, or as soon after it as the driver allows. The axis stands.
    pub(crate) fn close(&mut self) {
        self.train.close(self.horizon);
        self.horizon = self.horizon.max(self.train.recorded);
    }

    /// Whether the polynomial goes on from the horizon.
    #[inline]
    pub(crate) const fn is_on_polynomial(&self) -> bool {
        self.polynomial.end > self.horizon
    }

    /// Nothing is known any more of how the motion goes on.
    pub(crate) const fn leave(&mut self) {
        self.polynomial.end = 0;
    }

    /// The polynomial on which the motion goes on from the horizon.
    pub(crate) fn enter(&mut self, polynomial: Polynomial) {
        self.polynomial = polynomial;
        self.is_line = polynomial.is_line();
        if self.is_line {
            (self.reach, self.fast) = (self.longest, FAST);
            self.look_ahead(speed(&polynomial));
            return;
        }
        let chord = polynomial.longest_chord(self.horizon);
        self.reach = u32::try_from(chord).map_or(self.longest, |chord| chord.min(self.longest));
        self.reach = self.reach.max(self.least);
        let fast = (u64::from(PERIODS_PER_CHORD) << 32) >> chord.trailing_zeros();
        self.fast = u32::try_from(fast).unwrap_or(u32::MAX).max(FAST);
    }

    /// The state at the horizon.
    #[inline]
    pub(crate) const fn state(&self) -> State {
        State {
            position: self.polynomial.exact().floor(),
            velocity: Velocity::from_bits(low::i64(self.polynomial.velocity.bits() >> 40)),
        }
    }

    /// Makes the records of a chord that leads up to tick `enough`, if one chord can do that; of none where the records lead there already.
    ///
    /// `enough` is near what was committed, so its low 32 bits tell which tick it is.
    pub(crate) fn emit(&mut self, enough: u32) {
        if !self.train.flush(self.horizon, enough) {
            self.next_chord(enough);
            self.train.flush(self.horizon, enough);
        }
    }

    /// Advances by a chord, and makes the records of it.
    #[inline(never)]
    fn next_chord(&mut self, enough: u32) {
        let begin = self.horizon;
        let (from, first_rate) = (self.polynomial.position.floor(), speed(&self.polynomial));
        let length = self.length(enough, first_rate);
        self.horizon = begin.wrapping_add(length.into());
        let mut rate = first_rate;
        if self.is_line {
            self.polynomial.advance_line_by(length);
        } else {
            self.polynomial.advance_by(length);
            rate = speed(&self.polynomial);
        }
        if rate < self.fast || rate > self.longest_up_to {
            self.chord(begin, (from, length), None);
            return;
        }
        // −1 if it goes backwards.
        let mask = (self.polynomial.velocity.bits() >> 127) as i64;
        let beyond = self.beyond(self.polynomial.position.floor(), mask);
        let Some(count) = crossed(beyond) else {
            return;
        };
        let last = length.saturating_sub(over(low::u32(beyond.cast_unsigned()), rate));
        let sign = mask as i32 | 1;
        let speeding_up = rate >= first_rate;
        if !self.train.goes_on(begin, (count, last), sign, speeding_up) {
            self.chord(begin, (from, length), Some(first_rate));
        }
    }

    /// From the middle before the last step made to a position, as if it went forward if the mask is −1: Q32 steps.
    #[inline]
    fn beyond(&self, position: i64, mask: i64) -> i64 {
        let made = i64::from(self.train.steps) << 32;
        (position.wrapping_sub(made) ^ mask).wrapping_add(1 << 31)
    }

    /// How long the next chord is, in ticks.
    #[inline]
    fn length(&mut self, enough: u32, rate: u32) -> u32 {
        if !self.is_line {
            self.look_ahead(rate);
        }
        let left = self.polynomial.end - self.horizon;
        if left <= self.max_chord.into() {
            return low::u32(left);
        }
        // Up to there, and beyond. Neither is far from what was committed.
        let wanted = enough.wrapping_sub(low::u32(self.horizon)).cast_signed();
        let wanted = wanted.max(0).cast_unsigned().min(self.max_chord);
        let length = (wanted + self.beyond).min(self.max_chord + self.spare);
        u32::try_from(left).map_or(length, |left| left.min(length))
    }

    /// Computes how long a chord may be at this velocity, and how far it should lead.
    #[inline]
    fn look_ahead(&mut self, rate: u32) {
        self.max_chord = if rate <= self.longest_up_to {
            self.reach
        } else {
            self.shorter(rate)
        };
        // To the pulse behind what is wanted, or so far that silence can be made up to there.
        let period = if rate < FAST { 0 } else { over(u32::MAX, rate) };
        self.beyond = (period + (period >> 4)).max(self.train.behind());
        // In the latter case the next one begins a little early, for which there is an eighth to spare, where pulses are many and the acceleration is
        // not hard.
        let is_gentle = self.max_chord == self.longest && period < self.max_chord >> 1;
        self.spare = if is_gentle {
            period.min(self.max_chord >> 3)
        } else {
            0
        };
    }

    /// The longest chord at a higher velocity: no more than [`MAX_PULSES`] in it.
    #[cold]
    fn shorter(&self, rate: u32) -> u32 {
        let (max, _) = div_rem(u64::from(MAX_PULSES) << 32, rate);
        self.reach.min(low::u32(max)).max(self.least)
    }

    /// Makes the pulses of a chord whatever the one before was: of `length` ticks from `begin` on, from position `from` to where the
    /// polynomial is now. If the velocity at its beginning is given, those at both ends tell the ticks of the first and the last pulse.
    #[inline(never)]
    fn chord(&mut self, begin: Ticks, (from, length): (i64, u32), first_rate: Option<u32>) {
        let to = self.polynomial.position.floor();
        let distance = to.wrapping_sub(from);
        let due = self.due(self.polynomial.exact());
        // The motion knows where it goes. Steps due the other way are rounding at a turning point, unless it stands.
        let direction = match distance {
            0 if due < 0 => Direction::Reverse,
            0.. => Direction::Forward,
            _ => Direction::Reverse,
        };
        let mask = i64::from(direction.sign() >> 1);
        let beyond = self.beyond(to, mask);
        let Some(count) = crossed(beyond) else {
            return;
        };
        // To the first crossing from the beginning, and from the last one to the end.
        // Where another polynomial begins a hair before a crossing that was passed, that is not the next one.
        let to_first = (1_i64 << 32).saturating_sub(self.beyond(from, mask));
        let to_first = to_first.max(0).cast_unsigned();
        let rate = speed(&self.polynomial);
        let (first, back) = if let Some(first_rate) = first_rate {
            (
                over(u32::try_from(to_first).unwrap_or(u32::MAX), first_rate),
                over(low::u32(beyond.cast_unsigned()), rate),
            )
        } else {
            let part = |distance_to: u64| part_of(length, distance_to, distance.unsigned_abs());
            let back = self.since_crossing(count);
            (
                part(to_first),
                back.unwrap_or_else(|| part(u64::from(low::u32(beyond.cast_unsigned())))),
            )
        };
        let last = length.saturating_sub(back);
        let first = if count == 1 { last } else { first.min(last) };
        let pulses = Pulses {
            count,
            first,
            last,
            direction,
            speeding_up: self.is_speeding_up(),
        };
        self.train.run(begin, length, &pulses);
    }

    /// Whether the speed grows where the polynomial has come to.
    fn is_speeding_up(&self) -> bool {
        (self.polynomial.half < Q96::ZERO) == (self.polynomial.velocity < Q96::ZERO)
    }

    /// How many ticks ago the last of the steps due was crossed, where it is so slow that a tick is less than 2⁻³² steps.
    fn since_crossing(&self, count: u32) -> Option<u32> {
        let exact = self.polynomial.exact();
        if count != 1 || exact.velocity.is_zero() || !exact.rounded().velocity.is_below_resolution()
        {
            return None;
        }
        let step = self.train.steps.wrapping_add(self.due(exact));
        u32::try_from(exact.since_middle(step)).ok()
    }
}

/// The speed of a polynomial at its present tick, Q32 steps per tick; `u32::MAX` if it is above every pulse rate.
#[inline]
fn speed(polynomial: &Polynomial) -> u32 {
    let velocity = polynomial.velocity.floor();
    u32::try_from(velocity ^ (velocity >> 63)).unwrap_or(u32::MAX)
}

/// The steps crossed, if any, on the way beyond the middle before the last one.
#[inline]
fn crossed(beyond: i64) -> Option<u32> {
    u32::try_from(beyond >> 32).ok().filter(|count| *count > 0)
}

/// The ticks for a part of a step, Q32, at a velocity, Q32 steps per tick: to the nearest, as many velocities have steps of whole ticks.
#[inline]
fn over(part: u32, rate: u32) -> u32 {
    let part = part.saturating_add(rate >> 1);
    part.checked_div(rate).unwrap_or(0)
}

/// How many of so many ticks a part of a distance takes, to the nearest.
fn part_of(ticks: u32, part: u64, distance: u64) -> u32 {
    let shift = 32_u32.saturating_sub(distance.leading_zeros());
    let (distance, part) = (distance >> shift, part >> shift);
    let part = low::u32(part.min(distance));
    let product = u64::from(part) * u64::from(ticks);
    let (ticks, _) = div_rem(product + (distance >> 1), low::u32(distance));
    low::u32(ticks)
}

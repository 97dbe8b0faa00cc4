//! A phase-locked loop on the sync events of the network: integers, second order.
//!
//! Sync events come with jitter; the loop tells when they should have come. It begins with large gains, so that it is near after a few sync events,
//! and ends with small ones, so that a sync event that is 120 µs early moves the next moment by less than 4 µs. Sync events that are too far
//! off count as sync events, but nothing is measured by them; where too many are, the loop begins anew.
//!
//! The contract:
//! - Moments follow each other by about a period; each is decided on once, as come or as missed.
//! - Missed sync events do not move the moments: the loop goes on as it was.
//! - A period lies within [`SHORTEST`] and [`LONGEST`], whatever comes.

use super::{MicrosQ16, POINT, span};

/// The shortest period, 500 µs.
pub(crate) const SHORTEST: MicrosQ16 = 500 << POINT;
/// The longest period, two seconds.
pub(crate) const LONGEST: MicrosQ16 = 2_000_000 << POINT;

/// What is taken for the period before there is anything to measure by, where nobody has said so: 1 ms.
const USUAL: MicrosQ16 = 1_000 << POINT;

/// Sync events until the loop counts as locked.
const SETTLED: u8 = 32;
/// Missed in a row: there are no sync events any more.
const SILENCE: u8 = 8;
/// The loop begins anew where this many points have come together: two for each rejected or missed sync event, less one for each in time.
const RESTART_SCORE: u8 = 16;
/// A sync event may always be so far off, beside what jitter makes of it: 100 µs.
const SLACK: u64 = 100 << POINT;

/// What a sync event is to the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// It belongs to the next moment, or to a later one: [`Pll::at`].
    InTurn,
    /// It comes twice, or after its moment was decided on.
    OutOfTurn,
}

/// The loop.
#[derive(Debug)]
pub(crate) struct Pll {
    /// The last moment that was decided on.
    at: MicrosQ16,
    /// When the last sync event came.
    last_event: MicrosQ16,
    period: MicrosQ16,
    is_running: bool,
    /// Sync events since it began, as far as it matters.
    good: u8,
    /// Missed in a row.
    silent: u8,
    error_score: u8,
    jitter: MicrosQ16,
    missed: u32,
    rejected: u32,
}

impl Pll {
    pub(crate) const fn new() -> Self {
        Self {
            at: 0,
            last_event: 0,
            period: SHORTEST,
            is_running: false,
            good: 0,
            silent: 0,
            error_score: 0,
            jitter: 0,
            missed: 0,
            rejected: 0,
        }
    }

    /// Takes over the counts of another loop.
    pub(crate) const fn carry_on(&mut self, missed: u32, rejected: u32) {
        self.missed = missed;
        self.rejected = rejected;
    }

    /// The last moment that was decided on.
    pub(crate) const fn at(&self) -> MicrosQ16 {
        self.at
    }

    pub(crate) const fn period(&self) -> MicrosQ16 {
        self.period
    }

    /// There has been a sync event; the moments go on even if there are none any more.
    pub(crate) const fn is_running(&self) -> bool {
        self.is_running
    }

    pub(crate) const fn is_locked(&self) -> bool {
        self.is_running
            && self.good >= SETTLED
            && self.silent < SILENCE
            && self.jitter < self.period / 8
    }

    /// 2050h:1.
    pub(crate) const fn state(&self) -> u8 {
        if !self.is_running || self.silent >= SILENCE {
            0
        } else if self.is_locked() {
            2
        } else {
            1
        }
    }

    pub(crate) const fn jitter(&self) -> MicrosQ16 {
        self.jitter
    }

    pub(crate) const fn missed(&self) -> u32 {
        self.missed
    }

    pub(crate) const fn rejected(&self) -> u32 {
        self.rejected
    }

    /// A sync event came at `stamp`. The period is expected to be one of `expected`, the first of them before there is anything to measure by.
    pub(crate) fn on_sync_event(&mut self, stamp: MicrosQ16, expected: [MicrosQ16; 2]) -> Arrival {
        let before = span(self.last_event, stamp);
        if !self.is_running
            || self.silent >= SILENCE
            || self.error_score >= RESTART_SCORE
            || before < 0
        {
            self.begin(stamp, expected);
            return Arrival::InTurn;
        }
        self.last_event = stamp;
        if self.good == 0 {
            return self.measure(stamp, before.unsigned_abs(), expected);
        }
        let since = span(self.at, stamp);
        let mut due = self.period;
        let mut periods = 1;
        if since.wrapping_sub(due.cast_signed()).unsigned_abs() >= due / 2 {
            periods = self.periods(since);
            if periods == 0 {
                self.reject();
                return Arrival::OutOfTurn;
            }
            self.missed = self.missed.saturating_add(periods.wrapping_sub(1));
            due = due.wrapping_mul(periods.into());
        }
        self.silent = 0;
        let error = since.wrapping_sub(due.cast_signed());
        self.at = self.at.wrapping_add(due);
        let window = self.window();
        self.follow_jitter(error.unsigned_abs());
        if error.unsigned_abs() > window {
            self.reject();
        } else {
            self.correct(error, periods);
        }
        Arrival::InTurn
    }

    /// Whether the next moment may have passed without its sync event: false for certain.
    #[inline]
    pub(crate) const fn may_miss(&self, now: MicrosQ16) -> bool {
        self.is_running && span(self.at.wrapping_add(self.period), now) >= SHORTEST_TIMEOUT
    }

    /// Lets time pass. True if the next moment has passed without its sync event.
    pub(crate) fn count_missed(&mut self, now: MicrosQ16) -> bool {
        if !self.is_running {
            return false;
        }
        let next = self.at.wrapping_add(self.period);
        if span(next, now) < timeout(self.period).cast_signed() {
            return false;
        }
        self.at = next;
        if self.good > 0 {
            self.silent = self.silent.saturating_add(1);
            if self.silent <= SILENCE {
                self.missed = self.missed.saturating_add(1);
                self.error_score = self.error_score.saturating_add(2);
            }
        }
        true
    }

    fn begin(&mut self, stamp: MicrosQ16, [expected, _]: [MicrosQ16; 2]) {
        let expected = if expected == 0 { USUAL } else { expected };
        *self = Self {
            at: stamp,
            last_event: stamp,
            period: expected.clamp(SHORTEST, LONGEST),
            is_running: true,
            missed: self.missed,
            rejected: self.rejected,
            ..Self::new()
        };
    }

    /// The second sync event: its distance is the period, or near one that is expected.
    fn measure(&mut self, stamp: MicrosQ16, distance: u64, expected: [MicrosQ16; 2]) -> Arrival {
        if distance < SHORTEST / 2 {
            self.rejected = self.rejected.saturating_add(1);
            return Arrival::OutOfTurn;
        }
        let near = |period: &MicrosQ16| *period > 0 && distance.abs_diff(*period) <= *period / 3;
        self.period = expected
            .into_iter()
            .find(near)
            .unwrap_or(distance)
            .clamp(SHORTEST, LONGEST);
        self.at = stamp;
        self.good = 1;
        Arrival::InTurn
    }

    /// How many periods it has been, to the nearest. In whole microseconds, which the processor divides fast.
    fn periods(&self, since: i64) -> u32 {
        let micros = |time: u64| u32::try_from(time >> POINT).unwrap_or(u32::MAX);
        let since = micros(since.max(0).unsigned_abs());
        let period = micros(self.period);
        since
            .saturating_add(period / 2)
            .checked_div(period)
            .unwrap_or(0)
    }

    /// How far off a sync event may be to be measured by.
    const fn window(&self) -> u64 {
        if self.good < SETTLED {
            return self.period / 2;
        }
        // Jitter is a second at most.
        let likely = self.jitter.wrapping_mul(4).wrapping_add(SLACK);
        let max = self.period / 4;
        if likely < max { likely } else { max }
    }

    fn follow_jitter(&mut self, error: u64) {
        let error = error.min(self.period / 2);
        // Mean of the last sixteen, nearly.
        self.jitter = self
            .jitter
            .wrapping_sub(self.jitter >> 4)
            .wrapping_add(error >> 4);
    }

    fn correct(&mut self, error: i64, periods: u32) {
        // One shift by a number: five by constants would all be made.
        let (shift, more) = match self.good {
            0..=7 => (1, 2),
            8..=15 => (2, 3),
            16..=31 => (3, 4),
            32..=63 => (4, 5),
            _ => (5, 6),
        };
        let shift = error >> shift;
        let gain = shift >> more;
        self.at = self.at.wrapping_add_signed(shift);
        let gain = match periods {
            1 => gain,
            _ => gain.checked_div(periods.into()).unwrap_or(0),
        };
        self.period = self
            .period
            .saturating_add_signed(gain)
            .clamp(SHORTEST, LONGEST);
        self.good = self.good.saturating_add(1);
        self.error_score = self.error_score.saturating_sub(1);
    }

    fn reject(&mut self) {
        self.rejected = self.rejected.saturating_add(1);
        self.error_score = self.error_score.saturating_add(2);
    }
}

/// The shortest time-out of a sync event, a quarter of a millisecond.
const SHORTEST_TIMEOUT: i64 = (SHORTEST / 2).cast_signed();

/// The time-out of a sync event: how long after its moment it counts as missed. Half a period, but of short periods less than a control tick, so that there is time to
/// bridge what is missing.
pub(crate) fn timeout(period: MicrosQ16) -> MicrosQ16 {
    const BRIDGING: MicrosQ16 = 3_500 << POINT;
    const LEAST: MicrosQ16 = 500 << POINT;
    period.saturating_sub(BRIDGING).max(LEAST).min(period / 2)
}

#[cfg(test)]
mod tests;

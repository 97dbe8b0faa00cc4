//! The train of pulses: an account of steps and ticks, and the records that are made of both.
//!
//! A step belongs where the position crosses the middle between two whole steps. Between the first crossing of a chord and its last one pulses are
//! evenly spaced, so that they are two runs of periods, `base + 1` and `base` ticks long, or three. The period behind the last pulse stays
//! open until the next chord tells where it ends. Ticks and pulses therefore add up by construction: nothing is rounded twice.
//!
//! How many steps are due is always the difference between the position and the steps made. A pulse that the driver's timing
//! delays is made later, and never lost.

use super::CHORDS_PER_SLICE;
use crate::clock::Ticks;
use crate::iterations::Iterations;
use crate::low;
use crate::record::{Direction, DriverTiming, Record, SHORTEST_RECORD};

/// Records that one chord can make at most: four of silence in front, one more at a change of direction, three runs, and three if what is open then
/// is made a record with it.
const MAX_RECORDS: usize = 11;

/// The pulses of a run are counted in 16 bits.
const LONGEST_RUN: u32 = u16::MAX as u32;

/// No chord is as long as so many of the shortest periods. With an eighth more, and the open period in front of it, it is a run.
pub(super) const MAX_IN_CHORD: u32 = LONGEST_RUN / 9 * 8 - 2;

/// From so many pulses in a chord on, the open period before it becomes one of the equal periods of the chord.
const MANY: u32 = 8;

/// A microsecond at 168 MHz, in ticks: faster pulses may be off by that, but for an eighth.
pub(super) const CROWDED: u32 = 168;

/// Where a run has fewer pulses than a period has so many ticks, its periods may be all alike: the last pulse is off by less than a 256th of a step.
const ROUGH: u32 = 128;

/// The pulses of a chord: evenly spaced, from the first to the last, in ticks from where it begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pulses {
    pub(super) count: u32,
    pub(super) first: u32,
    pub(super) last: u32,
    pub(super) direction: Direction,
    /// Whether the speed grows: the longer periods come first then, and otherwise last.
    pub(super) speeding_up: bool,
}

/// Makes records, and keeps the account of steps and ticks.
#[derive(Debug, Clone)]
pub(super) struct Train {
    /// Ticks of the step signal being high.
    width: u16,
    /// Records made and not committed.
    count: u8,
    /// There was no room for a record.
    is_overrun: bool,
    /// The shortest period between pulses.
    pub(super) shortest: u32,
    /// The shortest record of one period, in ticks.
    least: u32,
    /// From the beginning of the last pulse to a change of direction.
    hold: u32,
    /// From a change of direction to the next pulse.
    setup: u32,
    pub(super) time_slice: u32,
    /// Steps made, modulo 2³².
    pub(super) steps: i32,
    /// Up to here there are records. What follows is the open period.
    pub(super) recorded: Ticks,
    /// The step of the pulse with which the open period begins, 1 or −1; 0 if it is silent.
    open_step: i32,
    /// The period of the last run; 0 if there is none before the open period.
    period: u32,
    /// The level of the direction signal; `None` until a record has set it.
    direction: Option<Direction>,
    made: [Record; MAX_RECORDS],
}

impl Train {
    /// A train that stands at `steps` at tick `now`. `time_slice` is brought into a range that `timing` allows.
    pub(super) fn new(timing: DriverTiming, time_slice: u32, steps: i32, now: Ticks) -> Self {
        let timing = timing.checked();
        let shortest = timing.shortest_period();
        let least = shortest.max(SHORTEST_RECORD);
        // All of a driver's times have 25 bits.
        let hold = least.max(timing.pulse_high + timing.direction_hold);
        let setup = least.max(timing.direction_setup);
        Self {
            width: low::u16(timing.pulse_high),
            count: 0,
            is_overrun: false,
            shortest,
            least,
            hold,
            setup,
            // No longer than so many runs; long enough that a record of one time slice keeps every time of the driver.
            time_slice: time_slice
                .min(shortest.saturating_mul(CHORDS_PER_SLICE * MAX_IN_CHORD))
                .min(1 << 28)
                .max((hold + setup) * 2),
            steps,
            recorded: now,
            open_step: 0,
            period: 0,
            direction: None,
            made: [Record::NONE; MAX_RECORDS],
        }
    }

    /// Starts anew at `steps` and `now`: what was open or not committed is dropped, and the direction is unknown.
    pub(super) fn reset(&mut self, steps: i32, now: Ticks) {
        self.steps = steps;
        self.recorded = now;
        self.open_step = 0;
        self.period = 0;
        self.direction = None;
        self.count = 0;
    }

    /// Whether nothing is open at tick `now`.
    pub(super) const fn is_closed(&self, now: Ticks) -> bool {
        self.open_step == 0 && self.recorded >= now
    }

    /// The records to commit.
    #[inline]
    pub(super) fn waiting(&self) -> &[Record] {
        self.made.get(..usize::from(self.count)).unwrap_or_default()
    }

    /// All of them have been committed.
    #[inline]
    pub(super) const fn take_all(&mut self) {
        self.count = 0;
    }

    /// Only the first `records` of them have been committed.
    pub(super) fn drop_committed(&mut self, records: usize) {
        let made = self.made;
        let left = made.get(records..).unwrap_or_default();
        // What stays behind them is not looked at.
        for (place, record) in self.made.iter_mut().zip(left) {
            *place = *record;
        }
        self.count = low::u8(low::word(usize::from(self.count).saturating_sub(records)));
    }

    /// Whether there was no room for a record since this was asked last.
    pub(super) const fn take_overrun(&mut self) -> bool {
        core::mem::replace(&mut self.is_overrun, false)
    }

    /// Steps up to the end of the records, modulo 2³²: those made, but for the one in the open period.
    #[inline]
    pub(super) const fn recorded_steps(&self) -> i32 {
        self.steps.wrapping_sub(self.open_step)
    }

    /// Ticks from the end of the records to `now`; negative if they go further. A few time slices at most, either way.
    #[inline]
    pub(super) const fn open_at(&self, now: Ticks) -> i32 {
        low::u32(now)
            .wrapping_sub(low::u32(self.recorded))
            .cast_signed()
    }

    /// How many ticks beyond a tick the chords have to lead, for [`Train::flush`] to bring the records up to that tick.
    #[inline]
    pub(super) const fn behind(&self) -> u32 {
        self.hold + self.least
    }

    /// Makes a record of the open period without waiting for its end, up to just before `now`, if that leads up to `enough`. Whether it did.
    #[inline]
    pub(super) fn flush(&mut self, now: Ticks, enough: u32) -> bool {
        let least = self.least;
        let beyond = low::u32(now).wrapping_sub(enough).cast_signed();
        let is_behind = self.open_at(now) > beyond;
        if !is_behind || beyond < least.cast_signed() {
            return false;
        }
        let open = self.open_at(now).cast_unsigned();
        // What is made is long enough for a change of direction behind it, and what is left is for a record.
        let is_long = open >= self.behind();
        if is_long {
            self.silence(open - least, self.direction.unwrap_or(Direction::Forward));
        }
        is_long
    }

    /// Closes the open period at `now`, or as soon after it as the driver allows. The axis stands.
    pub(super) fn close(&mut self, now: Ticks) {
        let least = if self.open_step == 0 {
            self.least
        } else {
            self.hold
        };
        let open = self.open_at(now).max(0).cast_unsigned();
        if self.open_step != 0 || open > 0 {
            let direction = self.direction.unwrap_or(Direction::Forward);
            self.silence(open.max(least), direction);
        }
    }

    /// Goes on with the run before, up to a pulse `last` ticks behind `begin`, if the periods of this chord are as long as those of the run
    /// but for an eighth, and the open one is no longer than that. Whether it has done so.
    #[inline]
    pub(super) fn goes_on(
        &mut self,
        begin: Ticks,
        (count, last): (u32, u32),
        sign: i32,
        speeding_up: bool,
    ) -> bool {
        let open = self.open_at(begin).cast_unsigned();
        let mut span = open.wrapping_add(last);
        let Some(mut base) = span.checked_div(count) else {
            return false;
        };
        let eighth = self.period >> 3;
        let is_alike = base.wrapping_add(eighth).wrapping_sub(self.period) <= eighth << 1
            && open <= base.wrapping_add(eighth)
            && base < self.time_slice
            && self.open_step == sign;
        if !is_alike {
            return false;
        }
        if base < self.shortest {
            // At the driver's highest rate it may be a tick more.
            base = self.shortest;
            let fastest = base.wrapping_mul(count);
            if span.wrapping_add(SHORTEST_RECORD) < fastest {
                return false;
            }
            span = fastest;
        }
        self.steps = self
            .steps
            .wrapping_add(count.cast_signed().wrapping_mul(sign));
        let direction = if sign < 0 {
            Direction::Reverse
        } else {
            Direction::Forward
        };
        if count < base / ROUGH {
            let period = (span + (count >> 1)).checked_div(count).unwrap_or(base);
            self.make(period, count, direction);
        } else {
            self.space((count, base), span, speeding_up, direction);
        }
        true
    }

    /// Makes the pulses of a chord that takes `length` ticks from `begin` on; as many of them as fit in it.
    #[inline(never)]
    pub(super) fn run(&mut self, begin: Ticks, length: u32, pulses: &Pulses) {
        let direction = pulses.direction;
        let shortest = self.shortest;
        let open = self.open_at(begin);
        // Both are less than a time slice.
        let (first, last) = (pulses.first.cast_signed(), pulses.last.cast_signed());
        let length = length.cast_signed();
        let joins = pulses.count >= MANY
            && self.open_step == direction.sign()
            && is_alike(open + first, last - first, pulses.count);
        let (start, gaps) = if joins {
            (-open, pulses.count)
        } else {
            let first = first.max(self.wait(direction) - open);
            if first > length {
                return;
            }
            (first, pulses.count.saturating_sub(1))
        };
        let mut gaps = gaps.min(LONGEST_RUN);
        let mut span = (last - start).max(0).cast_unsigned();
        if span < gaps.saturating_mul(shortest) {
            // Too dense for the driver: at its highest rate, and what does not fit is due in the next chord.
            let left = (length - start).max(0).cast_unsigned();
            gaps = gaps.min(left.checked_div(shortest).unwrap_or(0));
            span = gaps * shortest;
        }
        let made = if joins {
            gaps
        } else {
            self.open_pulse((open + start).cast_unsigned(), direction);
            gaps + 1
        };
        if let Some(base) = span.checked_div(gaps) {
            self.space((gaps, base), span, pulses.speeding_up, direction);
        }
        let steps = made.cast_signed() * direction.sign();
        self.steps = self.steps.wrapping_add(steps);
    }

    /// So many periods in so many ticks, each beginning with a pulse, and how long each is, rounded down. What remains when the ticks are shared out
    /// is one tick more in some periods. A run would be too short for a record only at the highest rates; its few ticks are left to the open period.
    fn space(
        &mut self,
        (gaps, base): (u32, u32),
        span: u32,
        speeding_up: bool,
        direction: Direction,
    ) {
        let longer = span - base * gaps;
        let long = (base + 1, longer);
        let short = (base, gaps - longer);
        let (more, fewer) = if long.1 > short.1 {
            (long, short)
        } else {
            (short, long)
        };
        if base * fewer.1 < SHORTEST_RECORD {
            // All alike. One gap alone may have to be stretched to be a record.
            let mut period = more.0;
            if period * gaps < SHORTEST_RECORD {
                period = SHORTEST_RECORD.div_ceil(gaps.max(1));
            }
            self.make(period, gaps, direction);
            return;
        }
        // The pulses of two runs are off by more · fewer / gaps ticks at most. Where that is too much, the fewer periods stand in the middle of
        // the others: so pulses are ahead in one half and behind in the other, and half as far.
        let enough = if base < CROWDED {
            gaps * (CROWDED - (CROWDED >> 3))
        } else {
            // A sixteenth of a step.
            span >> 4
        };
        let outer = more.1 >> 1;
        let is_crowded = more.1.saturating_mul(fewer.1) > enough;
        let (first, second) = if is_crowded && base * outer >= SHORTEST_RECORD {
            self.keep(self.pulses(more.0, outer, direction));
            (fewer, (more.0, more.1 - outer))
        } else if speeding_up {
            (long, short)
        } else {
            (short, long)
        };
        self.keep(self.pulses(first.0, first.1, direction));
        self.keep(self.pulses(second.0, second.1, direction));
        self.period = base;
        self.recorded = self.recorded.wrapping_add(span.into());
    }

    /// Ticks from the end of the records to the earliest pulse in `direction`.
    const fn wait(&self, direction: Direction) -> i32 {
        let is_turning = match self.direction {
            Some(before) => before.sign() != direction.sign(),
            None => true,
        };
        let wait = match (is_turning, self.open_step != 0) {
            (false, _) => self.least,
            (true, false) => self.setup,
            (true, true) => self.hold + self.setup,
        };
        wait.cast_signed()
    }

    /// Ends the open period, `ticks` long, where a pulse begins, at or after [`Train::wait`]; the period after the pulse is open then.
    fn open_pulse(&mut self, mut ticks: u32, direction: Direction) {
        let has_pulse = self.open_step != 0;
        let is_turning = self.direction != Some(direction);
        if is_turning && has_pulse {
            let before = self.direction.unwrap_or(direction);
            self.silence(self.hold, before);
            ticks = ticks.saturating_sub(self.hold);
        }
        self.silence(ticks, direction);
        if has_pulse && !is_turning && ticks <= self.time_slice {
            self.period = ticks;
        }
        self.direction = Some(direction);
        self.open_step = direction.sign();
    }

    /// Records for `ticks` of the open period: its pulse if it has one, then silence. None is longer than a time slice or shorter than
    /// the driver's shortest period.
    fn silence(&mut self, mut ticks: u32, direction: Direction) {
        let mut iterations = Iterations::at_most(low::word(MAX_RECORDS));
        while ticks > 0 {
            iterations.count();
            let part = if ticks > self.time_slice {
                self.time_slice.min(ticks.saturating_sub(self.least))
            } else {
                ticks
            };
            let width = if self.open_step == 0 { 0 } else { self.width };
            self.keep(Record {
                period: part,
                repeat: 1,
                width,
                direction,
            });
            self.recorded = self.recorded.wrapping_add(part.into());
            self.open_step = 0;
            ticks -= part;
        }
        self.open_step = 0;
        self.period = 0;
    }

    /// A run of so many periods.
    #[inline]
    fn make(&mut self, period: u32, count: u32, direction: Direction) {
        self.keep(self.pulses(period, count, direction));
        self.period = period;
        self.recorded = self.recorded.wrapping_add((period * count).into());
    }

    #[inline]
    const fn pulses(&self, period: u32, count: u32, direction: Direction) -> Record {
        Record {
            period,
            // No run is longer than what 16 bits count.
            repeat: low::u16(count),
            width: self.width,
            direction,
        }
    }

    #[inline]
    fn keep(&mut self, record: Record) {
        let place = self.made.get_mut(usize::from(self.count));
        debug_assert!(place.is_some(), "a chord makes more records than it can");
        match place {
            Some(place) => {
                *place = record;
                self.count += 1;
            }
            None => self.is_overrun = true,
        }
    }
}

/// Whether the open period, up to the first of so many pulses, is as long as those between them, which take `span` ticks, but for an
/// eighth: it can be one of them then, and needs no record of its own.
fn is_alike(open: i32, span: i32, pulses: u32) -> bool {
    let (Ok(open), Ok(span)) = (u32::try_from(open), u32::try_from(span)) else {
        return false;
    };
    let all = u64::from(open) * u64::from(pulses - 1);
    all.abs_diff(span.into()) <= u64::from(span >> 3)
}

#[cfg(test)]
mod tests;

//! From records to slots: what a timer of 16 bits with a repetition counter of 8 bits can do at a time.

use super::ring::{Slot, fill};
use crate::{Direction, Record};

/// Longest period of a timer of 16 bits, in ticks. One less than it could be, so that a compare value above the reload value
/// exists: that keeps the direction high.
pub(super) const LONGEST_PERIOD: u32 = 0xFFFF;

/// Most periods of a run: the repetition counter has 8 bits.
pub(super) const MOST_PERIODS: u32 = 256;

/// Longest run of a record, in ticks. A slot can be written until the run before it begins, so short runs leave a late processor
/// more time. (What is silent behind the last record takes longer.)
pub(super) const LONGEST_RUN: u32 = 1 << 14;

/// What a DMA burst writes into ARR, RCR, CCR1 and CCR2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Words(pub(super) [u32; 4]);

impl Words {
    /// `repeat` (1 ..= 256) periods of `period` (1 ..= 65535) ticks; the registers hold one less.
    #[inline]
    pub(super) const fn run(period: u32, repeat: u32, width: u32, direction: u32) -> Self {
        Self([
            period.wrapping_sub(1),
            repeat.wrapping_sub(1),
            width,
            direction,
        ])
    }

    /// As long as a run can be, without a pulse.
    pub(super) const fn silent(direction: u32) -> Self {
        Self::run(LONGEST_PERIOD, MOST_PERIODS, 0, direction)
    }

    /// The level of the direction signal.
    pub(super) const fn level(self) -> u32 {
        let [.., level] = self.0;
        level
    }

    /// How long the run takes.
    pub(super) const fn ticks(self) -> u32 {
        let [reload, repetitions, ..] = self.0;
        reload
            .wrapping_add(1)
            .wrapping_mul(repetitions.wrapping_add(1))
    }
}

/// The level of the direction signal as a compare value of channel 2.
pub(super) const fn level(direction: Direction) -> u32 {
    match direction {
        Direction::Forward => LONGEST_PERIOD,
        Direction::Reverse => 0,
    }
}

/// The direction of that level.
pub(super) const fn direction_of(level: u32) -> Direction {
    if level == 0 {
        Direction::Reverse
    } else {
        Direction::Forward
    }
}

/// A record in equal runs: a short one at the end might be over before the burst behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runs {
    /// The periods of each, and how many have one more.
    repeat: u32,
    more: u32,
}

impl Runs {
    /// Of so many periods; `None` if one is longer than a run may be.
    #[inline]
    pub(super) fn of(period: u32, periods: u32) -> Option<Self> {
        if period > LONGEST_RUN {
            return None;
        }
        // The product fits: a period has 15 bits, and there are 16 bits of them.
        let run = period.wrapping_mul(periods);
        if run <= LONGEST_RUN && periods <= MOST_PERIODS {
            return Some(Self {
                repeat: periods,
                more: 0,
            });
        }
        // Never more runs than periods.
        let count = run
            .div_ceil(LONGEST_RUN)
            .max(periods.div_ceil(MOST_PERIODS));
        let repeat = periods.checked_div(count).unwrap_or(0);
        let more = periods.wrapping_sub(repeat.wrapping_mul(count));
        Some(Self { repeat, more })
    }

    /// The periods of the next run.
    #[inline]
    pub(super) fn next(&mut self) -> u32 {
        if self.more == 0 {
            return self.repeat;
        }
        self.more = self.more.wrapping_sub(1);
        self.repeat.wrapping_add(1)
    }
}

/// Where slots are written, one behind the other.
#[derive(Debug)]
pub(super) struct Place<'a> {
    /// Those that may be written, and how many have been.
    slots: &'a [Slot],
    written: usize,
    /// The level of the direction signal in all of them.
    level: u32,
    /// Ticks of the last one written.
    pub(super) last: u32,
}

impl<'a> Place<'a> {
    pub(super) const fn new(slots: &'a [Slot], level: u32) -> Self {
        Self {
            slots,
            written: 0,
            level,
            last: 0,
        }
    }

    /// So many have been written.
    pub(super) const fn written(&self) -> usize {
        self.written
    }

    /// Writes a record, in equal runs; whether there was room for all of it.
    #[inline]
    pub(super) fn put(&mut self, record: &Record) -> bool {
        let (period, repeat) = (record.period, u32::from(record.repeat));
        let width = u32::from(record.width);
        // Silence is one period.
        if period > LONGEST_RUN || (width == 0 && repeat != 1) {
            return self.put_long(record);
        }
        // The product fits: a period has 15 bits, and there are 16 bits of them.
        let ticks = period.wrapping_mul(repeat);
        let mut last = repeat;
        if ticks > LONGEST_RUN || repeat > MOST_PERIODS {
            if ticks > 2 * LONGEST_RUN || repeat > 2 * MOST_PERIODS {
                return self.put_runs(period, repeat, width);
            }
            // Half of them first. Each run has a period at least, as none is longer than a run.
            let first = repeat >> 1;
            if !self.has_room(2) {
                return false;
            }
            self.write(Words::run(period, first, width, self.level));
            last = repeat.wrapping_sub(first);
        }
        let Some(slot) = self.slots.get(self.written) else {
            return false;
        };
        self.written = self.written.wrapping_add(1);
        self.last = period.wrapping_mul(last);
        fill(slot, Words::run(period, last, width, self.level));
        true
    }

    /// The same for pulses that take more.
    #[inline(never)]
    fn put_runs(&mut self, period: u32, repeat: u32, width: u32) -> bool {
        // Never more runs than periods.
        let mut runs = period
            .wrapping_mul(repeat)
            .div_ceil(LONGEST_RUN)
            .max(repeat.div_ceil(MOST_PERIODS));
        if !self.has_room(runs) {
            return false;
        }
        let (slots, level, mut place, mut left) = (self.slots, self.level, self.written, repeat);
        let mut run = 0;
        while let Some(share) = left.checked_div(runs)
            && let Some(slot) = slots.get(place)
        {
            fill(slot, Words::run(period, share, width, level));
            left = left.wrapping_sub(share);
            runs = runs.wrapping_sub(1);
            place = place.wrapping_add(1);
            run = share;
        }
        self.written = place;
        self.last = period.wrapping_mul(run);
        true
    }

    fn has_room(&self, number: u32) -> bool {
        number as usize <= self.slots.len().wrapping_sub(self.written)
    }

    #[inline]
    fn write(&mut self, words: Words) {
        if let Some(slot) = self.slots.get(self.written) {
            fill(slot, words);
        }
        self.written = self.written.wrapping_add(1);
    }

    /// The same for periods that take several slots each.
    #[inline(never)]
    fn put_long(&mut self, record: &Record) -> bool {
        let (period, repeat) = (record.period, u32::from(record.repeat));
        let (width, level) = (u32::from(record.width), self.level);
        // Silence is one period.
        let (period, repeat) = if width == 0 {
            (period.saturating_mul(repeat), 1)
        } else {
            (period, repeat)
        };
        let parts = period.div_ceil(LONGEST_RUN);
        if width >= LONGEST_RUN / 2 || !self.has_room(parts.saturating_mul(repeat)) {
            return false;
        }
        // Parts of equal length: none is short, and the pulse has room in the first.
        let part = period.checked_div(parts).unwrap_or(0);
        let rest = part.wrapping_add(period.wrapping_sub(part.wrapping_mul(parts)));
        for _ in 0..repeat {
            let mut width = width;
            for _ in 1..parts {
                self.write(Words::run(part, 1, width, level));
                width = 0;
            }
            self.write(Words::run(rest, 1, width, level));
        }
        self.last = rest;
        true
    }
}

/// What is left of a record on its way into slots. Ticks and pulses of its runs are those of the record, exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Remainder {
    period: u32,
    width: u32,
    direction: u32,
    /// Periods that have not begun.
    periods: u32,
    /// How they are shared out; `None` where a period is longer than a run.
    runs: Option<Runs>,
    /// Silence up to the end of the period under way.
    silence: u32,
}

impl Remainder {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        period: 0,
        width: 0,
        direction: 0,
        periods: 0,
        runs: None,
        silence: 0,
    };

    /// All of a record.
    #[inline]
    pub(super) fn of(record: &Record) -> Self {
        let (mut period, mut periods) = (record.period, u32::from(record.repeat));
        // Silence is one period if it can be.
        if record.width == 0
            && let Ok(ticks) = u32::try_from(record.ticks())
        {
            (period, periods) = (ticks, 1);
        }
        Self {
            period,
            width: record.width.into(),
            direction: level(record.direction),
            periods,
            runs: Runs::of(period, periods),
            silence: 0,
        }
    }

    /// Whether nothing is left.
    #[inline]
    pub(super) const fn is_empty(&self) -> bool {
        self.silence | self.periods == 0
    }

    /// How long it takes, modulo 2³².
    #[inline]
    pub(super) const fn ticks(&self) -> u32 {
        self.period
            .wrapping_mul(self.periods)
            .wrapping_add(self.silence)
    }

    /// The level of the direction signal.
    #[inline]
    pub(super) const fn direction(&self) -> u32 {
        self.direction
    }

    /// The next run. There must be something left.
    #[inline]
    pub(super) fn next(&mut self) -> Words {
        let Some(runs) = &mut self.runs else {
            return self.part_of_period();
        };
        let repeat = runs.next();
        self.periods = self.periods.saturating_sub(repeat);
        Words::run(self.period, repeat, self.width, self.direction)
    }

    /// Of a period that is longer than a run: a pulse, and as much of its period as the longest run holds; or some of the silence behind it.
    #[cold]
    #[inline(never)]
    fn part_of_period(&mut self) -> Words {
        if self.silence > 0 {
            return self.rest();
        }
        self.periods = self.periods.saturating_sub(1);
        // Neither part is short.
        let head = if self.width < LONGEST_RUN / 2 {
            (self.period / 2).min(LONGEST_RUN)
        } else if self.period <= LONGEST_PERIOD {
            self.period
        } else {
            LONGEST_PERIOD / 2 + 1
        };
        self.silence = self.period.saturating_sub(head);
        Words::run(head, 1, self.width, self.direction)
    }

    /// A run of silence.
    fn rest(&mut self) -> Words {
        let ticks = if self.silence <= LONGEST_RUN {
            self.silence
        } else {
            // Neither part is short.
            LONGEST_RUN.min(self.silence / 2)
        };
        self.silence = self.silence.saturating_sub(ticks);
        Words::run(ticks, 1, 0, self.direction)
    }
}

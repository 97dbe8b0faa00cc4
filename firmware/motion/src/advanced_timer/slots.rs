//! From records to slots: what a timer of 16 bits with a repetition counter of 8 bits can do at a time.

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

/// Whether a record is one slot.
#[inline]
pub(super) fn is_slot(record: &Record) -> bool {
    let repeat = u32::from(record.repeat);
    // The product fits where the period does.
    record.period <= LONGEST_RUN
        && repeat <= MOST_PERIODS
        && record.period.wrapping_mul(repeat) <= LONGEST_RUN
}

/// What is left of a record on its way into slots. Ticks and pulses of its runs are those of the record, exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Remainder {
    period: u32,
    width: u32,
    direction: u32,
    /// Periods that have not begun.
    periods: u32,
    /// Periods of a run, and how many runs have one more; 0 where a period is longer than a run.
    repeat: u32,
    more: u32,
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
        repeat: 0,
        more: 0,
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
        let (repeat, more) = if period > LONGEST_RUN {
            (0, 0)
        } else {
            // In equal parts: a short one at the end might be over before the burst behind it. The product fits: a period has 15
            // bits, and there are 16 bits of them.
            let run = period.wrapping_mul(periods);
            let parts = (run / LONGEST_RUN).max(periods / MOST_PERIODS);
            let parts = parts.wrapping_add(1);
            let repeat = periods.checked_div(parts).unwrap_or(0);
            (repeat, periods.wrapping_sub(repeat.wrapping_mul(parts)))
        };
        Self {
            period,
            width: record.width.into(),
            direction: level(record.direction),
            periods,
            repeat,
            more,
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
        if self.period > LONGEST_RUN {
            return self.part_of_period();
        }
        let repeat = if self.more == 0 {
            self.repeat
        } else {
            self.more = self.more.wrapping_sub(1);
            self.repeat.wrapping_add(1)
        };
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
